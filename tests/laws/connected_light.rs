//! Light connected to views inside yarns, and its dependence on absorption.

use ndarray::Axis;
use specval::cloth::light::{Beam, RadianceMoments, Scene, ViewCones, Volumetric, YarnSurface};
use specval::cloth::{Cloth, ClothSpec};
use specval::fit::{BetaTables, ScatteringNode, TableEffort};
use specval::optics::{HenyeyGreenstein, Medium, Phase};
use specval::rig::{Geometry, omega_in, omega_out};
use specval::spectrum::WavelengthGrid;
use specval::transport::{Cylinder, Estimate, Roulette};
use specval::yarn::{Estimator, LengthBins, Yarn};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::PI;

fn cloth(flattening: f64, spacing_mm: f64) -> Cloth {
    Cloth::new(&ClothSpec {
        warp_flattening: flattening,
        weft_flattening: flattening,
        warp_spacing_mm: spacing_mm,
        weft_spacing_mm: spacing_mm,
        ..ClothSpec::default()
    })
    .unwrap()
}

fn yarn(mu_s: f64, g: f64, mu_a: f64) -> Yarn {
    let grid = WavelengthGrid::new(vec![550.0]).unwrap();
    let phase = Phase::HenyeyGreenstein(HenyeyGreenstein::new(g).unwrap());
    Yarn {
        cylinder: Cylinder::new(0.15).unwrap(),
        medium: Medium::from_coefficients(&grid, vec![1.557], vec![mu_s], vec![mu_a], vec![phase]).unwrap(),
        roulette: Roulette::default(),
        estimator: Estimator::Independent,
    }
}

const VIEWS_DEG: [f64; 5] = [-60.0, -20.0, 0.0, 30.0, 60.0];

fn joint(values: impl Iterator<Item = (Estimate, Estimate)>) -> f64 {
    let z = values.map(|(a, b)| (a.value - b.value) / a.se.hypot(b.se));
    let squares: Vec<f64> = z.map(|z| z * z).collect();
    ChiSquared::new(squares.len() as f64).unwrap().sf(squares.iter().sum())
}

/// Every way out of a yarn counts once: connected light and the rest together are what cones of a goniophotometer
/// catch. Opaque flattened yarns, where nearly all light is connected, and transparent round ones, where half is. Each
/// case breaks by chance once in some 3,000 seeds (errors from 16 batches).
#[test]
fn connected_light_is_what_cones_catch() {
    for (name, mu_s, g, mu_a, flattening, spacing_mm) in [
        ("opaque", 120.0, 0.4, 8.0, 3.0, 0.765),
        ("transparent", 8.0, 0.6, 0.8, 1.0, 0.56),
    ] {
        let (cloth, yarn) = (cloth(flattening, spacing_mm), yarn(mu_s, g, mu_a));
        let scene = Scene {
            cloth: &cloth,
            yarns: [&yarn, &yarn],
            backing: None,
            surface: YarnSurface::Lost,
            seed: 5,
        };
        let beam = |number| Beam {
            omega_in: omega_in(45.0, 20.0),
            number,
        };
        let views = || VIEWS_DEG.map(|theta| omega_out(theta, 20.0)).to_vec();
        let bins = LengthBins::logarithmic(0.003, 20.0, 8).unwrap();
        // The rest is smooth to the resolution of the polynomials, and small where yarns are opaque.
        let moments = RadianceMoments::new(8, bins, 20.0, views());
        let cones = ViewCones::new(views(), 4f64.to_radians());
        let light = Volumetric::new(scene, 1500).unwrap();
        let many = Volumetric::new(scene, 30_000).unwrap();
        let (mut connected, mut caught) = (vec![Vec::new(); 5], vec![Vec::new(); 5]);
        for batch in 0..16 {
            let of = light.batch(&beam(1), &moments, batch).caught;
            let cone = many.batch(&beam(2), &cones, batch).caught;
            for (view, theta) in VIEWS_DEG.iter().enumerate() {
                let weights = moments.weights(*theta);
                let beta: f64 = (0..8)
                    .map(|bin| {
                        let rest: f64 = (weights.iter().enumerate())
                            .map(|(k, weight)| weight * of[moments.place(k, bin)][0])
                            .sum();
                        rest + of[moments.places_of_view(view, bin)[0]][0]
                    })
                    .sum();
                connected[view].push(beta);
                caught[view].push(cone[view][0] * PI / cones.projected_solid_angle(view));
            }
        }
        let pairs = connected.iter().zip(&caught).map(|(a, b)| {
            let of = |values: &Vec<f64>| Estimate::from_batches(values.iter().copied());
            (of(a), of(b))
        });
        let p = joint(pairs.clone());
        let shown: Vec<_> = pairs.map(|(a, b)| [a.value, a.se, b.value, b.se]).collect();
        assert!(p > 1e-4, "{name}: p {p}, {shown:.4?}");
    }
}

/// Tables traced with one absorption give β of a higher one as a trace with that absorption does. To lower ones they are
/// taken only where few long paths count, as these were ended by roulette: the search traces with 0.3 of what it seeks.
#[test]
fn one_trace_serves_every_absorption() {
    let cloth = cloth(2.0, 0.66);
    let geometries: Vec<Geometry> = VIEWS_DEG
        .map(|theta_v_deg| Geometry {
            theta_i_deg: 30.0,
            theta_v_deg,
        })
        .to_vec();
    let effort = TableEffort {
        particles: 6000,
        batches: 12,
        azimuths: 2,
        order: 6,
    };
    let tables = |mu_a: f64, seed| {
        let node = ScatteringNode {
            yarns: [yarn(60.0, 0.4, mu_a), yarn(60.0, 0.4, mu_a)],
            backing: None,
            mu_a_per_mm: mu_a,
        };
        BetaTables::trace(&cloth, YarnSurface::Lost, &[node], &geometries, 0.0, &effort, seed).unwrap()
    };
    let (clear, dark) = (tables(1.0, 1), tables(6.0, 2));
    let (predicted, traced) = (clear.beta(0, 6.0), dark.beta(0, 6.0));
    let estimate = |table: &ndarray::Array2<f64>, g: usize| Estimate::from_batches(table.column(g).iter().copied());
    let p = joint((0..geometries.len()).map(|g| (estimate(&predicted, g), estimate(&traced, g))));
    assert!(p > 1e-4, "p {p}");
    // β falls with absorption, at every geometry and in every batch.
    let levels = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0].map(|mu_a| clear.beta(0, mu_a).mean_axis(Axis(0)).unwrap());
    for pair in levels.windows(2) {
        assert!(pair[0].iter().zip(&pair[1]).all(|(a, b)| a > b), "{pair:?}");
    }
}
