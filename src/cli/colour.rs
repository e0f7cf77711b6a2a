use super::{Failure, Terminal, study};
use serde::Serialize;
use specval::colour::{Adaptation, Colour, ColourSystem, Convention, Illuminant, Observer, RgbSpace};
use specval::run::FileKind;
use specval::spectrum::read_spectra;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Sums run over exactly the wavelengths of the file; the perfect diffuser has Y = 1 and is the white of Lab. RGB is
/// linear and never clipped.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Spectral brightness factors: CSV, the column wavelength_nm first, then one column a spectrum, or CGATS-like text.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// cie1931-2deg, cie1964-10deg, or a file of xbar, ybar, zbar.
    #[arg(long, value_parser = Observer::load, default_value_t = Convention::default().observer)]
    observer: Observer,
    /// D65, D50, A, C, E, or a file of one spectrum.
    #[arg(long, value_parser = Illuminant::load, default_value_t = Convention::default().illuminant)]
    illuminant: Illuminant,
    /// srgb, cie-rgb or ntsc.
    #[arg(long, default_value_t = Convention::default().rgb)]
    rgb: RgbSpace,
    /// none, or bradford: to the white of the RGB space.
    #[arg(long, default_value_t = Convention::default().adaptation)]
    adaptation: Adaptation,
}

#[derive(Serialize)]
struct NamedColour {
    name: String,
    #[serde(flatten)]
    colour: Colour,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let convention = Convention {
        observer: arguments.observer.clone(),
        illuminant: arguments.illuminant.clone(),
        rgb: arguments.rgb,
        adaptation: arguments.adaptation,
    };
    let mut colours = Vec::new();
    let mut system: Option<ColourSystem> = None;
    for (name, samples) in read_spectra(&arguments.file).map_err(|error| no_spectra(error, &arguments.file))? {
        // All spectra of a file stand on one grid.
        let system = match &mut system {
            Some(system) => system,
            empty => empty.insert(ColourSystem::new(samples.grid(), convention.clone())?),
        };
        colours.push(NamedColour {
            name,
            colour: system.convert(samples.values()),
        });
    }
    terminal.result(&colours, |colours| text(colours, &convention))
}

/// Why this is no table of spectra.
fn no_spectra(error: impl Into<Failure>, path: &Path) -> Failure {
    let due = |kind| matches!(kind, FileKind::Spectra | FileKind::Sample);
    study::or_other_kind(error, path, "a table of spectra", due)
}

fn text(colours: &[NamedColour], convention: &Convention) -> String {
    let width = colours
        .iter()
        .map(|colour| colour.name.chars().count())
        .max()
        .unwrap_or(0)
        .max(8);
    let mut text = format!(
        "{convention}; the perfect diffuser has Y = 1; RGB linear, not clipped\n\n{:<width$}",
        "spectrum"
    );
    for title in ["X", "Y", "Z", "R", "G", "B", "L*", "a*", "b*"] {
        let _ = write!(text, " {title:>11}");
    }
    text += "\n";
    for NamedColour { name, colour } in colours {
        let _ = write!(text, "{name:<width$}");
        for value in [colour.xyz.x, colour.xyz.y, colour.xyz.z] {
            let _ = write!(text, " {value:>11.7}");
        }
        for value in colour.linear_rgb.0 {
            let _ = write!(text, " {value:>11.7}");
        }
        for value in colour.lab.0 {
            let _ = write!(text, " {value:>11.5}");
        }
        text += if colour.in_gamut { "\n" } else { "  out of gamut\n" };
    }
    text
}
