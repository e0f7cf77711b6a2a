use super::{ClothError, System};
use crate::fault::{self, Fault};

/// Draft: which yarn is on top at each crossing of a weft and a warp, over one repeat of the weave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    wefts: usize,
    warps: usize,
    /// Row-major, one row per weft.
    warp_on_top: Vec<bool>,
}

impl Draft {
    /// `rows[i][j]`: whether warp `j` lies over weft `i`.
    ///
    /// # Errors
    /// [`ClothError`] unless every yarn passes at least once over and once under the other system: it would not be
    /// bound in the cloth.
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

    /// Draft from rows of `X` (warp on top) and `.`, one row per weft.
    fn of_drawdown(rows: &[&str]) -> Self {
        Self {
            wefts: rows.len(),
            warps: rows.first().map_or(0, |row| row.len()),
            warp_on_top: rows.concat().bytes().map(|mark| mark == b'X').collect(),
        }
    }

    /// Whether warp `j_warp` lies over weft `i_weft`; both indices continue periodically beyond the repeat.
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

/// [`Weave`] and its names, from a table of drawdowns over one repeat: one row per weft, first weft first, `X` where
/// the warp is on top.
macro_rules! built_in_weaves {
    ($($(#[$meaning:meta])+ $weave:ident = $name:literal $rows:expr;)+) => {
        /// A built-in weave, or the draft of any other.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub enum Weave {
            $($(#[$meaning])+ $weave,)+
            Custom(Draft),
        }

        impl Weave {
            pub const BUILT_IN: &'static [Self] = &[$(Self::$weave),+];
            /// Names of [`Self::BUILT_IN`].
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The draft of this weave.
            pub fn draft(&self) -> Draft {
                match self {
                    $(Self::$weave => Draft::of_drawdown(&$rows),)+
                    Self::Custom(draft) => draft.clone(),
                }
            }
        }
    };
}

// Warp-faced where the faces differ. Adding a weave here adds it to the study file, the help and the messages.
built_in_weaves! {
    /// Over one, under one.
    Plain = "plain" [
        "X.",
        ".X",
    ];
    /// Warp over two, under one; the twill line advances one warp per weft.
    Twill21 = "twill-2-1" [
        ".XX",
        "X.X",
        "XX.",
    ];
    /// Warp over three, under one; the twill line advances one warp per weft.
    Twill31 = "twill-3-1" [
        ".XXX",
        "X.XX",
        "XX.X",
        "XXX.",
    ];
    /// Five-end warp satin: each warp passes under one weft in five; from weft to weft this point moves by two warps
    /// (move number 2).
    Satin5 = "satin-5" [
        ".XXXX",
        "XX.XX",
        "XXXX.",
        "X.XXX",
        "XXX.X",
    ];
}

impl Weave {
    /// The built-in weave of this name; `None` for other names.
    pub fn named(name: &str) -> Option<Self> {
        let place = Self::NAMES.iter().position(|known| *known == name)?;
        Self::BUILT_IN.get(place).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`Draft::new`] accepts each drawdown, and each name gives its own weave.
    #[test]
    fn built_in_weaves_are_drafts() {
        for (weave, name) in Weave::BUILT_IN.iter().zip(Weave::NAMES) {
            let draft = weave.draft();
            let row = |i| {
                (0..draft.warps)
                    .map(|j| draft.warp_on_top[i * draft.warps + j])
                    .collect()
            };
            let rows: Vec<Vec<bool>> = (0..draft.wefts).map(row).collect();
            assert_eq!(draft.warp_on_top.len(), draft.wefts * draft.warps, "{name}");
            assert_eq!(Draft::new(&rows), Ok(draft), "{name}");
            assert_eq!(Weave::named(name).as_ref(), Some(weave));
        }
        assert_eq!(Weave::named("Plain"), None);
    }
}
