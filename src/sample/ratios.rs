//! Colour ratios that were published without curves.

use serde::Serialize;

use crate::spectrum::{CsvError, CsvTable};

/// Ranges of linear RGB ratios, dimensionless; lower and upper end agree where one value was published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RatioRange {
    pub blue_over_red: [f64; 2],
    pub green_over_red: [f64; 2],
}

/// Published colour ratios at normal illumination.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedRatios {
    /// The authors' cloth on their rig.
    pub real: RatioRange,
    /// Their model over the parameters of its medium.
    pub model: RatioRange,
}

const RATIO_COLUMNS: [&str; 5] = [
    "row",
    "blue_over_red_low",
    "blue_over_red_high",
    "green_over_red_low",
    "green_over_red_high",
];

/// Reads a table of published ratios: rows `real` and `model`.
pub(super) fn ratios(table: &CsvTable) -> Result<PublishedRatios, Box<CsvError>> {
    if table.columns() != RATIO_COLUMNS {
        return Err(table.header_error(
            &format!("the columns {}", RATIO_COLUMNS.join(",")),
            &table.columns().join(","),
            "name the columns so, in this order",
        ));
    }
    let range = |name: &str| -> Result<RatioRange, Box<CsvError>> {
        let row = (0..table.len())
            .find(|&row| table.text(row, 0) == name)
            .ok_or_else(|| {
                table.header_error(
                    &format!("a row '{name}'"),
                    "none",
                    "add the row: real and model are both needed",
                )
            })?;
        let number = |column| table.number(row, column, "a ratio of linear RGB components");
        Ok(RatioRange {
            blue_over_red: [number(1)?, number(2)?],
            green_over_red: [number(3)?, number(4)?],
        })
    };
    Ok(PublishedRatios {
        real: range("real")?,
        model: range("model")?,
    })
}
