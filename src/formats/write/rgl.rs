use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use super::super::descriptor::Content;
use super::super::rgl_arrays::{Unwarped, write as write_arrays};
use super::balance::{Balance, mapped};
use super::sampling::{ChannelMap, Sampler, clipped};
use super::{WriteError, WriteNotice};
use crate::goniometric::{
    ChannelSet, Component, FileProvenance, Hemispherical, Table, angles_of, rounded_deg, unwarped_node,
};

/// Nodes along the square, of isotropic and of anisotropic tables, from the fewest on.
const SIZES: [[usize; 3]; 2] = [[64, 128, 256], [32, 64, 96]];
/// Departure of a hemispherical value from which on more nodes are taken, and the incidence beyond which none are:
/// there lobes are cut by the horizon, and no number of nodes would do.
const REFINED: f64 = 3e-3;
const GRAZING_DEG: f64 = 80.5;

/// f cos θ_out over half vectors, without a warp: what Mitsuba, pbrt and powitacq read as it stands. Spectral data stay
/// spectral; all others become RGB.
pub(in crate::formats) fn write(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let (component, provenance) = (content.component, content.provenance);
    let sampler = Sampler::new(component, content.format)?;
    let isotropic = component.is_isotropic();
    let map = match component.channels {
        ChannelSet::Wavelengths(_) => ChannelMap::Same,
        _ => ChannelMap::to_rgb(&component.channels, notices)?,
    };
    let (phi_i, theta_i, own) = axes(component);
    let nm: Option<Vec<f32>> = match &component.channels {
        ChannelSet::Wavelengths(grid) => Some(grid.nm().iter().map(|&nm| nm as f32).collect()),
        _ => None,
    };
    let single = |list: &[f64]| list.iter().map(|&v| v as f32).collect::<Vec<f32>>();
    let slices = Slices {
        sampler: &sampler,
        map: &map,
        isotropic,
        phi_i: &phi_i,
        theta_i: &theta_i,
        channels: nm.as_ref().map_or(3, Vec::len),
    };
    let file = |filled: &Filled| {
        write_arrays(&Unwarped {
            description: &description(provenance),
            phi_i_rad: &single(&phi_i),
            theta_i_rad: &single(&theta_i),
            wavelengths_nm: nm.as_deref(),
            size: filled.size,
            luminance: &filled.luminance,
            values: &filled.values,
        })
    };
    let mut balance = Balance::default();
    let mut filled = slices.fill(own.unwrap_or(SIZES[usize::from(!isotropic)][0]))?;
    if own.is_none() {
        let source = slices.hemispherical(component);
        // The file as every reader has it, and finer until it has the source's hemispherical values.
        let mut sizes = SIZES[usize::from(!isotropic)].into_iter().skip(1);
        loop {
            let bytes = file(&filled);
            let mut found = Balance::default();
            let factors = slices.factors(&source, &bytes, &mut found);
            match sizes.next().filter(|_| slices.largest(&factors) > REFINED) {
                Some(size) => filled = slices.fill(size)?,
                None => {
                    filled.scale(&factors, slices.channels);
                    balance = found;
                    break;
                }
            }
        }
        sampler.notice(notices);
    }
    if filled.clipped {
        notices.push(WriteNotice::Clipped { components: None });
    }
    balance.notice(notices);
    Ok(file(&filled))
}

/// What slices over the incident direction are filled with.
struct Slices<'a> {
    sampler: &'a Sampler<'a>,
    map: &'a ChannelMap,
    isotropic: bool,
    phi_i: &'a [f64],
    theta_i: &'a [f64],
    channels: usize,
}

/// Values of every slice on a square of nodes.
struct Filled {
    size: usize,
    values: Vec<f32>,
    luminance: Vec<f32>,
    clipped: bool,
}

impl Filled {
    /// Multiplies the values by a factor for each slice and channel.
    fn scale(&mut self, factors: &[f64], channels: usize) {
        let square = self.size * self.size;
        for (values, factor) in self.values.chunks_mut(square).zip(factors) {
            values.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        }
        for (luminance, factors) in self.luminance.chunks_mut(square).zip(factors.chunks(channels)) {
            let mean = factors.iter().sum::<f64>() / channels as f64;
            luminance.iter_mut().for_each(|v| *v = (f64::from(*v) * mean) as f32);
        }
    }
}

impl Slices<'_> {
    /// Azimuth and polar angle of a slice, in radians.
    fn incidence(&self, slice: usize) -> (f64, f64) {
        let thetas = self.theta_i.len();
        (self.phi_i[slice / thetas], self.theta_i[slice % thetas])
    }

    fn count(&self) -> usize {
        self.phi_i.len() * self.theta_i.len()
    }

    fn fill(&self, n: usize) -> Result<Filled, WriteError> {
        let (channels, square) = (self.channels, n * n);
        let mut values = vec![0.0; self.count() * channels * square];
        let mut luminance = vec![0.0; self.count() * square];
        let mut negative = Vec::new();
        for slice in 0..self.count() {
            let (phi, theta) = self.incidence(slice);
            for node in 0..square {
                let place = [node / n, node % n];
                let (omega_in, omega_out) = unwarped_node(theta, phi, self.isotropic, n, place);
                let mut f = self.map.apply(&self.sampler.bsdf(&omega_in, &omega_out)?);
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
        floor(&mut luminance, square);
        Ok(Filled {
            size: n,
            values,
            luminance,
            clipped: !negative.is_empty(),
        })
    }

    /// The largest departure from 1 of factors, a list for each slice, but those at grazing incidence.
    fn largest(&self, factors: &[f64]) -> f64 {
        let of_slices = factors.chunks(self.channels).enumerate();
        let seen = of_slices.filter(|(slice, _)| self.incidence(*slice).1.to_degrees() < GRAZING_DEG);
        seen.flat_map(|(_, factors)| factors)
            .fold(0.0, |most, factor| most.max((factor - 1.0).abs()))
    }

    /// The hemispherical values of a component at the incidences of the slices.
    fn hemispherical(&self, of: &Component) -> Vec<Option<Hemispherical>> {
        let slices: Vec<usize> = (0..self.count()).collect();
        let found = slices.par_iter().map(|&slice| {
            let (phi, theta) = self.incidence(slice);
            of.directional_hemispherical(theta, phi)
        });
        found.collect()
    }

    /// A factor for each slice and channel, by which the file of these bytes has the source's hemispherical values.
    fn factors(&self, source: &[Option<Hemispherical>], bytes: &[u8], balance: &mut Balance) -> Vec<f64> {
        let Ok(read) = super::super::rgl_read::read("", bytes) else {
            return vec![1.0; self.count() * self.channels];
        };
        let found = self.hemispherical(&read.components[0]);
        let all = source.iter().zip(&found).enumerate();
        all.flat_map(|(slice, (source, found))| {
            let theta_deg = rounded_deg(self.incidence(slice).1);
            balance.factors(
                theta_deg,
                source.as_ref().map(|of| mapped(of, self.map)).as_ref(),
                found.as_ref(),
                self.channels,
            )
        })
        .collect()
    }
}

/// Incident azimuths and polar angles in radians, and nodes along the square: the source's own where it has such a
/// table; else its incidences and every 5 degrees between them, and no nodes.
fn axes(component: &Component) -> (Vec<f64>, Vec<f64>, Option<usize>) {
    if let Table::Warped(table) = &component.table
        && table.is_unwarped()
        && table.covers_circle()
    {
        return (
            table.azimuth().nodes_rad().to_vec(),
            table.incidence().nodes_rad().to_vec(),
            Some(table.size()),
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
        return (vec![0.0], theta, None);
    }
    ((0..=16).map(|i| f64::from(i) / 16.0 * TAU - PI).collect(), theta, None)
}

/// A density of 0 all over would make readers divide by it.
fn floor(luminance: &mut [f32], square: usize) {
    for slice in luminance.chunks_exact_mut(square) {
        let most = slice.iter().copied().fold(0.0, f32::max);
        let least = if most > 0.0 { 1e-4 * most } else { 1.0 };
        slice.iter_mut().for_each(|v| *v = v.max(least));
    }
}

fn description(provenance: &FileProvenance) -> String {
    let stated = provenance.statements.iter().find(|(name, _)| name == "description");
    match stated {
        Some((_, words)) => words.clone(),
        None => format!("written by specval {}", env!("CARGO_PKG_VERSION")),
    }
}
