//! Laws: energy, reciprocity, normalisation, symmetry, statistics, and the order of the source itself.

#[path = "../support/batch_statistics.rs"]
mod batch_statistics;

mod batches;
mod classical_models;
mod cloth_geometry;
mod cloth_gloss;
mod cloth_media;
mod cloth_rays;
mod cloth_sections;
mod cloth_tubes;
mod connected_light;
mod coverage;
mod designs;
mod estimators;
mod fibre_gloss;
mod fit_readings;
mod least_squares;
mod physical_fit;
mod rig_view;
mod rivals;
mod shading;
mod stop_rules;
mod structure;
mod study;
mod transport;
mod verdicts;
mod woven;
mod woven_views;
mod yarn;
mod yarn_scatter;
