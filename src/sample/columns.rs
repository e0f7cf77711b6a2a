use crate::spectrum::plausibility;
use crate::spectrum::{CsvError, CsvTable};

/// Other names that instruments and scripts give to a column, in the form of [`plain`].
const INCIDENCE: &[&str] = &[
    "theta_i",
    "theta_in",
    "theta_in_deg",
    "theta_inc",
    "thetai",
    "aoi",
    "incidence",
    "incidence_deg",
    "incidence_angle",
    "incident_angle",
    "incident",
    "angle_of_incidence",
    "illumination",
    "illumination_angle",
];
const VIEW: &[&str] = &[
    "theta_v",
    "theta_view",
    "theta_r",
    "theta_r_deg",
    "thetar",
    "theta_o",
    "theta_o_deg",
    "theta_out",
    "theta_out_deg",
    "theta_det",
    "view",
    "view_deg",
    "view_angle",
    "viewing_angle",
    "detector",
    "detector_angle",
    "detection_angle",
    "observation_angle",
    "reflection_angle",
];
const WAVELENGTH: &[&str] = &["wavelength", "wavelengths", "lambda", "lambda_nm", "wl", "wl_nm", "nm"];
const BETA: &[&str] = &[
    "radiance_factor",
    "brightness_factor",
    "reflectance_factor",
    "reflectance",
    "brf",
    "r",
    "value",
];
const BETA_SE: &[&str] = &[
    "se",
    "std",
    "sigma",
    "uncertainty",
    "standard_error",
    "standard_uncertainty",
];
const RGB: [&[&str]; 3] = [
    &["r", "red", "beta_red"],
    &["g", "green", "beta_green"],
    &["b", "blue", "beta_blue"],
];

/// Which column holds what.
pub(super) struct Columns {
    pub(super) theta_i: usize,
    pub(super) theta_v: usize,
    pub(super) values: Values,
    /// Columns known by another name than the documented one: what they were taken for.
    pub(super) renamed: Vec<String>,
}

/// Where β stands; errors are as many as values, or none.
pub(super) enum Values {
    /// Red, green and blue of a line.
    Rgb { beta: Vec<usize>, se: Vec<usize> },
    /// One wavelength a line.
    Long {
        wavelength: usize,
        beta: usize,
        se: Option<usize>,
    },
    /// One column a wavelength: (nm, column), ascending.
    Wide {
        beta: Vec<(f64, usize)>,
        se: Vec<(f64, usize)>,
    },
}

impl Columns {
    /// Columns of β, and of its standard errors, none or as many.
    pub(super) fn places(&self) -> (Vec<usize>, Vec<usize>) {
        let of = |list: &[(f64, usize)]| list.iter().map(|(_, column)| *column).collect();
        match &self.values {
            Values::Rgb { beta, se } => (beta.clone(), se.clone()),
            Values::Long { beta, se, .. } => (vec![*beta], se.iter().copied().collect()),
            Values::Wide { beta, se } => (of(beta), of(se)),
        }
    }

    pub(super) fn has_se(&self) -> bool {
        !self.places().1.is_empty()
    }

    pub(super) fn of(table: &CsvTable) -> Result<Self, Box<CsvError>> {
        let mut find = Finder {
            table,
            renamed: Vec::new(),
            used: Vec::new(),
        };
        let theta_i = find.required("theta_i_deg", INCIDENCE)?;
        let theta_v = find.required("theta_v_deg", VIEW)?;
        let values = if let Some(wavelength) = find.optional("wavelength_nm", WAVELENGTH) {
            Values::Long {
                wavelength,
                beta: find.required("beta", BETA)?,
                se: find.optional("beta_se", BETA_SE),
            }
        } else if let Some(wide) = find.wide()? {
            wide
        } else {
            let names = ["beta_r", "beta_g", "beta_b"];
            let beta = std::iter::zip(names, RGB).map(|(name, others)| find.required(name, others));
            let beta = beta.collect::<Result<Vec<_>, _>>()?;
            let errors = names.map(|name| format!("{name}_se"));
            let se = match errors.iter().any(|name| table.column(name).is_some()) {
                true => errors
                    .iter()
                    .map(|name| find.required(name, &[]))
                    .collect::<Result<Vec<_>, _>>()?,
                false => Vec::new(),
            };
            Values::Rgb { beta, se }
        };
        if let Some(unknown) = (0..table.columns().len()).find(|column| !find.used.contains(column)) {
            let known: Vec<&str> = find.used.iter().map(|&c| table.columns()[c].as_str()).collect();
            return Err(table.header_error(
                &format!("only the columns {}", known.join(",")),
                &format!("'{}'", table.columns()[unknown]),
                Some("remove or rename it"),
            ));
        }
        Ok(Self {
            theta_i,
            theta_v,
            values,
            renamed: find.renamed,
        })
    }
}

struct Finder<'t> {
    table: &'t CsvTable,
    renamed: Vec<String>,
    used: Vec<usize>,
}

impl Finder<'_> {
    /// The column of this name, else the one column that has one of the others.
    fn optional(&mut self, name: &str, others: &[&str]) -> Option<usize> {
        let columns = self.table.columns();
        let found = self.table.column(name).or_else(|| {
            let mut alike = (0..columns.len()).filter(|&column| {
                let plain = plain(&columns[column]);
                plain == name || others.contains(&plain.as_str())
            });
            alike.next().filter(|_| alike.next().is_none())
        })?;
        if columns[found] != name {
            self.renamed.push(format!("'{}' as {name}", columns[found]));
        }
        self.used.push(found);
        Some(found)
    }

    fn required(&mut self, name: &str, others: &[&str]) -> Result<usize, Box<CsvError>> {
        self.optional(name, others).ok_or_else(|| {
            let remedy = "columns are theta_i_deg,theta_v_deg,wavelength_nm,beta[,beta_se] for spectral data, \
                          theta_i_deg,theta_v_deg and one column a wavelength (390,400,...), or \
                          theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b[,beta_r_se,beta_g_se,beta_b_se] for RGB";
            let found = self.table.columns().join(",");
            self.table
                .header_error(&format!("a column {name}"), &found, Some(remedy))
        })
    }

    /// Two or more columns named by wavelengths. One named by a number that is no wavelength in nm is refused with its unit.
    fn wide(&mut self) -> Result<Option<Values>, Box<CsvError>> {
        let (mut beta, mut se) = (Vec::new(), Vec::new());
        for (column, name) in self.table.columns().iter().enumerate() {
            let (stem, list) = match name.to_ascii_lowercase().strip_suffix("_se") {
                Some(stem) => (stem.to_owned(), &mut se),
                None => (name.clone(), &mut beta),
            };
            list.extend(wavelength_of(&stem).map(|nm| (nm, column)));
        }
        if beta.len() < 2 {
            return Ok(None);
        }
        for list in [&mut beta, &mut se] {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let header = |expected: &str, found: String, remedy: Option<&str>| {
            Err(self.table.header_error(expected, &found, remedy))
        };
        if let Some(twice) = beta.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return header("every wavelength once", format!("{} nm twice", twice[0].0), None);
        }
        if let Some((nm, _)) = beta.iter().find(|(nm, _)| !(100.0..=3000.0).contains(nm)) {
            let remedy =
                plausibility::wavelength_unit(*nm).or(Some("name the columns by wavelengths in nm, such as 450"));
            return header("columns named by wavelengths in nm", nm.to_string(), remedy);
        }
        if !se.is_empty() && !se.iter().map(|(nm, _)| nm).eq(beta.iter().map(|(nm, _)| nm)) {
            let found = format!("{} such columns for {} wavelengths", se.len(), beta.len());
            return header("a column with _se for every wavelength, or none", found, None);
        }
        self.used.extend(beta.iter().chain(&se).map(|(_, column)| column));
        Ok(Some(Values::Wide { beta, se }))
    }
}

/// A column's name in lower case, without its unit in brackets, words joined by `_`. A name in radians keeps its unit, so that it is no
/// column of degrees.
fn plain(name: &str) -> String {
    let lower = name.to_lowercase();
    let bare = match lower.find(['(', '[']) {
        Some(at) if !lower[at..].contains("rad") => &lower[..at],
        _ => lower.as_str(),
    };
    let words = bare
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

/// The number of a column named by its wavelength: `390`, `R390`, `X390` (as R writes it), `390 nm`, `beta_390`.
fn wavelength_of(name: &str) -> Option<f64> {
    let lower = name.trim().to_lowercase();
    let bare = lower.trim_end_matches("nm").trim_end_matches([' ', '_']);
    let digits = ["beta_", "beta", "wl_", "wl", "nm_", "r_", "r", "x"]
        .iter()
        .find_map(|prefix| bare.strip_prefix(prefix))
        .unwrap_or(bare);
    let number = digits.trim_matches([' ', '_']);
    // "inf" and "nan" are no wavelengths.
    if !number.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    number.parse().ok().filter(|nm| *nm > 0.0)
}
