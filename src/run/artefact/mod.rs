//! Files of the yarn's trace, written and read back: the trace file, shards of it, and the state of an unfinished run.

mod arrays;
mod catalogue;
mod layout;
mod shard;
mod state;
mod tables;

pub use catalogue::{BatchTables, MeanTables, Quantities, SumTables};
pub use layout::{MediumValues, YarnAxes, YarnLayout, YarnSettings};
pub(super) use shard::ShardWriter;
pub use shard::merge_shards;
pub use state::{YarnBatch, YarnSums};
pub use tables::{LengthTable, TraceTable};

use super::{RunError, energy_rows};
use crate::artefact::{ArtefactError, ArtefactKind, Reader};
use crate::report::EnergyRow;
use crate::transport::{Column, Estimate};
use arrays::{ArrayEntry, ArrayValues, write};
use catalogue::{DIRECT_SYSTEMATIC, ENERGY, ENERGY_SYSTEMATIC, Part};
use layout::parse;
use std::path::Path;

/// What `trace` finds out about a study's yarn, and the content of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnArtefact {
    pub layout: YarnLayout,
    /// Batches that were traced.
    pub batches: usize,
    /// The ledger: wavelength × incident direction, mirrored ones included.
    pub energy: Vec<EnergyRow>,
    pub tables: MeanTables,
    /// After a change of absorption only.
    pub systematic: Option<Systematic>,
}

/// What a change of absorption adds to the standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Systematic {
    /// Of f*, 1/sr: cell × wavelength.
    pub direct: Vec<f32>,
    /// Of the ledger: traced direction × wavelength × (ballistic, scattered). Absorbed light has the sum of both.
    pub energy: Vec<f32>,
}

impl YarnArtefact {
    pub fn new(layout: YarnLayout, sums: YarnSums) -> Self {
        Self {
            batches: sums.ledgers.len(),
            energy: energy_rows(&layout.axes.wavelength_nm, &layout.incident, &sums.ledgers),
            layout,
            tables: sums.tables.into(),
            systematic: None,
        }
    }

    /// Writes the file whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), RunError> {
        let layout = &self.layout;
        let mut entries: Vec<ArrayEntry> = energy_names()
            .into_iter()
            .zip([|of: Estimate| of.value, |of: Estimate| of.se])
            .map(|(name, part)| {
                let values = self.energy.iter().flat_map(|row| row.columns().map(part));
                let values = ArrayValues::F64(values.collect());
                ENERGY.entry(layout, name, values)
            })
            .collect();
        entries.extend(self.tables.entries(layout, Part::Means));
        if let Some(systematic) = &self.systematic {
            for (row, values) in [
                (DIRECT_SYSTEMATIC, &systematic.direct),
                (ENERGY_SYSTEMATIC, &systematic.energy),
            ] {
                entries.push(row.entry(layout, row.name.into(), values.into()));
            }
        }
        let header = serde_json::json!({ "batches": self.batches, "axes": layout.axes });
        write(path, ArtefactKind::Artefact, layout, &header, entries)
    }

    /// Reads a file back, bit for bit.
    pub fn read(path: &Path) -> Result<Self, RunError> {
        Ok(Self::read_with_digest(path)?.0)
    }

    /// The same with the file's SHA-256 in hexadecimal.
    pub fn read_with_digest(path: &Path) -> Result<(Self, String), RunError> {
        let mut file = Reader::open(path, ArtefactKind::Artefact)?;
        let layout = YarnLayout::read(path, ArtefactKind::Artefact, &file)?;
        let batches = parse(
            path,
            ArtefactKind::Artefact,
            "header.batches",
            &file.header()["batches"],
        )?;
        let energy = read_energy(&mut file, &layout)?;
        let traced = layout.settings.reabsorbed.is_empty();
        let tables = MeanTables::read(&mut file, &layout, Part::Means, traced)?;
        let systematic = if traced {
            None
        } else {
            Some(Systematic {
                direct: file.array(DIRECT_SYSTEMATIC.name, &DIRECT_SYSTEMATIC.shape(&layout))?,
                energy: file.array(ENERGY_SYSTEMATIC.name, &ENERGY_SYSTEMATIC.shape(&layout))?,
            })
        };
        let artefact = Self {
            batches,
            energy,
            tables,
            systematic,
            layout,
        };
        Ok((artefact, file.sha256()))
    }
}

/// Names of the arrays of the ledger: means and standard errors.
fn energy_names() -> [String; 2] {
    ["", "_se"].map(|part| format!("{}{part}", ENERGY.name))
}

fn read_energy(file: &mut Reader, layout: &YarnLayout) -> Result<Vec<EnergyRow>, ArtefactError> {
    let shape = ENERGY.shape(layout);
    let [mean, se] = energy_names().map(|name| file.array::<f64>(&name, &shape));
    let (mean, se) = (mean?, se?);
    let axes = &layout.axes;
    let directions = axes.incident_deg.len();
    let rows = std::iter::zip(mean.as_chunks::<{ Column::COUNT }>().0, se.as_chunks().0);
    let row = |(i, (mean, se)): (usize, (&[f64; Column::COUNT], &[f64; Column::COUNT]))| {
        let columns = std::array::from_fn(|k| Estimate {
            value: mean[k],
            se: se[k],
        });
        let (wavelength, direction) = (i / directions, i % directions);
        EnergyRow::new(axes.wavelength_nm[wavelength], axes.incident_deg[direction], columns)
    };
    Ok(rows.enumerate().map(row).collect())
}
