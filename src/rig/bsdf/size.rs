use super::Cells;
use crate::cloth::light::HemisphereNodes;
use crate::formats::{ChannelSet, Encoding, Format, resampled_nodes};

/// Bytes of a number with six significant digits, as 0.0312345, and of one with all digits, as 0.031234567890123456,
/// separator included.
const SIX_DIGITS: f64 = 10.0;
const ALL_DIGITS: f64 = 20.0;

impl Cells {
    /// Expected size of a file, bytes, within an eighth, because the lengths of numbers vary. `None` for formats whose
    /// files stay far below the limit for reading.
    pub fn expected_bytes(&self, format: Format, encoding: Encoding, channels: &ChannelSet) -> Option<u64> {
        let Self::Nodes(nodes) = self else { return None };
        let pairs = (self.incident() - 1 + nodes.azimuths()) as f64 * (self.count() - 1 + nodes.azimuths()) as f64;
        // Includes the repeated azimuth that closes the circle.
        let closed = |ring_nodes: usize| (1 + ring_nodes / nodes.azimuths()) * (nodes.azimuths() + 1);
        let closed_pairs = (closed(self.incident() - 1) * closed(self.count() - 1)) as f64;
        let values = channels.count() as f64;
        let bytes = match (format, encoding) {
            (Format::CSV, _) => match channels {
                // One line for each wavelength, which it states.
                ChannelSet::Wavelengths(_) => pairs * values * (angle_bytes(nodes, in_degrees) + 4.0 + SIX_DIGITS),
                _ => pairs * (angle_bytes(nodes, in_degrees) + values * SIX_DIGITS),
            },
            (Format::ASTM, _) => pairs * (angle_bytes(nodes, |rad| rad.to_string()) + values * SIX_DIGITS),
            (Format::SSDD, Encoding::Text) => 2.0 * closed_pairs * values * SIX_DIGITS,
            (Format::SSDD, Encoding::Binary) => 2.0 * closed_pairs * values * 4.0,
            (Format::DDR, _) => (nodes.rings() * resampled_nodes()) as f64 * values * ALL_DIGITS,
            _ => return None,
        };
        Some(bytes as u64)
    }
}

/// Mean bytes of the four angles of a line with commas, as written by `text`.
fn angle_bytes(nodes: &HemisphereNodes, text: impl Fn(f64) -> String) -> f64 {
    let mean = |count: usize, angle: &dyn Fn(usize) -> f64| {
        let bytes: usize = (0..count).map(|k| 1 + text(angle(k)).len()).sum();
        bytes as f64 / count as f64
    };
    let polar_rad = |ring: usize| nodes.angles_rad(nodes.node(ring, 0))[0];
    let azimuth_rad = |azimuth: usize| nodes.angles_rad(nodes.node(1, azimuth))[1];
    let polar = mean(nodes.rings(), &polar_rad) + mean(nodes.rings() + 1, &polar_rad);
    polar + 2.0 * mean(nodes.azimuths(), &azimuth_rad)
}

fn in_degrees(angle_rad: f64) -> String {
    ((angle_rad.to_degrees() * 1e9).round() / 1e9).to_string()
}
