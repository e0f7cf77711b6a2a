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

/// Other titles of these columns, in the form of [`plain`] without a unit.
const WAVELENGTHS: &[&str] = &[
    "wavelength",
    "wavelengths",
    "wave_length",
    "wl",
    "wvl",
    "lambda",
    "lam",
    "nm",
    "nanometer",
    "nanometers",
    "nanometre",
    "nanometres",
    "wellenlange",
    "wellenlaenge",
    "longueur_d_onde",
    "longitud_de_onda",
    "lunghezza_d_onda",
    "comprimento_de_onda",
    "golflengte",
    "vaglangd",
    "\u{434}\u{43b}\u{438}\u{43d}\u{430}_\u{432}\u{43e}\u{43b}\u{43d}\u{44b}",
    "\u{6ce2}\u{957f}",
    "\u{6ce2}\u{9577}",
];
const INCIDENCE: &[&str] = &[
    "theta_i",
    "theta_in",
    "theta_inc",
    "theta_incident",
    "thetai",
    "thetain",
    "aoi",
    "incidence",
    "incidence_angle",
    "incident_angle",
    "incident",
    "angle_of_incidence",
    "illumination",
    "illumination_angle",
    "einfallswinkel",
    "angle_d_incidence",
    "zenith_i",
    "zenith_in",
];
const VIEW: &[&str] = &[
    "theta_v",
    "theta_view",
    "theta_r",
    "theta_o",
    "theta_s",
    "theta_out",
    "theta_det",
    "theta_ref",
    "thetav",
    "thetar",
    "thetao",
    "thetas",
    "thetaout",
    "view",
    "view_angle",
    "viewing_angle",
    "detector",
    "detector_angle",
    "detection_angle",
    "observation_angle",
    "reflection_angle",
    "ausfallswinkel",
    "beobachtungswinkel",
    "zenith_o",
    "zenith_r",
    "zenith_v",
    "zenith_out",
];
const INCIDENT_AZIMUTH: &[&str] = &[
    "phi_i",
    "phi_in",
    "phi_inc",
    "phii",
    "phiin",
    "azimuth_i",
    "azimuth_in",
    "incident_azimuth",
    "incidence_azimuth",
];
const VIEW_AZIMUTH: &[&str] = &[
    "phi_o",
    "phi_out",
    "phi_r",
    "phi_s",
    "phi_v",
    "phi_view",
    "phio",
    "phiout",
    "phir",
    "phis",
    "phiv",
    "azimuth_o",
    "azimuth_r",
    "azimuth_v",
    "azimuth_out",
    "view_azimuth",
    "viewing_azimuth",
    "detector_azimuth",
    "outgoing_azimuth",
];
const BETA: &[&str] = &[
    "radiance_factor",
    "brightness_factor",
    "luminance_factor",
    "reflectance_factor",
    "reflectance",
    "brf",
    "beta",
    "r",
    "value",
];
const BETA_SE: &[&str] = &[
    "beta_se",
    "se",
    "std",
    "sigma",
    "uncertainty",
    "standard_error",
    "standard_uncertainty",
];
const RGB: [(&str, &[&str]); 3] = [
    ("beta_r", &["r", "red", "beta_red"]),
    ("beta_g", &["g", "green", "beta_green"]),
    ("beta_b", &["b", "blue", "beta_blue"]),
];

/// Units that end a title in the form of [`plain`].
const DEGREES: &[&str] = &["deg", "degree", "degrees"];
const RADIANS: &[&str] = &["rad", "radian", "radians"];
const NANOMETRES: &[&str] = &[
    "nm",
    "nanometer",
    "nanometers",
    "nanometre",
    "nanometres",
    "\u{43d}\u{43c}",
];
const MICROMETRES: &[&str] = &[
    "um",
    "micron",
    "microns",
    "micrometer",
    "micrometers",
    "micrometre",
    "micrometres",
];
const ANGSTROMS: &[&str] = &["a", "angstrom", "angstroms"];

const ANGLES: &str = "angles in degrees";
/// What to do about angles in radians.
const NO_RADIANS: &str = "multiply radians by 180/pi = 57.29578, and title the column with deg";

/// The name in this program of a column titled in other case, with blanks, or with its unit in brackets.
pub(super) fn known(title: &str) -> Option<&'static str> {
    let plain = plain(title);
    let base = without(&plain, NANOMETRES).unwrap_or(&plain);
    let base = base.strip_suffix("_in").unwrap_or(base);
    if WAVELENGTHS.contains(&base) {
        return Some("wavelength_nm");
    }
    let degrees = without(&plain, DEGREES).map(|name| format!("{name}_deg"));
    let plain = degrees.unwrap_or(plain);
    NAMES.into_iter().find(|name| *name == plain)
}

/// The names in this program of the columns of a table, and of which of them the title says something else. Titles of angles and
/// values, which can be anything in a table of spectra, are known where an incidence and a view stand together.
pub(super) fn names(titles: &[String]) -> (Vec<Option<&'static str>>, Vec<String>) {
    let own: Vec<Option<&'static str>> = titles.iter().map(|title| known(title)).collect();
    let mut found = Names {
        plain: titles.iter().map(|title| plain(title)).collect(),
        names: own.clone(),
    };
    found.angle("phi_o_deg", VIEW_AZIMUTH, None);
    let [view, other] = match found.has("phi_o_deg") {
        true => ["theta_o_deg", "theta_v_deg"],
        false => ["theta_v_deg", "theta_o_deg"],
    };
    found.angle("theta_i_deg", INCIDENCE, None);
    found.angle(view, VIEW, Some(other));
    if !found.has("theta_i_deg") || !found.has(view) {
        return (own, Vec::new());
    }
    found.angle("phi_i_deg", INCIDENT_AZIMUTH, None);
    let bands = titles.iter().filter(|title| band_nm(title).is_some()).count();
    if found.has("wavelength_nm") || bands < 2 {
        found.values();
    }
    let mut renamed = Vec::new();
    for (title, (name, own)) in titles.iter().zip(found.names.iter().zip(&own)) {
        if let Some(name) = name.filter(|_| name != own) {
            renamed.push(format!("'{title}' as {name}"));
        }
    }
    (found.names, renamed)
}

/// Titles in the form of [`plain`] and what they were found to name.
struct Names {
    plain: Vec<String>,
    names: Vec<Option<&'static str>>,
}

impl Names {
    fn has(&self, name: &str) -> bool {
        self.names.contains(&Some(name))
    }

    /// Gives the name to the only column, if there is but one, whose title is meant by it.
    fn take(&mut self, name: &'static str, is_meant: impl Fn(usize, &str) -> bool) {
        if self.has(name) {
            return;
        }
        let mut alike = (0..self.plain.len()).filter(|&column| is_meant(column, &self.plain[column]));
        if let (Some(column), None) = (alike.next(), alike.next()) {
            self.names[column] = Some(name);
        }
    }

    /// A column of degrees; `instead` is a name that stands for it in tables of the other layout.
    fn angle(&mut self, name: &'static str, titles: &[&str], instead: Option<&str>) {
        let names = self.names.clone();
        self.take(name, |column, plain| match names[column] {
            Some(other) => Some(other) == instead,
            None => titles.contains(&without(plain, DEGREES).unwrap_or(plain)),
        });
    }

    /// Red, green and blue, or one value, each perhaps with its standard error.
    fn values(&mut self) {
        let names = self.names.clone();
        let is_one_of = |titles: &'static [&str]| {
            move |free: bool, plain: &str| free && titles.contains(&plain.strip_suffix("_1").unwrap_or(plain))
        };
        let free = |column: usize| names[column].is_none_or(|name| name == "value");
        let is_rgb = !self.has("wavelength_nm")
            && RGB.iter().all(|(name, titles)| {
                let mut columns = self.plain.iter().enumerate();
                self.has(name) || columns.any(|(column, plain)| is_one_of(titles)(free(column), plain))
            });
        let values: Vec<(&'static str, &'static str)> = if is_rgb {
            for (name, titles) in RGB {
                self.take(name, |column, plain| is_one_of(titles)(free(column), plain));
            }
            vec![
                ("beta_r", "beta_r_se"),
                ("beta_g", "beta_g_se"),
                ("beta_b", "beta_b_se"),
            ]
        } else {
            self.take("beta", |column, plain| is_one_of(BETA)(free(column), plain));
            self.take("beta_se", |column, plain| {
                is_one_of(BETA_SE)(names[column].is_none(), plain)
            });
            vec![("beta", "beta_se")]
        };
        for (name, error) in values {
            let Some(column) = self.names.iter().position(|known| *known == Some(name)) else {
                continue;
            };
            let title = self.plain[column].clone();
            self.take(error, |column, plain| {
                names[column].is_none()
                    && (["se", "std", "sigma", "uncertainty", "error"]
                        .iter()
                        .any(|e| plain == format!("{title}_{e}"))
                        || ["u", "sigma", "std"].iter().any(|e| plain == format!("{e}_{title}")))
            });
        }
    }
}

/// The cells of a line of titles, whatever separates them.
fn cells(line: &str) -> Vec<String> {
    let bare = |cell: &str| cell.trim().trim_matches('"').trim().to_owned();
    match line.contains([',', ';', '\t', '|']) {
        true => line.split([',', ';', '\t', '|']).map(bare).collect(),
        false => line.split_whitespace().map(bare).collect(),
    }
}

/// What the titles in a line tell of the table below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Heading {
    /// Readings in the plane of incidence.
    Plane,
    /// Readings over the sphere.
    Sphere,
    /// Spectra, a row a wavelength or a column a wavelength.
    Spectra,
}

/// What a line is the header of; `None` of other lines.
pub(crate) fn heading(line: &str) -> Option<Heading> {
    // Most lines are numbers; spreadsheets put comments in quotes.
    if line.trim_start_matches(['"', ' ', '\t']).starts_with(['#', '<']) || !line.contains(char::is_alphabetic) {
        return None;
    }
    let cells = cells(line);
    let (names, _) = names(&cells);
    let has = |name| names.contains(&Some(name));
    // Of columns in radians the reader says what to do.
    let misstated = cells
        .iter()
        .find_map(|cell| misstated(cell))
        .filter(|_| cells.len() > 1);
    if has("theta_i_deg") || misstated.is_some_and(|(unit, _)| unit == ANGLES) {
        return Some(if has("phi_o_deg") {
            Heading::Sphere
        } else {
            Heading::Plane
        });
    }
    let bands: Vec<f64> = cells.iter().filter_map(|cell| band_nm(cell)).collect();
    let is_wide = bands.len() >= 3
        && bands.len() < cells.len()
        && (bands.is_sorted_by(|a, b| a < b) || bands.is_sorted_by(|a, b| a > b));
    // `wl 400` is a line of another format.
    let is_titled = has("wavelength_nm") && cells.len() > 1 && cells.iter().all(|cell| cell.parse::<f64>().is_err());
    (is_titled || is_wide || misstated.is_some()).then_some(Heading::Spectra)
}

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
fn without<'t>(plain: &'t str, units: &[&str]) -> Option<&'t str> {
    let (base, unit) = plain.rsplit_once('_')?;
    units.contains(&unit).then_some(base)
}

/// Lower case without accents, Greek letters by name; blanks, brackets and dots are one underscore, words in one are split where
/// a capital follows a small letter.
fn plain(title: &str) -> String {
    let mut plain = String::new();
    let mut was_small = false;
    for c in title.replace('\u{b0}', "deg").chars() {
        let splits = c.is_uppercase() && was_small && plain.chars().filter(|c| *c != '_').count() > 3;
        was_small = c.is_lowercase();
        if splits {
            plain.push('_');
        }
        for c in c.to_lowercase() {
            match c {
                // Marks of letters that are written as two characters.
                '\u{300}'..='\u{36f}' => {}
                '\u{e0}'..='\u{e5}' => plain.push('a'),
                '\u{e7}' => plain.push('c'),
                '\u{e8}'..='\u{eb}' => plain.push('e'),
                '\u{f2}'..='\u{f6}' => plain.push('o'),
                '\u{f9}'..='\u{fc}' => plain.push('u'),
                '\u{b5}' | '\u{3bc}' => plain.push('u'),
                '\u{3b2}' => plain += "beta",
                '\u{3b8}' | '\u{3d1}' => plain += "theta",
                '\u{3bb}' => plain += "lambda",
                '\u{3c1}' => plain += "rho",
                '\u{3c6}' | '\u{3d5}' => plain += "phi",
                c if c.is_alphanumeric() => plain.push(c),
                _ if !plain.is_empty() && !plain.ends_with('_') => plain.push('_'),
                _ => {}
            }
        }
    }
    plain.truncate(plain.trim_end_matches('_').len());
    plain
}

/// The wavelength in nm that a title such as `390`, `R390`, `390 nm`, `390_NM`, `X390`, `SPEC_390`, `SPECTRAL_NM390` or
/// `Reflectance (390 nm)` names.
pub(crate) fn band_nm(title: &str) -> Option<f64> {
    const PREFIXES: [&str; 19] = [
        "",
        "r",
        "x",
        "w",
        "wl",
        "l",
        "lambda",
        "rlambda",
        "nm",
        "wavelength",
        "beta",
        "rho",
        "spec",
        "spectral",
        "spectralnm",
        "refl",
        "reflectance",
        "radiancefactor",
        "brf",
    ];
    /// A letter and a smaller number count columns.
    const LEAST_NM: f64 = 100.0;
    let lower = title
        .to_lowercase()
        .replace('\u{3bb}', "lambda")
        .replace('\u{3b2}', "beta");
    let is_between = |c: char| c.is_whitespace() || matches!(c, '_' | '(' | ')' | '[' | ']');
    let bare: String = lower.chars().filter(|&c| !is_between(c)).collect();
    let bare = bare.strip_suffix("nm").filter(|rest| !rest.is_empty()).unwrap_or(&bare);
    let bare = bare.trim_end_matches('.');
    let (prefix, number) = bare.split_at(bare.find(|c: char| c.is_ascii_digit())?);
    let digits = number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if !digits || !PREFIXES.contains(&prefix) {
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
