//! The model's row of Table 1 for another absorption of the particles: kappa at the dye's peak, 0.01 if none is given.

use specval::compare::{Geometry, model_colour_ratios};
use specval::run::{Plan, Simulator, SpectralCurves};
use specval::study::Study;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut study = Study::default();
    study.medium.kappa_peak = std::env::args().nth(1).map_or(Ok(0.01), |typed| typed.parse())?;
    study.trace.paths_direct = 40_000;
    study.rig.pixels_per_side = 12;
    let plan = Plan::new(study)?;
    let normal = Geometry {
        theta_i_deg: 0.0,
        theta_v_deg: 0.0,
    };
    let simulator = Simulator::new(&plan, vec![normal])?;
    let mut diffuse = Vec::new();
    for batch in 0..plan.direct_effort.batches {
        diffuse.push(simulator.batch(batch)?.diffuse);
    }
    let curves = SpectralCurves::new(&plan, vec![normal], diffuse);
    let at_normal: Vec<[f64; 4]> = curves.channels(&plan.colour, false).into_iter().flatten().collect();
    let ratios = model_colour_ratios(&at_normal)?;
    println!("kappa {}", plan.study.medium.kappa_peak);
    for (name, ratio) in [("BLUE/RED", ratios.blue_over_red), ("GREEN/RED", ratios.green_over_red)] {
        println!("{name} {:.4} ± {:.4}", ratio.value, ratio.se);
    }
    Ok(())
}
