//! Laws of the gloss of fibres: energy, sampling, limits, and sense of the twist.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::geometry::Vec3;
use specval::optics::fresnel;
use specval::shading::{FibreGloss, ShadingError};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// α and β.
const ROUGHNESSES: [[f64; 2]; 4] = [[0.1, 0.6], [0.4, 0.6], [0.3, 0.3], [0.2, 1.0]];

fn gloss(twist_deg: f64, [along, across]: [f64; 2]) -> FibreGloss {
    FibreGloss::new(twist_deg.to_radians(), along, across).unwrap()
}

/// θ from the normal, φ from the tangent towards the axis.
fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Nodes and weights of n panels of four-point Gauss–Legendre each.
fn panels(low: f64, high: f64, n: usize) -> impl Iterator<Item = (f64, f64)> {
    const RULE: [(f64, f64); 2] = [
        (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    ];
    let half = 0.5 * (high - low) / n as f64;
    (0..n).flat_map(move |panel| {
        let middle = low + (2 * panel + 1) as f64 * half;
        RULE.into_iter()
            .flat_map(move |(x, w)| [(middle - x * half, w * half), (middle + x * half, w * half)])
    })
}

/// ∫ p dω over a range of θ and of φ. p has a step where θ is the light's, past which no facet mirrors light into the
/// surface, and is steepest about the mirror's direction there: with `crowded` nodes crowd to it from the range's ends.
fn integral(gloss: &FibreGloss, light: &Vec3, theta: [f64; 2], phi: [f64; 2], n: usize, crowded: bool) -> f64 {
    let sides = |[low, high]: [f64; 2], step: f64| {
        let step = step.clamp(low, high);
        [low, high]
            .map(|end| (step, end - step))
            .into_iter()
            .flat_map(move |(step, way)| {
                panels(0.0, 1.0, n).map(move |(x, weight)| {
                    if crowded {
                        (step + way * x * x * x, 3.0 * x * x * way.abs() * weight)
                    } else {
                        (step + way * x, way.abs() * weight)
                    }
                })
            })
    };
    let mut sum = 0.0;
    for (theta, weight) in sides(theta, light.z.acos()) {
        for (phi, share) in sides(phi, light.y.atan2(light.x) + PI) {
            sum += weight * share * theta.sin() * gloss.density(light, &direction(theta, phi));
        }
    }
    sum
}

/// Integral 1 to 1e-9, from normal to grazing light; largest measured deviation 3e-12.
#[test]
fn lobe_is_normalised() {
    for roughness in ROUGHNESSES {
        for (theta_deg, phi_deg, twist_deg) in [
            (0.0, 0.0, 20.0),
            (30.0, 70.0, -35.0),
            (60.0, 10.0, 90.0),
            (85.0, 200.0, 20.0),
            (89.9, -50.0, 0.0),
        ] {
            let theta = f64::to_radians(theta_deg);
            let (gloss, light) = (gloss(twist_deg, roughness), direction(theta, f64::to_radians(phi_deg)));
            let mirror = light.y.atan2(light.x) + PI;
            let around = [mirror - PI, mirror + PI];
            let all = integral(&gloss, &light, [0.0, FRAC_PI_2], around, 150, true);
            println!("{roughness:?}, light {theta_deg} deg: {:.1e}", all - 1.0);
            assert!((all - 1.0).abs() < 1e-9, "{roughness:?} {theta_deg} {twist_deg}: {all}");
        }
    }
    let any = gloss(20.0, [0.1, 0.6]);
    for below in [Vec3::x(), direction(2.0, 1.0), -Vec3::z()] {
        assert_eq!(any.density(&direction(0.5, 0.0), &below), 0.0);
    }
}

/// χ² of 128 bins of directions. False-alarm rate 1e-3 for 12 cases.
#[test]
fn sampled_directions_follow_the_density() {
    const DRAWS: usize = 1_000_000;
    let (rings, sectors) = (8, 16);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for roughness in ROUGHNESSES {
        for (theta_deg, twist_deg) in [(0.0, 20.0), (50.0, -60.0), (88.0f64, 35.0)] {
            let gloss = gloss(twist_deg, roughness);
            let light = direction(theta_deg.to_radians(), 0.4);
            let mut found = vec![0.0; rings * sectors];
            for _ in 0..DRAWS {
                let drawn = gloss.draw(&light, [rng.random(), rng.random()]);
                assert!((drawn.norm() - 1.0).abs() < 1e-12 && drawn.z >= 0.0);
                let ring = drawn.z.acos() / FRAC_PI_2 * rings as f64;
                let sector = drawn.y.atan2(drawn.x).rem_euclid(TAU) / TAU * sectors as f64;
                found[(ring as usize).min(rings - 1) * sectors + (sector as usize).min(sectors - 1)] += 1.0;
            }
            // Bins of few draws are taken together.
            let (mut rest, mut square, mut bins) = ([0.0; 2], 0.0, 0);
            for (k, found) in found.iter().enumerate() {
                let [ring, sector] = [k / sectors, k % sectors];
                let theta = [ring, ring + 1].map(|k| k as f64 * FRAC_PI_2 / rings as f64);
                let phi = [sector, sector + 1].map(|k| k as f64 * TAU / sectors as f64);
                let expected = DRAWS as f64 * integral(&gloss, &light, theta, phi, 8, false);
                if expected < 20.0 {
                    rest = [rest[0] + expected, rest[1] + found];
                    continue;
                }
                square += (found - expected).powi(2) / expected;
                bins += 1;
            }
            if rest[0] >= 20.0 {
                square += (rest[1] - rest[0]).powi(2) / rest[0];
                bins += 1;
            }
            let p = ChiSquared::new(f64::from(bins - 1)).unwrap().sf(square);
            println!("{roughness:?}, {theta_deg} deg: chi2 {square:.1} of {bins} bins, p {p:.3}");
            assert!(p > 1e-3 / 12.0, "{roughness:?} {theta_deg}: {square} of {bins}");
        }
    }
}

#[test]
fn small_roughness_approaches_specular_reflection() {
    let smooth = gloss(20.0, [0.001, 0.001]);
    for theta in [0.0, 0.7, 1.4] {
        let light = direction(theta, 0.3);
        let mirrored = direction(theta, 0.3 + PI);
        let (n, mut near) = (200, 0);
        for k in 0..n * n {
            let numbers = [k / n, k % n].map(|i| (i as f64 + 0.5) / f64::from(n as u32));
            near += usize::from((smooth.draw(&light, numbers) - mirrored).norm() < 0.1);
        }
        // The fraction of facets steeper than t is (α/t)²: 4e-4 at the slope that deflects light by 0.1.
        assert!(near as f64 > 0.9995 * (n * n) as f64, "{theta}: {near}");
    }
}

#[test]
fn isotropic_lobe_does_not_depend_on_twist() {
    let (light, view) = (direction(0.6, 0.3), direction(0.9, 2.9));
    let straight = gloss(0.0, [0.3, 0.3]).density(&light, &view);
    for twist_deg in [-90.0, -35.0, 20.0, 75.0] {
        let twisted = gloss(twist_deg, [0.3, 0.3]);
        assert!((twisted.density(&light, &view) / straight - 1.0).abs() < 1e-12);
        assert!(!twisted.is_handed());
    }
    assert!(gloss(20.0, [0.1, 0.6]).is_handed());
    for twist_deg in [0.0, 90.0, -90.0] {
        assert!(!gloss(twist_deg, [0.1, 0.6]).is_handed());
    }
}

/// Under light along the normal the lobe is brightest across the fibres, at 90° to the axis plus the twist. S is the
/// mirror image of Z. A Z-twisted yarn that hangs before the viewer, its axis up and the tangent to the right, has
/// fibres as the bar of a Z.
#[test]
fn lobe_rotates_with_the_twist() {
    let light = Vec3::z();
    for twist_deg in [-70.0, -20.0, 0.0, 20.0, 45.0] {
        let gloss = gloss(twist_deg, [0.1, 0.6]);
        let at = |azimuth_deg: f64| gloss.density(&light, &direction(0.6, azimuth_deg.to_radians()));
        let brightest = (-900..900)
            .map(|k| 0.1 * f64::from(k))
            .max_by(|a, b| at(*a).total_cmp(&at(*b)))
            .unwrap();
        assert!((brightest + twist_deg).abs() < 0.11, "{twist_deg}: {brightest}");
    }
    let frame = specval::geometry::Frame::from_axis_normal(Vec3::z(), Vec3::x());
    // The viewer looks along -x, up is z: y is to the right.
    assert!((frame.tangent - Vec3::y()).norm() < 1e-15);
    let [z, s] = [20.0, -20.0].map(|twist_deg| gloss(twist_deg, [0.1, 0.6]));
    let mirrored = |d: Vec3| Vec3::new(-d.x, d.y, d.z);
    let (light, view) = (direction(0.6, 0.3), direction(0.9, 2.0));
    let (one, other) = (z.density(&light, &view), s.density(&mirrored(light), &mirrored(view)));
    assert!((one / other - 1.0).abs() < 1e-12 && (s.density(&light, &view) / one - 1.0).abs() > 0.1);
}

/// A bed of parallel round fibres, viewed and lit along the normal: irradiance is uniform over a fibre's width, and the
/// normal at sin ψ of the half width is inclined by ψ.
#[test]
fn slopes_across_round_fibres_match_cylinders() {
    let bed = gloss(0.0, [0.001, 1.0]);
    let n = 500;
    let mut sines: Vec<f64> = (0..n * n)
        .map(|k| {
            let numbers = [k / n, k % n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
            let view = bed.draw(&Vec3::z(), numbers);
            // Facets steeper than 45 degrees mirror light into the surface and are folded up: their slope is the
            // inverse.
            let half = 0.5 * view.x.atan2(view.z);
            half.sin()
        })
        .collect();
    sines.sort_by(f64::total_cmp);
    // Half width h within sin 45°, and what folds onto it: h' = √(1 − h²).
    for h in [0.1f64, 0.3, 0.5, 0.7] {
        let below = sines.partition_point(|sine| *sine < h) as f64 - sines.partition_point(|sine| *sine < -h) as f64;
        let expected = h + 1.0 - (1.0 - h * h).sqrt();
        let share = below / sines.len() as f64;
        assert!((share - expected).abs() < 3e-3, "{h}: {share} {expected}");
    }
}

/// Ratio of F p / cosθ_out to its value with light and view exchanged: 1 for a reciprocal surface. The limits are those
/// stated in docs/between.md.
#[test]
fn deviation_from_reciprocity_is_as_documented() {
    let f = |gloss: &FibreGloss, light: &Vec3, view: &Vec3| {
        fresnel::reflectance(light.z, 1.557) * gloss.density(light, view) / view.z
    };
    for roughness in [[0.1, 0.6], [0.4, 0.6]] {
        let gloss = gloss(20.0, roughness);
        for (pair_deg, within) in [
            ([0.0, 30.0], [0.9, 1.2]),
            ([0.0, 60.0], [0.5, 1.0]),
            ([30.0, 60.0], [0.5, 1.0]),
            ([60.0, 80.0], [0.3, 1.0]),
        ] {
            let [one, other] = pair_deg.map(f64::to_radians);
            let [low, high] = within;
            let (mut least, mut most) = (f64::INFINITY, 0.0f64);
            for k in 0..36 {
                let (a, b) = (direction(one, 0.0), direction(other, f64::from(k) * TAU / 36.0));
                let ratio = f(&gloss, &a, &b) / f(&gloss, &b, &a);
                (least, most) = (least.min(ratio), most.max(ratio));
            }
            println!("{roughness:?} {pair_deg:?}: {least:.2} to {most:.2}");
            assert!(low < least && most < high, "{roughness:?} {pair_deg:?}");
        }
    }
}

#[test]
fn parameters_out_of_range_are_rejected() {
    for twist in [f64::NAN, 1.6, -1.6] {
        assert!(matches!(
            FibreGloss::new(twist, 0.1, 0.6),
            Err(ShadingError::Twist { .. })
        ));
    }
    for [along, across] in [[0.0, 0.6], [0.1, 1.1], [f64::NAN, 0.6], [0.1, f64::NAN]] {
        assert!(matches!(
            FibreGloss::new(0.0, along, across),
            Err(ShadingError::Roughness { .. })
        ));
    }
}
