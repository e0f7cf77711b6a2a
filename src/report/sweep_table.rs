//! The table of a sweep: a row a point.

use super::ReportError;
use crate::number::nan_from_null;
use serde::{Deserialize, Serialize};

/// A value and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptValue {
    #[serde(deserialize_with = "nan_from_null")]
    pub value: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub se: f64,
}

/// What the model is at a point. Values that do not exist, such as a ratio to red that is as good as 0, are NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// Number of the point in the design, from 0.
    pub point: usize,
    /// In the order of the table's keys.
    pub parameters: Vec<f64>,
    /// Of the diffuse part at normal incidence and view, as in Table 1.
    pub blue_over_red: SweptValue,
    pub green_over_red: SweptValue,
    /// Measured over model luminance at the reference; a perfect model has 1.
    pub coefficient: SweptValue,
    /// Root mean square of (model − measured) over the sample's standard uncertainty, channels r, g and b of all readings,
    /// of β as it is and of the normalised β.
    #[serde(deserialize_with = "nan_from_null")]
    pub misfit_absolute: f64,
    #[serde(deserialize_with = "nan_from_null")]
    pub misfit_normalised: f64,
    /// Of normalised luminance, an incidence each in the order of the table's.
    pub rmse: Vec<SweptValue>,
    /// Largest Monte Carlo standard error of the model's luminance over the geometries, relative.
    #[serde(deserialize_with = "nan_from_null")]
    pub relative_se: f64,
}

/// All points so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepTable {
    /// Keys of the study that are varied, as `section.key`.
    pub keys: Vec<String>,
    /// Incidences of the RMSE, degrees.
    pub theta_i_deg: Vec<f64>,
    /// SHA-256 of study, sample and design.
    pub digest: String,
    pub points: Vec<SweepPoint>,
}

const DIGEST: &str = "# specval sweep ";
const NAMED: [&str; 4] = ["blue_over_red", "green_over_red", "coefficient", "misfit_absolute"];

impl SweepTable {
    /// Names of the files of a sweep over so many keys.
    pub fn file_names(keys: usize) -> Vec<String> {
        let charts = (1..=keys).flat_map(|number| super::charts::file_names(&super::charts::sweep_name(number)));
        ["sweep.csv", "sweep.json"]
            .map(String::from)
            .into_iter()
            .chain(charts)
            .collect()
    }

    fn header(&self) -> Vec<String> {
        let pair = |name: String| [name.clone(), format!("{name}_se")];
        let mut names = vec!["point".to_owned()];
        names.extend(self.keys.iter().cloned());
        names.extend(NAMED[..3].iter().flat_map(|name| pair((*name).into())));
        names.extend([NAMED[3], "misfit_normalised", "relative_se"].map(String::from));
        names.extend(
            self.theta_i_deg
                .iter()
                .flat_map(|theta| pair(format!("rmse_y_{theta}deg"))),
        );
        names
    }

    /// The table as CSV, a first line of which holds the digest.
    ///
    /// # Errors
    /// None but of memory.
    pub fn csv(&self) -> Result<Vec<u8>, ReportError> {
        let mut text = format!("{DIGEST}{}\n", self.digest).into_bytes();
        let mut writer = csv::Writer::from_writer(&mut text);
        writer.write_record(self.header())?;
        for of in &self.points {
            let mut numbers = of.parameters.clone();
            for value in [of.blue_over_red, of.green_over_red, of.coefficient] {
                numbers.extend([value.value, value.se]);
            }
            numbers.extend([of.misfit_absolute, of.misfit_normalised, of.relative_se]);
            numbers.extend(of.rmse.iter().flat_map(|value| [value.value, value.se]));
            let cells = numbers.iter().map(|number| match number.is_finite() {
                true => number.to_string(),
                false => String::new(),
            });
            writer.write_record(std::iter::once(of.point.to_string()).chain(cells))?;
        }
        writer.flush().map_err(csv::Error::from)?;
        drop(writer);
        Ok(text)
    }

    /// The points of a table that [`Self::csv`] wrote for the same digest, keys and incidences; `None` of any other text,
    /// or of one that does not begin with the first points of the design.
    pub fn points_of(&self, text: &str) -> Option<Vec<SweepPoint>> {
        let (first, rows) = text.split_once('\n')?;
        if first.strip_prefix(DIGEST)? != self.digest {
            return None;
        }
        let mut reader = csv::Reader::from_reader(rows.as_bytes());
        if !reader
            .headers()
            .ok()?
            .iter()
            .eq(self.header().iter().map(String::as_str))
        {
            return None;
        }
        let mut points = Vec::new();
        for (number, record) in reader.records().enumerate() {
            let record = record.ok()?;
            let cell = |cell: &str| match cell.is_empty() {
                true => Some(f64::NAN),
                false => cell.parse().ok(),
            };
            if record.get(0)?.parse() != Ok(number) {
                return None;
            }
            let numbers: Vec<f64> = record.iter().skip(1).map(cell).collect::<Option<_>>()?;
            let (parameters, values) = numbers.split_at(self.keys.len());
            let pair = |at: usize| SweptValue {
                value: values[at],
                se: values[at + 1],
            };
            points.push(SweepPoint {
                point: number,
                parameters: parameters.to_vec(),
                blue_over_red: pair(0),
                green_over_red: pair(2),
                coefficient: pair(4),
                misfit_absolute: values[6],
                misfit_normalised: values[7],
                relative_se: values[8],
                rmse: (0..self.theta_i_deg.len()).map(|k| pair(9 + 2 * k)).collect(),
            });
        }
        Some(points)
    }
}
