use super::entrance::Entrance;
use super::flights::{Flights, LanesOf, Mask, Step, lanes_where};
use super::lane_math::{LANES, exp};
use super::weights::{EVENTS_AT_MOST, Weights};
use super::{Fraction, Interior, Ledger, Roulette};

/// Weights of paths of one wavelength, vectorised over lanes. The ledger closes to rounding.
pub(super) struct Plain<'a> {
    incident: Option<&'a [f32]>,
    mu_s: f64,
    mu_a: f64,
    crossing: f64,
    /// For the paths at the entrance: flux that crosses unscattered, probability P of not crossing, and flux that
    /// enters.
    waiting_crossing: [f64; LANES],
    waiting_reach: [f64; LANES],
    waiting_entering: [f64; LANES],
    /// Present flux of each path, its flux at entry, and events since roulette was last applied to it.
    carried: [f64; LANES],
    entered: [f64; LANES],
    events: [u64; LANES],
    /// Ledger sums of each lane.
    reflected: [f64; LANES],
    ballistic: [f64; LANES],
    scattered: [f64; LANES],
    absorbed: [f64; LANES],
    roulette: [f64; LANES],
}

impl<'a> Weights<'a> for Plain<'a> {
    fn new(interior: &Interior<'_>, incident: Option<&'a [f32]>) -> Self {
        Self {
            incident,
            mu_s: 1.0 / interior.mean_free_path()[0],
            mu_a: interior.first_mu_a(),
            crossing: 0.0,
            waiting_crossing: [0.0; LANES],
            waiting_reach: [0.0; LANES],
            waiting_entering: [0.0; LANES],
            carried: [0.0; LANES],
            entered: [0.0; LANES],
            events: [0; LANES],
            reflected: [0.0; LANES],
            ballistic: [0.0; LANES],
            scattered: [0.0; LANES],
            absorbed: [0.0; LANES],
            roulette: [0.0; LANES],
        }
    }

    #[inline(always)]
    fn prepare(&mut self, _: &Interior<'_>, entrance: &Entrance) {
        let waiting = entrance.waiting();
        let mut coming = [0.0; LANES];
        for (i, coming) in coming.iter_mut().enumerate().take(waiting) {
            *coming = self.incident.map_or(1.0, |rows| f64::from(rows[entrance.number[i]]));
        }
        for (i, &coming) in coming.iter().enumerate() {
            let reflected = coming * entrance.reflectance[i];
            let entering = coming - reflected;
            self.reflected[i] += reflected;
            let (transmittance, chord_mm) = (entrance.transmittance[i], entrance.chord_mm[i]);
            let unscattered = exp(-self.mu_s * chord_mm);
            let straight = entering * transmittance * unscattered;
            let crossing = straight * exp(-self.mu_a * chord_mm);
            // 1 − T exp(−μ_s c) in a form without cancellation.
            let reach = (1.0 - transmittance) + transmittance * (1.0 - unscattered);
            self.waiting_crossing[i] = crossing;
            self.waiting_reach[i] = reach;
            self.waiting_entering[i] = entering;
            self.ballistic[i] += crossing;
            self.absorbed[i] += straight - crossing;
        }
    }

    #[inline(always)]
    fn begin(&mut self, _: &Interior<'_>, _: &Entrance, place: usize, lane: usize, _: usize) -> f64 {
        self.crossing = self.waiting_crossing[place];
        self.carried[lane] = self.waiting_entering[place] * self.waiting_reach[place];
        self.entered[lane] = self.waiting_entering[place];
        self.events[lane] = 0;
        self.waiting_reach[place]
    }

    #[inline(always)]
    fn crossing(&self) -> &[f64] {
        std::slice::from_ref(&self.crossing)
    }

    #[inline(always)]
    fn meet(
        &mut self,
        _: &Interior<'_>,
        rule: &Roulette,
        flights: &Flights,
        step: &Step,
        mut tell: impl FnMut(usize, &[f64]),
    ) -> Mask {
        let mut leaving = [0.0; LANES];
        for (i, leaving) in leaving.iter_mut().enumerate() {
            let before = self.carried[i];
            let after = before * exp(-self.mu_a * step.length[i]);
            // Neither a particle nor a surface ahead: the remaining flux is absorbed on the way to infinity.
            let after = if step.lost[i] == 1 { 0.0 } else { after };
            let out = after * step.leaving[i];
            let kept = after - out;
            let ballistic = if flights.scattered[i] == 1 { 0.0 } else { out };
            // Roulette applies only after an exit: elsewhere it would remove long paths that a re-weighting to another
            // absorption needs.
            self.events[i] += 1;
            let due = (out > 0.0) | (self.events[i] >= EVENTS_AT_MOST);
            self.events[i] = if due { 0 } else { self.events[i] };
            let weighed = if due { kept } else { self.entered[i] };
            let worth = rule.worth(weighed, self.entered[i], flights.reflections[i], step.for_roulette[i]);
            let goes_on = kept * worth;
            self.absorbed[i] += before - after;
            self.ballistic[i] += ballistic;
            self.scattered[i] += out - ballistic;
            self.roulette[i] += kept - goes_on;
            self.carried[i] = goes_on;
            *leaving = out;
        }
        for lane in LanesOf(lanes_where(|lane| leaving[lane] > 0.0)) {
            tell(lane, std::slice::from_ref(&leaving[lane]));
        }
        lanes_where(|lane| self.carried[lane] > 0.0)
    }

    #[inline(always)]
    fn flux(&self, lane: usize) -> f64 {
        self.carried[lane]
    }

    fn ledgers(&self) -> Vec<Ledger> {
        let sum = |fraction| match fraction {
            Fraction::Reflected => self.reflected.iter().sum(),
            Fraction::Ballistic => self.ballistic.iter().sum(),
            Fraction::Scattered => self.scattered.iter().sum(),
            Fraction::Absorbed => self.absorbed.iter().sum(),
            Fraction::RouletteNet => self.roulette.iter().sum(),
            Fraction::MisNet => 0.0,
        };
        vec![Ledger::new(sum)]
    }
}
