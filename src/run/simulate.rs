use super::effort::{effort_note, paths_per_batch};
use super::{Batch, Gather, RunError, Schedule, Simulator, SpectralCurves, StateFile, Watch, gather};
use crate::cloth::light::ClothLedger;
use crate::report::EffortNote;
use crate::transport::Ledger;

/// All batches of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    pub curves: SpectralCurves,
    /// `[batch][traced incident direction × wavelength]`.
    pub ledgers: Vec<Vec<Ledger>>,
    /// `[batch][incidence × wavelength]`; empty batches where light is not followed from yarn to yarn.
    pub cloth: Vec<Vec<ClothLedger>>,
    /// How much was traced and why no more.
    pub effort: EffortNote,
}

/// Batches of a simulation so far.
struct Simulating<'a> {
    simulator: &'a Simulator<'a>,
    watch: Watch<'a>,
    state: &'a StateFile,
    done: Vec<Batch>,
}

impl Gather for Simulating<'_> {
    type Batch = Batch;
    type Error = RunError;

    fn batches(&self) -> usize {
        self.done.len()
    }

    fn make(&self, batch: usize) -> Result<Batch, RunError> {
        self.simulator.batch(batch)
    }

    fn accept(&mut self, batch: Batch) {
        self.watch.add(&batch.diffuse);
        self.done.push(batch);
    }

    fn largest_error(&self) -> Option<f64> {
        self.watch.largest_error()
    }

    fn save(&self) -> Result<(), RunError> {
        self.state.save(self.simulator, &self.done)
    }
}

/// Traces, shades and measures until the schedule's rule says stop. `resumed` are batches an earlier run has made, from
/// number 0 on; as many of them count as a run without them would have made.
pub fn simulate(
    simulator: &Simulator,
    watch: Watch,
    resumed: Vec<Batch>,
    state: &StateFile,
    schedule: &Schedule,
) -> Result<Simulation, RunError> {
    let rule = schedule.rule;
    let mut done = Simulating {
        simulator,
        watch,
        state,
        done: Vec::new(),
    };
    for batch in resumed {
        if rule.reached(done.batches(), || done.largest_error()).is_some() {
            break;
        }
        done.accept(batch);
    }
    let outcome = gather(&mut done, schedule)?;
    let plan = simulator.plan;
    let watched = done.watch.precision();
    let (mut ledgers, mut diffuse, mut cloth) = (Vec::new(), Vec::new(), Vec::new());
    for batch in done.done {
        ledgers.push(batch.ledgers);
        diffuse.push(batch.diffuse);
        cloth.push(batch.cloth);
    }
    Ok(Simulation {
        curves: SpectralCurves::new(plan, simulator.geometries().to_vec(), diffuse),
        ledgers,
        cloth,
        effort: effort_note(paths_per_batch(plan), rule, &outcome, watched),
    })
}
