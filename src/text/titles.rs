//! Titles of columns and units under them, as instruments, spreadsheets and scripts write them.

/// Columns of this program's own tables.
const NAMES: [&str; 22] = [
    "theta_i_deg",
    "theta_v_deg",
    "phi_i_deg",
    "theta_o_deg",
    "phi_o_deg",
    "wavelength_nm",
    "beta",
    "beta_se",
    "beta_r",
    "beta_g",
    "beta_b",
    "beta_x",
    "beta_y",
    "beta_z",
    "beta_r_se",
    "beta_g_se",
    "beta_b_se",
    "beta_x_se",
    "beta_y_se",
    "beta_z_se",
    "value",
    "name",
];

/// Other titles of `wavelength_nm`, in the form of [`plain`].
const WAVELENGTHS: [&str; 9] = [
    "wavelength",
    "wavelengths",
    "wavelengths_nm",
    "wl",
    "wl_nm",
    "lambda",
    "lambda_nm",
    "\u{3bb}",
    "\u{3bb}_nm",
];

/// The name in this program of a column titled in other case, with blanks, or with its unit in brackets.
pub(super) fn known(title: &str) -> Option<&'static str> {
    let plain = plain(title);
    if WAVELENGTHS.contains(&plain.as_str()) || plain == "nm" {
        return Some("wavelength_nm");
    }
    NAMES.into_iter().find(|name| *name == plain)
}

/// Whether a line is a header that has a column of this name.
pub(crate) fn is_titled(line: &str, name: &str) -> bool {
    let titles = line.split([',', ';', '\t']);
    line.contains(name) || titles.into_iter().any(|title| known(title) == Some(name))
}

/// Lower case; blanks, brackets and dots are one underscore.
fn plain(title: &str) -> String {
    let mut plain = String::new();
    for c in title.to_lowercase().replace('\u{b0}', "deg").chars() {
        if c.is_alphanumeric() {
            plain.push(c);
        } else if !plain.is_empty() && !plain.ends_with('_') {
            plain.push('_');
        }
    }
    let plain = plain.trim_end_matches('_');
    let degrees = plain.strip_suffix("_degrees").or_else(|| plain.strip_suffix("_degree"));
    degrees.map_or_else(|| plain.to_owned(), |name| format!("{name}_deg"))
}

/// The wavelength in nm that a title such as `390`, `R390`, `390 nm`, `390_NM`, `X390`, `SPEC_390` or `SPECTRAL_NM390` names.
pub(crate) fn band_nm(title: &str) -> Option<f64> {
    const PREFIXES: [&str; 18] = [
        "",
        "r",
        "r_",
        "x",
        "w",
        "wl",
        "wl_",
        "l",
        "lambda",
        "lambda_",
        "nm",
        "nm_",
        "beta_",
        "spec_",
        "spectral_",
        "spectral_nm",
        "spectral_nm_",
        "refl_",
    ];
    /// A letter and a smaller number count columns.
    const LEAST_NM: f64 = 100.0;
    let title = title.trim().to_lowercase();
    let title = title
        .strip_suffix("nm")
        .filter(|rest| !rest.is_empty())
        .unwrap_or(&title);
    let title = title.trim_end_matches(['_', '.', ' ']);
    let (prefix, number) = title.split_at(title.find(|c: char| c.is_ascii_digit())?);
    let plain = number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if !plain || !PREFIXES.contains(&prefix) {
        return None;
    }
    number
        .parse()
        .ok()
        .filter(|&nm| nm >= LEAST_NM || (nm > 0.0 && prefix.is_empty()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_in_other_writing_are_known() {
        for title in [
            "wavelength_nm",
            "Wavelength",
            "Wavelength (nm)",
            "wavelength..nm.",
            " WL ",
            "lambda [nm]",
            "nm",
        ] {
            assert_eq!(known(title), Some("wavelength_nm"), "{title}");
        }
        assert_eq!(known("Theta_i [deg]"), Some("theta_i_deg"));
        assert_eq!(known("theta v (\u{b0})"), Some("theta_v_deg"));
        assert_eq!(known("Beta R SE"), Some("beta_r_se"));
        // Its unit is not known.
        assert_eq!(
            (known("theta_i"), known("wavelength (um)"), known("red")),
            (None, None, None)
        );
    }

    #[test]
    fn titles_name_wavelengths() {
        for title in [
            "390",
            "R390",
            "390_NM",
            "390 nm",
            "390nm",
            "nm390",
            "X390",
            "X390.nm",
            "SPECTRAL_NM_390",
            "SPECTRAL_390",
        ] {
            assert_eq!(band_nm(title), Some(390.0), "{title}");
        }
        assert_eq!(band_nm("403.5"), Some(403.5));
        for title in ["R1", "red", "390-400", "XYZ_X", "nm", "", "D50", "sample 390"] {
            assert_eq!(band_nm(title), None, "{title}");
        }
    }
}
