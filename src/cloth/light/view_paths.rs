use super::air::{Air, Caught, Survival};
use super::yarn_to_yarn::{Nothing, Parts, YarnToYarn};
use super::{Beam, YarnSurface};
use crate::cloth::{Cloth, Hit, System};
use crate::geometry::Vec3;
use crate::transport::{Purpose, Stream};
use std::ops::Range;

/// Paths traced from a view: vertices on yarns and on the backing that its camera rays reach, directly or through yarns
/// along specular paths. Light deflected by smooth interfaces on its way to the view is thus included without a
/// detector cone.
pub struct ViewPaths {
    /// Group of each vertex, ascending: [`Vertex::group`].
    groups: Vec<usize>,
    ends: Vec<Vertex>,
    /// Fraction of a vertex's light that reaches the view: vertex × wavelength (fastest).
    weights: Vec<f32>,
    wavelengths: usize,
    /// Number of camera rays, uniform over the unit cell in the cloth's plane.
    pub(super) rays: usize,
}

/// A point at which a camera ray meets a yarn or the backing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    place: usize,
    pub position: Vec3,
    /// Outward unit normal of the yarn.
    pub normal: Vec3,
    /// Unit vector along which light leaves the vertex to reach the view.
    pub towards: Vec3,
    /// Number of yarns between the vertex and the view.
    pub yarns: usize,
    /// 1/mm². On a yarn: 1 over the surface area of its segment per radian of the normal; on the backing: 1 over the
    /// area of its square.
    pub per_surface: f64,
}

impl Vertex {
    /// Group of the vertex: for each place, first the vertices that see the view directly, then the others.
    fn group(&self) -> usize {
        2 * self.place + usize::from(self.yarns > 0)
    }
}

/// A chosen vertex: the fraction of its light that reaches the view, and the number of vertices it represents.
pub(super) struct Seen<'a> {
    pub end: &'a Vertex,
    pub weights: &'a [f32],
    pub of_ends: f64,
}

/// Numbered segments of yarn and squares of the backing in the unit cell. Connections ignore the position of the entry
/// point within a segment or square.
#[derive(Clone, Debug)]
pub struct Segments {
    /// Number of segments of one yarn of warp and weft, and first index of each system and of the backing.
    pieces: [usize; 2],
    first: [usize; 3],
    squares: [usize; 2],
    cell_mm: [f64; 2],
}

impl Segments {
    /// `piece_mm` and `square_mm` are the largest lengths of a segment and of the side of a square, mm.
    pub fn new(cloth: &Cloth, piece_mm: f64, square_mm: f64) -> Self {
        let count = |length: f64, most: f64| (length / most).ceil() as usize;
        let cell_mm = cloth.cell_mm();
        let pieces = [System::Warp, System::Weft].map(|system| count(cloth.repeat_mm(system), piece_mm));
        let warps = cloth.yarns(System::Warp) * pieces[0];
        let wefts = cloth.yarns(System::Weft) * pieces[1];
        Self {
            pieces,
            first: [0, warps, warps + wefts],
            squares: cell_mm.map(|length| count(length, square_mm)),
            cell_mm,
        }
    }

    /// Index of the segment of yarn that light meets.
    pub(super) fn of_yarn(&self, cloth: &Cloth, hit: &Hit) -> usize {
        let system = hit.yarn.system;
        let k = system.index();
        let place_mm = cloth.place_mm(system, hit.position.into());
        let along = place_mm / cloth.repeat_mm(system) * self.pieces[k] as f64;
        let piece = (along as usize).min(self.pieces[k] - 1);
        self.first[k] + hit.yarn.index as usize * self.pieces[k] + piece
    }

    pub(super) fn of_backing(&self, position: &Vec3) -> usize {
        let [column, row] = [0, 1].map(|k| {
            let along = position[k].rem_euclid(self.cell_mm[k]) / self.cell_mm[k] * self.squares[k] as f64;
            (along as usize).min(self.squares[k] - 1)
        });
        self.first[2] + row * self.squares[0] + column
    }

    fn piece_mm(&self, cloth: &Cloth, system: System) -> f64 {
        cloth.repeat_mm(system) / self.pieces[system.index()] as f64
    }

    fn square_mm2(&self) -> f64 {
        self.cell_mm[0] * self.cell_mm[1] / (self.squares[0] * self.squares[1]) as f64
    }
}

impl ViewPaths {
    /// Traces the paths of one view above the cloth. `view` is the unit vector towards it; `number` separates the
    /// random streams of views.
    pub fn new(light: &YarnToYarn, segments: &Segments, view: &Vec3, number: usize, batch: usize, rays: usize) -> Self {
        let cloth = light.scene.cloth;
        let wavelengths = light.wavelengths();
        let stream = |k| Stream::open(light.scene.seed, Purpose::Sights, number, batch, k);
        let survival = Survival::LargestWeight;
        let mut air = Air::new(
            cloth,
            light.scene.backing,
            &Nothing,
            Caught::All,
            survival,
            stream(0),
            wavelengths,
        );
        let mut rng = stream(1);
        let surfaces = light.surfaces();
        // Light reflected by fibres is connected to the view at the point of reflection.
        let mirror = match light.scene.surface {
            YarnSurface::Smooth => YarnSurface::Smooth,
            YarnSurface::Lost | YarnSurface::Fibres(_) => YarnSurface::Lost,
        };
        let mut parts = Parts::new(wavelengths);
        let (mut ends, mut weights) = (Vec::new(), Vec::new());
        let camera = Beam {
            omega_in: *view,
            number,
        };
        air.launch_beam(&camera, rays);
        while !air.is_empty() {
            for (k, system) in [System::Warp, System::Weft].into_iter().enumerate() {
                let crossed = (light.scene.yarns[k], &surfaces[k]);
                let waiting = air.take(system);
                for (arrival, of_arrival) in waiting.arrivals.iter().zip(waiting.weights.chunks_exact(wavelengths)) {
                    let surface_mm = cloth.surface_mm(system, arrival.hit.position.into());
                    ends.push(Vertex {
                        place: segments.of_yarn(cloth, &arrival.hit),
                        position: arrival.hit.position,
                        normal: arrival.hit.frame.normal,
                        towards: arrival.omega_in,
                        yarns: arrival.history.yarns,
                        per_surface: 1.0 / (surface_mm * segments.piece_mm(cloth, system)),
                    });
                    weights.extend_from_slice(of_arrival);
                    if arrival.history.yarns <= light.most {
                        let entry = parts.enter(crossed.1, arrival, of_arrival);
                        air.reflect(&mirror, arrival, &parts.out);
                        light.cross(crossed, arrival, &entry, &mut parts, &mut air, &mut rng);
                    }
                }
            }
            let landed = air.take_landed();
            for (landing, of_landing) in landed.arrivals.iter().zip(landed.weights.chunks_exact(wavelengths)) {
                ends.push(Vertex {
                    place: segments.of_backing(&landing.position),
                    position: landing.position,
                    normal: Vec3::z(),
                    towards: landing.omega_in,
                    yarns: landing.history.yarns,
                    per_surface: 1.0 / segments.square_mm2(),
                });
                weights.extend(of_landing.iter().map(|weight| *weight as f32));
            }
        }
        Self::sorted(&ends, &weights, wavelengths, rays)
    }

    fn sorted(ends: &[Vertex], weights: &[f32], wavelengths: usize, rays: usize) -> Self {
        let mut order: Vec<usize> = (0..ends.len()).collect();
        order.sort_by_key(|&k| ends[k].group());
        Self {
            groups: order.iter().map(|&k| ends[k].group()).collect(),
            ends: order.iter().map(|&k| ends[k]).collect(),
            weights: (order.iter())
                .flat_map(|&k| weights[k * wavelengths..(k + 1) * wavelengths].iter().copied())
                .collect(),
            wavelengths,
            rays,
        }
    }

    /// Chooses one vertex of a place by a uniform random number in [0, 1): among those behind other yarns if
    /// `past_yarns`, else among those that see the view directly. `None` if there is none.
    pub(super) fn at(&self, place: usize, past_yarns: bool, uniform: f64) -> Option<Seen<'_>> {
        let group = 2 * place + usize::from(past_yarns);
        self.one_of(group..group + 1, uniform)
    }

    /// Chooses one vertex among all those of a place, in the same way.
    pub(super) fn at_any(&self, place: usize, uniform: f64) -> Option<Seen<'_>> {
        self.one_of(2 * place..2 * place + 2, uniform)
    }

    fn one_of(&self, groups: Range<usize>, uniform: f64) -> Option<Seen<'_>> {
        let [first, next] = [groups.start, groups.end].map(|group| self.groups.partition_point(|g| *g < group));
        let count = next - first;
        let k = first + ((uniform * count as f64) as usize).min(count.checked_sub(1)?);
        Some(Seen {
            end: &self.ends[k],
            weights: &self.weights[k * self.wavelengths..(k + 1) * self.wavelengths],
            of_ends: count as f64,
        })
    }

    /// Vertices on the backing that see the view directly.
    pub(super) fn bare(&self, segments: &Segments) -> impl Iterator<Item = &Vertex> {
        let on_backing = self.groups.partition_point(|group| *group < 2 * segments.first[2]);
        self.ends[on_backing..].iter().filter(|end| end.yarns == 0)
    }
}
