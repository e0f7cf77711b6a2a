//! What charts are drawn with: font, sizes, text and axes.

use plotters::coord::Shift;
use plotters::coord::ranged1d::BoldPoints;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::register_font;
use std::ops::Range;
use std::sync::Once;

/// DejaVu Sans measures the text; where a viewer of the SVG lacks it, Verdana has the same widths.
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
static REGISTER: Once = Once::new();

/// Name of the font of the graphs, which plotters draws with once this was called: the system needs none.
pub fn chart_font() -> &'static str {
    REGISTER.call_once(|| {
        // The embedded file is a valid font; were it not, drawing text would return the error.
        drop(register_font(
            FONT,
            FontStyle::Normal,
            include_bytes!("../font/DejaVuSans.ttf"),
        ))
    });
    FONT
}

/// Lengths below are in px of a 1600 by 1000 graph and drawn twice as large.
pub(super) const SCALE: i32 = 2;
pub(super) const MARGIN: i32 = 24;
pub(super) const CAPTION_LINE: i32 = 24;
pub(super) const TITLE_PX: i32 = 32;
pub(super) const PANEL_PX: i32 = 24;
pub(super) const TEXT_PX: i32 = 20;
pub(super) const TICK_PX: i32 = 19;

pub(super) type DrawingError<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;
pub(super) type Drawn<DB> = Result<(), DrawingError<DB>>;
pub(super) type Area<DB> = DrawingArea<DB, Shift>;
pub(super) type PlotArea<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

pub(super) fn at(x: i32, y: i32) -> (i32, i32) {
    (x * SCALE, y * SCALE)
}

pub(super) fn text(px: i32) -> TextStyle<'static> {
    TextStyle::from((FONT, px * SCALE)).color(&BLACK)
}

/// Typographic minus, as wide as a plus.
pub(super) fn minus(number: String) -> String {
    number.replace('-', "−")
}

/// Where the ticks of an axis stand.
pub(super) fn key_points(ordinates: &Range<f64>, ticks: usize) -> Vec<f64> {
    RangedCoordf64::from(ordinates.clone()).key_points(BoldPoints(ticks))
}

/// The fewest decimals that print every tick exactly.
pub(super) fn tick_decimals(ordinates: &Range<f64>, ticks: usize) -> usize {
    let span = ordinates.end - ordinates.start;
    let points = key_points(ordinates, ticks);
    let exact = |decimals: &usize| {
        let unit = 10.0_f64.powi(*decimals as i32);
        points
            .iter()
            .all(|tick| ((tick * unit).round() / unit - tick).abs() < 1e-6 * span)
    };
    (0..12).find(exact).unwrap_or(12)
}

/// Breaks a text at spaces into lines no wider than `width` px.
pub(super) fn wrap<DB: DrawingBackend>(
    root: &Area<DB>,
    sentence: &str,
    width: i32,
    lines: &mut Vec<String>,
) -> Drawn<DB> {
    let style = text(TICK_PX);
    let mut line = String::new();
    for word in sentence.split_whitespace() {
        let longer = if line.is_empty() {
            word.to_owned()
        } else {
            format!("{line} {word}")
        };
        if !line.is_empty() && root.estimate_text_size(&longer, &style)?.0 as i32 > width * SCALE {
            lines.push(std::mem::replace(&mut line, word.to_owned()));
        } else {
            line = longer;
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    Ok(())
}
