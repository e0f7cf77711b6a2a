use super::{Outcome, Plan, Precision, StopRule};
use crate::report::{AskedEffort, EffortNote, PathsPerBatch, ReachedPrecision};

pub(super) fn paths_per_batch(plan: &Plan) -> PathsPerBatch {
    PathsPerBatch {
        bssrdf: plan.bssrdf_effort.paths_per_batch,
        direct: plan.direct_effort.paths_per_batch,
    }
}

/// The effort of a run under this stop rule; `watched` is the quantity that its largest error is of.
pub(super) fn effort_note(
    paths_per_batch: PathsPerBatch,
    rule: &StopRule,
    outcome: &Outcome,
    watched: Precision,
) -> EffortNote {
    EffortNote {
        batches: outcome.batches,
        paths_per_batch,
        stopped_by: outcome.stopped_by.word().into(),
        asked: AskedEffort {
            until: rule.precision.map(|precision| precision.to_string()),
            max_time_s: rule.max_time.map(|time| time.as_secs_f64()),
            batches: rule.batches,
        },
        reached: outcome.reached.map(|largest_error| ReachedPrecision {
            tolerance: watched.tolerance.word().into(),
            of: watched.of.word().into(),
            largest_error: Some(largest_error).filter(|error| error.is_finite()),
        }),
    }
}
