//! Integra's `.ddr`, `.ddt` (diffuse) and `.sdr`, `.sdt` (specular): words separated by white space, `;;` begins a
//! comment. Reflection and transmission differ by the file's name alone.
//!
//! Diffuse values are k v with k of the `kbdf` list: π f (`Luminance`) or f cos θ_out (`Intensity`, kept as f).
//! `Relative` tables are scaled so that the directional-hemispherical reflectance of each incidence and channel is k.

mod header;

use std::f64::consts::TAU;

use self::header::{BLOCK, ColourHeader, Header, header};

use crate::formats::descriptor::{Beginning, Descriptor, FormatReader, FormatWriter, Holds, Mark, USUAL_SIZES};
use crate::formats::error::{FormatError, remedy};
use crate::formats::options::ReadOptions;
use crate::formats::text::{NOT_NEGATIVE, Readings, Text, Token, Tokens, finite, quoted};
use crate::formats::write::integra as write;
use crate::goniometric::{
    Axis, ChannelSet, Component, FileProvenance, Fold, Format, Goniometric, Grid, Parameters, Quantity, ReadNotice,
    Scatter, Side, SpecularTable, Table, divide_by_cosine, radians,
};
use crate::spectrum::WavelengthGrid;

pub(super) const DIFFUSE: Descriptor = Descriptor {
    format: Format::new("ddr"),
    words: "ddr, ddt",
    extensions: &[("ddr", Some(Scatter::Reflection)), ("ddt", Some(Scatter::Transmission))],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| told(beginning, TableKind::Diffuse),
    read: FormatReader::Goniometric(|input| input.text(|text| read_diffuse(text, input.options))),
    write: Some(FormatWriter {
        holds: Holds::Scattering,
        errors: false,
        variant: None,
        write: write::diffuse,
    }),
};

pub(super) const SPECULAR: Descriptor = Descriptor {
    format: Format::new("sdr"),
    words: "sdr, sdt",
    extensions: &[("sdr", Some(Scatter::Reflection)), ("sdt", Some(Scatter::Transmission))],
    sizes: USUAL_SIZES,
    convention: None,
    detect: |beginning| told(beginning, TableKind::Specular),
    read: FormatReader::Goniometric(|input| input.text(|text| read_specular(text, input.options))),
    write: Some(FormatWriter {
        holds: Holds::Fractions,
        errors: false,
        variant: None,
        write: write::specular,
    }),
};

#[derive(Clone, Copy, PartialEq)]
enum TableKind {
    Diffuse,
    Specular,
}

/// Whether it is of this kind: by the lists and statements before the first `def`.
fn told(beginning: &Beginning, kind: TableKind) -> Option<Mark> {
    let mut found = None;
    for (mark, word) in beginning.words() {
        match word.as_str() {
            "phi" | "theta" | "typesym" | "typedata" => found = Some(TableKind::Diffuse),
            "typecolormodel" | "sigma" => found = found.or(Some(TableKind::Specular)),
            "def" if found.is_some() => return (found == Some(kind)).then_some(mark),
            _ => {}
        }
    }
    (found == Some(kind)).then_some(Mark::Likely)
}

fn read_diffuse(text: Text, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let mut tokens = Tokens::new(text, ";;");
    let mut header = header(&mut tokens, true)?;
    let scatter = scatter_of(text.path, "ddr", "ddt", options, &mut header.warnings);
    let phi_deg = header.phi_deg.clone().unwrap_or_else(|| vec![0.0]);
    check_phi(text, &header, &phi_deg)?;
    let colour = colour(&mut tokens, &header)?;
    let psi_deg = header.psi_deg.clone().unwrap_or_else(|| vec![0.0]);
    let tables = psi_deg.len() * header.sigma_deg.len();
    let table = phi_deg.len() * header.theta_deg.len();
    let count = tables.checked_mul(table).and_then(|n| n.checked_mul(colour.blocks()));
    let count = count.ok_or_else(|| {
        let expected = "a number of values that can be counted";
        text.error(header.data.at, expected, "more", remedy::LISTS)
    })?;
    tokens.room_for(count, "values", header.data.at)?;
    let mut values = Vec::with_capacity(count);
    let mut factors = Vec::new();
    let mut readings = Readings::default();
    let channels = blocks(&mut tokens, header.data, colour, |tokens, channel| {
        let k = factors_of(tokens, tables)?;
        let expected = format!("{} values, finite, 0 or more, in this block", tables * table);
        tokens.readings(tables * table, &expected, &mut readings, &mut values)?;
        let block = channel * tables * table;
        if let (Some(k), false) = (&k, header.relative) {
            for (rows, k) in values[block..].chunks_mut(table).zip(k) {
                rows.iter_mut().for_each(|v| *v *= k);
            }
        }
        factors.push(k);
        Ok(())
    })?;
    text.judge(&readings, &mut header.warnings)?;
    let theta = Axis::bounded(radians(&header.theta_deg));
    let sigma = Axis::bounded(radians(&header.sigma_deg));
    let psi = Axis::azimuth(radians(&psi_deg), TAU);
    let phi = match (header.rotational, header.fold) {
        (true, _) => Axis::azimuth(vec![0.0], TAU),
        (_, Fold::Mirror) => Axis::bounded(radians(&phi_deg)),
        _ => Axis::azimuth(radians(&phi_deg), TAU),
    };
    if header.rotational && phi_deg.len() > 1 {
        return Err(text.error(
            header.data.at,
            "one phi in an AxiSymmetrical file",
            format!("{}", phi_deg.len()),
            "state another TypeSym, such as ASymmetrical, or one phi",
        ));
    }
    let offsets_rad = match &header.sigmat_deg {
        Some(sigmat) => sigmat
            .iter()
            .zip(&header.sigma_deg)
            .map(|(t, s)| (t - s).to_radians())
            .collect(),
        None => vec![0.0; header.sigma_deg.len()],
    };
    let order = [4, 1, 0, 3, 2];
    let parameters = Parameters::Specular { offsets_rad };
    let mut grid = Grid::new(
        parameters,
        [sigma, psi, theta, phi],
        header.fold,
        colour.blocks(),
        order,
        values,
    );
    if header.quantity == Quantity::BsdfCosine {
        let held = divide_by_cosine(&mut grid);
        header.quantity = Quantity::Bsdf;
        if held > 0 {
            header.warnings.push(ReadNotice::NodesAtHorizon {
                held,
                nodes: tables * table,
            });
        }
    }
    let mut component = Component {
        scatter,
        side: Side::Front,
        quantity: header.quantity,
        channels,
        table: Table::Grid(grid),
    };
    if header.relative && factors.iter().any(Option::is_some) {
        let wanted: Vec<Option<&[f64]>> = factors.iter().map(Option::as_deref).collect();
        make_absolute(text, &mut component, &psi_deg, &header, &wanted)?;
    } else if header.relative {
        header.warnings.push(ReadNotice::NoScale);
        component.quantity = Quantity::Unscaled;
    }
    Ok(Goniometric {
        format: DIFFUSE.format,
        provenance: provenance(header.source, &tokens),
        components: vec![component],
        warnings: header.warnings,
    })
}

/// Scales each incidence and channel so that its directional-hemispherical reflectance is the stated one.
fn make_absolute(
    text: Text,
    component: &mut Component,
    psi_deg: &[f64],
    header: &Header,
    wanted: &[Option<&[f64]>],
) -> Result<(), FormatError> {
    let sigma_count = header.sigma_deg.len();
    for (p, psi) in psi_deg.iter().enumerate() {
        for (s, sigma) in header.sigma_deg.iter().enumerate() {
            let found = component.integrated(sigma.to_radians(), psi.to_radians());
            for (channel, wanted) in wanted.iter().enumerate() {
                let Some(k) = wanted.map(|k| k[p * sigma_count + s]) else {
                    continue;
                };
                let reflectance = found.as_ref().map_or(0.0, |found| found.values[channel]);
                let by = if k == 0.0 { 0.0 } else { k / reflectance };
                if !by.is_finite() {
                    let expected = format!("a table that can be scaled to the reflectance {k}");
                    let found = format!("one of reflectance {reflectance} at psi {psi}, sigma {sigma}");
                    let remedy = "give values above 0 at this incidence, or take the table as Absolute";
                    return Err(text.error(header.data.at, expected, found, remedy));
                }
                if let Table::Grid(grid) = &mut component.table {
                    grid.scale([s, p], channel, by);
                }
            }
        }
    }
    Ok(())
}

fn read_specular(text: Text, options: &ReadOptions) -> Result<Goniometric, FormatError> {
    let mut tokens = Tokens::new(text, ";;");
    let mut header = header(&mut tokens, false)?;
    let scatter = scatter_of(text.path, "sdr", "sdt", options, &mut header.warnings);
    let colour = colour(&mut tokens, &header)?;
    let nodes = header.sigma_deg.len();
    let mut by_channel = Vec::new();
    let channels = blocks(&mut tokens, header.data, colour, |tokens, _| {
        tokens.keyword("def")?;
        tokens.numbers(
            nodes,
            &format!("{nodes} fractions, 0..1"),
            &(0.0..=1.0),
            &mut by_channel,
        )
    })?;
    let count = colour.blocks();
    let values = (0..nodes)
        .flat_map(|node| (0..count).map(move |c| c * nodes + node))
        .map(|i| by_channel[i]);
    let incidence = Axis::bounded(radians(&header.sigma_deg));
    let table = SpecularTable::new(incidence, Axis::azimuth(vec![0.0], TAU), count, values.collect());
    Ok(Goniometric {
        format: SPECULAR.format,
        provenance: provenance(header.source, &tokens),
        components: vec![Component {
            scatter,
            side: Side::Front,
            quantity: Quantity::Fraction,
            channels,
            table: Table::Specular(table),
        }],
        warnings: header.warnings,
    })
}

fn check_phi(text: Text, header: &Header, phi_deg: &[f64]) -> Result<(), FormatError> {
    let ends = [phi_deg[0], phi_deg[phi_deg.len() - 1]];
    let expected = match header.fold {
        _ if header.rotational => return Ok(()),
        Fold::Mirror => [0.0, 180.0],
        _ => [0.0, 360.0],
    };
    if ends == expected {
        return Ok(());
    }
    let words = format!("angles phi from {} to {} with this TypeSym", expected[0], expected[1]);
    let remedy = "repeat the values of the first azimuth at the last one, or state the TypeSym that these angles have";
    Err(text.error(header.data.at, words, format!("{} to {}", ends[0], ends[1]), remedy))
}

fn colour(tokens: &mut Tokens, header: &Header) -> Result<ColourHeader, FormatError> {
    match header.colour {
        Some(colour) => Ok(colour),
        None if header.data.is("bw") => Ok(ColourHeader::Bw),
        None if header.data.is("red") => Ok(ColourHeader::Rgb),
        None => {
            let remedy = "write 'TypeColorModel spectral N' with the number N of wavelengths into the header";
            Err(tokens.unexpected(&header.data, "TypeColorModel in the header", remedy))
        }
    }
}

/// All blocks of data, `first` being the first word of the first one; their channels by their words.
fn blocks<'a>(
    tokens: &mut Tokens<'a>,
    first: Token<'a>,
    colour: ColourHeader,
    mut content: impl FnMut(&mut Tokens<'a>, usize) -> Result<(), FormatError>,
) -> Result<ChannelSet, FormatError> {
    let mut wavelengths: Vec<f64> = Vec::new();
    let mut token = first;
    for channel in 0..colour.blocks() {
        if channel > 0 {
            token = tokens.expect(BLOCK)?;
        }
        let words: &[&str] = match (colour, channel) {
            (ColourHeader::Bw, _) => &["bw"],
            (ColourHeader::Rgb, 0) => &["red"],
            (ColourHeader::Rgb, 1) => &["gre", "green"],
            (ColourHeader::Rgb, _) => &["blu", "blue"],
            (ColourHeader::Spectral(_), _) => &["wl"],
        };
        if !words.iter().any(|word| token.is(word)) {
            let remedy = "write the blocks in the order of TypeColorModel, one for each of its channels";
            return Err(tokens.unexpected(&token, format!("the block '{}'", words[0]), remedy));
        }
        if let ColourHeader::Spectral(_) = colour {
            let above = wavelengths.last().copied().unwrap_or(0.0);
            let expected = format!("a wavelength in nm above {above}");
            let token = tokens.expect(&expected)?;
            let nm = finite(token.word, &(0.0..=1e6)).filter(|nm| *nm > above);
            wavelengths.push(nm.ok_or_else(|| tokens.unexpected(&token, expected, remedy::WAVELENGTHS))?);
        }
        content(tokens, channel)?;
        tokens.keyword("enddef")?;
    }
    if let Some(token) = tokens.next() {
        let expected = format!("the end of the file after {} blocks", colour.blocks());
        return Err(tokens.unexpected(&token, expected, remedy::MORE_BEHIND));
    }
    Ok(match colour {
        ColourHeader::Bw => ChannelSet::Monochrome,
        ColourHeader::Rgb => ChannelSet::Rgb,
        ColourHeader::Spectral(_) => {
            let grid = WavelengthGrid::new(wavelengths);
            ChannelSet::Wavelengths(grid.map_err(|e| {
                FormatError::file(tokens.source.path, "wavelengths", e.to_string(), remedy::WAVELENGTHS)
            })?)
        }
    })
}

fn factors_of(tokens: &mut Tokens, count: usize) -> Result<Option<Vec<f64>>, FormatError> {
    let token = tokens.expect("'kbdf' or 'def'")?;
    if token.is("def") {
        return Ok(None);
    }
    if !token.is("kbdf") {
        return Err(tokens.unexpected(&token, "'kbdf' or 'def'", remedy::SPELLING));
    }
    let mut factors = Vec::new();
    let expected = format!("{count} factors, one a psi and sigma, finite, 0 or more");
    tokens.numbers(count, &expected, &NOT_NEGATIVE, &mut factors)?;
    tokens.keyword("def")?;
    Ok(Some(factors))
}

/// The two kinds have the same content; only the name, or the user, can say which it is.
pub(super) fn scatter_of(
    path: &str,
    reflection: &str,
    transmission: &str,
    options: &ReadOptions,
    warnings: &mut Vec<ReadNotice>,
) -> Scatter {
    let ends = |extension: &str| path.to_ascii_lowercase().ends_with(&format!(".{extension}"));
    match options.scatter {
        Some(scatter) => scatter,
        None if ends(transmission) => Scatter::Transmission,
        None => {
            if !ends(reflection) {
                warnings.push(ReadNotice::ReflectionAssumed { file: quoted(path) });
            }
            Scatter::Reflection
        }
    }
}

fn provenance(source: Option<String>, tokens: &Tokens) -> FileProvenance {
    // "Psi = 0" and "Sigma = 20" number the rows.
    let says = |words: &&&str| !words.starts_with("Psi =") && !words.starts_with("Sigma =");
    FileProvenance {
        source,
        statements: Vec::new(),
        comments: tokens.comments().iter().filter(says).map(|&c| c.to_owned()).collect(),
    }
}
