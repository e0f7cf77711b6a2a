use super::curves::{channels, gloss};
use super::readings::readings;
use super::{Plan, Precision, RunError, Tolerance, Watched};
use crate::compare::{Channel, reference};
use crate::rig::Geometry;
use crate::transport::Estimate;

/// Keeps, batch by batch, the quantities whose standard errors a stop rule watches.
///
/// Only Monte Carlo errors count, because more batches lower no others. If a report normalises the model, the
/// normalised values are watched, whose errors include that of the coefficient; the point that normalisation makes
/// exact is watched before normalisation. If the wavelengths carry no colour, the mean over them replaces the
/// luminance.
pub struct Watch<'a> {
    plan: &'a Plan,
    precision: Precision,
    /// Gloss at each geometry.
    gloss: Vec<f64>,
    /// Place of normal incidence and view.
    normal: Option<usize>,
    /// Place of the reading that the curves are normalised to, and its luminance.
    reference: Option<(usize, f64)>,
    /// Whether any batch has diffuse light at each geometry; gloss needs no tracing.
    hit: Vec<bool>,
    /// Of each batch: luminance at each geometry, or linear RGB of the diffuse light at the normal.
    batches: Vec<Vec<f64>>,
}

impl<'a> Watch<'a> {
    /// Without a given precision the relative one of the curves is reported.
    pub fn new(
        plan: &'a Plan,
        geometries: &[Geometry],
        precision: Option<Precision>,
        normalised: bool,
    ) -> Result<Self, RunError> {
        let precision = precision.unwrap_or(Precision {
            tolerance: Tolerance::Relative(0.0),
            of: Watched::Curves,
        });
        let normal = geometries.iter().position(|g| *g == Geometry::NORMAL);
        if precision.of == Watched::Ratios {
            if normal.is_none() {
                return Err(RunError::NoNormal);
            }
            plan.require_colour()?;
        }
        // As the report normalises: where there is no light there, its values are absolute.
        let measured = match normalised {
            true => readings(plan, geometries)?,
            false => Vec::new(),
        };
        let reference = reference(geometries, &measured)
            .and_then(|place| Some((place, measured[place]?.beta[Channel::Y as usize])))
            .filter(|(_, luminance)| *luminance > 0.0);
        Ok(Self {
            plan,
            precision,
            gloss: geometries.iter().map(|g| gloss(plan, *g)).collect(),
            normal,
            reference,
            hit: vec![false; geometries.len()],
            batches: Vec::new(),
        })
    }

    pub(super) fn precision(&self) -> Precision {
        self.precision
    }

    /// `diffuse` is β at [geometry][wavelength] of one batch.
    pub(super) fn add(&mut self, diffuse: &[Vec<f64>]) {
        let colour = &self.plan.colour;
        for (hit, beta) in self.hit.iter_mut().zip(diffuse) {
            *hit |= beta.iter().any(|b| *b != 0.0);
        }
        self.batches.push(match self.precision.of {
            Watched::Curves => std::iter::zip(diffuse, &self.gloss)
                .map(|(beta, gloss)| {
                    let total: Vec<f64> = beta.iter().map(|b| b + gloss).collect();
                    match colour.require() {
                        Ok(()) => colour.xyz(&total).y,
                        Err(_) => total.iter().sum::<f64>() / total.len() as f64,
                    }
                })
                .collect(),
            // A trace of the yarn alone watches the ledger.
            Watched::Scattered => Vec::new(),
            Watched::Ratios => {
                let normal = self.normal.and_then(|place| diffuse.get(place));
                normal.map_or_else(Vec::new, |beta| channels(colour, beta)[..3].to_vec())
            }
        });
    }

    /// Largest of the standard errors, as the precision counts them; none for fewer than two batches, and where no
    /// light was hit in as many as [`super::StopRule::LEAST_FOR_NOTHING`].
    pub(super) fn largest_error(&self) -> Option<f64> {
        if self.batches.len() < 2 {
            return None;
        }
        let of = |place: usize| self.batches.iter().map(move |batch| batch[place]);
        let unknown = Estimate { value: 0.0, se: 0.0 };
        let estimates: Vec<Estimate> = match (self.precision.of, self.normal, self.reference) {
            (Watched::Scattered, ..) => return None,
            (Watched::Ratios, Some(normal), _) if !self.hit[normal] => vec![unknown],
            (Watched::Ratios, ..) => [2, 1].map(|channel| ratio(of(channel), of(0))).to_vec(),
            (Watched::Curves, _, Some((reference, measured))) => (0..self.gloss.len())
                .map(|place| match place {
                    _ if !self.hit[place] => unknown,
                    _ if place == reference => Estimate::from_batches(of(place)),
                    _ => {
                        let Estimate { value, se } = ratio(of(place), of(reference));
                        Estimate {
                            value: value * measured,
                            se: se * measured,
                        }
                    }
                })
                .collect(),
            (Watched::Curves, ..) => (0..self.gloss.len())
                .map(|place| match self.hit[place] {
                    true => Estimate::from_batches(of(place)),
                    false => unknown,
                })
                .collect(),
        };
        let estimates = estimates.iter().map(|e| (e.value, e.se));
        self.precision.tolerance.largest_error(self.batches.len(), estimates)
    }
}

/// Ratio of two means with its delete-one jackknife error, as in [`crate::compare::Propagation`], in linear time.
fn ratio(over: impl Iterator<Item = f64> + Clone, under: impl Iterator<Item = f64> + Clone) -> Estimate {
    let sums = (over.clone().sum::<f64>(), under.clone().sum::<f64>());
    let without = over.zip(under).map(|(a, b)| (sums.0 - a) / (sums.1 - b));
    let count = without.clone().count() as f64;
    let mean = without.clone().sum::<f64>() / count;
    let square: f64 = without.map(|r| (r - mean) * (r - mean)).sum();
    Estimate {
        value: sums.0 / sums.1,
        se: ((count - 1.0) / count * square).sqrt(),
    }
}
