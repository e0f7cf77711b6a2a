use super::readings::Channel;
use super::{FreeParameter, Scale};

/// An absorption spectrum that is fitted: its logarithm is linear in wavelength between nodes and constant beyond them,
/// so it is smooth and never negative.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeDye {
    nodes_nm: Vec<f64>,
    names: Vec<String>,
    bounds_per_mm: [f64; 2],
    /// Standard deviation of the second difference of the logarithm between neighbouring nodes, where the spectrum is
    /// regularised.
    roughness: Option<f64>,
}

/// Nodes for channels blue, green and red: about where each sees most.
const RGB_NODES_NM: [f64; 3] = [450.0, 545.0, 630.0];
/// The one node of a grey sample: where the eye sees most.
const LUMINANCE_NODE_NM: f64 = 555.0;

impl FreeDye {
    /// One node for each channel: of wavelengths those themselves, regularised; of red, green and blue three bands;
    /// of luminance alone one value at all wavelengths.
    pub fn for_channels(channels: &[Channel], bounds_per_mm: [f64; 2], roughness: f64) -> Self {
        let wavelengths: Vec<f64> = (channels.iter())
            .filter_map(|channel| match channel {
                Channel::Wavelength(nm) => Some(*nm),
                _ => None,
            })
            .collect();
        let (nodes_nm, roughness) = match (wavelengths.is_empty(), channels) {
            (true, [Channel::Luminance]) => (vec![LUMINANCE_NODE_NM], None),
            (true, _) => (RGB_NODES_NM.to_vec(), None),
            (false, _) => (wavelengths, Some(roughness)),
        };
        Self {
            names: (nodes_nm.iter()).map(|nm| format!("absorption at {nm} nm")).collect(),
            nodes_nm,
            bounds_per_mm,
            roughness,
        }
    }

    /// A parameter for each node, in 1/mm.
    pub fn parameters(&self) -> Vec<FreeParameter> {
        let parameter = |name: &String| FreeParameter {
            name: name.clone(),
            unit: "1/mm".into(),
            bounds: self.bounds_per_mm,
            scale: Scale::Log,
            prior: None,
        };
        self.names.iter().map(parameter).collect()
    }

    /// The absorption at a wavelength, in 1/mm, from the values at the nodes.
    pub fn at(&self, nm: f64, values_per_mm: &[f64]) -> f64 {
        let above = self.nodes_nm.partition_point(|node| *node <= nm);
        if above == 0 || above == self.nodes_nm.len() {
            return values_per_mm[above.saturating_sub(usize::from(above > 0))];
        }
        let [low, high] = [self.nodes_nm[above - 1], self.nodes_nm[above]];
        let share = (nm - low) / (high - low);
        (values_per_mm[above - 1].ln() * (1.0 - share) + values_per_mm[above].ln() * share).exp()
    }

    /// Residuals that hold the spectrum smooth: second differences of its logarithm in standard deviations.
    pub fn penalties(&self, values_per_mm: &[f64]) -> Vec<f64> {
        let Some(roughness) = self.roughness else {
            return Vec::new();
        };
        let of = |[a, b, c]: [usize; 3]| {
            let [x, y, z] = [self.nodes_nm[a], self.nodes_nm[b], self.nodes_nm[c]];
            let [u, v, w] = [values_per_mm[a].ln(), values_per_mm[b].ln(), values_per_mm[c].ln()];
            // On unequal steps the difference to the straight line through the neighbours, doubled.
            2.0 * (v - (u * (z - y) + w * (y - x)) / (z - x)) / roughness
        };
        (1..self.nodes_nm.len().saturating_sub(1))
            .map(|k| of([k - 1, k, k + 1]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_is_exponential_between_nodes_and_constant_beyond() {
        let dye = FreeDye::for_channels(&[Channel::Red, Channel::Green, Channel::Blue], [1e-3, 1e3], 0.3);
        let values = [1.0, 10.0, 0.1];
        assert_eq!(
            [dye.at(390.0, &values), dye.at(450.0, &values), dye.at(730.0, &values)],
            [1.0, 1.0, 0.1]
        );
        assert!((dye.at(497.5, &values) - 10f64.sqrt()).abs() < 1e-12);
        assert!(dye.penalties(&values).is_empty());
        let spectral: Vec<Channel> = [400.0, 410.0, 420.0].map(Channel::Wavelength).to_vec();
        let dye = FreeDye::for_channels(&spectral, [1e-3, 1e3], 0.5);
        let penalty = dye.penalties(&[1.0, 1f64.exp(), 1.0]);
        assert!((penalty[0] - 4.0).abs() < 1e-12, "{penalty:?}");
    }
}
