//! Whether numbers have the unit that their column asks for. Each rule names the likely unit and the remedy; none of them
//! changes a value. Shared by samples and by spectra of fractions.

/// A brightness factor or a fraction is seldom above this in the median, and in per cent seldom below.
const FRACTION_MEDIAN: f64 = 2.0;
/// A right angle in radians, and a little for rounding.
const QUARTER_TURN_RAD: f64 = 1.6;

/// What fractions (β, reflectances, transmittances; 1 is all) look like that are in per cent: their median is above 2. `None`
/// for plausible fractions. `what` names the values, such as "beta".
pub fn per_cent_for_fractions(what: &str, values: impl IntoIterator<Item = f64>) -> Option<String> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    (median > FRACTION_MEDIAN).then(|| {
        format!(
            "{what} has the median {}, where 1 is a perfect diffuser: these look like per cent; divide them by 100",
            rounded(median)
        )
    })
}

/// What angles in degrees look like that are in radians: three or more different ones, some beyond a tenth of a radian, and
/// none beyond a right angle in radians. `None` for plausible degrees.
pub fn radians_for_degrees(angles_deg: impl IntoIterator<Item = f64>) -> Option<String> {
    let mut angles: Vec<f64> = angles_deg.into_iter().map(f64::abs).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let largest = *angles.last()?;
    (angles.len() >= 3 && (0.1..=QUARTER_TURN_RAD).contains(&largest)).then(|| {
        format!(
            "no angle is beyond {}: these look like radians read as degrees; multiply them by 180/pi = 57.29578",
            rounded(largest)
        )
    })
}

/// The unit that a number in place of a wavelength in nm seems to have, and what to do. `None` from 100 nm to 3000 nm, and where
/// no unit makes light of it.
pub fn wavelength_unit(found_nm: f64) -> Option<&'static str> {
    match found_nm {
        0.1..3.0 => Some("this looks like micrometres: multiply the wavelengths by 1000"),
        3000.0..30_000.0 => Some("this looks like angstroms: divide the wavelengths by 10"),
        1e-7..3e-6 => Some("this looks like metres: multiply the wavelengths by 1e9"),
        _ => None,
    }
}

/// Three significant digits.
fn rounded(value: f64) -> f64 {
    let text = format!("{value:.2e}");
    text.parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn per_cent_is_told_from_fractions() {
        assert!(per_cent_for_fractions("beta", [40.0, 38.0, 0.5]).is_some_and(|words| words.contains("median 38")));
        // A gloss peak is no per cent.
        assert_eq!(per_cent_for_fractions("beta", [0.4, 0.5, 90.0]), None);
        assert_eq!(per_cent_for_fractions("beta", [f64::NAN]), None);
        assert_eq!(per_cent_for_fractions("beta", []), None);
    }

    #[test]
    fn radians_are_told_from_degrees() {
        assert!(radians_for_degrees([0.0, -1.05, 0.52, 1.22]).is_some());
        // One incidence and view, near the normal: degrees for all one knows.
        assert_eq!(radians_for_degrees([0.0, 0.02, -0.01]), None);
        assert_eq!(radians_for_degrees([0.0, 1.0]), None);
        assert_eq!(radians_for_degrees([0.0, 5.0, 10.0]), None);
    }

    #[test]
    fn wavelengths_name_their_unit() {
        assert!(wavelength_unit(0.45).is_some_and(|words| words.contains("micrometres")));
        assert!(wavelength_unit(4500.0).is_some_and(|words| words.contains("angstroms")));
        assert!(wavelength_unit(4.5e-7).is_some_and(|words| words.contains("metres")));
        assert_eq!(wavelength_unit(850.0), None);
    }
}
