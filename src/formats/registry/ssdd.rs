//! SSDD, Surface Scattering Distribution Data, version 0.3: lines of properties, then text or 32-bit binary values; up
//! to four blocks in one file. Values are f in 1/sr, fractions in specular blocks.

mod lines;

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use self::lines::{Lines, ascending, list_index, word_of};
use crate::formats::byte_order::{is_implausible, swapped};
use crate::formats::descriptor::{Beginning, Descriptor, FormatReader, FormatWriter, Holds, Input, Mark, USUAL_SIZES};
use crate::formats::error::{FormatError, Location, remedy};
use crate::formats::options::Encoding;
use crate::formats::text::{FINITE, Readings, finite, quoted, remedy_for};
use crate::formats::write::ssdd as write;
use crate::goniometric::{
    Axis, ChannelSet, Component, FileProvenance, Fold, Format, Goniometric, Grid, Parameters, Quantity, ReadNotice,
    Scatter, Side, SpecularTable, Table, radians,
};
use crate::number::shown;
use crate::spectrum::WavelengthGrid;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("ssdd"),
    words: "ssdd",
    extensions: &[("ssdd", None)],
    sizes: USUAL_SIZES,
    convention: None,
    detect: told,
    read: FormatReader::Goniometric(read),
    write: Some(FormatWriter {
        holds: Holds::Kinds,
        errors: false,
        variant: Some(("ssdd-binary", Encoding::Binary)),
        write: write::write,
    }),
};

fn told(beginning: &Beginning) -> Option<Mark> {
    let version = || beginning.line_of("VERSION").map(|_| Mark::LineWord);
    let mark = beginning.line_of("DATA_TYPE").or_else(version)?;
    let is_binary = beginning.text.contains('\0');
    Some(if is_binary { Mark::Binary } else { mark })
}

/// The properties of a block, before its data.
#[derive(Default)]
struct Block {
    data_type: Option<&'static str>,
    colour_model: Option<&'static str>,
    wavelengths_nm: Option<Vec<f64>>,
    parameter_type: Option<&'static str>,
    reduction: (bool, bool),
    lists_deg: [Option<Vec<f64>>; 5],
    source: Option<String>,
}

const BLOCK_KINDS: [&str; 4] = ["brdf", "btdf", "specular_reflectance", "specular_transmittance"];
const COLOUR_MODELS: [&str; 4] = ["monochrome", "rgb", "xyz", "spectrum"];
const PARAMETER_TYPES: [&str; 4] = [
    "spherical_coordinate_system",
    "specular_coordinate_system",
    "half_difference_coordinate_system",
    "distorted_spherical_coordinate_system",
];

fn read(input: &Input) -> Result<Goniometric, FormatError> {
    let (path, bytes) = (input.path, input.bytes);
    // Of a file with binary values the lines are decoded one by one.
    let text = crate::text::encoding::decode(bytes).ok();
    let text = text.filter(|decoded| !decoded.text.contains("DATA binary"));
    let bytes = text.as_ref().map_or(bytes, |decoded| decoded.text.as_bytes());
    let mut lines = Lines {
        path,
        bytes,
        position: 0,
        number: 0,
    };
    let mut provenance = FileProvenance::default();
    let mut components: Vec<Component> = Vec::new();
    let mut kinds_seen: Vec<&str> = Vec::new();
    let mut warnings: Vec<ReadNotice> = text
        .as_ref()
        .and_then(|decoded| decoded.notice.clone())
        .map(ReadNotice::from)
        .into_iter()
        .collect();
    let mut block = Block::default();
    let mut open = false;
    while let Some(line) = lines.next()? {
        let line = line.as_ref();
        let (name, value) = line.split_once([' ', '\t']).map_or((line, ""), |(n, v)| (n, v.trim()));
        if let Some(index) = list_index(name) {
            let list = ascending(&lines, value, name, 0.0..=360.0, index == 4)?;
            if block.lists_deg[index].replace(list).is_some() {
                return Err(lines.error("each property once in a block", quoted(name), remedy::ONE_OF_TWO));
            }
            continue;
        }
        match name {
            "VERSION" => {
                if !matches!(value, "0.2" | "0.3") {
                    warnings.push(ReadNotice::ReadAsVersion {
                        found: quoted(value),
                        read_as: "0.3".into(),
                    });
                }
                provenance.statements.push((name.into(), value.into()));
            }
            "DATA_TYPE" => {
                if open {
                    let remedy = "add the values of the block before it, or remove that block";
                    return Err(lines.error("DATA before the next DATA_TYPE", quoted(line), remedy));
                }
                let kind = word_of(&lines, value, &BLOCK_KINDS)?;
                if kinds_seen.contains(&kind) {
                    return Err(lines.error("each DATA_TYPE once in a file", quoted(kind), remedy::ONE_PER_FILE));
                }
                kinds_seen.push(kind);
                (block, open) = (Block::default(), true);
                block.data_type = Some(kind);
            }
            "COLOR_MODEL" => block.colour_model = Some(word_of(&lines, value, &COLOUR_MODELS)?),
            "PARAM_TYPE" => block.parameter_type = Some(word_of(&lines, value, &PARAMETER_TYPES)?),
            "WAVELENGTH_LIST" => block.wavelengths_nm = Some(ascending(&lines, value, name, 1.0..=1e6, false)?),
            "REDUCTION_TYPE" => {
                for word in value.split_whitespace() {
                    match word_of(&lines, word, &["bilateral_symmetry", "reciprocity", "none"])? {
                        "bilateral_symmetry" => block.reduction.0 = true,
                        "reciprocity" => block.reduction.1 = true,
                        _ => {}
                    }
                }
            }
            "SOURCE_TYPE" => block.source = Some(value.to_owned()),
            "SOFTWARE" | "API" | "DATE" | "NAME" | "DEVICE" | "CREATION_DATE" | "MEASUREMENT_DATE" => {
                provenance.statements.push((name.into(), value.into()));
            }
            "DATA" => {
                let Some(kind) = block.data_type.filter(|_| open) else {
                    let remedy = "begin each block with its properties, from DATA_TYPE on";
                    return Err(lines.error("DATA_TYPE before DATA", quoted(line), remedy));
                };
                provenance.source = provenance.source.or(block.source.clone());
                components.push(component(&mut lines, kind, &block, value, &mut warnings)?);
                open = false;
            }
            _ => return Err(lines.error("a property of SSDD, or DATA", quoted(name), remedy::PROPERTY)),
        }
    }
    if open || components.is_empty() {
        let expected = "a block of data, from DATA_TYPE to DATA";
        return Err(lines.error(expected, "the end of the file", remedy::CUT_SHORT));
    }
    Ok(Goniometric {
        format: FORMAT.format,
        provenance,
        components,
        warnings,
    })
}

fn component(
    lines: &mut Lines,
    kind: &str,
    block: &Block,
    encoding: &str,
    warnings: &mut Vec<ReadNotice>,
) -> Result<Component, FormatError> {
    let missing = |name: &str| {
        let remedy = format!("add a line {name} to the properties of the block");
        lines.error(format!("{name} before DATA in the block '{kind}'"), "none", remedy)
    };
    let channels = match block.colour_model.ok_or_else(|| missing("COLOR_MODEL"))? {
        "monochrome" => ChannelSet::Monochrome,
        "rgb" => ChannelSet::Rgb,
        "xyz" => ChannelSet::Xyz,
        _ => {
            let nm = block.wavelengths_nm.clone().ok_or_else(|| missing("WAVELENGTH_LIST"))?;
            let grid = WavelengthGrid::new(nm);
            ChannelSet::Wavelengths(
                grid.map_err(|e| lines.error("WAVELENGTH_LIST", e.to_string(), remedy::WAVELENGTHS))?,
            )
        }
    };
    let specular = kind.starts_with("specular");
    let required = |index: usize| {
        block.lists_deg[index]
            .clone()
            .ok_or_else(|| missing(&format!("PARAM{index}_LIST")))
    };
    let lists = [
        required(0)?,
        block.lists_deg[1].clone().unwrap_or_else(|| vec![0.0]),
        if specular { vec![0.0] } else { required(2)? },
        if specular { vec![0.0] } else { required(3)? },
    ];
    let parameter_type = block.parameter_type.unwrap_or("");
    let highest = [
        90.0,
        360.0,
        if parameter_type.starts_with("specular") {
            180.0
        } else {
            90.0
        },
        360.0,
    ];
    for (index, (list, highest)) in lists.iter().zip(highest).enumerate() {
        if let Some(beyond) = list.iter().find(|&&angle| angle > highest) {
            let expected = format!("angles of at most {highest} degrees in PARAM{index}_LIST");
            let remedy = "check the PARAM_TYPE and that the angles are in degrees";
            return Err(lines.error(expected, shown(*beyond), remedy));
        }
    }
    let nodes = lists
        .iter()
        .try_fold(channels.count(), |product, list| product.checked_mul(list.len()));
    let count = nodes.ok_or_else(|| lines.error("a number of values that can be counted", "more", remedy::LISTS))?;
    let range = if specular { 0.0..=1.0 } else { FINITE };
    let values = values(lines, encoding, count, channels.count(), &range, warnings)?;
    let scatter = if matches!(kind, "brdf" | "specular_reflectance") {
        Scatter::Reflection
    } else {
        Scatter::Transmission
    };
    let [p0, p1, p2, p3] = lists;
    let azimuth = Axis::azimuth(radians(&p1), TAU);
    let (quantity, table) = if specular {
        let table = SpecularTable::new(Axis::bounded(radians(&p0)), azimuth, channels.count(), values);
        (Quantity::Fraction, Table::Specular(table))
    } else {
        let offsets = match &block.lists_deg[4] {
            Some(list) if list.len() != p0.len() => {
                let expected = format!("{} offsets in PARAM4_LIST, one a PARAM0", p0.len());
                let remedy = "give an offset for each angle of PARAM0_LIST, or leave PARAM4_LIST out";
                return Err(lines.error(expected, list.len().to_string(), remedy));
            }
            Some(list) => radians(list),
            None => vec![0.0; p0.len()],
        };
        let parameters = match parameter_type {
            "spherical_coordinate_system" => Parameters::Spherical,
            "specular_coordinate_system" => Parameters::Specular { offsets_rad: offsets },
            "half_difference_coordinate_system" => Parameters::HalfDifference,
            "distorted_spherical_coordinate_system" => Parameters::Distorted { offsets_rad: offsets },
            _ => {
                let expected = format!("PARAM_TYPE before DATA in the block '{kind}'");
                return Err(lines.error(expected, "none", "add a line PARAM_TYPE to the properties of the block"));
            }
        };
        let (fold, last) = match block.reduction {
            (false, false) => (Fold::None, 360.0),
            (true, false) => (Fold::Mirror, 180.0),
            (false, true) => (Fold::HalfTurn, 180.0),
            (true, true) => (Fold::MirrorAndHalfTurn, 90.0),
        };
        if block.reduction.1 && parameters != Parameters::HalfDifference {
            let remedy = "give all azimuths and leave the word out of REDUCTION_TYPE";
            return Err(lines.error(
                "reciprocity with half-difference parameters alone",
                parameter_type,
                remedy,
            ));
        }
        if fold != Fold::None && (p3[0], p3[p3.len() - 1]) != (0.0, last) {
            let found = format!("{} to {}", p3[0], p3[p3.len() - 1]);
            let expected = format!("PARAM3_LIST from 0 to {last} with this REDUCTION_TYPE");
            let remedy = "give these azimuths, or write REDUCTION_TYPE none and all of the circle";
            return Err(lines.error(expected, found, remedy));
        }
        let around = match fold {
            Fold::None => Axis::azimuth(radians(&p3), TAU),
            _ => Axis::bounded(radians(&p3)),
        };
        let axes = [
            Axis::bounded(radians(&p0)),
            azimuth,
            Axis::bounded(radians(&p2)),
            around,
        ];
        let grid = Grid::new(parameters, axes, fold, channels.count(), [3, 2, 1, 0, 4], values);
        (Quantity::Bsdf, Table::Grid(grid))
    };
    Ok(Component {
        scatter,
        side: Side::Front,
        quantity,
        channels,
        table,
    })
}

/// The data of a block: a node a line in text; 32-bit little-endian, without a length, in binary.
fn values(
    lines: &mut Lines,
    encoding: &str,
    count: usize,
    channels: usize,
    range: &RangeInclusive<f64>,
    warnings: &mut Vec<ReadNotice>,
) -> Result<Vec<f64>, FormatError> {
    let expected = match range {
        range if *range == FINITE => "values, finite, 0 or more".to_owned(),
        range => format!("values from {} to {}", range.start(), range.end()),
    };
    let mut readings = Readings::default();
    let rest = lines.bytes.len() - lines.position;
    match encoding {
        "binary" => {
            let size = count.checked_mul(4).filter(|&size| size <= rest).ok_or_else(|| {
                let promised = format!("{count} binary values of 4 bytes, as the lists say");
                FormatError::byte(
                    lines.path,
                    lines.position,
                    promised,
                    format!("{rest} bytes to the end of the file"),
                    remedy::LISTS_OR_CUT,
                )
            })?;
            let stored = lines.bytes[lines.position..lines.position + size]
                .chunks_exact(4)
                .map(|bytes| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])));
            if is_implausible(stored.clone()) {
                return Err(swapped(lines.path, lines.position));
            }
            let mut values = Vec::with_capacity(count);
            for (index, value) in stored.enumerate() {
                let at = lines.position + 4 * index;
                if !(value.is_finite() && range.contains(&value)) {
                    let found = format!("{value:?}");
                    return Err(FormatError::byte(lines.path, at, expected, found, remedy::DAMAGED));
                }
                readings.take(value, at);
                values.push(value);
            }
            lines.position += size;
            match readings.judged() {
                Ok(doubt) => warnings.extend(doubt.map(ReadNotice::from)),
                Err((at, [expected, found, remedy])) => {
                    return Err(FormatError::byte(lines.path, at, expected, found, remedy));
                }
            }
            Ok(values)
        }
        "ascii" => {
            if count > rest.div_ceil(2) {
                let found = format!("room for {} at most in the rest of the file", rest.div_ceil(2));
                let expected = format!("{count} values, as the lists say");
                return Err(lines.error(expected, found, remedy::LISTS_OR_CUT));
            }
            let mut values = Vec::with_capacity(count);
            while values.len() < count {
                let promised = || format!("{count} values, {channels} a line, as the lists say");
                let line = lines.next()?;
                let line =
                    line.ok_or_else(|| lines.error(promised(), format!("{}", values.len()), remedy::LISTS_OR_CUT))?;
                let before = values.len();
                for word in line.split_whitespace() {
                    let value = finite(word, range)
                        .ok_or_else(|| lines.error(expected.as_str(), quoted(word), remedy_for(word, range)))?;
                    readings.take(value, lines.number);
                    values.push(value);
                }
                if values.len() != before + channels {
                    let found = format!("{}", values.len() - before);
                    let remedy = "write the channels of one pair of directions in a line, as COLOR_MODEL has them";
                    return Err(lines.error(format!("{channels} values in a line"), found, remedy));
                }
            }
            match readings.judged() {
                Ok(doubt) => warnings.extend(doubt.map(ReadNotice::from)),
                Err((line, [expected, found, remedy])) => {
                    let place = Location::Row { line, column: None };
                    return Err(FormatError::at(lines.path, place, expected, found, remedy));
                }
            }
            Ok(values)
        }
        _ => {
            let remedy = "write how the values behind the line are stored";
            Err(lines.error("DATA ascii or DATA binary", quoted(encoding), remedy))
        }
    }
}
