//! How charts draw the sources of each role.

use super::canvas::{Drawn, PlotArea, SCALE};
use crate::compare::{CurvePoint, Role};
use plotters::prelude::*;

/// Colour and line of a source: sources differ in print without colour as well.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub colour: RGBColor,
    /// Lengths of stroke and gap; `None` is a solid line.
    pub dash: Option<(i32, i32)>,
    pub width: i32,
    pub band_opacity: f64,
}

impl Look {
    pub fn stroke(self) -> ShapeStyle {
        self.colour.stroke_width((self.width * SCALE) as u32)
    }
}

/// Look of source number `place` of a role, from 0. The first of each role has the role's own colour and line; later
/// ones take the next shade and the next pattern of the role's dashes: long for models, medium for samples, dots for
/// classical models.
pub(super) fn look(role: Role, place: usize) -> Look {
    let (shades, dashes, width, band_opacity) = match role {
        Role::Model => (
            [(20, 70, 160), (0, 135, 150), (105, 60, 170), (70, 120, 40)],
            [None, Some((26, 4)), Some((20, 8)), Some((32, 12))],
            3,
            0.30,
        ),
        Role::Measured => (
            [(25, 25, 25), (120, 120, 120), (95, 70, 55), (60, 85, 90)],
            [Some((12, 7)), Some((8, 4)), Some((12, 14)), Some((8, 10))],
            2,
            0.16,
        ),
        Role::Classical => (
            [(205, 85, 0), (190, 30, 60), (170, 125, 0), (200, 70, 150)],
            [Some((3, 5)), Some((3, 10)), Some((3, 3)), Some((3, 15))],
            3,
            0.22,
        ),
    };
    let (red, green, blue) = shades[place % shades.len()];
    Look {
        colour: RGBColor(red, green, blue),
        dash: dashes[place % dashes.len()],
        width,
        band_opacity,
    }
}

/// A standard error to draw: none of one that is not known.
pub(super) fn finite(se: f64) -> f64 {
    if se.is_finite() { se } else { 0.0 }
}

/// Half the width a single view is drawn with, degrees.
const STUB_DEG: f64 = 2.0;

/// Abscissa, value and standard error of a curve; a single view becomes a short level stroke that a band can be seen
/// on.
fn strokes(points: &[&CurvePoint]) -> Vec<(f64, f64, f64)> {
    match points {
        [point] => [-STUB_DEG, STUB_DEG]
            .map(|shift| (point.theta_v_deg + shift, point.beta, finite(point.se)))
            .to_vec(),
        points => points.iter().map(|p| (p.theta_v_deg, p.beta, finite(p.se))).collect(),
    }
}

pub(super) fn draw_band<DB: DrawingBackend>(chart: &mut PlotArea<DB>, points: &[&CurvePoint], look: Look) -> Drawn<DB> {
    let strokes = strokes(points);
    if strokes.is_empty() || strokes.iter().any(|(_, _, se)| !se.is_finite()) {
        return Ok(());
    }
    let upper: Vec<_> = strokes.iter().map(|(angle, beta, se)| (*angle, beta + se)).collect();
    let lower: Vec<_> = strokes.iter().map(|(angle, beta, se)| (*angle, beta - se)).collect();
    let outline: Vec<_> = upper.iter().chain(lower.iter().rev()).copied().collect();
    let edge = look.colour.mix(0.5).stroke_width(SCALE as u32);
    chart.draw_series([Polygon::new(outline, look.colour.mix(look.band_opacity).filled())])?;
    chart.draw_series([upper, lower].map(|side| PathElement::new(side, edge)))?;
    Ok(())
}

pub(super) fn draw_line<DB: DrawingBackend>(chart: &mut PlotArea<DB>, points: &[&CurvePoint], look: Look) -> Drawn<DB> {
    let line: Vec<_> = strokes(points).iter().map(|(angle, beta, _)| (*angle, *beta)).collect();
    match look.dash {
        None => chart.draw_series([PathElement::new(line, look.stroke())])?,
        Some((dash, gap)) => {
            chart.draw_series(DashedLineSeries::new(line, dash * SCALE, gap * SCALE, look.stroke()))?
        }
    };
    let dot = |point: &&CurvePoint| Circle::new((point.theta_v_deg, point.beta), 3 * SCALE, look.colour.filled());
    chart.draw_series(points.iter().map(dot))?;
    Ok(())
}
