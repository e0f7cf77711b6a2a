use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::super::goniometric::angles_of;
use super::super::rgl::{Unwarped, write as write_arrays};
use super::super::warped::unwarped_node;
use super::super::{Channels, Component, Format, Provenance, Table};
use super::WriteError;
use super::sampling::{ChannelMap, Sampler, clipped};

/// f cos θ_out over half vectors, without a warp: what Mitsuba, pbrt and powitacq read as it stands. Spectral data stay
/// spectral; all others become RGB.
pub(super) fn write(
    component: &Component,
    provenance: &Provenance,
    notices: &mut Vec<String>,
) -> Result<Vec<u8>, WriteError> {
    let sampler = Sampler::new(component, Format::Rgl)?;
    let isotropic = component.is_isotropic();
    let map = match component.channels {
        Channels::Wavelengths(_) => ChannelMap::Same,
        _ => ChannelMap::to_rgb(&component.channels, notices)?,
    };
    let (phi_i, theta_i, n) = axes(component);
    let channels = match &component.channels {
        Channels::Wavelengths(grid) => grid.len(),
        _ => 3,
    };
    let square = n * n;
    let slices = phi_i.len() * theta_i.len();
    let mut values = vec![0.0; slices * channels * square];
    let mut luminance = vec![0.0; slices * square];
    let mut negative = Vec::new();
    for slice in 0..slices {
        let (phi, theta) = (phi_i[slice / theta_i.len()], theta_i[slice % theta_i.len()]);
        for node in 0..square {
            let place = [node / n, node % n];
            let (omega_in, omega_out) = unwarped_node(theta, phi, isotropic, n, place);
            let mut f = map.apply(&sampler.bsdf(&omega_in, &omega_out)?);
            clipped(&mut f, &mut negative);
            for (channel, f) in f.iter().enumerate() {
                // Below the horizon the cosine has its sign, so that what is interpolated above it goes to 0 there.
                values[(slice * channels + channel) * square + node] = (f * omega_out.z) as f32;
            }
            let half = omega_in + omega_out;
            let (theta_m, _) = angles_of(&half);
            let mean = f.iter().sum::<f64>() / channels as f64 * omega_out.z.max(0.0);
            let x = place[1] as f64 / (n - 1) as f64;
            // Density of the reflected direction over that of the square's points.
            let jacobian = TAU * PI * x * theta_m.sin() * 4.0 * half.normalize().dot(&omega_in).max(0.0);
            luminance[slice * square + node] = (mean * jacobian) as f32;
        }
    }
    if !negative.is_empty() {
        notices.push("components of colours outside the RGB space are written as 0".into());
    }
    floor(&mut luminance, square);
    let nm: Option<Vec<f32>> = match &component.channels {
        Channels::Wavelengths(grid) => Some(grid.nm().iter().map(|&nm| nm as f32).collect()),
        _ => None,
    };
    if !matches!(&component.table, Table::Warped(table) if table.is_unwarped()) {
        sampler.notice(notices);
    }
    let single = |list: &[f64]| list.iter().map(|&v| v as f32).collect::<Vec<f32>>();
    Ok(write_arrays(&Unwarped {
        description: &description(provenance),
        phi_i_rad: &single(&phi_i),
        theta_i_rad: &single(&theta_i),
        wavelengths_nm: nm.as_deref(),
        size: n,
        luminance: &luminance,
        values: &values,
    }))
}

/// Incident azimuths and polar angles in radians, and nodes along the square: the source's own where it has such a
/// table; else its incidences and every 5 degrees between them.
fn axes(component: &Component) -> (Vec<f64>, Vec<f64>, usize) {
    if let Table::Warped(table) = &component.table
        && table.is_unwarped()
    {
        return (
            table.azimuth().nodes_rad().to_vec(),
            table.incidence().nodes_rad().to_vec(),
            table.size(),
        );
    }
    let own = component.incidences_deg();
    let (first, last) = (own.first().copied().unwrap_or(0.0), own.last().copied().unwrap_or(0.0));
    let between = (0..=17)
        .map(|i| 5.0 * f64::from(i))
        .filter(|a| (first..last).contains(a));
    let mut theta_deg: Vec<f64> = own.iter().copied().chain(between).filter(|&a| a < 89.0).collect();
    if last >= 89.0 {
        theta_deg.push(89.0);
    }
    theta_deg.sort_by(f64::total_cmp);
    theta_deg.dedup_by(|a, b| (*a - *b).abs() < 0.5);
    let theta = theta_deg.iter().map(|a| a.to_radians().min(FRAC_PI_2)).collect();
    if component.is_isotropic() {
        return (vec![0.0], theta, 64);
    }
    ((0..=16).map(|i| f64::from(i) / 16.0 * TAU - PI).collect(), theta, 32)
}

/// A density of 0 all over would make readers divide by it.
fn floor(luminance: &mut [f32], square: usize) {
    for slice in luminance.chunks_exact_mut(square) {
        let most = slice.iter().copied().fold(0.0, f32::max);
        let least = if most > 0.0 { 1e-4 * most } else { 1.0 };
        slice.iter_mut().for_each(|v| *v = v.max(least));
    }
}

fn description(provenance: &Provenance) -> String {
    let stated = provenance.statements.iter().find(|(name, _)| name == "description");
    match stated {
        Some((_, words)) => words.clone(),
        None => format!("written by specval {}", env!("CARGO_PKG_VERSION")),
    }
}
