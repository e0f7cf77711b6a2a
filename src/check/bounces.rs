//! Light that goes from yarn to yarn of the study's cloth by their f*: what leaves, and what views see of it.

use super::cylinder::beam;
use super::gate::{Gate, Law, Where};
use super::medium::few_wavelengths;
use super::{CheckError, Context};
use crate::cloth::light::{
    Beam, ClothFraction, Connected, Detector, Scene, Segments, ViewCones, ViewPaths, YarnSurface, YarnToYarn,
};
use crate::geometry::Vec3;
use crate::optics::Medium;
use crate::rig::omega_in;
use crate::spectrum::WavelengthGrid;
use crate::transport::{Purpose, Stream};
use crate::yarn::{DirectTracer, Effort, SurfaceGrid, Yarn, YarnResponseGrid, YarnSampler, scattered_or_absorbed};
use rand::RngExt;
use rayon::prelude::*;
use std::f64::consts::TAU;

pub const BOUNCES: Law = Law {
    name: "bounces",
    words: "of light that goes from yarn to yarn by f*, reflected + transmitted + absorbed is all in the mean",
};
pub const VIEWS: Law = Law {
    name: "bounces-views",
    words: "views all around see the light that leaves the cloth, as it goes from yarn to yarn by f*, on either side",
};

const ENTERING: Law = Law {
    name: "entering-light",
    words: "of light that a yarn meets, what is neither reflected nor crosses unscattered is that of the closed form, \
            for every tilt",
};

/// Of the light that a yarn meets: 8 × 72 midpoints against Gauss's rule.
const MIDPOINTS: f64 = 5e-3;

/// Axes of f*: the laws hold for any table.
const TILTS: usize = 6;
const AXES: [usize; 3] = [24, 6, 12];
/// Paths of a tilt.
const PATHS: u64 = 2048;
/// Absorption, 1/mm: white yarns, so that all light goes far. With none at all, what a table's noise leaves over of the
/// light would be counted as gained or lost by chance, and not as absorbed.
const MU_A: f64 = 1e-9;
/// Absorption of the tested media, μ_a times the radius; scattering is that of the study at its middle wavelength.
/// Exits are sampled for all wavelengths together, so a wavelength unlike the others would get rare paths of large
/// weight.
const ABSORBING: [f64; 2] = [0.0, 0.02];
/// Range of μ_s times the diameter. With less, more light would pass unscattered, which views do not see; with more,
/// paths would hardly end.
const DEPTHS: [f64; 2] = [4.0, 30.0];
/// Pieces of yarn and squares of the backing in which light forgets where it came in.
const PIECE_RADII: f64 = 0.125;
const SQUARE_RADII: f64 = 0.25;
/// Spacing of a dense weave in radii, how many times more rays and particles the most open one gets, and the most
/// pieces from one crossing to the next.
const DENSE_RADII: f64 = 4.0;
const MOST_OPEN: f64 = 50.0;
const PIECES: f64 = 32.0;
/// Camera rays of a view.
const RAYS: usize = 160;
/// Views of a side and particles of a beam in one round, and the paths of a batch of the ledger that one round goes
/// with.
const VIEWS_OF_ROUND: usize = 2;
const PARTICLES: usize = 64;
const PATHS_OF_ROUND: u64 = 250;
/// Views lower than this see from far away: 4e-4 of the light leaves there.
const LEAST_COSINE: f64 = 0.02;
/// In place of a beam or a view, apart from those of the rig.
const STREAM: usize = 1 << 41;

/// Tolerance of what views see over that of what leaves: few views are worked out, each by few rays.
const SEEN: f64 = 2.0;

const SIDES: [&str; 3] = [", light's side", ", other side", ", both sides"];

/// The sides of the cloth: the light's, and the other.
struct Sides;

impl Detector for Sides {
    fn bins(&self) -> usize {
        2
    }

    fn find(&self, direction: &Vec3, _: f64, mut found: impl FnMut(usize, f64)) {
        found(usize::from(direction.z < 0.0), 1.0);
    }
}

/// Both laws are conditional on the tables of f*, whatever their noise: one small table of each yarn does, at three
/// wavelengths.
pub fn gates(context: &Context) -> Result<[Gate; 3], CheckError> {
    let Context { plan, judge, .. } = context;
    let seed = plan.study.seed;
    let grid = YarnResponseGrid::new(TILTS, SurfaceGrid::new(AXES[0], AXES[1], AXES[2])?)?;
    let yarns: Vec<Yarn> = plan
        .different_yarns()
        .map(|yarn| {
            let (medium, radius_mm) = (&yarn.medium, yarn.cylinder.radius_mm());
            let middle = medium.grid().len() / 2;
            let mu_s = medium.mu_s_per_mm()[middle]
                .max(0.5 * DEPTHS[0] / radius_mm)
                .min(0.5 * DEPTHS[1] / radius_mm);
            let medium = Medium::from_coefficients(
                &WavelengthGrid::new((1..).map(f64::from).take(ABSORBING.len()).collect())?,
                vec![medium.host_index()[middle]; ABSORBING.len()],
                vec![mu_s; ABSORBING.len()],
                ABSORBING.map(|depth| depth / radius_mm + MU_A).to_vec(),
                vec![medium.phase(middle).clone(); ABSORBING.len()],
            )?;
            Ok(Yarn { medium, ..yarn.clone() })
        })
        .collect::<Result<_, CheckError>>()?;
    let scatter = yarns
        .iter()
        .map(|yarn| -> Result<YarnSampler, CheckError> {
            let traced = DirectTracer::new(yarn, grid, Effort::new(seed, 2, 2 * PATHS)?, None)?.batch(0);
            Ok(traced.response.sampler(yarn)?)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let ([Some(warp), Some(weft)], [Some(of_warp), Some(of_weft)]) =
        ([yarns.first(), yarns.last()], [scatter.first(), scatter.last()])
    else {
        return Ok([ENTERING, BOUNCES, VIEWS].map(Gate::undecided));
    };
    let light = YarnToYarn {
        scene: Scene {
            yarns: [warp, weft],
            backing: None,
            // What fibres reflect has a law of its own, and as much of it goes on from smooth yarns.
            surface: match plan.surface(plan.study.specular.surface.is_of_yarns()) {
                YarnSurface::Lost => YarnSurface::Lost,
                YarnSurface::Smooth | YarnSurface::Fibres(_) => YarnSurface::Smooth,
            },
            ..plan.scene(false, false)
        },
        scatter: [of_warp, of_weft],
        most: usize::MAX,
    };
    let radius_mm = plan.cloth_spec.warp_radius_mm.min(plan.cloth_spec.weft_radius_mm);
    // Of an open weave most rays and particles meet no yarn, and a piece of one is seldom met by both.
    let spacing_mm = plan.cloth_spec.warp_spacing_mm.max(plan.cloth_spec.weft_spacing_mm);
    let open = (spacing_mm / (DENSE_RADII * radius_mm)).clamp(1.0, MOST_OPEN);
    let [rays, particles] = [RAYS, PARTICLES].map(|count| (count as f64 * open).ceil() as usize);
    let piece_mm = (PIECE_RADII * radius_mm).max(spacing_mm / PIECES);
    let segments = Segments::new(&plan.cloth, piece_mm, SQUARE_RADII * radius_mm);
    let rounds = context.share(1).div_ceil(PATHS_OF_ROUND) as usize;
    let incidences = plan.rig.incidences_deg();
    let batches: Vec<[Vec<f64>; 2]> = (0..context.batches)
        .into_par_iter()
        .map(|batch| {
            let mut cells = [1, SIDES.len()].map(|sides| vec![0.0; sides * incidences.len() * ABSORBING.len()]);
            for round in 0..rounds {
                // The beams share them.
                let cones = views(seed, batch, round);
                let paths: Vec<ViewPaths> = (cones.views().iter().enumerate())
                    .map(|(k, view)| {
                        let number = STREAM + round * cones.views().len() + k;
                        ViewPaths::new(&light, &segments, view, number, batch, rays)
                    })
                    .collect();
                let connected = Connected {
                    segments: &segments,
                    paths: paths.iter().collect(),
                    cones: &cones,
                    sunlit: false,
                };
                for (k, theta_i_deg) in incidences.iter().enumerate() {
                    let beam = Beam {
                        omega_in: omega_in(*theta_i_deg, plan.study.cloth.azimuth_deg),
                        number: STREAM + round * incidences.len() + k,
                    };
                    for (cells, of_beam) in cells
                        .iter_mut()
                        .zip(of_beam(&light, &connected, &beam, batch, particles))
                    {
                        let here = &mut cells[k * of_beam.len()..][..of_beam.len()];
                        here.iter_mut()
                            .zip(of_beam)
                            .for_each(|(sum, x)| *sum += x / rounds as f64);
                    }
                }
            }
            cells
        })
        .collect();
    let (nets, seen): (Vec<_>, Vec<_>) = batches.into_iter().map(|[net, seen]| (net, seen)).unzip();
    let n = ABSORBING.len();
    let tolerance = plan.study.check.cloth * context.widening;
    let at = |i: usize, sides: usize| {
        let side = if sides == 1 { "" } else { SIDES[i / n % sides] };
        let theta = incidences[i / (sides * n)];
        Where::named(format!("theta_i {theta} deg, mu_a R = {}{side}", ABSORBING[i % n]))
    };
    Ok([
        entering(context, &grid)?,
        judge.zero(BOUNCES, &nets, tolerance, |i| at(i, 1)),
        judge.zero(VIEWS, &seen, SEEN * tolerance, |i| at(i, SIDES.len())),
    ])
}

/// The part that tables of where light leaves are fractions of, summed over where it comes in, for the study's media.
fn entering(context: &Context, grid: &YarnResponseGrid) -> Result<Gate, CheckError> {
    let mut departures = Vec::new();
    let mut places = Vec::new();
    for (system, yarn) in ["warp", "weft"].into_iter().zip(context.plan.different_yarns()) {
        let yarn = few_wavelengths(yarn, |_, own| own)?;
        let medium = &yarn.medium;
        let extinction: Vec<f64> = medium.extinction_per_mm().collect();
        for tilt in 0..grid.tilts() {
            let tilts = grid.tilt_edges(tilt);
            let mut sums = vec![0.0; medium.grid().len()];
            for entry in 0..grid.entries() {
                let kept = scattered_or_absorbed(&yarn, tilts, grid.entry_edges(entry));
                sums.iter_mut().zip(kept).for_each(|(sum, kept)| *sum += kept);
            }
            for (w, sum) in sums.iter().enumerate() {
                let depth = extinction[w] * yarn.cylinder.radius_mm();
                let [_, _, absorbed] = beam(medium.host_index()[w], depth, tilts.map(f64::sin));
                departures.push(sum - absorbed);
                let [low, high] = tilts.map(f64::to_degrees);
                places.push(Where::new(
                    medium.grid().nm()[w],
                    format!("{system}, tilt {low:.0} to {high:.0} deg"),
                ));
            }
        }
    }
    Ok(context
        .judge
        .exact(ENTERING, &departures, MIDPOINTS, |i| places[i].clone()))
}

/// On either side. Directions even in cos²θ and azimuth have the density cosθ/π, so that the mean of β over them is the
/// fraction of a beam that leaves on their side.
fn views(seed: u64, batch: usize, round: usize) -> ViewCones {
    let mut rng = Stream::open(seed, Purpose::Check, STREAM, batch, round);
    let mut towards = Vec::with_capacity(2 * VIEWS_OF_ROUND);
    for side in [1.0, -1.0] {
        let turn: f64 = rng.random();
        for k in 0..VIEWS_OF_ROUND {
            let even = (k as f64 + rng.random::<f64>()) / VIEWS_OF_ROUND as f64;
            towards.push(direction(side, even, turn + k as f64 * GOLDEN));
        }
    }
    // So narrow that no particle is caught: what views are shown is the whole of it.
    ViewCones::new(towards, NARROW)
}

/// Fractions of one batch of a beam: what chance took of the light, at every wavelength; and what views see beyond what
/// leaves, by side and wavelength.
fn of_beam(light: &YarnToYarn, connected: &Connected, beam: &Beam, batch: usize, particles: usize) -> [Vec<f64>; 2] {
    let (beta, ledger) = light.between(beam, connected, batch, particles);
    let straight = light.straight(beam, &Sides, batch, particles);
    let nets = ledger.iter().map(|ledger| ledger[ClothFraction::SamplingNet]).collect();
    let mut seen = Vec::with_capacity(SIDES.len() * ABSORBING.len());
    for (side, (beta, straight)) in beta.chunks_exact(VIEWS_OF_ROUND).zip(straight).enumerate() {
        for (w, straight) in straight.into_iter().enumerate() {
            let shown = beta.iter().map(|beta| beta[w]).sum::<f64>() / VIEWS_OF_ROUND as f64;
            seen.push(
                shown + straight
                    - [
                        ledger[w][ClothFraction::Reflected],
                        ledger[w][ClothFraction::ThroughYarns],
                    ][side],
            );
        }
    }
    let both: Vec<f64> = (0..ABSORBING.len())
        .map(|w| seen[w] + seen[ABSORBING.len() + w])
        .collect();
    seen.extend(both);
    [nets, seen]
}

const GOLDEN: f64 = 0.618_033_988_749_894_9;
const NARROW: f64 = 1e-6;

/// On the side of a cloth, by the square of the cosine and the azimuth in turns.
fn direction(side: f64, cos2: f64, turns: f64) -> Vec3 {
    let cos = cos2.sqrt().max(LEAST_COSINE);
    let sin = (1.0 - cos * cos).sqrt();
    let (sin_phi, cos_phi) = (TAU * turns).sin_cos();
    Vec3::new(sin * cos_phi, sin * sin_phi, side * cos)
}
