use std::f64::consts::TAU;

use super::direction::{angles_of, direction};
use super::kinds::Placement;
use crate::geometry::Vec3;

/// Patches of the hemisphere in rings about the normal, counted outwards and, within a ring, from azimuth 0 on, on
/// which the first patch of each ring is centred (Klems 1994).
#[derive(Clone, Debug, PartialEq)]
pub struct KlemsBasis {
    pub name: String,
    /// Polar limits in degrees, one more than rings, from 0 to 90.
    limits_deg: Vec<f64>,
    patches: Vec<usize>,
}

impl KlemsBasis {
    /// `None` unless limits ascend from 0 to 90 degrees and each ring has a patch, the first one only one.
    pub fn new(name: &str, limits_deg: Vec<f64>, patches: Vec<usize>) -> Option<Self> {
        let ascending = limits_deg.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = limits_deg.first() == Some(&0.0) && limits_deg.last() == Some(&90.0);
        let fits = limits_deg.len() == patches.len() + 1 && patches.first() == Some(&1);
        (ascending && ends && fits && patches.iter().all(|&n| (1..=10_000).contains(&n))).then(|| Self {
            name: name.into(),
            limits_deg,
            patches,
        })
    }

    /// `LBNL/Klems Full`, `Half` or `Quarter`.
    pub fn named(name: &str) -> Option<Self> {
        let (limits, patches): (&[f64], &[usize]) = match name {
            "LBNL/Klems Full" => (
                &[0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 90.0],
                &[1, 8, 16, 20, 24, 24, 24, 16, 12],
            ),
            "LBNL/Klems Half" => (
                &[0.0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.0],
                &[1, 8, 12, 16, 20, 12, 8],
            ),
            "LBNL/Klems Quarter" => (&[0.0, 9.0, 27.0, 45.0, 63.0, 90.0], &[1, 8, 12, 12, 8]),
            _ => return None,
        };
        Self::new(name, limits.to_vec(), patches.to_vec())
    }

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.patches.iter().sum()
    }

    /// Polar limits in degrees and number of patches of each ring.
    pub fn rings(&self) -> impl Iterator<Item = ([f64; 2], usize)> {
        let limits = self.limits_deg.windows(2).map(|pair| [pair[0], pair[1]]);
        limits.zip(self.patches.iter().copied())
    }

    /// The patch of an upward direction.
    pub fn patch(&self, d: &Vec3) -> usize {
        let (theta, phi) = angles_of(d);
        let inner = &self.limits_deg[1..self.limits_deg.len() - 1];
        let ring = inner.partition_point(|limit| *limit < theta.to_degrees());
        let sectors = self.patches[ring];
        let sector = (phi / TAU * sectors as f64 + 0.5) as usize % sectors;
        self.patches[..ring].iter().sum::<usize>() + sector
    }

    /// A direction inside a patch, from fractions 0..1 of its projected solid angle (outwards) and of its azimuth
    /// range.
    pub fn direction(&self, patch: usize, outwards: f64, around: f64) -> Vec3 {
        let (ring, sector) = self.ring_of(patch);
        let sin2 = |limit: f64| limit.to_radians().sin().powi(2);
        let (low, high) = (sin2(self.limits_deg[ring]), sin2(self.limits_deg[ring + 1]));
        let theta = (low + outwards * (high - low)).sqrt().min(1.0).asin();
        let phi = (sector as f64 + around - 0.5) / self.patches[ring] as f64 * TAU;
        direction(if patch == 0 && outwards == 0.0 { 0.0 } else { theta }, phi)
    }

    /// ∫ cos θ dω over a patch, sr.
    pub fn projected_solid_angle(&self, patch: usize) -> f64 {
        let (ring, _) = self.ring_of(patch);
        let sin2 = |limit: f64| limit.to_radians().sin().powi(2);
        TAU / 2.0 * (sin2(self.limits_deg[ring + 1]) - sin2(self.limits_deg[ring])) / self.patches[ring] as f64
    }

    fn ring_of(&self, patch: usize) -> (usize, usize) {
        let mut sector = patch;
        for (ring, &count) in self.patches.iter().enumerate() {
            if sector < count {
                return (ring, sector);
            }
            sector -= count;
        }
        (self.patches.len() - 1, 0)
    }
}

/// Values constant on pairs of patches. The patch of an incident direction is that of its opposite in azimuth, so that
/// the diagonal is the mirror direction, of transmission the straight one.
#[derive(Clone, Debug, PartialEq)]
pub struct KlemsMatrix {
    incident: KlemsBasis,
    exiting: KlemsBasis,
    /// Channel slowest, then exiting patch, then incident patch.
    values: Vec<f64>,
}

impl KlemsMatrix {
    /// The reader has checked that the lengths match.
    pub(crate) fn new(incident: KlemsBasis, exiting: KlemsBasis, values: Vec<f64>) -> Self {
        debug_assert_eq!(values.len() % (incident.count() * exiting.count()), 0);
        Self {
            incident,
            exiting,
            values,
        }
    }

    /// Patches of the incident hemisphere.
    pub fn incident(&self) -> &KlemsBasis {
        &self.incident
    }

    /// Patches of the exiting hemisphere.
    pub fn exiting(&self) -> &KlemsBasis {
        &self.exiting
    }

    /// f of a channel between two patches.
    pub fn at(&self, channel: usize, incident: usize, exiting: usize) -> f64 {
        self.values[(channel * self.exiting.count() + exiting) * self.incident.count() + incident]
    }

    pub(crate) fn add(&mut self, channel: usize, incident: usize, exiting: usize, value: f64) {
        self.values[(channel * self.exiting.count() + exiting) * self.incident.count() + incident] += value;
    }

    /// ∫ f cos θ_out dω_out per channel for light from a direction: exact, because f is constant on patches.
    pub(crate) fn hemispherical(&self, omega_in: &Vec3) -> Vec<f64> {
        let incident = self.incident_patch(omega_in);
        let sum = |channel: usize| {
            let patches = 0..self.exiting.count();
            patches
                .map(|exiting| self.at(channel, incident, exiting) * self.exiting.projected_solid_angle(exiting))
                .sum()
        };
        (0..self.channels()).map(sum).collect()
    }

    fn incident_patch(&self, omega_in: &Vec3) -> usize {
        self.incident.patch(&Vec3::new(-omega_in.x, -omega_in.y, omega_in.z))
    }

    pub(crate) fn channels(&self) -> usize {
        self.values.len() / (self.incident.count() * self.exiting.count())
    }

    /// Centres of the rings of incidence.
    pub(crate) fn incidences_rad(&self) -> Vec<f64> {
        let centre =
            |(index, ([low, high], _)): (usize, ([f64; 2], usize))| if index == 0 { 0.0 } else { (low + high) / 2.0 };
        self.incident
            .rings()
            .enumerate()
            .map(centre)
            .map(f64::to_radians)
            .collect()
    }

    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        let incident = self.incident_patch(omega_in);
        let exiting = self.exiting.patch(omega_out);
        let values = (0..self.channels()).map(|channel| self.at(channel, incident, exiting));
        Some((values.collect(), Placement::InCell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_cover_the_hemisphere() {
        for (name, count) in [("Full", 145), ("Half", 77), ("Quarter", 41)] {
            let basis = KlemsBasis::named(&format!("LBNL/Klems {name}")).unwrap();
            assert_eq!(basis.count(), count);
            let sum: f64 = (0..count).map(|patch| basis.projected_solid_angle(patch)).sum();
            assert!((sum - std::f64::consts::PI).abs() < 1e-12);
            for patch in 0..count {
                for (outwards, around) in [(0.5, 0.5), (0.01, 0.02), (0.99, 0.97)] {
                    assert_eq!(
                        basis.patch(&basis.direction(patch, outwards, around)),
                        patch,
                        "{name} {patch}"
                    );
                }
            }
        }
    }
}
