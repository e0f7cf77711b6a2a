use crate::cloth::{ClothSpec, Draft, System};
use crate::geometry::Vec3;

/// A rotation or reflection that maps the axes of the cloth to themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symmetry {
    /// Whether x and y are exchanged first.
    pub swap: bool,
    /// Which of x, y and z are then reversed.
    pub flip: [bool; 3],
}

impl Symmetry {
    /// The identity.
    pub const IDENTITY: Self = Self {
        swap: false,
        flip: [false; 3],
    };

    /// All symmetries, the identity first.
    fn all() -> impl Iterator<Item = Self> {
        (0..16u8).map(|bits| Self {
            swap: bits & 8 != 0,
            flip: [0, 1, 2].map(|axis| bits >> axis & 1 == 1),
        })
    }

    /// Image of a vector.
    pub fn apply(&self, d: &Vec3) -> Vec3 {
        let (x, y) = if self.swap { (d.y, d.x) } else { (d.x, d.y) };
        let signed = |flip: bool, value: f64| if flip { -value } else { value };
        Vec3::new(
            signed(self.flip[0], x),
            signed(self.flip[1], y),
            signed(self.flip[2], d.z),
        )
    }

    /// Whether it is a rotation, which preserves handedness; a reflection reverses it.
    pub fn keeps_hand(&self) -> bool {
        let reversed = self.flip.iter().filter(|flip| **flip).count() + usize::from(self.swap);
        reversed.is_multiple_of(2)
    }

    /// Whether it maps the endless weave of a draft to itself, apart from a shift in the cloth's plane. `side` is a
    /// multiple of both repeats.
    fn keeps(&self, draft: &Draft, side: usize) -> bool {
        // Wefts are numbered along x, warps along y.
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

/// Largest repeat, in yarns, whose symmetries are searched; the time grows with the sixth power of it at worst.
const LARGEST_REPEAT: usize = 24;

/// The group of rotations and reflections under which a cloth's scattering is invariant, the identity first. Only the
/// identity if yarns vary or the repeat is large.
///
/// Yarns are assumed to equal their mirror images; otherwise only rotations remain ([`Symmetry::keeps_hand`]).
/// `same_media`: warp and weft have the same medium. `same_sides`: the cloth has neither a backing nor anything on it
/// that distinguishes its sides.
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
        // The four rotations in the plane, and the four that exchange front and back.
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
        // A rotation by 180° leaves a twill invariant, reflections do not; its back has the wefts on top.
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
        // A satin's wefts float on its back as its warps do on its face; rotations by 90° do not reverse its move.
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
