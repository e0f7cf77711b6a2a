//! Rays through the endless weave against closed forms and against sphere tracing of the smooth yarns.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::cloth::{CentreLine, CentreLineKind, Cloth, ClothSpec, System, Weave, YarnId};
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

const DOWN: Vec3 = Vec3::new(0.0, 0.0, -1.0);
const RADIUS: f64 = 0.15;
const SPACING: f64 = 0.54;

fn cloth(weave: Weave) -> Cloth {
    Cloth::new(&ClothSpec {
        weave,
        ..ClothSpec::default()
    })
    .unwrap()
}

#[test]
fn plain_weave_cover_equals_its_silhouette() {
    let cloth = cloth(Weave::Plain);
    let [cell_x, cell_y] = cloth.cell_mm();
    assert_eq!([cell_x, cell_y], [1.08, 1.08]);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let n = 500;
    let mut covered = 0;
    for k in 0..n * n {
        let x = (f64::from(k % n) + rng.random::<f64>()) / f64::from(n) * cell_x;
        let y = (f64::from(k / n) + rng.random::<f64>()) / f64::from(n) * cell_y;
        let hit = cloth.first_hit(Vec3::new(x, y, 3.0), DOWN);
        let near = |v: f64| (v.rem_euclid(SPACING) - 0.5 * SPACING).abs() < RADIUS;
        assert_eq!(hit.is_some(), near(x) || near(y), "at {x}, {y}");
        covered += i32::from(hit.is_some());
    }
    // Stratified: only the strata on the gaps' edges (8 edges of 0.44 cells' length in all 4 gaps) are random.
    let expected = 1.0 - (1.0 - 2.0 * RADIUS / SPACING).powi(2);
    let found = f64::from(covered) / f64::from(n * n);
    assert!((found - expected).abs() < 2e-4, "{found} {expected}");
}

#[test]
fn crowns_are_tori_and_floats_are_cylinders() {
    let arc_radius = 2.0 * RADIUS;
    let plain = cloth(Weave::Plain);
    let twill = cloth(Weave::Twill31);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for _ in 0..2000 {
        let u = 0.1 * (2.0 * rng.random::<f64>() - 1.0);
        let v = 0.12 * (2.0 * rng.random::<f64>() - 1.0);
        // Warp 0 passes over weft 0 of the plain weave: a torus around the weft's axis.
        let hit = plain.first_hit(Vec3::new(0.27 + u, 0.27 + v, 1.0), DOWN).unwrap();
        assert_eq!(
            hit.yarn,
            YarnId {
                system: System::Warp,
                index: 0,
                lateral: 0
            }
        );
        let outer = arc_radius + (RADIUS * RADIUS - v * v).sqrt();
        let top = -0.5 * arc_radius + (outer * outer - u * u).sqrt();
        let radial = Vec3::new(u, 0.0, top + 0.5 * arc_radius);
        let normal = (radial - radial.normalize() * arc_radius + Vec3::y() * v).normalize();
        assert!((top - hit.position.z).abs() < 1e-12, "torus {top} {}", hit.position.z);
        assert!(
            (hit.frame.normal - normal).norm() < 1e-10,
            "{}",
            hit.frame.normal - normal
        );
        let axis = Vec3::new(radial.z, 0.0, -radial.x).normalize();
        assert!((hit.frame.axis - axis).norm() < 1e-10);
        assert!((hit.distance_mm - (1.0 - hit.position.z)).abs() < 1e-12);

        // Warp 0 of the 3/1 twill floats over wefts 1 to 3.
        let hit = twill
            .first_hit(Vec3::new(2.5 * SPACING + 4.0 * u, 0.27 + v, 1.0), DOWN)
            .unwrap();
        assert_eq!(hit.yarn.system, System::Warp);
        let normal_z = (1.0 - (v / RADIUS).powi(2)).sqrt();
        let depth = 0.5 * arc_radius + RADIUS * normal_z - hit.position.z;
        assert!(depth.abs() < 1e-12, "cylinder {depth}");
        assert!((hit.frame.axis - Vec3::x()).norm() < 1e-12);
    }
    assert!((plain.top_mm() - 2.0 * RADIUS).abs() < 1e-15);
}

/// Distance from a point to the smooth tubes of the default plain cloth, slowly: nearest yarns of either system, each
/// centre line searched by scan and ternary search.
fn distance_to_yarns(line: &CentreLine, point: Vec3) -> f64 {
    let mut nearest = f64::INFINITY;
    for system in [System::Warp, System::Weft] {
        let (along, across) = match system {
            System::Warp => (point.x, point.y),
            System::Weft => (point.y, point.x),
        };
        let yarn = (across / SPACING - 0.5).round();
        for k in [yarn - 1.0, yarn, yarn + 1.0] {
            // `line` is warp 0, up at crossing 0; moved by one crossing it is warp 1 and weft 0.
            let odd = k.rem_euclid(2.0) == 1.0;
            let shift = if odd != (system == System::Weft) { SPACING } else { 0.0 };
            let aside = across - (k + 0.5) * SPACING;
            let squared = |s: f64| {
                let height = line.height_and_slope(s + shift).0;
                (s - along).powi(2) + aside * aside + (height - point.z).powi(2)
            };
            let scan = (-60..=60).map(|n| along + 0.01 * f64::from(n));
            let best = scan.min_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap();
            let (mut low, mut high) = (best - 0.01, best + 0.01);
            for _ in 0..40 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if squared(a) < squared(b) { high = b } else { low = a }
            }
            nearest = nearest.min(squared(low).sqrt() - RADIUS);
        }
    }
    nearest
}

/// First point of a ray on the smooth yarns, from above the cloth to below it.
fn sphere_trace(line: &CentreLine, origin: Vec3, direction: Vec3) -> Option<f64> {
    let mut t = ((0.301 - origin.z) / direction.z).max(0.0);
    while origin.z + t * direction.z > -0.301 {
        let step = distance_to_yarns(line, origin + direction * t);
        if step < 1e-7 {
            return Some(t);
        }
        t += step;
    }
    None
}

#[test]
fn oblique_and_grazing_rays_agree_with_sphere_tracing() {
    let cloth = cloth(Weave::Plain);
    let up = vec![true, false];
    let line = CentreLine::new(CentreLineKind::Peirce, System::Warp, up, SPACING, 2.0 * RADIUS).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let (mut hits, mut gaps) = (0, 0);
    for theta_deg in [5.0, 35.0, 60.0, 75.0, 85.0, 89.0f64] {
        let mut compared = 0;
        for _ in 0..60 {
            let theta = theta_deg.to_radians();
            let azimuth = 2.0 * PI * rng.random::<f64>();
            let direction = Vec3::new(theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), -theta.cos());
            // Well outside the cell, and above or in the slab's margin.
            let origin = Vec3::new(
                40.0 * rng.random::<f64>() - 20.0,
                40.0 * rng.random::<f64>() - 20.0,
                0.31,
            );
            let expected = sphere_trace(&line, origin, direction);
            let found = cloth.first_hit(origin, direction);
            let Some(t) = expected else {
                assert!(found.is_none(), "{theta_deg}: {:?}", found.map(|h| h.distance_mm));
                gaps += 1;
                continue;
            };
            let at = origin + direction * t;
            let e = 1e-5;
            let gradient = Vec3::from_fn(|k, _| {
                let step = Vec3::ith(k, e);
                distance_to_yarns(&line, at + step) - distance_to_yarns(&line, at - step)
            });
            let facing = -gradient.normalize().dot(&direction);
            // Where the ray only grazes the yarn, the march's last step may stop short of it.
            if facing > 0.05 {
                let hit = found.unwrap_or_else(|| panic!("{theta_deg}: missed at {t}"));
                // The march ends 1e-7 off the surface.
                assert!(
                    (hit.distance_mm - t).abs() < 2e-7 / facing,
                    "{theta_deg}: {} {t} {facing}",
                    hit.distance_mm
                );
                compared += 1;
                hits += 1;
            }
        }
        assert!(compared > 10, "{theta_deg}: {compared}");
    }
    assert!(hits > 200 && gaps > 10, "{hits} {gaps}");
}

#[test]
fn hits_are_periodic_over_cells() {
    for weave in [Weave::Plain, Weave::Twill21, Weave::Satin5] {
        let cloth = cloth(weave);
        let [cell_x, cell_y] = cloth.cell_mm();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for _ in 0..2000 {
            let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
            let (a, b) = ((10.0 * signed()).round(), (10.0 * signed()).round());
            let shift = Vec3::new(a * cell_x, b * cell_y, 0.0);
            let origin = Vec3::new(signed(), signed(), 0.5);
            let direction = Vec3::new(signed(), signed(), -0.02 - signed().abs()).normalize();
            let here = cloth.first_hit(origin, direction);
            let there = cloth.first_hit(origin + shift, direction);
            assert_eq!(here.is_some(), there.is_some());
            let (Some(here), Some(there)) = (here, there) else {
                continue;
            };
            assert!((here.distance_mm - there.distance_mm).abs() < 1e-10);
            assert!((here.frame.normal - there.frame.normal).norm() < 1e-8);
            let lateral = match here.yarn.system {
                System::Warp => b as i64,
                System::Weft => a as i64,
            };
            assert_eq!(
                there.yarn,
                YarnId {
                    lateral: here.yarn.lateral + lateral,
                    ..here.yarn
                }
            );
            let light = Vec3::new(signed(), signed(), 0.3).normalize();
            assert_eq!(
                cloth.shadowed(here.position, light, here.yarn),
                cloth.shadowed(there.position, light, there.yarn)
            );
        }
    }
}

#[test]
fn shadow_ray_skips_only_the_owner_along_its_whole_length() {
    let cloth = cloth(Weave::Plain);
    let owner = YarnId {
        system: System::Warp,
        index: 0,
        lateral: 0,
    };
    for cell in -3..=3 {
        // Between two wefts a vertical ray through the axis of warp 0 meets that yarn alone.
        let origin = Vec3::new(1.08 * f64::from(cell) + 0.54, 0.27, 1.0);
        assert_eq!(cloth.first_hit(origin, DOWN).unwrap().yarn, owner);
        assert!(!cloth.shadowed(origin, DOWN, owner));
        for other in [
            YarnId { lateral: 1, ..owner },
            YarnId { index: 1, ..owner },
            YarnId {
                system: System::Weft,
                ..owner
            },
        ] {
            assert!(cloth.shadowed(origin, DOWN, other));
        }
        assert!(!cloth.shadowed(origin, -DOWN, YarnId { index: 1, ..owner }));
        // At a crossing the weft is still in the way.
        let crossing = Vec3::new(1.08 * f64::from(cell) + 0.27, 0.27, 1.0);
        assert!(cloth.shadowed(crossing, DOWN, owner));
    }
}

#[test]
fn shadow_rays_agree_with_the_nearest_hit_of_other_yarns() {
    // Stepping from hit to hit, through the owner where it is met, must say the same as the one query.
    let cloth = cloth(Weave::Twill21);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut blocked = 0;
    for _ in 0..3000 {
        let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
        let (origin, direction) = (Vec3::new(signed(), signed(), 0.5), Vec3::new(signed(), signed(), -1.0));
        let Some(hit) = cloth.first_hit(origin, direction.normalize()) else {
            continue;
        };
        let light = Vec3::new(signed(), signed(), 0.05 + signed().abs()).normalize();
        let through = |at: Vec3| {
            let [position, direction] = [at, light].map(Into::into);
            at + light * cloth.inside_distance(hit.yarn.system, position, direction, 10.0)
        };
        let inwards = hit.frame.normal.dot(&light) < 0.0;
        let mut from = if inwards { through(hit.position) } else { hit.position };
        let mut steps = 0;
        let expected = loop {
            steps += 1;
            assert!(steps < 1000, "{hit:?} {light}");
            match cloth.first_hit(from, light) {
                None => break false,
                Some(next) if next.yarn != hit.yarn => break true,
                Some(next) => from = through(next.position),
            }
        };
        assert_eq!(cloth.shadowed(hit.position, light, hit.yarn), expected);
        blocked += i32::from(expected);
    }
    assert!(blocked > 300, "{blocked}");
}

#[test]
fn rays_in_the_plane_and_along_the_axes_terminate() {
    let cloth = cloth(Weave::Plain);
    assert!(cloth.first_hit(Vec3::new(-7.0, 0.27, 0.15), Vec3::x()).is_some());
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::x()).is_none());
    assert!(
        cloth
            .first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::new(1.0, 0.0, -0.0))
            .is_none()
    );
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::z()).is_none());
    // Exactly on a cell's wall and on a yarn's outermost line.
    assert!(cloth.first_hit(Vec3::new(0.0, 0.27, 1.0), DOWN).is_some());
    assert!(cloth.first_hit(Vec3::new(1.08, 0.27, 1.0), DOWN).is_some());
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 1.0), DOWN).is_none());
}
