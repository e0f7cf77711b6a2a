//! The full BSDF of the woven cloth: reflection and transmission over both hemispheres, at every wavelength.
//!
//! Coordinates are the cloth's own: +z out of its front, x along the warp, y along the weft. Light that meets no yarn is no
//! part of f: it goes straight through the gaps, a fraction of its own.

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

/// What is measured, and how often.
#[derive(Clone, Debug)]
pub struct FullMeasurement {
    cells: Cells,
    symmetries: Vec<Symmetry>,
    sides: Vec<Side>,
    batches: usize,
    seed: u64,
    grid: WavelengthGrid,
}

/// Light from one direction, and where it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Where it comes from.
    pub side: Side,
    /// Of [`Cells`].
    pub cell: usize,
    /// Fractions of the beam, bin slowest, wavelength fastest.
    caught: BatchSums,
    /// [`hemispherical::QUANTITIES`] for each wavelength.
    ledger: BatchSums,
}

/// f between all pairs of directions, with standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct FullBsdf {
    cells: Cells,
    sides: Vec<Side>,
    grid: WavelengthGrid,
    incidences: Vec<Incidence>,
    /// For each side and incident cell the incidence that was traced for it, and what takes it there.
    placed: Vec<(usize, Symmetry)>,
}

/// Incidences to be traced, and for each side and incident cell which of them stands for it and what takes it there.
#[derive(Default)]
struct Orbits {
    traced: Vec<(Side, usize)>,
    placed: Vec<(usize, Symmetry)>,
}

/// Most values of one table, 0.4 GB.
const MOST_VALUES: usize = 50_000_000;

impl FullMeasurement {
    /// Of a group of symmetries, the identity among them, one incidence is traced for all that they take it to. With
    /// `back` there is also light from the back.
    ///
    /// # Errors
    /// More values than memory should be asked for.
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

    /// The incidence a symmetry takes another to.
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

    /// Incidences that are traced, and bins that each is caught in.
    pub fn size(&self) -> [usize; 2] {
        [self.orbits().traced.len(), 2 * self.cells.count()]
    }

    /// Traces every batch of every incidence with `light`, which gives the numbered batch of a beam at all wavelengths and
    /// depends on nothing else: the result is the same for any number of threads. `progress` receives increments that add up to 1.
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

    /// The mean of what was caught over the symmetries that leave the light where it is.
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
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// Those that were traced.
    pub fn incidences(&self) -> &[Incidence] {
        &self.incidences
    }

    /// f in 1/sr at each wavelength, of light from an incident cell of a side towards a cell. Light from a side that was not
    /// measured has none.
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
