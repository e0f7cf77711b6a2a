//! Flattened and uneven yarns: closed forms, normals at hits, invariants of variation, and rejected input.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use specval::cloth::{CentreLineKind, Cloth, ClothError, ClothSpec, System, Weave};
use std::collections::BTreeMap;

type Vec3 = Vector3<f64>;

const DOWN: Vec3 = Vec3::new(0.0, 0.0, -1.0);

fn flat(warp_flattening: f64, weft_flattening: f64) -> ClothSpec {
    ClothSpec {
        warp_flattening,
        weft_flattening,
        warp_spacing_mm: 0.8,
        weft_spacing_mm: 0.8,
        ..ClothSpec::default()
    }
}

fn uneven(weave: Weave, centre_line: CentreLineKind, seed: u64) -> ClothSpec {
    ClothSpec {
        weave,
        centre_line,
        warp_flattening: 1.3,
        warp_spacing_mm: 0.7,
        weft_spacing_mm: 0.7,
        radius_variation: 0.05,
        spacing_variation: 0.06,
        repeats: [2, 3],
        variation_seed: seed,
        ..ClothSpec::default()
    }
}

#[test]
fn flattened_yarns_preserve_area_and_increase_cover() {
    for q in [0.7, 1.0, 1.5, 2.0] {
        let cloth = Cloth::new(&flat(q, 1.0)).unwrap();
        let (a, b) = (0.15 * f64::sqrt(q), 0.15 / f64::sqrt(q));
        // Crest of either system at half the sum of the half-heights, plus the higher half-height.
        assert!((cloth.top_mm() - (0.5 * (b + 0.15) + b.max(0.15))).abs() < 1e-15);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..20_000 {
            let (x, y) = (1.6 * rng.random::<f64>(), 1.6 * rng.random::<f64>());
            let aside = |v: f64| (v.rem_euclid(0.8) - 0.4).abs();
            let hit = cloth.first_hit(Vec3::new(x, y, 3.0), DOWN);
            assert_eq!(hit.is_some(), aside(y) < a || aside(x) < 0.15, "{x} {y}");
            if let Some(hit) = hit {
                let chord = cloth.inside_distance(hit.yarn.system, hit.position.into(), DOWN.into(), f64::INFINITY);
                let (u, half_width, half_height) = match hit.yarn.system {
                    System::Warp => (aside(y), a, b),
                    System::Weft => (aside(x), 0.15, 0.15),
                };
                // At least the chord across the section, more where the yarn climbs.
                let level = 2.0 * half_height * (1.0 - (u / half_width).powi(2)).sqrt();
                assert!(chord > level - 1e-12 && chord < 4.0 * level + 1e-9, "{chord} {level}");
            }
        }
    }
}

#[test]
fn every_weave_is_valid_with_flat_yarns() {
    for weave in [Weave::Plain, Weave::Twill21, Weave::Twill31, Weave::Satin5] {
        for (warp_flattening, weft_flattening) in
            [(1.5, 1.0), (1.0, 1.4), (1.5, 1.5), (2.0, 1.8), (0.8, 1.2), (0.7, 0.7)]
        {
            let spec = ClothSpec {
                weave: weave.clone(),
                warp_spacing_mm: 1.2,
                weft_spacing_mm: 1.2,
                ..flat(warp_flattening, weft_flattening)
            };
            if let Err(error) = Cloth::new(&spec) {
                panic!("{weave:?} {warp_flattening} {weft_flattening}: {error}");
            }
        }
    }
}

/// Normals of hits against the plane through three neighbouring hits, and crowns against their ellipse: at a crossing
/// the centre line is level, so the section there is the plane across the yarn.
#[test]
fn normals_and_crowns_of_flat_and_uneven_yarns_match_ellipses() {
    let sinusoid = CentreLineKind::Sinusoid { amplitude_mm: 0.16 };
    for spec in [
        flat(1.6, 1.2),
        flat(0.8, 1.0),
        uneven(Weave::Plain, CentreLineKind::Peirce, 1),
        uneven(Weave::Twill31, CentreLineKind::Peirce, 2),
        uneven(Weave::Twill21, sinusoid, 3),
    ] {
        let cloth = Cloth::new(&spec).unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let mut compared = 0;
        for _ in 0..20_000 {
            let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
            let origin = Vec3::new(9.0 * signed(), 9.0 * signed(), 0.6);
            let direction = Vec3::new(signed(), signed(), -0.05 - signed().abs()).normalize();
            const STEP: f64 = 1e-6;
            let hits =
                [Vec3::zeros(), Vec3::x(), Vec3::y()].map(|aside| cloth.first_hit(origin + aside * STEP, direction));
            let [Some(hit), Some(along_x), Some(along_y)] = hits else {
                continue;
            };
            let facing = -hit.frame.normal.dot(&direction);
            if facing < 0.3 || [along_x, along_y].iter().any(|other| other.yarn != hit.yarn) {
                continue;
            }
            let normal = (along_x.position - hit.position)
                .cross(&(along_y.position - hit.position))
                .normalize();
            assert!(
                (normal - hit.frame.normal).norm() < 2e-4,
                "{spec:?} {normal} {}",
                hit.frame.normal
            );
            assert!(hit.frame.normal.dot(&hit.frame.axis).abs() < 1e-12);
            compared += 1;
        }
        assert!(compared > 5000, "{compared}");
    }
    for (q, r) in [(1.6, 1.2), (0.8, 1.0), (1.0, 1.5)] {
        let cloth = Cloth::new(&flat(q, r)).unwrap();
        let [[a, b], [_, other]] = [q, r].map(|flattening: f64| [0.15 * flattening.sqrt(), 0.15 / flattening.sqrt()]);
        for k in -9..=9 {
            // Warp 0 lies over weft 0 of the plain weave.
            let aside = 0.1 * f64::from(k) * a;
            let hit = cloth.first_hit(Vec3::new(0.4, 0.4 + aside, 1.0), DOWN).unwrap();
            let top = 0.5 * (b + other) + b * (1.0 - (aside / a).powi(2)).sqrt();
            assert_eq!(hit.yarn.system, System::Warp);
            assert!((hit.position.z - top).abs() < 1e-12, "{} {top}", hit.position.z);
        }
    }
}

/// Centre and half width of every yarn of a system in the cell, from the tubes' silhouette in plan.
fn silhouettes(spec: &ClothSpec, system: System) -> BTreeMap<u32, (f64, f64)> {
    let cloth = Cloth::new(spec).unwrap();
    let [cell_x, cell_y] = cloth.cell_mm();
    let mut edges = BTreeMap::new();
    let n = 4000;
    for k in 0..n {
        for line in 0..40 {
            let (across, along) = ((f64::from(k) + 0.5) / f64::from(n), (f64::from(line) + 0.31) / 40.0);
            let (x, y) = match system {
                System::Warp => (along * cell_x, across * cell_y),
                System::Weft => (across * cell_x, along * cell_y),
            };
            for (height, direction) in [(3.0, DOWN), (-3.0, -DOWN)] {
                if let Some(hit) = cloth.first_hit(Vec3::new(x, y, height), direction)
                    && hit.yarn.system == system
                    && hit.yarn.lateral == 0
                {
                    let at = if system == System::Warp { y } else { x };
                    let [low, high] = edges
                        .entry(hit.yarn.index)
                        .or_insert([f64::INFINITY, f64::NEG_INFINITY]);
                    (*low, *high) = (f64::min(*low, at), f64::max(*high, at));
                }
            }
        }
    }
    edges
        .into_iter()
        .map(|(index, [low, high]): (u32, [f64; 2])| (index, (0.5 * (low + high), 0.5 * (high - low))))
        .collect()
}

#[test]
fn variation_preserves_means_and_depends_on_its_seed() {
    let spec = uneven(Weave::Plain, CentreLineKind::Peirce, 7);
    for (system, yarns, half_width) in [(System::Warp, 6, 0.15 * 1.3f64.sqrt()), (System::Weft, 4, 0.15)] {
        let found = silhouettes(&spec, system);
        assert_eq!(found.len(), yarns);
        let mean = found.values().map(|(_, half)| half).sum::<f64>() / yarns as f64;
        // Edges are found to a step of the scan, some 1 µm.
        assert!((mean - half_width).abs() < 2e-3, "{mean} {half_width}");
        assert!(
            found
                .values()
                .any(|(_, half)| (half - half_width).abs() > 0.01 * half_width)
        );
        let uneven = found
            .iter()
            .any(|(k, (at, _))| (at - 0.7 * (f64::from(*k) + 0.5)).abs() > 0.01);
        assert!(uneven && (found[&0].0 - 0.35).abs() < 2e-3);
    }
    let rays = |spec: &ClothSpec| -> Vec<Option<f64>> {
        let cloth = Cloth::new(spec).unwrap();
        (0..200)
            .map(|k| cloth.first_hit(Vec3::new(0.0137 * f64::from(k), 0.0211 * f64::from(k), 1.0), DOWN))
            .map(|hit| hit.map(|h| h.distance_mm))
            .collect()
    };
    assert_eq!(rays(&spec), rays(&spec));
    assert_ne!(rays(&spec), rays(&uneven(Weave::Plain, CentreLineKind::Peirce, 8)));
}

#[test]
fn repeats_without_variation_change_nothing() {
    let one = Cloth::new(&ClothSpec::default()).unwrap();
    let six = Cloth::new(&ClothSpec {
        repeats: [2, 3],
        ..ClothSpec::default()
    })
    .unwrap();
    assert_eq!(six.cell_mm(), [2.16, 3.24]);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for _ in 0..5000 {
        let mut signed = || 2.0 * rng.random::<f64>() - 1.0;
        let origin = Vec3::new(5.0 * signed(), 5.0 * signed(), 0.5);
        let direction = Vec3::new(signed(), signed(), -0.1 - signed().abs()).normalize();
        let [a, b] = [&one, &six].map(|cloth| cloth.first_hit(origin, direction));
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            assert_eq!(a.yarn.system, b.yarn.system);
            let facing = -a.frame.normal.dot(&direction);
            assert!((a.distance_mm - b.distance_mm).abs() < 1e-13 / facing, "{facing}");
        }
    }
}

#[test]
fn overlapping_uneven_and_flat_yarns_are_rejected() {
    let refusal = |spec: ClothSpec| Cloth::new(&spec).expect_err("this cloth cannot be");
    // Level yarns whose axes cross 0.2 mm apart; half-heights 0.15/√1.44 each.
    match refusal(ClothSpec {
        centre_line: CentreLineKind::Sinusoid { amplitude_mm: 0.1 },
        warp_spacing_mm: 3.0,
        weft_spacing_mm: 3.0,
        ..flat(1.44, 1.44)
    }) {
        ClothError::Overlap {
            first,
            second,
            overlap_mm,
            ..
        } => {
            assert_eq!((first.as_str(), second.as_str()), ("warp 0", "weft 0"));
            assert!((overlap_mm - 0.05).abs() < 2e-3, "{overlap_mm}");
        }
        other => panic!("{other}"),
    }
    // Half widths 0.15 √1.44 = 0.18.
    let wide = refusal(ClothSpec {
        centre_line: CentreLineKind::Sinusoid { amplitude_mm: 0.0725 },
        warp_spacing_mm: 0.35,
        weft_spacing_mm: 2.0,
        weave: Weave::Satin5,
        weft_radius_mm: 0.02,
        ..flat(1.44, 1.0)
    });
    assert!(
        wide.to_string()
            .contains("each warp and the next warp overlap by 0.01 mm; increase warp_spacing_mm"),
        "{wide}"
    );
    let crowded = refusal(ClothSpec {
        centre_line: CentreLineKind::Sinusoid { amplitude_mm: 0.085 },
        warp_spacing_mm: 0.31,
        weft_spacing_mm: 2.0,
        weave: Weave::Satin5,
        weft_radius_mm: 0.02,
        spacing_variation: 0.15,
        ..ClothSpec::default()
    });
    let text = crowded.to_string();
    assert!(
        text.starts_with("warp ") && text.contains("overlap by") && text.contains("variations"),
        "{text}"
    );
    for (name, spec) in [
        ("warp_flattening", flat(0.0, 1.0)),
        ("weft_flattening", flat(1.0, f64::NAN)),
        (
            "radius_variation",
            ClothSpec {
                radius_variation: -0.1,
                ..ClothSpec::default()
            },
        ),
        (
            "spacing_variation",
            ClothSpec {
                spacing_variation: 0.5,
                ..ClothSpec::default()
            },
        ),
        (
            "repeats along y",
            ClothSpec {
                repeats: [1, 0],
                ..ClothSpec::default()
            },
        ),
    ] {
        assert!(refusal(spec).to_string().starts_with(name));
    }
}
