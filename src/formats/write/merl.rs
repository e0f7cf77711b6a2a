use std::f64::consts::TAU;

use rayon::prelude::*;

use super::super::merl;
use super::super::{Channels, Component, Format};
use super::WriteError;
use super::sampling::{ChannelMap, Sampler, clipped};
use crate::geometry::Vec3;

/// Incident azimuths an anisotropic source is averaged over.
const TURNS: usize = 8;

/// Linear RGB at each node; of an anisotropic source the mean over turns of the sample about its normal.
pub(super) fn write(component: &Component, notices: &mut Vec<String>) -> Result<Vec<u8>, WriteError> {
    let map = ChannelMap::to_rgb(&component.channels, notices)?;
    let as_rgb = component.with_channels(Channels::Rgb, |values| map.apply(values));
    let (component, map) = match &as_rgb {
        Some(as_rgb) => (as_rgb, ChannelMap::Same),
        None => (component, map),
    };
    let sampler = Sampler::new(component, Format::Merl)?;
    let turns = if component.is_isotropic() { 1 } else { TURNS };
    if turns > 1 {
        notices.push(format!(
            "merl holds isotropic data: values are the mean over {TURNS} turns about the normal"
        ));
    }
    let turns_rad: Vec<f64> = (0..turns).map(|turn| turn as f64 / turns as f64 * TAU).collect();
    let mean = |omega_in: &Vec3, omega_out: &Vec3| -> Result<[f64; 3], WriteError> {
        // The map is linear: the mean of the source's channels is mapped once.
        let rgb = map.apply(&sampler.mean_over_turns(omega_in, omega_out, &turns_rad)?);
        Ok([rgb[0], rgb[1], rgb[2]])
    };
    let all: Vec<usize> = (0..merl::NODES).collect();
    let rgb = all.par_iter().map(|&node| match merl::directions(node) {
        (omega_in, omega_out) if omega_in.z > 0.0 && omega_out.z > 0.0 => mean(&omega_in, &omega_out).map(Some),
        // No data below the horizon.
        _ => Ok(None),
    });
    let mut rgb = rgb.collect::<Result<Vec<Option<[f64; 3]>>, _>>()?;
    let mut negative = Vec::new();
    rgb.iter_mut()
        .flatten()
        .for_each(|values| clipped(values, &mut negative));
    if !negative.is_empty() {
        notices.push("components of colours outside the RGB space are written as 0".into());
    }
    sampler.notice(notices);
    Ok(merl::bytes(&rgb))
}
