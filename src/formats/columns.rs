//! Readings in lines of comma-separated numbers: this program's CSV, and the text with a `VARS` line that goes by the
//! name ASTM E1392.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

use super::detect::Format;
use super::goniometric::{Channels, Component, Goniometric, Provenance, Quantity, Scatter, Side, Table};
use super::integra::scatter_of;
use super::scattered::{Directions, Scattered};
use super::error::remedy;
use super::text::{FINITE, NOT_NEGATIVE, Readings, Text, finite, quoted, remedy_for};
use super::{AngleUnit, FormatError, ReadOptions};
use crate::spectrum::WavelengthGrid;

/// A line and the byte it begins at.
type Line<'a> = (usize, &'a str);

/// The lines of a text that are not blank.
fn lines(text: Text<'_>) -> impl Iterator<Item = Line<'_>> {
    let start = text.text.as_ptr() as usize;
    text.text
        .split(['\n', '\r'])
        .filter(|line| !line.trim().is_empty())
        .map(move |line| (line.as_ptr() as usize - start, line))
}

/// As many numbers as there are ranges, each within its own.
fn numbers(text: Text, line: Line, names: &[&str], ranges: &[RangeInclusive<f64>]) -> Result<Vec<f64>, FormatError> {
    let cells = line.1.split(',').count();
    if cells != names.len() {
        let expected = format!("{} values ({})", names.len(), names.join(","));
        let remedy = "separate the values by commas, one for each column, with a point as decimal mark";
        return Err(text.error(line.0, expected, format!("{cells}"), remedy));
    }
    let mut at = line.0;
    let mut found = Vec::with_capacity(names.len());
    for (cell, (name, range)) in line.1.split(',').zip(names.iter().zip(ranges)) {
        let number = finite(cell.trim(), range).ok_or_else(|| {
            let expected = match range {
                range if *range == FINITE => format!("{name}, a finite number"),
                range if range.end() == FINITE.end() => format!("{name}, a number of {} or more", range.start()),
                range => format!("{name}, a number from {} to {}", range.start(), range.end()),
            };
            text.error(at, expected, quoted(cell.trim()), remedy_for(cell.trim(), range))
        })?;
        found.push(number);
        at += cell.len() + 1;
    }
    Ok(found)
}

fn scattered(
    text: Text,
    directions: Directions,
    angles: &[Vec<f64>],
    at: &[usize],
    channels: usize,
    values: Vec<f64>,
) -> Result<Scattered, FormatError> {
    Scattered::new(directions, angles, channels, values).map_err(|twice| {
        text.error(
            at[twice.1],
            "every pair of directions once",
            format!("the pair of{} again", text.place(at[twice.0]).to_string().trim_start_matches(',')),
            "keep one reading of the two, or their mean; azimuths 360 degrees apart are one direction",
        )
    })
}

pub(super) fn read_astm(text: Text, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let mut provenance = Provenance::default();
    let mut promised = None;
    let mut lines = lines(text);
    let (vars_at, vars) = loop {
        let Some((at, line)) = lines.next() else {
            let remedy = "write a line VARS with the names of the columns before the readings";
            return Err(text.error(text.text.len(), "a line VARS", "the end of the file", remedy));
        };
        let (name, value) = line.trim().split_once([' ', '\t']).unwrap_or((line.trim(), ""));
        match name {
            "VARS" => break (at, value.trim()),
            "NUM_POINTS" => {
                let count: Result<usize, _> = value.trim().parse();
                promised = Some(count.map_err(|_| {
                    let remedy = "write how many lines of readings follow VARS, or leave the line out";
                    text.error(at, "NUM_POINTS and a whole number", quoted(value), remedy)
                })?);
            }
            _ => provenance.statements.push((name.to_owned(), value.trim().to_owned())),
        }
    };
    let names: Vec<&str> = vars.split(',').map(str::trim).collect();
    // Some writers leave the incident azimuth out.
    let angle_count = if names
        .get(1)
        .is_some_and(|name| name.to_ascii_lowercase().contains("theta"))
    {
        3
    } else {
        4
    };
    if names.len() <= angle_count {
        let expected = "columns of angles, then of values, after VARS";
        let remedy = "name them between commas, such as theta_i,phi_i,theta_s,phi_s,BSDF";
        return Err(text.error(vars_at, expected, quoted(vars), remedy));
    }
    let channels = astm_channels(text, vars_at, &names[angle_count..])?;
    let turn = match options.angle_unit {
        Some(AngleUnit::Degrees) => 1f64.to_radians(),
        _ => 1.0,
    };
    let any_angle = -1e3..=1e3;
    let mut ranges = vec![any_angle; angle_count];
    ranges.resize(names.len(), FINITE);
    let mut readings = Readings::default();
    let (mut angles, mut at, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for line in lines {
        let row = numbers(text, line, &names, &ranges)?;
        let mut directions: Vec<f64> = row[..angle_count].iter().map(|angle| angle * turn).collect();
        if angle_count == 3 {
            directions.insert(1, 0.0);
        }
        for polar in [0, 2] {
            if !(0.0..=FRAC_PI_2 + 1e-4).contains(&directions[polar]) {
                let expected = match options.angle_unit {
                    Some(AngleUnit::Degrees) => "polar angles from 0 to 90 degrees",
                    _ => "polar angles in radians, 0 to 1.5708",
                };
                let remedy = match options.angle_unit {
                    None => "if the angles are degrees, say so: --degrees",
                    Some(_) => "check the unit and the order of the columns; give light from below as a file of its own",
                };
                let found = row[polar.min(angle_count - 2)].to_string();
                return Err(text.error(line.0, expected, found, remedy));
            }
        }
        angles.push(directions);
        at.push(line.0);
        row[angle_count..].iter().for_each(|&value| readings.take(value, line.0));
        values.extend_from_slice(&row[angle_count..]);
    }
    if angles.is_empty() || promised.is_some_and(|count| count != angles.len()) {
        let expected = promised.map_or("lines of readings".to_owned(), |count| {
            format!("{count} lines, as NUM_POINTS says")
        });
        let remedy = "correct NUM_POINTS, or copy the file again: lines may be missing at its end";
        return Err(text.error(text.text.len(), expected, format!("{}", angles.len()), remedy));
    }
    let table = scattered(text, Directions::Sphere, &angles, &at, channels.count(), values)?;
    let mut warnings = Vec::new();
    text.judge(&readings, &mut warnings)?;
    let scatter = scatter_of(text.path, "astm", "btdf.astm", options, &mut warnings);
    if options.angle_unit.is_none() {
        warnings.push("the file does not state the unit of its angles: taken as radians".into());
    }
    if table.is_mirrored() {
        warnings.push(
            "one side of the plane of incidence alone was measured: the other is taken as its mirror image".into(),
        );
    }
    Ok(Goniometric {
        format: Format::Astm,
        provenance,
        components: vec![Component {
            scatter,
            side: Side::Front,
            quantity: Quantity::Bsdf,
            channels,
            table: Table::Scattered(table),
        }],
        warnings,
    })
}

fn astm_channels(text: Text, at: usize, names: &[&str]) -> Result<Channels, FormatError> {
    let nm: Option<Vec<f64>> = names
        .iter()
        .map(|n| n.strip_suffix("nm")?.trim().parse().ok())
        .collect();
    Ok(match (names, nm) {
        (["R", "G", "B"], _) => Channels::Rgb,
        (["X", "Y", "Z"], _) => Channels::Xyz,
        (_, Some(nm)) => Channels::Wavelengths(
            WavelengthGrid::new(nm)
                .map_err(|e| text.error(at, "ascending wavelengths", e.to_string(), remedy::WAVELENGTHS))?,
        ),
        ([_], _) => Channels::Monochrome,
        _ => {
            let expected = "value columns R,G,B or X,Y,Z or wavelengths such as 550nm, or a single one";
            let remedy = "name the columns of values so, or split them into files";
            return Err(text.error(at, expected, quoted(&names.join(",")), remedy));
        }
    })
}

/// Angle columns of the CSV, with their ranges in degrees.
const PLANE: [(&str, RangeInclusive<f64>); 2] = [("theta_i_deg", 0.0..=90.0), ("theta_v_deg", -90.0..=90.0)];
const SPHERE: [(&str, RangeInclusive<f64>); 4] = [
    ("theta_i_deg", 0.0..=90.0),
    ("phi_i_deg", -360.0..=360.0),
    ("theta_o_deg", 0.0..=180.0),
    ("phi_o_deg", -360.0..=360.0),
];

/// Columns: angles in degrees as above, theta_o beyond 90 of transmission; then `wavelength_nm,beta`, or
/// `beta_r,beta_g,beta_b`, `beta_x,beta_y,beta_z` or `beta`; then standard errors, the same names with `_se`, all or none.
pub(super) fn read_csv(text: Text) -> Result<Goniometric, FormatError> {
    let comment = |line: &Line| line.1.trim_start().starts_with('#');
    let mut provenance = Provenance::default();
    let comments = lines(text).filter(comment).take(20);
    provenance
        .comments
        .extend(comments.map(|(_, line)| line.trim_start_matches(['#', ' ']).to_owned()));
    let mut rows = lines(text).filter(|line| !comment(line));
    let Some((header_at, header)) = rows.next() else {
        let remedy = "begin with a line such as theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta";
        return Err(text.error(0, "a line of column names", "the end of the file", remedy));
    };
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let (directions, angle_columns) = if names.contains(&"phi_o_deg") {
        (Directions::Sphere, &SPHERE[..])
    } else {
        (Directions::Plane, &PLANE[..])
    };
    let value_columns: &[&str] = [
        &["wavelength_nm", "beta"][..],
        &["beta_r", "beta_g", "beta_b"],
        &["beta_x", "beta_y", "beta_z"],
        &["beta"],
    ]
    .into_iter()
    .find(|set| set.iter().all(|name| names.contains(name)))
    .ok_or_else(|| {
        text.error(
            header_at,
            "columns wavelength_nm,beta or beta_r,beta_g,beta_b or beta_x,beta_y,beta_z or beta",
            quoted(header),
            "name the columns of values so; beta is the brightness factor, 1 for the perfect diffuser",
        )
    })?;
    let place = |name: &str| {
        let place = names.iter().position(|n| *n == name);
        place.ok_or_else(|| {
            let remedy = format!("add the column {name}, or correct its title");
            text.error(header_at, format!("a column {name}"), quoted(header), remedy)
        })
    };
    let angle_places = angle_columns
        .iter()
        .map(|(name, _)| place(name))
        .collect::<Result<Vec<_>, _>>()?;
    let value_places = value_columns
        .iter()
        .map(|name| place(name))
        .collect::<Result<Vec<_>, _>>()?;
    let mut ranges = vec![NOT_NEGATIVE; names.len()];
    let mut readings = Readings::default();
    for ((_, range), &place) in angle_columns.iter().zip(&angle_places) {
        ranges[place] = range.clone();
    }
    let spectral = value_columns[0] == "wavelength_nm";
    let beta_columns = &value_columns[usize::from(spectral)..];
    let beta_places = &value_places[usize::from(spectral)..];
    beta_places.iter().for_each(|&place| ranges[place] = FINITE);
    let error_places = if names.iter().any(|name| name.ends_with("_se")) {
        let errors = beta_columns.iter().map(|name| place(&format!("{name}_se")));
        errors.collect::<Result<Vec<_>, _>>()?
    } else {
        Vec::new()
    };
    let known = [&angle_places[..], &value_places, &error_places].concat();
    if let Some(other) = (0..names.len()).find(|place| !known.contains(place)) {
        let remedy = "remove the column, or correct its title";
        return Err(text.error(header_at, "known columns, each once", quoted(names[other]), remedy));
    }
    let mut by_geometry: HashMap<Vec<u64>, usize> = HashMap::new();
    let (mut angles, mut at, mut values): (Vec<Vec<f64>>, Vec<usize>, Vec<Vec<f64>>) = Default::default();
    let mut errors: Vec<Vec<f64>> = Vec::new();
    let mut wavelengths: Vec<Vec<f64>> = Vec::new();
    let mut through = None;
    for line in rows {
        let row = numbers(text, line, &names, &ranges)?;
        let mut degrees: Vec<f64> = angle_places.iter().map(|&place| row[place]).collect();
        if directions == Directions::Sphere {
            // The horizon belongs to both.
            let side = (degrees[2] != 90.0).then_some(degrees[2] > 90.0);
            if side.is_some_and(|side| *through.get_or_insert(side) != side) {
                return Err(text.error(
                    line.0,
                    "either reflection or transmission in a file",
                    format!("theta_o {}", degrees[2]),
                    "write two files: theta_o_deg up to 90 is reflection, beyond it transmission",
                ));
            }
            if degrees[2] > 90.0 {
                degrees[2] = 180.0 - degrees[2];
            }
        }
        let key = degrees.iter().map(|a| (a + 0.0).to_bits()).collect();
        let next = angles.len();
        let index = *by_geometry.entry(key).or_insert(next);
        if index == next {
            angles.push(degrees.into_iter().map(f64::to_radians).collect());
            at.push(line.0);
            values.push(Vec::new());
            errors.push(Vec::new());
            wavelengths.push(Vec::new());
        } else if !spectral {
            let remedy = "keep one reading of the two, or their mean";
            return Err(text.error(line.0, "every pair of directions once", "a pair again", remedy));
        }
        if spectral {
            let nm = row[value_places[0]];
            if wavelengths[index].last().is_some_and(|last| nm <= *last) || nm <= 0.0 {
                let expected = "wavelengths in nm, ascending at each geometry";
                return Err(text.error(line.0, expected, nm.to_string(), remedy::WAVELENGTHS));
            }
            wavelengths[index].push(nm);
        }
        for &place in beta_places {
            readings.take(row[place], line.0);
        }
        values[index].extend(beta_places.iter().map(|&place| row[place]));
        errors[index].extend(error_places.iter().map(|&place| row[place]));
    }
    if angles.is_empty() {
        let remedy = "add lines of readings below the column names";
        return Err(text.error(text.text.len(), "lines of readings", "the end of the file", remedy));
    }
    let channels = match value_columns {
        ["wavelength_nm", ..] => {
            if let Some(other) = wavelengths.iter().position(|nm| *nm != wavelengths[0]) {
                let expected = format!("the {} wavelengths of the first geometry", wavelengths[0].len());
                let remedy = "give every geometry the same wavelengths; leave out those that some lack";
                return Err(text.error(at[other], expected, "others", remedy));
            }
            let grid = WavelengthGrid::new(wavelengths.swap_remove(0));
            Channels::Wavelengths(grid.map_err(|e| {
                text.error(at[0], "wavelengths", e.to_string(), remedy::WAVELENGTHS)
            })?)
        }
        ["beta_r", ..] => Channels::Rgb,
        ["beta_x", ..] => Channels::Xyz,
        _ => Channels::Monochrome,
    };
    let table = scattered(text, directions, &angles, &at, channels.count(), values.concat())?;
    let table = table.with_errors((!error_places.is_empty()).then(|| errors.concat()));
    let mut warnings = Vec::new();
    text.judge(&readings, &mut warnings)?;
    Ok(Goniometric {
        format: Format::Csv,
        provenance,
        components: vec![Component {
            scatter: if through == Some(true) {
                Scatter::Transmission
            } else {
                Scatter::Reflection
            },
            side: Side::Front,
            quantity: Quantity::BrightnessFactor,
            channels,
            table: Table::Scattered(table),
        }],
        warnings,
    })
}
