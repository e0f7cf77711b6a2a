//! A whole study: every stage in turn, from the study's values to the report's data.

mod approximations;
mod artefact;
mod batches;
mod camera;
mod cloth_keys;
mod curves;
mod file_kind;
mod full;
mod grazing;
mod inputs;
mod light;
mod memory;
mod plan;
mod reabsorb;
mod readings;
mod report;
mod simulate;
mod state;
mod stop;
mod trace;
mod watch;
mod work;

pub use approximations::{approximations, check_approximations};
pub use artefact::{
    LengthTable, MediumValues, Shard, ShardError, Systematic, Table, YarnArtefact, YarnAxes, YarnLayout, YarnSettings,
    merge_shards, trace_shard,
};
pub use batches::{Gather, Outcome, Schedule, gather};
pub use camera::CameraBatch;
pub(crate) use camera::stream_of;
pub use curves::SpectralCurves;
pub(crate) use curves::{directions, gloss};
pub use file_kind::{FileKind, OtherKind};
pub use full::{Cells, Colours, FullBsdf, FullMeasurement, HemisphericalRow, Incidence, Symmetry, symmetries};
pub(crate) use grazing::hemisphere;
pub use grazing::{GrazingGain, grazing_gains, grazing_notice, white_albedo};
pub use inputs::{input_files, sample_files};
pub use light::{FactorCloth, VolumetricCloth};
pub(crate) use light::{LitBatch, LitViews};
pub use memory::{Stage, bytes as memory_bytes, check_memory, refuse_beyond};
pub use plan::{Plan, RunError, medium, study_notices};
pub(crate) use plan::{dye_on, medium_spec};
pub use reabsorb::{Notice, NoticeKind, Reabsorbed, reabsorb};
pub use readings::report_geometries;
pub use report::report;
pub use simulate::{Batch, Simulation, Simulator, energy_rows, simulate};
pub use state::StateFile;
pub use stop::{Precision, PrecisionError, StopRule, StoppedBy, Tolerance, Watched};
pub use trace::{YarnBatch, YarnSums, YarnTracer, trace_yarn};
pub use watch::Watch;

/// Told of finished work, in shares of the whole that sum to 1.
pub type Progress<'a> = &'a (dyn Fn(f64) + Sync);
