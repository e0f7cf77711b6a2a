use super::chart::{self, Figure};
use super::{ReportData, ReportError};
use crate::compare::Role;
use plotters::prelude::*;

/// Width and height of a graph, px.
const SIZE: (u32, u32) = (1600, 1000);
/// Graphs are drawn this many times larger, in whole pixels. The SVG is shown smaller by its view box, the PNG is
/// averaged down: both come from the same strokes and have smooth edges.
const OVERSAMPLING: u32 = 2;

/// One of graphs 1, 2, 3… (model and measured, one an incidence) and the following ones (the classical model beside
/// them), numbered as in the preprint for its three incidences.
#[derive(Debug)]
pub struct Graph<'a> {
    figure: Figure<'a>,
}

/// Every graph of the result, in order; two for each incidence that has a curve. Where the geometries are the sample's own, an
/// incidence that it was not measured at, added for Table 1, has none.
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
            figure: Figure {
                number: index + 1,
                theta_i_deg,
                roles,
                data,
            },
        })
        .collect()
}

impl Graph<'_> {
    /// 1 for the first.
    pub fn number(&self) -> usize {
        self.figure.number
    }

    /// The graph as an SVG document of 1600 by 1000 px; it loads nothing.
    pub fn svg(&self) -> Result<String, ReportError> {
        let (width, height) = drawn_size();
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
            chart::draw(&root, &self.figure).map_err(|error| self.drawing(error))?;
            root.present().map_err(|error| self.drawing(error))?;
        }
        Ok(text.replacen(
            &format!("width=\"{width}\" height=\"{height}\""),
            &format!("width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1),
            1,
        ))
    }

    /// The graph as a PNG of 1600 by 1000 px, 8-bit RGB.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        let (width, height) = drawn_size();
        let mut pixels = vec![0; width as usize * height as usize * 3];
        {
            let root = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
            chart::draw(&root, &self.figure).map_err(|error| self.drawing(error))?;
            root.present().map_err(|error| self.drawing(error))?;
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, SIZE.0, SIZE.1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Default);
        encoder.set_depth(png::BitDepth::Eight);
        // Flat areas: a third of the size the default filter gives.
        encoder.set_filter(png::FilterType::NoFilter);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(&averaged(&pixels)))
            .map_err(|error| self.drawing(error))?;
        Ok(bytes)
    }

    fn drawing(&self, error: impl std::fmt::Display) -> ReportError {
        ReportError::Drawing {
            graph: self.number(),
            reason: error.to_string(),
        }
    }
}

fn drawn_size() -> (u32, u32) {
    (SIZE.0 * OVERSAMPLING, SIZE.1 * OVERSAMPLING)
}

/// Means of squares of `OVERSAMPLING` by `OVERSAMPLING` pixels.
fn averaged(pixels: &[u8]) -> Vec<u8> {
    let n = OVERSAMPLING as usize;
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let mut out = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let mut sum = 0;
                for dy in 0..n {
                    for dx in 0..n {
                        sum += usize::from(pixels[((y * n + dy) * width * n + x * n + dx) * 3 + channel]);
                    }
                }
                out.push(((sum + n * n / 2) / (n * n)) as u8);
            }
        }
    }
    out
}
