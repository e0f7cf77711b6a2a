//! Units in titles and below them.

use super::aliases::{
    ANGSTROMS, INCIDENCE, INCIDENT_AZIMUTH, MICROMETRES, RADIANS, VIEW, VIEW_AZIMUTH, WAVELENGTHS, plain,
};

pub(super) const ANGLES: &str = "angles in degrees";
/// What to do about angles in radians.
const NO_RADIANS: &str = "multiply radians by 180/pi = 57.29578, and title the column with deg";

/// A title that states another unit than the column of its name has: the unit expected, and what to do.
pub(super) fn misstated(title: &str) -> Option<(&'static str, &'static str)> {
    let plain = plain(title);
    let angles = [INCIDENCE, VIEW, INCIDENT_AZIMUTH, VIEW_AZIMUTH];
    let is_angle = |base: &str| angles.iter().any(|titles| titles.contains(&base));
    if without(&plain, RADIANS).is_some_and(is_angle) {
        return Some((ANGLES, NO_RADIANS));
    }
    let is_wavelength = |base: &str| WAVELENGTHS.contains(&base);
    if without(&plain, MICROMETRES).is_some_and(is_wavelength) {
        return Some((
            "wavelengths in nm",
            "multiply micrometres by 1000, and title the column wavelength_nm",
        ));
    }
    without(&plain, ANGSTROMS).is_some_and(is_wavelength).then_some((
        "wavelengths in nm",
        "divide angstroms by 10, and title the column wavelength_nm",
    ))
}

/// A title in the form of [`plain`] without one of these units at its end.
pub(super) fn without<'t>(plain: &'t str, units: &[&str]) -> Option<&'t str> {
    let (base, unit) = plain.rsplit_once('_')?;
    units.contains(&unit).then_some(base)
}

/// Whether a cell below the header can be a unit.
pub(super) fn is_unit(cell: &str) -> bool {
    const UNITS: [&str; 26] = [
        "",
        "1",
        "-",
        "\u{2013}",
        "--",
        "/",
        "none",
        "n/a",
        "dimensionless",
        "unitless",
        "a.u.",
        "deg",
        "degree",
        "degrees",
        "\u{b0}",
        "rad",
        "radian",
        "radians",
        "nm",
        "nanometer",
        "nanometre",
        "um",
        "\u{b5}m",
        "\u{3bc}m",
        "%",
        "percent",
    ];
    UNITS.contains(&bare(cell).as_str())
}

/// The unit that a column of this name has, where another one stands below its title.
pub(super) fn contradicts(name: &str, unit: &str) -> Option<(&'static str, &'static str)> {
    let unit = bare(unit);
    let is = |units: &[&str]| units.contains(&unit.as_str());
    if name.ends_with("_deg") && !is(&["", "-", "deg", "degree", "degrees", "\u{b0}"]) {
        return Some(("deg", "multiply radians by 57.29578"));
    }
    if name.ends_with("_nm") && !is(&["", "-", "nm", "nanometer", "nanometre"]) {
        return Some(("nm", "multiply micrometres by 1000"));
    }
    is(&["%", "percent"]).then_some((
        "1, a fraction",
        "divide values in per cent by 100 and write 1 for the unit",
    ))
}

fn bare(cell: &str) -> String {
    let cell = cell.trim().trim_start_matches(['(', '[']).trim_end_matches([')', ']']);
    cell.trim().to_lowercase()
}
