use super::cloth::ClothEnergy;
use super::gate::{Gate, GateVerdict, Law};
use super::{
    CheckEffort, CheckError, Checked, Context, Subject, attenuation, bounces, camera, cells, cloth, cylinder,
    estimates, ledger, medium, particles, reabsorption, rig, symmetry, tables, weave, woven,
};
use crate::run::{Plan, Progress};

/// Laws in the mean, which have a chance to break: the false alarms of a run are divided between them.
const IN_THE_MEAN: [Law; 11] = [
    medium::ANGLE,
    cylinder::LAW,
    ledger::SHARING,
    ledger::ROULETTE,
    tables::ROADS,
    symmetry::RECIPROCITY,
    symmetry::MIRROR,
    bounces::BOUNCES,
    bounces::VIEWS,
    cloth::ENERGY,
    cloth::ALBEDO,
];

/// Laws of which nothing can be said of a medium that amplifies: no light can be traced in it.
const TRACED: Law = Law {
    name: "traced-laws",
    words: "ledgers, tables, symmetries and cloth of the study",
};

/// Tests every law on the study of a plan.
///
/// # Errors
/// What tracing refuses; see [`CheckError`].
pub fn study(plan: &Plan, effort: CheckEffort, progress: Progress) -> Result<Checked, CheckError> {
    let context = &Context::new(plan, effort, IN_THE_MEAN.len());
    let subject = Subject {
        version: env!("CARGO_PKG_VERSION").into(),
        kind: "study",
        seed: plan.study.seed,
        effort: Some(effort),
        study: serde_json::to_value(&plan.study)?,
        inputs: plan.inputs.clone(),
    };
    let mut passive = medium::passive(&plan.yarn.medium, context);
    if plan.weft.is_some() && passive.note.is_none() {
        passive =
            passive.with_note("warp and weft differ: laws are tested on the warp's yarn, and on a cloth of it alone");
    }
    let mut gates = vec![passive.clone()];
    gates.extend(medium::tables(context)?);
    gates.extend([
        rig::whites(context)?,
        rig::diffuser(context),
        rig::shading(context)?,
        rig::lookup(context),
        camera::pixels(context)?,
        camera::rig_directions(context),
        camera::mirror_gloss(context)?,
    ]);
    gates.extend(weave::gates(context)?);
    gates.extend([
        cells::lookup(context),
        estimates::standard_errors(context)?,
        estimates::normalisation(context)?,
    ]);
    gates.extend(particles::gates(context)?);
    progress(0.05);
    if passive.verdict == GateVerdict::Broken {
        gates.push(Gate::undecided(TRACED).with_note("not traced: the medium is not passive"));
        return Ok(Checked::new(gates, Vec::new(), subject));
    }
    gates.extend(attenuation::gates(context)?);
    gates.push(cells::straight(context)?);
    gates.push(reabsorption::gate(context)?);
    gates.push(medium::angles(context)?);
    gates.push(cylinder::closed_forms(context)?);
    progress(0.1);
    let (ledgers, mut quantities) = ledger::gates(context)?;
    gates.extend(ledgers);
    progress(0.5);
    gates.push(tables::bssrdf(context)?);
    let mut cloth = ClothEnergy::new(context);
    gates.extend(tables::direct(context, |batch| cloth.add(batch))?);
    gates.push(tables::two_estimators(context)?);
    progress(0.2);
    gates.extend(symmetry::gates(context)?);
    gates.push(woven::ledger(context)?);
    gates.push(woven::furnace(context, &ledger::white_yarn(context)?)?);
    gates.push(woven::aperture(context)?);
    gates.extend(bounces::gates(context)?);
    let (energy, of_cloth) = cloth.gates();
    gates.extend(energy);
    quantities.extend(of_cloth);
    progress(0.15);
    Ok(Checked::new(gates, quantities, subject))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use std::collections::BTreeSet;

    #[test]
    fn false_alarms_are_divided_between_just_the_laws_in_the_mean() {
        let mut study = Study::default();
        study.spectrum.wavelengths_nm = Some(vec![450.0, 650.0]);
        study.trace.zenith_cells = 2;
        study.trace.azimuth_cells = 4;
        study.rig.pixels_per_side = 4;
        let plan = Plan::new(study).unwrap();
        let checked = self::study(&plan, CheckEffort::of_paths(4096).unwrap(), &|_| ()).unwrap();
        let random: BTreeSet<&str> = checked
            .gates
            .iter()
            .filter(|gate| gate.p.is_some())
            .map(|gate| gate.name)
            .collect();
        assert_eq!(random, IN_THE_MEAN.iter().map(|law| law.name).collect());
    }
}
