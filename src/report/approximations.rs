//! What each approximation of the light in the cloth costs, as rows of tables.

use crate::compare::Channel;
use crate::number::nan_from_null;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Tables of `report --approximations`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approximations {
    pub rows: Vec<ApproximationRow>,
    pub locality: Vec<LocalityRow>,
}

/// Mean brightness factor over the views of one incidence, by one way to shade or to measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ApproximationRow {
    #[serde(deserialize_with = "nan_from_null")]
    pub theta_i_deg: f64,
    pub channel: Channel,
    /// `classical`, `direct` (f* in the sun alone), `all-bounces` (f* from yarn to yarn), `volumetric`, or `measured`
    /// where the sample has a reading at every view.
    pub source: Cow<'static, str>,
    /// Not normalised.
    #[serde(deserialize_with = "nan_from_null")]
    pub mean_beta: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub mean_beta_se: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub over_volumetric: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub over_volumetric_se: f64,
}

/// How far along the yarn scattered light leaves from where it came in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalityRow {
    #[serde(deserialize_with = "nan_from_null")]
    pub wavelength_nm: f64,
    /// Fractions of the scattered light that leave farther away than half the distance of neighbouring crossings, than
    /// all of it, and than 8 yarn radii.
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_half_spacing: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_half_spacing_se: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_spacing: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_spacing_se: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_8_radii: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub beyond_8_radii_se: f64,
}
