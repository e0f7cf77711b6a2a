use crate::artefact::{ArtefactError, ArtefactKind, Identity, Reader};
use crate::optics::Medium;
use crate::report::InputDigest;
use crate::run::plan::{bssrdf_surface, factor_grid, incident_grid};
use crate::run::{Reabsorbed, RunError};
use crate::study::{Study, study_of_any_age};
use crate::yarn::{BssrdfGrid, IncidentGrid, LengthBins, YarnResponseGrid};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// Everything that the numbers of a trace of the yarn depend on: the identity of its files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct YarnSettings {
    #[serde(deserialize_with = "study_of_any_age")]
    pub study: Study,
    /// Digests of the tables and files that went in.
    pub inputs: Vec<InputDigest>,
    /// The medium that followed from them, so that a shard made with another C library is refused. The serialised name
    /// sorts it behind the study, whose keys messages name first where two files differ.
    #[serde(rename = "traced_medium")]
    pub medium: MediumValues,
    /// Later changes of absorption, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reabsorbed: Vec<Reabsorbed>,
}

/// The yarn's medium as it was traced, a value for each wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MediumValues {
    pub wavelength_nm: Vec<f64>,
    pub host_index: Vec<f64>,
    pub mu_s_per_mm: Vec<f64>,
    pub mu_a_per_mm: Vec<f64>,
}

impl From<&Medium> for MediumValues {
    fn from(medium: &Medium) -> Self {
        Self {
            wavelength_nm: medium.grid().nm().to_vec(),
            host_index: medium.host_index().to_vec(),
            mu_s_per_mm: medium.mu_s_per_mm().to_vec(),
            mu_a_per_mm: medium.mu_a_per_mm().to_vec(),
        }
    }
}

/// Values along the axes of the tables, for readers without this library.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct YarnAxes {
    pub wavelength_nm: Vec<f64>,
    /// Edges of the cells of the light's tilt out of the yarn's normal plane, one more than cells.
    pub tilt_edges_deg: Vec<f64>,
    /// Upper edges of the cells of z > 0; the same below 0, and one overflow cell at either end.
    pub z_edges_mm: Vec<f64>,
    /// Upper edges of the bins of path length, but for the last, which has none.
    pub length_edges_mm: Vec<f64>,
    /// Every incident direction of the ledger, mirrored ones included: zenith angle, azimuth from tangent to axis.
    pub incident_deg: Vec<[f64; 2]>,
}

/// Settings and axes of one study's tables, and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnLayout {
    pub settings: YarnSettings,
    pub axes: YarnAxes,
    pub incident: IncidentGrid,
    pub factor_grid: YarnResponseGrid,
    /// Traced incident direction × exit azimuth × z × exit cell × wavelength.
    pub bssrdf_shape: [usize; 5],
}

impl YarnLayout {
    /// `bssrdf` and `lengths` are the axes that the settings alone do not give.
    pub fn new(
        settings: YarnSettings,
        incident: IncidentGrid,
        factor: YarnResponseGrid,
        bssrdf: &BssrdfGrid,
        lengths: &LengthBins,
    ) -> Self {
        let tilt_edges = (0..factor.tilts()).map(|k| factor.tilt_edges(k)[0]);
        let last = factor.tilt_edges(factor.tilts() - 1)[1];
        Self {
            axes: YarnAxes {
                wavelength_nm: settings.medium.wavelength_nm.clone(),
                tilt_edges_deg: tilt_edges.chain([last]).map(f64::to_degrees).collect(),
                z_edges_mm: bssrdf.z_edges_mm().to_vec(),
                length_edges_mm: lengths.edges_mm().to_vec(),
                incident_deg: (0..incident.len()).map(|i| incident.angles_deg(i)).collect(),
            },
            settings,
            incident,
            factor_grid: factor,
            bssrdf_shape: bssrdf.shape(),
        }
    }

    /// Reads the layout of a file whose header has the axes under `axes`.
    pub(super) fn read(path: &Path, kind: ArtefactKind, reader: &Reader) -> Result<Self, RunError> {
        let settings: YarnSettings = parse(path, kind, "identity", reader.identity().value())?;
        let axes: YarnAxes = parse(path, kind, "header.axes", &reader.header()["axes"])?;
        let trace = &settings.study.trace;
        settings.study.validate()?;
        let incident = incident_grid(trace)?;
        let factor_grid = factor_grid(trace)?;
        let surface = bssrdf_surface(trace)?;
        let wavelengths = axes.wavelength_nm.len();
        let medium = &settings.medium;
        let of_medium = [
            medium.wavelength_nm.len(),
            medium.host_index.len(),
            medium.mu_s_per_mm.len(),
            medium.mu_a_per_mm.len(),
        ];
        let z_cells = trace.z_cells as usize;
        if of_medium != [wavelengths; 4]
            || axes.tilt_edges_deg.len() != factor_grid.tilts() + 1
            || 2 * axes.z_edges_mm.len() != z_cells
            || axes.incident_deg.len() != incident.len()
        {
            return Err(damaged(path, kind, "axes that are not those of its study".into()));
        }
        Ok(Self {
            bssrdf_shape: [
                incident.traced(),
                surface.azimuths(),
                z_cells + 2,
                surface.exit().cells(),
                wavelengths,
            ],
            settings,
            axes,
            incident,
            factor_grid,
        })
    }

    pub fn identity(&self) -> Result<Identity, RunError> {
        Ok(Identity::new(self.settings.study.seed, &self.settings)?)
    }

    pub fn wavelengths(&self) -> usize {
        self.axes.wavelength_nm.len()
    }

    /// Batches of the whole study.
    pub fn batches(&self) -> usize {
        self.settings.study.trace.batches as usize
    }

    /// Bins of path length.
    pub fn bins(&self) -> usize {
        self.axes.length_edges_mm.len() + 1
    }
}

/// Parses a part of the JSON of a verified file.
pub(super) fn parse<T: serde::de::DeserializeOwned>(
    path: &Path,
    kind: ArtefactKind,
    what: &str,
    value: &Value,
) -> Result<T, RunError> {
    serde_json::from_value(value.clone())
        .map_err(|cause| damaged(path, kind, format!("`{what}` that cannot be read ({cause})")))
}

pub(super) fn damaged(path: &Path, kind: ArtefactKind, found: String) -> RunError {
    RunError::Artefact(ArtefactError::Damaged {
        path: path.to_owned(),
        kind,
        found,
    })
}
