//! Ratios, normalisation coefficient and misfit of a sweep over each of its parameters.

use super::canvas::{
    Area, Drawn, MARGIN, SCALE, TEXT_PX, TICK_PX, TITLE_PX, at, chart_font, key_points, minus, text, tick_decimals,
};
use super::look::finite;
use super::picture::{Drawing, files};
use crate::output::NamedFile;
use crate::report::{ReportError, SweepPoint, SweepTable};
use plotters::prelude::*;
use std::ops::Range;

/// Of the picture of a parameter, counted from 1, without extension.
pub(crate) fn name(number: usize) -> String {
    format!("sweep{number}")
}

/// The points of a sweep over one of its parameters.
struct OverParameter<'a> {
    number: usize,
    table: &'a SweepTable,
}

/// A picture of each parameter, as SVG and PNG.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn sweep_charts(table: &SweepTable) -> Result<Vec<NamedFile>, ReportError> {
    let of = |number| OverParameter { number, table };
    files(&(1..=table.keys.len()).map(of).collect::<Vec<_>>())
}

/// Values of points as dots with bars of a standard error.
struct Series {
    label: &'static str,
    colour: RGBColor,
    of: fn(&SweepPoint) -> (f64, f64),
}

/// Abscissa, value and standard error.
type Dot = (f64, f64, f64);

const BLUE: RGBColor = RGBColor(20, 70, 160);
const GREEN: RGBColor = RGBColor(40, 120, 60);
const ORANGE: RGBColor = RGBColor(205, 85, 0);

/// Title of the ordinate and its series, a panel each.
const PANELS: [(&str, &[Series]); 4] = [
    (
        "blue/red, –",
        &[Series {
            label: "blue/red",
            colour: BLUE,
            of: |point| (point.blue_over_red.value, point.blue_over_red.se),
        }],
    ),
    (
        "green/red, –",
        &[Series {
            label: "green/red",
            colour: GREEN,
            of: |point| (point.green_over_red.value, point.green_over_red.se),
        }],
    ),
    (
        "measured/model luminance, –",
        &[Series {
            label: "coefficient",
            colour: BLACK,
            of: |point| (point.coefficient.value, point.coefficient.se),
        }],
    ),
    (
        "rms misfit over uncertainty, –",
        &[
            Series {
                label: "absolute",
                colour: ORANGE,
                of: |point| (point.misfit_absolute, 0.0),
            },
            Series {
                label: "normalised",
                colour: BLUE,
                of: |point| (point.misfit_normalised, 0.0),
            },
        ],
    ),
];

impl OverParameter<'_> {
    fn parameter(&self, point: &SweepPoint) -> f64 {
        point.parameters[self.number - 1]
    }

    /// The points that have a value.
    fn dots(&self, series: &Series) -> Vec<Dot> {
        let all = self.table.points.iter().map(|point| {
            let (value, se) = (series.of)(point);
            (self.parameter(point), value, finite(se))
        });
        all.filter(|(_, value, _)| value.is_finite()).collect()
    }
}

/// The least range around values, with a margin.
fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    if low > high {
        return 0.0..1.0;
    }
    let margin = match high - low {
        0.0 => 0.05 * low.abs().max(1e-12),
        span => 0.05 * span,
    };
    low - margin..high + margin
}

impl Drawing for OverParameter<'_> {
    fn name(&self) -> String {
        name(self.number)
    }

    fn draw<DB: DrawingBackend>(&self, root: &Area<DB>) -> Drawn<DB> {
        chart_font();
        root.fill(&WHITE)?;
        let (width, height) = root.dim_in_pixel();
        let (width, height) = (width as i32 / SCALE, height as i32 / SCALE);
        let key = &self.table.keys[self.number - 1];
        let title = format!(
            "Sweep of {} points over {key}; bars: ±1 standard error",
            self.table.points.len()
        );
        root.draw_text(&title, &text(TITLE_PX), at(MARGIN, 16))?;
        const TOP: i32 = 64;
        let (half, middle) = (width / 2, TOP + (height - TOP) / 2);
        for (place, (ordinate, series)) in PANELS.iter().enumerate() {
            let columns = [0..half, half..width][place % 2].clone();
            let rows = [TOP..middle, middle..height][place / 2].clone();
            draw_panel(root, self, (ordinate, series), (columns, rows))?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(
    root: &Area<DB>,
    of: &OverParameter,
    (ordinate, series): (&str, &[Series]),
    (columns, rows): (Range<i32>, Range<i32>),
) -> Drawn<DB> {
    let size = (columns.end - columns.start, rows.end - rows.start);
    let area = root.clone().shrink(at(columns.start, rows.start), at(size.0, size.1));
    let dots: Vec<(&Series, Vec<Dot>)> = series.iter().map(|series| (series, of.dots(series))).collect();
    let abscissas = around(of.table.points.iter().map(|point| of.parameter(point)));
    let all = || dots.iter().flat_map(|(_, dots)| dots);
    let ordinates = around(all().flat_map(|(_, value, se)| [value - se, value + se]));
    let ticks = (size.1 / 45).max(3) as usize;
    let decimals = tick_decimals(&ordinates, ticks);
    let places = tick_decimals(&abscissas, 8);
    let label = |value: &f64| minus(format!("{value:.decimals$}"));
    let mut label_width = 0;
    for tick in key_points(&ordinates, ticks) {
        label_width = label_width.max(root.estimate_text_size(&label(&tick), &text(TICK_PX))?.0 as i32 / SCALE);
    }
    let mut chart = ChartBuilder::on(&area)
        .margin_left(16 * SCALE)
        .margin_right(20 * SCALE)
        .margin_top(32 * SCALE)
        .margin_bottom(4 * SCALE)
        .x_label_area_size(56 * SCALE)
        .y_label_area_size((label_width + 44) * SCALE)
        .build_cartesian_2d(abscissas, ordinates)?;
    chart
        .configure_mesh()
        .x_labels(8)
        .y_labels(ticks)
        .x_label_formatter(&|value| minus(format!("{value:.places$}")))
        .y_label_formatter(&label)
        .x_desc(of.table.keys[of.number - 1].as_str())
        .y_desc(ordinate)
        .label_style(text(TICK_PX))
        .axis_desc_style(text(TEXT_PX))
        .axis_style(BLACK.stroke_width(SCALE as u32))
        .bold_line_style(RGBColor(215, 215, 215).stroke_width(SCALE as u32))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(5 * SCALE)
        .draw()?;
    let mut x = columns.start + label_width + 80;
    for (series, dots) in &dots {
        let stroke = series.colour.stroke_width(SCALE as u32);
        let bar = |(x, y, se): &Dot| PathElement::new([(*x, y - se), (*x, y + se)], stroke);
        chart.draw_series(dots.iter().map(bar))?;
        let dot = |(x, y, _): &Dot| Circle::new((*x, *y), 4 * SCALE, series.colour.filled());
        chart.draw_series(dots.iter().map(dot))?;
        root.draw_text(
            series.label,
            &text(TEXT_PX).color(&series.colour),
            at(x, rows.start + 6),
        )?;
        x += root.estimate_text_size(series.label, &text(TEXT_PX))?.0 as i32 / SCALE + 32;
    }
    Ok(())
}
