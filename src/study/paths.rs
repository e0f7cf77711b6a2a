use std::path::Path;

use super::choices::NumberOrTable;
use super::keys::Study;
use crate::cloth::Weave;
use crate::colour::{Illuminant, Observer};
use crate::sample::Sample;
use crate::spectrum::tables;
use crate::text::is_path;

impl Study {
    /// Takes every path in the study as one from `folder`, the folder of the study's file: of each key, those of
    /// tables, dye, backing, weave, observer, illuminant and sample. Names of built-in weaves, tables and samples stay,
    /// absolute paths too.
    pub fn at_folder(mut self, folder: &Path) -> Self {
        let rebase = |path: &mut String| *path = folder.join(&*path).display().to_string();
        // A word may be a file, or a misspelt name of what is built in.
        let rebase_word = |path: &mut String| {
            if is_path(path) || folder.join(&*path).exists() {
                rebase(path);
            }
        };
        let known = |name: &str, known: &str| name.eq_ignore_ascii_case(known);
        let (medium, weft) = (&mut self.medium, &mut self.weft);
        let numbers = [
            Some(&mut medium.host_index),
            Some(&mut medium.host_mu_a_per_mm),
            Some(&mut medium.particle_index),
            weft.host_index.as_mut(),
            weft.host_mu_a_per_mm.as_mut(),
            weft.particle_index.as_mut(),
        ];
        for number in numbers.into_iter().flatten() {
            if let NumberOrTable::Table(path) = number {
                rebase(path);
            }
        }
        for dye in [Some(&mut medium.dye), weft.dye.as_mut()].into_iter().flatten() {
            if tables::dye(dye).is_err() {
                rebase_word(dye);
            }
        }
        if Weave::named(&self.cloth.weave).is_none() {
            rebase_word(&mut self.cloth.weave);
        }
        if !["none", "black", "white"].contains(&self.cloth.backing.as_str()) {
            rebase_word(&mut self.cloth.backing);
        }
        let colour = &mut self.colour;
        if !Observer::ALL.iter().any(|one| known(&colour.observer, one.name())) {
            rebase_word(&mut colour.observer);
        }
        if !Illuminant::ALL.iter().any(|one| known(&colour.illuminant, one.name())) {
            rebase_word(&mut colour.illuminant);
        }
        if !Sample::built_in_names().any(|name| name == self.measured.sample) {
            rebase_word(&mut self.measured.sample);
        }
        self
    }
}
