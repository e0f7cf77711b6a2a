use super::{Failure, Options, Terminal};
use specval::number::significant;
use specval::validate::{self, Check};
use std::fmt::Write;

/// Solves problems whose answers are known from elsewhere with the very code that traces yarns, and prints how far
/// apart they are in standard errors. `--paths` is for each problem.
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Enough for errors of 0.1 to 0.3 %, in seconds.
const DEFAULT_PATHS: u64 = 100_000;

/// Beyond this a z-score is marked.
const MARKED: f64 = 3.5;

pub fn run(_: &Arguments, options: &Options, terminal: &Terminal) -> Result<(), Failure> {
    let paths = options.paths.map_or(DEFAULT_PATHS, std::num::NonZeroU64::get);
    let checks = validate::run(paths, options.seed.unwrap_or(1))?;
    terminal.result(&checks, |checks| text(checks))
}

fn text(checks: &[Check]) -> String {
    let mut text = format!(
        "{:<44} {:<24} {:>14} {:>10} {:>14} {:>7}\n",
        "problem", "quantity", "value", "se", "reference", "z"
    );
    for check in checks {
        let mark = if check.z.abs() > MARKED { " !" } else { "" };
        let _ = writeln!(
            text,
            "{:<44} {:<24} {:>14.8} {:>10} {:>14.8} {:>7.2}{mark}",
            check.problem,
            check.quantity,
            check.value,
            significant(check.se, 3),
            check.reference,
            check.z
        );
    }
    let beyond = checks.iter().filter(|c| c.z.abs() > MARKED).count();
    let _ = writeln!(
        text,
        "{} values, {beyond} beyond {MARKED} standard errors (expected by chance: {:.2})",
        checks.len(),
        4.65e-4 * checks.len() as f64
    );
    text
}
