//! Graphs of β over the signed view angle, one an incidence: R in a large panel, G and B beside it on their own
//! ordinates.

use super::canvas::{
    Area, CAPTION_LINE, DrawingError, Drawn, MARGIN, PANEL_PX, PlotArea, SCALE, TEXT_PX, TICK_PX, TITLE_PX, at,
    chart_font, key_points, minus, text, tick_decimals, wrap,
};
use super::look::{Look, draw_band, draw_line, finite, look};
use super::picture::{Chart, Drawing, files, png, svg};
use crate::compare::{Channel, CurvePoint, Role, Source, SourceId};
use crate::report::error::ReportError;
use crate::report::result::ReportData;
use crate::report::tables::{channel_name, with_error, words_of};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Models and samples at each incidence, then the classical models beside them.
pub(super) const CHART: Chart = Chart {
    names: |outline| (1..=2 * outline.incidences).map(name).collect(),
    files: |data| files(&graphs(data)),
};

fn name(number: usize) -> String {
    format!("graph{number}")
}

/// One of graphs 1, 2, 3… (models and samples, one an incidence) and the following ones (the classical models beside
/// them), numbered as in the preprint for its three incidences.
#[derive(Debug)]
pub struct Graph<'a> {
    number: usize,
    theta_i_deg: f64,
    /// Roles of the sources that it shows, in the order in which they are drawn and named.
    roles: &'static [Role],
    data: &'a ReportData,
}

/// Every graph of the result, in order; two for each incidence that has a curve. Where the geometries are the sample's
/// own, an incidence that it was not measured at, added for Table 1, has none.
pub fn graphs(data: &ReportData) -> Vec<Graph<'_>> {
    let sampled = data.readings.geometries_of_sample;
    let shown = data
        .curves
        .iter()
        .filter(|point| !sampled || data.sample(&point.source).is_some());
    let mut incidences: Vec<f64> = shown.map(|point| point.theta_i_deg).collect();
    incidences.sort_by(f64::total_cmp);
    incidences.dedup();
    let sets: [&'static [Role]; 2] = [
        &[Role::Model, Role::Measured],
        &[Role::Model, Role::Measured, Role::Classical],
    ];
    sets.iter()
        .flat_map(|&roles| incidences.iter().map(move |&theta_i_deg| (roles, theta_i_deg)))
        .enumerate()
        .map(|(index, (roles, theta_i_deg))| Graph {
            number: index + 1,
            theta_i_deg,
            roles,
            data,
        })
        .collect()
}

impl Graph<'_> {
    /// 1 for the first.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The graph as an SVG document of 1600 by 1000 px; it loads nothing.
    pub fn svg(&self) -> Result<String, ReportError> {
        svg(self)
    }

    /// The graph as a PNG of 1600 by 1000 px, 8-bit RGB.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        png(self)
    }

    /// One curve in order of view angle; points that are not numbers are left out.
    fn curve(&self, source: &Source, channel: Channel) -> Vec<&CurvePoint> {
        let mut points: Vec<_> = self
            .data
            .curves
            .iter()
            .filter(|p| p.theta_i_deg == self.theta_i_deg && p.source == source.id && p.channel == channel)
            .filter(|p| p.theta_v_deg.is_finite() && p.beta.is_finite())
            .collect();
        points.sort_by(|a, b| a.theta_v_deg.total_cmp(&b.theta_v_deg));
        points
    }

    /// The figure's sources, each with its look.
    fn sources(&self) -> impl Iterator<Item = (&Source, Look)> {
        let of = |&role: &Role| {
            let sources = self.data.sources_of(role).enumerate();
            sources.map(move |(place, source)| (source, look(role, place)))
        };
        self.roles.iter().flat_map(of)
    }

    /// Those of them that have a curve here.
    fn present(&self) -> Vec<(&Source, Look)> {
        let has = |source: &Source| {
            [Channel::R, Channel::G, Channel::B]
                .into_iter()
                .any(|channel| !self.curve(source, channel).is_empty())
        };
        self.sources().filter(|(source, _)| has(source)).collect()
    }

    fn title(&self) -> String {
        let present = self.present();
        let name = |&role: &Role| {
            let count = present.iter().filter(|(source, _)| source.role == role).count();
            let one = match role {
                Role::Model => "model",
                Role::Measured => "measured cloth",
                Role::Classical => "classical model",
            };
            match count {
                0 => None,
                1 => Some(one.to_owned()),
                _ => Some(format!("{count} {one}s")),
            }
        };
        let names: Vec<String> = self.roles.iter().filter_map(name).collect();
        let names = match names.split_last() {
            None => "no curves".to_owned(),
            Some((last, [])) => last.clone(),
            Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
        };
        format!(
            "Graph {}. Light at {}° from the normal: {names}",
            self.number, self.theta_i_deg
        )
    }

    fn caption(&self) -> Vec<String> {
        let present = self.present();
        let shown = |id: &SourceId| present.iter().any(|(source, _)| source.id == *id);
        let mut sentences = Vec::new();
        let samples: Vec<_> = self.data.samples.iter().filter(|sample| shown(&sample.id)).collect();
        for sample in &samples {
            sentences.push(format!("Sample: {} ({}). {}", sample.name, sample.kind, sample.caption));
        }
        if samples.is_empty() && self.data.readings.total > 0 {
            sentences.push("No measured curve: the sample has no reading at this incidence.".to_owned());
        }
        // Curves are normalised to the first sample that was compared.
        let first = self.data.normalisation.first().map(|of| &of.sample);
        let coefficients = || self.data.normalisation.iter().filter(|of| Some(&of.sample) == first);
        if let Some(at) = coefficients().next().map(|of| of.at) {
            let factors: Vec<String> = coefficients()
                .filter(|of| shown(&of.source))
                .map(|of| format!("{} × {}", of.source, with_error(of.factor.value, of.factor.se)))
                .collect();
            sentences.push(format!(
                "Normalisation: {} (measured luminance divided by its own, at {}; a perfect model has 1).",
                factors.join(", "),
                words_of(&at)
            ));
        }
        sentences.push(format!(
            "β is 1 for a perfect diffuser. Colour: {}.",
            self.data.colour_convention
        ));
        sentences
    }

    /// View angles shown, the same for every panel, degrees.
    fn view_range(&self) -> Range<f64> {
        let angles = self
            .present()
            .into_iter()
            .flat_map(|(source, _)| [Channel::R, Channel::G, Channel::B].map(|channel| (source, channel)))
            .flat_map(|(source, channel)| self.curve(source, channel));
        let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
            (low.min(point.theta_v_deg), high.max(point.theta_v_deg))
        });
        if low > high {
            return -90.0..90.0;
        }
        // A single view needs room to be seen in.
        let pad = if high - low < 1.0 { 10.0 } else { 2.0 };
        low - pad..high + pad
    }

    /// Ordinates of one panel: 0 and every band lie inside, with room for the labels of the light above.
    fn ordinate_range(&self, channel: Channel) -> Range<f64> {
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for (source, _) in self.sources() {
            for point in self.curve(source, channel) {
                let se = finite(point.se);
                low = low.min(point.beta - se);
                high = high.max(point.beta + se);
            }
        }
        if high - low <= 0.0 {
            return 0.0..1.0;
        }
        let span = high - low;
        let below = if low < 0.0 { 0.06 * span } else { 0.0 };
        low - below..high + 0.12 * span
    }
}

impl Drawing for Graph<'_> {
    fn name(&self) -> String {
        name(self.number)
    }

    fn draw<DB: DrawingBackend>(&self, root: &Area<DB>) -> Drawn<DB> {
        chart_font();
        root.fill(&WHITE)?;
        let (width, height) = root.dim_in_pixel();
        let (width, height) = (width as i32 / SCALE, height as i32 / SCALE);

        root.draw_text(&self.title(), &text(TITLE_PX), at(MARGIN, 16))?;
        let top = draw_legend(root, self, width)?;

        let mut lines = Vec::new();
        for sentence in self.caption() {
            wrap(root, &sentence, width - 2 * MARGIN, &mut lines)?;
        }
        let bottom = height - 12 - CAPTION_LINE * lines.len() as i32;
        for (index, line) in lines.iter().enumerate() {
            let y = bottom + CAPTION_LINE * index as i32;
            root.draw_text(line, &text(TICK_PX), at(MARGIN, y))?;
        }

        let bottom = bottom - 8;
        let middle = top + (bottom - top) / 2;
        let split = width * 6 / 10;
        draw_panel(root, self, Channel::R, (0..split, top..bottom))?;
        draw_panel(root, self, Channel::G, (split..width, top..middle))?;
        draw_panel(root, self, Channel::B, (split..width, middle..bottom))
    }
}

/// Lines, bands and what the bands are, in as many rows as it takes; gives the ordinate below them.
fn draw_legend<DB: DrawingBackend>(root: &Area<DB>, graph: &Graph, width: i32) -> Result<i32, DrawingError<DB>> {
    const SAMPLE: i32 = 64;
    const ROW: i32 = 30;
    let (mut x, mut y) = (MARGIN, 64);
    let style = text(TEXT_PX);
    let mut place = |label: &str, sample: i32| -> Result<(i32, i32), DrawingError<DB>> {
        let needed = sample + root.estimate_text_size(label, &style)?.0 as i32 / SCALE + 32;
        if x > MARGIN && x + needed > width {
            (x, y) = (MARGIN, y + ROW);
        }
        let here = (x, y);
        x += needed;
        Ok(here)
    };
    for (source, look) in graph.present() {
        let (x, y) = place(&source.label, SAMPLE + 10)?;
        let band = look.colour.mix(look.band_opacity).filled();
        root.draw(&Rectangle::new([at(x, y), at(x + SAMPLE, y + 20)], band))?;
        let ends = [at(x, y + 10), at(x + SAMPLE, y + 10)];
        match look.dash {
            None => root.draw(&PathElement::new(ends, look.stroke()))?,
            Some((dash, gap)) => {
                for start in (0..SAMPLE).step_by((dash + gap) as usize) {
                    let end = (start + dash).min(SAMPLE);
                    let piece = [at(x + start, y + 10), at(x + end, y + 10)];
                    root.draw(&PathElement::new(piece, look.stroke()))?;
                }
            }
        }
        root.draw_text(&source.label, &style, at(x + SAMPLE + 10, y + 2))?;
    }
    let label = "bands: ±1 standard error (sample: standard uncertainty)";
    let (x, y) = place(label, 0)?;
    root.draw_text(label, &style, at(x, y + 2))?;
    Ok(y + ROW + 4)
}

fn draw_panel<DB: DrawingBackend>(
    root: &Area<DB>,
    graph: &Graph,
    channel: Channel,
    (columns, rows): (Range<i32>, Range<i32>),
) -> Drawn<DB> {
    let size = (columns.end - columns.start, rows.end - rows.start);
    let area = root.clone().shrink(at(columns.start, rows.start), at(size.0, size.1));
    let (views, ordinates) = (graph.view_range(), graph.ordinate_range(channel));
    let ticks = (size.1 / 45).max(3) as usize;
    let decimals = tick_decimals(&ordinates, ticks);
    let label = |beta: &f64| minus(format!("{beta:.decimals$}"));
    let mut label_width = 0;
    for tick in key_points(&ordinates, ticks) {
        label_width = label_width.max(root.estimate_text_size(&label(&tick), &text(TICK_PX))?.0 as i32 / SCALE);
    }
    let (left, label_width) = (16, label_width + 44);
    let mut chart = ChartBuilder::on(&area)
        .margin_left(left * SCALE)
        .margin_right(20 * SCALE)
        .margin_top(32 * SCALE)
        .margin_bottom(4 * SCALE)
        .x_label_area_size(56 * SCALE)
        .y_label_area_size(label_width * SCALE)
        .build_cartesian_2d(views.clone(), ordinates.clone())?;
    chart
        .configure_mesh()
        .x_labels((size.0 / 50).max(3) as usize)
        .y_labels(ticks)
        .x_label_formatter(&|angle| minus(format!("{angle:.0}")))
        .y_label_formatter(&label)
        .x_desc("signed view angle, degrees (− light's side, + mirror side)")
        .y_desc("brightness factor β, –")
        .label_style(text(TICK_PX))
        .axis_desc_style(text(TEXT_PX))
        .axis_style(BLACK.stroke_width(SCALE as u32))
        .bold_line_style(RGBColor(215, 215, 215).stroke_width(SCALE as u32))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(5 * SCALE)
        .draw()?;

    draw_directions(&mut chart, graph.theta_i_deg, &views, &ordinates)?;
    if ordinates.start < 0.0 {
        let zero = [(views.start, 0.0), (views.end, 0.0)];
        chart.draw_series([PathElement::new(zero, BLACK.stroke_width(SCALE as u32))])?;
    }

    let curves: Vec<_> = graph
        .sources()
        .map(|(source, look)| (graph.curve(source, channel), look))
        .collect();
    // No band may hide a line.
    for (points, look) in &curves {
        draw_band(&mut chart, points, *look)?;
    }
    for (points, look) in &curves {
        draw_line(&mut chart, points, *look)?;
    }
    let name = channel_name(channel);
    let title = if curves.iter().any(|(points, _)| !points.is_empty()) {
        name.to_owned()
    } else {
        format!("{name}: no data")
    };
    area.draw_text(&title, &text(PANEL_PX), at(left + label_width, 4))
}

/// Where the light comes from and where a mirror would send it.
fn draw_directions<DB: DrawingBackend>(
    chart: &mut PlotArea<DB>,
    theta_i_deg: f64,
    views: &Range<f64>,
    ordinates: &Range<f64>,
) -> Drawn<DB> {
    let marks: &[(f64, &str)] = if theta_i_deg == 0.0 {
        &[(0.0, "light, mirror")]
    } else {
        &[(-theta_i_deg, "light"), (theta_i_deg, "mirror")]
    };
    let grey = RGBColor(110, 110, 110);
    for &(angle, name) in marks.iter().filter(|(angle, _)| views.contains(angle)) {
        let line = [(angle, ordinates.start), (angle, ordinates.end)];
        chart.draw_series(DashedLineSeries::new(
            line,
            2 * SCALE,
            5 * SCALE,
            grey.stroke_width(SCALE as u32),
        ))?;
        let left_half = angle < (views.start + views.end) / 2.0;
        let (h_pos, shift) = if left_half { (HPos::Left, 6) } else { (HPos::Right, -6) };
        let style = text(TICK_PX).color(&grey).pos(Pos::new(h_pos, VPos::Top));
        let label = EmptyElement::at((angle, ordinates.end)) + Text::new(name, at(shift, 5), style);
        chart.draw_series([label])?;
    }
    Ok(())
}
