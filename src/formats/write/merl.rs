use std::f64::consts::TAU;

use rayon::prelude::*;

use super::super::descriptor::Content;
use super::super::merl_table as merl;
use super::balance::{Balance, hemispherical, mapped};
use super::sampling::{ChannelMap, Sampler, clipped, every};
use super::{WriteError, WriteNotice};
use crate::geometry::Vec3;
use crate::goniometric::{ChannelSet, Component, Format, Hemispherical, Quantity, Scatter, Side, Table};

/// Departures of hemispherical values that nodes are not scaled for.
const KEPT: f64 = 5e-3;
/// Times that hemispherical values are compared and values scaled.
const PASSES: usize = 3;
/// Incident azimuths an anisotropic source is averaged over.
const TURNS: usize = 8;

/// Linear RGB at each node; of an anisotropic source the mean over turns of the sample about its normal.
pub(in crate::formats) fn write(content: &Content, notices: &mut Vec<WriteNotice>) -> Result<Vec<u8>, WriteError> {
    let component = content.component;
    let map = ChannelMap::to_rgb(&component.channels, notices)?;
    let as_rgb = component.with_channels(ChannelSet::Rgb, |values| map.apply(values));
    let (component, map) = match &as_rgb {
        Some(as_rgb) => (as_rgb, ChannelMap::Same),
        None => (component, map),
    };
    let sampler = Sampler::new(component, content.format)?;
    let turns = if component.is_isotropic() { 1 } else { TURNS };
    if turns > 1 {
        notices.push(WriteNotice::Isotropic {
            format: content.format,
            azimuths: TURNS,
        });
    }
    let turns_rad: Vec<f64> = (0..turns).map(|turn| turn as f64 / turns as f64 * TAU).collect();
    let mean = |omega_in: &Vec3, omega_out: &Vec3| -> Result<[f64; 3], WriteError> {
        // The map is linear: the mean of the source's channels is mapped once.
        let rgb = map.apply(&sampler.mean_over_turns(omega_in, omega_out, &turns_rad)?);
        Ok([rgb[0], rgb[1], rgb[2]])
    };
    // A node stands for the pair and for the exchanged one.
    let both = |omega_in: &Vec3, omega_out: &Vec3| -> Result<([f64; 3], Departure), WriteError> {
        let (there, back) = (mean(omega_in, omega_out)?, mean(omega_out, omega_in)?);
        let rgb = std::array::from_fn(|channel| 0.5 * (there[channel] + back[channel]));
        Ok((rgb, Departure::of(omega_in, omega_out, there, back)))
    };
    let all: Vec<usize> = (0..merl::NODES).collect();
    let nodes = all.par_iter().map(|&node| match merl::directions(node) {
        (omega_in, omega_out) if omega_in.z > 0.0 && omega_out.z > 0.0 => both(&omega_in, &omega_out).map(Some),
        // No data below the horizon.
        _ => Ok(None),
    });
    let nodes = nodes.collect::<Result<Vec<Option<([f64; 3], Departure)>>, _>>()?;
    let departures = nodes.iter().flatten().map(|(_, departure)| *departure);
    if let Some(largest) = departures.max_by(|a, b| a.share.total_cmp(&b.share)) {
        largest.notice(content.format, notices);
    }
    let mut rgb: Vec<Option<[f64; 3]>> = nodes.into_iter().map(|node| node.map(|(rgb, _)| rgb)).collect();
    let mut negative = Vec::new();
    rgb.iter_mut()
        .flatten()
        .for_each(|values| clipped(values, &mut negative));
    if !negative.is_empty() {
        notices.push(WriteNotice::Clipped { components: None });
    }
    sampler.notice(notices);
    keep(component, &map, &turns_rad, &mut rgb, notices);
    Ok(merl::bytes(&rgb))
}

/// What a pair of directions loses of its value when it gets the mean of the two that are exchanged.
#[derive(Clone, Copy)]
struct Departure {
    /// Of the mean.
    share: f64,
    /// Polar angles in degrees.
    theta_deg: [f64; 2],
    /// Values of the channel, 1/sr.
    values: [f64; 2],
}

impl Departure {
    fn of(omega_in: &Vec3, omega_out: &Vec3, there: [f64; 3], back: [f64; 3]) -> Self {
        let polar = |omega: &Vec3| omega.z.clamp(-1.0, 1.0).acos().to_degrees();
        let of = |channel: usize| {
            let (a, b) = (there[channel], back[channel]);
            let sum = (a + b).abs();
            if sum > 0.0 { (a - b).abs() / sum } else { 0.0 }
        };
        let worst = (0..3).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap_or(0);
        Self {
            share: of(worst),
            theta_deg: [polar(omega_in), polar(omega_out)],
            values: [there[worst], back[worst]],
        }
    }

    fn notice(&self, format: Format, notices: &mut Vec<WriteNotice>) {
        /// Below it values differ by interpolation alone.
        const TOLD: f64 = 1e-3;
        if self.share > TOLD {
            notices.push(WriteNotice::Reciprocal {
                format,
                share: self.share,
                theta_deg: self.theta_deg,
                values: self.values,
            });
        }
    }
}

/// Scales values by √(a(θ_i) a(θ_o)), which keeps them reciprocal, with a such that hemispherical values are the
/// source's.
fn keep(
    component: &Component,
    map: &ChannelMap,
    turns_rad: &[f64],
    rgb: &mut [Option<[f64; 3]>],
    notices: &mut Vec<WriteNotice>,
) {
    const STEP_DEG: f64 = 5.0;
    let incidences_deg = every(STEP_DEG, 80.0);
    let wanted: Vec<Option<Hemispherical>> = incidences_deg
        .par_iter()
        .map(|&theta| {
            let turned = turns_rad
                .iter()
                .map(|turn| hemispherical(component, theta, turn.to_degrees()));
            let all: Vec<Hemispherical> = turned.collect::<Option<_>>()?;
            let n = all.len() as f64;
            let mean = |of: fn(&Hemispherical) -> &Vec<f64>| -> Vec<f64> {
                let channels = 0..component.channels.count();
                channels
                    .map(|c| all.iter().map(|found| of(found)[c]).sum::<f64>() / n)
                    .collect()
            };
            let mean = Hemispherical {
                values: mean(|found| &found.values),
                errors: mean(|found| &found.errors),
                measured: all.iter().map(|found| found.measured).fold(1.0, f64::min),
            };
            Some(mapped(&mean, map))
        })
        .collect();
    let written = |rgb: &[Option<[f64; 3]>]| -> Vec<Option<Hemispherical>> {
        let table = Component {
            scatter: Scatter::Reflection,
            side: Side::Front,
            quantity: Quantity::Bsdf,
            channels: ChannelSet::Rgb,
            table: Table::Grid(merl::table(rgb)),
        };
        incidences_deg
            .par_iter()
            .map(|&theta| hemispherical(&table, theta, 0.0))
            .collect()
    };
    let mut balance = Balance::default();
    for pass in 0..PASSES {
        let mut each = Balance::default();
        let found = written(rgb);
        let factors: Vec<Vec<f64>> = (incidences_deg.iter().zip(wanted.iter().zip(&found)))
            .map(|(&theta, (wanted, found))| each.factors(theta, wanted.as_ref(), found.as_ref(), 3))
            .collect();
        if factors.iter().flatten().all(|factor| (factor - 1.0).abs() < KEPT) {
            break;
        }
        if pass == 0 {
            balance = each;
        }
        let at = |omega: &Vec3, channel: usize| {
            let place = (omega.z.clamp(-1.0, 1.0).acos().to_degrees() / STEP_DEG).min((factors.len() - 1) as f64);
            let below = (place as usize).min(factors.len() - 2);
            let t = place - below as f64;
            (1.0 - t) * factors[below][channel] + t * factors[below + 1][channel]
        };
        rgb.par_iter_mut().enumerate().for_each(|(node, values)| {
            if let Some(values) = values {
                let (omega_in, omega_out) = merl::directions(node);
                for (channel, value) in values.iter_mut().enumerate() {
                    *value *= (at(&omega_in, channel) * at(&omega_out, channel)).sqrt();
                }
            }
        });
    }
    for (&theta, (wanted, found)) in incidences_deg.iter().zip(wanted.iter().zip(&written(rgb))) {
        if let (Some(wanted), Some(found)) = (wanted, found)
            && wanted.measured == 1.0
        {
            balance.leave(theta, wanted, found);
        }
    }
    balance.notice(notices);
}
