//! `specval`: decides whether a physical model of cloth scatters light as a measured sample does.

mod cli;

use cli::{Command, Terminal, TypedCommand};
use std::process::ExitCode;

fn main() -> ExitCode {
    let (TypedCommand { command, options }, notice) = TypedCommand::typed();
    let terminal = Terminal::new(&options);
    if let Some(notice) = notice {
        terminal.notice(notice);
    }
    cli::exit(terminal.start_threads(&options).and_then(|()| {
        let done = match command {
            Command::Check(arguments) => return cli::check::run(&arguments, &options),
            Command::Report(arguments) => cli::report::run(&arguments, &options, &terminal),
            Command::Init(arguments) => cli::init::run(&arguments, &options),
            Command::Mie(arguments) => cli::mie::run(&arguments, &terminal),
            Command::Medium(arguments) => cli::medium::run(&arguments, &options, &terminal),
            Command::Trace(arguments) => cli::trace::run(&arguments, &options),
            Command::Reabsorb(arguments) => cli::reabsorb::run(&arguments, &options),
            Command::Merge(arguments) => cli::merge::run(&arguments, &options),
            Command::Measure(arguments) => cli::measure::run(&arguments, &options),
            Command::Sweep(arguments) => cli::sweep::run(&arguments, &options, &terminal),
            Command::Bsdf(arguments) => cli::bsdf::run(&arguments, &options),
            Command::Validate(arguments) => cli::validate::run(&arguments, &options, &terminal),
            Command::Colour(arguments) => cli::colour::run(&arguments, &terminal),
            Command::Inspect(arguments) => cli::inspect::run(&arguments, &terminal),
            Command::Convert(arguments) => cli::convert::run(&arguments, &options),
            Command::Weave(arguments) => cli::weave::run(&arguments, &terminal),
        };
        done.map(|()| ExitCode::SUCCESS)
    }))
}
