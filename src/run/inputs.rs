use crate::cloth::Weave;
use crate::colour::{Illuminant, Observer};
use crate::sample::Sample;
use crate::spectrum::tables;
use crate::study::{MediumSection, NumberOrTable, Study};
use std::path::{Path, PathBuf};

/// Every file that a run of this study reads, the study's own aside: what none of its outputs may be. Names of built-in
/// tables and samples are no files; whether a file is there is not asked.
pub fn input_files(study: &Study) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for medium in [&study.medium, &study.weft.medium(&study.medium)] {
        files.extend(of_medium(medium));
    }
    let built_in = |name: &str, names: &[&str]| names.iter().any(|known| known.eq_ignore_ascii_case(name));
    let names = Observer::ALL
        .iter()
        .map(Observer::name)
        .chain(Illuminant::ALL.iter().map(Illuminant::name));
    let names: Vec<&str> = names.chain(["none", "black", "white"]).collect();
    let named = [&study.colour.observer, &study.colour.illuminant, &study.cloth.backing];
    files.extend(
        named
            .into_iter()
            .filter(|name| !built_in(name, &names))
            .map(PathBuf::from),
    );
    if Weave::named(&study.cloth.weave).is_none() {
        files.push(PathBuf::from(&study.cloth.weave));
    }
    files.extend(sample_files(&study.measured.sample));
    files
}

/// Files of a sample: none of a built-in one, all of a folder.
pub fn sample_files(name_or_path: &str) -> Vec<PathBuf> {
    if Sample::built_in_names().any(|known| known == name_or_path) {
        return Vec::new();
    }
    let path = Path::new(name_or_path);
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(|path| path.is_file())
        .collect()
}

fn of_medium(medium: &MediumSection) -> Vec<PathBuf> {
    let tables = [&medium.host_index, &medium.host_mu_a_per_mm, &medium.particle_index];
    let mut files: Vec<PathBuf> = tables
        .into_iter()
        .filter_map(NumberOrTable::table)
        .map(PathBuf::from)
        .collect();
    if tables::dye(&medium.dye).is_err() {
        files.push(PathBuf::from(&medium.dye));
    }
    files
}
