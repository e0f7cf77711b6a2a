use super::inspect::ChosenComponent;
use super::notice::{first_of, worded};
use super::{Failure, Terminal, study};
use serde::Serialize;
use specval::colour::{Adaptation, Colour, ColourSystem, Convention, Illuminant, Observer, RgbSpace, Stated, Xyz};
use specval::formats::{self, Format};
use specval::run::FileKind;
use specval::sample::Sample;
use specval::spectrum::{Samples, SpectraFile, WavelengthGrid, plausibility};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The perfect diffuser has Y = 1 and is the white of Lab. RGB is linear and never clipped. On 390..730 nm in steps of
/// 10 nm or finer the sums run over exactly the wavelengths of the file; other data are interpolated, which is told.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Spectral brightness factors: CSV with the column wavelength_nm and one column a spectrum, or one column a
    /// wavelength; CGATS text; or readings over incidence and view, as `measure` writes them.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    chosen: ChosenComponent,
    /// cie1931-2deg, cie1964-10deg, or a file of xbar, ybar, zbar [default: what a CGATS file states, else
    /// cie1931-2deg].
    #[arg(long, value_parser = Observer::load)]
    observer: Option<Observer>,
    /// D65, D50, A, C, E, or a file of one spectrum [default: what a CGATS file states, else D65].
    #[arg(long, value_parser = Illuminant::load)]
    illuminant: Option<Illuminant>,
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
    geometry: Option<CurveGeometry>,
    #[serde(flatten)]
    colour: Colour,
    observer: String,
    illuminant: String,
    rgb: RgbSpace,
    adaptation: Adaptation,
    /// XYZ of the perfect diffuser.
    white: Xyz,
    /// How spectra become sums.
    method: String,
    /// What makes the colour doubtful.
    notices: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct CurveGeometry {
    theta_i_deg: f64,
    theta_v_deg: f64,
}

/// Spectra on one grid, with what was noticed of the file and of each.
struct Spectra {
    grid: WavelengthGrid,
    all: Vec<Spectrum>,
    notices: Vec<String>,
    /// Key words that state an illuminant or an observer.
    stated: Vec<(String, String)>,
}

struct Spectrum {
    name: String,
    geometry: Option<CurveGeometry>,
    values: Vec<f64>,
    notices: Vec<String>,
}

/// A file that has colours but no spectra.
#[derive(Debug, thiserror::Error)]
#[error("{0}: expected spectra, found values that are colours already; `specval inspect` shows them")]
struct NoSpectra(String);

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let spectra = read(&arguments.file, arguments.chosen).map_err(|error| no_spectra(error, &arguments.file))?;
    let mut notices = spectra.notices;
    let stated = Stated::of(&spectra.stated);
    let convention = Convention {
        observer: stated.observer(arguments.observer.clone(), &mut notices),
        illuminant: stated.illuminant(arguments.illuminant.clone(), &mut notices),
        rgb: arguments.rgb,
        adaptation: arguments.adaptation,
    };
    let system = ColourSystem::new(&spectra.grid, convention.clone())?;
    system
        .require()
        .map_err(|e| format!("{}: {e}", arguments.file.display()))?;
    notices.extend(system.notice());
    for notice in &notices {
        terminal.notice(notice);
    }
    let own: Vec<String> = spectra
        .all
        .iter()
        .flat_map(|spectrum| spectrum.notices.clone())
        .collect();
    if let Some(words) = first_of(&own) {
        terminal.notice(words);
    }
    let colours: Vec<NamedColour> = spectra
        .all
        .into_iter()
        .map(|spectrum| NamedColour {
            name: spectrum.name,
            geometry: spectrum.geometry,
            colour: system.convert(&spectrum.values),
            observer: convention.observer.name().into(),
            illuminant: convention.illuminant.name().into(),
            rgb: convention.rgb,
            adaptation: convention.adaptation,
            white: system.white(),
            method: system.method().into(),
            notices: notices.iter().cloned().chain(spectrum.notices).collect(),
        })
        .collect();
    terminal.result(&colours, |colours| text(colours, &system))
}

/// Why this is no table of spectra.
fn no_spectra(error: impl Into<Failure>, path: &Path) -> Failure {
    let due = |kind| matches!(kind, FileKind::Spectra | FileKind::Sample);
    study::or_other_kind(error, path, "a table of spectra", due)
}

fn read(path: &Path, chosen: ChosenComponent) -> Result<Spectra, Failure> {
    let format = formats::format_of(path);
    if matches!(format, Ok(Format::CSV)) {
        return readings(path, chosen);
    }
    match (SpectraFile::read(path), format) {
        (Ok(file), _) => {
            let refused = chosen.refuse_for("a table of spectra");
            refused.map_err(|error| format!("{}: {error}", path.display()))?;
            Ok(named(file)?)
        }
        (Err(_), Ok(format)) if format != Format::WIF => readings(path, chosen),
        (Err(error), _) => Err(error.into()),
    }
}

fn named(file: SpectraFile) -> Result<Spectra, Failure> {
    let mut all = Vec::with_capacity(file.spectra.len());
    // All spectra of a file stand on one grid.
    let grid = file
        .spectra
        .first()
        .map_or_else(WavelengthGrid::preprint, |(_, samples)| samples.grid().clone());
    for (name, samples) in file.spectra {
        // A title may have been wrapped by a spreadsheet.
        let name = name.replace('\n', " ");
        let doubts = plausibility::reflectances(&name, samples.values())?;
        all.push(Spectrum {
            name,
            geometry: None,
            values: samples.values().to_vec(),
            notices: doubts.iter().map(ToString::to_string).collect(),
        });
    }
    Ok(Spectra {
        grid,
        all,
        notices: worded(&file.notices).collect(),
        stated: file.stated,
    })
}

/// Readings over incidence and view, one spectrum for each.
fn readings(path: &Path, chosen: ChosenComponent) -> Result<Spectra, Failure> {
    let name = path.display().to_string();
    let sample = Sample::load_chosen(&name, chosen.into())?;
    let nm = sample.wavelengths_nm().ok_or(NoSpectra(name))?;
    let grid = WavelengthGrid::new(nm.to_vec())?;
    let mut all = Vec::new();
    for reading in sample.raw() {
        let (theta_i_deg, theta_v_deg) = (reading.theta_i_deg, reading.theta_v_deg);
        let name = format!("{theta_i_deg}/{theta_v_deg}");
        let samples = Samples::new(&name, &grid, reading.beta.to_vec())?;
        all.push(Spectrum {
            name,
            geometry: Some(CurveGeometry {
                theta_i_deg,
                theta_v_deg,
            }),
            values: samples.values().to_vec(),
            notices: Vec::new(),
        });
    }
    let notices = sample.notices().iter().map(ToString::to_string).collect();
    Ok(Spectra {
        grid,
        all,
        notices,
        stated: Vec::new(),
    })
}

fn text(colours: &[NamedColour], system: &ColourSystem) -> String {
    let width = colours
        .iter()
        .map(|colour| colour.name.chars().count())
        .max()
        .unwrap_or(0)
        .max(8);
    let Xyz { x, y, z } = system.white();
    let title = match colours.first().and_then(|colour| colour.geometry) {
        Some(_) => "in/view",
        None => "spectrum",
    };
    let mut text = format!(
        "{}; white X {x:.5} Y {y:.5} Z {z:.5}, the perfect diffuser; RGB linear, not clipped\n{}\n\n{title:<width$}",
        system.convention(),
        system.method(),
    );
    for title in ["X", "Y", "Z", "R", "G", "B", "L*", "a*", "b*"] {
        let _ = write!(text, " {title:>11}");
    }
    text += "\n";
    for NamedColour { name, colour, .. } in colours {
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
