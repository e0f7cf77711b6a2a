use super::{Failure, Options, Terminal, study};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Scattering and absorption coefficient in 1/mm of the yarn's material and the asymmetry parameter, one a wavelength
/// (in vacuum).
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Study file; without it the built-in study.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
}

#[derive(Serialize)]
struct MediumRows {
    wavelength_nm: Vec<f64>,
    mu_s_per_mm: Vec<f64>,
    mu_a_per_mm: Vec<f64>,
    g: Vec<f64>,
    /// Numbers of the study that look like those of another unit.
    notices: Vec<String>,
}

pub fn run(arguments: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let study = study::load(arguments.study.as_deref(), options)?;
    let notices = specval::run::study_notices(&study);
    for notice in &notices {
        terminal.notice(notice);
    }
    let notices = notices.iter().map(ToString::to_string).collect();
    let medium = specval::run::medium(&study)?;
    let coefficients = MediumRows {
        wavelength_nm: medium.grid().nm().to_vec(),
        mu_s_per_mm: medium.mu_s_per_mm().to_vec(),
        mu_a_per_mm: medium.mu_a_per_mm().to_vec(),
        g: medium.g().to_vec(),
        notices,
    };
    terminal.result(&coefficients, text)
}

fn text(of: &MediumRows) -> String {
    let mut text = format!(
        "{:>13} {:>12} {:>12} {:>10}\n",
        "wavelength_nm", "mu_s_per_mm", "mu_a_per_mm", "g"
    );
    for (i, nm) in of.wavelength_nm.iter().enumerate() {
        let _ = writeln!(
            text,
            "{nm:>13} {:>12.6} {:>12.6} {:>10.6}",
            of.mu_s_per_mm[i], of.mu_a_per_mm[i], of.g[i]
        );
    }
    text
}
