use crate::cloth::{Cloth, System};
use crate::geometry::Vec3;
use crate::optics::fresnel;

/// The straight way of light from a point inside a yarn through its surface into a given direction outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Refracted {
    /// Where it leaves.
    pub position: Vec3,
    /// Unit direction inside.
    pub direction: Vec3,
    /// Length inside, mm.
    pub length_mm: f64,
    /// Fresnel transmittance.
    pub transmittance: f64,
    /// dω_inside/dω_outside: solid angle of directions at the point that the surface spreads over a unit of solid angle
    /// outside.
    pub solid_angle_ratio: f64,
}

/// Newton steps after which the search gives up, and distance in units of the length inside at which it has converged.
const MOST_STEPS: usize = 12;
const CONVERGED: f64 = 1e-7;
/// Step, as a share of the distance to the surface, over which the curvature of the surface is measured.
const CURVATURE_STEP: f64 = 1e-4;
/// Largest ratio of solid angles accepted: near a caustic it diverges, and with it the variance.
const MOST_RATIO: f64 = 4.0;

impl Refracted {
    /// Finds the way from `from`, inside a yarn of `system`, towards the unit vector `towards`, with the index `index`
    /// inside. A function of its arguments alone, which may miss ways where there are several: light on a way that it
    /// does not find must be scored otherwise.
    ///
    /// The camera ray from `towards` that meets the surface at p is refracted into a line; p is moved until the line
    /// passes the point (Newton's method, with the curvature of the surface from differences of its normal). The ratio
    /// of solid angles follows from how the refracted direction turns as p moves.
    pub fn find(cloth: &Cloth, system: System, index: f64, from: Vec3, towards: Vec3) -> Option<Self> {
        let surface = |p: Vec3| {
            let (on, normal) = cloth.surface(system, p.into());
            (Vec3::from(on), Vec3::from(normal))
        };
        // The way straight out, refracted at the plane there, is the first guess.
        let outward = Side::at(surface(from).1, towards, index)?.inside;
        let reach = cloth.inside_distance(system, from.into(), outward.into(), f64::INFINITY);
        if !reach.is_finite() {
            return None;
        }
        let mut position = from + outward * reach;
        for _ in 0..MOST_STEPS {
            let (on, normal) = surface(position);
            position = on;
            let side = Side::at(normal, towards, index)?;
            let way = position - from;
            let length_mm = way.dot(&side.inside);
            let miss = side.inside * length_mm - way;
            let bend = Bend::at(position, normal, CURVATURE_STEP * length_mm.abs(), surface)?;
            if miss.norm() <= CONVERGED * length_mm {
                return Self::of(cloth, system, index, from, position, normal, &side, length_mm, &bend);
            }
            position += side.step(&bend, &miss, length_mm)?;
        }
        None
    }

    #[allow(clippy::too_many_arguments)]
    fn of(
        cloth: &Cloth,
        system: System,
        index: f64,
        from: Vec3,
        position: Vec3,
        normal: Vec3,
        side: &Side,
        length_mm: f64,
        bend: &Bend,
    ) -> Option<Self> {
        if length_mm <= 0.0 {
            return None;
        }
        // The surface must not be met before.
        let met = cloth.inside_distance(system, from.into(), side.inside.into(), f64::INFINITY);
        if (met - length_mm).abs() > 1e-6 * length_mm {
            return None;
        }
        let (d, cos_in, cos_out) = (side.inside, side.cos_inside, side.cos_outside);
        // Outside direction ω = n d − (n cos_in − cos_out) N, as the point moves along a tangent.
        let turned = |tangent: Vec3, turn: Vec3| {
            let of_d = (tangent - d * d.dot(&tangent)) / length_mm;
            let of_cos_in = of_d.dot(&normal) + d.dot(&turn);
            let of_cos_out = index * index * cos_in * of_cos_in / cos_out;
            of_d * index - normal * (index * of_cos_in - of_cos_out) - turn * (index * cos_in - cos_out)
        };
        let spread = turned(bend.tangents[0], bend.turns[0])
            .cross(&turned(bend.tangents[1], bend.turns[1]))
            .norm();
        let solid_angle_ratio = cos_in / (length_mm * length_mm * spread);
        (solid_angle_ratio < MOST_RATIO).then(|| Self {
            position,
            direction: d,
            length_mm,
            transmittance: 1.0 - fresnel::reflectance(cos_out, index),
            solid_angle_ratio,
        })
    }
}

/// The two directions at a point of the surface.
struct Side {
    /// Unit direction inside of light that leaves towards the view.
    inside: Vec3,
    cos_inside: f64,
    cos_outside: f64,
    index: f64,
    normal: Vec3,
}

impl Side {
    fn at(normal: Vec3, towards: Vec3, index: f64) -> Option<Self> {
        let cos_outside = towards.dot(&normal);
        // NaN, at the axis of a yarn, has no side either.
        if cos_outside.is_nan() || cos_outside <= 1e-4 {
            return None;
        }
        let cos_inside = (1.0 - (1.0 - cos_outside * cos_outside) / (index * index)).sqrt();
        let inside = towards / index + normal * (cos_inside - cos_outside / index);
        Some(Self {
            inside,
            cos_inside,
            cos_outside,
            index,
            normal,
        })
    }

    /// Newton step of the point on the surface: (1 − s Dt) dp + … = miss, where the line turns with the normal.
    fn step(&self, bend: &Bend, miss: &Vec3, length_mm: f64) -> Option<Vec3> {
        // The line through p + dp in the direction d + δd passes the point if dp − s δd − ds d = miss.
        let column = |k: usize| {
            let turn = bend.turns[k];
            let of_outside = turn.dot(&(self.normal * self.cos_outside + self.lateral()));
            let of_inside = self.cos_outside * of_outside / (self.index * self.index * self.cos_inside);
            let of_d = self.normal * (of_inside - of_outside / self.index)
                + turn * (self.cos_inside - self.cos_outside / self.index);
            bend.tangents[k] - of_d * length_mm
        };
        let matrix = nalgebra::Matrix3::from_columns(&[column(0), column(1), -self.inside]);
        let solved = matrix.lu().solve(miss)?;
        let step = bend.tangents[0] * solved.x + bend.tangents[1] * solved.y;
        // Not beyond the scale on which the surface is known.
        let most = 0.5 * length_mm.abs();
        let norm = step.norm();
        norm.is_finite()
            .then(|| if norm > most { step * (most / norm) } else { step })
    }

    /// Part of the outside direction along the surface.
    fn lateral(&self) -> Vec3 {
        (self.inside - self.normal * self.cos_inside) * self.index
    }
}

/// Curvature of the surface at a point.
struct Bend {
    tangents: [Vec3; 2],
    /// Change of the normal per length along each tangent, 1/mm.
    turns: [Vec3; 2],
}

impl Bend {
    fn at(position: Vec3, normal: Vec3, step: f64, surface: impl Fn(Vec3) -> (Vec3, Vec3)) -> Option<Self> {
        let other = if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
        let first = normal.cross(&other).normalize();
        let tangents = [first, normal.cross(&first)];
        let turns = tangents.map(|tangent| (surface(position + tangent * step).1 - normal) / step);
        turns
            .iter()
            .all(|turn| turn.norm().is_finite())
            .then_some(Self { tangents, turns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::ClothSpec;
    use approx::assert_relative_eq;

    /// Snell's law holds at the surface, and the ratio of solid angles is that of differences.
    #[test]
    fn ways_out_are_refracted_towards_the_view() {
        let spec = ClothSpec {
            warp_flattening: 2.0,
            weft_flattening: 2.0,
            warp_spacing_mm: 0.66,
            weft_spacing_mm: 0.66,
            ..ClothSpec::default()
        };
        let (cloth, index) = (Cloth::new(&spec).unwrap(), 1.557);
        let mut found = 0;
        for k in 0..200 {
            let [x, y] = [0.618, 0.414].map(|step: f64| (step * f64::from(k)).fract() * 1.32);
            let Some(hit) = cloth.first_hit(Vec3::new(x, y, 1.0), -Vec3::z()) else {
                continue;
            };
            let from = hit.position - hit.frame.normal * (0.002 + 0.02 * f64::from(k % 5));
            let system = hit.yarn.system;
            let [theta, phi] = [f64::from(k % 13) * 10.0 - 60.0, f64::from(k % 7) * 25.0].map(f64::to_radians);
            let towards = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let Some(way) = Refracted::find(&cloth, system, index, from, towards) else {
                continue;
            };
            found += 1;
            assert_relative_eq!(way.position, from + way.direction * way.length_mm, epsilon = 1e-7);
            let normal = Vec3::from(cloth.surface(system, way.position.into()).1);
            // n sin θ inside = sin θ outside, in one plane.
            let [inside, outside] = [way.direction, towards].map(|d| d - normal * d.dot(&normal));
            assert_relative_eq!(inside * index, outside, epsilon = 1e-5);
            let step = 1e-4;
            let across = towards.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize();
            let turned = |along: Vec3| {
                let of = |sign: f64| {
                    let towards = (towards + along * (sign * step)).normalize();
                    Some(Refracted::find(&cloth, system, index, from, towards)?.direction)
                };
                Some((of(1.0)? - of(-1.0)?) / (2.0 * step))
            };
            let (Some(a), Some(b)) = (turned(across), turned(towards.cross(&across))) else {
                continue;
            };
            // The curvature of the arcs jumps where they meet the straights.
            let difference = (a.cross(&b).norm() / way.solid_angle_ratio - 1.0).abs();
            assert!(difference < 2e-2, "{k}: {difference}");
        }
        assert!(found > 120, "{found}");
    }
}
