use std::f64::consts::TAU;

use super::super::merl::{self, nodes};
use super::super::{Component, Format};
use super::WriteError;
use super::sampling::{ChannelMap, Sampler, clipped};
use crate::geometry::Vec3;

/// Incident azimuths an anisotropic source is averaged over.
const TURNS: usize = 8;

/// Linear RGB at each node; of an anisotropic source the mean over turns of the sample about its normal.
pub(super) fn write(component: &Component, notices: &mut Vec<String>) -> Result<Vec<u8>, WriteError> {
    let mut sampler = Sampler::new(component, Format::Merl)?;
    let map = ChannelMap::to_rgb(&component.channels, notices)?;
    let turns = if component.is_isotropic() { 1 } else { TURNS };
    if turns > 1 {
        notices.push(format!(
            "merl holds isotropic data: values are the mean over {TURNS} turns about the normal"
        ));
    }
    let mut negative = Vec::new();
    let mut rgb = Vec::new();
    for pair in nodes() {
        // No data below the horizon.
        let Some((omega_in, omega_out)) = pair.filter(|(i, o)| i.z > 0.0 && o.z > 0.0) else {
            rgb.push(None);
            continue;
        };
        let mut mean = [0.0; 3];
        for turn in 0..turns {
            let (sin, cos) = (turn as f64 / turns as f64 * TAU).sin_cos();
            let turned = |d: &Vec3| Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z);
            let f = map.apply(&sampler.bsdf(&turned(&omega_in), &turned(&omega_out))?);
            mean.iter_mut().zip(f).for_each(|(sum, f)| *sum += f / turns as f64);
        }
        clipped(&mut mean, &mut negative);
        rgb.push(Some(mean));
    }
    if !negative.is_empty() {
        notices.push("components of colours outside the RGB space are written as 0".into());
    }
    sampler.notice(notices);
    Ok(merl::bytes(&rgb))
}
