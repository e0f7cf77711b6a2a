//! Woven cloth: draft, centre lines of the yarns, their tubes as a mesh, and rays through the endless periodic weave.
//!
//! The cloth lies in the x–y plane around z = 0, its outer normal is +z. Warp yarns run along x, weft yarns along y.
//! The first warp of the cell stands at y = ½ warp spacing, the first weft at x = ½ weft spacing. Lengths are mm.

mod centre_line;
mod draft;
mod interpenetration;
mod layout;
mod mesh;
mod piece;
mod scene;
mod tube;
mod tubes;

pub use centre_line::{CentreLine, CentreLineKind, PeirceSegment};
pub use draft::{Draft, Weave};
pub use scene::{Cloth, Hit, YarnId};
pub use tubes::{TubeHit, Tubes};

use std::fmt;

/// The two systems of yarns of a weave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum System {
    /// Along x.
    Warp,
    /// Along y.
    Weft,
}

impl System {
    /// Place in pairs of warp and weft.
    pub fn index(self) -> usize {
        match self {
            Self::Warp => 0,
            Self::Weft => 1,
        }
    }

    pub fn other(self) -> Self {
        match self {
            Self::Warp => Self::Weft,
            Self::Weft => Self::Warp,
        }
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Warp => "warp",
            Self::Weft => "weft",
        })
    }
}

/// Everything that fixes the shape of a cloth. [`Cloth::new`] checks it.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothSpec {
    pub weave: Weave,
    pub centre_line: CentreLineKind,
    pub warp_radius_mm: f64,
    pub weft_radius_mm: f64,
    /// Width over height of the warps' elliptical sections. Their area is that of the circle of `warp_radius_mm`.
    pub warp_flattening: f64,
    pub weft_flattening: f64,
    /// Mean distance of neighbouring warp yarns, along y.
    pub warp_spacing_mm: f64,
    /// Mean distance of neighbouring weft yarns, along x.
    pub weft_spacing_mm: f64,
    /// Standard deviation of the yarns' radii over the mean radius: normal, cut off at two standard deviations, with the
    /// mean over the cell kept.
    pub radius_variation: f64,
    /// The same of the distances of neighbouring yarns.
    pub spacing_variation: f64,
    /// Repeats of the draft in one cell, along x and along y. More give variation more yarns before it recurs.
    pub repeats: [usize; 2],
    /// Fixes every yarn's radius and place.
    pub variation_seed: u64,
    /// Facets around a yarn, a multiple of four so that silhouettes seen from above are exact. The facets lie inside
    /// the round yarn, by at most R (1 − cos(π / n)).
    pub segments_around: usize,
    /// Facets along a yarn from one crossing to the next.
    pub segments_along: usize,
}

impl Default for ClothSpec {
    /// Plain weave of equal yarns, radius 0.15 mm, 1.8 diameters apart.
    fn default() -> Self {
        Self {
            weave: Weave::Plain,
            centre_line: CentreLineKind::Peirce,
            warp_radius_mm: 0.15,
            weft_radius_mm: 0.15,
            warp_flattening: 1.0,
            weft_flattening: 1.0,
            warp_spacing_mm: 0.54,
            weft_spacing_mm: 0.54,
            radius_variation: 0.0,
            spacing_variation: 0.0,
            repeats: [1, 1],
            variation_seed: 0,
            segments_around: 48,
            segments_along: 24,
        }
    }
}

impl ClothSpec {
    fn radius_mm(&self, system: System) -> f64 {
        match system {
            System::Warp => self.warp_radius_mm,
            System::Weft => self.weft_radius_mm,
        }
    }

    fn spacing_mm(&self, system: System) -> f64 {
        match system {
            System::Warp => self.warp_spacing_mm,
            System::Weft => self.weft_spacing_mm,
        }
    }

    /// Half width and half height of a yarn whose section has the area of the circle of a radius.
    fn half_axes_mm(&self, system: System, radius_mm: f64) -> [f64; 2] {
        let stretch = match system {
            System::Warp => self.warp_flattening,
            System::Weft => self.weft_flattening,
        }
        .sqrt();
        [radius_mm * stretch, radius_mm / stretch]
    }

    /// Whether this cloth can be woven.
    ///
    /// # Errors
    /// As [`Cloth::new`], which also limits the number of facets.
    pub fn check(&self) -> Result<(), ClothError> {
        layout::Layout::new(self).map(drop)
    }

    /// With sinusoids of the smallest amplitude, in steps of 2 % of that at which yarns touch where they cross, at which yarns do
    /// not overlap; or of that one, if there is none up to twice it.
    pub fn with_least_amplitude(self) -> Self {
        const STEPS: u32 = 50;
        let touching_mm = [System::Warp, System::Weft]
            .map(|system| 0.5 * self.half_axes_mm(system, self.radius_mm(system))[1])
            .iter()
            .sum::<f64>();
        let with = |step: u32| Self {
            centre_line: CentreLineKind::Sinusoid {
                amplitude_mm: touching_mm * (1.0 + f64::from(step) / f64::from(STEPS)),
            },
            ..self.clone()
        };
        let possible = (0..=STEPS).map(with).find(|spec| spec.check().is_ok());
        possible.unwrap_or_else(|| with(0))
    }

    fn is_varied(&self) -> bool {
        self.radius_variation > 0.0 || self.spacing_variation > 0.0
    }

    /// Repeats of the draft across the yarns of a system.
    fn repeats_across(&self, system: System) -> usize {
        match system {
            System::Warp => self.repeats[1],
            System::Weft => self.repeats[0],
        }
    }

    fn check_ranges(&self) -> Result<(), ClothError> {
        let mut lengths = vec![
            ("warp_radius_mm", self.warp_radius_mm),
            ("weft_radius_mm", self.weft_radius_mm),
            ("warp_spacing_mm", self.warp_spacing_mm),
            ("weft_spacing_mm", self.weft_spacing_mm),
        ];
        if let CentreLineKind::Sinusoid { amplitude_mm } = self.centre_line {
            lengths.push(("amplitude_mm", amplitude_mm));
        }
        for (name, found) in lengths {
            // Squares and quotients of lengths in this range neither overflow nor vanish.
            if !(1e-6..=1e6).contains(&found) {
                return Err(ClothError::Length { name, found });
            }
        }
        for (name, found, low, high) in [
            ("warp_flattening", self.warp_flattening, 0.2, 5.0),
            ("weft_flattening", self.weft_flattening, 0.2, 5.0),
            ("radius_variation", self.radius_variation, 0.0, 0.2),
            ("spacing_variation", self.spacing_variation, 0.0, 0.2),
            ("repeats along x", self.repeats[0] as f64, 1.0, 256.0),
            ("repeats along y", self.repeats[1] as f64, 1.0, 256.0),
        ] {
            if !(low..=high).contains(&found) {
                return Err(ClothError::Ratio { name, found, low, high });
            }
        }
        for (name, found, multiple) in [
            ("segments_around", self.segments_around, 4),
            ("segments_along", self.segments_along, 1),
        ] {
            if !(8..=1024).contains(&found) || found % multiple != 0 {
                return Err(ClothError::Segments { name, found, multiple });
            }
        }
        Ok(())
    }
}

/// Why a draft or a cloth cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClothError {
    #[error("the draft is empty: it needs at least one row (weft) and one column (warp)")]
    EmptyDraft,
    #[error("draft row {row}: expected {expected} columns, one a warp as in row 0, found {found}")]
    RaggedDraft { row: usize, expected: usize, found: usize },
    #[error("{system} {index} of the draft (counted from 0) stays on one side at every crossing; let it change sides")]
    NeverInterlaces { system: System, index: usize },
    #[error("{name}: expected a length from 1e-6 to 1e6 mm, found {found}")]
    Length { name: &'static str, found: f64 },
    #[error("{name}: expected a number from {low} to {high}, found {found}")]
    Ratio {
        name: &'static str,
        found: f64,
        low: f64,
        high: f64,
    },
    #[error("{name}: expected 8 to 1024 facets, a multiple of {multiple}, found {found}")]
    Segments {
        name: &'static str,
        found: usize,
        multiple: usize,
    },
    #[error(
        "the cell would have {found} facets, more than {limit}; reduce segments_around, segments_along, repeats or the draft"
    )]
    TooManyFacets { found: usize, limit: usize },
    #[error(
        "the weave jams: {crossed} yarns {spacing_mm} mm apart leave no room for the {system} between them; increase \
         {crossed}_spacing_mm to at least {minimum_mm:.6}, or reduce the yarn radii (now {radius_sum_mm} mm together)"
    )]
    Jammed {
        system: System,
        crossed: System,
        spacing_mm: f64,
        minimum_mm: f64,
        radius_sum_mm: f64,
    },
    #[error("{first} and {second} overlap by {overlap_mm:.6} mm; {remedy}")]
    Overlap {
        first: String,
        second: String,
        /// The system of both, where they run side by side; none where they cross.
        neighbours: Option<System>,
        overlap_mm: f64,
        remedy: &'static str,
    },
    #[error(
        "{system} {index} bends with a radius of {curvature_mm:.6} mm, tighter than its own radius {radius_mm} mm; \
         increase {crossed}_spacing_mm, or reduce the amplitude or the yarn radius", crossed = system.other()
    )]
    TooCurved {
        system: System,
        index: usize,
        curvature_mm: f64,
        radius_mm: f64,
    },
}
