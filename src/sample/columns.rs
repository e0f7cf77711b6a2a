use crate::spectrum::plausibility;
use crate::spectrum::{CsvError, CsvTable};
use crate::text::band_nm;
use crate::text::remedy_for_brdf;

/// Which column holds what.
pub(super) struct SampleColumns {
    pub(super) theta_i: usize,
    pub(super) theta_v: usize,
    pub(super) values: ValueColumns,
}

/// Where β stands; errors are as many as values, or none.
pub(super) enum ValueColumns {
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

impl SampleColumns {
    /// Columns of β, and of its standard errors, none or as many.
    pub(super) fn places(&self) -> (Vec<usize>, Vec<usize>) {
        let of = |list: &[(f64, usize)]| list.iter().map(|(_, column)| *column).collect();
        match &self.values {
            ValueColumns::Rgb { beta, se } => (beta.clone(), se.clone()),
            ValueColumns::Long { beta, se, .. } => (vec![*beta], se.iter().copied().collect()),
            ValueColumns::Wide { beta, se } => (of(beta), of(se)),
        }
    }

    pub(super) fn has_se(&self) -> bool {
        !self.places().1.is_empty()
    }

    pub(super) fn of(table: &CsvTable) -> Result<Self, Box<CsvError>> {
        let mut find = Finder {
            table,
            used: Vec::new(),
        };
        let theta_i = find.required("theta_i_deg")?;
        let theta_v = find.required("theta_v_deg")?;
        let values = if let Some(wavelength) = find.optional("wavelength_nm") {
            ValueColumns::Long {
                wavelength,
                beta: find.required("beta")?,
                se: find.optional("beta_se"),
            }
        } else if let Some(wide) = find.wide()? {
            wide
        } else {
            let names = ["beta_r", "beta_g", "beta_b"];
            let beta = names
                .map(|name| find.required(name))
                .into_iter()
                .collect::<Result<Vec<_>, _>>()?;
            let errors = names.map(|name| format!("{name}_se"));
            let se = match errors.iter().any(|name| table.column(name).is_some()) {
                true => errors
                    .iter()
                    .map(|name| find.required(name))
                    .collect::<Result<Vec<_>, _>>()?,
                false => Vec::new(),
            };
            ValueColumns::Rgb { beta, se }
        };
        if let Some(unknown) = (0..table.columns().len()).find(|column| !find.used.contains(column)) {
            let known: Vec<&str> = find.used.iter().map(|&c| table.columns()[c].as_str()).collect();
            return Err(table.header_error(
                &format!("only the columns {}", known.join(",")),
                &format!("'{}'", table.columns()[unknown]),
                "remove or rename it",
            ));
        }
        Ok(Self {
            theta_i,
            theta_v,
            values,
        })
    }
}

struct Finder<'t> {
    table: &'t CsvTable,
    used: Vec<usize>,
}

impl Finder<'_> {
    fn optional(&mut self, name: &str) -> Option<usize> {
        let found = self.table.column(name)?;
        self.used.push(found);
        Some(found)
    }

    fn required(&mut self, name: &str) -> Result<usize, Box<CsvError>> {
        self.optional(name).ok_or_else(|| {
            let remedy = "columns are theta_i_deg,theta_v_deg,wavelength_nm,beta[,beta_se] for spectral data, \
                          theta_i_deg,theta_v_deg and one column a wavelength (390,400,...), or \
                          theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b[,beta_r_se,beta_g_se,beta_b_se] for RGB";
            let found = self.table.columns().join(",");
            self.table.header_error(
                &format!("a column {name}"),
                &found,
                remedy_for_brdf(&found).unwrap_or(remedy),
            )
        })
    }

    /// Two or more columns named by wavelengths. One named by a number that is no wavelength in nm is refused with its
    /// unit.
    fn wide(&mut self) -> Result<Option<ValueColumns>, Box<CsvError>> {
        let (mut beta, mut se) = (Vec::new(), Vec::new());
        for (column, name) in self.table.columns().iter().enumerate() {
            let (stem, list) = match name.to_ascii_lowercase().strip_suffix("_se") {
                Some(stem) => (stem.to_owned(), &mut se),
                None => (name.clone(), &mut beta),
            };
            list.extend(band_nm(&stem).map(|nm| (nm, column)));
        }
        if beta.len() < 2 {
            return Ok(None);
        }
        for list in [&mut beta, &mut se] {
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let header =
            |expected: &str, found: String, remedy: &str| Err(self.table.header_error(expected, &found, remedy));
        if let Some(twice) = beta.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return header(
                "every wavelength once",
                format!("{} nm twice", twice[0].0),
                "keep one of the two columns, or their mean",
            );
        }
        if let Some((nm, _)) = beta.iter().find(|(nm, _)| !(100.0..=3000.0).contains(nm)) {
            let remedy =
                plausibility::wavelength_unit(*nm).unwrap_or("name the columns by wavelengths in nm, such as 450");
            return header("columns named by wavelengths in nm", nm.to_string(), remedy);
        }
        if !se.is_empty() && !se.iter().map(|(nm, _)| nm).eq(beta.iter().map(|(nm, _)| nm)) {
            let found = format!("{} such columns for {} wavelengths", se.len(), beta.len());
            return header(
                "a column with _se for every wavelength, or none",
                found,
                "add those that are missing, or remove the others",
            );
        }
        self.used.extend(beta.iter().chain(&se).map(|(_, column)| column));
        Ok(Some(ValueColumns::Wide { beta, se }))
    }
}
