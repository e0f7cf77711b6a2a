use std::fmt;

/// The two systems of yarns of a weave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum System {
    /// Along x.
    Warp,
    /// Along y.
    Weft,
}

impl System {
    /// Index in pairs of (warp, weft).
    pub fn index(self) -> usize {
        match self {
            Self::Warp => 0,
            Self::Weft => 1,
        }
    }

    /// The other system.
    pub fn other(self) -> Self {
        match self {
            Self::Warp => Self::Weft,
            Self::Weft => Self::Warp,
        }
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Warp => "warp",
            Self::Weft => "weft",
        })
    }
}

/// One physical yarn of the endless cloth. All repeats along a yarn are the same yarn; its copy one cell sideways is
/// another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct YarnId {
    pub system: System,
    /// Index in the cell.
    pub index: u32,
    /// Cell across the yarn: along y for a warp, along x for a weft.
    pub lateral: i64,
}
