use std::collections::HashMap;

use serde::Serialize;

use super::SampleError;
use super::goniometric::GoniometricData;
use crate::spectrum::{CsvError, CsvTable, WavelengthGrid};

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Data {
    Curves(Curves),
    Goniometric(Box<GoniometricData>),
    Ratios(PublishedRatios),
}

/// Readings over incidence and view, all of them on the same channels or wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curves {
    axis: Axis,
    has_se: bool,
    /// Ascending by incidence, then by view; a geometry occurs once.
    rows: Vec<Row>,
}

/// What the values of a row stand for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Axis {
    Rgb,
    Xyz,
    Wavelengths(WavelengthGrid),
}

/// β and its standard error, one value a channel or wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) theta_i_deg: f64,
    pub(super) theta_v_deg: f64,
    pub(super) beta: Vec<f64>,
    pub(super) se: Vec<f64>,
}

impl Curves {
    pub(super) fn axis(&self) -> &Axis {
        &self.axis
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    pub(super) fn has_se(&self) -> bool {
        self.has_se
    }
}

/// Ranges of linear RGB ratios, dimensionless; lower and upper end agree where one value was published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RatioRange {
    pub blue_over_red: [f64; 2],
    pub green_over_red: [f64; 2],
}

/// Published colour ratios at normal illumination.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedRatios {
    /// The authors' cloth on their rig.
    pub real: RatioRange,
    /// Their model over the parameters of its medium.
    pub model: RatioRange,
}

const RATIO_COLUMNS: [&str; 5] = [
    "row",
    "blue_over_red_low",
    "blue_over_red_high",
    "green_over_red_low",
    "green_over_red_high",
];

/// Reads data of any layout; its header says which.
pub(super) fn parse(path: &str, bytes: &[u8], relative_se: Option<f64>) -> Result<Data, SampleError> {
    let table = CsvTable::parse(path, bytes)?;
    if table.column("row").is_some() {
        return Ok(Data::Ratios(ratios(path, bytes)?));
    }
    let layout = Layout::of(&table)?;
    let has_se = !layout.se.is_empty();
    let mut entries = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        entries.push(layout.entry(&table, row, relative_se.unwrap_or(0.0))?);
    }
    let (axis, mut rows) = match layout.wavelength {
        Some(column) => spectral(&table, column, entries)?,
        None => (Axis::Rgb, rgb(&table, entries)?),
    };
    rows.sort_by(|a, b| {
        a.theta_i_deg
            .total_cmp(&b.theta_i_deg)
            .then(a.theta_v_deg.total_cmp(&b.theta_v_deg))
    });
    Ok(Data::Curves(Curves { axis, has_se, rows }))
}

/// Columns of the two layouts of readings.
struct Layout {
    theta_i: usize,
    theta_v: usize,
    wavelength: Option<usize>,
    beta: Vec<usize>,
    /// As many as `beta`, or none.
    se: Vec<usize>,
}

impl Layout {
    fn of(table: &CsvTable) -> Result<Self, Box<CsvError>> {
        let spectral = table.column("wavelength_nm").is_some();
        let (values, errors): (&[&str], &[&str]) = if spectral {
            (&["wavelength_nm", "beta"], &["beta_se"])
        } else {
            (
                &["beta_r", "beta_g", "beta_b"],
                &["beta_r_se", "beta_g_se", "beta_b_se"],
            )
        };
        let required = [&["theta_i_deg", "theta_v_deg"], values].concat();
        let remedy = "columns are theta_i_deg,theta_v_deg,wavelength_nm,beta[,beta_se] for spectral data and \
                      theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b[,beta_r_se,beta_g_se,beta_b_se] for RGB";
        let find = |name: &&str| {
            table.column(name).ok_or_else(|| {
                table.header_error(&format!("a column {name}"), &table.columns().join(","), Some(remedy))
            })
        };
        let columns = required.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        let se = if errors.iter().any(|name| table.column(name).is_some()) {
            errors.iter().map(find).collect::<Result<Vec<_>, _>>()?
        } else {
            Vec::new()
        };
        let known = [&required, errors].concat();
        if let Some(unknown) = table.columns().iter().find(|c| !known.contains(&c.as_str())) {
            let expected = format!("only the columns {}", known.join(","));
            return Err(table.header_error(&expected, &format!("'{unknown}'"), Some("remove or rename it")));
        }
        Ok(Self {
            theta_i: columns[0],
            theta_v: columns[1],
            wavelength: spectral.then(|| columns[2]),
            beta: columns[if spectral { 3 } else { 2 }..].to_vec(),
            se,
        })
    }

    /// One line: a whole reading of RGB data, one wavelength of spectral data.
    fn entry(&self, table: &CsvTable, row: usize, relative_se: f64) -> Result<Row, Box<CsvError>> {
        let checked = |column: usize, expected: &str, remedy: Option<&str>, allowed: &dyn Fn(f64) -> bool| {
            let value = table.number(row, column, expected)?;
            if allowed(value) {
                Ok(value)
            } else {
                Err(table.cell_error(row, column, expected, remedy))
            }
        };
        let theta_i_deg = checked(
            self.theta_i,
            "an incidence in degrees from the normal, 0 or more and below 90",
            Some("the light's side is given by the sign of theta_v_deg"),
            &|v| (0.0..90.0).contains(&v),
        )?;
        let theta_v_deg = checked(
            self.theta_v,
            "a signed view angle in degrees, above -90 and below 90",
            Some("reflection only: the view lies above the cloth"),
            &|v| v.abs() < 90.0,
        )?;
        let beta = self
            .beta
            .iter()
            .map(|&column| {
                checked(
                    column,
                    "a brightness factor, dimensionless, 0 or more",
                    Some("a colour outside the RGB space has to be given as spectral data"),
                    &|v| v >= 0.0,
                )
            })
            .collect::<Result<Vec<_>, _>>()?;
        let se = if self.se.is_empty() {
            beta.iter().map(|b| b * relative_se).collect()
        } else {
            let expected = "a standard error in the unit of beta, dimensionless, 0 or more";
            self.se
                .iter()
                .map(|&column| checked(column, expected, None, &|v| v >= 0.0))
                .collect::<Result<Vec<_>, _>>()?
        };
        Ok(Row {
            theta_i_deg,
            theta_v_deg,
            beta,
            se,
        })
    }
}

/// Bits of the two angles; adding 0 makes one zero of the two.
fn key(row: &Row) -> [u64; 2] {
    [(row.theta_i_deg + 0.0).to_bits(), (row.theta_v_deg + 0.0).to_bits()]
}

fn geometry_text(row: &Row) -> String {
    format!("theta_i_deg {}, theta_v_deg {}", row.theta_i_deg, row.theta_v_deg)
}

fn rgb(table: &CsvTable, entries: Vec<Row>) -> Result<Vec<Row>, Box<CsvError>> {
    let mut seen = HashMap::new();
    for (index, entry) in entries.iter().enumerate() {
        if let Some(first) = seen.insert(key(entry), index) {
            return Err(twice(table, index, first, &geometry_text(entry)));
        }
    }
    Ok(entries)
}

fn twice(table: &CsvTable, row: usize, first: usize, what: &str) -> Box<CsvError> {
    let found = format!("{what} again, first on line {}", table.line(first));
    table.row_error(row, "every geometry once", &found, Some("keep one, or their mean"))
}

/// One geometry of a spectral table while its lines are gathered.
struct Gathered {
    first_row: usize,
    /// (wavelength in nm, row of the table)
    points: Vec<(f64, usize)>,
}

fn spectral(table: &CsvTable, column: usize, entries: Vec<Row>) -> Result<(Axis, Vec<Row>), SampleError> {
    /// Common to the observers' and the illuminants' tables.
    const COLOUR_NM: std::ops::RangeInclusive<f64> = 360.0..=780.0;
    let mut found: HashMap<[u64; 2], usize> = HashMap::new();
    let mut geometries: Vec<Gathered> = Vec::new();
    for (row, entry) in entries.iter().enumerate() {
        let expected = "a wavelength in nm, 360..780, where the CIE tables are";
        let nm = table.number(row, column, expected)?;
        if !COLOUR_NM.contains(&nm) {
            return Err(table
                .cell_error(row, column, expected, Some("leave the row out"))
                .into());
        }
        let index = *found.entry(key(entry)).or_insert_with(|| {
            geometries.push(Gathered {
                first_row: row,
                points: Vec::new(),
            });
            geometries.len() - 1
        });
        geometries[index].points.push((nm, row));
    }
    for geometry in &mut geometries {
        geometry.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = geometry.points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let what = format!("{}, {} nm", geometry_text(&entries[pair[1].1]), pair[1].0);
            return Err(twice(table, pair[1].1, pair[0].1, &what).into());
        }
    }
    let nm: Vec<f64> = geometries[0].points.iter().map(|point| point.0).collect();
    if let Some(other) = geometries
        .iter()
        .find(|g| !g.points.iter().map(|point| point.0).eq(nm.iter().copied()))
    {
        let expected = format!("the {} wavelengths of {}", nm.len(), geometry_text(&entries[0]));
        let text = format!(
            "{} others at {}",
            other.points.len(),
            geometry_text(&entries[other.first_row])
        );
        let remedy = "measure every geometry at the same wavelengths, or resample first";
        return Err(table.row_error(other.first_row, &expected, &text, Some(remedy)).into());
    }
    let rows = geometries
        .iter()
        .map(|geometry| {
            let values = |of: fn(&Row) -> f64| geometry.points.iter().map(|point| of(&entries[point.1])).collect();
            let first = &entries[geometry.first_row];
            Row {
                theta_i_deg: first.theta_i_deg,
                theta_v_deg: first.theta_v_deg,
                beta: values(|entry| entry.beta[0]),
                se: values(|entry| entry.se[0]),
            }
        })
        .collect();
    Ok((Axis::Wavelengths(WavelengthGrid::new(nm)?), rows))
}

/// Reads a table of published ratios: rows `real` and `model`.
pub(super) fn ratios(path: &str, bytes: &[u8]) -> Result<PublishedRatios, Box<CsvError>> {
    let table = CsvTable::parse(path, bytes)?;
    if table.columns() != RATIO_COLUMNS {
        return Err(table.header_error(
            &format!("the columns {}", RATIO_COLUMNS.join(",")),
            &table.columns().join(","),
            None,
        ));
    }
    let range = |name: &str| -> Result<RatioRange, Box<CsvError>> {
        let row = (0..table.len())
            .find(|&row| table.text(row, 0) == name)
            .ok_or_else(|| table.header_error(&format!("a row '{name}'"), "none", None))?;
        let number = |column| table.number(row, column, "a ratio of linear RGB components");
        Ok(RatioRange {
            blue_over_red: [number(1)?, number(2)?],
            green_over_red: [number(3)?, number(4)?],
        })
    };
    Ok(PublishedRatios {
        real: range("real")?,
        model: range("model")?,
    })
}
