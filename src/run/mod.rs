//! A whole study: every stage in turn, from the study's values to the report's data.

mod approximations;
mod artefact;
mod batches;
mod cloth_keys;
mod curves;
mod effort;
mod energy;
mod error;
mod file_kind;
mod grazing;
mod inputs;
mod light;
mod light_orders;
mod media;
mod memory;
mod notices;
mod plan;
mod progress;
mod reabsorb;
mod reabsorbed;
mod readings;
mod report;
mod shard;
mod simulate;
mod simulator;
mod state;
mod stop;
mod sweep;
mod table1;
mod trace;
mod watch;
mod work;

pub use approximations::{approximations, check_approximations};
pub use artefact::{
    BatchTables, LengthTable, MeanTables, MediumValues, Quantities, SumTables, Systematic, TraceTable, YarnArtefact,
    YarnAxes, YarnBatch, YarnLayout, YarnSettings, YarnSums, merge_shards,
};
pub use batches::{Gather, Outcome, Schedule, gather};
pub use curves::SpectralCurves;
pub(crate) use curves::{directions, gloss};
pub use energy::energy_rows;
pub use error::RunError;
pub use file_kind::{FileKind, OtherKind};
pub(crate) use grazing::hemisphere;
pub use grazing::{grazing_gains, grazing_notice, white_albedo};
pub use inputs::{input_files, sample_files};
pub use light::{FactorCloth, volumetric_cloth};
pub use light_orders::light_orders;
pub use media::medium;
pub(crate) use media::{dye_on, medium_spec};
pub use memory::{Stage, bytes as memory_bytes, check_memory, refuse_beyond};
pub use notices::study_notices;
pub use plan::Plan;
pub use progress::Progress;
pub use reabsorb::reabsorb;
pub use reabsorbed::{NoticeKind, Reabsorbed, ReabsorptionNotice};
pub use readings::report_geometries;
pub use report::{Request, report};
pub use shard::{Shard, ShardError};
pub use simulate::{Simulation, simulate};
pub use simulator::{Batch, Simulator};
pub use state::StateFile;
pub use stop::{Precision, PrecisionError, StopRule, StoppedBy, Tolerance, Watched};
pub use sweep::Sweep;
pub use trace::{YarnTracer, trace_shard, trace_yarn};
pub use watch::Watch;
