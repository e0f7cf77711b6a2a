//! Zemax (Radiant) and LightTools tabular BSDFs: words and numbers, `#` begins a comment. Values are f in 1/sr.

use std::f64::consts::TAU;

use crate::formats::descriptor::{Descriptor, FormatReader, USUAL_SIZES};
use crate::formats::error::{FormatError, remedy};
use crate::formats::text::{NOT_NEGATIVE, Readings, Text, Tokens};
use crate::goniometric::{
    Axis, ChannelSet, Component, FileProvenance, Fold, Format, Goniometric, Grid, Parameters, Quantity, ReadNotice,
    Scatter, Side, Table, radians,
};

pub(super) const ZEMAX: Descriptor = Descriptor {
    format: Format::new("zemax"),
    words: "zemax",
    extensions: &[("bsdf", None)],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| beginning.word("angleofincidence"),
    read: FormatReader::Goniometric(|input| input.text(read_zemax)),
    write: None,
};

pub(super) const LIGHT_TOOLS: Descriptor = Descriptor {
    format: Format::new("lighttools"),
    words: "lighttools",
    extensions: &[("bsdf", None)],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| beginning.word("aoi"),
    read: FormatReader::Goniometric(|input| input.text(read_lighttools)),
    write: None,
};

fn list(tokens: &mut Tokens, keyword: &str, high: f64) -> Result<Vec<f64>, FormatError> {
    tokens.keyword(keyword)?;
    let count = tokens.count(&format!("angles {keyword}"))?;
    tokens.angles_deg(count, &format!("angles {keyword}"), 0.0..=high)
}

/// The word after a key word; any of some, in any case.
fn choice<'w>(tokens: &mut Tokens, keyword: &str, words: &[&'w str]) -> Result<&'w str, FormatError> {
    tokens.keyword(keyword)?;
    let expected = format!("{keyword} {}", words.join(" or "));
    let token = tokens.expect(&expected)?;
    let known = words.iter().find(|word| token.is(word));
    known
        .copied()
        .ok_or_else(|| tokens.unexpected(&token, expected, remedy::SPELLING))
}

fn provenance(tokens: &Tokens, source: &str) -> FileProvenance {
    FileProvenance {
        source: Some(source.into()),
        statements: Vec::new(),
        comments: tokens.comments().iter().map(|&c| c.to_owned()).collect(),
    }
}

fn scatter(word: &str) -> Scatter {
    if word == "BRDF" {
        Scatter::Reflection
    } else {
        Scatter::Transmission
    }
}

/// The total integrated scatter of a block, as the file states it. The values are taken as they stand.
fn total(tokens: &mut Tokens) -> Result<f64, FormatError> {
    tokens.keyword("TIS")?;
    tokens.number("the total integrated scatter, a fraction, 0 or more", &NOT_NEGATIVE)
}

/// Angles about the mirror direction, or of transmission the straight one, as in Integra's files.
fn read_zemax(text: Text) -> Result<Goniometric, FormatError> {
    let mut tokens = Tokens::new(text, "#");
    let source = choice(&mut tokens, "Source", &["Measured", "Generated"])?;
    let symmetries = ["PlaneSymmetrical", "Asymmetrical", "Asymmetrical4D"];
    let symmetry = choice(&mut tokens, "Symmetry", &symmetries)?;
    let content = choice(&mut tokens, "SpectralContent", &["Monochrome", "XYZ"])?;
    let scatter = scatter(choice(&mut tokens, "ScatterType", &["BRDF", "BTDF"])?);
    let rotation = list(&mut tokens, "SampleRotation", 360.0)?;
    let incidence = list(&mut tokens, "AngleOfIncidence", 90.0)?;
    let azimuth = list(&mut tokens, "ScatterAzimuth", 360.0)?;
    let radial = list(&mut tokens, "ScatterRadial", 180.0)?;
    let fold = if symmetry == "PlaneSymmetrical" {
        Fold::Mirror
    } else {
        Fold::None
    };
    let ends = if fold == Fold::Mirror {
        [0.0, 180.0]
    } else {
        [0.0, 360.0]
    };
    if [azimuth[0], azimuth[azimuth.len() - 1]] != ends {
        let expected = format!("angles ScatterAzimuth from {} to {} of {symmetry}", ends[0], ends[1]);
        let found = format!("{} to {}", azimuth[0], azimuth[azimuth.len() - 1]);
        let remedy =
            "repeat the values of the first azimuth at the last one, or state the Symmetry that these angles have";
        return Err(FormatError::file(text.path, expected, found, remedy));
    }
    let blocks: &[&str] = match content {
        "XYZ" => &["TristimulusX", "TristimulusY", "TristimulusZ"],
        _ => &["Monochrome"],
    };
    let table = azimuth.len() * radial.len();
    let mut values = Vec::new();
    let mut totals = Vec::new();
    let mut readings = Readings::default();
    let mut warnings = Vec::new();
    for block in blocks {
        tokens.keyword(block)?;
        tokens.keyword("DataBegin")?;
        for _ in 0..rotation.len() * incidence.len() {
            totals.push(total(&mut tokens)?);
            let expected = format!("{table} values, 1/sr, 0 or more");
            tokens.readings(table, &expected, &mut readings, &mut values)?;
        }
        tokens.keyword("DataEnd")?;
    }
    if let Some(token) = tokens.next() {
        return Err(tokens.unexpected(&token, "the end of the file after DataEnd", remedy::MORE_BEHIND));
    }
    text.judge(&readings, &mut warnings)?;
    let around = match fold {
        Fold::Mirror => Axis::bounded(radians(&azimuth)),
        _ => Axis::azimuth(radians(&azimuth), TAU),
    };
    let parameters = Parameters::Specular {
        offsets_rad: vec![0.0; incidence.len()],
    };
    let axes = [
        Axis::bounded(radians(&incidence)),
        Axis::azimuth(radians(&rotation), TAU),
        Axis::bounded(radians(&radial)),
        around,
    ];
    let component = Component {
        scatter,
        side: Side::Front,
        quantity: Quantity::Bsdf,
        channels: if blocks.len() == 3 {
            ChannelSet::Xyz
        } else {
            ChannelSet::Monochrome
        },
        table: Table::Grid(Grid::new(parameters, axes, fold, blocks.len(), [4, 1, 0, 3, 2], values)),
    };
    let mut provenance = provenance(&tokens, source);
    let stated: Vec<String> = totals.iter().map(f64::to_string).collect();
    provenance.statements.push(("TIS".into(), stated.join(" ")));
    Ok(Goniometric {
        format: ZEMAX.format,
        provenance,
        components: vec![component],
        warnings,
    })
}

/// One block of a LightTools file.
struct Block {
    incidence: f64,
    side: Side,
    scatter: Scatter,
    wavelength_nm: f64,
    tristimulus: Option<usize>,
    values: Vec<f64>,
}

/// Outgoing directions in plain spherical coordinates; light comes from azimuth 90°.
fn read_lighttools(text: Text) -> Result<Goniometric, FormatError> {
    let mut tokens = Tokens::new(text, "#");
    let source = choice(&mut tokens, "Source", &["Measured", "Generated"])?;
    let symmetry = choice(
        &mut tokens,
        "Symmetry",
        &["PlaneSymmetrical", "Asymmetric", "Asymmetrical"],
    )?;
    let content = choice(&mut tokens, "SpectralContent", &["Monochrome", "XYZ"])?;
    let azimuth = list(&mut tokens, "ScatterAzimuth", 360.0)?;
    let radial = list(&mut tokens, "ScatterRadial", 90.0)?;
    tokens.keyword("DataBegin")?;
    let mut warnings = Vec::new();
    let mut blocks: Vec<Block> = Vec::new();
    let mut readings = Readings::default();
    loop {
        let token = tokens.expect("'AOI' or 'DataEnd'")?;
        if token.is("DataEnd") {
            break;
        }
        if !token.is("AOI") {
            return Err(tokens.unexpected(&token, "'AOI' or 'DataEnd'", remedy::SPELLING_OR_COUNT));
        }
        let incidence = tokens.number("an angle of incidence in degrees, 0..90", &(0.0..=90.0))?;
        tokens.keyword("POI")?;
        tokens.number("the azimuth of the plane of incidence in degrees", &(-360.0..=360.0))?;
        let side = match choice(&mut tokens, "Side", &["Front", "Back"])? {
            "Front" => Side::Front,
            _ => Side::Back,
        };
        tokens.keyword("Wavelength")?;
        let wavelength_nm = tokens.number("a wavelength in nm", &(1.0..=1e6))?;
        let scatter = scatter(choice(&mut tokens, "ScatterType", &["BRDF", "BTDF"])?);
        let tristimulus = if content == "XYZ" {
            let names = ["TrisX", "TrisY", "TrisZ"];
            let name = choice(&mut tokens, "TristimulusValue", &names)?;
            names.iter().position(|n| *n == name)
        } else {
            None
        };
        total(&mut tokens)?;
        let mut values = Vec::new();
        let count = azimuth.len() * radial.len();
        let expected = format!("{count} values, 1/sr, 0 or more");
        tokens.readings(count, &expected, &mut readings, &mut values)?;
        blocks.push(Block {
            incidence,
            side,
            scatter,
            wavelength_nm,
            tristimulus,
            values,
        });
    }
    if let Some(token) = tokens.next() {
        return Err(tokens.unexpected(&token, "the end of the file after DataEnd", remedy::MORE_BEHIND));
    }
    text.judge(&readings, &mut warnings)?;
    let mut components = Vec::new();
    for (side, scatter) in [Side::Front, Side::Back]
        .into_iter()
        .flat_map(|side| [(side, Scatter::Reflection), (side, Scatter::Transmission)])
    {
        let mut chosen: Vec<&Block> = blocks
            .iter()
            .filter(|b| (b.side, b.scatter) == (side, scatter))
            .collect();
        if let Some(first) = chosen.first() {
            let nm = first.wavelength_nm;
            if let Some(other) = chosen.iter().find(|b| b.wavelength_nm != nm) {
                let expected = format!("blocks of one wavelength, {nm} nm as in the first");
                return Err(FormatError::file(
                    text.path,
                    expected,
                    format!("{} nm", other.wavelength_nm),
                    "write a file for each wavelength",
                ));
            }
            chosen.sort_by(|a, b| {
                a.incidence
                    .total_cmp(&b.incidence)
                    .then(a.tristimulus.cmp(&b.tristimulus))
            });
            components.push(component(
                text,
                side,
                scatter,
                content == "XYZ",
                &chosen,
                &azimuth,
                &radial,
            )?);
        }
    }
    if components.is_empty() {
        let remedy = "the file was exported without data: export it again";
        return Err(FormatError::file(text.path, "at least one block AOI", "none", remedy));
    }
    if symmetry == "PlaneSymmetrical" {
        warnings.push(ReadNotice::AzimuthsNotFilled);
    }
    if blocks.iter().any(|b| b.side == Side::Back) {
        warnings.push(ReadNotice::BackAsFront);
    }
    Ok(Goniometric {
        format: LIGHT_TOOLS.format,
        provenance: provenance(&tokens, source),
        components,
        warnings,
    })
}

fn component(
    text: Text,
    side: Side,
    scatter: Scatter,
    xyz: bool,
    blocks: &[&Block],
    azimuth_deg: &[f64],
    radial_deg: &[f64],
) -> Result<Component, FormatError> {
    let channels = if xyz { 3 } else { 1 };
    let mut incidences = Vec::new();
    let mut values = Vec::new();
    for group in blocks.chunk_by(|a, b| a.incidence == b.incidence) {
        if group.len() != channels || (xyz && !group.iter().enumerate().all(|(i, b)| b.tristimulus == Some(i))) {
            let expected = if xyz {
                "one block each of TrisX, TrisY, TrisZ"
            } else {
                "one block"
            };
            let expected = format!("{expected} at incidence {} degrees", group[0].incidence);
            return Err(FormatError::file(
                text.path,
                expected,
                format!("{} blocks", group.len()),
                "remove the blocks that are there twice, or add those that are missing",
            ));
        }
        incidences.push(group[0].incidence);
        group.iter().for_each(|block| values.extend_from_slice(&block.values));
    }
    // From the light's azimuth instead of from 90 degrees before it; the circle must begin with its first azimuth.
    let relative: Vec<f64> = azimuth_deg.iter().map(|phi| (phi - 90.0).to_radians()).collect();
    let axes = [
        Axis::bounded(radians(&incidences)),
        Axis::azimuth(vec![0.0], TAU),
        Axis::bounded(radians(radial_deg)),
        Axis::azimuth(relative, TAU),
    ];
    Ok(Component {
        scatter,
        side,
        quantity: Quantity::Bsdf,
        channels: if xyz { ChannelSet::Xyz } else { ChannelSet::Monochrome },
        table: Table::Grid(Grid::new(
            Parameters::Spherical,
            axes,
            Fold::None,
            channels,
            [0, 4, 1, 3, 2],
            values,
        )),
    })
}
