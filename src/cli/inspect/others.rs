//! Files that are not goniometric tables: drafts, spectra and samples.

use super::super::notice::{first_of, worded};
use super::super::{Failure, Terminal};
use super::series::Series;
use serde::Serialize;
use specval::sample::{Description, Sample, Uncertainty};
use specval::spectrum::{SpectraFile, plausibility};
use specval::weave::{Thread, WeaveDraft};
use std::fmt::Write;
use std::path::Path;

#[derive(Serialize)]
struct DraftInspection {
    format: &'static str,
    title: Option<String>,
    warps: usize,
    wefts: usize,
    /// Wefts and warps of the smallest repeat.
    repeat: [usize; 2],
    /// Threads with a colour, warps and wefts.
    coloured: [usize; 2],
    /// Different distances of thread centres, warps and wefts.
    spacing_mm: [Series; 2],
    warnings: Vec<String>,
}

pub fn draft(path: &Path, terminal: &Terminal) -> Result<(), Failure> {
    let draft = WeaveDraft::read(path)?;
    let coloured = |threads: &[Thread]| threads.iter().filter(|thread| thread.rgb.is_some()).count();
    let spacing = |threads: &[Thread]| Series::new(threads.iter().filter_map(|thread| thread.spacing_mm).collect());
    let found = DraftInspection {
        format: "wif",
        warps: draft.warps.len(),
        wefts: draft.wefts.len(),
        repeat: draft.repeat(),
        coloured: [coloured(&draft.warps), coloured(&draft.wefts)],
        spacing_mm: [spacing(&draft.warps), spacing(&draft.wefts)],
        title: draft.title,
        warnings: worded(&draft.warnings).collect(),
    };
    terminal.result(&found, |of| {
        let mut text = "format       wif, a weave draft; `specval weave` prints its drawdown\n".to_owned();
        // Writing to a string cannot fail.
        if let Some(title) = &of.title {
            let _ = writeln!(text, "title        {}", title.escape_debug());
        }
        let _ = writeln!(text, "repeat       {} wefts x {} warps", of.repeat[0], of.repeat[1]);
        for (index, (name, count)) in [("warps", of.warps), ("wefts", of.wefts)].into_iter().enumerate() {
            let spacing = match of.spacing_mm[index].count() {
                0 => "spacing not stated".to_owned(),
                _ => format!("spacing {} mm", of.spacing_mm[index].words()),
            };
            let _ = writeln!(
                text,
                "{name:<12} {count}, {} with a colour, {spacing}",
                of.coloured[index]
            );
        }
        warned(&mut text, &of.warnings);
        text
    })
}

#[derive(Serialize)]
struct Spectra {
    format: &'static str,
    wavelength_nm: Series,
    spectra: Vec<Spectrum>,
    stated: Vec<(String, String)>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Spectrum {
    name: String,
    lowest: f64,
    highest: f64,
}

pub fn spectra(file: &SpectraFile, terminal: &Terminal) -> Result<(), Failure> {
    let nm = file.spectra.first().map(|(_, samples)| samples.grid().nm().to_vec());
    let of = |(name, samples): &(String, specval::spectrum::Samples)| {
        let values = || samples.values().iter().copied();
        Spectrum {
            name: name.clone(),
            lowest: values().fold(f64::INFINITY, f64::min),
            highest: values().fold(f64::NEG_INFINITY, f64::max),
        }
    };
    // What `colour` refuses is told here.
    let doubts =
        file.spectra.iter().flat_map(
            |(name, samples)| match plausibility::reflectances(name, samples.values()) {
                Ok(doubts) => doubts.iter().map(ToString::to_string).collect(),
                Err(refused) => vec![refused],
            },
        );
    let doubts: Vec<String> = doubts.collect();
    let found = Spectra {
        format: "spectra",
        wavelength_nm: Series::new(nm.unwrap_or_default()),
        spectra: file.spectra.iter().map(of).collect(),
        stated: file.stated.clone(),
        warnings: worded(&file.notices).chain(first_of(&doubts)).collect(),
    };
    terminal.result(&found, |of| {
        let mut text = "format       table of spectra; `specval colour` prints their colours\n".to_owned();
        for (name, value) in &of.stated {
            let _ = writeln!(text, "{name:<12} {}", value.escape_debug());
        }
        let _ = writeln!(text, "wavelengths  {} nm", of.wavelength_nm.words());
        let _ = writeln!(text, "spectra      {}, values as the file has them:", of.spectra.len());
        for spectrum in &of.spectra {
            let name = spectrum.name.escape_debug();
            let _ = writeln!(text, "  {name}: {} to {}", spectrum.lowest, spectrum.highest);
        }
        warned(&mut text, &of.warnings);
        text
    })
}

#[derive(Serialize)]
struct Measured<'a> {
    format: &'static str,
    description: &'a Description,
    theta_i_deg: Series,
    theta_v_deg: Series,
    geometries: usize,
    /// None of RGB and XYZ.
    wavelength_nm: Option<Series>,
    /// Lowest and highest brightness factor.
    beta: Option<[f64; 2]>,
    uncertainty: Uncertainty,
    warnings: Vec<String>,
}

pub fn sample(sample: &Sample, terminal: &Terminal) -> Result<(), Failure> {
    let values = || sample.raw().flat_map(|reading| reading.beta.iter().copied());
    let found = Measured {
        format: "sample",
        description: sample.description(),
        theta_i_deg: Series::new(sample.geometries().map(|(theta_i, _)| theta_i).collect()),
        theta_v_deg: Series::new(sample.geometries().map(|(_, theta_v)| theta_v).collect()),
        geometries: sample.geometries().count(),
        wavelength_nm: sample.wavelengths_nm().map(|nm| Series::new(nm.to_vec())),
        beta: (values().next().is_some()).then(|| {
            [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ]
        }),
        uncertainty: sample.uncertainty(),
        warnings: sample.notices().iter().map(ToString::to_string).collect(),
    };
    terminal.result(&found, |of| {
        let mut text = format!(
            "format       sample, compared with by `report --measured` and tested by `check --sample`\nname         \
             {}\nsource       {}\nlicence      {}\n",
            of.description.name, of.description.source, of.description.licence
        );
        if of.geometries == 0 {
            text += "holds published ratios alone, no readings\n";
        } else {
            let _ = writeln!(text, "theta_i      {} deg", of.theta_i_deg.words());
            let _ = writeln!(text, "theta_v      {} deg", of.theta_v_deg.words());
            let _ = writeln!(text, "geometries   {}", of.geometries);
            let channels = match &of.wavelength_nm {
                Some(nm) => format!("{} nm", nm.words()),
                None if sample.is_luminance() => "one: luminance".to_owned(),
                None => "three: RGB or XYZ".to_owned(),
            };
            let _ = writeln!(text, "channels     {channels}");
        }
        if let Some([lowest, highest]) = of.beta {
            let _ = writeln!(
                text,
                "beta         {lowest} to {highest}, dimensionless, 1 for the perfect diffuser"
            );
        }
        let uncertainty = match of.uncertainty {
            Uncertainty::Columns => "a standard error for each reading".to_owned(),
            Uncertainty::Relative(share) => format!("{} % of each reading", 100.0 * share),
            Uncertainty::NotStated => "not stated".to_owned(),
        };
        let _ = writeln!(text, "uncertainty  {uncertainty}");
        warned(&mut text, &of.warnings);
        text
    })
}

fn warned(text: &mut String, warnings: &[String]) {
    for warning in warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
}
