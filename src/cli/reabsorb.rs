use super::{Failure, Options, Replace, claim, help, study};
use serde::Serialize;
use specval::artefact;
use specval::report::{LedgerRange, ledger_ranges, ledger_table};
use specval::run::{FileKind, Reabsorbed, RunError, YarnArtefact, input_files, reabsorb};
use specval::study::NumberOrTable;
use std::path::{Path, PathBuf};
use std::slice;

/// Applies another absorption to a trace without tracing, along the path lengths it kept.
///
/// Changes f* of the direct simulation, the ledger and their errors; the BSSRDF is left out. Says where the paths that
/// were traced no longer carry the change.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("change").required(true).multiple(true)))]
pub struct Arguments {
    /// Artefact of `specval trace`, or of this command.
    #[arg(value_name = "ARTEFACT")]
    artefact: PathBuf,
    /// File for the changed artefact.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Imaginary part of the particles' index at the peak of the dye, as medium.kappa_peak.
    #[arg(long, value_name = "KAPPA", allow_negative_numbers = true, group = "change")]
    kappa_peak: Option<f64>,
    #[arg(long, help = format!("A built-in dye ({}) or a CSV file, as medium.dye", help::dyes()), value_name = "NAME|FILE", group = "change")]
    dye: Option<String>,
    /// Absorption coefficient of the host in 1/mm, as medium.host_mu_a_per_mm.
    #[arg(long, value_name = "PER_MM", allow_negative_numbers = true, group = "change")]
    host_mu_a: Option<f64>,
    #[command(flatten)]
    replace: Replace,
}

/// Why this is no artefact.
fn no_artefact(error: impl Into<Failure>, path: &Path) -> Failure {
    let due = |kind| kind == FileKind::Artefact(artefact::ArtefactKind::Artefact);
    study::or_other_kind(error, path, "the artefact of a trace", due)
}

#[derive(Serialize)]
struct Document<'a> {
    ledger: Vec<LedgerRange>,
    reabsorbed: &'a Reabsorbed,
}

pub fn run(arguments: &Arguments, options: &Options) -> Result<(), Failure> {
    if options.seed.is_some() || options.paths.is_some() {
        return Err("--seed and --paths: nothing is traced here; leave them out".into());
    }
    let out = arguments.out.as_path();
    // Before the artefact is read, and again when the tables that its study names are known.
    claim(
        &[out],
        slice::from_ref(&arguments.artefact),
        &arguments.replace,
        options,
    )?;
    let (artefact, source) =
        YarnArtefact::read_with_digest(&arguments.artefact).map_err(|error| no_artefact(error, &arguments.artefact))?;
    let mut medium = artefact.layout.settings.study.medium.clone();
    if let Some(kappa_peak) = arguments.kappa_peak {
        medium.kappa_peak = kappa_peak;
    }
    if let Some(dye) = &arguments.dye {
        medium.dye.clone_from(dye);
    }
    if let Some(host_mu_a) = arguments.host_mu_a {
        medium.host_mu_a_per_mm = NumberOrTable::Number(host_mu_a);
    }
    let mut study = artefact.layout.settings.study.clone();
    let mut inputs = input_files(&study);
    study.medium.clone_from(&medium);
    inputs.extend(input_files(&study));
    let (_, terminal) = claim(&[out], &inputs, &arguments.replace, options)?;
    let artefact = reabsorb(artefact, source, medium).map_err(|error| match (error.unplaced(), &arguments.dye) {
        (RunError::Dye { .. } | RunError::DyeRange { .. } | RunError::Table { key: "dye", .. }, Some(_)) => {
            Failure::from(format!("--dye: {error}"))
        }
        _ => error.into(),
    })?;
    artefact.write(&arguments.out)?;
    let Some(reabsorbed) = artefact.layout.settings.reabsorbed.last() else {
        return Ok(());
    };
    let document = Document {
        ledger: ledger_ranges(&artefact.energy),
        reabsorbed,
    };
    terminal.result(&document, |document| {
        let [low, high] = document.reabsorbed.mu_a_change_per_mm;
        let mut text = ledger_table(&artefact.energy);
        text += &format!("mu_a changed by {low:+.3} to {high:+.3} /mm\n");
        for notice in &document.reabsorbed.notices {
            text += &format!("warning: {notice}\n");
        }
        text
    })
}
