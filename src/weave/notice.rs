//! What the reader of a draft assumed or left out.

use crate::cloth::System;
use crate::number::count;
use crate::spectrum::TextNotice;
use std::fmt::{self, Display, Formatter};

/// A notice of the reader of a draft. [`Display`] gives its words.
#[derive(Clone, Debug, PartialEq)]
pub enum DraftNotice {
    Text {
        notice: TextNotice,
    },
    /// Lines before the first section.
    BeforeSections {
        lines: usize,
    },
    NoWifSection,
    /// Sections that the table of contents promises, in brackets.
    MissingSections {
        sections: Vec<String>,
    },
    TieUpBeforeLiftPlan,
    /// Threads, picks or treadles that are counted from 0.
    NumberedFromZero {
        what: &'static str,
        section: String,
    },
    NoThreadCount {
        section: &'static str,
    },
    /// Picks that lift no shaft.
    IdlePicks {
        picks: Vec<usize>,
    },
    /// Warp threads on no shaft.
    IdleWarps {
        warps: Vec<usize>,
    },
    RisingShedAssumed,
    /// Numbers of colours that the table of colours lacks, a few of them, and how often they are used.
    UnknownColours {
        system: System,
        uses: usize,
        colours: Vec<String>,
    },
    UnknownThreads {
        system: System,
        threads: Vec<usize>,
    },
}

impl Display for DraftNotice {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Text { notice } => notice.fmt(f),
            Self::BeforeSections { lines } => write!(
                f,
                "text before the first section is passed over ({})",
                count(*lines, "line")
            ),
            Self::NoWifSection => f.write_str("the file has no section [WIF], which the format requires"),
            Self::MissingSections { sections } => write!(
                f,
                "[CONTENTS] promises {}, and the file has none: it may be cut short; export it again",
                sections.join(", ")
            ),
            Self::TieUpBeforeLiftPlan => f.write_str("both a lift plan and a tie-up are given: the tie-up is used"),
            Self::NumberedFromZero { what, section } => write!(
                f,
                "{what} are numbered from 0 in [{section}], not from 1 as the format has it"
            ),
            Self::NoThreadCount { section } => {
                write!(f, "[{section}] states Threads=0: as many as are listed are taken")
            }
            Self::IdlePicks { picks } => {
                let words = match picks.len() {
                    1 => "lifts no shaft, so that nothing binds it",
                    _ => "lift no shaft, so that nothing binds them",
                };
                let counted = count(picks.len(), "pick");
                write!(
                    f,
                    "{counted} ({}) {words}: check treadling and tie-up, or the lift plan",
                    listed(picks)
                )
            }
            Self::IdleWarps { warps } => {
                let words = match warps.len() {
                    1 => "is on no shaft, so that nothing binds it",
                    _ => "are on no shaft, so that nothing binds them",
                };
                let counted = count(warps.len(), "warp thread");
                write!(f, "{counted} ({}) {words}: check the threading", listed(warps))
            }
            Self::RisingShedAssumed => f.write_str("the file does not say whether the shed rises: taken as rising"),
            Self::UnknownColours { system, uses, colours } => write!(
                f,
                "{uses} entries of the {} name colours that [COLOR TABLE] does not have ({}): taken as not stated",
                name(*system),
                colours.join(", ")
            ),
            Self::UnknownThreads { system, threads } => write!(
                f,
                "{} entries are of {} threads that the draft does not have ({}): left out",
                threads.len(),
                name(*system),
                listed(threads)
            ),
        }
    }
}

fn name(system: System) -> &'static str {
    match system {
        System::Warp => "warp",
        System::Weft => "weft",
    }
}

/// The first numbers of a list.
fn listed(numbers: &[usize]) -> String {
    const SHOWN: usize = 8;
    let mut words: Vec<String> = numbers.iter().take(SHOWN).map(usize::to_string).collect();
    if numbers.len() > SHOWN {
        words.push("…".into());
    }
    words.join(", ")
}
