use super::System;
use crate::number::{shown, significant};

/// Invalid draft or cloth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClothError {
    #[error("the draft is empty: it needs at least one row (weft) and one column (warp)")]
    EmptyDraft,
    #[error("draft row {row}: expected {expected} columns, one a warp as in row 0, found {found}")]
    RaggedDraft { row: usize, expected: usize, found: usize },
    #[error("{system} {index} of the draft (counted from 0) stays on one side at every crossing; let it change sides")]
    NeverInterlaces { system: System, index: usize },
    #[error("{name}: expected a length from 1e-6 to 1e6 mm, found {found}")]
    Length { name: &'static str, found: f64 },
    #[error("{name}: expected a number from {low} to {high}, found {found}")]
    Ratio {
        name: &'static str,
        found: f64,
        low: f64,
        high: f64,
    },
    #[error("the cell would have {found} crossings, more than {limit}; reduce the repeats, or take a smaller draft")]
    TooManyCrossings { found: usize, limit: usize },
    #[error(
        "the weave jams: {crossed} yarns {spacing_mm} mm apart leave no room for the {system} between them; increase \
         {crossed}_spacing_mm to at least {minimum_mm:.6}, or reduce the yarn radii (now {radius_sum_mm} mm together)"
    )]
    Jammed {
        system: System,
        crossed: System,
        spacing_mm: f64,
        minimum_mm: f64,
        radius_sum_mm: f64,
    },
    #[error("{}; {remedy}", self.fault())]
    Overlap {
        first: String,
        second: String,
        /// The system of both yarns if they are neighbours; `None` if they cross.
        neighbours: Option<System>,
        overlap_mm: f64,
        remedy: &'static str,
    },
    #[error(
        "{}; increase {crossed}_spacing_mm, or reduce the amplitude or the yarn radius",
        self.fault(), crossed = system.other()
    )]
    TooCurved {
        system: System,
        index: usize,
        curvature_mm: f64,
        radius_mm: f64,
    },
}

impl ClothError {
    /// What is wrong, without the remedy in the fields of a [`ClothSpec`](super::ClothSpec).
    pub fn fault(&self) -> String {
        match self {
            Self::Overlap {
                first,
                second,
                overlap_mm,
                ..
            } => format!("{first} and {second} overlap by {} mm", significant(*overlap_mm, 3)),
            Self::TooCurved {
                system,
                index,
                curvature_mm,
                radius_mm,
            } => format!(
                "{system} {index} bends with a radius of {} mm, tighter than its own radius {} mm",
                significant(*curvature_mm, 3),
                shown(*radius_mm)
            ),
            other => other.to_string(),
        }
    }
}
