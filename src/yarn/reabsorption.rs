use super::length_range::Tilted;
use super::{LengthBins, YarnError};
use crate::fault::{self, Fault};
use crate::optics::Medium;
use rayon::prelude::*;
use std::iter::zip;

/// Re-weighting of traced light to another absorption by exp(−Δμ L), with L the path length inside the yarn.
///
/// Path lengths are binned; each bin holds the amount of light and its mean length. Within a bin the maximum-entropy
/// distribution with that mean is assumed: a truncated exponential (Jaynes 1957), and an exponential in the open last
/// bin. Re-weighting maps this family of distributions to itself, so two successive changes equal one.
///
/// κ changes scattering too. At the peak of the default dye μ_s changes by −0.8 % for κ_0 = 0 instead of 0.0065, by
/// +1.7 % for 0.01 and by +11 % for 0.02; g changes by less than 0.002. Δμ is therefore the change of μ_a + μ_s, and
/// scattered light gets a factor μ_s'/μ_s. This is exact for ballistic and singly scattered light. For multiple
/// scattering, a trace with 10 % more μ_s gave a remaining dependence μ_s^q with q from 0.08 at 530 nm to 1.95 at
/// 680 nm, always less than μ_s L (0.25 to 2.5). The systematic error therefore includes |μ_s'/μ_s − 1| μ_s L. The
/// change of the phase function is neglected.
#[derive(Clone, Debug)]
pub struct Reabsorption {
    bins: LengthBins,
    changes: Vec<Change>,
}

/// Change of the medium at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    pub wavelength_nm: f64,
    /// New less old absorption coefficient, 1/mm.
    pub mu_a_per_mm: f64,
    /// Change of the extinction coefficient μ_a + μ_s, 1/mm.
    mu_t_per_mm: f64,
    /// Ratio of the new to the old scattering coefficient.
    pub scattering: f64,
    /// New scattering coefficient, 1/mm.
    mu_s_per_mm: f64,
}

/// A table split by path length, re-weighted in place: cell × bin × wavelength (fastest), means over batches.
#[derive(Debug)]
pub struct ByLength<'a> {
    pub mean: &'a mut [f32],
    pub se: &'a mut [f32],
    /// Mean of value × path length, mm.
    pub moment_mm: &'a mut [f32],
}

/// Result of re-weighting one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reweighted {
    /// Ratio of the new to the old value.
    pub ratio: f64,
    /// Ratio of the new to the old standard error.
    pub se_ratio: f64,
    /// Systematic error from the binning of lengths and from multiple scattering, relative to the new value.
    pub systematic: f64,
    /// Effective fraction of the paths, (Σ e W)² / (Σ W Σ e² W) over the bins, with e the factor and W the light of a
    /// bin.
    pub effective_share: f64,
    /// Fraction of the new value in the open last bin.
    open_share: f64,
    /// Old value in the last bin, and that value times its mean length beyond the bin's edge, mm.
    open: [f64; 2],
}

/// Quality of the re-weighting at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Mean of [`Reweighted::effective_share`] over the table's light.
    pub effective_share: f64,
    /// Fraction of the light in cells whose effective share is below [`Reabsorption::LEAST_EFFECTIVE_SHARE`].
    pub unsupported: f64,
    /// Relative systematic error of the total.
    pub systematic: f64,
    /// Fraction of the light in cells whose systematic error exceeds both the statistical error and
    /// [`Reabsorption::GREATEST_SYSTEMATIC`].
    pub systematic_rules: f64,
    /// Fraction of the light in the open last bin.
    pub open_bin: f64,
    /// −Δμ times the mean length beyond the edge of the last bin: a lower bound of the growth of the light there, since
    /// the distribution of its lengths is unknown.
    pub open_bin_growth: f64,
}

impl Reabsorption {
    /// Effective share of the paths below which the standard error of a cell is unreliable.
    pub const LEAST_EFFECTIVE_SHARE: f64 = 0.1;
    /// Relative systematic error above which a warning is given, if it also exceeds the statistical error.
    pub const GREATEST_SYSTEMATIC: f64 = 0.01;
    /// Largest accepted relative change of μ_s, and largest accepted change of g.
    pub const GREATEST_SCATTERING_CHANGE: f64 = 0.1;
    pub const GREATEST_G_CHANGE: f64 = 0.01;
    /// Error estimate of the correction for the spread of lengths within bins, as a fraction of that correction. For
    /// the default study and |Δμ| up to 15/mm, the actual errors of cells were 0.15 to 0.5 times this estimate (rms
    /// over the yarn) and at most 1.4 times.
    pub const ERROR_OF_SPREAD: f64 = 0.25;

    /// Re-weighting from the traced medium to the wanted one.
    ///
    /// # Errors
    /// [`YarnError`] if the media differ in wavelengths or host index, in μ_s by more than 10 %, or in g by more than
    /// 0.01: such a medium must be traced.
    pub fn new(bins: LengthBins, traced: &Medium, wanted: &Medium) -> Result<Self, YarnError> {
        let refused = |quantity, expected, found| YarnError::Reabsorption {
            quantity,
            expected,
            found,
        };
        if traced.grid() != wanted.grid() {
            let found = format!("{} other ones", wanted.grid().len());
            return Err(refused("wavelengths", "those that were traced".into(), found));
        }
        let mut changes = Vec::with_capacity(traced.grid().len());
        for (i, &nm) in traced.grid().nm().iter().enumerate() {
            let pair = |of: fn(&Medium) -> &[f64]| (of(traced)[i], of(wanted)[i]);
            let (index, index_wanted) = pair(Medium::host_index);
            let (mu_s, mu_s_wanted) = pair(Medium::mu_s_per_mm);
            let (mu_a, mu_a_wanted) = pair(Medium::mu_a_per_mm);
            let (g, g_wanted) = pair(Medium::g);
            if index != index_wanted {
                let expected = format!("{index} as traced");
                return Err(refused("host index", expected, format!("{index_wanted} at {nm} nm")));
            }
            if (mu_s_wanted - mu_s).abs() > Self::GREATEST_SCATTERING_CHANGE * mu_s {
                let expected = format!("within 10 % of the {mu_s:.4}/mm that was traced");
                return Err(refused("mu_s", expected, format!("{mu_s_wanted:.4}/mm at {nm} nm")));
            }
            if mu_s > 0.0 && (g_wanted - g).abs() > Self::GREATEST_G_CHANGE {
                let expected = format!("within 0.01 of the {g:.4} that was traced");
                return Err(refused("g", expected, format!("{g_wanted:.4} at {nm} nm")));
            }
            let sign = if fault::active(Fault::ReabsorptionSign) {
                -1.0
            } else {
                1.0
            };
            changes.push(Change {
                wavelength_nm: nm,
                mu_a_per_mm: mu_a_wanted - mu_a,
                mu_t_per_mm: sign * (mu_a_wanted - mu_a + mu_s_wanted - mu_s),
                scattering: if mu_s > 0.0 { mu_s_wanted / mu_s } else { 1.0 },
                mu_s_per_mm: mu_s_wanted,
            });
        }
        Ok(Self { bins, changes })
    }

    /// Change of the medium at each wavelength.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Re-weights a table of f* (cell × wavelength) and its table by path length, in place. The new standard error is
    /// the old one times √(Σ e² V / Σ V), with V the variance and e the factor of a bin: correlations of bins between
    /// batches are assumed not to change. Systematic errors of an earlier change, in the unit of the table, are kept
    /// and added to.
    ///
    /// # Errors
    /// [`YarnError::Reabsorption`] if the lengths of the lists do not match.
    pub fn table(
        &self,
        mean: &mut [f64],
        se: &mut [f32],
        by_length: ByLength<'_>,
        systematic: &mut [f32],
    ) -> Result<Vec<Support>, YarnError> {
        let (bins, wavelengths) = (self.bins.bins(), self.changes.len());
        let lengths = [&by_length.mean, &by_length.se, &by_length.moment_mm].map(|list| list.len());
        if !mean.len().is_multiple_of(wavelengths)
            || [se.len(), systematic.len()] != [mean.len(); 2]
            || lengths != [mean.len() * bins; 3]
        {
            return Err(YarnError::Reabsorption {
                quantity: "values by path length",
                expected: format!("{bins} bins of {} values at {wavelengths} wavelengths", mean.len()),
                found: format!("{lengths:?}"),
            });
        }
        let row = bins * wavelengths;
        let cells: Vec<Vec<(f64, f64, Reweighted)>> = mean
            .par_chunks_mut(wavelengths)
            .zip(se.par_chunks_mut(wavelengths))
            .zip(systematic.par_chunks_mut(wavelengths))
            .zip(by_length.mean.par_chunks_mut(row))
            .zip(by_length.se.par_chunks_mut(row))
            .zip(by_length.moment_mm.par_chunks_mut(row))
            .map_init(
                || vec![Bin::default(); bins],
                |held, (((((mean, se), systematic), bin_mean), bin_se), bin_moment)| {
                    let mut one = |w: usize| {
                        let places = (0..bins).map(|bin| bin * wavelengths + w);
                        for (bin, at) in zip(held.iter_mut(), places.clone()) {
                            *bin = Bin {
                                mean: f64::from(bin_mean[at]),
                                se: f64::from(bin_se[at]),
                                moment_mm: f64::from(bin_moment[at]),
                            };
                        }
                        let all = self.reweight(w, Light::Scattered, held);
                        for (bin, at) in zip(held.iter(), places) {
                            bin_mean[at] = bin.mean as f32;
                            bin_se[at] = bin.se as f32;
                            bin_moment[at] = bin.moment_mm as f32;
                        }
                        mean[w] *= all.ratio;
                        se[w] = (f64::from(se[w]) * all.se_ratio) as f32;
                        let own = all.systematic * mean[w];
                        systematic[w] = (f64::from(systematic[w]) * all.ratio + own) as f32;
                        let rules = own > f64::from(se[w]).max(Self::GREATEST_SYSTEMATIC * mean[w]);
                        (mean[w], if rules { mean[w] } else { 0.0 }, all)
                    };
                    (0..wavelengths).map(&mut one).collect()
                },
            )
            .collect();
        Ok((0..wavelengths)
            .map(|w| self.support(w, cells.iter().map(|cell| cell[w])))
            .collect())
    }

    /// Re-weights the fractions that left the yarn, in place. `mean` and `se` hold, for each traced direction,
    /// wavelength and bin: ballistic light, scattered light, and both times path length in mm. Returns the result for
    /// the ballistic and the scattered light of each direction and wavelength.
    ///
    /// # Errors
    /// [`YarnError::Reabsorption`] if the lengths of the lists do not match.
    pub fn energy(&self, mean: &mut [f64], se: &mut [f32]) -> Result<Vec<[Reweighted; 2]>, YarnError> {
        let (bins, wavelengths) = (self.bins.bins(), self.changes.len());
        if mean.len() != se.len() || !mean.len().is_multiple_of(4 * bins * wavelengths) {
            return Err(YarnError::Reabsorption {
                quantity: "energy by path length",
                expected: format!("{bins} bins of 4 values at {wavelengths} wavelengths a direction"),
                found: format!("{} values with {} errors", mean.len(), se.len()),
            });
        }
        let rows = zip(mean.chunks_exact_mut(4 * bins), se.chunks_exact_mut(4 * bins)).enumerate();
        let mut held = vec![Bin::default(); bins];
        let reweighted = rows.map(|(row, (mean, se))| {
            [Light::Ballistic, Light::Scattered].map(|light| {
                let places = (0..bins).map(|bin| 4 * bin + light as usize);
                for (bin, at) in zip(&mut held, places.clone()) {
                    *bin = Bin {
                        mean: mean[at],
                        se: f64::from(se[at]),
                        moment_mm: mean[at + 2],
                    };
                }
                let all = self.reweight(row % wavelengths, light, &mut held);
                for (bin, at) in zip(&held, places) {
                    let factor = if mean[at] > 0.0 { bin.mean / mean[at] } else { 1.0 };
                    mean[at] = bin.mean;
                    mean[at + 2] = bin.moment_mm;
                    se[at] = bin.se as f32;
                    se[at + 2] = (factor * f64::from(se[at + 2])) as f32;
                }
                all
            })
        });
        Ok(reweighted.collect())
    }

    /// Re-weights all bins of one value.
    fn reweight(&self, w: usize, light: Light, bins: &mut [Bin]) -> Reweighted {
        let change = self.changes[w];
        let scattering = match light {
            Light::Ballistic => 1.0,
            Light::Scattered => change.scattering,
        };
        let (mut old, mut new, mut squares, mut moment) = (0.0, 0.0, 0.0, 0.0);
        let (mut variance, mut new_variance, mut spread) = (0.0, 0.0, 0.0);
        let (mut open_share, mut open) = (0.0, [0.0; 2]);
        for (i, bin) in bins.iter_mut().enumerate().filter(|(_, bin)| bin.mean > 0.0) {
            let range = self.bins.range(i);
            let error = bin.se / bin.mean;
            let mean_mm = bin.moment_mm / bin.mean;
            let tilted = match light {
                // The variance of n paths about their own mean is (1 − 1/n) of the true variance, and 1/n is the square
                // of their relative error.
                Light::Scattered => range.tilt(mean_mm, change.mu_t_per_mm, (1.0 - error * error).max(0.0)),
                // Ballistic light of one direction crosses the yarn an integer number of times. Each bin holds a single
                // number of crossings, except the last few bins, which hold almost no light.
                Light::Ballistic => Tilted {
                    correction: match old {
                        0.0 => 0.0,
                        _ => range.tilt(mean_mm, change.mu_t_per_mm, 1.0).correction,
                    },
                    ..range.tilt(mean_mm, change.mu_t_per_mm, 0.0)
                },
            };
            let factor = scattering * tilted.factor;
            let mean = factor * bin.mean;
            if range.width_mm.is_none() {
                open_share = mean;
                open = [bin.mean, (bin.moment_mm - range.low_mm * bin.mean).max(0.0)];
            }
            old += bin.mean;
            new += mean;
            squares += factor * mean;
            moment += mean * tilted.mean_mm;
            variance += bin.se * bin.se;
            new_variance += factor * factor * bin.se * bin.se;
            spread += mean * tilted.correction;
            *bin = Bin {
                mean,
                se: factor * bin.se,
                moment_mm: mean * tilted.mean_mm,
            };
        }
        if old <= 0.0 || new <= 0.0 {
            return Reweighted {
                ratio: 1.0,
                se_ratio: 1.0,
                systematic: 0.0,
                effective_share: 1.0,
                open_share: 0.0,
                open,
            };
        }
        let ratio = new / old;
        let further = match light {
            Light::Ballistic => 0.0,
            Light::Scattered => (change.scattering - 1.0).abs() * change.mu_s_per_mm * moment,
        };
        Reweighted {
            ratio,
            se_ratio: if variance > 0.0 {
                (new_variance / variance).sqrt()
            } else {
                ratio
            },
            systematic: (Self::ERROR_OF_SPREAD * spread + further) / new,
            effective_share: new * ratio / squares,
            open_share: open_share / new,
            open,
        }
    }

    /// Quality over all cells of a table. Each item is a cell's light, the part of it in which the systematic error
    /// dominates, and its result.
    fn support(&self, w: usize, cells: impl Iterator<Item = (f64, f64, Reweighted)>) -> Support {
        let mut sum = Support {
            effective_share: 0.0,
            unsupported: 0.0,
            systematic: 0.0,
            systematic_rules: 0.0,
            open_bin: 0.0,
            open_bin_growth: 0.0,
        };
        let (mut light, mut open) = (0.0, [0.0; 2]);
        for (value, ruled, all) in cells {
            light += value;
            sum.effective_share += value * all.effective_share;
            if all.effective_share < Self::LEAST_EFFECTIVE_SHARE {
                sum.unsupported += value;
            }
            sum.systematic += value * all.systematic;
            sum.systematic_rules += ruled;
            sum.open_bin += value * all.open_share;
            zip(&mut open, all.open).for_each(|(sum, x)| *sum += x);
        }
        if light <= 0.0 {
            return Support {
                effective_share: 1.0,
                ..sum
            };
        }
        Support {
            effective_share: sum.effective_share / light,
            unsupported: sum.unsupported / light,
            systematic: sum.systematic / light,
            systematic_rules: sum.systematic_rules / light,
            open_bin: sum.open_bin / light,
            open_bin_growth: if open[0] > 0.0 {
                -self.changes[w].mu_t_per_mm * open[1] / open[0]
            } else {
                0.0
            },
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Light {
    Ballistic = 0,
    Scattered = 1,
}

/// A bin of one value.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    mean: f64,
    se: f64,
    moment_mm: f64,
}
