use std::f64::consts::PI;
use std::fmt::Write;

use rayon::prelude::*;

use super::super::descriptor::Content;
use super::balance::{Balance, hemispherical};
use super::nodes::Probe;
use super::sampling::{Sampler, every};
use super::{WriteError, WriteNotice};
use crate::goniometric::{
    ChannelSet, Component, Directions, FileProvenance, Format, Grid, Hemispherical, Parameters, Quantity, Scatter,
    Scattered, Table, direction, rounded_deg,
};

/// Steps in θ_o, and in φ_o and φ_i, of a table that is resampled, where its values do not bend.
const POLAR_DEG: f64 = 5.0;
const AROUND_DEG: f64 = 15.0;
/// Nodes at most in θ_o and φ_o for each incidence, of isotropic and of anisotropic tables.
const MOST: [[usize; 2]; 2] = [[64, 60], [30, 36]];

/// A reading: its angles in radians, θ_in, φ_in, θ_out, φ_out or θ_in, θ_v; and f in 1/sr, or β in a CSV, one a
/// channel.
type ColumnReading = (Vec<f64>, Vec<f64>);

/// Lines of angles and values in the style of ASTM E1392: f over radians.
pub(in crate::formats) fn astm(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let component = content.component;
    let readings = readings(component, content.format, Quantity::Bsdf, notices)?;
    if component.scatter == Scatter::Transmission {
        notices.push(WriteNotice::TransmissionNotStated { format: content.format });
    }
    Ok(astm_lines(
        component,
        &readings,
        in_plane(&readings),
        content.provenance,
    ))
}

/// Lines of angles and values as this program's CSV: β over degrees.
pub(in crate::formats) fn csv(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let component = content.component;
    let readings = readings(component, content.format, Quantity::BrightnessFactor, notices)?;
    // A CSV's own errors are of its own quantity; no other format states any.
    let errors = match &component.table {
        Table::Scattered(scattered) => scattered.reading_errors(),
        _ => Vec::new(),
    };
    let plane = in_plane(&readings);
    Ok(csv_lines(component, &readings, &errors, plane, content.provenance))
}

fn in_plane(readings: &[ColumnReading]) -> bool {
    readings.first().is_some_and(|(angles, _)| angles.len() == 2)
}

fn astm_lines(component: &Component, readings: &[ColumnReading], plane: bool, provenance: &FileProvenance) -> Vec<u8> {
    let mut text = String::new();
    for (name, value) in &provenance.statements {
        let key = !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase() || c == '_') && name != "VARS";
        if key && name != "NUM_POINTS" {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name} {}", value.replace(['\n', '\r'], " "));
        }
    }
    let names = match &component.channels {
        ChannelSet::Monochrome => vec!["BSDF".to_owned()],
        channels => channels.names(),
    };
    let _ = writeln!(
        text,
        "NUM_POINTS {}\nVARS theta_i,phi_i,theta_s,phi_s,{}",
        readings.len(),
        names.join(",")
    );
    for (angles, values) in readings {
        let sphere = match angles[..] {
            [theta_i, theta_v] if plane => [theta_i, 0.0, theta_v.abs(), if theta_v < 0.0 { 0.0 } else { PI }].to_vec(),
            _ => angles.clone(),
        };
        let numbers: Vec<String> = sphere.iter().chain(values).map(f64::to_string).collect();
        let _ = writeln!(text, "{}", numbers.join(","));
    }
    text.into_bytes()
}

fn csv_lines(
    component: &Component,
    readings: &[ColumnReading],
    errors: &[(Vec<f64>, &[f64])],
    plane: bool,
    provenance: &FileProvenance,
) -> Vec<u8> {
    let mut text = String::new();
    for comment in &provenance.comments {
        let _ = writeln!(text, "# {comment}");
    }
    text += if plane {
        "theta_i_deg,theta_v_deg,"
    } else {
        "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,"
    };
    text += match component.channels {
        ChannelSet::Monochrome => "beta",
        ChannelSet::Rgb => "beta_r,beta_g,beta_b",
        ChannelSet::Xyz => "beta_x,beta_y,beta_z",
        ChannelSet::Wavelengths(_) => "wavelength_nm,beta",
    };
    if !errors.is_empty() {
        text += match component.channels {
            ChannelSet::Rgb => ",beta_r_se,beta_g_se,beta_b_se",
            ChannelSet::Xyz => ",beta_x_se,beta_y_se,beta_z_se",
            ChannelSet::Monochrome | ChannelSet::Wavelengths(_) => ",beta_se",
        };
    }
    text.push('\n');
    for (index, (angles, values)) in readings.iter().enumerate() {
        let errors = errors.get(index).map_or(&[][..], |(_, errors)| errors);
        let mut degrees: Vec<f64> = angles.iter().map(|&a| rounded_deg(a)).collect();
        if component.scatter == Scatter::Transmission && !plane {
            degrees[2] = 180.0 - degrees[2];
        }
        let degrees: Vec<String> = degrees.iter().map(f64::to_string).collect();
        let beta = values.iter().map(f64::to_string);
        if let ChannelSet::Wavelengths(grid) = &component.channels {
            for (channel, (nm, beta)) in grid.nm().iter().zip(beta).enumerate() {
                let error = errors.get(channel).map_or(String::new(), |error| format!(",{error}"));
                let _ = writeln!(text, "{},{nm},{beta}{error}", degrees.join(","));
            }
        } else {
            let numbers: Vec<String> = beta.chain(errors.iter().map(f64::to_string)).collect();
            let _ = writeln!(text, "{},{}", degrees.join(","), numbers.join(","));
        }
    }
    text.into_bytes()
}

/// The source's own readings or nodes where they are directions; else resampled.
fn readings(
    component: &Component,
    format: Format,
    quantity: Quantity,
    notices: &mut Vec<WriteNotice>,
) -> Result<Vec<ColumnReading>, WriteError> {
    let of = |value: f64, theta_o: f64| {
        if component.quantity == quantity {
            return Some(value);
        }
        quantity.of_bsdf(component.quantity.to_bsdf(value, theta_o.cos())?, theta_o.cos())
    };
    let converted = |values: Vec<f64>, theta_o: f64| {
        let values = values.into_iter().map(|v| of(v, theta_o));
        values.collect::<Option<Vec<f64>>>().ok_or(WriteError::Unscaled)
    };
    match &component.table {
        Table::Scattered(scattered) => {
            let theta_o = if scattered.directions() == Directions::Plane {
                1
            } else {
                2
            };
            let all = scattered.readings().into_iter();
            all.map(|(angles, values)| Ok((angles.clone(), converted(values.to_vec(), angles[theta_o])?)))
                .collect()
        }
        Table::Grid(grid) if is_spherical(grid) => {
            let [n0, n1, n2, n3] = grid.shape();
            let node = |i: usize| [i / (n3 * n2 * n1), i / (n3 * n2) % n1, i / n3 % n2, i % n3];
            let nodes = (0..n0 * n1 * n2 * n3).map(node);
            nodes
                .map(|node| {
                    let angles: Vec<f64> = (0..4).map(|axis| grid.axes()[axis].nodes_rad()[node[axis]]).collect();
                    let values = (0..component.channels.count())
                        .map(|channel| grid.at(node, channel))
                        .collect();
                    let values = converted(values, angles[2])?;
                    Ok((angles, values))
                })
                .collect()
        }
        _ => resampled(component, format, quantity, notices),
    }
}

/// The source's incidences, and for each of them outgoing directions that are closer where its values bend.
fn resampled(
    component: &Component,
    format: Format,
    quantity: Quantity,
    notices: &mut Vec<WriteNotice>,
) -> Result<Vec<ColumnReading>, WriteError> {
    let sampler = Sampler::new(component, format)?;
    let isotropic = component.is_isotropic();
    let azimuths = if isotropic { vec![0.0] } else { every(AROUND_DEG, 345.0) };
    let probed = if isotropic { vec![0.0] } else { vec![0.0, 45.0, 90.0] };
    let mut balance = Balance::default();
    let mut readings: Vec<ColumnReading> = Vec::new();
    let node = |[theta_i, phi_i]: [f64; 2], theta_o: f64, phi_o: f64| {
        let at = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
        (at(theta_i, phi_i), at(theta_o, phi_i + phi_o))
    };
    for theta_i in component.incidences_deg() {
        let probe = Probe::new(component, Sampler::new(component, format)?, &[theta_i], &probed);
        let even = [every(POLAR_DEG, 90.0), every(AROUND_DEG, 360.0)];
        let [theta_o, mut phi_o] = probe.nodes(even, MOST[usize::from(!isotropic)], node)?;
        phi_o.pop();
        let mut of_incidence: Vec<ColumnReading> = Vec::new();
        for &phi_i in &azimuths {
            // In the order of the file: outgoing azimuths from 0 to 360, not from the light's on.
            let mut phi_o: Vec<f64> = phi_o.iter().map(|phi| (phi + phi_i).rem_euclid(360.0)).collect();
            phi_o.sort_by(f64::total_cmp);
            for &theta_o in &theta_o {
                for &phi_o in &phi_o {
                    let (omega_in, omega_out) = node([theta_i, phi_i], theta_o, phi_o - phi_i);
                    let f = sampler.bsdf(&omega_in, &omega_out)?;
                    let angles = [theta_i, phi_i, theta_o, phi_o].map(f64::to_radians);
                    of_incidence.push((angles.to_vec(), f));
                }
            }
        }
        keep(component, theta_i, &azimuths, &mut of_incidence, &mut balance);
        readings.extend(of_incidence);
    }
    if quantity == Quantity::BrightnessFactor {
        readings.iter_mut().flat_map(|(_, f)| f).for_each(|f| *f *= PI);
    }
    sampler.notice(notices);
    balance.notice(notices);
    Ok(readings)
}

/// Scales the readings of an incidence to the source's hemispherical values, one an incident azimuth, which they are in
/// the order of.
fn keep(component: &Component, theta_i: f64, azimuths: &[f64], readings: &mut [ColumnReading], balance: &mut Balance) {
    let channels = component.channels.count();
    let angles: Vec<Vec<f64>> = readings.iter().map(|(angles, _)| angles.clone()).collect();
    let values = readings.iter().flat_map(|(_, f)| f.iter().copied()).collect();
    let Ok(table) = Scattered::new(Directions::Sphere, &angles, channels, values) else {
        return;
    };
    let table = Component {
        quantity: Quantity::Bsdf,
        table: Table::Scattered(table),
        ..component.clone()
    };
    let found: Vec<[Option<Hemispherical>; 2]> = azimuths
        .par_iter()
        .map(|&phi_i| [component, &table].map(|of| hemispherical(of, theta_i, phi_i)))
        .collect();
    let each = readings.len() / azimuths.len();
    for ([source, written], readings) in found.iter().zip(readings.chunks_mut(each)) {
        let factors = balance.factors(theta_i, source.as_ref(), written.as_ref(), channels);
        for (_, f) in readings {
            f.iter_mut().zip(&factors).for_each(|(f, factor)| *f *= factor);
        }
    }
}

fn is_spherical(grid: &Grid) -> bool {
    *grid.parameters() == Parameters::Spherical && grid.fold() == super::super::Fold::None
}
