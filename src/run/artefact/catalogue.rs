//! The catalogue of what a trace of the yarn tallies. Trace file, shard and state are written and read by it alone: a
//! further quantity takes a row, a field of [`Quantities`] with its lines below, and the place that computes it.

use super::YarnLayout;
use super::arrays::{ArrayEntry, ArrayValues, Held, read_into};
use super::tables::{LengthTable, TraceTable};
use crate::artefact::{ArrayInfo, ArtefactError, Reader};
use crate::transport::{BatchSums, Column, Fraction, FractionList};
use crate::yarn::{LengthSums, LengthTally};

/// A quantity of a trace: what its arrays hold, along which axes, and how files name them.
pub(super) struct Row {
    pub name: &'static str,
    pub unit: &'static str,
    /// Axes in words, first axis first.
    pub axes: &'static str,
    /// Cells along these axes.
    pub shape: fn(&YarnLayout) -> Vec<usize>,
    /// What a further, last axis counts, each component by its name; without any there is no such axis.
    pub components: fn() -> Vec<&'static str>,
    /// Its name in a state.
    pub in_state: &'static str,
    /// Unit of the quantity times path length, of quantities that are split by path length.
    pub moment: Option<&'static str>,
    /// Whether it comes from the BSSRDF of a patch, which a change of absorption cannot follow.
    pub from_patch: bool,
}

/// Which arrays of a quantity a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// One batch of a shard.
    Batch(usize),
    /// Σ x and Σ x² over the batches of a state.
    Sums,
    /// Mean and standard error in a trace file.
    Means,
}

const PLAIN: Row = Row {
    name: "",
    unit: "",
    axes: "",
    shape: |_| Vec::new(),
    components: Vec::new,
    in_state: "",
    moment: None,
    from_patch: false,
};

/// f*, cell × wavelength.
const RESPONSE: Row = Row {
    unit: "1/sr",
    axes: "tilt, azimuth from the light 0..180 deg, exit cell (theta, phi), wavelength",
    shape: |layout| response(layout, None),
    ..PLAIN
};

/// Light that left, by path length: traced direction × wavelength × bin.
const ENERGY_BY_LENGTH: Row = Row {
    name: "energy_by_length",
    in_state: "energy_by_length",
    unit: "fraction of the incident flux; the same times mm",
    axes: "traced direction, wavelength, bin of path length",
    shape: |layout| vec![layout.incident.traced(), layout.wavelengths(), layout.bins()],
    components: || vec!["ballistic", "scattered", "ballistic moment", "scattered moment"],
    ..PLAIN
};

const DIRECT: Row = Row {
    name: "radiance_factor_direct",
    in_state: "radiance_factor_direct",
    ..RESPONSE
};

const SUMMED: Row = Row {
    name: "radiance_factor_bssrdf",
    in_state: "radiance_factor_bssrdf",
    from_patch: true,
    ..RESPONSE
};

const BSSRDF: Row = Row {
    name: "bssrdf_fraction",
    in_state: "bssrdf_fraction",
    unit: "fraction of the flux incident on the patch",
    axes: "traced direction, exit azimuth, z (overflow first and last), exit cell (theta, phi), wavelength",
    shape: |layout| layout.bssrdf_shape.to_vec(),
    from_patch: true,
    ..PLAIN
};

const BY_LENGTH: Row = Row {
    name: "radiance_factor_by_length",
    in_state: "by_length",
    unit: "1/sr",
    axes: "tilt, azimuth from the light 0..180 deg, exit cell (theta, phi), bin of path length, wavelength",
    shape: |layout| response(layout, Some(layout.bins())),
    moment: Some("mm/sr"),
    ..PLAIN
};

/// The ledger of one batch, in shards and states; fractions that follow from others are left out.
pub(super) const LEDGERS: Row = Row {
    name: "ledgers",
    unit: "fraction of the incident flux",
    axes: "traced direction, wavelength",
    shape: |layout| vec![layout.incident.traced(), layout.wavelengths()],
    components: || Fraction::ALL.iter().map(|fraction| fraction.name()).collect(),
    ..PLAIN
};

/// The ledger of a trace file, mirrored directions included.
pub(super) const ENERGY: Row = Row {
    name: "energy",
    axes: "wavelength, incident direction",
    shape: |layout| vec![layout.wavelengths(), layout.incident.len()],
    components: || Column::ALL.iter().map(|column| column.name()).collect(),
    ..LEDGERS
};

/// Systematic error of f* after a change of absorption.
pub(super) const DIRECT_SYSTEMATIC: Row = Row {
    name: "radiance_factor_direct_systematic",
    ..RESPONSE
};

/// Systematic error of the ledger after a change of absorption.
pub(super) const ENERGY_SYSTEMATIC: Row = Row {
    name: "energy_systematic",
    components: || vec!["ballistic", "scattered"],
    ..LEDGERS
};

/// Cells of f*, with the bins of path length before the wavelengths where it is split by them.
fn response(layout: &YarnLayout, bins: Option<usize>) -> Vec<usize> {
    let grid = &layout.factor_grid;
    let cells = [grid.tilts(), grid.azimuths(), grid.surface().exit().cells()];
    cells.into_iter().chain(bins).chain([layout.wavelengths()]).collect()
}

impl Row {
    /// Cells along all axes, components included.
    pub fn shape(&self, layout: &YarnLayout) -> Vec<usize> {
        let components = Some((self.components)().len()).filter(|&count| count > 0);
        (self.shape)(layout).into_iter().chain(components).collect()
    }

    pub fn values(&self, layout: &YarnLayout) -> usize {
        self.shape(layout).iter().product()
    }

    /// One of its arrays, by its name in the file.
    pub fn entry<'a>(&self, layout: &YarnLayout, name: String, values: ArrayValues<'a>) -> ArrayEntry<'a> {
        let components = (self.components)().join(", ");
        let info = ArrayInfo {
            name,
            unit: self.unit.into(),
            axes: match components.as_str() {
                "" => self.axes.into(),
                _ => format!("{}; {components}", self.axes),
            },
            shape: self.shape(layout),
            element: values.element(),
        };
        ArrayEntry { info, values }
    }

    /// Names and units of its arrays, in the order of [`Held`].
    pub fn arrays(&self, part: Part) -> Vec<(String, &'static str)> {
        let amounts = match part {
            Part::Batch(number) => vec![format!("{number}.{}", self.name)],
            Part::Sums => ["sum", "square"].map(|of| format!("{}.{of}", self.in_state)).into(),
            Part::Means => vec![self.name.to_owned(), format!("{}_se", self.name)],
        };
        let moment = self.moment.map(|unit| match part {
            Part::Batch(number) => (format!("{number}.{}_moment", self.name), unit),
            Part::Sums => (format!("{}.moment", self.in_state), unit),
            Part::Means => (format!("{}_moment", self.name), unit),
        });
        amounts
            .into_iter()
            .map(|name| (name, self.unit))
            .chain(moment)
            .collect()
    }
}

/// What is kept of each quantity at one stage of a trace: of a batch, as sums over batches, or as means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantities<Beam, Patch, Largest, ByLength> {
    /// What left by path length: traced direction × wavelength × bin × (ballistic, scattered, and both times path
    /// length), fractions of the incident flux and the same times mm.
    pub energy_by_length: Beam,
    /// f* of the direct simulation, 1/sr: cell × wavelength.
    pub direct: Beam,
    /// f* as the sum of the BSSRDF, 1/sr: cell × wavelength.
    pub summed: Patch,
    /// BSSRDF as fractions of the flux incident on the patch, axes as [`crate::yarn::BssrdfGrid`] says.
    pub bssrdf: Largest,
    /// f* of the direct simulation by path length: cell × bin × wavelength.
    pub by_length: ByLength,
}

/// Of one batch. The BSSRDF, the largest table by far, is rounded to single precision, far below the noise of a cell.
pub type BatchTables = Quantities<Vec<f64>, Vec<f64>, Vec<f32>, LengthTally>;

/// Sums over batches.
pub type SumTables = Quantities<BatchSums, BatchSums, BatchSums, LengthSums>;

/// Means and their standard errors. A change of absorption leaves no tables of the BSSRDF: path lengths of every cell
/// would be needed for them.
pub type MeanTables = Quantities<TraceTable, Option<TraceTable>, Option<TraceTable>, LengthTable>;

impl<Beam: Held, Patch: Held, Largest: Held, ByLength: Held> Quantities<Beam, Patch, Largest, ByLength> {
    fn rows(&self) -> [(&'static Row, &dyn Held); 5] {
        [
            (&ENERGY_BY_LENGTH, &self.energy_by_length),
            (&DIRECT, &self.direct),
            (&SUMMED, &self.summed),
            (&BSSRDF, &self.bssrdf),
            (&BY_LENGTH, &self.by_length),
        ]
    }

    fn rows_mut(&mut self) -> [(&'static Row, &mut dyn Held); 5] {
        [
            (&ENERGY_BY_LENGTH, &mut self.energy_by_length),
            (&DIRECT, &mut self.direct),
            (&SUMMED, &mut self.summed),
            (&BSSRDF, &mut self.bssrdf),
            (&BY_LENGTH, &mut self.by_length),
        ]
    }

    /// The arrays of a file in its order.
    pub(super) fn entries(&self, layout: &YarnLayout, part: Part) -> Vec<ArrayEntry<'_>> {
        let mut entries = Vec::new();
        for (row, held) in self.rows() {
            for ((name, unit), values) in std::iter::zip(row.arrays(part), held.values()) {
                let mut entry = row.entry(layout, name, values);
                entry.info.unit = unit.into();
                entries.push(entry);
            }
        }
        entries
    }

    /// Reads the arrays of a file; those from a patch only where it has them.
    pub(super) fn read(
        file: &mut Reader,
        layout: &YarnLayout,
        part: Part,
        with_patch: bool,
    ) -> Result<Self, ArtefactError>
    where
        Self: Default,
    {
        let mut tables = Self::default();
        for (row, held) in tables.rows_mut() {
            if row.from_patch && !with_patch {
                continue;
            }
            for ((name, _), values) in std::iter::zip(row.arrays(part), held.values_mut()) {
                read_into(file, &name, &row.shape(layout), values)?;
            }
        }
        Ok(tables)
    }
}

impl SumTables {
    pub fn zeros(layout: &YarnLayout) -> Self {
        Self {
            energy_by_length: BatchSums::zeros(ENERGY_BY_LENGTH.values(layout)),
            direct: BatchSums::zeros(DIRECT.values(layout)),
            summed: BatchSums::zeros(SUMMED.values(layout)),
            bssrdf: BatchSums::zeros(BSSRDF.values(layout)),
            by_length: LengthSums::zeros(BY_LENGTH.values(layout)),
        }
    }

    /// Adds the next batch.
    pub fn add(&mut self, batch: &BatchTables) {
        self.energy_by_length.add(&batch.energy_by_length);
        self.direct.add(&batch.direct);
        self.summed.add(&batch.summed);
        self.bssrdf.add(&batch.bssrdf);
        self.by_length.add(&batch.by_length);
    }

    /// Sets the number of batches that sums read from a file are of.
    pub(super) fn set_batches(&mut self, batches: u64) {
        for (_, held) in self.rows_mut() {
            held.set_batches(batches);
        }
    }
}

impl From<SumTables> for MeanTables {
    /// Takes the sums apart, so that nothing is in memory twice.
    fn from(sums: SumTables) -> Self {
        Self {
            energy_by_length: sums.energy_by_length.into(),
            direct: sums.direct.into(),
            summed: Some(sums.summed.into()),
            bssrdf: Some(sums.bssrdf.into()),
            by_length: sums.by_length.into(),
        }
    }
}
