use super::notice::worded;
use super::{Failure, Terminal, help, study};
use serde::Serialize;
use specval::weave::{Thread, WeaveDraft, WeaveError};
use std::fmt::Write;
use std::path::Path;

/// Prints who is on top at each crossing, and what the file says of the threads.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[arg(help = format!("Built-in weave ({}), or WIF file", help::weaves()), value_name = "NAME-OR-PATH")]
    weave: String,
}

#[derive(Serialize)]
struct Drawdown {
    title: Option<String>,
    warps: usize,
    wefts: usize,
    /// Wefts and warps of the smallest repeat.
    repeat: [usize; 2],
    /// A row a pick, `X` where the warp is on top.
    drawdown: Vec<String>,
    warp_threads: Vec<Thread>,
    weft_threads: Vec<Thread>,
    warnings: Vec<String>,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let draft = WeaveDraft::load(&arguments.weave).map_err(|error| match error {
        WeaveError::Unknown(_) => error.into(),
        WeaveError::File(_) => study::no_draft(error, Path::new(&arguments.weave)),
    })?;
    let (warps, wefts) = (draft.warps.len(), draft.wefts.len());
    let row = |i: usize| {
        (0..warps)
            .map(|j| if draft.warp_on_top(i, j) { 'X' } else { '.' })
            .collect()
    };
    let (repeat, drawdown) = (draft.repeat(), (0..wefts).map(row).collect());
    let drawdown = Drawdown {
        title: draft.title,
        warps,
        wefts,
        repeat,
        drawdown,
        warp_threads: draft.warps,
        weft_threads: draft.wefts,
        warnings: worded(&draft.warnings).collect(),
    };
    terminal.result(&drawdown, text)
}

fn text(of: &Drawdown) -> String {
    let mut text = String::new();
    if let Some(title) = &of.title {
        let _ = writeln!(text, "{title}");
    }
    let _ = writeln!(
        text,
        "{} warps, {} wefts, repeat {} wefts x {} warps; X: warp on top; first pick first\n",
        of.warps, of.wefts, of.repeat[0], of.repeat[1]
    );
    for row in &of.drawdown {
        let _ = writeln!(text, "{row}");
    }
    for (name, threads) in [("warp", &of.warp_threads), ("weft", &of.weft_threads)] {
        let mut runs: Vec<(usize, &Thread)> = Vec::new();
        for thread in threads {
            match runs.last_mut() {
                Some((count, last)) if last.rgb == thread.rgb && last.spacing_mm == thread.spacing_mm => *count += 1,
                _ => runs.push((1, thread)),
            }
        }
        let _ = writeln!(text, "\n{name} threads, in order:");
        for (count, thread) in runs {
            let rgb = thread
                .rgb
                .map_or("no colour".to_owned(), |[r, g, b]| format!("rgb {r:.3} {g:.3} {b:.3}"));
            let spacing = thread
                .spacing_mm
                .map_or(String::new(), |mm| format!(", {mm:.4} mm apart"));
            let _ = writeln!(text, "  {count} x {rgb}{spacing}");
        }
    }
    for warning in &of.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
