//! Every key of a study file, a row each: name, type, default, kind with range, unit, and above them what it means.
//! From these rows come the structs and their defaults, the reader, the ranges, the messages, the file that
//! `specval init` writes and docs/study.md. The form of a row: the macro `sections` of [`super::table`].

use serde::{Deserialize, Serialize};

use super::Origin;
use super::choices::{
    BounceLimit, CentreLineChoice, DistributionChoice, DyeChoice, EstimatorChoice, GeometryChoice, InterferenceChoice,
    MethodChoice, NumberOrTable, ShadeWith, SurfaceChoice,
};
use super::fields::{self, Field, Range, Section, ValueKind, above, below, between, closed};
use super::free_key::FreeKey;
use crate::cloth::Weave;
use crate::colour::{Adaptation, Convention, Illuminant, Observer, RgbSpace};

const WAVELENGTH: Range = closed(100.0, 10_000.0);
const INDEX: Range = closed(1.0, 4.0);
const KAPPA: Range = closed(0.0, 10.0);
/// Size parameters within those of [`crate::optics::mie`], and phase functions that a table resolves at the default
/// wavelengths.
const DIAMETER: Range = closed(0.01, 20_000.0);
const VIEW: Range = between(-90.0, 90.0);
/// Squares of lengths and their quotients neither overflow nor vanish.
const LENGTH: Range = closed(1e-6, 100.0);
const SPACING: Range = above(1.0, 100.0);
/// Equal spheres cannot fill more than π/√18 = 0.7405 of a volume.
const FRACTION: Range = below(0.0, 0.74);
const ROUGHNESS: Range = closed(0.001, 1.0);
const FLATTENING: Range = closed(0.2, 5.0);
const VARIATION: Range = closed(0.0, 0.2);
/// Of the incident flux.
const TOLERANCE: Range = above(0.0, 1.0);
const CELLS: ValueKind = ValueKind::Integer(1, 1000);
const FOURS: ValueKind = ValueKind::Multiple(4, 1000, 4);
const PATHS: ValueKind = ValueKind::Integer(2, 1_000_000_000_000);
/// TOML has no unsigned 64-bit integers.
const SEED: ValueKind = ValueKind::Integer(0, i64::MAX as u64);

study! {
/// A study. The default is the built-in one.
pub struct Study {
    /// Seed of every random number. The same study and seed give the same result on any number of threads.
    seed: u64 = 1, SEED, "";

    [spectrum] SpectrumSection;
    [medium] MediumSection;
    [yarn] YarnSection;
    [weft] WeftSection, unless "WeftSection::is_default";
    [trace] TraceSection;
    [cloth] ClothSection;
    [specular] SpecularSection;
    [rig] RigSection;
    [colour] ColourSection;
    [measured] MeasuredSection;
    [sweep] SweepSection;
    [fit] FitSection, unless "FitSection::is_default";
    [check] CheckSection;
}
}

sections! {
/// The wavelengths (in vacuum) at which everything is computed.
pub struct SpectrumSection {
    /// First wavelength.
    wavelength_min_nm: f64 = 390.0, Number(WAVELENGTH), "nm";
    /// Last wavelength, a whole number of steps above the first.
    wavelength_max_nm: f64 = 730.0, Number(WAVELENGTH), "nm";
    /// Step between wavelengths.
    wavelength_step_nm: f64 = 10.0, Number(above(0.0, 1000.0)), "nm";
    /// An ascending list to use in place of the three above.
    wavelengths_nm: Option<Vec<f64>> = None, Numbers(WAVELENGTH, 1), "nm", example "[450.0, 550.0, 650.0]";
}

/// What fills the yarn: equal dyed spheres in a clear host.
pub struct MediumSection {
    /// Refractive index of the host.
    host_index: NumberOrTable = 1.557.into(), NumberOrTable(INDEX), "";
    /// Absorption coefficient of the host.
    host_mu_a_per_mm: NumberOrTable = 0.0.into(), NumberOrTable(closed(0.0, 1e6)), "1/mm";
    /// Refractive index of the particles, absolute.
    particle_index: NumberOrTable = 1.61.into(), NumberOrTable(INDEX), "";
    /// Diameter (not radius) of the particles.
    particle_diameter_nm: f64 = 150.0, Number(DIAMETER), "nm";
    /// Share of the yarn's volume that is particles.
    volume_fraction: f64 = 0.14, Number(FRACTION), "";
    /// Imaginary part of the particles' refractive index at the peak of the dye.
    kappa_peak: f64 = 0.0065, Number(KAPPA), "";
    /// Shape of the dye's absorption over wavelength, 1 at its peak: a built-in dye, or a path to a CSV or CGATS text.
    dye: String = "preprint-red".into(), Text, "";
    /// Particles scatter as if alone, or with the Percus-Yevick structure factor of hard spheres.
    interference: InterferenceChoice = InterferenceChoice::Independent, Choice(InterferenceChoice::NAMES), "";
}

/// An infinite circular cylinder.
pub struct YarnSection {
    /// Radius of the yarn.
    radius_mm: f64 = 0.15, Number(LENGTH), "mm";
    /// Angle of the fibres to the axis of warps and wefts, where [specular] surface is "fibres": positive Z twist,
    /// negative S twist; 0, along the axis, where it is left out.
    twist_deg: Option<f64> = None, Number(closed(-90.0, 90.0)), "degrees", example "20.0";
}

/// In what the weft differs from the warp. What is left out is as in [medium], [yarn] and [cloth].
pub struct WeftSection {
    radius_mm: Option<f64> = None, as YarnSection, example "0.12";
    /// Distance of neighbouring wefts, in mean diameters of warp and weft.
    spacing_diameters: Option<f64> = None, Number(SPACING), "yarn diameters", example "2.0";
    host_index: Option<NumberOrTable> = None, as MediumSection, example "1.557";
    host_mu_a_per_mm: Option<NumberOrTable> = None, as MediumSection, example "0.0";
    particle_index: Option<NumberOrTable> = None, as MediumSection, example "1.61";
    particle_diameter_nm: Option<f64> = None, as MediumSection, example "150.0";
    volume_fraction: Option<f64> = None, as MediumSection, example "0.14";
    kappa_peak: Option<f64> = None, as MediumSection, example "0.0";
    dye: Option<String> = None, as MediumSection, example "\"preprint-red\"";
    interference: Option<InterferenceChoice> = None, as MediumSection, example "\"independent\"";
}

/// Monte Carlo simulation of light in the yarn.
pub struct TraceSection {
    /// Shared: one path for all wavelengths of one host index. Independent: a path each.
    estimator: EstimatorChoice = EstimatorChoice::Shared, Choice(EstimatorChoice::NAMES), "";
    /// Batches a direction; their means give the standard errors.
    batches: u32 = 16, Integer(2, 100_000), "";
    /// Paths for each incident direction and wavelength of the BSSRDF, at least one a batch.
    paths_bssrdf: u64 = 20_000, PATHS, "";
    /// Paths for each tilt and wavelength of the direct simulation, at least one a batch.
    paths_direct: u64 = 600_000, PATHS, "";
    /// Particles of each beam that are followed from yarn to yarn where yarns scatter by f*.
    particles: u64 = 48_000, PATHS, "";
    /// Particles of each beam of the volumetric method.
    particles_volumetric: u64 = 2_000_000, PATHS, "";
    /// Share of its first weight below which Russian roulette may end a path.
    roulette_threshold: f64 = 0.1, Number(between(0.0, 1.0)), "";
    /// Probability of surviving the roulette.
    roulette_survival: f64 = 0.2, Number(between(0.0, 1.0)), "";
    /// Incident directions: cells in the zenith angle from the normal of the entry patch.
    zenith_cells: u32 = 9, CELLS, "";
    /// Incident directions: cells in azimuth about that normal.
    azimuth_cells: u32 = 16, FOURS, "";
    /// Cells around the yarn where light leaves.
    exit_azimuth_cells: u32 = 36, FOURS, "";
    /// Exit directions: cells in the zenith angle.
    exit_theta_cells: u32 = 12, CELLS, "";
    /// Exit directions: cells in azimuth.
    exit_phi_cells: u32 = 24, FOURS, "";
    /// Cells around the yarn of the stored BSSRDF, whose table has two more axes.
    bssrdf_azimuth_cells: u32 = 20, FOURS, "";
    /// Its exit directions: cells in the zenith angle.
    bssrdf_exit_theta_cells: u32 = 6, CELLS, "";
    /// Its exit directions: cells in azimuth.
    bssrdf_exit_phi_cells: u32 = 12, FOURS, "";
    /// Cells along the yarn where light leaves.
    z_cells: u32 = 8, Multiple(2, 1000, 2), "";
    /// Direct simulation: directions of the beam between across and along the yarn.
    tilts: u32 = 10, CELLS, "";
    /// Trace a quarter of the directions and mirror the rest.
    fold_symmetry: bool = true, Flag, "";
    /// Response f* of the cloth's yarns: from the direct simulation, or from the sum of the BSSRDF.
    shade_with: ShadeWith = ShadeWith::Direct, Choice(ShadeWith::NAMES), "";
}

/// The weave and the geometry of its yarns.
pub struct ClothSection {
    /// Which yarn is on top at each crossing: a built-in weave, or a WIF file, whose smallest repeat is woven;
    /// `specval weave` prints it.
    weave: String = "plain".into(), ChoiceOrPath(Weave::NAMES), "";
    /// Arcs and straights (Peirce 1937), or a sinusoid.
    centre_line: CentreLineChoice = CentreLineChoice::Peirce, Choice(CentreLineChoice::NAMES), "";
    /// Distance of neighbouring yarns, in mean diameters of warp and weft; a plain weave of equal round yarns jams at
    /// 1.73.
    spacing_diameters: f64 = 1.8, Number(SPACING), "yarn diameters";
    /// Amplitude of the sinusoid; by default the smallest, in steps of 2 % of that at which yarns touch where they
    /// cross, at which they do not overlap.
    sinusoid_amplitude_mm: Option<f64> = None, Number(LENGTH), "mm", example "0.15";
    /// Turn of the cloth in its plane: warp from the plane of incidence.
    azimuth_deg: f64 = 0.0, Number(closed(-360.0, 360.0)), "degrees";
    /// Light in the cloth: scattered by the yarns' f*, or traced through the medium of every yarn it meets.
    method: MethodChoice = MethodChoice::RadianceFactor, Choice(MethodChoice::NAMES), "";
    /// Yarns that light may go on to after the first it met, where yarns scatter by f*; 0 is the preprint's shading.
    bounces: BounceLimit = BounceLimit::Most(0), IntegerOr(0, 1000, "all"), "";
    /// What lies under the cloth: "none", "black", "white" (a perfect diffuser), or a path to a spectrum of its
    /// reflectance.
    backing: String = "none".into(), Text, "";
    /// Width over height of the warp yarns' elliptical section, whose area is that of the yarn's radius.
    warp_flattening: f64 = 1.0, Number(FLATTENING), "";
    /// The same of the weft yarns.
    weft_flattening: f64 = 1.0, Number(FLATTENING), "";
    /// Relative standard deviation of the yarns' radii from one to the next.
    radius_variation: f64 = 0.0, Number(VARIATION), "";
    /// Relative standard deviation of the distances between neighbouring yarns.
    spacing_variation: f64 = 0.0, Number(VARIATION), "";
    /// Repeats of the weave along warp and weft before variations come again.
    repeats: u32 = 1, Integer(1, 128), "";
    /// Seed of the variations, apart from the study's.
    variation_seed: u64 = 1, SEED, "";
}

/// Gloss about the cloth's normal (Cook-Torrance), for model and classical shading alike.
pub struct SpecularSection {
    /// What shines: the cloth about its normal (Cook-Torrance); or the surface of each yarn (Fresnel), smooth or of
    /// fibres that spread the light, which goes on to other yarns; classical shading is about the cloth's normal in any
    /// case.
    surface: SurfaceChoice = SurfaceChoice::Cloth, Choice(SurfaceChoice::NAMES), "";
    /// Root mean square slope of the facets; of fibres the width of the distribution (Trowbridge-Reitz) of slopes along
    /// them.
    roughness: f64 = 0.4, Number(ROUGHNESS), "";
    /// The same across fibres, where surface is "fibres": height over width of their sections, 1 of round ones; 0.6
    /// where it is left out.
    roughness_across: Option<f64> = None, Number(ROUGHNESS), "", example "0.6";
    /// Distribution of their slopes.
    distribution: DistributionChoice = DistributionChoice::Beckmann, Choice(DistributionChoice::NAMES), "";
    /// Refractive index of the surface.
    index: f64 = 1.557, Number(INDEX), "";
    /// Factor of the whole term; 0 switches it off.
    weight: f64 = 0.25, Number(closed(0.0, 1.0)), "";
}

/// The virtual goniophotometer.
pub struct RigSection {
    /// What a report measures: "auto" the sample's own geometries, unless the four keys below differ from these values;
    /// "rig" those of the four keys. Left out beside one of the four, it is "rig".
    geometries: GeometryChoice = GeometryChoice::Auto, Choice(GeometryChoice::NAMES), "";
    /// Angles of incidence, from the normal.
    incidences_deg: Vec<f64> = vec![0.0, 30.0, 60.0], Numbers(below(0.0, 90.0), 1), "degrees";
    /// First view angle: negative on the light's side of the normal.
    view_min_deg: f64 = -60.0, Number(VIEW), "degrees";
    /// Last view angle: positive on the specular side.
    view_max_deg: f64 = 70.0, Number(VIEW), "degrees";
    /// Step between view angles.
    view_step_deg: f64 = 5.0, Number(above(0.0, 180.0)), "degrees";
    /// Pixels a side over one unit cell of the cloth.
    pixels_per_side: u32 = 32, Integer(1, 10_000), "";
    /// Half angle of the cone about a view in which light is caught that leaves a smooth surface, and all light of the
    /// volumetric method.
    aperture_half_angle_deg: f64 = 5.0, Number(closed(0.1, 20.0)), "degrees";
}

/// From spectra to colours; the same for model, classical and measured.
pub struct ColourSection {
    /// Colour-matching functions; a file has the columns wavelength_nm,xbar,ybar,zbar, or is CGATS text.
    observer: String = Convention::default().observer.to_string(), ChoiceOrPath(Observer::NAMES), "";
    /// Light in which the cloth is seen, relative power; a file has the columns wavelength_nm,value, or is CGATS text.
    illuminant: String = Convention::default().illuminant.to_string(), ChoiceOrPath(Illuminant::NAMES), "";
    /// Primaries and white of the linear RGB.
    rgb: RgbSpace = Convention::default().rgb, Choice(RgbSpace::NAMES), "";
    /// From the illuminant's white to that of the RGB space.
    adaptation: Adaptation = Convention::default().adaptation, Choice(Adaptation::NAMES), "";
}

/// The measured sample to compare with.
pub struct MeasuredSection {
    /// A built-in sample, or a path to the folder of one.
    sample: String = "merl-red-fabric".into(), Text, "";
}

/// Values of parameters for the model's range in Table 1. Each is varied alone; an empty list leaves it alone.
pub struct SweepSection {
    /// As in [medium].
    kappa_peak: Vec<f64> = vec![0.002, 0.0065, 0.012], Numbers(KAPPA, 0), "";
    /// As in [medium].
    volume_fraction: Vec<f64> = vec![0.07, 0.14, 0.21], Numbers(FRACTION, 0), "";
    /// As in [medium].
    particle_diameter_nm: Vec<f64> = vec![100.0, 150.0, 300.0], Numbers(DIAMETER, 0), "nm";
    /// As in [medium]; each takes the place of a table there.
    particle_index: Vec<f64> = vec![1.59, 1.61, 1.63], Numbers(INDEX, 0), "";
}

/// What `specval fit` varies to bring the model near to the sample.
pub struct FitSection {
    /// Keys that vary, with bounds; a scale "log" (else "linear"), a prior with its standard deviation, and further keys
    /// that take the same value, in `also`. The lower bound of cloth.spacing_diameters rises to the least spacing that
    /// the yarns allow.
    free: Vec<FreeKey> = FreeKey::defaults(), FreeKeys, "";
    /// Absorption: "free", a spectrum that is fitted and takes the place of the particles' and the host's absorption of
    /// both yarns; or "fixed", as [medium] has it.
    dye: DyeChoice = DyeChoice::Free, Choice(DyeChoice::NAMES), "";
    /// Bounds of the free absorption.
    dye_bounds_per_mm: Vec<f64> = vec![1e-3, 300.0], Numbers(above(0.0, 1e5), 2), "1/mm";
    /// Of spectral samples: standard deviation of the second difference of the logarithm of the free absorption between
    /// neighbouring wavelengths, where nothing else is known of it.
    dye_roughness: f64 = 0.3, Number(above(0.0, 100.0)), "";
    /// Particles for each incidence and each wavelength at which scattering is traced, of one evaluation of the model.
    particles: u64 = 8_000, PATHS, "";
    /// Azimuths of the cloth over which a batch averages where the sample is isotropic.
    azimuths: u32 = 2, Integer(1, 64), "";
    /// Largest degree of the polynomials of direction that expand the reflected radiance.
    expansion_order: u32 = 6, Integer(2, 12), "";
}

/// What `specval check` must not miss. A stochastic gate that could miss a departure of its tolerance says that it
/// is inconclusive, and how many paths would be enough; with --quick these tolerances are 2.8 times as wide.
pub struct CheckSection {
    /// Probability that any gate of a run breaks by chance.
    false_alarms: f64 = 1e-3, Number(above(0.0, 0.1)), "";
    /// Departure allowed where a law holds to rounding: ledgers, tables, phase functions, the rig.
    rounding: f64 = 1e-12, Number(above(0.0, 1e-3)), "";
    /// Net effect of the balance heuristic of shared paths, of the incident flux, at any wavelength and direction.
    sharing: f64 = 0.05, Number(TOLERANCE), "";
    /// Net effect of roulette, of the incident flux, mean over directions.
    roulette: f64 = 0.002, Number(TOLERANCE), "";
    /// Mean cosine of the angles that paths turn by, against g.
    scattering_angle: f64 = 0.01, Number(TOLERANCE), "";
    /// Closed forms of the cylinder without scattering, of the incident flux.
    cylinder: f64 = 0.002, Number(TOLERANCE), "";
    /// Scattered light in f* from the BSSRDF against the direct f*, of the incident flux.
    two_estimators: f64 = 0.02, Number(TOLERANCE), "";
    /// Yarn's scattering one way against the other, and against its mirror images, of the incident flux.
    reciprocity: f64 = 0.002, Number(TOLERANCE), "";
    /// Reflected, transmitted and absorbed light of the cloth beyond 1.
    cloth: f64 = 0.02, Number(TOLERANCE), "";
    /// Departure of a measurement from reciprocity and from a smooth curve, relative to its mean.
    sample: f64 = 0.1, Number(above(0.0, 10.0)), "";
}
}

/// The row of a key.
pub(super) fn find(section: &str, key: &str) -> Option<&'static Field> {
    let section = SECTIONS.iter().find(|s| s.name == section)?;
    section.fields.iter().find(|f| f.key == key)
}
