use super::layout::Layout;
use super::tube::{Local, SurfaceFrame, Tube, floor};
use crate::cloth::{ClothError, ClothSpec, System, YarnId};
use crate::geometry::{Frame, Vec3};

/// Limit of the number of cells between crossings after which a ray counts as escaped: a ray in the cloth's plane may
/// run forever through a channel of the weave. At 89.99° to the normal a ray crosses only a few thousand.
const MAX_CELLS: usize = 1 << 20;

/// Overlap, as a fraction of the cell's size, of the ranges searched in neighbouring cells. Covers rounding.
const SEAM: f64 = 1e-12;

/// Intersection of a ray in the air with a yarn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position on the smooth surface, mm.
    pub position: Vec3,
    pub distance_mm: f64,
    /// Local frame: axis along the centre line's tangent, normal outward.
    pub frame: Frame,
    pub yarn: YarnId,
}

/// An endless woven cloth of smooth tubes; intersects rays inside the yarns and in the air between them.
#[derive(Clone, Debug)]
pub struct Cloth {
    warp: Parallel,
    weft: Parallel,
    cell_mm: [f64; 2],
    top_mm: f64,
}

/// The yarns of one system.
#[derive(Clone, Debug)]
struct Parallel {
    tubes: Vec<Tube>,
    /// Positions of the yarns of one repeat across their direction, mm, ascending.
    places: Vec<f64>,
    /// Middle of the gap from each yarn to the next, mm.
    gaps: Vec<f64>,
    repeat: f64,
    inverse_repeat: f64,
}

/// A yarn of the endless cloth: its index in the repeat, and the cell across.
#[derive(Clone, Copy)]
struct Counted {
    index: usize,
    cell: i64,
}

impl Parallel {
    fn new(tubes: Vec<Tube>, places: Vec<f64>, repeat: f64) -> Self {
        let n = places.len();
        let gaps = (0..n)
            .map(|j| {
                let next = if j + 1 < n { places[j + 1] } else { places[0] + repeat };
                0.5 * (places[j] + tubes[j].half_width + next - tubes[(j + 1) % n].half_width)
            })
            .collect();
        Self {
            tubes,
            places,
            gaps,
            repeat,
            inverse_repeat: 1.0 / repeat,
        }
    }

    #[inline]
    fn place(&self, yarn: Counted) -> f64 {
        self.places[yarn.index] + self.repeat * yarn.cell as f64
    }

    #[inline]
    fn next(&self, Counted { index, cell }: Counted) -> Counted {
        if index + 1 == self.places.len() {
            Counted {
                index: 0,
                cell: cell + 1,
            }
        } else {
            Counted { index: index + 1, cell }
        }
    }

    #[inline]
    fn previous(&self, Counted { index, cell }: Counted) -> Counted {
        if index == 0 {
            Counted {
                index: self.places.len() - 1,
                cell: cell - 1,
            }
        } else {
            Counted { index: index - 1, cell }
        }
    }

    /// The last yarn at or before `across`.
    fn before(&self, across: f64) -> Counted {
        let repeats = (across / self.repeat).floor();
        let mut yarn = Counted {
            index: 0,
            cell: repeats as i64,
        };
        while self.place(yarn) > across {
            yarn = self.previous(yarn);
        }
        while self.place(self.next(yarn)) <= across {
            yarn = self.next(yarn);
        }
        yarn
    }

    /// The tube around `across` and the distance from its plane.
    #[inline]
    fn nearest(&self, across: f64) -> (&Tube, f64) {
        let n = self.places.len();
        let repeats = across * self.inverse_repeat;
        let whole = floor(repeats);
        let mut across = across - whole * self.repeat;
        let mut k = (((repeats - whole) * n as f64) as usize).min(n - 1);
        // The middle of the last gap may lie before or beyond the end of the repeat.
        if across > self.gaps[n - 1] {
            across -= self.repeat;
            k = 0;
        } else if across < self.gaps[n - 1] - self.repeat {
            across += self.repeat;
            k = n - 1;
        }
        while k > 0 && across < self.gaps[k - 1] {
            k -= 1;
        }
        while k + 1 < n && across > self.gaps[k] {
            k += 1;
        }
        (&self.tubes[k], across - self.places[k])
    }
}

/// A world vector in a yarn's coordinates, and back: warps run along x, wefts along y.
#[inline]
fn local(system: System, [x, y, z]: [f64; 3]) -> Local {
    match system {
        System::Warp => Local { x, u: y, z },
        System::Weft => Local { x: y, u: x, z },
    }
}

#[inline]
fn world(system: System, Local { x, u, z }: Local) -> [f64; 3] {
    match system {
        System::Warp => [x, u, z],
        System::Weft => [u, x, z],
    }
}

impl Cloth {
    /// Builds the tubes of a cloth.
    ///
    /// # Errors
    /// [`ClothError`] for a value out of range, too many yarns, a jammed weave, and yarns that overlap or whose radius
    /// of curvature is below their half height.
    pub fn new(spec: &ClothSpec) -> Result<Self, ClothError> {
        let layout = Layout::new(spec)?;
        let parallel = |system, repeat| {
            let yarns = layout.yarns(system);
            let places = yarns.iter().map(|yarn| yarn.place_mm).collect();
            Parallel::new(yarns.iter().map(Tube::new).collect(), places, repeat)
        };
        Ok(Self {
            warp: parallel(System::Warp, layout.cell_mm[1]),
            weft: parallel(System::Weft, layout.cell_mm[0]),
            cell_mm: layout.cell_mm,
            top_mm: layout.top_mm(),
        })
    }

    /// Size of the unit cell along x and y, mm.
    pub fn cell_mm(&self) -> [f64; 2] {
        self.cell_mm
    }

    /// Height of the highest points of the yarns above the middle plane, mm; the lowest are as far below it.
    pub fn top_mm(&self) -> f64 {
        self.top_mm
    }

    #[inline]
    fn parallel(&self, system: System) -> &Parallel {
        match system {
            System::Warp => &self.warp,
            System::Weft => &self.weft,
        }
    }

    /// The tube of a system around a point, and the point in its coordinates.
    #[inline]
    fn tube(&self, system: System, position: [f64; 3]) -> (&Tube, Local) {
        let at = local(system, position);
        let (tube, u) = self.parallel(system).nearest(at.u);
        (tube, Local { u, ..at })
    }

    /// Distance in mm along a unit direction from a point in a yarn of `system`, or on its surface with the direction
    /// inward, to the yarn's surface. If the surface is not nearer than `limit_mm`, any value of at least `limit_mm`
    /// may be returned. Infinite if the ray has not left after some hundred diameters of yarn.
    pub fn inside_distance(&self, system: System, position: [f64; 3], direction: [f64; 3], limit_mm: f64) -> f64 {
        let (tube, from) = self.tube(system, position);
        tube.inside_distance(from, local(system, direction), limit_mm)
    }

    /// Point of a yarn's surface nearest to a position that is on the surface to rounding, and outward unit normal.
    pub fn surface(&self, system: System, position: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let (tube, near) = self.tube(system, position);
        let SurfaceFrame { to_surface, normal, .. } = tube.surface_frame(near);
        let shift = world(system, to_surface);
        (std::array::from_fn(|k| position[k] + shift[k]), world(system, normal))
    }

    /// Frame of the yarn of `system` at a position that is on its surface to rounding.
    pub fn frame(&self, system: System, position: [f64; 3]) -> Frame {
        let (tube, near) = self.tube(system, position);
        frame(system, &tube.surface_frame(near))
    }

    /// Point of the section through a surface point at which the outward normal is `normal`, a unit vector
    /// perpendicular to the yarn's axis there.
    pub fn beside(&self, system: System, position: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
        let (tube, near) = self.tube(system, position);
        let shift = world(system, tube.around(near, local(system, normal)));
        std::array::from_fn(|k| position[k] + shift[k])
    }

    /// Position along the yarn of `system` of the section through a surface point, mm, measured in the cloth's plane:
    /// from 0 to below the length of one repeat.
    pub fn place_mm(&self, system: System, position: [f64; 3]) -> f64 {
        let (tube, near) = self.tube(system, position);
        tube.foot(near)[0].rem_euclid(self.repeat_mm(system))
    }

    /// Surface area of a yarn at a point per length along the yarn (in the cloth's plane) and per radian of rotation of
    /// the normal within the section, mm.
    pub fn surface_mm(&self, system: System, position: [f64; 3]) -> f64 {
        let (tube, near) = self.tube(system, position);
        tube.surface_per_place(near)
    }

    /// Period of a yarn of `system` along itself, mm.
    pub fn repeat_mm(&self, system: System) -> f64 {
        match system {
            System::Warp => self.cell_mm[0],
            System::Weft => self.cell_mm[1],
        }
    }

    /// Number of yarns of `system` in one cell.
    pub fn yarns(&self, system: System) -> usize {
        self.parallel(system).places.len()
    }

    /// First intersection of a ray that starts in the air, or on a yarn's surface going outward. `direction` is a unit
    /// vector. A yarn in contact with the one just left is met at distance 0.
    pub fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let (distance, yarn) = self.search(origin, direction, None)?;
        Some(self.hit(origin + direction * distance, distance, yarn))
    }

    /// Whether any yarn except `owner` blocks a ray from the owner's surface; the ray may pass through the owner. f*
    /// includes the yarn's shadow on itself, so the owner of the shaded point is skipped along its whole length.
    pub fn shadowed(&self, origin: Vec3, direction: Vec3, owner: YarnId) -> bool {
        self.search(origin, direction, Some(owner)).is_some()
    }

    /// Distance and identity of the first yarn on a ray, except `skipped`.
    fn search(&self, origin: Vec3, direction: Vec3, skipped: Option<YarnId>) -> Option<(f64, YarnId)> {
        let (o, d) = (origin, direction);
        let (mut entry, mut exit) = (0.0f64, f64::INFINITY);
        clip([-self.top_mm - o.z, self.top_mm - o.z], d.z, &mut entry, &mut exit);
        if entry > exit {
            return None;
        }
        // Cells between the planes of neighbouring yarns: each contains quarters of two warps and of two wefts, each
        // along one piece of its centre line.
        let start = o + d * entry;
        let mut number = [self.weft.before(start.x), self.warp.before(start.y)];
        let seam = SEAM * (self.cell_mm[0] + self.cell_mm[1]);
        for _ in 0..MAX_CELLS {
            let beside = [
                [number[0], self.weft.next(number[0])],
                [number[1], self.warp.next(number[1])],
            ];
            let walls = [
                beside[0].map(|yarn| self.weft.place(yarn)),
                beside[1].map(|yarn| self.warp.place(yarn)),
            ];
            let leave = [0, 1].map(|k| {
                if d[k] == 0.0 {
                    f64::INFINITY
                } else {
                    (walls[k][usize::from(d[k] > 0.0)] - o[k]) / d[k]
                }
            });
            let axis = usize::from(leave[1] < leave[0]);
            let end = leave[axis].min(exit);
            let mut nearest = end + seam;
            let mut found = None;
            for (system, along, across) in [(System::Warp, 0, 1), (System::Weft, 1, 0)] {
                let parallel = self.parallel(system);
                let piece = number[along].index;
                let direction = local(system, [d.x, d.y, d.z]);
                for side in 0..2 {
                    let Counted { index, cell } = beside[across][side];
                    let yarn = YarnId {
                        system,
                        index: index as u32,
                        lateral: cell,
                    };
                    if skipped == Some(yarn) {
                        continue;
                    }
                    let tube = &parallel.tubes[index];
                    let from = Local {
                        x: o[along] - walls[along][0],
                        u: o[across] - walls[across][side],
                        z: o.z,
                    };
                    let [mut first, mut last] = [entry - seam, nearest];
                    first = first.max(0.0);
                    let half = tube.half_width;
                    clip([-half - from.u, half - from.u], direction.u, &mut first, &mut last);
                    let [low, high] = tube.heights(piece);
                    clip([low - from.z, high - from.z], direction.z, &mut first, &mut last);
                    if first <= last
                        && let Some(distance) = tube.entry(piece, from, direction, [first, last])
                    {
                        nearest = distance;
                        found = Some((distance, yarn));
                    }
                }
            }
            if found.is_some() {
                return found;
            }
            if leave[axis] >= exit {
                return None;
            }
            entry = end;
            let crossed = if axis == 0 { &self.weft } else { &self.warp };
            number[axis] = if d[axis] > 0.0 {
                beside[axis][1]
            } else {
                crossed.previous(number[axis])
            };
        }
        None
    }

    fn hit(&self, near: Vec3, distance_mm: f64, yarn: YarnId) -> Hit {
        let (tube, at) = self.tube(yarn.system, near.into());
        let surface = tube.surface_frame(at);
        Hit {
            position: near + Vec3::from(world(yarn.system, surface.to_surface)),
            distance_mm,
            frame: frame(yarn.system, &surface),
            yarn,
        }
    }
}

fn frame(system: System, surface: &SurfaceFrame) -> Frame {
    Frame::from_axis_normal(
        world(system, surface.tangent).into(),
        world(system, surface.normal).into(),
    )
}

/// Restricts [`first`, `last`] to the distances at which a coordinate that starts at 0 and changes at `rate` is within
/// `bounds`.
#[inline]
fn clip(bounds: [f64; 2], rate: f64, first: &mut f64, last: &mut f64) {
    if rate == 0.0 {
        if bounds[0] > 0.0 || bounds[1] < 0.0 {
            *last = f64::NEG_INFINITY;
        }
        return;
    }
    let inverse = 1.0 / rate;
    let [a, b] = bounds.map(|bound| bound * inverse);
    *first = first.max(a.min(b));
    *last = last.min(a.max(b));
}
