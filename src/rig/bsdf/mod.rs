//! The full BSDF of the woven cloth: reflection and transmission over both hemispheres, at every wavelength.
//!
//! Coordinates are those of the cloth: +z out of its front, x along the warp, y along the weft. f does not include
//! light that meets no yarn: it passes straight through the gaps and is a separate fraction.

mod cells;
mod hemispherical;
mod size;
mod symmetry;
mod tables;

pub use cells::Cells;
pub use hemispherical::HemisphericalRow;
pub use symmetry::{Symmetry, symmetries};
pub use tables::Colours;

use super::RigError;
use crate::cloth::light::{Beam, ClothBatch};
use crate::formats::{Scatter, Side};
use crate::spectrum::WavelengthGrid;
use crate::transport::{BatchSums, Estimate, Purpose, Stream};
use rayon::prelude::*;

/// Directions, sides, symmetries and batches of a measurement.
#[derive(Clone, Debug)]
pub struct FullMeasurement {
    cells: Cells,
    symmetries: Vec<Symmetry>,
    sides: Vec<Side>,
    batches: usize,
    seed: u64,
    grid: WavelengthGrid,
}

/// Result for light from one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Side the light comes from.
    pub side: Side,
    /// Incident cell, an index into [`Cells`].
    pub cell: usize,
    /// Fractions of the beam in each bin: bin × wavelength (fastest).
    caught: BatchSums,
    /// [`hemispherical::QUANTITIES`] for each wavelength.
    ledger: BatchSums,
}

/// BSDF f between all pairs of directions, 1/sr, with standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct FullBsdf {
    cells: Cells,
    sides: Vec<Side>,
    grid: WavelengthGrid,
    incidences: Vec<Incidence>,
    /// For each side and incident cell, the traced incidence that represents it and the symmetry that maps it there.
    placed: Vec<(usize, Symmetry)>,
}

/// Incidences to trace, and for each side and incident cell the one that represents it and the symmetry that maps it
/// there.
#[derive(Default)]
struct Orbits {
    traced: Vec<(Side, usize)>,
    placed: Vec<(usize, Symmetry)>,
}

/// Largest number of values of one table, 0.4 GB.
const MOST_VALUES: usize = 50_000_000;

impl FullMeasurement {
    /// Plans a measurement. `symmetries` is a group that includes the identity; one incidence is traced for all its
    /// images. With `back`, light also comes from the back.
    ///
    /// # Errors
    /// [`RigError`] if the tables would hold more than 50 million values.
    pub fn new(
        cells: Cells,
        symmetries: Vec<Symmetry>,
        back: bool,
        batches: usize,
        seed: u64,
        grid: &WavelengthGrid,
    ) -> Result<Self, RigError> {
        let found = cells.incident() * cells.count() * 2 * grid.len();
        if found > MOST_VALUES {
            return Err(RigError::TooManyValues {
                found,
                most: MOST_VALUES,
            });
        }
        Ok(Self {
            cells,
            symmetries,
            sides: if back {
                vec![Side::Front, Side::Back]
            } else {
                vec![Side::Front]
            },
            batches,
            seed,
            grid: grid.clone(),
        })
    }

    /// Image of an incidence under a symmetry.
    fn image(&self, (side, cell): (Side, usize), symmetry: &Symmetry) -> (Side, usize) {
        let side = match (side, symmetry.flip[2]) {
            (side, false) => side,
            (Side::Front, true) => Side::Back,
            (Side::Back, true) => Side::Front,
        };
        (side, self.cells.image(cell, symmetry))
    }

    fn orbits(&self) -> Orbits {
        let Orbits { mut traced, mut placed } = Orbits::default();
        for &side in &self.sides {
            for cell in 0..self.cells.incident() {
                let known = self.symmetries.iter().find_map(|symmetry| {
                    let image = self.image((side, cell), symmetry);
                    Some((traced.iter().position(|of| *of == image)?, *symmetry))
                });
                placed.push(known.unwrap_or((traced.len(), Symmetry::IDENTITY)));
                if known.is_none() {
                    traced.push((side, cell));
                }
            }
        }
        Orbits { traced, placed }
    }

    /// Number of traced incidences, and number of bins for each.
    pub fn size(&self) -> [usize; 2] {
        [self.orbits().traced.len(), 2 * self.cells.count()]
    }

    /// Traces every batch of every incidence with `light`, which returns batch `n` of a beam at all wavelengths and
    /// must depend on nothing else: the result is then the same for any number of threads. `progress` receives
    /// increments that add up to 1.
    pub fn measure(
        &self,
        light: impl Fn(&Beam, &Cells, usize) -> ClothBatch + Sync,
        progress: &(dyn Fn(f64) + Sync),
    ) -> FullBsdf {
        let Orbits { traced, placed } = self.orbits();
        let step = 1.0 / (traced.len() * self.batches) as f64;
        let incidences = traced.into_par_iter().map(|(side, cell)| {
            let fixing: Vec<&Symmetry> = self
                .symmetries
                .iter()
                .filter(|symmetry| self.image((side, cell), symmetry) == (side, cell))
                .collect();
            let batches: Vec<ClothBatch> = (0..self.batches)
                .into_par_iter()
                .map(|batch| {
                    let back = side == Side::Back;
                    let number = cell + if back { self.cells.count() } else { 0 };
                    let stream = Stream::open(self.seed, Purpose::Incidence, number, 0, 0);
                    let mut omega_in = self.cells.towards_light(cell, batch, self.batches, stream);
                    if back {
                        omega_in.z = -omega_in.z;
                    }
                    let traced = light(&Beam { omega_in, number }, &self.cells, batch);
                    progress(step);
                    traced
                })
                .collect();
            let mut caught = BatchSums::zeros(2 * self.cells.count() * self.grid.len());
            let mut ledger = BatchSums::zeros(hemispherical::QUANTITIES * self.grid.len());
            for batch in &batches {
                caught.add(&self.symmetrised(&batch.caught, &fixing));
                ledger.add(&hemispherical::quantities(&batch.ledger));
            }
            Incidence {
                side,
                cell,
                caught,
                ledger,
            }
        });
        FullBsdf {
            cells: self.cells.clone(),
            sides: self.sides.clone(),
            grid: self.grid.clone(),
            incidences: incidences.collect(),
            placed,
        }
    }

    /// Mean of the scored light over the symmetries that leave the incident direction unchanged.
    fn symmetrised(&self, caught: &[Vec<f64>], fixing: &[&Symmetry]) -> Vec<f64> {
        let wavelengths = self.grid.len();
        let mut mean = vec![0.0; caught.len() * wavelengths];
        for symmetry in fixing {
            for (bin, sums) in mean.chunks_exact_mut(wavelengths).enumerate() {
                let image = image_of_bin(&self.cells, bin, symmetry);
                for (sum, fraction) in sums.iter_mut().zip(&caught[image]) {
                    *sum += fraction / fixing.len() as f64;
                }
            }
        }
        mean
    }
}

fn image_of_bin(cells: &Cells, bin: usize, symmetry: &Symmetry) -> usize {
    let below = (bin >= cells.count()) != symmetry.flip[2];
    usize::from(below) * cells.count() + cells.image(bin % cells.count(), symmetry)
}

impl FullBsdf {
    /// Cells of incident and outgoing directions.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// Sides from which light was measured.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Wavelength grid of the values.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// The traced incidences.
    pub fn incidences(&self) -> &[Incidence] {
        &self.incidences
    }

    /// f in 1/sr at each wavelength, from incident cell `incident` of a side to cell `exiting`. Empty for a side that
    /// was not measured.
    pub fn bsdf(&self, side: Side, incident: usize, scatter: Scatter, exiting: usize) -> Vec<Estimate> {
        let Some((incidence, symmetry)) = self.traced_for(side, incident) else {
            return Vec::new();
        };
        let above = (side == Side::Front) == (scatter == Scatter::Reflection);
        let bin = exiting + if above { 0 } else { self.cells.count() };
        let image = image_of_bin(&self.cells, bin, &symmetry);
        let per_sr = 1.0 / self.cells.projected_solid_angle(exiting);
        let wavelengths = self.grid.len();
        (image * wavelengths..(image + 1) * wavelengths)
            .map(|i| {
                let Estimate { value, se } = incidence.caught.estimate(i);
                Estimate {
                    value: value * per_sr,
                    se: se * per_sr,
                }
            })
            .collect()
    }

    fn traced_for(&self, side: Side, incident: usize) -> Option<(&Incidence, Symmetry)> {
        let place = self.sides.iter().position(|s| *s == side)?;
        let (traced, symmetry) = self.placed.get(place * self.cells.incident() + incident)?;
        Some((&self.incidences[*traced], *symmetry))
    }
}
