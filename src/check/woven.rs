//! Light that goes from yarn to yarn, traced through the medium of each: none of it is lost, and a white cloth keeps
//! none.

use super::gate::{Gate, Law, Where};
use super::{CheckError, Context};
use crate::cloth::light::{
    Beam, ClothFraction, ClothLedger, Integrator, LitBatch, LitViews, Scene, ViewCones, Volumetric,
};
use crate::geometry::Vec3;
use crate::rig::omega_in;
use crate::yarn::Yarn;
use rayon::prelude::*;

const LEDGER: Law = Law {
    name: "cloth-ledger",
    words: "of light traced through the yarns of the cloth, reflected + transmitted + absorbed + the net of random \
            sampling is 1",
};
const FURNACE: Law = Law {
    name: "cloth-furnace",
    words: "white yarns absorb nothing of the light traced through them, and the same sum is 1",
};

const APERTURE: Law = Law {
    name: "aperture",
    words: "a cone of 90° about the normal has the brightness factor of the light that the ledger says is reflected",
};

/// Half angle of the widest cone; 3e-8 of diffuse light leaves lower, and what is left of the circle of directions.
const WIDEST_DEG: f64 = 89.99;
/// Of the incident flux: particles carry what they do in single precision.
const CAUGHT: f64 = 1e-5;

/// Light traced through the yarns as the rig catches it, particle by particle.
pub fn aperture(context: &Context) -> Result<Gate, CheckError> {
    let plan = context.plan;
    let incidences = plan.rig.incidences_deg();
    let lit: Vec<LitViews> = (incidences.iter().enumerate())
        .map(|(number, theta_i_deg)| LitViews {
            beam: Beam {
                omega_in: omega_in(*theta_i_deg, plan.study.cloth.azimuth_deg),
                number,
            },
            cones: ViewCones::new(vec![Vec3::z()], WIDEST_DEG.to_radians()),
            numbers: vec![0],
        })
        .collect();
    let cloth = Volumetric::new(plan.scene(true, false), PARTICLES)?;
    let departures: Vec<f64> = cloth
        .brightness(&[], &lit, 0)?
        .iter()
        .flat_map(|LitBatch { beta, ledger }| {
            let caught = beta.iter().flatten();
            caught
                .zip(ledger)
                .map(|(beta, ledger)| beta - ledger[ClothFraction::Reflected])
                .collect::<Vec<_>>()
        })
        .collect();
    let nm = plan.grid.nm();
    Ok(context.judge.exact(APERTURE, &departures, CAUGHT, |i| {
        Where::new(nm[i % nm.len()], format!("theta_i {} deg", incidences[i / nm.len()]))
    }))
}

/// Particles of a beam and group of wavelengths: the sums hold path by path, whatever their number.
const PARTICLES: usize = 64;

pub fn ledger(context: &Context) -> Result<Gate, CheckError> {
    closes(context, LEDGER, context.plan.yarns(), |ledger| ledger.residual())
}

/// `white` is the study's yarn without absorption.
pub fn furnace(context: &Context, white: &Yarn) -> Result<Gate, CheckError> {
    closes(context, FURNACE, [white, white], |ledger| {
        let residual = ledger.residual();
        if ledger[ClothFraction::Absorbed].abs() > residual.abs() {
            ledger[ClothFraction::Absorbed]
        } else {
            residual
        }
    })
}

/// Warp and weft of one cloth, at every incidence of the rig.
fn closes(context: &Context, law: Law, yarns: [&Yarn; 2], of: fn(&ClothLedger) -> f64) -> Result<Gate, CheckError> {
    let plan = context.plan;
    let scene = Scene {
        yarns,
        ..plan.scene(true, false)
    };
    let cloth = Volumetric::new(scene, PARTICLES)?;
    let nothing = ViewCones::new(Vec::new(), 0.0);
    let incidences = plan.rig.incidences_deg();
    let ledgers: Vec<ClothLedger> = (incidences.par_iter().enumerate())
        .flat_map_iter(|(number, theta_i_deg)| {
            let beam = Beam {
                omega_in: omega_in(*theta_i_deg, plan.study.cloth.azimuth_deg),
                number,
            };
            cloth.batch(&beam, &nothing, 0).ledger
        })
        .collect();
    let departures: Vec<f64> = ledgers.iter().map(of).collect();
    let nm = plan.grid.nm();
    Ok(context.judge.exact(law, &departures, plan.study.check.rounding, |i| {
        Where::new(nm[i % nm.len()], format!("theta_i {} deg", incidences[i / nm.len()]))
    }))
}
