//! This program's CSV of goniometric readings.

use std::collections::HashMap;
use std::iter::zip;
use std::ops::RangeInclusive;

use crate::formats::descriptor::{Descriptor, FormatReader, FormatWriter, Holds, Input, USUAL_SIZES};
use crate::formats::error::{FormatError, Location};
use crate::formats::write::columns;
use crate::goniometric::{
    ChannelSet, Component, Directions, FileProvenance, Format, Goniometric, Quantity, ReadNotice, Scatter, Scattered,
    Side, Table,
};
use crate::spectrum::{WavelengthGrid, plausibility};
use crate::text::{CsvError, CsvTable, Heading, heading, remedy_for_brdf};

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("csv"),
    words: "csv",
    extensions: &[("csv", None)],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| beginning.first_line(|line| matches!(heading(line), Some(Heading::Plane | Heading::Sphere))),
    read: FormatReader::Goniometric(read),
    write: Some(FormatWriter {
        holds: Holds::Scattering,
        errors: true,
        variant: None,
        write: columns::csv,
    }),
};

/// Angle columns, with their ranges in degrees.
const PLANE: [(&str, RangeInclusive<f64>); 2] = [("theta_i_deg", 0.0..=90.0), ("theta_v_deg", -90.0..=90.0)];
const SPHERE: [(&str, RangeInclusive<f64>); 4] = [
    ("theta_i_deg", 0.0..=90.0),
    ("phi_i_deg", -360.0..=360.0),
    ("theta_o_deg", 0.0..=180.0),
    ("phi_o_deg", -360.0..=360.0),
];

/// Brightness factors and their errors are at most this.
const LARGEST: f64 = 1e30;

/// Columns: angles in degrees as above, theta_o beyond 90 of transmission; then `wavelength_nm,beta`, or a column a
/// wavelength, or `beta_r,beta_g,beta_b`, `beta_x,beta_y,beta_z` or `beta`; then standard errors, the same names with
/// `_se`, all or none.
fn read(input: &Input) -> Result<Goniometric, FormatError> {
    parse(input.path, input.bytes).map_err(|e| format_error(&e))
}

fn format_error(of: &CsvError) -> FormatError {
    let place = Location::Row {
        line: of.line,
        column: of.column.as_deref().map(Into::into),
    };
    FormatError::at(
        &of.name,
        place,
        of.expected.as_str(),
        of.found.as_str(),
        of.remedy.as_str(),
    )
}

/// Which column holds what.
struct ReadingLayout {
    directions: Directions,
    angles: Vec<(usize, RangeInclusive<f64>)>,
    wavelength: Option<usize>,
    beta: Vec<usize>,
    /// As many as `beta`, or none.
    errors: Vec<usize>,
}

impl ReadingLayout {
    fn of(table: &CsvTable) -> Result<Self, Box<CsvError>> {
        let (directions, angle_columns) = match table.column("phi_o_deg") {
            Some(_) => (Directions::Sphere, &SPHERE[..]),
            None => (Directions::Plane, &PLANE[..]),
        };
        let found = || table.columns().join(",");
        let place = |name: &str| {
            let remedy = "columns are theta_i_deg,theta_v_deg or theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg, then \
                          wavelength_nm,beta or beta_r,beta_g,beta_b";
            let missing = || table.header_error(&format!("a column {name}"), &found(), remedy);
            table.column(name).ok_or_else(missing)
        };
        let value_columns: &[&str] = [
            &["wavelength_nm", "beta"][..],
            &["beta_r", "beta_g", "beta_b"],
            &["beta_x", "beta_y", "beta_z"],
            &["beta"],
        ]
        .into_iter()
        .find(|set| set.iter().all(|name| table.column(name).is_some()))
        .ok_or_else(|| {
            let remedy =
                remedy_for_brdf(&found()).unwrap_or("or a column a wavelength, titled with it in nm, such as 450");
            table.header_error("columns wavelength_nm,beta or beta_r,beta_g,beta_b", &found(), remedy)
        })?;
        let angles = angle_columns
            .iter()
            .map(|(name, range)| Ok((place(name)?, range.clone())));
        let angles = angles.collect::<Result<Vec<_>, Box<CsvError>>>()?;
        let wavelength = table
            .column("wavelength_nm")
            .filter(|_| value_columns[0] == "wavelength_nm");
        let names = &value_columns[usize::from(wavelength.is_some())..];
        let beta = names.iter().map(|name| place(name)).collect::<Result<Vec<_>, _>>()?;
        let errors = match table.columns().iter().any(|name| name.ends_with("_se")) {
            true => names
                .iter()
                .map(|name| place(&format!("{name}_se")))
                .collect::<Result<Vec<_>, _>>()?,
            false => Vec::new(),
        };
        let layout = Self {
            directions,
            angles,
            wavelength,
            beta,
            errors,
        };
        match (0..table.columns().len()).find(|column| !layout.holds(*column)) {
            Some(other) => {
                let expected = "columns of angles, wavelengths, values and their standard errors alone";
                let found = format!("'{}'", table.columns()[other]);
                Err(table.header_error(expected, &found, "remove it, or rename it"))
            }
            None => Ok(layout),
        }
    }

    fn holds(&self, column: usize) -> bool {
        let places = self.angles.iter().map(|(place, _)| place).chain(&self.wavelength);
        places
            .chain(&self.beta)
            .chain(&self.errors)
            .any(|place| *place == column)
    }
}

/// What a line says of its geometry.
struct Point {
    row: usize,
    /// 0 where there are no wavelengths.
    nm: f64,
    values: Vec<f64>,
    errors: Vec<f64>,
}

/// Readings in the order of the file.
#[derive(Default)]
struct Readings {
    by_geometry: HashMap<Vec<u64>, usize>,
    /// In radians.
    angles: Vec<Vec<f64>>,
    /// Of each geometry; one, but where lines are of wavelengths.
    points: Vec<Vec<Point>>,
    /// Lines that repeat another one.
    repeated: usize,
    /// Whether the light went through.
    through: Option<bool>,
    highest: f64,
    /// The lowest value and its row.
    lowest: (f64, usize),
    negative: usize,
}

impl Readings {
    fn take(&mut self, table: &CsvTable, layout: &ReadingLayout, row: usize) -> Result<(), Box<CsvError>> {
        let mut degrees = Vec::with_capacity(layout.angles.len());
        for (column, range) in &layout.angles {
            let expected = format!("an angle from {} to {} degrees", range.start(), range.end());
            let angle = table.number(row, *column, &expected)?;
            if !range.contains(&angle) {
                let remedy = "check the unit of the angle and its column";
                return Err(table.cell_error(row, *column, &expected, remedy));
            }
            degrees.push(angle);
        }
        if layout.directions == Directions::Sphere {
            // The horizon belongs to both.
            let side = (degrees[2] != 90.0).then_some(degrees[2] > 90.0);
            if side.is_some_and(|side| *self.through.get_or_insert(side) != side) {
                let found = format!("theta_o_deg {}", degrees[2]);
                let remedy = "write transmission, theta_o_deg above 90, into a file of its own";
                return Err(table.row_error(row, "either reflection or transmission in a file", &found, remedy));
            }
            if degrees[2] > 90.0 {
                degrees[2] = 180.0 - degrees[2];
            }
        }
        let key = degrees.iter().map(|a| (a + 0.0).to_bits()).collect();
        let mut point = Point {
            row,
            nm: 0.0,
            values: Vec::with_capacity(layout.beta.len()),
            errors: Vec::with_capacity(layout.errors.len()),
        };
        let readings = self.angles.len();
        let index = *self.by_geometry.entry(key).or_insert(readings);
        if index == readings {
            self.angles.push(degrees.into_iter().map(f64::to_radians).collect());
            self.points.push(Vec::new());
        }
        if let Some(column) = layout.wavelength {
            let expected = "a wavelength in nm";
            let nm = table.number(row, column, expected)?;
            let unit = plausibility::wavelength_unit(nm).filter(|_| self.points[index].is_empty());
            if nm <= 0.0 || unit.is_some() {
                let remedy = unit.unwrap_or("correct the wavelength, or leave the line out");
                return Err(table.cell_error(row, column, expected, remedy));
            }
            point.nm = nm;
        }
        for &column in &layout.beta {
            let expected = "a brightness factor, dimensionless";
            let value = table.number(row, column, expected)?;
            if value.abs() > LARGEST {
                let remedy = "correct the value, or leave the line out";
                return Err(table.cell_error(row, column, expected, remedy));
            }
            self.highest = self.highest.max(value);
            self.negative += usize::from(value < 0.0);
            if value < self.lowest.0 {
                self.lowest = (value, row);
            }
            point.values.push(value);
        }
        for &column in &layout.errors {
            let expected = "a standard error in the unit of beta, 0 or more";
            let error = table.number(row, column, expected)?;
            if !(0.0..=LARGEST).contains(&error) {
                let remedy = "give its size without a sign, or leave the columns of errors out";
                return Err(table.cell_error(row, column, expected, remedy));
            }
            point.errors.push(error);
        }
        self.points[index].push(point);
        Ok(())
    }

    /// Puts the wavelengths of each geometry into ascending order; the same reading written twice is one.
    fn sorted(&mut self, table: &CsvTable) -> Result<(), Box<CsvError>> {
        for points in &mut self.points {
            points.sort_by(|a, b| a.nm.total_cmp(&b.nm));
            let all = points.len();
            points.dedup_by(|b, a| a.nm == b.nm && a.values == b.values && a.errors == b.errors);
            self.repeated += all - points.len();
            if let Some(pair) = points.windows(2).find(|pair| pair[0].nm == pair[1].nm) {
                return Err(twice(table, pair[1].row, pair[0].row));
            }
        }
        Ok(())
    }

    /// Values, or errors, in the order of the geometries.
    fn concat(&self, of: fn(&Point) -> &[f64]) -> Vec<f64> {
        let points = self.points.iter().flatten();
        points.flat_map(of).copied().collect()
    }

    /// Notices on the values as a whole.
    fn notices(&self, table: &CsvTable) -> Result<Vec<ReadNotice>, Box<CsvError>> {
        let mut notices: Vec<ReadNotice> = table.notices().iter().cloned().map(ReadNotice::from).collect();
        if !table.renamed().is_empty() {
            notices.push(ReadNotice::RenamedColumns {
                columns: table.renamed().to_vec(),
            });
        }
        notices.extend(plausibility::repeated(self.repeated).map(ReadNotice::from));
        match plausibility::below_zero("beta", self.lowest.0, self.highest, self.negative) {
            Ok(doubt) => notices.extend(doubt.map(ReadNotice::from)),
            Err([expected, found, remedy]) => {
                return Err(table.row_error(self.lowest.1, &expected, &found, &remedy));
            }
        }
        let degrees = |angles: &[f64]| -> Vec<f64> { angles.iter().map(|angle| angle.to_degrees()).collect() };
        let readings = zip(&self.angles, &self.points).flat_map(|(angles, points)| {
            let in_lobe = match degrees(angles)[..] {
                [theta_i, phi_i, theta_o, phi_o] => plausibility::in_lobe(theta_i, theta_o, phi_o - phi_i),
                [theta_i, theta_v] => plausibility::in_lobe_of_plane(theta_i, theta_v),
                _ => false,
            };
            let values = points.iter().flat_map(|point| &point.values);
            values.map(move |value| (*value, in_lobe))
        });
        let per_cent = plausibility::per_cent_for_fractions("beta", readings);
        // Polar angles and azimuths take turns, but in the plane.
        let of = |is_polar: bool| {
            let angles = self.angles.iter().flat_map(move |angles| {
                let is_plane = angles.len() == PLANE.len();
                let wanted = move |(at, _): &(usize, &f64)| (is_plane || at % 2 == 0) == is_polar;
                angles.iter().enumerate().filter(wanted)
            });
            angles.map(|(_, angle)| angle.to_degrees())
        };
        let radians = plausibility::radians_for_degrees(of(true), of(false));
        notices.extend(per_cent.into_iter().chain(radians).map(ReadNotice::from));
        Ok(notices)
    }
}

fn twice(table: &CsvTable, row: usize, first: usize) -> Box<CsvError> {
    let found = format!("the pair of line {} again, with another value", table.line(first));
    table.row_error(
        row,
        "every pair of directions once",
        &found,
        "keep one of them, or their mean; azimuths 360 degrees apart are one direction",
    )
}

fn parse(path: &str, bytes: &[u8]) -> Result<Goniometric, Box<CsvError>> {
    let table = CsvTable::parse(path, bytes)?.long()?;
    let layout = ReadingLayout::of(&table)?;
    let mut readings = Readings::default();
    for row in 0..table.len() {
        readings.take(&table, &layout, row)?;
    }
    readings.sorted(&table)?;
    let warnings = readings.notices(&table)?;
    let row_of = |geometry: usize| readings.points[geometry][0].row;
    let channels = match (layout.wavelength, layout.beta.len()) {
        (Some(_), _) => {
            let wavelengths = |points: &[Point]| -> Vec<f64> { points.iter().map(|point| point.nm).collect() };
            let nm = wavelengths(&readings.points[0]);
            let is_other = |points: &Vec<Point>| !points.iter().map(|point| point.nm).eq(nm.iter().copied());
            if let Some(other) = readings.points.iter().position(is_other) {
                let expected = format!("the {} wavelengths of the first geometry", nm.len());
                let found = format!("{} others", readings.points[other].len());
                let remedy = "measure every geometry at the same wavelengths, or leave the others out";
                return Err(table.row_error(row_of(other), &expected, &found, remedy));
            }
            let remedy = "give wavelengths above 0 nm";
            ChannelSet::Wavelengths(
                WavelengthGrid::new(nm).map_err(|e| table.header_error("wavelengths", &e.to_string(), remedy))?,
            )
        }
        (None, 1) => ChannelSet::Monochrome,
        (None, _) if table.column("beta_r").is_some() => ChannelSet::Rgb,
        (None, _) => ChannelSet::Xyz,
    };
    let scattered = Scattered::new(
        layout.directions,
        &readings.angles,
        channels.count(),
        readings.concat(|point| &point.values),
    )
    .map_err(|pair| twice(&table, row_of(pair.1), row_of(pair.0)))?;
    let errors = (!layout.errors.is_empty()).then(|| readings.concat(|point| &point.errors));
    let scattered = scattered.with_errors(errors);
    let provenance = FileProvenance {
        comments: table.comments().to_vec(),
        ..FileProvenance::default()
    };
    Ok(Goniometric {
        format: FORMAT.format,
        provenance,
        components: vec![Component {
            scatter: match readings.through {
                Some(true) => Scatter::Transmission,
                _ => Scatter::Reflection,
            },
            side: Side::Front,
            quantity: Quantity::BrightnessFactor,
            channels,
            table: Table::Scattered(scattered),
        }],
        warnings,
    })
}
