//! Memory that a run takes, from its study alone: looked at before any work, so that a study too large for the machine
//! is refused by the key that makes it so. It decides whether a run begins, and about no result.

use crate::number::{shown, to_two_digits};
use crate::study::{MethodChoice, ShadeWith, Study, StudyError};
use crate::yarn::LengthBins;

/// What a study is run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Views of the cloth: `report` and `measure`.
    Views,
    /// The yarn alone: `trace`.
    Yarn,
    /// Laws as gates: `check`.
    Check,
    /// The whole BSDF of the cloth: `bsdf`, of so many incidences that are traced, each caught in so many bins; by f*,
    /// whose tables of all batches are then held, or through the media.
    Full {
        incidences: usize,
        bins: usize,
        by_factor: bool,
    },
}

/// Batches of views that are under way at once at most; each holds a table of f*.
pub const BATCHES_UNDER_WAY: usize = 4;

/// Bytes that are taken for free where the system does not say.
const UNKNOWN_FREE: f64 = 4e9;
/// Bytes of program, cloth and built-in tables.
const PROGRAM: f64 = 28e6;
/// Bytes of a camera ray's end with its place among the exit directions, and of an end of a view's ray with its
/// position.
const CAMERA_RAY: f64 = 320.0;
const SIGHT: f64 = 170.0;
/// Rays of a view where light goes from yarn to yarn, at most.
const SIGHTS: f64 = 4096.0;
/// Cells of f* that a camera ray weighs, and bytes of each.
const CELLS_OF_RAY: f64 = 10.0;
const WEIGHT: f64 = 12.0;
/// Bytes of a cell of f* of one wavelength, and of its weight.
const WHITE: f64 = 16.2;
/// Of a table of f*, what scattering by it from yarn to yarn takes besides.
const SCATTER: f64 = 0.5;
/// Bytes of a row of the energy ledger with its texts.
const ENERGY_ROW: f64 = 1000.0;
/// Places on the section where light enters, of each of which f* has where it leaves.
const ENTRIES: f64 = 9.0;

/// A key that makes tables larger: its name, its value, and numbers of which its values are multiples.
struct Size {
    key: &'static str,
    of: fn(&mut Study) -> &mut u32,
    multiple: u32,
}

const SIZES: [Size; 12] = [
    size("rig.pixels_per_side", |s| &mut s.rig.pixels_per_side, 1),
    size("trace.exit_azimuth_cells", |s| &mut s.trace.exit_azimuth_cells, 4),
    size("trace.exit_theta_cells", |s| &mut s.trace.exit_theta_cells, 1),
    size("trace.exit_phi_cells", |s| &mut s.trace.exit_phi_cells, 4),
    size("trace.tilts", |s| &mut s.trace.tilts, 1),
    size("trace.zenith_cells", |s| &mut s.trace.zenith_cells, 1),
    size("trace.azimuth_cells", |s| &mut s.trace.azimuth_cells, 4),
    size("trace.bssrdf_azimuth_cells", |s| &mut s.trace.bssrdf_azimuth_cells, 4),
    size(
        "trace.bssrdf_exit_theta_cells",
        |s| &mut s.trace.bssrdf_exit_theta_cells,
        1,
    ),
    size("trace.bssrdf_exit_phi_cells", |s| &mut s.trace.bssrdf_exit_phi_cells, 4),
    size("trace.z_cells", |s| &mut s.trace.z_cells, 2),
    size("trace.batches", |s| &mut s.trace.batches, 1),
];

const fn size(key: &'static str, of: fn(&mut Study) -> &mut u32, multiple: u32) -> Size {
    Size { key, of, multiple }
}

/// Refuses a study whose tables do not fit into the memory that is free, on as many threads as there are.
///
/// # Errors
/// The key that takes most beyond its default: its value, the estimate, and the largest value that would fit.
pub fn check_memory(study: &Study, stage: Stage) -> Result<(), StudyError> {
    refuse_beyond(study, stage, rayon::current_num_threads(), free_bytes())
}

/// [`check_memory`] for so many threads and free bytes.
///
/// # Errors
/// As [`check_memory`].
pub fn refuse_beyond(study: &Study, stage: Stage, threads: usize, free: f64) -> Result<(), StudyError> {
    let needed = bytes(study, stage, threads);
    if needed <= free {
        return Ok(());
    }
    let mut defaults = Study::default();
    let with = |size: &Size, value: u32| {
        let mut study = study.clone();
        *(size.of)(&mut study) = value;
        bytes(&study, stage, threads)
    };
    let mut found = study.clone();
    let with_default = |size: &Size, defaults: &mut Study, found: &mut Study| {
        let value = *(size.of)(found);
        with(size, value.min(*(size.of)(defaults)))
    };
    let dominating = SIZES.iter().min_by(|a, b| {
        let [a, b] = [a, b].map(|size| with_default(size, &mut defaults, &mut found));
        a.total_cmp(&b)
    });
    let takes = format!(
        "which takes about {} of memory where {} are free",
        in_bytes(needed),
        in_bytes(free)
    );
    let refuse = |key: &str, expected: String, found: String, remedy: String| {
        Err(StudyError::Value {
            place: study.origin.place(key),
            key: key.into(),
            expected,
            found: format!("{found}, {takes}"),
            remedy,
        })
    };
    let Some(size) = dominating.filter(|size| with_default(size, &mut Study::default(), &mut study.clone()) < needed)
    else {
        let wavelengths = study.spectrum.wavelengths().len();
        let key = match study.spectrum.wavelengths_nm {
            Some(_) => "spectrum.wavelengths_nm",
            None => "spectrum.wavelength_step_nm",
        };
        return refuse(
            key,
            "fewer wavelengths, with which the tables fit".into(),
            format!("{wavelengths} wavelengths"),
            "take fewer".into(),
        );
    };
    let value = *(size.of)(&mut found);
    // The largest multiple that fits: more never takes less.
    let (mut fits, mut beyond) = (0, value / size.multiple);
    while beyond - fits > 1 {
        let middle = fits + (beyond - fits) / 2;
        match with(size, middle * size.multiple) <= free {
            true => fits = middle,
            false => beyond = middle,
        }
    }
    match fits * size.multiple {
        0 => refuse(
            size.key,
            "a study whose tables fit".into(),
            value.to_string(),
            "reduce it and the other cells, which do not fit with any value of it".into(),
        ),
        most => refuse(
            size.key,
            format!("at most {most} beside the rest of the study"),
            value.to_string(),
            "reduce it".into(),
        ),
    }
}

/// Estimate of all tables that are held at once.
pub fn bytes(study: &Study, stage: Stage, threads: usize) -> f64 {
    let trace = &study.trace;
    let n = |count: u32| f64::from(count);
    let wavelengths = study.spectrum.wavelengths().len() as f64;
    let threads = threads as f64;
    let yarns = if study.weft.medium(&study.medium) == study.medium && study.weft.radius_mm.is_none() {
        1.0
    } else {
        2.0
    };
    let fold = if trace.fold_symmetry { 4.0 } else { 1.0 };
    let directions = n(trace.zenith_cells) * n(trace.azimuth_cells) / fold;
    let azimuths = 0.5 * n(trace.exit_azimuth_cells);
    let cells = n(trace.tilts) * azimuths * n(trace.exit_theta_cells) * n(trace.exit_phi_cells);
    let passages = n(trace.tilts) * ENTRIES * 2.0 * azimuths;
    let table = 8.0 * wavelengths * (cells + passages);
    let bssrdf = wavelengths
        * directions
        * n(trace.bssrdf_azimuth_cells)
        * (n(trace.z_cells) + 2.0)
        * n(trace.bssrdf_exit_theta_cells)
        * n(trace.bssrdf_exit_phi_cells);
    // Fractions of all directions, and those tilts of f* that the directions reach which are held at once.
    let of_patch = 8.0 * bssrdf + 2.0 * table;
    let ledgers = n(trace.batches) * directions * wavelengths * 100.0;
    match stage {
        // One table of the yarn after the other, of which paths touch a part: an upper bound.
        Stage::Check => PROGRAM + of_patch,
        Stage::Yarn => {
            let lengths = LengthBins::DEFAULT as f64 * wavelengths * cells;
            // Single precision of a batch, sums and squares; both estimates of f*; amounts and moments of the lengths,
            // of the tilts one by one and together, and their sums.
            PROGRAM + of_patch + 20.0 * bssrdf + 8.0 * table + 28.0 * lengths + ledgers
        }
        Stage::Full {
            incidences,
            bins,
            by_factor,
        } => {
            let values = bins as f64 * wavelengths;
            let tables = match by_factor {
                true => yarns * table * (n(trace.batches) * (1.0 + SCATTER) + 2.0),
                false => 0.0,
            };
            // Of each incidence sums, squares and what is written of it; of those under way every batch.
            PROGRAM + tables + incidences as f64 * values * 60.0 + threads * n(trace.batches) * values * 8.0
        }
        Stage::Views => {
            let [views, incidences] = [study.rig.views_deg().len(), study.rig.incidences_deg.len()].map(|n| n as f64);
            let pixels = n(study.rig.pixels_per_side).powi(2);
            // Of each batch under way: the tables of all yarns, and what the camera saw.
            let direct = yarns * table + 9.0 * yarns * cells;
            let camera = |geometries: f64| geometries * WEIGHT * cells.min(CELLS_OF_RAY * pixels);
            let between =
                |views: f64| SCATTER * yarns * table + views * SIGHTS.min(4.0 * pixels) * (SIGHT + 4.0 * wavelengths);
            let goes_on = study.cloth.bounces.most() > 0
                || study.specular.surface.is_of_yarns()
                || !["none", "black"].contains(&study.cloth.backing.as_str());
            let seen = camera(views * incidences) + if goes_on { between(views) } else { 0.0 };
            let simulated = match (study.cloth.method, trace.shade_with) {
                (MethodChoice::Volumetric, _) => 0.0,
                (_, ShadeWith::Direct) => direct + seen,
                (_, ShadeWith::Bssrdf) => direct + yarns * of_patch + seen,
            };
            let rays = threads * pixels * CAMERA_RAY;
            // Table 1 has rows of light between the yarns, of one batch at a time at one geometry.
            let at_normal = direct + camera(1.0) + between(1.0) + rays;
            // The search for gains at grazing incidence, before the batches: a white f* and its weights on each thread.
            let grazing = threads.min(incidences) * WHITE * cells;
            let under_way = threads.min(BATCHES_UNDER_WAY as f64);
            let kept = n(trace.batches) * views * incidences * wavelengths * 24.0;
            let rows = n(trace.zenith_cells) * n(trace.azimuth_cells) * wavelengths * ENERGY_ROW;
            PROGRAM + at_normal.max(grazing).max(under_way * simulated + rays) + kept + ledgers + rows
        }
    }
}

/// Bytes of memory that the system has for new work.
fn free_bytes() -> f64 {
    let kilobytes = || {
        let text = std::fs::read_to_string("/proc/meminfo").ok()?;
        let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
        line.split_whitespace().nth(1)?.parse::<f64>().ok()
    };
    kilobytes().map_or(UNKNOWN_FREE, |kilobytes| 1024.0 * kilobytes)
}

fn in_bytes(bytes: f64) -> String {
    match bytes {
        _ if bytes >= 1e12 => format!("{} TB", shown(to_two_digits(bytes * 1e-12))),
        _ if bytes >= 1e9 => format!("{:.1} GB", bytes * 1e-9),
        _ => format!("{:.0} MB", bytes * 1e-6),
    }
}
