//! Titles of columns, as instruments, spreadsheets and scripts write them.

use super::aliases::{
    BETA, BETA_SE, DEGREES, INCIDENCE, INCIDENT_AZIMUTH, NAMES, NANOMETRES, RGB, VIEW, VIEW_AZIMUTH, WAVELENGTHS, plain,
};
use super::bands::band_nm;
use super::units::{ANGLES, misstated, without};

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

/// The names in this program of the columns of a table, and of which of them the title says something else. Titles of
/// angles and values, which can be anything in a table of spectra, are known where an incidence and a view stand
/// together.
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
