use super::{LengthBins, YarnError};
use crate::fault::{self, Fault};
use crate::optics::Medium;
use rayon::prelude::*;
use std::iter::zip;

/// Another absorption for light that was traced already, after exp(−Δμ L) of its path lengths L.
///
/// Path lengths are known by bins, as the amount and the mean length in each. Within a bin they are taken to be spread as
/// widely as that mean allows, which is a truncated exponential (Jaynes 1957), in the last bin, without an end, an
/// exponential. More absorption turns such a distribution into another of its kind, so that two changes in turn are as good as
/// one.
///
/// κ changes scattering too: at the peak of the default dye μ_s by −0.8 % for κ_0 = 0 in place of 0.0065, by +1.7 % for 0.01
/// and +11 % for 0.02, g by less than 0.002. Δμ is therefore the change of μ_a + μ_s, and scattered light takes a
/// factor μ_s'/μ_s: all there is to ballistic light and to light that scattered once. What more scatterings add was traced with
/// 10 % more μ_s: a power of μ_s from 0.08 at 530 nm to 1.95 at 680 nm, always less than μ_s L (0.25 to 2.5), so that
/// |μ_s'/μ_s − 1| μ_s L is part of the systematic error. The change of the phase function is neglected.
#[derive(Clone, Debug)]
pub struct Reabsorption {
    bins: LengthBins,
    changes: Vec<Change>,
}

/// How the medium changes at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    pub wavelength_nm: f64,
    /// New less old absorption coefficient, 1/mm.
    pub mu_a_per_mm: f64,
    /// The same of absorption and scattering together.
    mu_t_per_mm: f64,
    /// New over old scattering coefficient.
    pub scattering: f64,
    /// New scattering coefficient, 1/mm.
    mu_s_per_mm: f64,
}

/// Values of a table that are split by path length, in place: cell × bin × wavelength (fastest), means over batches.
#[derive(Debug)]
pub struct ByLength<'a> {
    pub mean: &'a mut [f32],
    pub se: &'a mut [f32],
    /// Mean of value × path length, mm.
    pub moment_mm: &'a mut [f32],
}

/// What becomes of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reweighted {
    /// New value over old.
    pub ratio: f64,
    /// New standard error over old.
    pub se_ratio: f64,
    /// What the bins and further scatterings leave open, relative to the new value.
    pub systematic: f64,
    /// (Σ e W)² / (Σ W Σ e² W) over the bins, e the factor of what W holds: the share of the paths that still counts.
    pub effective_share: f64,
    /// Part of the new value in the last bin.
    open_share: f64,
    /// Old value in the last bin, and its mean lengths beyond the bin's edge, mm times value.
    open: [f64; 2],
}

/// How well the tallies of a wavelength carried its change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Mean of [`Reweighted::effective_share`] over the table's light.
    pub effective_share: f64,
    /// Part of the light in cells where that share is below [`Reabsorption::LEAST_EFFECTIVE_SHARE`].
    pub unsupported: f64,
    /// Systematic error of all the light, relative.
    pub systematic: f64,
    /// Part of the light in cells whose systematic error exceeds both the statistical one and
    /// [`Reabsorption::GREATEST_SYSTEMATIC`].
    pub systematic_rules: f64,
    /// Part of the light in the last bin.
    pub open_bin: f64,
    /// −Δμ times the mean length beyond the last bin's edge: the least of the growth of the light there, whose true lengths are
    /// not known.
    pub open_bin_growth: f64,
}

impl Reabsorption {
    /// Below this effective share of the paths a cell's own error bar is no longer to be relied upon.
    pub const LEAST_EFFECTIVE_SHARE: f64 = 0.1;
    /// Relative systematic error that is worth a warning where it is greater than the statistical one.
    pub const GREATEST_SYSTEMATIC: f64 = 0.01;
    /// Relative change of μ_s, and change of g, that is taken as small.
    pub const GREATEST_SCATTERING_CHANGE: f64 = 0.1;
    pub const GREATEST_G_CHANGE: f64 = 0.01;
    /// The part of the correction for the spread within bins that is its error. At the default study and |Δμ| up to 15/mm cells
    /// were off by 0.15 to 0.5 of that, rms over the yarn, and by 1.4 times as much at most.
    pub const ERROR_OF_SPREAD: f64 = 0.25;

    /// From the medium that was traced to another.
    ///
    /// # Errors
    /// Other wavelengths or host index; a scattering coefficient or asymmetry that differs by more than 10 % or 0.01: such a
    /// medium must be traced.
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

    /// One a wavelength.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// A table of f*, cell × wavelength, from its own values and those by path length, all in place. The standard error is the
    /// table's own times √(Σ e² V / Σ V), V the variance of a bin, e its factor: as far as bins go together from batch to batch
    /// they are taken to go on doing so. Systematic errors of an earlier change, in the unit of the table, are kept and added to.
    ///
    /// # Errors
    /// Lists whose lengths do not fit each other.
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

    /// Light that left by path length: traced direction × wavelength × bin of ballistic light, scattered light, and both times
    /// path length in mm, in place. Returns what becomes of the ballistic and the scattered light of each direction and
    /// wavelength.
    ///
    /// # Errors
    /// Lists whose lengths do not fit each other.
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

    /// All bins of one value.
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
            let range = self.range(i);
            let error = bin.se / bin.mean;
            let mean_mm = bin.moment_mm / bin.mean;
            let tilted = match light {
                // n paths are spread (1 − 1/n) as widely about their own mean as many are, and 1/n is the square of their
                // relative error.
                Light::Scattered => range.tilt(mean_mm, change.mu_t_per_mm, (1.0 - error * error).max(0.0)),
                // In one direction it has crossed the yarn a whole number of times, a different one in each bin but for the
                // last few, which hold next to nothing.
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

    /// Of all cells of a table, each with its light and how much of it the systematic error rules.
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

    fn range(&self, bin: usize) -> Range {
        let edges = self.bins.edges_mm();
        let low_mm = if bin == 0 { 0.0 } else { edges[bin - 1] };
        Range {
            low_mm,
            width_mm: edges.get(bin).map(|edge| edge - low_mm),
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

/// Lengths that a bin holds, mm; the last has no width.
#[derive(Clone, Copy, Debug)]
struct Range {
    low_mm: f64,
    width_mm: Option<f64>,
}

/// A bin after exp(−Δμ L).
struct Tilted {
    /// Mean of exp(−Δμ L).
    factor: f64,
    /// New mean length.
    mean_mm: f64,
    /// How much of the factor is due to the spread of the lengths, relative.
    correction: f64,
}

impl Range {
    /// Lengths of a mean, of which the part `spreads` of their variance is spread over the range.
    fn tilt(&self, mean_mm: f64, change_per_mm: f64, spreads: f64) -> Tilted {
        let beyond = (mean_mm - self.low_mm).max(0.0);
        // Logarithm of the mean of exp(−Δμ (L − mean)), and how far the mean moves.
        let (spread, shift) = match self.width_mm {
            Some(width) => {
                let rate = rate_of_mean((beyond / width).min(1.0));
                let new = rate + change_per_mm * width;
                let spread = log_integral(new) - log_integral(rate) + change_per_mm * beyond;
                (spread, width * (mean_of_rate(new) - mean_of_rate(rate)))
            }
            None => {
                // An exponential that would grow without end stops short of it; the warning of the open bin says so.
                let growth = (change_per_mm * beyond).max(-MOST_OPEN_GROWTH);
                (growth - growth.ln_1p(), -beyond * growth / (1.0 + growth))
            }
        };
        let spread = spreads * spread.max(0.0);
        Tilted {
            factor: (spread - change_per_mm * mean_mm).exp(),
            mean_mm: mean_mm + spreads * shift,
            correction: -(-spread).exp_m1(),
        }
    }
}

/// Of −Δμ times the mean length beyond the last edge; the exponential diverges at 1.
const MOST_OPEN_GROWTH: f64 = 0.9;

/// ln ∫₀¹ exp(−t x) dx.
fn log_integral(t: f64) -> f64 {
    if t < 0.0 {
        return -t + log_integral(-t);
    }
    if t < 1e-3 {
        return -t / 2.0 + t * t / 24.0;
    }
    (-(-t).exp_m1() / t).ln()
}

/// Mean of x over 0..1 with the density exp(−t x): ½ − ½ L(t/2), L(x) = coth x − 1/x the Langevin function.
fn mean_of_rate(t: f64) -> f64 {
    0.5 - 0.5 * langevin(0.5 * t)
}

/// The t of a mean.
fn rate_of_mean(mean: f64) -> f64 {
    let v = (1.0 - 2.0 * mean).clamp(-STEEPEST, STEEPEST);
    // Within 5 % (Cohen 1991), and from there by Newton's steps, each of which squares the error.
    let mut x = v * (3.0 - v * v) / (1.0 - v * v);
    for _ in 0..4 {
        let slope = if x.abs() < 1e-2 {
            1.0 / 3.0
        } else {
            1.0 / (x * x) - 1.0 / x.sinh().powi(2)
        };
        x -= (langevin(x) - v) / slope;
    }
    2.0 * x
}

/// Means nearer to an edge than this, 5e-4 of the range, count as so near.
const STEEPEST: f64 = 0.999;

fn langevin(x: f64) -> f64 {
    if x.abs() < 1e-2 {
        let square = x * x;
        return x / 3.0 * (1.0 - square / 15.0 * (1.0 - square * 2.0 / 21.0));
    }
    1.0 / x.tanh() - 1.0 / x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_density_of_a_mean_has_that_mean() {
        for k in 1..2000 {
            let mean = k as f64 / 2000.0;
            let found = mean_of_rate(rate_of_mean(mean));
            assert!((found - mean).abs() < 1e-12, "{mean}: {found}");
        }
    }

    /// Against the integral by Simpson's rule, and the derivative of its logarithm.
    #[test]
    fn a_tilted_range_has_the_integral_and_mean_of_its_density() {
        let range = Range {
            low_mm: 0.3,
            width_mm: Some(0.15),
        };
        for (u, change) in [(0.1, 12.0), (0.3, -20.0), (0.5, 1e-4), (0.9, 5.0), (0.499, -3.0)] {
            let rate = rate_of_mean(u);
            let steps = 20_000;
            let moments = |change: f64| {
                let mut sums = [0.0; 2];
                for i in 0..=steps {
                    let x = i as f64 / steps as f64;
                    let simpson = if i == 0 || i == steps {
                        1.0
                    } else {
                        2.0 + 2.0 * (i % 2) as f64
                    };
                    let length = 0.3 + 0.15 * x;
                    let density = simpson * (-rate * x - change * length).exp();
                    zip(&mut sums, [1.0, length]).for_each(|(sum, power)| *sum += density * power);
                }
                sums
            };
            let (before, after) = (moments(0.0), moments(change));
            let tilted = range.tilt(before[1] / before[0], change, 1.0);
            let exact = after[0] / before[0];
            assert!(
                (tilted.factor / exact - 1.0).abs() < 1e-9,
                "{u} {change}: {} {exact}",
                tilted.factor
            );
            assert!(
                (tilted.mean_mm / (after[1] / after[0]) - 1.0).abs() < 1e-9,
                "{u} {change}"
            );
            let back = range.tilt(tilted.mean_mm, -change, 1.0);
            assert!((back.factor * tilted.factor - 1.0).abs() < 1e-9, "{u} {change}");
        }
    }

    #[test]
    fn one_path_alone_is_taken_at_its_length() {
        for width_mm in [Some(0.15), None] {
            let tilted = Range { low_mm: 0.3, width_mm }.tilt(0.4, -7.0, 0.0);
            assert_eq!(
                (tilted.factor, tilted.mean_mm, tilted.correction),
                ((7.0f64 * 0.4).exp(), 0.4, 0.0)
            );
        }
    }
}
