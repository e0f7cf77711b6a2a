use super::angles::Angle;
use super::flights::LANES;
use super::lane_math;
use super::{Interior, Ledger};

/// What the paths under way carry at every wavelength, and the sums of what became of it. Rows of wavelengths are padded
/// as those of the [`Interior`] are.
pub(super) struct Spectral {
    width: usize,
    wavelengths: usize,
    /// Balance heuristic of each lane, up to a factor between evaluations.
    share: Vec<f64>,
    /// 1/P of each lane's wavelengths as heroes, P being the probability to do anything but cross on the first flight.
    inverse_reach: Vec<f64>,
    /// exp(−μ_a L) of each lane at the last evaluation.
    survived: Vec<f64>,
    /// Result of the last evaluation.
    weights: Vec<f64>,
    scratch: [Vec<f64>; 2],
    ballistic: Vec<f64>,
    scattered: Vec<f64>,
    absorbed: Vec<f64>,
    roulette: Vec<f64>,
}

impl Spectral {
    pub fn new(interior: &Interior<'_>) -> Self {
        let width = interior.width();
        let zeros = || vec![0.0; width];
        let of_lanes = || vec![0.0; width * LANES];
        Self {
            width,
            wavelengths: interior.wavelengths(),
            share: of_lanes(),
            inverse_reach: of_lanes(),
            survived: of_lanes(),
            weights: zeros(),
            scratch: [zeros(), zeros()],
            ballistic: zeros(),
            scattered: zeros(),
            absorbed: zeros(),
            roulette: zeros(),
        }
    }

    /// Fractions of the path's incident flux at each wavelength, as last worked out.
    #[inline(always)]
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.wavelengths]
    }

    /// Begins a path: `weights` becomes the light that crosses unscattered. Returns 1/P of the hero; 0 if nothing else can
    /// happen.
    #[inline(always)]
    pub fn begin(
        &mut self,
        interior: &Interior<'_>,
        lane: usize,
        hero: usize,
        entering: f64,
        transmittance: f64,
        chord_mm: f64,
    ) -> f64 {
        let row = lane * self.width..(lane + 1) * self.width;
        let [unscattered, unabsorbed] = &mut self.scratch;
        attenuation(unscattered, interior.mu_s(), 0.0, chord_mm);
        attenuation(unabsorbed, interior.mu_a(), 0.0, chord_mm);
        let inverse_reach = &mut self.inverse_reach[row.clone()];
        reaches(inverse_reach, unscattered, interior.taken(), transmittance);
        cross(
            &mut self.weights,
            &mut self.ballistic,
            &mut self.absorbed,
            unscattered,
            unabsorbed,
            entering * transmittance,
        );
        let even = self.wavelengths as f64 / sum(inverse_reach);
        let inverse = inverse_reach[hero];
        let share = self.share[row.clone()].iter_mut().zip(interior.taken());
        share.for_each(|(share, taken)| *share = even * taken);
        self.survived[row].fill(1.0);
        inverse
    }

    /// A particle turned the lane's path.
    #[inline(always)]
    pub fn scatter(&mut self, interior: &Interior<'_>, lane: usize, angle: &Angle) {
        interior.weigh(angle, &mut self.share[lane * self.width..(lane + 1) * self.width]);
    }

    /// Works out `weights`, what the path carries at each wavelength after `since_mm` more, counts what was absorbed, and
    /// returns the largest weight. `common` is what Fresnel and roulette have left.
    #[inline(always)]
    pub fn evaluate(&mut self, interior: &Interior<'_>, lane: usize, hero: usize, common: f64, since_mm: f64) -> f64 {
        let row = lane * self.width..(lane + 1) * self.width;
        let share = &mut self.share[row.clone()];
        let [factor, product] = &mut self.scratch;
        let mut balance = 1.0;
        if self.wavelengths > 1 {
            attenuation(factor, interior.mu_s(), interior.mu_s()[hero], since_mm);
            weigh(share, product, factor, &self.inverse_reach[row.clone()]);
            balance = self.wavelengths as f64 / sum(product);
        }
        attenuation(factor, interior.mu_a(), 0.0, since_mm);
        carry(
            share,
            &mut self.survived[row],
            &mut self.absorbed,
            &mut self.weights,
            factor,
            balance,
            common,
        );
        largest(&self.weights)
    }

    /// Lets a part of the weights out; they are then what left.
    #[inline(always)]
    pub fn leave(&mut self, transmittance: f64, scattered: bool) {
        let sums = if scattered {
            &mut self.scattered
        } else {
            &mut self.ballistic
        };
        let_out(sums, &mut self.weights, transmittance);
    }

    /// Counts `factor` × the weights as taken by roulette.
    #[inline(always)]
    pub fn take(&mut self, factor: f64) {
        add(&mut self.roulette, &self.weights, factor);
    }

    /// Counts the weights as absorbed.
    #[inline(always)]
    pub fn absorb(&mut self) {
        add(&mut self.absorbed, &self.weights, 1.0);
    }

    pub fn ledgers(&self, reflected: f64) -> Vec<Ledger> {
        (0..self.wavelengths)
            .map(|w| Ledger {
                reflected,
                ballistic: self.ballistic[w],
                scattered: self.scattered[w],
                absorbed: self.absorbed[w],
                roulette: self.roulette[w],
            })
            .collect()
    }
}

// The loops over wavelengths stand in functions of their own because slices that come as arguments are known not to
// overlap: only then do the loops compile to vectors without a check each time.

/// exp(−(μ − `less`) x) of every wavelength.
#[inline(always)]
fn attenuation(result: &mut [f64], mu: &[f64], less: f64, x: f64) {
    for (result, mu) in result.iter_mut().zip(mu) {
        *result = lane_math::exp((less - mu) * x);
    }
}

/// 1/P, P = 1 − T exp(−μ_s c) in a form that does not cancel; 0 where P or the place is empty.
#[inline(always)]
fn reaches(inverse_reach: &mut [f64], unscattered: &[f64], taken: &[f64], transmittance: f64) {
    for ((inverse, unscattered), taken) in inverse_reach.iter_mut().zip(unscattered).zip(taken) {
        let reach = (1.0 - transmittance) + transmittance * (1.0 - unscattered);
        *inverse = if reach > 0.0 { taken / reach } else { 0.0 };
    }
}

#[inline(always)]
fn cross(
    weights: &mut [f64],
    ballistic: &mut [f64],
    absorbed: &mut [f64],
    unscattered: &[f64],
    unabsorbed: &[f64],
    crossing: f64,
) {
    let n = weights.len();
    let (ballistic, absorbed) = (&mut ballistic[..n], &mut absorbed[..n]);
    let (unscattered, unabsorbed) = (&unscattered[..n], &unabsorbed[..n]);
    for i in 0..n {
        let straight = crossing * unscattered[i];
        let leaving = straight * unabsorbed[i];
        weights[i] = leaving;
        ballistic[i] += leaving;
        absorbed[i] += straight - leaving;
    }
}

#[inline(always)]
fn weigh(share: &mut [f64], product: &mut [f64], factor: &[f64], inverse_reach: &[f64]) {
    let n = share.len();
    let (product, factor, inverse_reach) = (&mut product[..n], &factor[..n], &inverse_reach[..n]);
    for i in 0..n {
        let now = share[i] * factor[i];
        share[i] = now;
        product[i] = now * inverse_reach[i];
    }
}

#[inline(always)]
fn carry(
    share: &mut [f64],
    survived: &mut [f64],
    absorbed: &mut [f64],
    weights: &mut [f64],
    factor: &[f64],
    balance: f64,
    common: f64,
) {
    let n = share.len();
    let (survived, absorbed) = (&mut survived[..n], &mut absorbed[..n]);
    let (weights, factor) = (&mut weights[..n], &factor[..n]);
    for i in 0..n {
        // A wavelength out of the race stays out, before its share becomes a slow denormal number.
        let balanced = share[i] * balance;
        let balanced = if balanced > 1e-250 { balanced } else { 0.0 };
        let (carried, before) = (common * balanced, survived[i]);
        let now = before * factor[i];
        let weight = carried * now;
        share[i] = balanced;
        survived[i] = now;
        absorbed[i] += carried * before - weight;
        weights[i] = weight;
    }
}

#[inline(always)]
fn let_out(sums: &mut [f64], weights: &mut [f64], transmittance: f64) {
    for (sum, weight) in sums.iter_mut().zip(weights) {
        *weight *= transmittance;
        *sum += *weight;
    }
}

#[inline(always)]
fn add(sums: &mut [f64], weights: &[f64], factor: f64) {
    for (sum, weight) in sums.iter_mut().zip(weights) {
        *sum += factor * weight;
    }
}

/// Sum in a fixed order that suits vectors; the length is a multiple of 8.
#[inline(always)]
fn sum(values: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for chunk in values.chunks_exact(8) {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += x;
        }
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

/// Largest of values ≥ 0; the length is a multiple of 8.
#[inline(always)]
fn largest(values: &[f64]) -> f64 {
    let mut best = [0.0; 8];
    for chunk in values.chunks_exact(8) {
        for (best, &x) in best.iter_mut().zip(chunk) {
            *best = if x > *best { x } else { *best };
        }
    }
    best.iter().fold(0.0, |a, &b| if b > a { b } else { a })
}
