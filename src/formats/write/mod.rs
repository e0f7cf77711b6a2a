//! Writers. What a format cannot hold is resampled in the source's own interpolation, and said so.

mod columns;
mod integra;
mod merl;
mod radiance;
mod rgl;
mod sampling;
mod ssdd;

use super::{Component, Format, Goniometric, Scatter, Side, Table};
use crate::colour::ColourError;

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

/// Writes data as a file of a format. Formats that hold one component take the reflection from the front, or what
/// `scatter` says.
///
/// # Errors
/// What the format cannot hold, and where the source has no value that the format needs.
pub fn write(data: &Goniometric, format: Format, scatter: Option<Scatter>) -> Result<Written, WriteError> {
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
        Format::Ssdd => ssdd::write(data, &mut notices)?,
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
    Ok(Written { bytes, notices })
}
