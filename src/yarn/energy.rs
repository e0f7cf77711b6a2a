use super::tracer::{LightSource, Tracer};
use super::{Effort, IncidentGrid, LengthBins, Yarn, YarnError};
use crate::geometry::Vec3;
use crate::transport::{ENTRY_COORDINATES, Entry, Ledger, Purpose};
use rayon::prelude::*;

/// Traces the energy ledger of light that meets the yarn from each of the incident directions. By the cylinder's
/// symmetry one point of entry represents all.
pub struct EnergyTracer<'a> {
    tracer: Tracer<'a, Point>,
    lengths: Option<LengthBins>,
}

/// Light source that illuminates one point of a yarn; a part is one of the incident directions.
struct Point {
    position: Vec3,
    incident: IncidentGrid,
}

impl LightSource for Point {
    fn purpose(&self) -> Purpose {
        Purpose::Energy
    }

    fn entry(&self, part: usize, _: &[f64; ENTRY_COORDINATES]) -> Entry {
        Entry {
            position: self.position,
            normal: Vec3::z(),
            omega_in: self.incident.traced_direction(part),
        }
    }
}

/// Result of one batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyBatch {
    /// Ledgers, traced direction × wavelength (fastest).
    pub ledgers: Vec<Ledger>,
    /// Light that left, by path length; empty without bins: traced direction × wavelength × bin of the fractions
    /// (ballistic, scattered) and of the fractions times path length in mm.
    pub lengths: Vec<[f64; 4]>,
}

impl<'a> EnergyTracer<'a> {
    /// `effort` gives the paths for each traced direction.
    pub fn new(
        yarn: &'a Yarn,
        incident: IncidentGrid,
        effort: Effort,
        lengths: Option<LengthBins>,
    ) -> Result<Self, YarnError> {
        let point = Point {
            position: yarn.cylinder.at(0.0),
            incident,
        };
        Ok(Self {
            tracer: Tracer::new(yarn, point, effort)?,
            lengths,
        })
    }

    /// Traces one batch for every traced direction.
    pub fn batch(&self, batch: usize) -> EnergyBatch {
        let directions: Vec<EnergyBatch> = (0..self.tracer.source.incident.traced())
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
        let share = self.tracer.share_of_path();
        let bins = self.lengths.as_ref().map_or(0, LengthBins::bins);
        let mut lengths = vec![[0.0; 4]; self.tracer.wavelengths() * bins];
        let ledgers = self.tracer.part(batch, direction, |exit, here| {
            if let Some(of) = &self.lengths {
                let bin = of.bin(exit.length_mm);
                let place = usize::from(exit.scattered);
                for (weight, row) in exit
                    .weights
                    .iter()
                    .zip(lengths[here.start * bins..].chunks_exact_mut(bins))
                {
                    row[bin][place] += share * weight;
                    row[bin][place + 2] += share * weight * exit.length_mm;
                }
            }
        });
        EnergyBatch { ledgers, lengths }
    }
}
