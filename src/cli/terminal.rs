use super::Options;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::collections::HashSet;
use std::error::Error;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Duration;

/// Any error of the library or of a command; its message has place, expectation, finding and remedy.
pub type Failure = Box<dyn Error>;

#[derive(Debug, thiserror::Error)]
#[error("--threads {threads}: the system cannot start so many; take fewer, or leave it out for one a core")]
struct NoThreads {
    threads: NonZeroUsize,
    #[source]
    cause: rayon::ThreadPoolBuildError,
}

#[derive(Debug, thiserror::Error)]
#[error("stdout: cannot be written; free space where it goes, or send it elsewhere")]
struct NotWritten {
    #[source]
    cause: io::Error,
}

/// Exit code of bad input, the same as for a mistyped flag.
const BAD_INPUT: u8 = 2;

/// Where results and notes go.
#[derive(Debug)]
pub struct Terminal {
    json: bool,
    quiet: bool,
    /// An output of the run goes to stdout, so its summary goes to stderr.
    stdout_is_output: bool,
    /// Notices that were printed: each is printed once.
    printed: Mutex<HashSet<String>>,
}

impl Terminal {
    pub fn new(options: &Options) -> Self {
        Self {
            json: options.json,
            quiet: options.quiet,
            stdout_is_output: false,
            printed: Mutex::default(),
        }
    }

    /// The same, with stdout left to an output or not.
    pub fn beside_output(self, on_stdout: bool) -> Self {
        Self {
            stdout_is_output: on_stdout,
            ..self
        }
    }

    /// Limits the number of threads. Without the option the pool starts by itself when first used, not for `--help`.
    pub fn start_threads(&self, options: &Options) -> Result<(), Failure> {
        if let Some(threads) = options.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads.get())
                .build_global()
                .map_err(|cause| NoThreads { threads, cause })?;
        }
        Ok(())
    }

    /// Prints a result: the document with `--json`, else the text.
    pub fn result<T: Serialize>(&self, document: &T, text: impl FnOnce(&T) -> String) -> Result<(), Failure> {
        let out = if self.json {
            serde_json::to_string_pretty(document)? + "\n"
        } else {
            text(document)
        };
        self.print(&out)
    }

    /// Prints a text to stdout, or to stderr where stdout is an output's.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        if self.stdout_is_output {
            if !self.quiet {
                // A closed stderr is no error.
                let _ = io::stderr().write_all(text.as_bytes());
            }
            return Ok(());
        }
        let mut stdout = io::stdout().lock();
        let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
        Ok(written.map_err(|cause| NotWritten { cause })?)
    }

    /// Prints a notice on stderr; a notice with the same words is printed once.
    pub fn notice(&self, notice: impl Display) {
        let text = notice.to_string();
        let first = self
            .printed
            .lock()
            .is_ok_and(|mut printed| printed.insert(text.clone()));
        if first && !self.quiet {
            // A closed stderr is no error.
            let _ = writeln!(io::stderr(), "notice: {text}");
        }
    }

    /// A progress bar on stderr, if that is a terminal and `--quiet` is not given.
    pub fn progress(&self, what: &'static str) -> ProgressLine {
        let bar = if self.quiet || !io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {eta}");
            ProgressBar::new(ProgressLine::STEPS).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        };
        ProgressLine(bar.with_message(what))
    }

    /// A spinner on stderr for work of unknown length, where [`Self::progress`] has its bar.
    pub fn busy(&self, what: &'static str) -> ProgressLine {
        if self.quiet || !io::stderr().is_terminal() {
            return ProgressLine(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template("{msg} {spinner} {elapsed}");
        let bar = ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(Duration::from_millis(200));
        ProgressLine(bar.with_message(what))
    }
}

/// Progress of a piece of work.
pub struct ProgressLine(ProgressBar);

impl ProgressLine {
    const STEPS: u64 = 1_000_000;

    /// Adds a share of the whole.
    pub fn advance(&self, share: f64) {
        self.0.inc((share * Self::STEPS as f64) as u64);
    }

    /// Says what is being done.
    pub fn say(&self, what: String) {
        self.0.set_message(what);
    }

    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Prints an error with all its causes and returns the exit code.
pub fn exit(result: Result<ExitCode, Failure>) -> ExitCode {
    let failure = match result {
        Ok(code) => return code,
        Err(failure) => failure,
    };
    if is_broken_pipe(failure.as_ref()) {
        return ExitCode::SUCCESS;
    }
    let mut message = format!("error: {failure}");
    let mut cause = failure.source();
    while let Some(error) = cause {
        let words = error.to_string();
        // An error that already quotes its cause does not need it twice.
        if !message.contains(&words) {
            message += &format!("\n  because: {words}");
        }
        cause = error.source();
    }
    // A closed stderr is no error.
    let _ = writeln!(io::stderr(), "{message}");
    ExitCode::from(BAD_INPUT)
}

fn is_broken_pipe(failure: &(dyn Error + 'static)) -> bool {
    let mut error = Some(failure);
    while let Some(here) = error {
        if here
            .downcast_ref::<io::Error>()
            .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
        {
            return true;
        }
        error = here.source();
    }
    false
}
