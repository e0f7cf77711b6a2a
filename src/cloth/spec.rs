use super::{ClothError, System, Weave};

/// Shape of the yarns' centre lines.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum CentreLineKind {
    /// Circular arcs wrapped around the crossing yarns, joined by straights: F. T. Peirce, "The geometry of cloth
    /// structure", J. Textile Inst. 28 (1937) T45. The crimp is shared equally by the two systems.
    #[default]
    Peirce,
    /// Half a cosine between a crossing above and one below, straight along floats.
    Sinusoid { amplitude_mm: f64 },
}

/// All parameters of a cloth's geometry. [`Cloth::new`](crate::cloth::Cloth::new) validates them.
#[derive(Clone, Debug, PartialEq)]
pub struct ClothSpec {
    pub weave: Weave,
    pub centre_line: CentreLineKind,
    pub warp_radius_mm: f64,
    pub weft_radius_mm: f64,
    /// Ratio of width to height of the warps' elliptical sections; the area is that of a circle of radius
    /// `warp_radius_mm`.
    pub warp_flattening: f64,
    pub weft_flattening: f64,
    /// Mean distance of neighbouring warp yarns, along y.
    pub warp_spacing_mm: f64,
    /// Mean distance of neighbouring weft yarns, along x.
    pub weft_spacing_mm: f64,
    /// Relative standard deviation of the yarns' radii: normal distribution, truncated at two standard deviations; the
    /// mean over the cell is preserved.
    pub radius_variation: f64,
    /// The same for the distances of neighbouring yarns.
    pub spacing_variation: f64,
    /// Number of repeats of the draft in one cell, along x and along y. Variation recurs with the cell.
    pub repeats: [usize; 2],
    /// Seed of the variation of radii and positions.
    pub variation_seed: u64,
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
        }
    }
}

impl ClothSpec {
    pub(super) fn radius_mm(&self, system: System) -> f64 {
        match system {
            System::Warp => self.warp_radius_mm,
            System::Weft => self.weft_radius_mm,
        }
    }

    pub(super) fn spacing_mm(&self, system: System) -> f64 {
        match system {
            System::Warp => self.warp_spacing_mm,
            System::Weft => self.weft_spacing_mm,
        }
    }

    /// Half width and half height, mm, of a section with the area of a circle of radius `radius_mm`.
    pub(super) fn half_axes_mm(&self, system: System, radius_mm: f64) -> [f64; 2] {
        let stretch = match system {
            System::Warp => self.warp_flattening,
            System::Weft => self.weft_flattening,
        }
        .sqrt();
        [radius_mm * stretch, radius_mm / stretch]
    }

    pub(super) fn is_varied(&self) -> bool {
        self.radius_variation > 0.0 || self.spacing_variation > 0.0
    }

    /// Number of repeats of the draft across the yarns of a system.
    pub(super) fn repeats_across(&self, system: System) -> usize {
        match system {
            System::Warp => self.repeats[1],
            System::Weft => self.repeats[0],
        }
    }

    pub(super) fn check_ranges(&self) -> Result<(), ClothError> {
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
            ("repeats along x", self.repeats[0] as f64, 1.0, 128.0),
            ("repeats along y", self.repeats[1] as f64, 1.0, 128.0),
        ] {
            if !(low..=high).contains(&found) {
                return Err(ClothError::Ratio { name, found, low, high });
            }
        }
        Ok(())
    }
}
