//! How far the preprint's classical shading lies from a measured sample, by incidence: a built-in sample, a folder or a
//! file.

use specval::rig::{omega_in, omega_out};
use specval::run::Plan;
use specval::sample::Sample;
use specval::shading::{Basis, classical_model};
use specval::study::Study;
use std::collections::BTreeMap;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("merl-red-fabric2".into());
    let plan = Plan::new(Study::default())?;
    let sample = Sample::load(&name)?;
    let reading = |i, v| sample.reading(i, v, plan.colour.convention());
    let normal = reading(0.0, 0.0)?.ok_or("the sample has no reading at normal incidence and view")?;
    let model = classical_model("lambert-cook-torrance")?.of(&Basis {
        normal: normal.beta,
        specular: plan.specular,
    })?;
    let mut by_incidence: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (theta_i, theta_v) in sample.geometries() {
        let Some(measured) = reading(theta_i, theta_v)? else {
            continue;
        };
        let shaded = model.eval(&omega_in(theta_i, 0.0), &omega_out(theta_v, 0.0), &[1.0; 4]);
        let squares = by_incidence.entry(theta_i.round() as i64).or_default();
        squares.push((shaded[3] - measured.beta[3]).powi(2));
    }
    for (theta_i, squares) in by_incidence {
        let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        println!(
            "{theta_i:>3}°  luminance factor off by {rms:.4} rms over {} views",
            squares.len()
        );
    }
    Ok(())
}
