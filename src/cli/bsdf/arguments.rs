//! Options of `bsdf`, and what they ask for.

use super::super::Failure;
use super::super::Replace;
use super::super::convert::{ConvertError, OutputFormat, by_extension, target_of, targets};
use super::super::inspect::scatter_of;
use super::super::method::Method;
use specval::cloth::light::HemisphereNodes;
use specval::formats::{ChannelSet, Encoding, Format, Holds, KlemsBasis, Scatter, registry};
use specval::rig::bsdf::{Cells, Colours};
use std::path::{Path, PathBuf};

/// Measures the full BSDF of the woven model, reflection and transmission over both hemispheres, for lighting
/// simulation.
///
/// Beside a file it writes FILE.hemispherical.csv. --paths are particles of each incidence.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    pub(super) study: Option<PathBuf>,
    /// File of any format that is written.
    #[arg(long, value_name = "FILE")]
    pub(super) out: PathBuf,
    /// How light in the cloth is simulated; volumetric unless said here, whatever the study's `[cloth] method` of
    /// curves.
    #[arg(long, value_enum, value_name = "METHOD")]
    pub(super) method: Option<Method>,
    #[command(flatten)]
    pub(super) replace: Replace,
    #[arg(
        long, value_name = "FORMAT", value_parser = target_of,
        help = format!("Format to write: {}; without it the extension of --out says", targets())
    )]
    to: Option<OutputFormat>,
    /// What to write in a format that holds one of the two: reflection or transmission.
    #[arg(long, value_name = "KIND", value_parser = scatter_of)]
    scatter: Option<Scatter>,
    /// Linear sRGB under D65 in place of spectra.
    #[arg(long)]
    pub(super) rgb: bool,
    /// Polar step of incident and outgoing directions, degrees; a right angle has 2 to 90 of them.
    #[arg(long, value_name = "DEG", value_parser = step, allow_negative_numbers = true, default_value = "10")]
    theta_step: Step,
    /// Step of azimuths, degrees; a right angle has 1 to 90 of them.
    #[arg(long, value_name = "DEG", value_parser = step, allow_negative_numbers = true, default_value = "15")]
    phi_step: Step,
    /// Trace every incidence, also those that the weave's symmetry gives.
    #[arg(long)]
    pub(super) no_fold: bool,
    /// CSV file for the standard errors of the spectra, in the layout of the values.
    #[arg(long, value_name = "FILE")]
    pub(super) errors: Option<PathBuf>,
}

/// A right angle in so many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step(usize);

fn step(text: &str) -> Result<Step, String> {
    let expected = || "expected a step in degrees that divides 90, from 1 to 90".to_owned();
    let degrees: f64 = text.parse().map_err(|_| expected())?;
    let steps = 90.0 / degrees;
    if !(1.0..=90.0).contains(&steps) || (steps - steps.round()).abs() > 1e-9 {
        return Err(expected());
    }
    Ok(Step(steps.round() as usize))
}

#[derive(Debug, thiserror::Error)]
pub(super) enum FullError {
    #[error("--theta-step: expected at most 45 degrees, found 90")]
    ThetaStep,
    #[error("{format} holds {holds}; leave {option} out, or take another format")]
    Option {
        format: Format,
        holds: &'static str,
        option: &'static str,
    },
    #[error(
        "the {format} file would have about {expected_mib} MiB, and specval reads at most {most_mib} MiB of that \
         format; take larger steps{smaller}"
    )]
    TooLarge {
        format: Format,
        expected_mib: u64,
        most_mib: u64,
        smaller: &'static str,
    },
}

impl Arguments {
    /// What to write; refuses what would fail after the tracing.
    pub(super) fn target(&self, out: &Path) -> Result<(OutputFormat, Option<Scatter>), Failure> {
        let (by_name, scatter) = by_extension(out);
        let target = self
            .to
            .or(by_name.map(OutputFormat::from))
            .ok_or_else(|| ConvertError::Extension { path: out.to_owned() })?;
        let format = target.format;
        let scatter = self.scatter.or(scatter);
        let refuse = |holds, option| Err(FullError::Option { format, holds, option }.into());
        match registry::writer(format)?.holds {
            Holds::Reflection if scatter == Some(Scatter::Transmission) => refuse("reflection alone", "--scatter"),
            Holds::Fractions if scatter == Some(Scatter::Reflection) => {
                refuse("what goes straight through the gaps, a transmission", "--scatter")
            }
            Holds::Kinds | Holds::Sides if self.scatter.is_some() => refuse("reflection and transmission", "--scatter"),
            _ if self.rgb && format == Format::RADIANCE_XML => refuse("X, Y, Z", "--rgb"),
            _ => Ok((target, scatter)),
        }
    }

    pub(super) fn cells(&self, format: Format) -> Result<Cells, Failure> {
        if format == Format::RADIANCE_XML
            && let Some(basis) = KlemsBasis::named("LBNL/Klems Full")
        {
            return Ok(Cells::Patches(basis));
        }
        let nodes = HemisphereNodes::new(self.theta_step.0, 4 * self.phi_step.0).ok_or(FullError::ThetaStep)?;
        Ok(Cells::Nodes(nodes))
    }

    pub(super) fn colours(&self, format: Format) -> Colours {
        match format {
            Format::RADIANCE_XML => Colours::Xyz,
            Format::MERL => Colours::Rgb,
            _ if self.rgb => Colours::Rgb,
            _ => Colours::Spectral,
        }
    }
}

/// Refuses a file that nothing would read, before it is traced for; `smaller` says what else than larger steps helps.
pub(super) fn check_size(
    cells: &Cells,
    format: Format,
    encoding: Encoding,
    channels: &ChannelSet,
    smaller: &'static str,
) -> Result<(), FullError> {
    let most_bytes = registry::descriptor(format).most_bytes();
    match cells.expected_bytes(format, encoding, channels) {
        Some(expected) if expected > most_bytes => Err(FullError::TooLarge {
            format,
            expected_mib: expected >> 20,
            most_mib: most_bytes >> 20,
            smaller,
        }),
        _ => Ok(()),
    }
}
