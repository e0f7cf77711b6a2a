use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use rayon::prelude::*;

use super::super::descriptor::Content;
use super::balance::{Balance, hemispherical};
use super::nodes::Probe;
use super::sampling::{ChannelMap, Sampler, clipped, every};
use super::{WriteError, WriteNotice};
use crate::geometry::Vec3;
use crate::goniometric::{
    Axis, ChannelSet, Component, FileProvenance, Fold, Format, Grid, Hemispherical, Parameters, Quantity, Table,
    about_z, degrees, direction, from_specular, radians,
};

/// Steps in θ, and in φ and ψ, of a table that is resampled, where its values do not bend.
const POLAR_DEG: f64 = 5.0;
const AROUND_DEG: f64 = 15.0;
/// Nodes at most in θ and φ, of isotropic and of anisotropic tables.
const MOST: [[usize; 2]; 2] = [[160, 73], [74, 37]];

/// Nodes for each σ of an anisotropic table that is resampled and has no narrow lobe.
pub(crate) fn resampled_nodes() -> usize {
    every(POLAR_DEG, 180.0).len() * every(AROUND_DEG, 360.0).len().pow(2)
}

/// A table over the angles of a `.ddr` file, psi slowest, then sigma, phi, theta, channel.
pub(super) struct SpecularGrid {
    pub(super) psi_deg: Vec<f64>,
    pub(super) sigma_deg: Vec<f64>,
    pub(super) sigmat_deg: Option<Vec<f64>>,
    pub(super) phi_deg: Vec<f64>,
    pub(super) theta_deg: Vec<f64>,
    pub(super) fold: Fold,
    /// In `quantity`.
    pub(super) values: Vec<f64>,
    pub(super) quantity: Quantity,
}

impl SpecularGrid {
    /// The source's own nodes where it has such a table, else a table of even steps.
    pub(super) fn of(
        component: &Component,
        format: Format,
        notices: &mut Vec<WriteNotice>,
    ) -> Result<Self, WriteError> {
        if let Table::Grid(grid) = &component.table
            && let Parameters::Specular { offsets_rad } = grid.parameters()
            && matches!(grid.fold(), Fold::None | Fold::Mirror)
        {
            return Self::same(component.quantity, grid, offsets_rad);
        }
        let sampler = Sampler::new(component, format)?;
        let isotropic = component.is_isotropic();
        let psi_deg = if isotropic { vec![0.0] } else { every(AROUND_DEG, 360.0) };
        let sigma_deg = component.incidences_deg();
        let probed_psi = if isotropic { vec![0.0] } else { vec![0.0, 45.0, 90.0] };
        let probe = Probe::new(component, Sampler::new(component, format)?, &sigma_deg, &probed_psi);
        let even = [every(POLAR_DEG, 180.0), every(AROUND_DEG, 360.0)];
        let [theta_deg, phi_deg] = probe.nodes(even, MOST[usize::from(!isotropic)], node)?;
        let mut values = Vec::new();
        for psi in &psi_deg {
            for sigma in &sigma_deg {
                for phi in &phi_deg {
                    for theta in &theta_deg {
                        let (omega_in, omega_out) = node([*sigma, *psi], *theta, *phi);
                        values.extend(sampler.bsdf(&omega_in, &omega_out)?);
                    }
                }
            }
        }
        sampler.notice(notices);
        let axes = [
            Axis::bounded(radians(&sigma_deg)),
            Axis::azimuth(radians(&psi_deg), TAU),
            Axis::bounded(radians(&theta_deg)),
            Axis::azimuth(radians(&phi_deg), TAU),
        ];
        let offsets_rad = vec![0.0; sigma_deg.len()];
        let channels = component.channels.count();
        let order = [1, 0, 3, 2, 4];
        let table = Grid::new(
            Parameters::Specular { offsets_rad },
            axes,
            Fold::None,
            channels,
            order,
            values,
        );
        let table = Component {
            quantity: Quantity::Bsdf,
            table: Table::Grid(table),
            ..component.clone()
        };
        let incidences: Vec<[usize; 2]> = (0..psi_deg.len())
            .flat_map(|p| (0..sigma_deg.len()).map(move |s| [s, p]))
            .collect();
        let found: Vec<[Option<Hemispherical>; 2]> = incidences
            .par_iter()
            .map(|&[s, p]| [component, &table].map(|of| hemispherical(of, sigma_deg[s], psi_deg[p])))
            .collect();
        let Table::Grid(mut scaled) = table.table else {
            return Err(WriteError::CannotHold {
                format,
                holds: "a grid of angles".into(),
                found: "a table of another kind".into(),
                remedy: "take a format that holds single readings (csv, astm)".into(),
            });
        };
        let mut balance = Balance::default();
        for (&[s, p], [source, written]) in incidences.iter().zip(&found) {
            let factors = balance.factors(sigma_deg[s], source.as_ref(), written.as_ref(), channels);
            let factors = factors.into_iter().enumerate();
            factors.for_each(|(channel, factor)| scaled.scale([s, p], channel, factor));
        }
        balance.notice(notices);
        let offsets_rad = vec![0.0; sigma_deg.len()];
        Self::same(Quantity::Bsdf, &scaled, &offsets_rad)
    }

    fn same(quantity: Quantity, grid: &Grid, offsets_rad: &[f64]) -> Result<Self, WriteError> {
        // The format wants azimuths from 0 to 360 degrees.
        let grid = &grid.closed();
        let [sigma, psi, theta, phi] = grid.axes();
        let [n0, n1, n2, n3] = grid.shape();
        if quantity == Quantity::Unscaled {
            return Err(WriteError::Unscaled);
        }
        let mut values = Vec::new();
        for (i1, i0, i3, i2) in indices([n1, n0, n3, n2]) {
            values.extend((0..grid.channels()).map(|channel| grid.at([i0, i1, i2, i3], channel)));
        }
        let sigma_deg = degrees(sigma.nodes_rad());
        let sigmat = offsets_rad
            .iter()
            .zip(&sigma_deg)
            .map(|(offset, s)| ((offset.to_degrees() + s) * 1e9).round() / 1e9);
        Ok(Self {
            psi_deg: if grid.is_isotropic() {
                vec![0.0]
            } else {
                degrees(psi.nodes_rad())
            },
            sigmat_deg: offsets_rad
                .iter()
                .any(|&offset| offset != 0.0)
                .then(|| sigmat.collect()),
            sigma_deg,
            phi_deg: degrees(phi.nodes_rad()),
            theta_deg: degrees(theta.nodes_rad()),
            fold: grid.fold(),
            values,
            quantity,
        })
    }
}

/// Directions to light and viewer of a node in degrees: incident polar angle and azimuth, angle from the mirror
/// direction and azimuth about it.
fn node([sigma, psi]: [f64; 2], theta: f64, phi: f64) -> (Vec3, Vec3) {
    let [sigma, psi, theta, phi] = [sigma, psi, theta, phi].map(f64::to_radians);
    (direction(sigma, psi), about_z(&from_specular(theta, phi, sigma), psi))
}

/// All combinations, the last fastest.
fn indices(n: [usize; 4]) -> impl Iterator<Item = (usize, usize, usize, usize)> {
    let [n0, n1, n2, n3] = n;
    (0..n0).flat_map(move |a| (0..n1).flat_map(move |b| (0..n2).flat_map(move |c| (0..n3).map(move |d| (a, b, c, d)))))
}

pub(super) fn line(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn source(provenance: &FileProvenance) -> &str {
    let known = ["Measured", "Generated", "Edited", "Morphed"];
    let stated = provenance.source.as_deref().unwrap_or_default();
    known
        .into_iter()
        .find(|word| word.eq_ignore_ascii_case(stated))
        .unwrap_or("Generated")
}

fn colour_model(channels: &ChannelSet) -> String {
    match channels {
        ChannelSet::Monochrome => "BW".into(),
        ChannelSet::Rgb | ChannelSet::Xyz => "RGB".into(),
        ChannelSet::Wavelengths(grid) => format!("spectral {}", grid.len()),
    }
}

/// First lines of the blocks, one a channel.
fn block_names(channels: &ChannelSet) -> Vec<String> {
    match channels {
        ChannelSet::Monochrome => vec!["bw".into()],
        ChannelSet::Rgb | ChannelSet::Xyz => ["red", "gre", "blu"].map(String::from).to_vec(),
        ChannelSet::Wavelengths(grid) => grid.nm().iter().map(|nm| format!("wl {nm}")).collect(),
    }
}

/// XYZ becomes RGB; all else stays.
fn mapped(values: Vec<f64>, channels: &ChannelSet, notices: &mut Vec<WriteNotice>) -> Result<Vec<f64>, WriteError> {
    if *channels != ChannelSet::Xyz {
        return Ok(values);
    }
    let map = ChannelMap::to_rgb(channels, notices)?;
    let mut mapped: Vec<f64> = values.chunks_exact(3).flat_map(|v| map.apply(v)).collect();
    clipped(&mut mapped, notices);
    Ok(mapped)
}

pub(in crate::formats) fn diffuse(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let (component, provenance) = (content.component, content.provenance);
    let grid = SpecularGrid::of(component, content.format, notices)?;
    let scale = if grid.quantity == Quantity::Bsdf { PI } else { 1.0 };
    let values = mapped(grid.values, &component.channels, notices)?;
    let symmetry = match (grid.fold, grid.psi_deg.len(), grid.phi_deg.len()) {
        (_, 1, 1) => "AxiSymmetrical",
        (Fold::Mirror, ..) => "PlaneSymmetrical",
        (_, 1, _) => "ASymmetrical",
        _ => "ASymmetrical 4D",
    };
    let mut text = format!(
        ";; specval {}\nSource {}\nTypeSym {symmetry}\nTypeColorModel {}\nTypeData Luminance Absolute\n",
        env!("CARGO_PKG_VERSION"),
        source(provenance),
        colour_model(&component.channels)
    );
    // Writing to a string cannot fail.
    for comment in &provenance.comments {
        let _ = writeln!(text, ";; {}", comment.replace(['\n', '\r'], " "));
    }
    if grid.psi_deg.len() > 1 {
        let _ = writeln!(text, "psi {}\n {}", grid.psi_deg.len(), line(&grid.psi_deg));
    }
    let _ = writeln!(text, "sigma {}\n {}", grid.sigma_deg.len(), line(&grid.sigma_deg));
    if let Some(sigmat) = &grid.sigmat_deg {
        let _ = writeln!(text, "sigmat\n {}", line(sigmat));
    }
    let _ = writeln!(text, "phi {}\n {}", grid.phi_deg.len(), line(&grid.phi_deg));
    let _ = writeln!(text, "theta {}\n {}", grid.theta_deg.len(), line(&grid.theta_deg));
    let channels = component.channels.count();
    let row = grid.theta_deg.len() * channels;
    let factors = vec![1.0; grid.psi_deg.len() * grid.sigma_deg.len()];
    for (channel, name) in block_names(&component.channels).iter().enumerate() {
        let _ = writeln!(text, "{name}\n kbdf\n {}\n def", line(&factors));
        for (index, rows) in values.chunks_exact(row * grid.phi_deg.len()).enumerate() {
            let (psi, sigma) = (index / grid.sigma_deg.len(), index % grid.sigma_deg.len());
            let _ = writeln!(
                text,
                ";; Psi = {}\n;; Sigma = {}",
                grid.psi_deg[psi], grid.sigma_deg[sigma]
            );
            for row in rows.chunks_exact(row) {
                let row: Vec<f64> = row.iter().skip(channel).step_by(channels).map(|v| v * scale).collect();
                let _ = writeln!(text, " {}", line(&row));
            }
        }
        text += " enddef\n";
    }
    Ok(text.into_bytes())
}

pub(in crate::formats) fn specular(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let (component, provenance) = (content.component, content.provenance);
    let Table::Specular(table) = &component.table else {
        return Err(WriteError::CannotHold {
            format: content.format,
            holds: "specular fractions".into(),
            found: "scattering over directions".into(),
            remedy: "take ddr for scattering over directions".into(),
        });
    };
    if !table.azimuth().is_single() {
        notices.push(WriteNotice::FirstAzimuth);
    }
    let sigma = degrees(table.incidence().nodes_rad());
    let nodes = (0..sigma.len()).flat_map(|node| table.at(node, 0).to_vec());
    let values = mapped(nodes.collect(), &component.channels, notices)?;
    let mut text = format!(
        ";; specval {}\nSource {}\nTypeColorModel {}\nsigma {}\n {}\n",
        env!("CARGO_PKG_VERSION"),
        source(provenance),
        colour_model(&component.channels),
        sigma.len(),
        line(&sigma)
    );
    let channels = component.channels.count();
    for (channel, name) in block_names(&component.channels).iter().enumerate() {
        let row: Vec<f64> = values.iter().skip(channel).step_by(channels).copied().collect();
        let _ = writeln!(text, "{name}\n def\n {}\n enddef", line(&row));
    }
    Ok(text.into_bytes())
}
