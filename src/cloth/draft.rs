use super::{ClothError, System};
use crate::fault::{self, Fault};

/// Who is on top where a weft crosses a warp, over one repeat of the weave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    wefts: usize,
    warps: usize,
    /// Row-major, one row a weft.
    warp_on_top: Vec<bool>,
}

impl Draft {
    /// `rows[i][j]` says whether warp `j` lies over weft `i`. Every yarn must pass at least once over and once under the
    /// other system, otherwise it falls out of the cloth.
    pub fn new(rows: &[Vec<bool>]) -> Result<Self, ClothError> {
        let warps = rows.first().map_or(0, Vec::len);
        if warps == 0 {
            return Err(ClothError::EmptyDraft);
        }
        if let Some(row) = rows.iter().position(|r| r.len() != warps) {
            return Err(ClothError::RaggedDraft {
                row,
                expected: warps,
                found: rows[row].len(),
            });
        }
        let draft = Self {
            wefts: rows.len(),
            warps,
            warp_on_top: rows.concat(),
        };
        for system in [System::Warp, System::Weft] {
            for index in 0..draft.yarns(system) {
                let on_top = draft.on_top(system, index);
                if on_top.iter().all(|&up| up == on_top[0]) {
                    return Err(ClothError::NeverInterlaces { system, index });
                }
            }
        }
        Ok(draft)
    }

    /// Draft whose weft `i` dips under every warp but those with `weft_on_top(i, j)`.
    fn square(repeat: usize, weft_on_top: impl Fn(usize, usize) -> bool) -> Self {
        Self {
            wefts: repeat,
            warps: repeat,
            warp_on_top: (0..repeat * repeat)
                .map(|k| !weft_on_top(k / repeat, k % repeat))
                .collect(),
        }
    }

    /// Whether warp `j_warp` lies over weft `i_weft`, both counted on past the repeat.
    pub fn warp_on_top(&self, i_weft: usize, j_warp: usize) -> bool {
        let mut column = j_warp % self.warps;
        if fault::active(Fault::DraftMirrored) {
            column = self.warps - 1 - column;
        }
        self.warp_on_top[(i_weft % self.wefts) * self.warps + column] != fault::active(Fault::FacesExchanged)
    }

    /// Number of yarns of a system in the repeat.
    pub fn yarns(&self, system: System) -> usize {
        match system {
            System::Warp => self.warps,
            System::Weft => self.wefts,
        }
    }

    /// Whether yarn `index` of a system is on top at each crossing along it.
    pub fn on_top(&self, system: System, index: usize) -> Vec<bool> {
        match system {
            System::Warp => (0..self.wefts).map(|i| self.warp_on_top(i, index)).collect(),
            System::Weft => (0..self.warps).map(|j| !self.warp_on_top(index, j)).collect(),
        }
    }
}

/// The weaves known by name, warp-faced where the faces differ, and any other.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Weave {
    /// Over one, under one.
    #[default]
    Plain,
    /// Warp over two, under one; the twill line climbs one warp a weft.
    Twill21,
    /// Warp over three, under one; the twill line climbs one warp a weft.
    Twill31,
    /// Five-end warp satin: each warp under one weft in five, the next weft's place two warps on (move number 2).
    Satin5,
    Custom(Draft),
}

impl Weave {
    pub fn draft(&self) -> Draft {
        match self {
            Self::Plain => Draft::square(2, |i, j| i != j),
            Self::Twill21 => Draft::square(3, |i, j| i == j),
            Self::Twill31 => Draft::square(4, |i, j| i == j),
            Self::Satin5 => Draft::square(5, |i, j| j == 2 * i % 5),
            Self::Custom(draft) => draft.clone(),
        }
    }
}
