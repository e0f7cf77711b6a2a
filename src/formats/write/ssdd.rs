use std::f64::consts::TAU;
use std::fmt::Write;

use super::super::integra::degrees;
use super::super::{
    Channels, Component, Fold, Format, Goniometric, Grid, Parameters, Quantity, Scatter, Side, SpecularTable, Table,
};
use super::WriteError;
use super::integra::{SpecularGrid, line};

/// Text blocks, one a component of the front, values with all their digits.
pub(super) fn write(data: &Goniometric, notices: &mut Vec<String>) -> Result<Vec<u8>, WriteError> {
    let mut text = format!("VERSION 0.3\nSOFTWARE specval-{}\n", env!("CARGO_PKG_VERSION"));
    for comment in &data.provenance.comments {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "# {}", comment.replace(['\n', '\r'], " "));
    }
    let source = data
        .provenance
        .source
        .as_deref()
        .unwrap_or_default()
        .to_ascii_lowercase();
    let known = ["measured", "generated", "edited"];
    let mut kinds: Vec<&str> = Vec::new();
    for component in &data.components {
        if component.side == Side::Back {
            notices.push("ssdd holds light from the front alone: what comes from the back is left out".into());
            continue;
        }
        let kind = kind(component);
        if kinds.contains(&kind) {
            notices.push(format!("ssdd holds one block {kind}: the others are left out"));
            continue;
        }
        kinds.push(kind);
        let _ = writeln!(
            text,
            "\nDATA_TYPE {kind}\nCOLOR_MODEL {}",
            colour_model(&component.channels)
        );
        if let Channels::Wavelengths(grid) = &component.channels {
            let _ = writeln!(text, "WAVELENGTH_LIST {}", line(grid.nm()));
        }
        match &component.table {
            Table::Specular(table) => specular(&mut text, table),
            Table::Grid(grid) if is_held(grid) => same(&mut text, component, grid)?,
            _ => resampled(&mut text, component, notices)?,
        }
    }
    if let Some(word) = known.into_iter().find(|word| *word == source) {
        text = text.replacen("\nDATA_TYPE", &format!("\nSOURCE_TYPE {word}\nDATA_TYPE"), 1);
    }
    Ok(text.into_bytes())
}

fn kind(component: &Component) -> &'static str {
    match (component.scatter, &component.table) {
        (Scatter::Reflection, Table::Specular(_)) => "specular_reflectance",
        (Scatter::Transmission, Table::Specular(_)) => "specular_transmittance",
        (Scatter::Reflection, _) => "brdf",
        (Scatter::Transmission, _) => "btdf",
    }
}

fn colour_model(channels: &Channels) -> &'static str {
    match channels {
        Channels::Monochrome => "monochrome",
        Channels::Rgb => "rgb",
        Channels::Xyz => "xyz",
        Channels::Wavelengths(_) => "spectrum",
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

fn specular(text: &mut String, table: &SpecularTable) {
    let (incidence, azimuth) = (degrees(table.incidence()), degrees(table.azimuth()));
    lists(text, &[(0, &incidence)]);
    if !table.azimuth().is_single() {
        lists(text, &[(1, &azimuth)]);
    }
    *text += "DATA ascii\n";
    for phi in 0..azimuth.len() {
        for theta in 0..incidence.len() {
            let _ = writeln!(text, "{}", line(table.at(theta, phi)));
        }
    }
}

fn same(text: &mut String, component: &Component, grid: &Grid) -> Result<(), WriteError> {
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
    let axes = grid.axes().each_ref().map(degrees);
    lists(text, &[(0, &axes[0])]);
    if !grid.is_isotropic() {
        lists(text, &[(1, &axes[1])]);
    }
    lists(text, &[(2, &axes[2]), (3, &axes[3])]);
    if let Some(offsets) = offsets.filter(|offsets| offsets.iter().any(|&o| o != 0.0)) {
        let offsets: Vec<f64> = offsets.iter().map(|o| (o.to_degrees() * 1e9).round() / 1e9).collect();
        lists(text, &[(4, &offsets)]);
    }
    *text += "DATA ascii\n";
    let [n0, n1, n2, n3] = grid.shape();
    for node in (0..n0 * n1 * n2 * n3).map(|i| [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2]) {
        let cos_out = grid.directions(node).map_or(0.0, |(_, omega_out)| omega_out.z);
        let mut values = Vec::new();
        for channel in 0..component.channels.count() {
            let stored = grid.at(node, channel);
            // Below the horizon a value that holds the cosine has no f; nothing is looked up there.
            let below = component.quantity == Quantity::BsdfCosine && cos_out <= 0.0;
            let bsdf = if below {
                Some(0.0)
            } else {
                component.quantity.to_bsdf(stored, cos_out)
            };
            values.push(bsdf.ok_or(WriteError::Unscaled)?);
        }
        let _ = writeln!(text, "{}", line(&values));
    }
    Ok(())
}

fn resampled(text: &mut String, component: &Component, notices: &mut Vec<String>) -> Result<(), WriteError> {
    let grid = SpecularGrid::of(component, Format::Ssdd, notices)?;
    *text += "PARAM_TYPE specular_coordinate_system\n";
    lists(text, &[(0, &grid.sigma_deg)]);
    if grid.psi_deg.len() > 1 {
        lists(text, &[(1, &grid.psi_deg)]);
    }
    lists(text, &[(2, &grid.theta_deg), (3, &grid.phi_deg)]);
    *text += "DATA ascii\n";
    let channels = component.channels.count();
    let [n0, n1, n2, n3] = [&grid.sigma_deg, &grid.psi_deg, &grid.theta_deg, &grid.phi_deg].map(Vec::len);
    for i in 0..n0 * n1 * n2 * n3 {
        let [i0, i1, i2, i3] = [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2];
        let at = channels * (((i1 * n0 + i0) * n3 + i3) * n2 + i2);
        let _ = writeln!(text, "{}", line(&grid.values[at..at + channels]));
    }
    Ok(())
}
