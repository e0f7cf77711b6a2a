//! BSDF files of Radiance and WINDOW: an XML envelope around Klems matrices or tensor trees. Values are f in 1/sr.
//!
//! `Reflection Back` and `Transmission Back` have their light on +z, `Front` on −z.

mod tree;
mod xml;

use roxmltree::{Document, Node as Element, ParsingOptions};

use self::tree::tree;
use self::xml::{AnySpace, Xml, child, words};
use crate::formats::descriptor::{Beginning, Descriptor, FormatReader, FormatWriter, Holds, Mark, USUAL_SIZES};
use crate::formats::error::{FormatError, Location, remedy};
use crate::formats::text::{FINITE, Readings, Text, finite, quoted, remedy_for};
use crate::formats::write::radiance as write;
use crate::goniometric::{
    ChannelSet, Component, FileProvenance, Format, Goniometric, KlemsBasis, KlemsMatrix, Quantity, ReadNotice, Scatter,
    Side, Table, TensorTree,
};
use crate::number::shown;

pub(super) const FORMAT: Descriptor = Descriptor {
    format: Format::new("klems"),
    words: "radiance xml",
    extensions: &[("xml", None)],
    sizes: USUAL_SIZES,
    convention: Some(
        "the front is +z, as in Radiance; WINDOW calls that side Back, so that `Reflection Back` has its light on it. \
         Incident patches are those of the opposite azimuth: directions point away from the surface here, and the \
         light's run towards it in WINDOW",
    ),
    detect: told,
    read: FormatReader::Goniometric(|input| input.text(read)),
    write: Some(FormatWriter {
        holds: Holds::Sides,
        errors: false,
        variant: None,
        write: write::write,
    }),
};

fn told(beginning: &Beginning) -> Option<Mark> {
    let text = &beginning.text;
    // Programs may print a line or two before the XML.
    let is_xml = text.trim_start().starts_with('<') || text.contains("<?xml") || text.contains("<WindowElement");
    is_xml.then_some(Mark::Word { line: 0, word: 0 })
}

/// A basis beyond these is none that can be meant.
const LATITUDES: usize = 46;
const PATCHES: usize = 10_000;

/// The blocks of one direction, by their place in X, Y, Z or in Y, u′, v′.
struct Blocks<'n> {
    scatter: Scatter,
    side: Side,
    data: [Option<Element<'n, 'n>>; 3],
}

fn read(text: Text) -> Result<Goniometric, FormatError> {
    let begins = begin(text.text);
    // A document type names rules that nothing here needs; entities could make a small file endless.
    if let Some(at) = text.text[begins..].find("<!ENTITY") {
        let remedy = "write the text of each entity where it is used, and remove the declaration";
        return Err(text.error(begins + at, "XML without entities of its own", "'<!ENTITY'", remedy));
    }
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(&text.text[begins..], options).map_err(|e| {
        let (row, column) = (e.pos().row as usize, e.pos().col as usize);
        let before = match text.place(begins) {
            Location::Line { line, column } => [line - 1, if row == 1 { column - 1 } else { 0 }],
            _ => [0, 0],
        };
        let place = Location::Line {
            line: before[0] + row,
            column: before[1] + column,
        };
        let remedy = "correct the tags there, or copy the file again: it may be cut short";
        FormatError::at(text.path, place, "XML", e.to_string(), remedy)
    })?;
    let xml = Xml { text, begins };
    let root = document.root_element();
    if !root.has_tag_name_in_any_space("WindowElement") {
        let remedy = "this is XML of another kind; give a BSDF file of Radiance (genBSDF, bsdf2klems) or WINDOW";
        let found = quoted(root.tag_name().name());
        return Err(xml.error(root, "the root element <WindowElement>", found, remedy));
    }
    if let Some(kind) = child(root, "FileType")
        && words(kind) != "BSDF"
    {
        let remedy = "give the file that holds the BSDF, not the one of the glazing system";
        return Err(xml.error(kind, "<FileType> BSDF", quoted(words(kind)), remedy));
    }
    let layer = xml.child(xml.child(root, "Optical")?, "Layer")?;
    let definition = xml.child(layer, "DataDefinition")?;
    let structure = xml.words(definition, "IncidentDataStructure")?;
    let rank = match structure {
        "Columns" | "Rows" => None,
        "TensorTree3" => Some(3),
        "TensorTree4" => Some(4),
        _ => {
            let expected = "<IncidentDataStructure> Columns, Rows, TensorTree3 or TensorTree4";
            let remedy = "export the data as a Klems matrix or a tensor tree";
            return Err(xml.error(definition, expected, quoted(structure), remedy));
        }
    };
    let mut warnings = Vec::new();
    if !text.text[..begins].trim().is_empty() {
        let lines = text.text[..begins].lines().count();
        warnings.push(ReadNotice::BeforeXml { lines });
    }
    let mut readings = Readings::default();
    let blocks = blocks(&xml, layer, rank.is_some(), &mut warnings)?;
    let mut components = Vec::new();
    for Blocks { scatter, side, data } in &blocks {
        let names: &[usize] = if data.iter().all(Option::is_some) {
            &[0, 1, 2]
        } else {
            &[if rank.is_some() { 0 } else { 1 }]
        };
        let chosen: Vec<Element> = names.iter().filter_map(|&i| data[i]).collect();
        if chosen.len() != names.len() {
            let remedy = "add the data of the wavelength Visible to this direction";
            return Err(xml.error(
                layer,
                "a block of wavelength Visible for each direction",
                "none",
                remedy,
            ));
        }
        if chosen.len() == 1 && data.iter().flatten().count() > 1 {
            warnings.push(ReadNotice::IncompleteColour);
        }
        let table = match rank {
            Some(rank) => Table::Tree(TensorTree::new(
                rank,
                chosen
                    .iter()
                    .map(|&block| tree(&xml, block, rank, &mut readings))
                    .collect::<Result<_, _>>()?,
            )),
            None => Table::Klems(matrix(&xml, definition, &chosen, structure == "Rows", &mut readings)?),
        };
        components.push(Component {
            scatter: *scatter,
            side: *side,
            quantity: Quantity::Bsdf,
            channels: if chosen.len() == 3 {
                ChannelSet::Xyz
            } else {
                ChannelSet::Monochrome
            },
            table,
        });
    }
    if components.is_empty() {
        let remedy = "export visible data: those of the sun's spectrum or of single wavelengths are not read";
        return Err(xml.error(layer, "a <WavelengthData> of Visible light in it", "none", remedy));
    }
    text.judge(&readings, &mut warnings)?;
    let mut provenance = FileProvenance::default();
    if let Some(material) = child(layer, "Material") {
        for element in material.children().filter(Element::is_element) {
            if !words(element).is_empty() {
                let name = element.tag_name().name().to_owned();
                provenance.statements.push((name, words(element).to_owned()));
            }
        }
    }
    Ok(Goniometric {
        format: FORMAT.format,
        provenance,
        components,
        warnings,
    })
}

fn blocks<'n>(
    xml: &Xml,
    layer: Element<'n, 'n>,
    is_tree: bool,
    warnings: &mut Vec<ReadNotice>,
) -> Result<Vec<Blocks<'n>>, FormatError> {
    let mut all: Vec<Blocks> = Vec::new();
    let mut other_wavelengths: Vec<String> = Vec::new();
    for data in layer
        .children()
        .filter(|n| n.has_tag_name_in_any_space("WavelengthData"))
    {
        let wavelength = xml.words(data, "Wavelength")?;
        let channel = match (wavelength, is_tree) {
            ("CIE-X", false) => 0,
            ("Visible", false) => 1,
            ("CIE-Z", false) => 2,
            ("Visible", true) => 0,
            ("CIE-u", true) => 1,
            ("CIE-v", true) => 2,
            _ => {
                other_wavelengths.push(quoted(wavelength));
                continue;
            }
        };
        for block in data
            .children()
            .filter(|n| n.has_tag_name_in_any_space("WavelengthDataBlock"))
        {
            let direction = xml.words(block, "WavelengthDataDirection")?;
            let (scatter, side) = match direction {
                "Reflection Back" => (Scatter::Reflection, Side::Front),
                "Reflection Front" => (Scatter::Reflection, Side::Back),
                "Transmission Back" => (Scatter::Transmission, Side::Front),
                "Transmission Front" => (Scatter::Transmission, Side::Back),
                _ => {
                    let expected = "<WavelengthDataDirection> Reflection or Transmission, Front or Back";
                    return Err(xml.error(block, expected, quoted(direction), remedy::SPELLING));
                }
            };
            let index = all
                .iter()
                .position(|b| (b.scatter, b.side) == (scatter, side))
                .unwrap_or_else(|| {
                    all.push(Blocks {
                        scatter,
                        side,
                        data: [None; 3],
                    });
                    all.len() - 1
                });
            if all[index].data[channel].replace(block).is_some() {
                return Err(xml.error(
                    block,
                    "each direction and wavelength once",
                    format!("{direction} of {wavelength} again"),
                    remedy::ONE_OF_TWO,
                ));
            }
        }
    }
    if !other_wavelengths.is_empty() {
        let blocks = other_wavelengths.len();
        other_wavelengths.dedup();
        other_wavelengths.truncate(8);
        warnings.push(ReadNotice::OtherWavelengths {
            blocks,
            names: other_wavelengths,
        });
    }
    Ok(all)
}

/// The beginning of the XML: programs may print a line or two before it.
fn begin(text: &str) -> usize {
    let declaration = text.find("<?xml");
    let root = text.find("<WindowElement");
    match (declaration, root) {
        (Some(at), root) if root.is_none_or(|root| at < root) => at,
        (_, Some(root)) if !text.trim_start().starts_with('<') => root,
        _ => 0,
    }
}

fn matrix(
    xml: &Xml,
    definition: Element,
    blocks: &[Element],
    rows: bool,
    readings: &mut Readings,
) -> Result<KlemsMatrix, FormatError> {
    let mut bases = None;
    let mut values = Vec::new();
    for &block in blocks {
        let find = |name: &str| -> Result<&str, FormatError> {
            let element = block.children().find(|n| n.has_tag_name_in_any_space(name));
            let element = element.ok_or_else(|| xml.missing(block, name))?;
            Ok(element.text().unwrap_or_default().trim())
        };
        let incident = basis(xml, definition, find("ColumnAngleBasis")?, block)?;
        let exiting = basis(xml, definition, find("RowAngleBasis")?, block)?;
        let (n_in, n_out) = (incident.count(), exiting.count());
        let data = block.children().find(|n| n.has_tag_name_in_any_space("ScatteringData"));
        let data = data.ok_or_else(|| xml.missing(block, "ScatteringData"))?;
        let text = data.text().unwrap_or_default();
        let count = n_in * n_out;
        let start = values.len();
        for word in text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty()) {
            if values.len() - start == count {
                let expected = format!("{count} values, {n_in} x {n_out}");
                return Err(xml.error(data, expected, "more", remedy::ANGLE_BASES));
            }
            let value = finite(word, &FINITE).ok_or_else(|| {
                let expected = "values in 1/sr, 0 or more, between commas";
                xml.error(data, expected, quoted(word), remedy_for(word, &FINITE))
            })?;
            readings.take(value, xml.begins + data.range().start);
            values.push(value);
        }
        if values.len() - start != count {
            let found = format!("{}", values.len() - start);
            let expected = format!("{count} values, {n_in} x {n_out}");
            return Err(xml.error(data, expected, found, remedy::ANGLE_BASES));
        }
        if rows {
            let transposed: Vec<f64> = (0..count)
                .map(|at| values[start + at % n_in * n_out + at / n_in])
                .collect();
            values[start..].copy_from_slice(&transposed);
        }
        match &bases {
            None => bases = Some((incident, exiting)),
            Some(first) if *first == (incident, exiting) => {}
            Some(_) => {
                let remedy = "give X, Y and Z on the same patches, or Visible alone";
                return Err(xml.error(block, "the same angle bases in all wavelengths", "others", remedy));
            }
        }
    }
    let (incident, exiting) = bases.ok_or_else(|| xml.missing(definition, "WavelengthDataBlock"))?;
    Ok(KlemsMatrix::new(incident, exiting, values))
}

/// A basis as the file defines it, whatever its name; without blocks in the file, the one known by that name.
fn basis(xml: &Xml, definition: Element, name: &str, at: Element) -> Result<KlemsBasis, FormatError> {
    let is_it = |basis: &Element| {
        let title = basis.children().find(|n| n.has_tag_name_in_any_space("AngleBasisName"));
        title.is_some_and(|title| title.text().unwrap_or_default().trim() == name)
    };
    let mut bases = definition
        .children()
        .filter(|n| n.has_tag_name_in_any_space("AngleBasis"));
    let has_blocks = |basis: &Element| basis.children().any(|n| n.has_tag_name_in_any_space("AngleBasisBlock"));
    let Some(found) = bases.find(|basis| is_it(basis) && has_blocks(basis)) else {
        let expected = "an angle basis known by name or defined in the file";
        let remedy = "add its <AngleBasis> to <DataDefinition>";
        return KlemsBasis::named(name).ok_or_else(|| xml.error(at, expected, quoted(name), remedy));
    };
    let mut limits = vec![0.0];
    let mut patches = Vec::new();
    for ring in found
        .children()
        .filter(|n| n.has_tag_name_in_any_space("AngleBasisBlock"))
    {
        let bounds = ring.children().find(|n| n.has_tag_name_in_any_space("ThetaBounds"));
        let bounds = bounds.ok_or_else(|| xml.missing(ring, "ThetaBounds"))?;
        let (lower, upper) = (xml.number(bounds, "LowerTheta")?, xml.number(bounds, "UpperTheta")?);
        /// Programs write bounds with few digits.
        const SAME_DEG: f64 = 1e-3;
        if limits.last().is_none_or(|last| (last - lower).abs() > SAME_DEG) {
            let remedy = "order the blocks from the normal outwards, without gaps, in degrees";
            let expected = "a <LowerTheta> where the last block ended";
            return Err(xml.error(bounds, expected, shown(lower), remedy));
        }
        limits.push(upper);
        patches.push(xml.number(ring, "nPhis")?);
    }
    let counts: Vec<usize> = patches.iter().map(|&n| n as usize).collect();
    let whole = patches.iter().all(|n| n.fract() == 0.0);
    let small = patches.len() <= LATITUDES && patches.iter().sum::<f64>() <= PATCHES as f64;
    let basis = if whole && small {
        KlemsBasis::new(name, limits, counts)
    } else {
        None
    };
    let expected = "rings of patches from 0 to 90 degrees, the first with one patch";
    basis.ok_or_else(|| {
        xml.error(
            found,
            expected,
            "others",
            "correct the blocks of the basis, or export it again",
        )
    })
}
