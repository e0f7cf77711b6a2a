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
    /// The component of formats that hold one; without it the reflection from the front.
    pub scatter: Option<Scatter>,
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
    pub notices: Vec<String>,
}

/// Why data were not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WriteError {
    #[error("{format} files are read but not written; take csv, ddr, sdr, ssdd, astm, merl, rgl or klems")]
    NotWritten { format: Format },
    #[error("{format} holds {holds}; the source has {found}")]
    CannotHold {
        format: Format,
        holds: &'static str,
        found: String,
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
    let WriteOptions { scatter, encoding } = *options;
    let specular = |c: &Component| matches!(c.table, Table::Specular(_));
    let mut notices = Vec::new();
    let mut one = |wanted: fn(&Component) -> bool, holds: &'static str| {
        let mut fitting = data
            .components
            .iter()
            .filter(|c| wanted(c) && scatter.is_none_or(|s| c.scatter == s));
        let chosen = fitting
            .clone()
            .find(|c| c.side == Side::Front)
            .or_else(|| fitting.next());
        if data.components.len() > 1 {
            notices.push(format!(
                "{format} holds one of the {} components of the source",
                data.components.len()
            ));
        }
        chosen.ok_or_else(|| WriteError::CannotHold {
            format,
            holds,
            found: "none of that".into(),
        })
    };
    let diffuse = "scattering over directions, of the kind that was asked for";
    let bytes = match format {
        Format::Ddr => {
            let component = one(|c| !matches!(c.table, Table::Specular(_)), diffuse)?;
            integra::diffuse(component, &data.provenance, &mut notices)?
        }
        Format::Sdr => {
            let component = one(|c| matches!(c.table, Table::Specular(_)), "specular fractions")?;
            integra::specular(component, &data.provenance, &mut notices)?
        }
        Format::Ssdd => ssdd::write(data, encoding, &mut notices)?,
        Format::Astm | Format::Csv => {
            let component = one(|c| !matches!(c.table, Table::Specular(_)), diffuse)?;
            columns::write(component, format, &data.provenance, &mut notices)?
        }
        Format::Rgl | Format::Merl => {
            let component = one(
                |c| c.scatter == Scatter::Reflection && !matches!(c.table, Table::Specular(_)),
                "reflection",
            )?;
            if format == Format::Rgl {
                rgl::write(component, &data.provenance, &mut notices)?
            } else {
                merl::write(component, &mut notices)?
            }
        }
        Format::RadianceXml => {
            if data.components.iter().all(specular) {
                return Err(WriteError::CannotHold {
                    format,
                    holds: diffuse,
                    found: "specular fractions".into(),
                });
            }
            radiance::write(data, &mut notices)?
        }
        Format::Zemax | Format::LightTools | Format::Utia | Format::Wif => {
            return Err(WriteError::NotWritten { format });
        }
    };
    if format != Format::Csv && data.components.iter().any(states_errors) {
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
    Ok(Written { bytes, notices })
}

fn states_errors(component: &Component) -> bool {
    matches!(&component.table, Table::Scattered(scattered) if scattered.states_errors())
}
