use super::{Effort, Sharing, Yarn, YarnError};
use crate::geometry::Vec3;
use crate::transport::{ENTRY_COORDINATES, Entry, Exit, Ledger, Purpose, Stream};
use std::ops::Range;

/// Light source of the paths, divided into numbered parts: tilts of a beam, incident directions of a patch.
pub(super) trait LightSource: Sync {
    /// Purpose of the random stream, which separates the random numbers of different sources.
    fn purpose(&self) -> Purpose;

    /// Entry of a path of a part, from uniform random numbers in [0, 1); the first is stratified over the paths.
    fn entry(&self, part: usize, uniform: &[f64; ENTRY_COORDINATES]) -> Entry;
}

/// Traces the light of a source through a yarn, part by part and batch by batch.
pub(super) struct Tracer<'a, S> {
    yarn: &'a Yarn,
    sharing: Vec<Sharing<'a>>,
    effort: Effort,
    pub source: S,
}

impl<'a, S: LightSource> Tracer<'a, S> {
    pub fn new(yarn: &'a Yarn, source: S, effort: Effort) -> Result<Self, YarnError> {
        Ok(Self {
            yarn,
            sharing: yarn.sharing()?,
            effort,
            source,
        })
    }

    pub fn yarn(&self) -> &'a Yarn {
        self.yarn
    }

    pub fn wavelengths(&self) -> usize {
        self.yarn.wavelengths()
    }

    pub fn paths_per_batch(&self) -> usize {
        self.effort.paths_per_batch
    }

    /// Fraction of the light of a part that one path represents.
    pub fn share_of_path(&self) -> f64 {
        1.0 / self.effort.paths_per_batch as f64
    }

    /// Traces one part of a batch. `tally` receives each exit and the range of wavelengths its weights apply to.
    /// Returns one ledger for each wavelength, as fractions of the part's light.
    pub fn part(&self, batch: usize, part: usize, mut tally: impl FnMut(&Exit<'_>, Range<usize>)) -> Vec<Ledger> {
        let share = self.share_of_path();
        let mut ledgers = Vec::with_capacity(self.wavelengths());
        for sharing in &self.sharing {
            let here = sharing.first..sharing.first + sharing.interior.wavelengths();
            let stream = Stream::open(self.effort.seed, self.source.purpose(), part, batch, sharing.first);
            let traced = self.yarn.walk(&sharing.interior).trace(
                stream,
                self.effort.paths_per_batch,
                |uniform| self.source.entry(part, uniform),
                |exit| tally(exit, here.clone()),
            );
            ledgers.extend(traced.ledgers.iter().map(|sum| sum.scaled(share)));
        }
        ledgers
    }
}

/// Parallel beams over the whole width of a yarn. A part is a band of tilts between two sines, over which beams are
/// uniform in sin ψ: uniform radiance from that band of directions.
pub(super) struct ParallelBeam {
    pub purpose: Purpose,
    pub radius_mm: f64,
    /// Limits of sin ψ of each part.
    pub sines: Vec<[f64; 2]>,
    /// Whether light comes from both sides of the plane normal to the yarn, or from +y alone.
    pub both_sides: bool,
}

impl LightSource for ParallelBeam {
    fn purpose(&self) -> Purpose {
        self.purpose
    }

    #[inline(always)]
    fn entry(&self, part: usize, [across, along, side, _]: &[f64; ENTRY_COORDINATES]) -> Entry {
        let [low, high] = self.sines[part];
        let h = 2.0 * across - 1.0;
        let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
        let sine = low + (high - low) * along;
        let reversed = self.both_sides && *side >= 0.5;
        Entry {
            position: normal * self.radius_mm,
            normal,
            omega_in: Vec3::new(0.0, if reversed { -sine } else { sine }, (1.0 - sine * sine).sqrt()),
        }
    }
}
