//! Weave drafts from files: what a weaver's program wrote, as the interlacement and colours of a cloth.

mod ini;
mod wif;

use std::collections::HashMap;

use crate::cloth::{ClothError, Draft};
use crate::formats::FormatError;
use serde::Serialize;

/// A draft over all its threads. Wefts are the picks in the order they are woven.
#[derive(Clone, Debug, PartialEq)]
pub struct WeaveDraft {
    pub title: Option<String>,
    /// Row-major, one row a weft.
    warp_on_top: Vec<bool>,
    pub warps: Vec<Thread>,
    pub wefts: Vec<Thread>,
    /// What the reader had to assume.
    pub warnings: Vec<String>,
}

/// A thread as the file states it; a draft is no optics, so nothing is assumed where it says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct Thread {
    /// Red, green and blue, 0..1, of a display the file does not name.
    pub rgb: Option<[f64; 3]>,
    /// Distance of thread centres.
    pub spacing_mm: Option<f64>,
    /// Diameter.
    pub thickness_mm: Option<f64>,
}

impl WeaveDraft {
    /// Whether warp `j` lies over weft `i`.
    pub fn warp_on_top(&self, i_weft: usize, j_warp: usize) -> bool {
        self.warp_on_top[i_weft * self.warps.len() + j_warp]
    }

    /// The smallest numbers of wefts and warps after which the interlacement repeats; all of them where it does so at
    /// most once.
    pub fn repeat(&self) -> [usize; 2] {
        let (wefts, warps) = (self.wefts.len(), self.warps.len());
        // Equal threads get equal numbers, so that each is compared whole only once.
        let smallest = |n: usize, thread: &dyn Fn(usize) -> Vec<bool>| {
            let mut known = HashMap::new();
            let kinds: Vec<usize> = (0..n)
                .map(|k| {
                    let next = known.len();
                    *known.entry(thread(k)).or_insert(next)
                })
                .collect();
            let repeats = |period: &usize| kinds[*period..].iter().zip(&kinds).all(|(a, b)| a == b);
            (1..=n / 2).find(repeats).unwrap_or(n)
        };
        [
            smallest(wefts, &|i| (0..warps).map(|j| self.warp_on_top(i, j)).collect()),
            smallest(warps, &|j| (0..wefts).map(|i| self.warp_on_top(i, j)).collect()),
        ]
    }

    /// One repeat, for a cloth.
    ///
    /// # Errors
    /// A thread that never changes sides.
    pub fn draft(&self) -> Result<Draft, ClothError> {
        let [wefts, warps] = self.repeat();
        let row = |i: usize| (0..warps).map(|j| self.warp_on_top(i, j)).collect();
        Draft::new(&(0..wefts).map(row).collect::<Vec<_>>())
    }

    /// Reads a WIF file of at most 4 MiB.
    ///
    /// # Errors
    /// The first place where the file departs from the format.
    pub fn read(path: &std::path::Path) -> Result<Self, FormatError> {
        let (format, bytes) = crate::formats::read_bytes(path)?;
        let name = path.display().to_string();
        if format != crate::formats::Format::WIF {
            return Err(FormatError::file(
                &name,
                "a weave draft (WIF)",
                format!("a file of the format {format}"),
                "look at it with `specval inspect`, or export the draft as WIF",
            ));
        }
        Self::parse(&name, &bytes)
    }

    /// Reads the bytes of a WIF file, called `path` in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(path: &str, bytes: &[u8]) -> Result<Self, FormatError> {
        let decoded = crate::formats::decode(path, bytes)?;
        let mut draft = wif::parse(path, &decoded.text)?;
        draft.warnings.extend(decoded.notice);
        Ok(draft)
    }
}
