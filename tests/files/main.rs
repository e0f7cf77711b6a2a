//! Files that are read and written: formats, samples, spectra, studies, reports.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/golden.rs"]
mod golden;
#[path = "../support/report_data.rs"]
mod report_data;

mod artefact;
mod formats_clients;
mod formats_read;
mod formats_refuse;
mod formats_ssdd;
mod formats_tables;
mod formats_write;
mod report;
mod report_graphs;
mod sample_bundled;
mod sample_load;
mod spectrum_tables;
mod study;
mod weave_drafts;
