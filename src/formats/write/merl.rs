use std::f64::consts::TAU;

use rayon::prelude::*;

use super::super::merl;
use super::super::{Component, Format};
use super::WriteError;
use super::sampling::{ChannelMap, Sampler, clipped};
use crate::geometry::Vec3;

/// Incident azimuths an anisotropic source is averaged over.
const TURNS: usize = 8;

/// Linear RGB at each node; of an anisotropic source the mean over turns of the sample about its normal.
pub(super) fn write(component: &Component, notices: &mut Vec<String>) -> Result<Vec<u8>, WriteError> {
    let sampler = Sampler::new(component, Format::Merl)?;
    let map = ChannelMap::to_rgb(&component.channels, notices)?;
    let turns = if component.is_isotropic() { 1 } else { TURNS };
    if turns > 1 {
        notices.push(format!(
            "merl holds isotropic data: values are the mean over {TURNS} turns about the normal"
        ));
    }
    let mean = |omega_in: &Vec3, omega_out: &Vec3| -> Result<[f64; 3], WriteError> {
        let mut mean = [0.0; 3];
        for turn in 0..turns {
            let (sin, cos) = (turn as f64 / turns as f64 * TAU).sin_cos();
            let turned = |d: &Vec3| Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z);
            let f = map.apply(&sampler.bsdf(&turned(omega_in), &turned(omega_out))?);
            mean.iter_mut().zip(f).for_each(|(sum, f)| *sum += f / turns as f64);
        }
        Ok(mean)
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
