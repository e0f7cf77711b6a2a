//! Charts as files: what a chart is, and its pictures as SVG and PNG.

use super::canvas::{Area, Drawn};
use crate::output::NamedFile;
use crate::report::error::ReportError;
use crate::report::result::ReportData;
use plotters::prelude::*;
use rayon::prelude::*;

/// Width and height of a picture, px.
const SIZE: (u32, u32) = (1600, 1000);
/// Pictures are drawn this many times larger, in whole pixels. The SVG is shown smaller by its view box, the PNG is
/// averaged down: both come from the same strokes and have smooth edges.
const OVERSAMPLING: u32 = 2;

/// What is known of a report before it is run.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// Incidences that have curves, at most.
    pub incidences: usize,
    pub approximations: bool,
}

/// A chart of the report: a row of [`super::CHARTS`].
pub struct Chart {
    /// Names of its pictures, without extension, in a report of this outline; none where it does not apply.
    pub names: fn(&Outline) -> Vec<String>,
    /// Its pictures of a result: [`files`] of them.
    pub files: fn(&ReportData) -> Result<Vec<NamedFile>, ReportError>,
}

/// One picture of a chart.
pub(super) trait Drawing: Sync {
    /// Of the file, without extension.
    fn name(&self) -> String;

    fn draw<DB: DrawingBackend>(&self, root: &Area<DB>) -> Drawn<DB>;
}

/// Names of the files that [`files`] makes of a picture.
pub(crate) fn file_names(picture: &str) -> [String; 2] {
    ["svg", "png"].map(|extension| format!("{picture}.{extension}"))
}

/// Pictures as files.
pub(super) fn files<D: Drawing>(drawings: &[D]) -> Result<Vec<NamedFile>, ReportError> {
    let pictures: Vec<[NamedFile; 2]> = drawings
        .par_iter()
        .map(|drawing| {
            let [vector, pixels] = file_names(&drawing.name());
            Ok([
                NamedFile {
                    name: vector,
                    bytes: svg(drawing)?.into_bytes(),
                },
                NamedFile {
                    name: pixels,
                    bytes: png(drawing)?,
                },
            ])
        })
        .collect::<Result<_, ReportError>>()?;
    Ok(pictures.into_iter().flatten().collect())
}

/// An SVG document of 1600 by 1000 px that loads nothing.
pub(super) fn svg(of: &impl Drawing) -> Result<String, ReportError> {
    let (width, height) = drawn_size();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
        of.draw(&root).map_err(failed(of))?;
        root.present().map_err(failed(of))?;
    }
    Ok(text.replacen(
        &format!("width=\"{width}\" height=\"{height}\""),
        &format!("width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1),
        1,
    ))
}

/// A PNG of 1600 by 1000 px, 8-bit RGB.
pub(super) fn png(of: &impl Drawing) -> Result<Vec<u8>, ReportError> {
    let (width, height) = drawn_size();
    let mut pixels = vec![0; width as usize * height as usize * 3];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        of.draw(&root).map_err(failed(of))?;
        root.present().map_err(failed(of))?;
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
        .map_err(failed(of))?;
    Ok(bytes)
}

fn failed<E: std::fmt::Display>(of: &impl Drawing) -> impl Fn(E) -> ReportError {
    let picture = of.name();
    move |error| ReportError::Drawing {
        picture: picture.clone(),
        reason: error.to_string(),
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
