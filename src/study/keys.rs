//! Every key of a study file: meaning, unit and range, written once.

use super::fields::{Field, Kind, Range, Section};
use crate::cloth::Weave;

const fn closed(low: f64, high: f64) -> Range {
    Range {
        low,
        low_included: true,
        high,
        high_included: true,
    }
}

/// Low excluded, high included.
const fn above(low: f64, high: f64) -> Range {
    Range {
        low,
        low_included: false,
        high,
        high_included: true,
    }
}

const fn field(key: &'static str, unit: &'static str, kind: Kind, meaning: &'static str) -> Field {
    Field {
        key,
        meaning,
        unit,
        kind,
        example: None,
    }
}

const fn optional(field: Field, example: &'static str) -> Field {
    Field {
        example: Some(example),
        ..field
    }
}

const WAVELENGTH: Range = closed(100.0, 10_000.0);
const INDEX: Range = closed(1.0, 4.0);
const KAPPA: Range = closed(0.0, 10.0);
/// Size parameters within those of [`crate::optics::mie`], and phase functions that a table resolves at the default wavelengths.
const DIAMETER: Range = closed(0.01, 20_000.0);
const VIEW: Range = Range {
    low: -90.0,
    low_included: false,
    high: 90.0,
    high_included: false,
};
/// Squares of lengths and their quotients neither overflow nor vanish.
const LENGTH: Range = closed(1e-6, 100.0);
const SPACING: Range = above(1.0, 100.0);
/// Equal spheres cannot fill more than π/√18 = 0.7405 of a volume.
const FRACTION: Range = Range {
    low: 0.0,
    low_included: true,
    high: 0.74,
    high_included: false,
};
const CELLS: Kind = Kind::Integer(1, 1000);
const FOURS: Kind = Kind::Multiple(4, 1000, 4);
const PATHS: Kind = Kind::Integer(2, 1_000_000_000_000);

const HOST_INDEX: Field = field(
    "host_index",
    "",
    Kind::NumberOrTable(INDEX),
    "Refractive index of the host.",
);
const HOST_MU_A_PER_MM: Field = field(
    "host_mu_a_per_mm",
    "1/mm",
    Kind::NumberOrTable(closed(0.0, 1e6)),
    "Absorption coefficient of the host.",
);
const PARTICLE_INDEX: Field = field(
    "particle_index",
    "",
    Kind::NumberOrTable(INDEX),
    "Refractive index of the particles, absolute.",
);
const PARTICLE_DIAMETER_NM: Field = field(
    "particle_diameter_nm",
    "nm",
    Kind::Number(DIAMETER),
    "Diameter (not radius) of the particles.",
);
const VOLUME_FRACTION: Field = field(
    "volume_fraction",
    "",
    Kind::Number(FRACTION),
    "Share of the yarn's volume that is particles.",
);
const KAPPA_PEAK: Field = field(
    "kappa_peak",
    "",
    Kind::Number(KAPPA),
    "Imaginary part of the particles' refractive index at the peak of the dye.",
);
const DYE: Field = field(
    "dye",
    "",
    Kind::Text,
    "Shape of the dye's absorption over wavelength, 1 at its peak: a built-in dye, or a path to a CSV or CGATS text.",
);
const INTERFERENCE: Field = field(
    "interference",
    "",
    Kind::Choice(&["independent", "percus-yevick"]),
    "Particles scatter as if alone, or with the Percus-Yevick structure factor of hard spheres.",
);
const RADIUS_MM: Field = field("radius_mm", "mm", Kind::Number(LENGTH), "Radius of the yarn.");

pub(super) const SECTIONS: &[Section] = &[
    Section {
        name: "",
        meaning: "",
        fields: &[field(
            "seed",
            "",
            Kind::Integer(0, i64::MAX as u64),
            "Seed of every random number. The same study and seed give the same result on any number of threads.",
        )],
    },
    Section {
        name: "spectrum",
        meaning: "The wavelengths (in vacuum) at which everything is computed.",
        fields: &[
            field("wavelength_min_nm", "nm", Kind::Number(WAVELENGTH), "First wavelength."),
            field(
                "wavelength_max_nm",
                "nm",
                Kind::Number(WAVELENGTH),
                "Last wavelength, a whole number of steps above the first.",
            ),
            field(
                "wavelength_step_nm",
                "nm",
                Kind::Number(above(0.0, 1000.0)),
                "Step between wavelengths.",
            ),
            optional(
                field(
                    "wavelengths_nm",
                    "nm",
                    Kind::Numbers(WAVELENGTH, 1),
                    "An ascending list to use in place of the three above.",
                ),
                "[450.0, 550.0, 650.0]",
            ),
        ],
    },
    Section {
        name: "medium",
        meaning: "What fills the yarn: equal dyed spheres in a clear host.",
        fields: &[
            HOST_INDEX,
            HOST_MU_A_PER_MM,
            PARTICLE_INDEX,
            PARTICLE_DIAMETER_NM,
            VOLUME_FRACTION,
            KAPPA_PEAK,
            DYE,
            INTERFERENCE,
        ],
    },
    Section {
        name: "yarn",
        meaning: "An infinite circular cylinder.",
        fields: &[
            RADIUS_MM,
            optional(
                field(
                    "twist_deg",
                    "degrees",
                    Kind::Number(closed(-90.0, 90.0)),
                    "Angle of the fibres to the axis of warps and wefts, where [specular] surface is \"fibres\": positive Z twist, \
                     negative S twist; 0, along the axis, where it is left out.",
                ),
                "20.0",
            ),
        ],
    },
    Section {
        name: "weft",
        meaning: "In what the weft differs from the warp. What is left out is as in [medium], [yarn] and [cloth].",
        fields: &[
            optional(RADIUS_MM, "0.12"),
            optional(
                field(
                    "spacing_diameters",
                    "yarn diameters",
                    Kind::Number(SPACING),
                    "Distance of neighbouring wefts, in mean diameters of warp and weft.",
                ),
                "2.0",
            ),
            optional(HOST_INDEX, "1.557"),
            optional(HOST_MU_A_PER_MM, "0.0"),
            optional(PARTICLE_INDEX, "1.61"),
            optional(PARTICLE_DIAMETER_NM, "150.0"),
            optional(VOLUME_FRACTION, "0.14"),
            optional(KAPPA_PEAK, "0.0"),
            optional(DYE, "\"preprint-red\""),
            optional(INTERFERENCE, "\"independent\""),
        ],
    },
    Section {
        name: "trace",
        meaning: "Monte Carlo simulation of light in the yarn.",
        fields: &[
            field(
                "estimator",
                "",
                Kind::Choice(&["shared", "independent"]),
                "Shared: one path for all wavelengths of one host index. Independent: a path each.",
            ),
            field(
                "batches",
                "",
                Kind::Integer(2, 100_000),
                "Batches a direction; their means give the standard errors.",
            ),
            field(
                "paths_bssrdf",
                "",
                PATHS,
                "Paths for each incident direction and wavelength of the BSSRDF, at least one a batch.",
            ),
            field(
                "paths_direct",
                "",
                PATHS,
                "Paths for each tilt and wavelength of the direct simulation, at least one a batch.",
            ),
            field(
                "particles",
                "",
                Kind::Integer(2, 1_000_000_000_000),
                "Particles of each beam that are followed from yarn to yarn where yarns scatter by f*.",
            ),
            field(
                "particles_volumetric",
                "",
                Kind::Integer(2, 1_000_000_000_000),
                "Particles of each beam of the volumetric method.",
            ),
            field(
                "roulette_threshold",
                "",
                Kind::Number(Range {
                    low: 0.0,
                    low_included: false,
                    high: 1.0,
                    high_included: false,
                }),
                "Share of its first weight below which a path plays Russian roulette.",
            ),
            field(
                "roulette_survival",
                "",
                Kind::Number(Range {
                    low: 0.0,
                    low_included: false,
                    high: 1.0,
                    high_included: false,
                }),
                "Probability of surviving the roulette.",
            ),
            field(
                "zenith_cells",
                "",
                CELLS,
                "Incident directions: cells in the zenith angle from the normal of the entry patch.",
            ),
            field(
                "azimuth_cells",
                "",
                FOURS,
                "Incident directions: cells in azimuth about that normal.",
            ),
            field(
                "exit_azimuth_cells",
                "",
                FOURS,
                "Cells around the yarn where light leaves.",
            ),
            field(
                "exit_theta_cells",
                "",
                CELLS,
                "Exit directions: cells in the zenith angle.",
            ),
            field("exit_phi_cells", "", FOURS, "Exit directions: cells in azimuth."),
            field(
                "bssrdf_azimuth_cells",
                "",
                FOURS,
                "Cells around the yarn of the stored BSSRDF, whose table has two more axes.",
            ),
            field(
                "bssrdf_exit_theta_cells",
                "",
                CELLS,
                "Its exit directions: cells in the zenith angle.",
            ),
            field(
                "bssrdf_exit_phi_cells",
                "",
                FOURS,
                "Its exit directions: cells in azimuth.",
            ),
            field(
                "z_cells",
                "",
                Kind::Multiple(2, 1000, 2),
                "Cells along the yarn where light leaves.",
            ),
            field(
                "tilts",
                "",
                CELLS,
                "Direct simulation: directions of the beam between across and along the yarn.",
            ),
            field(
                "fold_symmetry",
                "",
                Kind::Flag,
                "Trace a quarter of the directions and mirror the rest.",
            ),
            field(
                "shade_with",
                "",
                Kind::Choice(&["direct", "bssrdf"]),
                "Radiance factor of the cloth's yarns: from the direct simulation, or from the sum of the BSSRDF.",
            ),
        ],
    },
    Section {
        name: "cloth",
        meaning: "The weave and the geometry of its yarns.",
        fields: &[
            field(
                "weave",
                "",
                Kind::ChoiceOrPath(Weave::NAMES),
                "Which yarn is on top at each crossing: a built-in weave, or a WIF file, whose smallest repeat is woven; \
                 `specval weave` prints it.",
            ),
            field(
                "centre_line",
                "",
                Kind::Choice(&["peirce", "sinusoid"]),
                "Arcs and straights (Peirce 1937), or a sinusoid.",
            ),
            field(
                "spacing_diameters",
                "yarn diameters",
                Kind::Number(SPACING),
                "Distance of neighbouring yarns, in mean diameters of warp and weft; a plain weave of equal round yarns jams at 1.73.",
            ),
            optional(
                field(
                    "sinusoid_amplitude_mm",
                    "mm",
                    Kind::Number(LENGTH),
                    "Amplitude of the sinusoid; by default the smallest, in steps of 2 % of that at which yarns touch where they \
                     cross, at which they do not overlap.",
                ),
                "0.15",
            ),
            field(
                "segments_around",
                "",
                Kind::Multiple(8, 1024, 4),
                "Facets around a yarn.",
            ),
            field(
                "segments_along",
                "",
                Kind::Integer(8, 1024),
                "Facets along a yarn from one crossing to the next.",
            ),
            field(
                "azimuth_deg",
                "degrees",
                Kind::Number(closed(-360.0, 360.0)),
                "Turn of the cloth in its plane: warp from the plane of incidence.",
            ),
            field(
                "method",
                "",
                Kind::Choice(&["radiance-factor", "volumetric"]),
                "Light in the cloth: scattered by the yarns' f*, or traced through the medium of every yarn it meets.",
            ),
            field(
                "bounces",
                "",
                Kind::IntegerOr(0, 1000, "all"),
                "Yarns that light may go on to after the first it met, where yarns scatter by f*; 0 is the preprint's shading.",
            ),
            field(
                "backing",
                "",
                Kind::Text,
                "What lies under the cloth: \"none\", \"black\", \"white\" (a perfect diffuser), or a path to a spectrum of its reflectance.",
            ),
            field(
                "warp_flattening",
                "",
                Kind::Number(closed(0.2, 5.0)),
                "Width over height of the warp yarns' elliptical section, whose area is that of the yarn's radius.",
            ),
            field(
                "weft_flattening",
                "",
                Kind::Number(closed(0.2, 5.0)),
                "The same of the weft yarns.",
            ),
            field(
                "radius_variation",
                "",
                Kind::Number(closed(0.0, 0.2)),
                "Relative standard deviation of the yarns' radii from one to the next.",
            ),
            field(
                "spacing_variation",
                "",
                Kind::Number(closed(0.0, 0.2)),
                "Relative standard deviation of the distances between neighbouring yarns.",
            ),
            field(
                "repeats",
                "",
                Kind::Integer(1, 256),
                "Repeats of the weave along warp and weft before variations come again.",
            ),
            field(
                "variation_seed",
                "",
                Kind::Integer(0, i64::MAX as u64),
                "Seed of the variations, apart from the study's.",
            ),
        ],
    },
    Section {
        name: "specular",
        meaning: "Gloss about the cloth's normal (Cook-Torrance), for model and classical shading alike.",
        fields: &[
            field(
                "surface",
                "",
                Kind::Choice(&["cloth", "yarn", "fibres"]),
                "What shines: the cloth about its normal (Cook-Torrance); or the surface of each yarn (Fresnel), smooth or of fibres \
                 that spread the light, which goes on to other yarns; classical shading is about the cloth's normal in any case.",
            ),
            field(
                "roughness",
                "",
                Kind::Number(closed(0.001, 1.0)),
                "Root mean square slope of the facets; of fibres the width of the distribution (Trowbridge-Reitz) of slopes along them.",
            ),
            optional(
                field(
                    "roughness_across",
                    "",
                    Kind::Number(closed(0.001, 1.0)),
                    "The same across fibres, where surface is \"fibres\": height over width of their sections, 1 of round ones; 0.6 \
                     where it is left out.",
                ),
                "0.6",
            ),
            field(
                "distribution",
                "",
                Kind::Choice(&["beckmann", "trowbridge-reitz"]),
                "Distribution of their slopes.",
            ),
            field("index", "", Kind::Number(INDEX), "Refractive index of the surface."),
            field(
                "weight",
                "",
                Kind::Number(closed(0.0, 1.0)),
                "Factor of the whole term; 0 switches it off.",
            ),
        ],
    },
    Section {
        name: "rig",
        meaning: "The virtual goniophotometer.",
        fields: &[
            field(
                "geometries",
                "",
                Kind::Choice(&["auto", "rig"]),
                "What a report measures: \"auto\" the sample's own geometries, unless the four keys below differ from these values; \
                 \"rig\" those of the four keys. Left out beside one of the four, it is \"rig\".",
            ),
            field(
                "incidences_deg",
                "degrees",
                Kind::Numbers(
                    Range {
                        low: 0.0,
                        low_included: true,
                        high: 90.0,
                        high_included: false,
                    },
                    1,
                ),
                "Angles of incidence, from the normal.",
            ),
            field(
                "view_min_deg",
                "degrees",
                Kind::Number(VIEW),
                "First view angle: negative on the light's side of the normal.",
            ),
            field(
                "view_max_deg",
                "degrees",
                Kind::Number(VIEW),
                "Last view angle: positive on the specular side.",
            ),
            field(
                "view_step_deg",
                "degrees",
                Kind::Number(above(0.0, 180.0)),
                "Step between view angles.",
            ),
            field(
                "pixels_per_side",
                "",
                Kind::Integer(1, 10_000),
                "Pixels a side over one unit cell of the cloth.",
            ),
            field(
                "aperture_half_angle_deg",
                "degrees",
                Kind::Number(closed(0.1, 20.0)),
                "Half angle of the cone about a view in which light is caught that leaves a smooth surface, and all light of the \
                 volumetric method.",
            ),
        ],
    },
    Section {
        name: "colour",
        meaning: "From spectra to colours; the same for model, classical and measured.",
        fields: &[
            field(
                "observer",
                "",
                Kind::ChoiceOrPath(&["cie1931-2deg", "cie1964-10deg"]),
                "Colour-matching functions; a file has the columns wavelength_nm,xbar,ybar,zbar, or is CGATS text.",
            ),
            field(
                "illuminant",
                "",
                Kind::ChoiceOrPath(&["D65", "D50", "A", "C", "E"]),
                "Light in which the cloth is seen, relative power; a file has the columns wavelength_nm,value, or is CGATS text.",
            ),
            field(
                "rgb",
                "",
                Kind::Choice(&["srgb", "cie-rgb", "ntsc"]),
                "Primaries and white of the linear RGB.",
            ),
            field(
                "adaptation",
                "",
                Kind::Choice(&["none", "bradford"]),
                "From the illuminant's white to that of the RGB space.",
            ),
        ],
    },
    Section {
        name: "measured",
        meaning: "The measured sample to compare with.",
        fields: &[field(
            "sample",
            "",
            Kind::Text,
            "A built-in sample, or a path to the folder of one.",
        )],
    },
    Section {
        name: "sweep",
        meaning: "Values of parameters for the model's range in Table 1. Each is varied alone; an empty list leaves it alone.",
        fields: &[
            field("kappa_peak", "", Kind::Numbers(KAPPA, 0), "As in [medium]."),
            field("volume_fraction", "", Kind::Numbers(FRACTION, 0), "As in [medium]."),
            field(
                "particle_diameter_nm",
                "nm",
                Kind::Numbers(DIAMETER, 0),
                "As in [medium].",
            ),
            field(
                "particle_index",
                "",
                Kind::Numbers(INDEX, 0),
                "As in [medium]; each takes the place of a table there.",
            ),
        ],
    },
    Section {
        name: "check",
        meaning: "What `specval check` must not miss. A stochastic gate that could miss a departure of its tolerance says that it \
                  cannot tell, and how many paths would do; with --quick these tolerances are 2.8 times as wide.",
        fields: &[
            field(
                "false_alarms",
                "",
                Kind::Number(Range {
                    low: 0.0,
                    low_included: false,
                    high: 0.1,
                    high_included: true,
                }),
                "Probability that any gate of a run breaks by chance.",
            ),
            field(
                "rounding",
                "",
                Kind::Number(above(0.0, 1e-3)),
                "Departure allowed where a law holds to rounding: ledgers, tables, phase functions, the rig.",
            ),
            field(
                "sharing",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Net effect of the balance heuristic of shared paths, of the incident flux, at any wavelength and direction.",
            ),
            field(
                "roulette",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Net effect of roulette, of the incident flux, mean over directions.",
            ),
            field(
                "scattering_angle",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Mean cosine of the angles that paths turn by, against g.",
            ),
            field(
                "cylinder",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Closed forms of the cylinder without scattering, of the incident flux.",
            ),
            field(
                "two_roads",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Scattered light in f* from the BSSRDF against the direct f*, of the incident flux.",
            ),
            field(
                "reciprocity",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Yarn's scattering one way against the other, and against its mirror images, of the incident flux.",
            ),
            field(
                "cloth",
                "",
                Kind::Number(above(0.0, 1.0)),
                "Reflected, transmitted and absorbed light of the cloth beyond 1.",
            ),
            field(
                "sample",
                "",
                Kind::Number(above(0.0, 10.0)),
                "Departure of a measurement from reciprocity and from a smooth curve, relative to its mean.",
            ),
        ],
    },
];
