//! Weave drafts, built in or from files: what a weaver's program wrote, as the interlacement and colours of a cloth.

mod ini;
mod notice;
mod threads;
mod wif;

pub use notice::DraftNotice;

use std::collections::HashMap;

use crate::cloth::{ClothError, Draft, System, Weave};
use crate::formats::FormatError;
use crate::spectrum::UnknownName;
use crate::text::is_path;
use serde::Serialize;

/// Failure to find or read a draft.
#[derive(Debug, thiserror::Error)]
pub enum WeaveError {
    #[error("expected a built-in weave, or a WIF file by a path with a dot or slash in it: {0}")]
    Unknown(#[from] UnknownName),
    #[error(transparent)]
    File(#[from] FormatError),
}

/// A draft over all its threads. Wefts are the picks in the order they are woven.
#[derive(Clone, Debug, PartialEq)]
pub struct WeaveDraft {
    pub title: Option<String>,
    /// Row-major, one row a weft.
    warp_on_top: Vec<bool>,
    pub warps: Vec<Thread>,
    pub wefts: Vec<Thread>,
    /// Assumptions that the reader made.
    pub warnings: Vec<DraftNotice>,
}

/// A thread as the file describes it; values that the file omits stay `None`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize)]
pub struct Thread {
    /// Red, green and blue, 0..1, of a display the file does not name.
    pub rgb: Option<[f64; 3]>,
    /// Distance of thread centres, mm.
    pub spacing_mm: Option<f64>,
    /// Diameter, mm.
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

    /// A built-in weave by its name, else the WIF file of that path.
    ///
    /// # Errors
    /// [`WeaveError`] if it is neither a name nor a file, or as [`Self::read`].
    pub fn load(name_or_path: &str) -> Result<Self, WeaveError> {
        if let Some(weave) = Weave::named(name_or_path) {
            return Ok(Self::built_in(name_or_path, &weave.draft()));
        }
        let path = std::path::Path::new(name_or_path);
        if is_path(name_or_path) || path.exists() {
            return Ok(Self::read(path)?);
        }
        Err(UnknownName::new("weave", name_or_path, Weave::NAMES.iter().copied()).into())
    }

    /// One repeat of a weave, with threads without stated properties.
    fn built_in(name: &str, draft: &Draft) -> Self {
        let [wefts, warps] = [System::Weft, System::Warp].map(|system| draft.yarns(system));
        let crossings = (0..wefts).flat_map(|i| (0..warps).map(move |j| (i, j)));
        Self {
            title: Some(name.into()),
            warp_on_top: crossings.map(|(i, j)| draft.warp_on_top(i, j)).collect(),
            warps: vec![Thread::default(); warps],
            wefts: vec![Thread::default(); wefts],
            warnings: Vec::new(),
        }
    }

    /// Reads a WIF file of at most 4 MiB.
    ///
    /// # Errors
    /// [`FormatError`] at the first position where the file violates the format.
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
        draft
            .warnings
            .extend(decoded.notice.map(|notice| DraftNotice::Text { notice }));
        Ok(draft)
    }
}
