use super::entrance::Entrance;
use super::flights::{Flights, Mask, Step};
use super::{Interior, Ledger, Roulette};

/// What the paths under way carry, and the sums of what became of it.
pub(super) trait Weights<'a> {
    /// Every path comes with a weight of 1 at every wavelength, or with the row of `incident` that has its number.
    fn new(interior: &Interior<'_>, incident: Option<&'a [f32]>) -> Self;

    /// Looks at the paths that wait at the entrance.
    fn prepare(&mut self, interior: &Interior<'_>, entrance: &Entrance);

    /// Begins the path that waits at a place of the entrance in a lane: `crossing` becomes what leaves on the far side
    /// without meeting a particle. Returns the probability P that the hero does anything else on its first flight, under
    /// the condition of which the path is drawn.
    fn begin(&mut self, interior: &Interior<'_>, entrance: &Entrance, place: usize, lane: usize, hero: usize) -> f64;

    /// Fractions of the path's incident flux, one for each wavelength, that cross unscattered.
    fn crossing(&self) -> &[f64];

    /// Takes every lane through the step: absorption, turns, light that leaves, which `tell` gets lane by lane with its
    /// fraction of the path's incident flux at each wavelength, and roulette. Returns the lanes whose paths go on.
    fn meet(
        &mut self,
        interior: &Interior<'_>,
        roulette: &Roulette,
        flights: &Flights,
        step: &Step,
        tell: impl FnMut(usize, &[f64]),
    ) -> Mask;

    /// Sums over all paths, of each wavelength.
    fn ledgers(&self) -> Vec<Ledger>;
}

/// Events on end without light that leaves, after which a path has its turn at roulette all the same.
pub(super) const EVENTS_AT_MOST: u64 = 32;
