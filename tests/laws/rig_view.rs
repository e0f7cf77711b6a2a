//! The virtual goniophotometer on samples with known results.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::cloth::light::Integrator;
use specval::cloth::{CentreLineKind, Cloth, ClothSpec, System, Weave};
use specval::rig::{
    Geometry, Interaction, PixelSamples, Rig, RigError, brightness_factor, omega_in, omega_out, view_cell,
};
use specval::run::Plan;
use specval::shading::BrightnessFactor;
use specval::study::Study;
use specval::yarn::YarnResponse;
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;

fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// Mean of a value over the cell's camera rays.
fn mean(cloth: &Cloth, v: &Vec3, n: usize, seed: u64, value: impl Fn(Option<Interaction>) -> f64) -> f64 {
    let samples = PixelSamples::new(n, n).unwrap();
    let mut sum = 0.0;
    view_cell(cloth, v, &samples, &mut rng(seed), |interaction| {
        sum += value(interaction)
    });
    sum / samples.count() as f64
}

#[test]
fn angles_follow_the_signed_convention() {
    let (l, v) = (omega_in(30.0, 0.0), omega_out(30.0, 0.0));
    assert!((l - Vec3::new(-0.5, 0.0, 0.75f64.sqrt())).norm() < 1e-15);
    // The mirror direction of the light is at plus θ_i, the light itself at minus.
    assert!((v - Vec3::new(-l.x, -l.y, l.z)).norm() < 1e-15);
    assert!((omega_out(-30.0, 70.0) - omega_in(30.0, 70.0)).norm() < 1e-15);
    let turned = omega_out(40.0, 90.0);
    assert!((turned - Vec3::new(0.0, 40f64.to_radians().sin(), 40f64.to_radians().cos())).norm() < 1e-15);
}

#[test]
fn angles_out_of_range_are_rejected() {
    let rig = Rig::default();
    assert_eq!(rig.incidences_deg(), [0.0, 30.0, 60.0]);
    assert_eq!(rig.views_deg().len(), 27);
    assert_eq!((rig.views_deg()[0], rig.views_deg()[26]), (-60.0, 70.0));
    assert_eq!(Rig::new(vec![], vec![0.0]), Err(RigError::NoAngles));
    assert_eq!(
        Rig::new(vec![-1.0], vec![0.0]),
        Err(RigError::Incidence { found: -1.0 })
    );
    assert_eq!(
        Rig::new(vec![90.0], vec![0.0]),
        Err(RigError::Incidence { found: 90.0 })
    );
    assert_eq!(
        Rig::new(vec![0.0], vec![0.0, -90.0]),
        Err(RigError::View { found: -90.0 })
    );
    assert!(Rig::new(vec![0.0], vec![f64::NAN]).is_err());
    assert!(Rig::new(vec![f64::NAN], vec![0.0]).is_err());
    assert!(PixelSamples::new(0, 4).is_err());
    assert!(PixelSamples::new(4, 1 << 20).is_err());
}

#[test]
fn perfect_diffuser_has_brightness_factor_one_at_every_angle() {
    let rig = Rig::default();
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    for &theta_i in rig.incidences_deg() {
        let cos_i = theta_i.to_radians().cos();
        for &theta_v in rig.views_deg() {
            let (l, v) = (omega_in(theta_i, 20.0), omega_out(theta_v, 20.0));
            let sheet = BrightnessFactor(1.0).brdf().0 * l.z;
            assert!((brightness_factor(sheet, cos_i).0 - 1.0).abs() < 1e-14);
            // Cloth and gaps of equal radiance: the mean must not contain the cosine of the view.
            let shining = mean(&cloth, &v, 8, 1, |_| cos_i / PI);
            assert!(
                (brightness_factor(shining, cos_i).0 - 1.0).abs() < 1e-13,
                "{theta_i} {theta_v}"
            );
        }
    }
}

/// Fraction of a plain weave's cell covered by yarns of radius R at spacing p, viewed along the normal.
fn coverage_from_above(radius_mm: f64, spacing_mm: f64) -> f64 {
    1.0 - (1.0 - 2.0 * radius_mm / spacing_mm).powi(2)
}

#[test]
fn each_system_contributes_half_the_cover_at_normal_view() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let see =
        |system| move |i: Option<Interaction>| f64::from(u8::from(i.is_some_and(|i| i.hit.yarn.system == system)));
    let z = Vec3::z();
    let half = 0.5 * coverage_from_above(0.15, 0.54);
    for system in [System::Warp, System::Weft] {
        let found = mean(&cloth, &z, 400, 2, see(system));
        assert!((found - half).abs() < 5e-4, "{system} {found} {half}");
    }
}

/// Gaps of an open weave in an independent renderer: tests/data/cloth_open_weave_gaps.csv.
#[test]
fn gaps_match_an_independent_renderer() {
    let cloth = Cloth::new(&ClothSpec {
        weave: Weave::Plain,
        centre_line: CentreLineKind::Sinusoid { amplitude_mm: 0.126 },
        warp_radius_mm: 0.125,
        weft_radius_mm: 0.125,
        warp_spacing_mm: 0.6,
        weft_spacing_mm: 0.6,
        ..ClothSpec::default()
    })
    .unwrap();
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path("tests/data/cloth_open_weave_gaps.csv")
        .unwrap();
    let mut rows = 0;
    for row in reader.deserialize() {
        let (theta_deg, reference, reference_se): (f64, f64, f64) = row.unwrap();
        // Eight runs give the standard error of the stratified mean.
        let runs: Vec<f64> = (0..8)
            .map(|seed| {
                let v = omega_out(theta_deg, 0.0);
                mean(&cloth, &v, 250, seed, |i| f64::from(u8::from(i.is_none())))
            })
            .collect();
        let found = runs.iter().sum::<f64>() / 8.0;
        let variance = runs.iter().map(|r| (r - found).powi(2)).sum::<f64>() / 56.0;
        let z = (found - reference) / (variance + reference_se * reference_se).sqrt();
        assert!(z.abs() < 3.5, "{theta_deg}: {found} against {reference}, z {z}");
        rows += 1;
    }
    assert_eq!(rows, 2);
}

#[test]
fn local_directions_transform_back_to_the_world_frame() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let (l, v) = (omega_in(60.0, 35.0), omega_out(65.0, 35.0));
    let (mut seen, mut lit, mut turned_up) = (0, 0, 0);
    view_cell(
        &cloth,
        &v,
        &PixelSamples::new(150, 150).unwrap(),
        &mut rng(3),
        |interaction| {
            let Some(i) = interaction else { return };
            let frame = i.hit.frame;
            if let Some(light) = i.light(&cloth, &l) {
                assert!((frame.to_world(&light) - l).norm() < 1e-14);
                lit += 1;
            }
            assert!((i.omega_out_local.norm() - 1.0).abs() < 1e-14 && i.omega_out_local.z > 0.0);
            // Rotated up to a cosine of 1e-6 only at a silhouette.
            let turn = (frame.to_world(&i.omega_out_local) - v).norm();
            assert!(turn < 2e-6, "{turn}");
            turned_up += i32::from(turn > 1e-12);
            assert!(match i.hit.yarn.system {
                System::Warp => frame.axis.y.abs() < 1e-12 && frame.axis.x > 0.6,
                System::Weft => frame.axis.x.abs() < 1e-12 && frame.axis.y > 0.6,
            });
            seen += 1;
        },
    );
    assert!(
        lit > 0 && lit < seen && turned_up * 1000 < seen,
        "{seen} {lit} {turned_up}"
    );
}

#[test]
fn light_from_the_view_direction_casts_no_visible_shadow() {
    let cloth = Cloth::new(&ClothSpec {
        weave: Weave::Twill21,
        ..ClothSpec::default()
    })
    .unwrap();
    for theta in [0.0, 40.0, 80.0] {
        let v = omega_out(theta, 50.0);
        let samples = PixelSamples::new(60, 60).unwrap();
        view_cell(&cloth, &v, &samples, &mut rng(4), |i| {
            assert!(i.is_none_or(|i| i.light(&cloth, &v).is_some()), "{theta}")
        });
    }
}

#[test]
fn same_seed_gives_the_same_view() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let v = omega_out(-20.0, 0.0);
    let look = |seed| {
        let mut all = Vec::new();
        view_cell(&cloth, &v, &PixelSamples::new(20, 30).unwrap(), &mut rng(seed), |i| {
            all.push(i)
        });
        all
    };
    assert_eq!(look(5).len(), 600);
    assert_eq!(look(5), look(5));
    assert_ne!(look(5), look(6));
}

/// Helmholtz reciprocity: ∫ (n·l)⁺ (n·v)⁺ over the surface both visible and lit is symmetric in l and v. The rig
/// viewing along v includes (n·v) in its measure: cosθ_v times its mean of (n·l)⁺ is the integral per area of cloth.
/// Here with the yarn's shadow on itself, found by a ray from the surface.
#[test]
fn visible_and_lit_surface_is_reciprocal() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let [cell_x, cell_y] = cloth.cell_mm();
    let half = |l: &Vec3, v: &Vec3, seed: u64| {
        let mut rng = rng(seed);
        let n = 250;
        let mut sum = 0.0;
        for k in 0..n * n {
            let x = (f64::from(k % n) + rng.random::<f64>()) / f64::from(n) * cell_x;
            let y = (f64::from(k / n) + rng.random::<f64>()) / f64::from(n) * cell_y;
            let origin = Vec3::new(x, y, 0.0) + v * (1.0 / v.z);
            let Some(hit) = cloth.first_hit(origin, -v) else {
                continue;
            };
            let cos_l = hit.frame.normal.dot(l);
            if cos_l > 0.0 && cloth.first_hit(hit.position, *l).is_none() {
                sum += cos_l;
            }
        }
        v.z * sum / f64::from(n * n)
    };
    for (a, b) in [(0.0, 50.0), (30.0, -60.0), (60.0, 20.0), (70.0, -40.0)] {
        let (l, v) = (omega_out(a, 25.0), omega_out(b, 25.0));
        let (one, other) = (half(&l, &v, 6), half(&v, &l, 7));
        assert!((one - other).abs() < 2e-3 * one, "{a} {b}: {one} {other}");
    }
}

/// The outward normals of a convex or any closed tube sum up to its silhouette: seen along v, the mean over the cell of
/// 1 is covered + gaps, and from either side of the cloth the same is covered.
#[test]
fn cover_is_equal_from_both_sides_and_increases_with_angle() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    let [cell_x, cell_y] = cloth.cell_mm();
    let mut last = coverage_from_above(0.15, 0.54) - 1e-3;
    for theta in [0.0, 20.0, 40.0, 55.0] {
        let v = omega_out(theta, 0.0);
        let above = mean(&cloth, &v, 300, 8, |i| f64::from(u8::from(i.is_some())));
        let mut rng = rng(9);
        let n = 300;
        let below = (0..n * n)
            .filter(|k| {
                let x = (f64::from(k % n) + rng.random::<f64>()) / f64::from(n) * cell_x;
                let y = (f64::from(k / n) + rng.random::<f64>()) / f64::from(n) * cell_y;
                cloth.first_hit(Vec3::new(x, y, 0.0) - v * (1.0 / v.z), v).is_some()
            })
            .count() as f64
            / f64::from(n * n);
        assert!((above - below).abs() < 1.5e-3, "{theta}: {above} {below}");
        assert!(above > last, "{theta}: {above}");
        last = above;
    }
}

/// Camera rays are uniform over their pixels: offsets within a pixel have mean 1/2 and variance 1/12 along both sides,
/// and x and y are independent.
#[test]
fn camera_rays_are_uniform_over_pixels() {
    let cloth = Cloth::new(&ClothSpec::default()).unwrap();
    const SIDE: usize = 200;
    let samples = PixelSamples::new(SIDE, SIDE).unwrap();
    let pixels = cloth.cell_mm().map(|cell| cell / SIDE as f64);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let (mut sums, mut rays) = ([0.0; 5], 0.0);
    view_cell(&cloth, &Vec3::z(), &samples, &mut rng, |interaction| {
        if let Some(point) = interaction {
            let [x, y] = [0, 1].map(|k| (point.hit.position[k] / pixels[k]).fract() - 0.5);
            for (sum, moment) in sums.iter_mut().zip([x, y, x * x, y * y, x * y]) {
                *sum += moment;
            }
            rays += 1.0;
        }
    });
    // Four standard deviations of the means of x, x² and xy, 1/√12, 1/√180 and 1/12 for one ray.
    let bound = |deviation: f64| 4.0 * deviation / f64::sqrt(rays);
    let [x, y, xx, yy, xy] = sums.map(|sum| sum / rays);
    assert!(
        rays > 30_000.0 && x.abs().max(y.abs()) < bound(12f64.powf(-0.5)),
        "{x} {y}"
    );
    let variances = [xx, yy].map(|square| (square - 1.0 / 12.0).abs());
    assert!(variances[0].max(variances[1]) < bound(180f64.powf(-0.5)), "{xx} {yy}");
    assert!(xy.abs() < bound(1.0 / 12.0), "{xy}");
}

#[test]
fn camera_rays_do_not_depend_on_other_views() {
    let mut study = Study::default();
    study.rig.pixels_per_side = 6;
    let plan = Plan::new(study).unwrap();
    let geometry = |theta_i_deg, theta_v_deg| Geometry {
        theta_i_deg,
        theta_v_deg,
    };
    let all = [geometry(30.0, 50.0), geometry(0.0, -20.0), geometry(60.0, 50.0)];
    let response = YarnResponse::from_fn(plan.factor_grid, 1, |[tilt, ..]| plan.factor_grid.mean_cosine(tilt));
    let look = |geometries: &[Geometry], batch| {
        let beams = plan.beams(geometries);
        beams.sum(
            &plan
                .direct()
                .brightness(std::slice::from_ref(&response), beams.lit(), batch)
                .unwrap(),
            1,
        )
    };
    let together = look(&all, 3);
    for (place, alone) in all.iter().enumerate() {
        assert_eq!(look(std::slice::from_ref(alone), 3)[0], together[place], "{place}");
    }
    assert_ne!(look(&all, 4), together);
}

/// f* = 1 everywhere at one wavelength gives β = π times the visible and lit fraction of the cell, or slightly more
/// where the cosine of the tilt is interpolated; f* = 2 at another wavelength gives twice that.
#[test]
fn wavelengths_are_shaded_independently() {
    let plan = Plan::new(Study::default()).unwrap();
    let camera = plan.direct().look(plan.beams(&[Geometry::NORMAL]).lit(), 0);
    let response = YarnResponse::from_fn(plan.factor_grid, plan.grid.len(), |[.., wavelength]| match wavelength {
        4 => 1.0,
        9 => 2.0,
        _ => 0.0,
    });
    let beta = &camera.shade(&[response])[0][0];
    // The plain weave at 1.8 diameters covers 0.802 of the cell, 2.52 / π, and what is seen from the light is lit.
    assert!((2.4..2.6).contains(&beta[4]) && beta[9] == 2.0 * beta[4]);
    assert_eq!(beta.iter().filter(|b| **b != 0.0).count(), 2);
}
