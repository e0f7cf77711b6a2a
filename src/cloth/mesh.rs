use super::layout::{Layout, Yarn};
use super::{ClothSpec, System};
use crate::fault::{self, Fault};
use crate::geometry::Vec3;
use std::f64::consts::TAU;

/// Point of a yarn's surface. `normal` and `axis` are those of the smooth tube, unit length and perpendicular.
pub(super) struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    pub axis: Vec3,
}

/// Four vertices, in order around the facet, of yarn `index` of a system. Split in two triangles along 0–2.
pub(super) struct Quad {
    pub corners: [u32; 4],
    pub system: System,
    pub index: u32,
}

/// One repeat of every yarn of the cell.
#[derive(Default)]
pub(super) struct Mesh {
    pub vertices: Vec<Vertex>,
    pub quads: Vec<Quad>,
}

impl Mesh {
    pub fn new(spec: &ClothSpec, layout: &Layout) -> Self {
        let mut mesh = Self::default();
        for system in [System::Warp, System::Weft] {
            for (index, yarn) in layout.yarns(system).iter().enumerate() {
                mesh.add_tube(spec, system, index, yarn);
            }
        }
        mesh
    }

    /// Elliptical sections perpendicular to the centre line, evenly spaced in the cloth's plane. The centre line is a
    /// plane curve, so the section's frame does not twist.
    fn add_tube(&mut self, spec: &ClothSpec, system: System, index: usize, yarn: &Yarn) {
        let line = &yarn.line;
        let rings = line.crossings() * spec.segments_along;
        let across_mm = yarn.place_mm;
        let (a_mm, b_mm) = (yarn.half_width_mm, yarn.half_height_mm);
        let (forward, lateral) = match system {
            System::Warp => (Vec3::x(), Vec3::y()),
            System::Weft => (Vec3::y(), Vec3::x()),
        };
        let first = self.vertices.len();
        for ring in 0..=rings {
            // The closing ring repeats the first one period on, bit for bit, so neighbouring cells join without a gap.
            let along_mm = line.repeat_mm() * (ring % rings) as f64 / rings as f64;
            let shift = forward * if ring == rings { line.repeat_mm() } else { 0.0 };
            let (height_mm, slope) = line.height_and_slope(along_mm);
            let crimp = if fault::active(Fault::CrimpLow) { 0.9 } else { 1.0 };
            let height_mm = crimp * height_mm;
            let axis = (forward + Vec3::z() * slope).normalize();
            let upward = (Vec3::z() - forward * slope).normalize();
            let centre = forward * along_mm + lateral * across_mm + Vec3::z() * height_mm;
            for k in 0..spec.segments_around {
                let (sin, cos) = (TAU * k as f64 / spec.segments_around as f64).sin_cos();
                let (sideways, up) = (lateral * cos, upward * sin);
                // Length of the ellipse's gradient times both half axes; a circle's without rounding.
                let length_mm = if a_mm == b_mm {
                    a_mm
                } else {
                    (b_mm * cos).hypot(a_mm * sin)
                };
                self.vertices.push(Vertex {
                    position: centre + (sideways * a_mm + up * b_mm) + shift,
                    normal: sideways * (b_mm / length_mm) + up * (a_mm / length_mm),
                    axis,
                });
            }
        }
        let vertex = |ring: usize, k: usize| (first + ring * spec.segments_around + k % spec.segments_around) as u32;
        for ring in 0..rings {
            for k in 0..spec.segments_around {
                self.quads.push(Quad {
                    corners: [
                        vertex(ring, k),
                        vertex(ring + 1, k),
                        vertex(ring + 1, k + 1),
                        vertex(ring, k + 1),
                    ],
                    system,
                    index: index as u32,
                });
            }
        }
    }
}
