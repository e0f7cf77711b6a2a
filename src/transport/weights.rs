use super::entrance::Entrance;
use super::flights::{Flights, Mask, Step};
use super::{Interior, Ledger, Roulette};

/// Weights of the paths being traced, and the ledger sums of all paths.
pub(super) trait Weights<'a> {
    /// Every path has an incident flux of 1 at every wavelength, or the row of `incident` with the path's index.
    fn new(interior: &Interior<'_>, incident: Option<&'a [f32]>) -> Self;

    /// Called when a new set of paths waits at the entrance; precomputes what can be vectorised over them.
    fn prepare(&mut self, interior: &Interior<'_>, entrance: &Entrance);

    /// Starts the path at position `place` of the entrance in a lane; [`Self::crossing`] then holds the part that
    /// crosses unscattered. Returns the probability P that the hero's first flight does not cross, on which the path is
    /// conditioned.
    fn begin(&mut self, interior: &Interior<'_>, entrance: &Entrance, place: usize, lane: usize, hero: usize) -> f64;

    /// Fractions of the path's incident flux, one for each wavelength, that cross unscattered.
    fn crossing(&self) -> &[f64];

    /// Applies a step to the weights of every lane: absorption, scattering, exits and Russian roulette. Passes the
    /// light that leaves each lane to `tell`, as fractions of the path's incident flux at each wavelength. Returns the
    /// lanes whose paths continue.
    fn meet(
        &mut self,
        interior: &Interior<'_>,
        roulette: &Roulette,
        flights: &Flights,
        step: &Step,
        tell: impl FnMut(usize, &[f64]),
    ) -> Mask;

    /// Present flux of a lane's path at the first wavelength, as a fraction of its incident flux.
    fn flux(&self, lane: usize) -> f64;

    /// Ledger sums over all paths, one for each wavelength.
    fn ledgers(&self) -> Vec<Ledger>;
}

/// Number of consecutive events without an exit after which Russian roulette applies all the same.
pub(super) const EVENTS_AT_MOST: u64 = 32;
