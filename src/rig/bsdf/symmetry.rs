use crate::cloth::{ClothSpec, Draft, System};
use crate::geometry::Vec3;

/// A turn or reflection that takes the axes of the cloth to themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symmetry {
    /// x and y are exchanged first.
    pub swap: bool,
    /// Then these of x, y and z are reversed.
    pub flip: [bool; 3],
}

impl Symmetry {
    pub const IDENTITY: Self = Self {
        swap: false,
        flip: [false; 3],
    };

    /// Every one, the identity first.
    fn all() -> impl Iterator<Item = Self> {
        (0..16u8).map(|bits| Self {
            swap: bits & 8 != 0,
            flip: [0, 1, 2].map(|axis| bits >> axis & 1 == 1),
        })
    }

    pub fn apply(&self, d: &Vec3) -> Vec3 {
        let (x, y) = if self.swap { (d.y, d.x) } else { (d.x, d.y) };
        let signed = |flip: bool, value: f64| if flip { -value } else { value };
        Vec3::new(
            signed(self.flip[0], x),
            signed(self.flip[1], y),
            signed(self.flip[2], d.z),
        )
    }

    /// Whether it is a turn, which leaves a screw what it is; a reflection makes a left-handed one of a right-handed.
    pub fn keeps_hand(&self) -> bool {
        let reversed = self.flip.iter().filter(|flip| **flip).count() + usize::from(self.swap);
        reversed.is_multiple_of(2)
    }

    /// Whether it takes the endless weave of a draft to itself, but for a shift in the cloth's plane. `side` is a multiple
    /// of both repeats.
    fn keeps(&self, draft: &Draft, side: usize) -> bool {
        // Wefts stand along x, warps along y.
        let image = |weft: usize, warp: usize| {
            let (weft, warp) = if self.swap { (warp, weft) } else { (weft, warp) };
            let reversed = |flip: bool, k: usize| if flip { (side - k) % side } else { k };
            (reversed(self.flip[0], weft), reversed(self.flip[1], warp))
        };
        let turned_over = self.swap != self.flip[2];
        let shifts = (0..side).flat_map(|a| (0..side).map(move |b| (a, b)));
        shifts.into_iter().any(|(a, b)| {
            (0..side * side).all(|k| {
                let (weft, warp) = (k / side, k % side);
                let (to_weft, to_warp) = image(weft, warp);
                draft.warp_on_top(to_weft + a, to_warp + b) == (draft.warp_on_top(weft, warp) != turned_over)
            })
        })
    }
}

/// Largest repeat, in yarns, whose symmetries are looked for; the search takes the sixth power of time at worst.
const LARGEST_REPEAT: usize = 24;

/// The turns and reflections that leave a cloth's scattering as it is, the identity first: a group. None but the identity
/// where yarns vary or the repeat is large.
///
/// Yarns count as their own mirror images; where they do not, those that keep the hand are left ([`Symmetry::keeps_hand`]).
/// `same_media`: warp and weft are of one medium. `same_sides`: nothing lies under the cloth or on it.
pub fn symmetries(spec: &ClothSpec, same_media: bool, same_sides: bool) -> Vec<Symmetry> {
    let draft = spec.weave.draft();
    let [wefts, warps] = [System::Weft, System::Warp].map(|system| draft.yarns(system));
    let side = wefts / gcd(wefts, warps) * warps;
    if spec.radius_variation > 0.0 || spec.spacing_variation > 0.0 || side > LARGEST_REPEAT {
        return vec![Symmetry::IDENTITY];
    }
    let same_systems = same_media
        && spec.warp_radius_mm == spec.weft_radius_mm
        && spec.warp_spacing_mm == spec.weft_spacing_mm
        && spec.warp_flattening == spec.weft_flattening;
    Symmetry::all()
        .filter(|symmetry| (same_systems || !symmetry.swap) && (same_sides || !symmetry.flip[2]))
        .filter(|symmetry| symmetry.keeps(&draft, side))
        .collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Weave;

    fn of(weave: Weave) -> Vec<Symmetry> {
        symmetries(
            &ClothSpec {
                weave,
                ..ClothSpec::default()
            },
            true,
            true,
        )
    }

    #[test]
    fn drafts_have_the_symmetries_one_sees() {
        assert_eq!(of(Weave::Plain).len(), 16);
        // The turns of a square and those that lay it on its face.
        assert_eq!(of(Weave::Plain).iter().filter(|s| s.keeps_hand()).count(), 8);
        let unequal = ClothSpec {
            warp_spacing_mm: 0.6,
            ..ClothSpec::default()
        };
        assert_eq!(symmetries(&unequal, true, true).len(), 8);
        assert_eq!(symmetries(&ClothSpec::default(), false, false).len(), 4);
        let varied = ClothSpec {
            radius_variation: 0.05,
            ..ClothSpec::default()
        };
        assert_eq!(symmetries(&varied, true, true), [Symmetry::IDENTITY]);
        // The half turn keeps a twill, its mirror images do not; its back has the wefts on top.
        let twill = of(Weave::Twill31);
        let half_turn = Symmetry {
            swap: false,
            flip: [true, true, false],
        };
        let mirror = Symmetry {
            swap: false,
            flip: [true, false, false],
        };
        let turned_over = Symmetry {
            swap: false,
            flip: [false, false, true],
        };
        assert!(twill.contains(&half_turn) && !twill.contains(&mirror) && !twill.contains(&turned_over));
        // A satin's wefts float on its back as its warps do on its face; quarter turns do not reverse its step.
        for weave in [Weave::Twill21, Weave::Twill31, Weave::Satin5] {
            let group = of(weave);
            for a in &group {
                for b in &group {
                    let d = Vec3::new(0.2, 0.3, 0.5);
                    let both = a.apply(&b.apply(&d));
                    assert!(group.iter().any(|c| c.apply(&d) == both));
                }
            }
        }
    }
}
