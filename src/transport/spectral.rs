use super::entrance::Entrance;
use super::flights::{Flights, LanesOf, Mask, Step, lanes_where};
use super::groups::{
    balanced, count, density_ratio, double, larger, losses, minus, paths_over_reach, plus, product, remainder, scaled,
    single, sum, top,
};
use super::interior::{Double, GROUP, Single};
use super::lane_math::LANES;
use super::roulette::REFLECTIONS_IN_A_ROW;
use super::weights::{EVENTS_AT_MOST, Weights};
use super::{Fraction, Interior, Ledger, Roulette};

/// Weights of paths shared by all wavelengths. Lanes are processed one after the other; vectors run over wavelengths.
///
/// Weights of one path are in single precision (relative error about 10⁻⁶), which doubles the number of wavelengths in
/// a vector. Sums over paths are in double precision.
pub(super) struct Spectral<'a> {
    incident: Option<&'a [f32]>,
    wavelengths: usize,
    groups: usize,
    /// Number of paths in a round over all heroes.
    paths_per_round: f32,
    /// Balance-heuristic weight of each lane at its last evaluation, times the density ratios to the hero since then.
    share: Vec<Single>,
    /// c_h/P_h of each lane: paths per round of each hero over the probability that its first flight does not cross.
    heroes: Vec<Single>,
    /// Incident flux of each lane's path times exp(−μ_a L), at the last evaluation.
    survived: Vec<Single>,
    /// Flux of each lane at the last evaluation, before any of it left.
    carried: Vec<Single>,
    /// Flux that leaves the body in the exit being scored.
    weights: Vec<Double>,
    reflected: Vec<Double>,
    ballistic: Vec<Double>,
    scattered: Vec<Double>,
    absorbed: Vec<Double>,
    roulette: Vec<Double>,
    sharing: Vec<Double>,
    /// Product of Fresnel reflectances and roulette factors, the same at every wavelength.
    common: [f64; LANES],
    /// Fresnel and roulette factor applied to `carried` since the last evaluation.
    left: [f64; LANES],
    entered: [f64; LANES],
    /// Path length, mm, and scattering events since the last evaluation.
    since: [f64; LANES],
    scatterings: [u64; LANES],
}

impl<'a> Weights<'a> for Spectral<'a> {
    fn new(interior: &Interior<'_>, incident: Option<&'a [f32]>) -> Self {
        let groups = interior.mu_s().len();
        let sums = || vec![[0.0; GROUP]; groups];
        Self {
            incident,
            wavelengths: interior.wavelengths(),
            groups,
            paths_per_round: interior.heroes().len() as f32,
            share: vec![[0.0; GROUP]; groups * LANES],
            heroes: vec![[0.0; GROUP]; groups * LANES],
            survived: vec![[0.0; GROUP]; groups * LANES],
            carried: vec![[0.0; GROUP]; groups * LANES],
            weights: sums(),
            reflected: sums(),
            ballistic: sums(),
            scattered: sums(),
            absorbed: sums(),
            roulette: sums(),
            sharing: sums(),
            common: [0.0; LANES],
            left: [0.0; LANES],
            entered: [0.0; LANES],
            since: [0.0; LANES],
            scatterings: [0; LANES],
        }
    }

    #[inline(always)]
    fn prepare(&mut self, _: &Interior<'_>, _: &Entrance) {}

    #[inline(always)]
    fn begin(&mut self, interior: &Interior<'_>, entrance: &Entrance, place: usize, lane: usize, hero: usize) -> f64 {
        let entering = 1.0 - entrance.reflectance[place];
        let chord_mm = single(entrance.chord_mm[place]);
        let transmittance = entrance.transmittance[place] as f32;
        let crossing = entering as f32 * transmittance;
        let row = lane * self.groups..(lane + 1) * self.groups;
        let coming = &mut self.survived[row.clone()];
        match self.incident {
            None => coming.copy_from_slice(interior.taken()),
            Some(rows) => {
                let first = entrance.number[place] * self.wavelengths;
                coming.as_flattened_mut()[..self.wavelengths].copy_from_slice(&rows[first..first + self.wavelengths]);
            }
        }
        let share = &mut self.share[row.clone()];
        let heroes = &mut self.heroes[row.clone()];
        let mut total = [0.0; GROUP];
        let mut largest = [0.0; GROUP];
        for (group, as_hero) in heroes.iter_mut().enumerate() {
            let met = losses(interior.mu_s()[group], chord_mm);
            let straight = product(coming[group], scaled(remainder(met), crossing));
            let reflected = scaled(double(coming[group]), entrance.reflectance[place]);
            self.reflected[group] = plus(self.reflected[group], reflected);
            largest = larger(largest, coming[group]);
            let absorbed = double(product(straight, losses(interior.mu_a()[group], chord_mm)));
            let weights = minus(double(straight), absorbed);
            self.weights[group] = weights;
            self.ballistic[group] = plus(self.ballistic[group], weights);
            self.absorbed[group] = plus(self.absorbed[group], absorbed);
            self.sharing[group] = minus(self.sharing[group], double(straight));
            *as_hero = paths_over_reach(met, interior.paths_per_round()[group], transmittance);
            total = plus(total, *as_hero);
        }
        // If every hero certainly crosses, no flux remains inside.
        let reach = sum(total);
        let normalisation = if reach > 0.0 { self.paths_per_round / reach } else { 0.0 };
        let carried = self.carried[row.clone()].iter_mut().zip(interior.taken());
        let carried = carried.zip(&*coming);
        for ((share, ((carried, taken), coming)), sharing) in share.iter_mut().zip(carried).zip(&mut self.sharing) {
            *share = scaled(*taken, normalisation);
            *carried = product(scaled(*share, entering as f32), *coming);
            // A path starts with the balance-heuristic weight at each wavelength; the difference to what entered is
            // the net effect of sharing, zero in the mean.
            *sharing = plus(*sharing, minus(scaled(double(*coming), entering), double(*carried)));
        }
        self.common[lane] = entering;
        self.left[lane] = 1.0;
        self.entered[lane] = entering * f64::from(top(largest));
        self.since[lane] = 0.0;
        self.scatterings[lane] = 0;
        let paths_per_round = f64::from(interior.paths_per_round().as_flattened()[hero]);
        let over_reach = f64::from(heroes.as_flattened()[hero]);
        if over_reach > 0.0 {
            (paths_per_round / over_reach).min(1.0)
        } else {
            // This hero certainly crosses, so no path continues; paths of the other heroes carry its share.
            count(
                &mut self.sharing,
                &self.carried[lane * self.groups..(lane + 1) * self.groups],
                1.0,
            );
            0.0
        }
    }

    #[inline(always)]
    fn crossing(&self) -> &[f64] {
        &self.weights.as_flattened()[..self.wavelengths]
    }

    #[inline(always)]
    fn meet(
        &mut self,
        interior: &Interior<'_>,
        rule: &Roulette,
        flights: &Flights,
        step: &Step,
        mut tell: impl FnMut(usize, &[f64]),
    ) -> Mask {
        for lane in LanesOf(step.scattering) {
            let share = &mut self.share[lane * self.groups..(lane + 1) * self.groups];
            interior.weigh(flights.hero[lane] as usize, &step.deflection, lane, share);
        }
        let at_most = interior.scatterings_at_most().min(EVENTS_AT_MOST);
        for i in 0..LANES {
            self.since[i] += step.length[i];
            self.scatterings[i] += step.scatters[i];
        }
        let due = lanes_where(|lane| {
            (step.leaving[lane] > 0.0)
                | (self.scatterings[lane] >= at_most)
                | (flights.reflections[lane] >= REFLECTIONS_IN_A_ROW)
                | (step.lost[lane] == 1)
        });
        let mut alive = flights.alive;
        for lane in LanesOf(alive & due) {
            let largest = self.evaluate(interior, flights.hero[lane] as usize, lane);
            let carried = &self.carried[lane * self.groups..(lane + 1) * self.groups];
            let out = step.leaving[lane];
            if out > 0.0 {
                let sums = if flights.scattered[lane] == 1 {
                    &mut self.scattered
                } else {
                    &mut self.ballistic
                };
                for ((sums, weights), carried) in sums.iter_mut().zip(&mut self.weights).zip(carried) {
                    *weights = scaled(double(*carried), out);
                    *sums = plus(*sums, *weights);
                }
                tell(lane, &self.weights.as_flattened()[..self.wavelengths]);
            }
            let kept = 1.0 - out;
            if step.lost[lane] == 1 {
                // Neither a particle nor a surface ahead: the remaining flux is absorbed on the way to infinity.
                count(&mut self.absorbed, carried, 1.0);
                alive &= !(1 << lane);
                continue;
            }
            let reflections = flights.reflections[lane];
            let worth = rule.worth(largest * kept, self.entered[lane], reflections, step.for_roulette[lane]);
            if worth != 1.0 {
                count(&mut self.roulette, carried, kept * (1.0 - worth));
            }
            self.common[lane] *= kept * worth;
            self.left[lane] = kept * worth;
            alive &= !(Mask::from(largest * kept * worth <= 0.0) << lane);
        }
        alive
    }

    /// At the last evaluation: between two the flux is not known.
    #[inline(always)]
    fn flux(&self, lane: usize) -> f64 {
        f64::from(self.carried[lane * self.groups][0]) * self.left[lane]
    }

    fn ledgers(&self) -> Vec<Ledger> {
        let sums = |fraction| match fraction {
            Fraction::Reflected => self.reflected.as_flattened(),
            Fraction::Ballistic => self.ballistic.as_flattened(),
            Fraction::Scattered => self.scattered.as_flattened(),
            Fraction::Absorbed => self.absorbed.as_flattened(),
            Fraction::RouletteNet => self.roulette.as_flattened(),
            Fraction::MisNet => self.sharing.as_flattened(),
        };
        (0..self.wavelengths)
            .map(|w| Ledger::new(|fraction| sums(fraction)[w]))
            .collect()
    }
}

impl Spectral<'_> {
    /// Evaluates the path's flux at each wavelength, scores absorption and the net effect of the balance heuristic
    /// since the last evaluation, and returns the largest flux.
    #[inline(always)]
    fn evaluate(&mut self, interior: &Interior<'_>, hero: usize, lane: usize) -> f64 {
        let row = lane * self.groups..(lane + 1) * self.groups;
        let since = single(self.since[lane]);
        self.since[lane] = 0.0;
        self.scatterings[lane] = 0;
        let share = &mut self.share[row.clone()];
        let mu_s = interior.mu_s();
        let hero_mu_s = mu_s[hero / GROUP][hero % GROUP];
        let mut total = [0.0; GROUP];
        for ((share, mu_s), as_hero) in share.iter_mut().zip(mu_s).zip(&self.heroes[row.clone()]) {
            let flown = density_ratio(*mu_s, hero_mu_s, since);
            let now = product(*share, flown);
            *share = now;
            total = plus(total, product(now, *as_hero));
        }
        let balance = self.paths_per_round / sum(total);
        let common = self.common[lane] as f32;
        let left = self.left[lane];
        let mut largest = [0.0; GROUP];
        let carried = &mut self.carried[row.clone()];
        let rows = share.iter_mut().zip(&mut self.survived[row]).zip(carried);
        for (group, ((share, survived), last)) in rows.enumerate() {
            let now = balanced(*share, balance);
            *share = now;
            let before = product(scaled(now, common), *survived);
            let lost = losses(interior.mu_a()[group], since);
            let kept = remainder(lost);
            *survived = product(*survived, kept);
            let carried = product(before, kept);
            let absorbed = double(product(before, lost));
            let accounted = plus(absorbed, double(carried));
            // Rounding errors of single precision are booked with the balance heuristic, so that the ledger closes.
            let changed = minus(scaled(double(*last), left), accounted);
            self.sharing[group] = plus(self.sharing[group], changed);
            *last = carried;
            self.absorbed[group] = plus(self.absorbed[group], absorbed);
            largest = larger(largest, carried);
        }
        f64::from(top(largest))
    }
}
