//! A fit beside the sample: a panel for each incidence and channel, with the readings and the model before and after.

use super::canvas::{
    Area, Drawn, MARGIN, PANEL_PX, SCALE, TEXT_PX, TICK_PX, TITLE_PX, at, chart_font, minus, text, tick_decimals,
};
use super::look::look;
use super::picture::{Drawing, files};
use crate::compare::Role;
use crate::fit::FitReadings;
use crate::output::NamedFile;
use crate::report::error::ReportError;
use ndarray::Array2;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Curves of a fit, β at `[geometry][channel]` of the readings.
#[derive(Clone, Copy, Debug)]
pub struct FitCurves<'a> {
    pub readings: &'a FitReadings,
    pub before: &'a Array2<f64>,
    pub after: &'a Array2<f64>,
}

/// Most panels beside each other.
const COLUMNS: usize = 3;
const LEGEND_PX: i32 = 48;
/// Highest ordinate drawn over the highest reading: a model far off does not flatten the others.
const MOST_OVER_READINGS: f64 = 1.6;

/// The chart as SVG and PNG of this name.
///
/// # Errors
/// What the drawing library refuses.
pub fn fit_panels(name: &str, curves: FitCurves) -> Result<Vec<NamedFile>, ReportError> {
    files(&[Panels {
        name: name.into(),
        curves,
    }])
}

struct Panels<'a> {
    name: String,
    curves: FitCurves<'a>,
}

impl Panels<'_> {
    /// Channels that have panels: all of a few, else three over the range.
    fn channels(&self) -> Vec<usize> {
        let count = self.curves.readings.channels.len();
        match count {
            0..=COLUMNS => (0..count).collect(),
            _ => [1, 3, 5].map(|part| part * count / 6).to_vec(),
        }
    }

    fn panel<DB: DrawingBackend>(&self, area: &Area<DB>, theta_i_deg: f64, channel: usize) -> Drawn<DB> {
        let FitCurves {
            readings,
            before,
            after,
        } = self.curves;
        let mut places: Vec<usize> = (0..readings.geometries.len())
            .filter(|&g| readings.geometries[g].theta_i_deg == theta_i_deg)
            .collect();
        let angle = |g: usize| readings.geometries[g].theta_v_deg;
        places.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
        let highest = places.iter().map(|&g| readings.beta[[g, channel]]).fold(0.0, f64::max);
        let top = places
            .iter()
            .flat_map(|&g| [before[[g, channel]], after[[g, channel]]])
            .fold(highest, f64::max)
            .min(MOST_OVER_READINGS * highest.max(1e-6))
            * 1.05;
        let ordinates: Range<f64> = 0.0..top;
        let decimals = tick_decimals(&ordinates, 5);
        let label = readings.channels[channel].name();
        let caption = format!("incidence {theta_i_deg}°, {label}");
        area.draw_text(
            &caption,
            &text(PANEL_PX).pos(Pos::new(HPos::Center, VPos::Top)),
            centre(area),
        )?;
        let mut chart = ChartBuilder::on(area)
            .margin_top(36 * SCALE)
            .margin_right(16 * SCALE)
            .x_label_area_size(44 * SCALE)
            .y_label_area_size(80 * SCALE)
            .build_cartesian_2d(-90.0..90.0, ordinates)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12).stroke_width(SCALE as u32))
            .axis_style(BLACK.stroke_width(SCALE as u32))
            .x_labels(7)
            .y_labels(5)
            .x_label_formatter(&|angle| minus(format!("{angle:.0}")))
            .y_label_formatter(&|beta| format!("{beta:.decimals$}"))
            .label_style(text(TICK_PX))
            .draw()?;
        let (model, classical) = (look(Role::Model, 0), look(Role::Classical, 0));
        let line = |of: &Array2<f64>| -> Vec<(f64, f64)> {
            places.iter().map(|&g| (angle(g), of[[g, channel]].min(top))).collect()
        };
        let (dash, gap) = classical.dash.unwrap_or((3, 5));
        chart.draw_series(DashedLineSeries::new(
            line(before),
            dash * SCALE,
            gap * SCALE,
            classical.stroke(),
        ))?;
        chart.draw_series([PathElement::new(line(after), model.stroke())])?;
        let measured = look(Role::Measured, 0).colour;
        for &g in &places {
            let (beta, se) = (readings.beta[[g, channel]], readings.se[[g, channel]]);
            let ends = vec![(angle(g), beta - se), (angle(g), (beta + se).min(top))];
            chart.draw_series([PathElement::new(ends, measured.stroke_width(SCALE as u32))])?;
            chart.draw_series([Circle::new((angle(g), beta), 3 * SCALE, measured.filled())])?;
        }
        Ok(())
    }
}

fn centre<DB: DrawingBackend>(area: &Area<DB>) -> (i32, i32) {
    (area.dim_in_pixel().0 as i32 / 2, 4 * SCALE)
}

impl Drawing for Panels<'_> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn draw<DB: DrawingBackend>(&self, root: &Area<DB>) -> Drawn<DB> {
        chart_font();
        root.fill(&WHITE)?;
        let readings = self.curves.readings;
        root.draw_text(
            &format!(
                "Fit to {}: brightness factor over the signed view angle in degrees",
                readings.sample
            ),
            &text(TITLE_PX),
            at(MARGIN, MARGIN),
        )?;
        let legend = [
            ("measured, with its uncertainty", look(Role::Measured, 0).colour),
            ("model as stated (dotted)", look(Role::Classical, 0).colour),
            ("model fitted", look(Role::Model, 0).colour),
        ];
        for (k, (words, colour)) in legend.into_iter().enumerate() {
            let left = MARGIN + 420 * k as i32;
            let top = MARGIN + LEGEND_PX;
            root.draw(&Circle::new(at(left + 8, top + 12), 8 * SCALE, colour.filled()))?;
            root.draw_text(words, &text(TEXT_PX), at(left + 28, top))?;
        }
        let channels = self.channels();
        let incidences = readings.incidences_deg();
        let rows = incidences.len().clamp(1, COLUMNS);
        let (_, below) = root.split_vertically((MARGIN + 2 * LEGEND_PX) * SCALE);
        let areas = below.split_evenly((rows, channels.len().max(1)));
        // Of many incidences the first, a middle one and the last.
        let shown: Vec<f64> = match incidences.len() {
            n if n <= COLUMNS => incidences,
            n => [0, n / 2, n - 1].map(|k| incidences[k]).to_vec(),
        };
        for (row, theta_i_deg) in shown.into_iter().enumerate() {
            for (column, &channel) in channels.iter().enumerate() {
                self.panel(&areas[row * channels.len() + column], theta_i_deg, channel)?;
            }
        }
        Ok(())
    }
}
