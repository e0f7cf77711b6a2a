use super::{Effort, IncidentGrid, LengthBins, Sharing, Yarn, YarnError};
use crate::geometry::Vec3;
use crate::transport::{Entry, Ledger, Purpose, Stream};
use rayon::prelude::*;

/// The energy ledger of light that meets the yarn from each of the incident directions. By the cylinder's symmetry one
/// point of entry stands for all.
pub struct EnergyTracer<'a> {
    yarn: &'a Yarn,
    sharing: Vec<Sharing<'a>>,
    incident: IncidentGrid,
    effort: Effort,
    lengths: Option<LengthBins>,
}

/// Result of one batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyBatch {
    /// Traced direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    /// What left by path length, where it was asked for: traced direction × wavelength × bin of the fractions
    /// (ballistic, scattered) and of the fractions times path length in mm.
    pub lengths: Vec<[f64; 4]>,
}

impl<'a> EnergyTracer<'a> {
    pub fn new(
        yarn: &'a Yarn,
        incident: IncidentGrid,
        effort: Effort,
        lengths: Option<LengthBins>,
    ) -> Result<Self, YarnError> {
        Ok(Self {
            yarn,
            sharing: yarn.sharing()?,
            incident,
            effort,
            lengths,
        })
    }

    pub fn batch(&self, batch: usize) -> EnergyBatch {
        let directions: Vec<EnergyBatch> = (0..self.incident.traced())
            .into_par_iter()
            .map(|direction| self.direction(batch, direction))
            .collect();
        let mut whole = EnergyBatch::default();
        for direction in directions {
            whole.ledgers.extend(direction.ledgers);
            whole.lengths.extend(direction.lengths);
        }
        whole
    }

    fn direction(&self, batch: usize, direction: usize) -> EnergyBatch {
        let paths = self.effort.paths_per_batch;
        let scale = 1.0 / paths as f64;
        let bins = self.lengths.as_ref().map_or(0, LengthBins::bins);
        let entry = Entry {
            position: self.yarn.cylinder.at(0.0),
            normal: Vec3::z(),
            omega_in: self.incident.traced_direction(direction),
        };
        let mut result = EnergyBatch::default();
        for sharing in &self.sharing {
            let stream = Stream::open(self.effort.seed, Purpose::Energy, direction, batch, sharing.first);
            let mut lengths = vec![[0.0; 4]; sharing.interior.wavelengths() * bins];
            let traced = self.yarn.walk(&sharing.interior).trace(
                stream,
                paths,
                |_| entry,
                |exit| {
                    if let Some(of) = &self.lengths {
                        let bin = of.bin(exit.length_mm);
                        let place = usize::from(exit.scattered);
                        for (weight, row) in exit.weights.iter().zip(lengths.chunks_exact_mut(bins)) {
                            row[bin][place] += scale * weight;
                            row[bin][place + 2] += scale * weight * exit.length_mm;
                        }
                    }
                },
            );
            result
                .ledgers
                .extend(traced.ledgers.iter().map(|sum| sum.scaled(scale)));
            result.lengths.extend(lengths);
        }
        result
    }
}
