use super::axis::Axis;

/// Specularly reflected or regularly transmitted fractions of the flux by incident polar angle; of anisotropic samples
/// also by azimuth. Linear between nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecularTable {
    incidence: Axis,
    azimuth: Axis,
    channels: usize,
    /// Azimuth slowest, channel fastest.
    values: Vec<f64>,
}

impl SpecularTable {
    pub(crate) fn new(incidence: Axis, azimuth: Axis, channels: usize, values: Vec<f64>) -> Self {
        debug_assert_eq!(
            values.len(),
            incidence.nodes_rad().len() * azimuth.nodes_rad().len() * channels
        );
        Self {
            incidence,
            azimuth,
            channels,
            values,
        }
    }

    /// Axis of the incident polar angle.
    pub fn incidence(&self) -> &Axis {
        &self.incidence
    }

    /// Axis of the incident azimuth.
    pub fn azimuth(&self) -> &Axis {
        &self.azimuth
    }

    /// The same table with azimuths that close the circle ([`Axis::closed`]).
    pub(crate) fn closed(&self) -> Self {
        let Some((azimuth, shares)) = self.azimuth.closed() else {
            return self.clone();
        };
        let mut values = Vec::new();
        for shares in shares {
            for incidence in 0..self.incidence.nodes_rad().len() {
                let parts = shares.map(|(node, share)| (self.at(incidence, node), share));
                let mean =
                    |channel: usize| -> f64 { parts.iter().map(|(values, share)| share * values[channel]).sum() };
                values.extend((0..self.channels).map(mean));
            }
        }
        Self::new(self.incidence.clone(), azimuth, self.channels, values)
    }

    /// Fractions of a node, one a channel.
    pub fn at(&self, incidence: usize, azimuth: usize) -> &[f64] {
        let node = azimuth * self.incidence.nodes_rad().len() + incidence;
        &self.values[node * self.channels..(node + 1) * self.channels]
    }

    /// Fractions at a direction of incidence, at the normal the mean over azimuth; `None` outside what was measured.
    pub fn fraction(&self, theta_i_rad: f64, phi_i_rad: f64) -> Option<Vec<f64>> {
        let theta = self.incidence.locate(theta_i_rad)?;
        let azimuths: Vec<(usize, f64)> = if theta_i_rad.abs() < 1e-5 {
            self.azimuth.shares().into_iter().enumerate().collect()
        } else {
            let phi = self.azimuth.locate(phi_i_rad)?;
            vec![(phi.below, 1.0 - phi.t), (phi.above, phi.t)]
        };
        let mut values = vec![0.0; self.channels];
        for (azimuth, weight_phi) in azimuths {
            for (incidence, weight_theta) in [(theta.below, 1.0 - theta.t), (theta.above, theta.t)] {
                for (sum, value) in values.iter_mut().zip(self.at(incidence, azimuth)) {
                    *sum += weight_phi * weight_theta * value;
                }
            }
        }
        Some(values)
    }
}
