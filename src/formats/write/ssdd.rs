use std::f64::consts::TAU;
use std::fmt::Write;

use super::super::descriptor::Content;
use super::super::options::Encoding;
use super::integra::{SpecularGrid, line};
use super::{WriteError, WriteNotice};
use crate::goniometric::{
    ChannelSet, Component, Fold, Format, Grid, Parameters, Scatter, SpecularTable, Table, degrees,
};

/// Blocks of values with all their digits, or of 32-bit floats, one a component.
pub(in crate::formats) fn write(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let (components, provenance) = (content.components, content.provenance);
    let mut head = format!("VERSION 0.3\nSOFTWARE specval-{}\n", env!("CARGO_PKG_VERSION"));
    for comment in &provenance.comments {
        // Writing to a string cannot fail.
        let _ = writeln!(head, "# {}", comment.replace(['\n', '\r'], " "));
    }
    let source = provenance.source.as_deref().unwrap_or_default().to_ascii_lowercase();
    let source = ["measured", "generated", "edited"]
        .into_iter()
        .find(|word| *word == source);
    let mut bytes = head.into_bytes();
    let mut rounded = false;
    for component in components {
        let kind = kind(component);
        let mut text = format!(
            "\nDATA_TYPE {kind}\nCOLOR_MODEL {}\n",
            colour_model(&component.channels)
        );
        if let Some(source) = source {
            let _ = writeln!(text, "SOURCE_TYPE {source}");
        }
        if let ChannelSet::Wavelengths(grid) = &component.channels {
            let _ = writeln!(text, "WAVELENGTH_LIST {}", line(grid.nm()));
        }
        let values = match &component.table {
            Table::Specular(table) => specular(&mut text, table),
            Table::Grid(grid) if is_held(grid) => same(&mut text, component, grid)?,
            _ => resampled(&mut text, component, content.format, notices)?,
        };
        match content.encoding {
            Encoding::Text => {
                text += "DATA ascii\n";
                for row in values.chunks_exact(component.channels.count()) {
                    let _ = writeln!(text, "{}", line(row));
                }
                bytes.extend(text.into_bytes());
            }
            Encoding::Binary => {
                text += "DATA binary\n";
                bytes.extend(text.into_bytes());
                bytes.extend(binary(&values, content.format)?);
                rounded |= values.iter().any(|&value| f64::from(value as f32) != value);
                bytes.push(b'\n');
            }
        }
    }
    if rounded {
        notices.push(WriteNotice::RoundedTo32Bits);
    }
    Ok(bytes)
}

/// 32-bit floats. libbsdf takes a '#' behind white space for the beginning of a comment, even here; the value that
/// would begin the data so is raised by a few units in its last place.
fn binary(values: &[f64], format: Format) -> Result<Vec<u8>, WriteError> {
    let beyond = |value: &&f64| **value > f64::from(f32::MAX);
    if let Some(value) = values.iter().find(beyond) {
        return Err(WriteError::CannotHold {
            format,
            holds: "values up to 3.4e38 in binary".into(),
            found: value.to_string(),
            remedy: "write it as text: --to ssdd".into(),
        });
    }
    let mut bytes: Vec<u8> = values.iter().flat_map(|&value| (value as f32).to_le_bytes()).collect();
    let blank = |byte: &u8| matches!(byte, 0x09..=0x0d | b' ');
    while let Some(first) = bytes
        .iter()
        .position(|byte| !blank(byte))
        .filter(|&at| bytes[at] == b'#')
    {
        // The lowest byte of a value is blank or '#', so that nothing is carried.
        bytes[first / 4 * 4] += 1;
    }
    Ok(bytes)
}

fn kind(component: &Component) -> &'static str {
    match (component.scatter, &component.table) {
        (Scatter::Reflection, Table::Specular(_)) => "specular_reflectance",
        (Scatter::Transmission, Table::Specular(_)) => "specular_transmittance",
        (Scatter::Reflection, _) => "brdf",
        (Scatter::Transmission, _) => "btdf",
    }
}

fn colour_model(channels: &ChannelSet) -> &'static str {
    match channels {
        ChannelSet::Monochrome => "monochrome",
        ChannelSet::Rgb => "rgb",
        ChannelSet::Xyz => "xyz",
        ChannelSet::Wavelengths(_) => "spectrum",
    }
}

/// Whether the format has these nodes: no gaps, and azimuths from 0 on.
fn is_held(grid: &Grid) -> bool {
    let range = |axis: usize, low: f64, high: f64| {
        grid.axes()[axis]
            .nodes_rad()
            .iter()
            .all(|a| (low - 1e-12..=high + 1e-12).contains(a))
    };
    let ends = |last: f64| {
        let nodes = grid.axes()[3].nodes_rad();
        nodes[0] == 0.0 && (nodes[nodes.len() - 1] - last).abs() < 1e-9
    };
    let folded = match grid.fold() {
        Fold::None => true,
        Fold::Mirror | Fold::HalfTurn => ends(TAU / 2.0),
        Fold::MirrorAndHalfTurn => ends(TAU / 4.0),
    };
    !grid.has_holes() && folded && range(1, 0.0, TAU) && range(3, 0.0, TAU)
}

fn lists(text: &mut String, lists: &[(usize, &[f64])]) {
    for (index, list) in lists {
        let _ = writeln!(text, "PARAM{index}_LIST {}", line(list));
    }
}

fn specular(text: &mut String, table: &SpecularTable) -> Vec<f64> {
    let table = &table.closed();
    let (incidence, azimuth) = (
        degrees(table.incidence().nodes_rad()),
        degrees(table.azimuth().nodes_rad()),
    );
    lists(text, &[(0, &incidence)]);
    if !table.azimuth().is_single() {
        lists(text, &[(1, &azimuth)]);
    }
    let nodes = (0..azimuth.len()).flat_map(|phi| (0..incidence.len()).map(move |theta| (theta, phi)));
    nodes.flat_map(|(theta, phi)| table.at(theta, phi).to_vec()).collect()
}

fn same(text: &mut String, component: &Component, grid: &Grid) -> Result<Vec<f64>, WriteError> {
    // Some readers hold the value of the last azimuth up to 360 degrees.
    let grid = &grid.closed();
    let (name, offsets) = match grid.parameters() {
        Parameters::Spherical => ("spherical", None),
        Parameters::Specular { offsets_rad } => ("specular", Some(offsets_rad)),
        Parameters::HalfDifference => ("half_difference", None),
        Parameters::Distorted { offsets_rad } => ("distorted_spherical", Some(offsets_rad)),
    };
    let _ = writeln!(text, "PARAM_TYPE {name}_coordinate_system");
    match grid.fold() {
        Fold::None => {}
        Fold::Mirror => *text += "REDUCTION_TYPE bilateral_symmetry\n",
        Fold::HalfTurn => *text += "REDUCTION_TYPE reciprocity\n",
        Fold::MirrorAndHalfTurn => *text += "REDUCTION_TYPE bilateral_symmetry reciprocity\n",
    }
    let axes = grid.axes().each_ref().map(|axis| degrees(axis.nodes_rad()));
    lists(text, &[(0, &axes[0])]);
    if !grid.is_isotropic() {
        lists(text, &[(1, &axes[1])]);
    }
    lists(text, &[(2, &axes[2]), (3, &axes[3])]);
    if let Some(offsets) = offsets.filter(|offsets| offsets.iter().any(|&o| o != 0.0)) {
        let offsets: Vec<f64> = offsets.iter().map(|o| (o.to_degrees() * 1e9).round() / 1e9).collect();
        lists(text, &[(4, &offsets)]);
    }
    let [n0, n1, n2, n3] = grid.shape();
    let mut values = Vec::new();
    for node in (0..n0 * n1 * n2 * n3).map(|i| [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2]) {
        for channel in 0..component.channels.count() {
            // No grid holds the cosine.
            let bsdf = component.quantity.to_bsdf(grid.at(node, channel), 1.0);
            values.push(bsdf.ok_or(WriteError::Unscaled)?);
        }
    }
    Ok(values)
}

fn resampled(
    text: &mut String,
    component: &Component,
    format: Format,
    notices: &mut Vec<WriteNotice>,
) -> Result<Vec<f64>, WriteError> {
    let grid = SpecularGrid::of(component, format, notices)?;
    *text += "PARAM_TYPE specular_coordinate_system\n";
    lists(text, &[(0, &grid.sigma_deg)]);
    if grid.psi_deg.len() > 1 {
        lists(text, &[(1, &grid.psi_deg)]);
    }
    lists(text, &[(2, &grid.theta_deg), (3, &grid.phi_deg)]);
    let channels = component.channels.count();
    let [n0, n1, n2, n3] = [&grid.sigma_deg, &grid.psi_deg, &grid.theta_deg, &grid.phi_deg].map(Vec::len);
    let mut values = Vec::with_capacity(grid.values.len());
    for i in 0..n0 * n1 * n2 * n3 {
        let [i0, i1, i2, i3] = [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2];
        let at = channels * (((i1 * n0 + i0) * n3 + i3) * n2 + i2);
        values.extend(&grid.values[at..at + channels]);
    }
    Ok(values)
}
