use super::{Cells, FullBsdf};
use crate::cloth::light::{ClothFraction, HemisphereNodes};
use crate::colour::{ColourError, ColourSystem, Convention};
use crate::formats::{
    Axis, ChannelSet, Component, Fold, Grid, KlemsBasis, KlemsMatrix, Parameters, Quantity, Scatter, Side,
    SpecularTable, Table, WriteNotice,
};
use crate::spectrum::WavelengthGrid;
use crate::transport::Estimate;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};

/// Representation of a spectrum in tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    Spectral,
    /// Linear sRGB under D65, CIE 1931 2° observer, clipped only at 0.
    Rgb,
    /// XYZ under D65; Y = 1 for the perfect diffuser.
    Xyz,
}

impl Colours {
    /// Channels for spectra at these wavelengths.
    pub fn channels(self, grid: &WavelengthGrid) -> ChannelSet {
        match self {
            Self::Spectral => ChannelSet::Wavelengths(grid.clone()),
            Self::Rgb => ChannelSet::Rgb,
            Self::Xyz => ChannelSet::Xyz,
        }
    }
}

/// Values of one geometry, from the estimates at each wavelength.
type Values<'a> = dyn Fn(&[Estimate]) -> Vec<f64> + 'a;

impl FullBsdf {
    /// Reflection and transmission from every measured side, and the fraction that passes straight through the gaps.
    /// With nodes that fraction is a separate component. With patches it is part of f on the diagonal of the
    /// transmission, such that ∫ f cosθ dω over the patch is the fraction (the convention of WINDOW and Radiance).
    /// Values, β or f, are rounded to six digits. Colours outside the RGB space have negative components, which are set
    /// to 0 with a notice.
    pub fn components(
        &self,
        colours: Colours,
        as_beta: bool,
        notices: &mut Vec<WriteNotice>,
    ) -> Result<Vec<Component>, ColourError> {
        let negative = Cell::new(0usize);
        let system = ColourSystem::new(&self.grid, Convention::default())?;
        if colours != Colours::Spectral {
            system.require()?;
            notices.extend(system.notice().map(|words| WriteNotice::DoubtfulColours { words }));
        }
        let values = |spectrum: &[Estimate]| {
            let values: Vec<f64> = spectrum.iter().map(|f| f.value).collect();
            let values = match colours {
                Colours::Spectral => values,
                Colours::Rgb => system.linear_rgb(system.xyz(&values)).0.to_vec(),
                Colours::Xyz => {
                    let xyz = system.xyz(&values);
                    vec![xyz.x, xyz.y, xyz.z]
                }
            };
            let clipped = |value: f64| {
                negative.set(negative.get() + usize::from(value < 0.0));
                value.max(0.0)
            };
            values.into_iter().map(clipped).collect()
        };
        let channels = colours.channels(&self.grid);
        let tables = self.tables(&channels, as_beta, &values, true);
        if negative.get() > 0 {
            notices.push(WriteNotice::Clipped {
                components: Some(negative.get()),
            });
        }
        Ok(tables)
    }

    /// Spectral standard errors, in tables like those of the values. On the diagonal of the transmission between
    /// patches, scattered light and light through gaps are treated as independent, although they are rather
    /// anticorrelated.
    pub fn errors(&self, as_beta: bool) -> Vec<Component> {
        let values = |spectrum: &[Estimate]| spectrum.iter().map(|f| f.se).collect();
        self.tables(&ChannelSet::Wavelengths(self.grid.clone()), as_beta, &values, false)
    }

    fn tables(&self, channels: &ChannelSet, as_beta: bool, values: &Values, with_gaps: bool) -> Vec<Component> {
        let (quantity, scale) = if as_beta {
            (Quantity::BrightnessFactor, PI)
        } else {
            (Quantity::Bsdf, 1.0)
        };
        let of_bsdf = |spectrum: &[Estimate]| {
            let values = values(spectrum).into_iter();
            values.map(|f| rounded(scale * f)).collect()
        };
        let fractions = |spectrum: &[Estimate]| values(spectrum).into_iter().map(rounded).collect();
        let mut components = Vec::new();
        for &side in &self.sides {
            for scatter in [Scatter::Reflection, Scatter::Transmission] {
                components.push(Component {
                    scatter,
                    side,
                    quantity,
                    channels: channels.clone(),
                    table: match &self.cells {
                        Cells::Nodes(nodes) => {
                            Table::Grid(self.grid_of(nodes, side, scatter, channels.count(), &of_bsdf))
                        }
                        Cells::Patches(basis) => {
                            let matrix = self.matrix_of(basis, side, scatter, channels.count(), &of_bsdf);
                            Table::Klems(KlemsMatrix::new(basis.clone(), basis.clone(), matrix))
                        }
                    },
                });
            }
            if let (Cells::Nodes(nodes), true) = (&self.cells, with_gaps) {
                components.push(Component {
                    scatter: Scatter::Transmission,
                    side,
                    quantity: Quantity::Fraction,
                    channels: channels.clone(),
                    table: Table::Specular(self.gaps_of(nodes, side, channels.count(), &fractions)),
                });
            }
        }
        components
    }

    /// Table on spherical nodes; the node at the normal is repeated for each azimuth.
    fn grid_of(&self, nodes: &HemisphereNodes, side: Side, scatter: Scatter, channels: usize, values: &Values) -> Grid {
        let (rings, azimuths) = (nodes.rings(), nodes.azimuths());
        let mut table = Vec::with_capacity(rings * azimuths * (rings + 1) * azimuths * channels);
        for ring_in in 0..rings {
            for azimuth_in in 0..azimuths {
                let incident = nodes.node(ring_in, azimuth_in);
                for ring_out in 0..=rings {
                    for azimuth_out in 0..azimuths {
                        let exiting = nodes.node(ring_out, azimuth_out);
                        table.extend(values(&self.bsdf(side, incident, scatter, exiting)));
                    }
                }
            }
        }
        let (polar, around) = axes_rad(nodes);
        let axes = [
            Axis::bounded(polar[..rings].to_vec()),
            Axis::azimuth(around.clone(), TAU),
            Axis::bounded(polar),
            Axis::azimuth(around, TAU),
        ];
        Grid::new(
            Parameters::Spherical,
            axes,
            Fold::None,
            channels,
            [0, 1, 2, 3, 4],
            table,
        )
    }

    /// Table on patches: channel × exiting patch × incident patch (fastest).
    fn matrix_of(
        &self,
        basis: &KlemsBasis,
        side: Side,
        scatter: Scatter,
        channels: usize,
        values: &Values,
    ) -> Vec<f64> {
        let count = basis.count();
        let mut matrix = vec![0.0; channels * count * count];
        for incident in 0..count {
            for exiting in 0..count {
                let mut f = self.bsdf(side, incident, scatter, exiting);
                if scatter == Scatter::Transmission && exiting == incident {
                    let gaps = self.through_gaps(side, incident);
                    f.iter_mut().zip(gaps).for_each(|(f, gaps)| {
                        let per_sr = 1.0 / basis.projected_solid_angle(exiting);
                        f.value += gaps.value * per_sr;
                        f.se = f.se.hypot(gaps.se * per_sr);
                    });
                }
                for (channel, value) in values(&f).into_iter().enumerate() {
                    matrix[(channel * count + exiting) * count + incident] = value;
                }
            }
        }
        matrix
    }

    /// Fraction of the light from an incident cell that meets no yarn, at each wavelength.
    fn through_gaps(&self, side: Side, incident: usize) -> Vec<Estimate> {
        let traced = self.traced_for(side, incident);
        traced.map_or_else(Vec::new, |(incidence, _)| {
            let of = |w: usize| incidence.fractions(w).0[ClothFraction::ThroughGaps as usize];
            (0..self.grid.len()).map(of).collect()
        })
    }

    fn gaps_of(&self, nodes: &HemisphereNodes, side: Side, channels: usize, values: &Values) -> SpecularTable {
        let (polar, around) = axes_rad(nodes);
        let mut table = Vec::new();
        for azimuth in 0..nodes.azimuths() {
            for ring in 0..nodes.rings() {
                table.extend(values(&self.through_gaps(side, nodes.node(ring, azimuth))));
            }
        }
        SpecularTable::new(
            Axis::bounded(polar[..nodes.rings()].to_vec()),
            Axis::azimuth(around, TAU),
            channels,
            table,
        )
    }
}

/// Polar angles, horizon included, and azimuths, radians.
fn axes_rad(nodes: &HemisphereNodes) -> (Vec<f64>, Vec<f64>) {
    let polar = (0..=nodes.rings()).map(|ring| nodes.angles_rad(nodes.node(ring, 0))[0]);
    let around = (0..nodes.azimuths()).map(|azimuth| nodes.angles_rad(nodes.node(1, azimuth))[1]);
    (polar.collect(), around.collect())
}

/// Value rounded to six significant digits: the error is far below any standard error, and files are half as long.
fn rounded(value: f64) -> f64 {
    // A number formatted like this always parses.
    format!("{value:.5e}").parse().unwrap_or(value)
}
