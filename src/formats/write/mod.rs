//! Writers. What a format cannot hold is resampled in the source's own interpolation, and said so.

mod balance;
mod columns;
mod integra;
mod merl;
mod nodes;
mod radiance;
mod rgl;
mod sampling;
mod ssdd;

pub(crate) use integra::resampled_nodes;

use super::{Component, Format, Goniometric, Scatter, Side, Table};
use crate::colour::ColourError;

/// What some formats leave to the writer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// What is written; without it all that the format holds, of formats that hold one component the reflection if there is one.
    pub scatter: Option<Scatter>,
    /// Where the light comes from; without it the front, of formats that state the side both.
    pub side: Option<Side>,
    /// Of the values of SSDD files.
    pub encoding: Encoding,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// All digits.
    #[default]
    Text,
    /// 32-bit floating point, little-endian.
    Binary,
}

/// The bytes of a file, and what they do not hold as the source did.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    pub bytes: Vec<u8>,
    /// What is in it, in words.
    pub components: Vec<String>,
    pub notices: Vec<String>,
}

/// Why data were not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    #[error(
        "expected a format that is written, found {format}, which is read but not written; take csv, ddr, sdr, ssdd, astm, merl, rgl or klems"
    )]
    NotWritten { format: Format },
    #[error("expected {holds}, which {format} holds, found {found}; {remedy}")]
    CannotHold {
        format: Format,
        holds: String,
        found: String,
        remedy: &'static str,
    },
    #[error("the source's values are of a scale it does not state; give the factor to 1/sr (--scale)")]
    Unscaled,
    #[error(
        "{format} needs f at incidence {theta_i_deg:.4} degrees towards {theta_o_deg:.4} degrees, azimuth {phi_o_deg:.4}, \
         and the source has nothing near it at that azimuth; take a format that holds single readings (csv, astm)"
    )]
    NotMeasured {
        format: Format,
        theta_i_deg: f64,
        theta_o_deg: f64,
        phi_o_deg: f64,
    },
    #[error(transparent)]
    Colour(#[from] ColourError),
}

/// Writes data as a file of a format.
///
/// # Errors
/// What the format cannot hold, and where the source has no value that the format needs.
pub fn write(data: &Goniometric, format: Format, options: &WriteOptions) -> Result<Written, WriteError> {
    if matches!(format, Format::Zemax | Format::LightTools | Format::Utia | Format::Wif) {
        return Err(WriteError::NotWritten { format });
    }
    let chosen = chosen(data, format, options)?;
    let mut notices = Vec::new();
    let left_out = data.components.iter().filter(|c| !chosen.contains(c));
    let left_out: Vec<String> = left_out.map(Component::words).collect();
    if !left_out.is_empty() {
        notices.push(format!("not in the file, but in the source: {}", left_out.join("; ")));
    }
    if format != Format::RadianceXml && chosen.iter().any(|c| c.side == Side::Back) {
        notices.push(format!(
            "{format} does not state the side: the light comes from the back, and azimuths run as on the front"
        ));
    }
    let provenance = &data.provenance;
    let bytes = match (format, &chosen[..]) {
        (Format::Ddr, [one, ..]) => integra::diffuse(one, provenance, &mut notices)?,
        (Format::Sdr, [one, ..]) => integra::specular(one, provenance, &mut notices)?,
        (Format::Astm | Format::Csv, [one, ..]) => columns::write(one, format, provenance, &mut notices)?,
        (Format::Rgl, [one, ..]) => rgl::write(one, provenance, &mut notices)?,
        (Format::Merl, [one, ..]) => merl::write(one, &mut notices)?,
        (Format::Ssdd, all) => ssdd::write(all, provenance, options.encoding, &mut notices)?,
        (_, all) => radiance::write(all, provenance, &mut notices)?,
    };
    if format != Format::Csv && chosen.iter().any(|c| states_errors(c)) {
        notices.push(format!(
            "{format} holds no standard errors: those of the source are left out"
        ));
    }
    let most = format.most_bytes();
    if bytes.len() as u64 > most {
        notices.push(format!(
            "the file has {} bytes, and those that specval reads in the format {format} have at most {most}",
            bytes.len()
        ));
    }
    Ok(Written {
        bytes,
        components: chosen.into_iter().map(Component::words).collect(),
        notices: super::counted(notices),
    })
}

/// The components that are written, at least one: those that were asked for and that the format holds. Of formats that hold one
/// it is, where nothing was asked for, the reflection before the transmission. What comes from the back is written into formats
/// that do not state the side only where it was asked for.
fn chosen<'a>(data: &'a Goniometric, format: Format, options: &WriteOptions) -> Result<Vec<&'a Component>, WriteError> {
    let is_specular = |c: &Component| matches!(c.table, Table::Specular(_));
    let holds = |c: &Component| match format {
        Format::Sdr => is_specular(c),
        Format::Rgl | Format::Merl => !is_specular(c) && c.scatter == Scatter::Reflection,
        Format::Ssdd | Format::RadianceXml => true,
        _ => !is_specular(c),
    };
    let asked = |c: &Component| {
        let side = match format {
            Format::RadianceXml => options.side,
            _ => Some(options.side.unwrap_or(Side::Front)),
        };
        options.scatter.is_none_or(|scatter| c.scatter == scatter) && side.is_none_or(|side| c.side == side)
    };
    let mut fitting: Vec<&Component> = data.components.iter().filter(|c| holds(c) && asked(c)).collect();
    if format == Format::Ssdd {
        // A block of each kind.
        let mut kinds = Vec::new();
        fitting.retain(|c| {
            let kind = (c.scatter, is_specular(c));
            let is_first = !kinds.contains(&kind);
            kinds.push(kind);
            is_first
        });
    }
    // Klems matrices alone take specular fractions on.
    let is_held = match format {
        Format::RadianceXml => fitting.iter().any(|c| !is_specular(c)),
        _ => !fitting.is_empty(),
    };
    if !is_held {
        let held = match format {
            Format::Sdr => "specular fractions",
            Format::Rgl | Format::Merl => "reflection",
            Format::Ssdd => "scattering and specular fractions",
            _ => "scattering over directions",
        };
        let kind = match options.scatter {
            Some(Scatter::Reflection) => ", of reflection as was asked for",
            Some(Scatter::Transmission) => ", of transmission as was asked for",
            None => "",
        };
        let side = match (format, options.side) {
            (Format::RadianceXml, None) => "",
            (_, Some(Side::Back)) => ", of light from the back",
            _ => ", of light from the front",
        };
        let there: Vec<String> = data.components.iter().map(Component::words).collect();
        return Err(WriteError::CannotHold {
            format,
            holds: format!("{held}{kind}{side}"),
            found: there.join("; "),
            remedy: "choose one with --scatter and --side, or take a format that holds it: klems holds both sides, ssdd \
                     reflection and transmission",
        });
    }
    if !matches!(format, Format::Ssdd | Format::RadianceXml) {
        // The first one in the order of the source; sorting keeps it.
        fitting.sort_by_key(|c| c.scatter == Scatter::Transmission);
        fitting.truncate(1);
    }
    Ok(fitting)
}

fn states_errors(component: &Component) -> bool {
    matches!(&component.table, Table::Scattered(scattered) if scattered.states_errors())
}
