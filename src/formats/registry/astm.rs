//! Readings in lines of comma-separated numbers under a `VARS` line: the text that goes by the name ASTM E1392.

use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

use super::integra::scatter_of;
use crate::formats::descriptor::{Descriptor, FormatReader, FormatWriter, Holds, USUAL_SIZES};
use crate::formats::error::{FormatError, remedy};
use crate::formats::options::{AngleUnit, ReadOptions};
use crate::formats::text::{FINITE, Readings, Text, finite, quoted, remedy_for};
use crate::formats::write::columns;
use crate::goniometric::{
    ChannelSet, Component, Directions, FileProvenance, Format, Goniometric, Quantity, ReadNotice, Scattered, Side,
    Table,
};
use crate::number::shown;
use crate::spectrum::WavelengthGrid;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("astm"),
    words: "astm",
    extensions: &[("astm", None)],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| beginning.line_of("VARS"),
    read: FormatReader::Goniometric(|input| input.text(|text| read(text, input.options))),
    write: Some(FormatWriter {
        holds: Holds::Scattering,
        errors: false,
        variant: None,
        write: columns::astm,
    }),
};

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
            format!(
                "the pair of{} again",
                text.place(at[twice.0]).to_string().trim_start_matches(',')
            ),
            "keep one reading of the two, or their mean; azimuths 360 degrees apart are one direction",
        )
    })
}

fn read(text: Text, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let mut provenance = FileProvenance::default();
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
                    Some(_) => {
                        "check the unit and the order of the columns; give light from below as a file of its own"
                    }
                };
                let found = shown(row[polar.min(angle_count - 2)]);
                return Err(text.error(line.0, expected, found, remedy));
            }
        }
        angles.push(directions);
        at.push(line.0);
        row[angle_count..]
            .iter()
            .for_each(|&value| readings.take(value, line.0));
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
        warnings.push(ReadNotice::RadiansAssumed);
    }
    if table.is_mirrored() {
        warnings.push(ReadNotice::MirroredPlane);
    }
    Ok(Goniometric {
        format: FORMAT.format,
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

fn astm_channels(text: Text, at: usize, names: &[&str]) -> Result<ChannelSet, FormatError> {
    let nm: Option<Vec<f64>> = names
        .iter()
        .map(|n| n.strip_suffix("nm")?.trim().parse().ok())
        .collect();
    Ok(match (names, nm) {
        (["R", "G", "B"], _) => ChannelSet::Rgb,
        (["X", "Y", "Z"], _) => ChannelSet::Xyz,
        (_, Some(nm)) => ChannelSet::Wavelengths(
            WavelengthGrid::new(nm)
                .map_err(|e| text.error(at, "ascending wavelengths", e.to_string(), remedy::WAVELENGTHS))?,
        ),
        ([_], _) => ChannelSet::Monochrome,
        _ => {
            let expected = "value columns R,G,B or X,Y,Z or wavelengths such as 550nm, or a single one";
            let remedy = "name the columns of values so, or split them into files";
            return Err(text.error(at, expected, quoted(&names.join(",")), remedy));
        }
    })
}
