//! The program as a user runs it.

#[path = "../support/batch_statistics.rs"]
mod batch_statistics;
#[path = "../support/command.rs"]
mod command;
#[path = "../support/golden.rs"]
mod golden;
#[path = "../support/runs.rs"]
mod runs;

mod bsdf;
mod check_gates;
mod check_sample;
mod commands;
mod examples;
mod fit;
mod formats;
mod formats_usual;
mod memory;
mod no_nan;
mod outputs;
mod reabsorption;
mod report_chain;
mod resume;
mod run_limits;
mod shards;
mod sweep;
mod woven;
