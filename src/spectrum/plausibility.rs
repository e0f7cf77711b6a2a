//! Whether numbers have the unit that their column asks for. Each rule names the likely unit and the remedy; none of
//! them changes a value. Shared by samples, spectra and media.

use crate::number::nan_from_null;
use crate::text::TextNotice;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::ops::{Bound, RangeBounds};

/// Fluorescent cloths reach 1.5; a cloth's brightness factor is above this near the mirror direction or towards the
/// light alone, and one in per cent at nearly every wavelength where the cloth is not black.
const FRACTION: f64 = 2.0;
/// Share of the readings above that, away from lobes, that is more than outliers.
const SHARE: f64 = 0.05;
/// Half-widths of the lobes about the mirror (or straight) direction and about the light, degrees.
const MIRROR_LOBE_DEG: f64 = 30.0;
const RETRO_LOBE_DEG: f64 = 10.0;
/// A reflectance of a whole spectrum is above this where the material fluoresces or mirrors, or where it is in per
/// cent.
const FRACTION_HIGHEST: f64 = 1.5;
/// Share of the highest value that dark subtraction may leave readings below 0.
pub const NOISE: f64 = 0.05;
/// A right angle in radians, and a little for rounding.
const QUARTER_TURN_RAD: f64 = 1.6;
const TURN_RAD: f64 = 6.3;

/// What is doubtful about numbers. [`Display`] gives the words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case")]
pub enum Doubt {
    /// Fractions of which this share is above 2, up to `highest`, look like per cent. `what` names the values, such as
    /// "beta".
    PerCent { what: String, share: f64, highest: f64 },
    /// The highest value of a spectrum of reflectances.
    High {
        what: String,
        #[serde(deserialize_with = "nan_from_null")]
        highest: f64,
    },
    /// So many readings are below 0, within noise.
    BelowZero { what: String, count: usize, lowest: f64 },
    /// A particle smaller than a molecule.
    ParticleDiameter { diameter_nm: f64 },
    /// No angle in degrees is beyond this one, which looks like radians.
    Radians { largest: f64 },
    /// So many lines of a file repeat a reading with the same value.
    Repeated { lines: usize },
}

impl Display for Doubt {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::PerCent { what, share, highest } => write!(
                f,
                "{what} is above {FRACTION} in {} % of the values away from mirror and light, up to {}, where 1 is a \
                 perfect diffuser: these look like per cent; divide them by 100",
                (100.0 * share).round(),
                rounded(*highest)
            ),
            Self::High { what, highest } => write!(
                f,
                "{what}: the highest value is {}, where 1 is a perfect diffuser; if these are per cent, divide them by \
                 100",
                rounded(*highest)
            ),
            Self::BelowZero { what, count, lowest } => write!(
                f,
                "{what}: {count} values are below 0, down to {}, as dark subtraction leaves them; they are kept",
                rounded(*lowest)
            ),
            Self::ParticleDiameter { diameter_nm } => write!(
                f,
                "a particle of {diameter_nm} nm is smaller than a molecule and scatters next to nothing; if that is in \
                 micrometres, write {}",
                rounded(1000.0 * diameter_nm)
            ),
            Self::Radians { largest } => write!(
                f,
                "no angle is beyond {}: these look like radians read as degrees; multiply them by 180/pi = 57.29578",
                rounded(*largest)
            ),
            Self::Repeated { lines } => TextNotice::RepeatedLines { lines: *lines }.fmt(f),
        }
    }
}

/// Whether a view may see a lobe: within 30 degrees of the mirror direction, or, for light that went through, of the
/// straight one, or within 10 degrees of the light. Polar angles are from the normal on the viewer's side, azimuths
/// those of light and viewer.
pub fn in_lobe(theta_i_deg: f64, theta_o_deg: f64, phi_deg: f64) -> bool {
    let [i, o, phi] = [theta_i_deg, theta_o_deg, phi_deg].map(f64::to_radians);
    // The cosine of the angle to the light; with the azimuth turned by 180 degrees, to the mirror direction.
    let cos = |towards: f64| i.cos() * o.cos() + towards * i.sin() * o.sin() * phi.cos();
    cos(-1.0) > MIRROR_LOBE_DEG.to_radians().cos() || cos(1.0) > RETRO_LOBE_DEG.to_radians().cos()
}

/// [`in_lobe`] of a signed view in the plane of incidence.
pub fn in_lobe_of_plane(theta_i_deg: f64, theta_v_deg: f64) -> bool {
    in_lobe(theta_i_deg, theta_v_deg, 180.0)
}

/// What fractions (β, reflectances, transmittances; 1 is all) look like that are in per cent: a twentieth of them or
/// more is above 2. Readings in a lobe of gloss or of retroreflection may be, so they count only where there are no
/// others. `readings` are values, each with whether it is in a lobe; `what` names the values, such as "beta". `None`
/// for plausible fractions.
pub fn per_cent_for_fractions(what: &str, readings: impl IntoIterator<Item = (f64, bool)>) -> Option<Doubt> {
    let (lobes, others): (Vec<_>, Vec<_>) = readings
        .into_iter()
        .filter(|(value, _)| value.is_finite())
        .partition(|(_, in_lobe)| *in_lobe);
    let judged = if others.is_empty() { lobes } else { others };
    let above = judged.iter().filter(|(value, _)| *value > FRACTION).count();
    let share = above as f64 / judged.len().max(1) as f64;
    (share >= SHARE).then(|| Doubt::PerCent {
        what: what.into(),
        share,
        highest: judged.iter().map(|(value, _)| *value).fold(0.0, f64::max),
    })
}

/// What is doubtful about a spectrum of reflectances or brightness factors (1 is a perfect diffuser): values above 1.5,
/// and values a little below 0, as dark subtraction leaves them. `what` names the spectrum.
///
/// # Errors
/// A value further below 0 than a twentieth of the highest: what was expected and what was found.
pub fn reflectances(what: &str, values: &[f64]) -> Result<Vec<Doubt>, String> {
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let mut notices = Vec::new();
    if highest > FRACTION_HIGHEST {
        let what = what.into();
        notices.push(Doubt::High { what, highest });
    }
    let negative = values.iter().filter(|value| **value < 0.0).count();
    match below_zero(what, lowest, highest, negative) {
        Ok(notice) => notices.extend(notice),
        Err([expected, found, remedy]) => return Err(format!("{what}: expected {expected}, found {found}; {remedy}")),
    }
    Ok(notices)
}

/// A notice of readings below 0 by no more than a twentieth of the highest, as dark subtraction leaves them.
///
/// # Errors
/// A lowest reading further below 0: what was expected, what was found, and the remedy.
pub fn below_zero(what: &str, lowest: f64, highest: f64, count: usize) -> Result<Option<Doubt>, [String; 3]> {
    if lowest >= 0.0 {
        return Ok(None);
    }
    if lowest < -NOISE * highest {
        return Err([
            format!(
                "values of 0 or more, but for noise of {:.0} % of the highest",
                100.0 * NOISE
            ),
            format!("{} where the highest is {}", rounded(lowest), rounded(highest)),
            "check the sign and the dark reading".into(),
        ]);
    }
    let what = what.into();
    Ok(Some(Doubt::BelowZero { what, count, lowest }))
}

/// What to do about a value that is outside the bounds of fractions: per cent, or noise below 0.
pub(super) fn remedy_outside(value: f64, bounds: &impl RangeBounds<f64>) -> &'static str {
    let is_bound = |bound: Bound<&f64>, at: f64| matches!(bound, Bound::Included(x) if *x == at);
    if is_bound(bounds.start_bound(), 0.0) && value < 0.0 {
        return "set to 0 what dark subtraction left below it";
    }
    match is_bound(bounds.end_bound(), 1.0) && value > 1.0 {
        true => "values in per cent have to be divided by 100, other curves by their highest value",
        false => "correct the value, or leave its wavelength out",
    }
}

/// What a particle's diameter in nm looks like that is in micrometres: below 1 nm, which no particle that scatters
/// light has.
pub fn particle_diameter(diameter_nm: f64) -> Option<Doubt> {
    (diameter_nm < 1.0).then_some(Doubt::ParticleDiameter { diameter_nm })
}

/// What polar angles and azimuths in degrees look like that are in radians: three or more different polar angles, or
/// two and azimuths beyond them, some beyond a tenth of a radian, no polar angle beyond a right angle in radians and no
/// azimuth beyond a turn. `None` for plausible degrees.
pub fn radians_for_degrees(
    polar_deg: impl IntoIterator<Item = f64>,
    azimuths_deg: impl IntoIterator<Item = f64>,
) -> Option<Doubt> {
    let ascending = |angles: &mut dyn Iterator<Item = f64>| {
        let mut angles: Vec<f64> = angles.map(f64::abs).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    };
    let polar = ascending(&mut polar_deg.into_iter());
    let azimuths = ascending(&mut azimuths_deg.into_iter());
    let (theta, phi) = (*polar.last()?, azimuths.last().copied().unwrap_or(0.0));
    let several = polar.len() >= 3 || polar.len() == 2 && azimuths.len() >= 3;
    let radians = several && (0.1..=QUARTER_TURN_RAD).contains(&theta) && phi <= TURN_RAD;
    radians.then_some(Doubt::Radians {
        largest: theta.max(phi),
    })
}

/// The unit that a number in place of a wavelength in nm seems to have, and what to do. `None` from 100 nm to 3000 nm,
/// and where no unit makes light of it.
pub fn wavelength_unit(found_nm: f64) -> Option<&'static str> {
    match found_nm {
        0.1..3.0 => Some("this looks like micrometres: multiply the wavelengths by 1000"),
        3000.0..30_000.0 => Some("this looks like angstroms: divide the wavelengths by 10"),
        1e-7..3e-6 => Some("this looks like metres: multiply the wavelengths by 1e9"),
        _ => None,
    }
}

/// Readings that stand in a file more than once with the same value; `None` of none.
pub(crate) fn repeated(lines: usize) -> Option<Doubt> {
    (lines > 0).then_some(Doubt::Repeated { lines })
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
    fn per_cent_is_recognised() {
        let at = |in_lobe: bool| move |beta: &f64| (*beta, in_lobe);
        let judged = |values: &[f64], lobe: &[f64]| {
            per_cent_for_fractions("beta", values.iter().map(at(false)).chain(lobe.iter().map(at(true))))
        };
        // A deep red cloth in per cent: most of its wavelengths are dark.
        let red: Vec<f64> = (0..35).map(|band| if band < 23 { 0.9 } else { 45.0 }).collect();
        let told = judged(&red, &[]).unwrap().to_string();
        assert!(
            told.contains("above 2 in 34 % of the values") && told.contains("up to 45"),
            "{told}"
        );
        // Where there is nothing but a lobe, that is judged.
        assert!(judged(&[], &red).is_some());
        // A gloss peak is no per cent, nor is an outlier among many readings.
        assert_eq!(judged(&[0.4; 5], &[90.0; 20]), None);
        assert_eq!(judged(&[&[0.4; 30][..], &[2.5]].concat(), &[]), None);
        assert_eq!(judged(&[f64::NAN], &[]), None);
        assert_eq!(judged(&[], &[]), None);
        // In the plane and beyond it: mirror, light, and elsewhere.
        let plane = [(30.0, 55.0), (30.0, -35.0), (30.0, -5.0), (45.0, 0.0)];
        assert_eq!(plane.map(|(i, v)| in_lobe_of_plane(i, v)), [true, true, false, false]);
        let sphere = [(60.0, 60.0, 180.0), (60.0, 60.0, 0.0), (60.0, 60.0, 90.0)];
        assert_eq!(sphere.map(|(i, o, phi)| in_lobe(i, o, phi)), [true, true, false]);
    }

    #[test]
    fn reflectances_in_per_cent_or_below_zero_are_noticed() {
        assert_eq!(reflectances("red", &[0.0, 0.2, 1.05]), Ok(vec![]));
        let told = reflectances("red", &[0.2, 69.9]).unwrap()[0].to_string();
        assert!(told.contains("69.9") && told.contains("divide them by 100"), "{told}");
        let told = reflectances("red", &[-0.01, -0.002, 0.5]).unwrap()[0].to_string();
        assert!(told.contains("2 values are below 0, down to -0.01"), "{told}");
        assert!(reflectances("red", &[-0.03, 0.5]).is_err());
        assert!(reflectances("red", &[-0.4, -0.3]).is_err());
    }

    #[test]
    fn diameters_in_micrometres_are_noticed() {
        assert!(particle_diameter(0.15).is_some_and(|doubt| doubt.to_string().contains("write 150")));
        assert_eq!((particle_diameter(150.0), particle_diameter(1.0)), (None, None));
    }

    #[test]
    fn radians_are_recognised() {
        let plane = |angles: &[f64]| radians_for_degrees(angles.iter().copied(), []);
        assert!(plane(&[0.0, -1.05, 0.52, 1.2217]).is_some());
        // One incidence and view, near the normal: degrees for all one knows.
        assert_eq!(plane(&[0.0, 0.02, -0.01]), None);
        assert_eq!(plane(&[0.0, 1.0]), None);
        assert_eq!(plane(&[0.0, 5.0, 10.0]), None);
        let sphere =
            |polar: &[f64], azimuths: &[f64]| radians_for_degrees(polar.iter().copied(), azimuths.iter().copied());
        let turns = [0.0, 1.05, 2.09, 4.71];
        assert!(sphere(&[0.0, 0.52, 1.05], &turns).is_some_and(|doubt| doubt.to_string().contains("4.71")));
        assert!(sphere(&[0.0, 0.78], &turns).is_some());
        assert_eq!(sphere(&[0.0, 0.52, 1.05], &[0.0, 90.0]), None);
        assert_eq!(sphere(&[0.0, 30.0], &turns), None);
    }

    #[test]
    fn wavelengths_name_their_unit() {
        assert!(wavelength_unit(0.45).is_some_and(|words| words.contains("micrometres")));
        assert!(wavelength_unit(4500.0).is_some_and(|words| words.contains("angstroms")));
        assert!(wavelength_unit(4.5e-7).is_some_and(|words| words.contains("metres")));
        assert_eq!(wavelength_unit(850.0), None);
    }
}
