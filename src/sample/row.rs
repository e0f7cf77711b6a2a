use crate::spectrum::plausibility::{in_lobe_of_plane, per_cent_for_fractions, radians_for_degrees};
use crate::spectrum::{Doubt, WavelengthGrid};

/// What the values of a row stand for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ReadingAxis {
    Rgb,
    Xyz,
    /// One channel, luminous.
    Luminance,
    Wavelengths(WavelengthGrid),
}

/// β and its standard error, one value a channel or wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SampleRow {
    pub(super) theta_i_deg: f64,
    pub(super) theta_v_deg: f64,
    pub(super) beta: Vec<f64>,
    pub(super) se: Vec<f64>,
}

/// Per cent in place of fractions, and radians in place of degrees.
pub(super) fn unit_doubts(rows: &[SampleRow]) -> impl Iterator<Item = Doubt> {
    let readings = rows.iter().flat_map(|row| {
        let in_lobe = in_lobe_of_plane(row.theta_i_deg, row.theta_v_deg);
        row.beta.iter().map(move |beta| (*beta, in_lobe))
    });
    let angles = rows.iter().flat_map(|row| [row.theta_i_deg, row.theta_v_deg]);
    let per_cent = per_cent_for_fractions("beta", readings);
    per_cent.into_iter().chain(radians_for_degrees(angles, []))
}
