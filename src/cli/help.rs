//! What `--help` says beside the meaning of each option: examples, and names that are built in.

use specval::cloth::Weave;
use specval::colour::{Illuminant, Observer};
use specval::sample::Sample;
use specval::spectrum::tables;

pub const REPORT: &str = "Examples:
  specval report
  specval report study.toml --quick --out quick
  specval report study.toml --measured merl-red-fabric2 --out report2
  specval report study.toml --until \"rel 1%\" --max-time 10min";
pub const INIT: &str = "Examples:
  specval init
  specval init studies
  specval init -
  specval init --keys";
pub const MIE: &str = "Examples:
  specval mie --m-re 1.034 --m-im 0.004 --x 1.3
  specval mie --conducting --x 5 --angles 0,90,180 --json";
pub const MEDIUM: &str = "Examples:
  specval medium
  specval medium study.toml --json";
pub const TRACE: &str = "Examples:
  specval trace study.toml --out yarn.trace
  specval trace study.toml --out yarn.trace --resume
  specval trace study.toml --shard 3/16 --out shard-3";
pub const REABSORB: &str = "Examples:
  specval reabsorb yarn.trace --out paler.trace --kappa-peak 0.003
  specval reabsorb yarn.trace --out blue.trace --dye RR195";
pub const MERGE: &str = "Examples:
  specval merge --out yarn.trace shard-1 shard-2 shard-3";
pub const MEASURE: &str = "Examples:
  specval measure study.toml --out curves.csv
  specval measure study.toml --method volumetric --out truth.csv --paths 1e6";
pub const SWEEP: &str = "Examples:
  specval sweep --vary medium.kappa_peak=0.002:0.012:5 --quick
  specval sweep study.toml --vary medium.kappa_peak=0.001:0.05:9:log --vary cloth.spacing_diameters=1.8,2,2.4 --out grid
  specval sweep --vary medium.volume_fraction=0.05:0.25 --vary specular.roughness=0.2:0.6 --design sobol --points 64";
pub const BSDF: &str = "Examples:
  specval bsdf study.toml --out cloth.xml
  specval bsdf study.toml --to ssdd-binary --out cloth.ssdd";
pub const CHECK: &str = "Examples:
  specval check
  specval check study.toml --quick --junit gates.xml
  specval check study.toml --against baseline.json
  specval check --sample merl-red-fabric";
pub const VALIDATE: &str = "Examples:
  specval validate
  specval validate --paths 1e6 --seed 2";
pub const COLOUR: &str = "Examples:
  specval colour spectra.csv
  specval colour spectra.csv --observer cie1964-10deg --illuminant D50 --json";
pub const INSPECT: &str = "Examples:
  specval inspect fabric.bsdf
  specval inspect cloth.ddt --json";
pub const CONVERT: &str = "Examples:
  specval convert fabric.bsdf fabric.csv
  specval convert cloth.ddr cloth.ssdd --to ssdd-binary --force";
pub const WEAVE: &str = "Examples:
  specval weave satin-5
  specval weave twill.wif
  specval weave twill.wif --json";

/// Names that the keys of a study may have beside paths of files.
pub fn init() -> String {
    format!(
        "{INIT}

Names in a study, beside paths of files:
  medium.dye         {}
  cloth.weave        {}
  colour.observer    {}
  colour.illuminant  {}
  measured.sample    {}",
        dyes(),
        weaves(),
        observers(),
        illuminants(),
        samples()
    )
}

pub fn dyes() -> String {
    tables::dye_names().join(", ")
}

pub fn weaves() -> String {
    Weave::NAMES.join(", ")
}

pub fn observers() -> String {
    Observer::ALL.iter().map(Observer::name).collect::<Vec<_>>().join(", ")
}

pub fn illuminants() -> String {
    Illuminant::ALL
        .iter()
        .map(Illuminant::name)
        .collect::<Vec<_>>()
        .join(", ")
}

pub fn samples() -> String {
    Sample::built_in_names().collect::<Vec<_>>().join(", ")
}

/// What a command's arguments say of it, which the one line of the list of commands would hide.
pub fn of<A: clap::Args>() -> String {
    let command = A::augment_args(clap::Command::new(""));
    let about = command.get_long_about().or_else(|| command.get_about());
    about.map(ToString::to_string).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::cli::TypedCommand;
    use clap::{CommandFactory, Parser};

    #[test]
    fn every_command_has_examples_that_can_be_typed() {
        let program = TypedCommand::command();
        for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
            let help = command
                .get_after_long_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            let examples: Vec<&str> = help
                .lines()
                .filter(|line| line.trim().starts_with("specval "))
                .collect();
            assert!(!examples.is_empty(), "{}", command.get_name());
            for example in examples {
                // Quotes keep a blank in one word.
                let words = example.split('"').enumerate().flat_map(|(i, part)| match i % 2 {
                    0 => part.split_whitespace().collect(),
                    _ => vec![part],
                });
                if let Err(error) = TypedCommand::try_parse_from(words) {
                    panic!("{example}: {error}");
                }
            }
        }
    }
}
