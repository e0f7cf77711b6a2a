//! Rays in and between the smooth yarns against closed forms, and against dense marching.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::cloth::{CentreLine, CentreLineKind, Cloth, ClothSpec, Hit, System, Weave};
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

const DOWN: Vec3 = Vec3::new(0.0, 0.0, -1.0);
const SYSTEMS: [System; 2] = [System::Warp, System::Weft];

fn weaves() -> Vec<ClothSpec> {
    let open = ClothSpec {
        centre_line: CentreLineKind::Sinusoid { amplitude_mm: 0.126 },
        warp_radius_mm: 0.125,
        weft_radius_mm: 0.125,
        warp_spacing_mm: 0.6,
        weft_spacing_mm: 0.6,
        ..ClothSpec::default()
    };
    let fine_weft = ClothSpec {
        weave: Weave::Twill31,
        weft_radius_mm: 0.1,
        weft_spacing_mm: 0.47,
        ..ClothSpec::default()
    };
    vec![
        ClothSpec::default(),
        fine_weft,
        ClothSpec {
            weave: Weave::Satin5,
            ..open.clone()
        },
        open,
    ]
}

/// A yarn's F by its definition, with the nearest point of the centre line found by scan and ternary search.
struct Slow {
    spec: ClothSpec,
    lines: [Vec<CentreLine>; 2],
}

impl Slow {
    fn new(spec: &ClothSpec) -> Self {
        let draft = spec.weave.draft();
        let lines = SYSTEMS.map(|system| {
            let spacing = match system {
                System::Warp => spec.weft_spacing_mm,
                System::Weft => spec.warp_spacing_mm,
            };
            (0..draft.yarns(system))
                .map(|k| {
                    let radii = spec.warp_radius_mm + spec.weft_radius_mm;
                    CentreLine::new(spec.centre_line, system, draft.on_top(system, k), spacing, radii).unwrap()
                })
                .collect()
        });
        Self {
            spec: spec.clone(),
            lines,
        }
    }

    /// F of the yarn of a system whose plane is nearest, and that plane's number.
    fn value(&self, system: System, point: Vec3) -> (f64, i64) {
        let (along, across, spacing, radius, lines) = match system {
            System::Warp => (
                point.x,
                point.y,
                self.spec.warp_spacing_mm,
                self.spec.warp_radius_mm,
                &self.lines[0],
            ),
            System::Weft => (
                point.y,
                point.x,
                self.spec.weft_spacing_mm,
                self.spec.weft_radius_mm,
                &self.lines[1],
            ),
        };
        let number = (across / spacing - 0.5).round();
        let u = across - (number + 0.5) * spacing;
        let line = &lines[number.rem_euclid(lines.len() as f64) as usize];
        let squared = |s: f64| {
            let height = line.height_and_slope(s).0;
            (s - along).powi(2) + (height - point.z).powi(2)
        };
        let step = 0.02 * radius;
        let scan = (-70..=70).map(|n| along + step * f64::from(n));
        let best = scan.min_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap();
        let (mut low, mut high) = (best - step, best + step);
        for _ in 0..45 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if squared(a) < squared(b) { high = b } else { low = a }
        }
        ((u * u + squared(low)) / (radius * radius) - 1.0, number as i64)
    }
}

fn isotropic(rng: &mut Xoshiro256PlusPlus) -> Vec3 {
    let z = 2.0 * rng.random::<f64>() - 1.0;
    let azimuth = 2.0 * PI * rng.random::<f64>();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z)
}

/// A hit from a random direction above or below, anywhere on the cloth.
fn any_hit(cloth: &Cloth, rng: &mut Xoshiro256PlusPlus) -> Hit {
    loop {
        let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
        let through = Vec3::new(3.0 * signed(), 3.0 * signed(), 0.2 * signed());
        let direction = isotropic(rng);
        if direction.z.abs() > 0.02
            && let Some(hit) = cloth.first_hit(through - direction * (2.0 / direction.z.abs()), direction)
        {
            return hit;
        }
    }
}

/// A direction on the side of `normal` given by the sign, cosine-weighted.
fn lambert(rng: &mut Xoshiro256PlusPlus, normal: Vec3, sign: f64) -> Vec3 {
    (normal * sign + isotropic(rng) * (1.0 - 1e-9)).normalize()
}

#[test]
fn floats_match_the_closed_form_of_a_straight_cylinder() {
    // Warp 0 of the 3/1 twill runs level over wefts 1 to 3, its axis at y = 0.27, z = 0.15.
    let cloth = Cloth::new(&ClothSpec {
        weave: Weave::Twill31,
        ..ClothSpec::default()
    })
    .unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    for _ in 0..5000 {
        let (r, turn) = (0.15 * rng.random::<f64>().sqrt(), 2.0 * PI * rng.random::<f64>());
        let direction = isotropic(&mut rng);
        let (y, z) = (r * turn.cos(), r * turn.sin());
        let across = direction.y.hypot(direction.z);
        let half = (y * direction.y + z * direction.z) / (across * across);
        let expected = -half + (half * half + (0.0225 - r * r) / (across * across)).sqrt();
        // The float is two spacings long around x = 3 spacings.
        if expected > 0.5 {
            continue;
        }
        let from = [1.35, 0.27 + y, 0.15 + z];
        let found = cloth.inside_distance(System::Warp, from, direction.into(), f64::INFINITY);
        assert!(
            (found - expected).abs() < 1e-12 * (1.0 + 0.15 / (half + expected) / across),
            "{found} {expected}"
        );
    }
}

#[test]
fn rays_inside_end_at_the_first_surface() {
    for (n, spec) in weaves().iter().enumerate() {
        let cloth = Cloth::new(spec).unwrap();
        let slow = Slow::new(spec);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(20 + n as u64);
        for case in 0..1500 {
            let hit = any_hit(&cloth, &mut rng);
            let direction = lambert(&mut rng, hit.frame.normal, -1.0);
            let system = hit.yarn.system;
            let distance = cloth.inside_distance(system, hit.position.into(), direction.into(), f64::INFINITY);
            assert!(distance > 0.0 && distance < 20.0, "{distance}");
            let end = hit.position + direction * distance;
            let (on_surface, normal) = cloth.surface(system, end.into());
            assert!((end - Vec3::from(on_surface)).norm() < 1e-13, "{spec:?} {distance}");
            assert!(Vec3::from(normal).dot(&direction) > -1e-6);
            // The slow nearest point is good to the square root of rounding, its distance to rounding.
            assert!(slow.value(system, end).0.abs() < 1e-11, "{}", slow.value(system, end).0);
            let limit = 0.1 * rng.random::<f64>();
            let limited = cloth.inside_distance(system, hit.position.into(), direction.into(), limit);
            assert!(limited == distance || (limited >= limit && distance >= limit));
            if case % 5 == 0 {
                for k in 1..60 {
                    let at = hit.position + direction * (distance * f64::from(k) / 60.0);
                    assert!(slow.value(system, at).0 < 1e-12, "{spec:?}: left before {distance}");
                }
                // On along the surface after total reflection: legal, and never a distance of 0.
                let n = Vec3::from(normal);
                let reflected = (direction - n * (2.0 * n.dot(&direction))).normalize();
                let again = cloth.inside_distance(system, on_surface, reflected.into(), f64::INFINITY);
                assert!(again > 1e-11, "{again}");
            }
        }
    }
}

#[test]
fn first_hit_agrees_with_dense_marching() {
    for (n, spec) in weaves().iter().enumerate() {
        let cloth = Cloth::new(spec).unwrap();
        let slow = Slow::new(spec);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(40 + n as u64);
        let (mut met, mut escaped) = (0, 0);
        for _ in 0..200 {
            let start = any_hit(&cloth, &mut rng);
            let out = lambert(&mut rng, start.frame.normal, 1.0);
            let found = cloth.first_hit(start.position, out);
            let reach = match found {
                Some(hit) => {
                    met += 1;
                    assert!(slow.value(hit.yarn.system, hit.position).0.abs() < 1e-11);
                    assert!((hit.position - start.position - out * hit.distance_mm).norm() < 1e-12);
                    assert!(hit.frame.normal.dot(&out) < 1e-6);
                    let (_, number) = slow.value(hit.yarn.system, hit.position);
                    let yarns = slow.lines[hit.yarn.system as usize].len() as i64;
                    assert_eq!(hit.yarn.lateral * yarns + i64::from(hit.yarn.index), number);
                    hit.distance_mm
                }
                None => {
                    escaped += 1;
                    (out.z.signum() * cloth.top_mm() - start.position.z) / out.z
                }
            };
            let steps = (reach / 0.01).ceil().min(1000.0);
            for k in 1..steps as usize {
                let at = start.position + out * (reach * k as f64 / steps);
                for system in SYSTEMS {
                    // Contact along the arcs may hold rounding's worth of overlap.
                    let (f, _) = slow.value(system, at);
                    assert!(f > -1e-9, "{spec:?}: inside a {system} by {f} at {k} of {steps}");
                }
            }
        }
        assert!(met > 40 && escaped > 40, "{met} {escaped}");
    }
}

#[test]
fn reversed_rays_return_to_their_origin() {
    for (n, spec) in weaves().iter().enumerate() {
        let cloth = Cloth::new(spec).unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(80 + n as u64);
        let mut compared = 0;
        for _ in 0..20_000 {
            let start = any_hit(&cloth, &mut rng);
            let out = lambert(&mut rng, start.frame.normal, 1.0);
            let Some(there) = cloth.first_hit(start.position, out) else {
                continue;
            };
            // Rays that graze either end amplify rounding without bound.
            let facing = start.frame.normal.dot(&out).min(-there.frame.normal.dot(&out));
            if facing < 1e-3 || there.distance_mm < 1e-9 {
                continue;
            }
            compared += 1;
            let back = cloth.first_hit(there.position, -out).expect("the way back");
            assert_eq!(back.yarn, start.yarn);
            assert!(
                (back.distance_mm - there.distance_mm).abs() < 1e-12 / facing,
                "{facing}"
            );
        }
        assert!(compared > 4000, "{compared}");
    }
}

#[test]
fn rays_pass_between_yarns_in_contact() {
    // Warp 0 lies on weft 0 at (0.27, 0.27, 0); they touch along the arcs.
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let contact = Vec3::new(0.27, 0.27, 0.0);
    for (tilt, owner, other) in [(0.3, System::Weft, System::Warp), (-0.3f64, System::Warp, System::Weft)] {
        let direction = Vec3::new(tilt.sin(), 0.1, tilt.signum() * tilt.cos()).normalize();
        let hit = cloth.first_hit(contact, direction).expect("the other yarn");
        assert_eq!(hit.yarn.system, other, "leaving the {owner}");
        assert!(hit.distance_mm < 1e-9);
    }
}

#[test]
fn hits_are_periodic_over_cells() {
    for spec in weaves() {
        let cloth = Cloth::new(&spec).unwrap();
        let [cell_x, cell_y] = cloth.cell_mm();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(100);
        for _ in 0..1000 {
            let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
            let (a, b) = ((10.0 * signed()).round(), (10.0 * signed()).round());
            let shift = Vec3::new(a * cell_x, b * cell_y, 0.0);
            let origin = Vec3::new(signed(), signed(), 0.5);
            let direction = Vec3::new(signed(), signed(), -0.05 - signed().abs()).normalize();
            let here = cloth.first_hit(origin, direction);
            let there = cloth.first_hit(origin + shift, direction);
            assert_eq!(here.is_some(), there.is_some());
            if let (Some(here), Some(there)) = (here, there)
                && here.frame.normal.dot(&direction) < -0.01
            {
                assert!((here.distance_mm - there.distance_mm).abs() < 1e-11);
                let cells = if here.yarn.system == System::Warp { b } else { a };
                assert_eq!(there.yarn.lateral, here.yarn.lateral + cells as i64);
                assert_eq!(
                    (there.yarn.system, there.yarn.index),
                    (here.yarn.system, here.yarn.index)
                );
                let inward = lambert(&mut rng, here.frame.normal, -1.0);
                let [one, two] = [here, there].map(|hit| {
                    let from = hit.position.into();
                    cloth.inside_distance(hit.yarn.system, from, inward.into(), f64::INFINITY)
                });
                assert!((one - two).abs() < 1e-9, "{one} {two}");
            }
        }
    }
}

#[test]
fn rays_in_the_plane_and_along_the_axes_terminate() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    assert!(cloth.first_hit(Vec3::new(-7.0, 0.27, 0.15), Vec3::x()).is_some());
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::x()).is_none());
    assert!(
        cloth
            .first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::new(1.0, 0.0, -0.0))
            .is_none()
    );
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 0.31), Vec3::z()).is_none());
    // Between the planes of two wefts, over the troughs of no warp.
    assert!(cloth.first_hit(Vec3::new(0.0, 0.27, 1.0), DOWN).is_some());
    assert!(cloth.first_hit(Vec3::new(1.08, 0.27, 1.0), DOWN).is_some());
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 1.0), DOWN).is_none());
    // Along the channel between two warps, through the wefts' gaps at no height: ends on a weft.
    assert!(cloth.first_hit(Vec3::new(0.0, 0.0, 0.0), Vec3::x()).is_some());
}

/// Gaps of an open weave in an independent renderer: tests/data/cloth_open_weave_gaps.csv. Its azimuth of incidence
/// is along a yarn.
#[test]
fn gaps_of_an_open_weave_match_an_independent_renderer() {
    let cloth = Cloth::new(&weaves()[3]).unwrap();
    let mut rows = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path("tests/data/cloth_open_weave_gaps.csv")
        .unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for row in rows.deserialize() {
        let (theta_deg, expected, se): (f64, f64, f64) = row.unwrap();
        let (sin, cos) = theta_deg.to_radians().sin_cos();
        let direction = Vec3::new(sin, 0.0, -cos);
        let n = 1000;
        let through = (0..n * n)
            .filter(|k| {
                let x = 1.2 * (f64::from(k % n) + rng.random::<f64>()) / f64::from(n);
                let y = 1.2 * (f64::from(k / n) + rng.random::<f64>()) / f64::from(n);
                cloth.first_hit(Vec3::new(x, y, 0.3), direction).is_none()
            })
            .count();
        let found = through as f64 / f64::from(n * n);
        // Stratified: the error of this side is far below the reference's.
        assert!((found - expected).abs() < 3.0 * se, "{theta_deg}: {found} {expected}");
    }
}
