//! Files of the yarn's trace, written and read back: the artefact, shards of it, and the state of an unfinished run.

mod batch_arrays;
mod layout;
mod shard;
mod state;

pub use layout::{MediumValues, YarnAxes, YarnLayout, YarnSettings};
pub use shard::{merge_shards, trace_shard};

use super::{RunError, YarnSums, energy_rows};
use crate::artefact::{ElementType, Kind, Reader, Writer};
use crate::report::EnergyRow;
use crate::transport::{BatchSums, Column, Estimate};
use crate::yarn::LengthSums;
use layout::{Array, parse};
use std::path::Path;

/// Means over the batches and their standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub mean: Vec<f64>,
    /// Single precision, as no more is known of an error.
    pub se: Vec<f32>,
}

impl From<BatchSums> for Table {
    fn from(sums: BatchSums) -> Self {
        let se = (0..sums.sum.len()).map(|i| sums.estimate(i).se as f32).collect();
        let n = sums.batches as f64;
        let mut mean = sums.sum;
        mean.iter_mut().for_each(|sum| *sum /= n);
        Self { mean, se }
    }
}

/// f* split by path length: cell × bin × wavelength. Single precision: its rounding is far below the noise of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthTable {
    /// f* of the paths of the bin, 1/sr; the bins add to f*.
    pub mean: Vec<f32>,
    pub se: Vec<f32>,
    /// Mean of f* times path length, mm/sr.
    pub moment_mm: Vec<f32>,
}

impl From<LengthSums> for LengthTable {
    fn from(sums: LengthSums) -> Self {
        let se = (0..sums.amount.len()).map(|i| sums.estimate(i).se as f32).collect();
        let mean = |mut sums: Vec<f32>, n: u64| {
            sums.iter_mut()
                .for_each(|sum| *sum = (f64::from(*sum) / n as f64) as f32);
            sums
        };
        Self {
            mean: mean(sums.amount, sums.batches),
            se,
            moment_mm: mean(sums.moment_mm, sums.batches),
        }
    }
}

/// What `trace` finds out about a study's yarn, and the content of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnArtefact {
    pub layout: YarnLayout,
    /// Batches that were traced.
    pub batches: usize,
    /// The ledger: wavelength × incident direction, mirrored ones included.
    pub energy: Vec<EnergyRow>,
    /// What left by path length: traced direction × wavelength × bin × (ballistic, scattered, ballistic times path length,
    /// scattered times path length), fractions of the incident flux and the same times mm.
    pub energy_by_length: Table,
    /// f* of the direct simulation, 1/sr: cell × wavelength.
    pub direct: Table,
    /// f* as the sum of the BSSRDF, 1/sr: cell × wavelength. Not there after a change of absorption, for which path lengths of
    /// every cell would be needed.
    pub summed: Option<Table>,
    /// BSSRDF as fractions of the flux incident on the patch, axes as [`crate::yarn::BssrdfGrid`] says. The same holds.
    pub bssrdf: Option<Table>,
    /// f* of the direct simulation by path length.
    pub by_length: LengthTable,
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
    /// Takes the sums apart, so that nothing is in memory twice.
    pub fn new(layout: YarnLayout, sums: YarnSums) -> Self {
        Self {
            batches: sums.ledgers.len(),
            energy: energy_rows(&layout.axes.wavelength_nm, &layout.incident, &sums.ledgers),
            layout,
            energy_by_length: sums.energy_by_length.into(),
            direct: sums.direct.into(),
            summed: Some(sums.summed.into()),
            bssrdf: Some(sums.bssrdf.into()),
            by_length: sums.by_length.into(),
            systematic: None,
        }
    }

    /// Writes the file whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), RunError> {
        let layout = &self.layout;
        let tables = self.tables();
        let [amount, moment] = layout.factor_by_length();
        let energy = energy(layout);
        let mut arrays = vec![
            energy.info("energy", ElementType::F64),
            energy.info("energy_se", ElementType::F64),
        ];
        for (name, array, _) in &tables {
            arrays.push(array.info(*name, ElementType::F64));
            arrays.push(array.info(format!("{name}_se"), ElementType::F32));
        }
        arrays.push(amount.info("radiance_factor_by_length", ElementType::F32));
        arrays.push(amount.info("radiance_factor_by_length_se", ElementType::F32));
        arrays.push(moment.info("radiance_factor_by_length_moment", ElementType::F32));
        if self.systematic.is_some() {
            let array = layout.factor();
            arrays.push(array.info("radiance_factor_direct_systematic", ElementType::F32));
            arrays.push(layout.energy_systematic().info("energy_systematic", ElementType::F32));
        }
        let header = serde_json::json!({ "batches": self.batches, "axes": layout.axes });
        let mut file = Writer::create(path, Kind::Artefact, &layout.identity()?, &header, &arrays)?;
        file.append(
            "energy",
            self.energy.iter().flat_map(|row| columns(row).map(|of| of.value)),
        )?;
        file.append(
            "energy_se",
            self.energy.iter().flat_map(|row| columns(row).map(|of| of.se)),
        )?;
        for (name, _, table) in tables {
            file.append(name, table.mean.iter().copied())?;
            file.append(&format!("{name}_se"), table.se.iter().copied())?;
        }
        let lengths = &self.by_length;
        file.append("radiance_factor_by_length", lengths.mean.iter().copied())?;
        file.append("radiance_factor_by_length_se", lengths.se.iter().copied())?;
        file.append("radiance_factor_by_length_moment", lengths.moment_mm.iter().copied())?;
        if let Some(systematic) = &self.systematic {
            file.append("radiance_factor_direct_systematic", systematic.direct.iter().copied())?;
            file.append("energy_systematic", systematic.energy.iter().copied())?;
        }
        Ok(file.finish()?)
    }

    /// Reads a file back, bit for bit.
    pub fn read(path: &Path) -> Result<Self, RunError> {
        Ok(Self::read_with_digest(path)?.0)
    }

    /// The same with the file's SHA-256 in hexadecimal.
    pub fn read_with_digest(path: &Path) -> Result<(Self, String), RunError> {
        let mut file = Reader::open(path, Kind::Artefact)?;
        let layout = YarnLayout::read(path, Kind::Artefact, &file)?;
        let batches = parse(path, Kind::Artefact, "header.batches", &file.header()["batches"])?;
        let energy = {
            let shape = energy(&layout).shape;
            let mean: Vec<f64> = file.array("energy", &shape)?;
            let se: Vec<f64> = file.array("energy_se", &shape)?;
            rows(&layout, &mean, &se)
        };
        let mut table = |name: &str, array: Array| -> Result<Table, RunError> {
            Ok(Table {
                mean: file.array(name, &array.shape)?,
                se: file.array(&format!("{name}_se"), &array.shape)?,
            })
        };
        let energy_by_length = table("energy_by_length", layout.energy_by_length())?;
        let direct = table("radiance_factor_direct", layout.factor())?;
        let traced = layout.settings.reabsorbed.is_empty();
        let [summed, bssrdf] = if traced {
            let summed = table("radiance_factor_bssrdf", layout.factor())?;
            [Some(summed), Some(table("bssrdf_fraction", layout.bssrdf())?)]
        } else {
            [None, None]
        };
        let systematic = if traced {
            None
        } else {
            Some(Systematic {
                direct: file.array("radiance_factor_direct_systematic", &layout.factor().shape)?,
                energy: file.array("energy_systematic", &layout.energy_systematic().shape)?,
            })
        };
        let [amount, moment] = layout.factor_by_length();
        let artefact = Self {
            batches,
            energy,
            energy_by_length,
            direct,
            summed,
            bssrdf,
            by_length: LengthTable {
                mean: file.array("radiance_factor_by_length", &amount.shape)?,
                se: file.array("radiance_factor_by_length_se", &amount.shape)?,
                moment_mm: file.array("radiance_factor_by_length_moment", &moment.shape)?,
            },
            systematic,
            layout,
        };
        Ok((artefact, file.sha256()))
    }

    /// Tables of double precision in the file's order.
    fn tables(&self) -> Vec<(&'static str, Array, &Table)> {
        let layout = &self.layout;
        let tables = [
            (
                "energy_by_length",
                layout.energy_by_length(),
                Some(&self.energy_by_length),
            ),
            ("radiance_factor_direct", layout.factor(), Some(&self.direct)),
            ("radiance_factor_bssrdf", layout.factor(), self.summed.as_ref()),
            ("bssrdf_fraction", layout.bssrdf(), self.bssrdf.as_ref()),
        ];
        let there = tables.into_iter();
        there
            .filter_map(|(name, array, table)| Some((name, array, table?)))
            .collect()
    }
}

fn energy(layout: &YarnLayout) -> Array {
    Array {
        unit: "fraction of the incident flux",
        axes: "wavelength, incident direction; reflected, ballistic, scattered, absorbed, roulette, residual, sharing",
        shape: vec![layout.wavelengths(), layout.incident.len(), Column::COUNT],
    }
}

/// Value and standard error of each column of a row.
fn columns(row: &EnergyRow) -> [Estimate; Column::COUNT] {
    Column::ALL.map(|column| row.column(column))
}

fn rows(layout: &YarnLayout, mean: &[f64], se: &[f64]) -> Vec<EnergyRow> {
    let directions = layout.axes.incident_deg.len();
    std::iter::zip(mean.as_chunks().0, se.as_chunks().0)
        .enumerate()
        .map(
            |(i, (mean, se)): (usize, (&[f64; Column::COUNT], &[f64; Column::COUNT]))| {
                let columns = std::array::from_fn(|k| Estimate {
                    value: mean[k],
                    se: se[k],
                });
                EnergyRow::new(
                    layout.axes.wavelength_nm[i / directions],
                    layout.axes.incident_deg[i % directions],
                    columns,
                )
            },
        )
        .collect()
}
