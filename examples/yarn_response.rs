//! Plots the yarn response f* of the built-in yarn in the plane across it: yarn_response.svg, or the file named.

use plotters::prelude::*;
use specval::geometry::Vec3;
use specval::report::chart_font;
use specval::run::Plan;
use specval::study::Study;
use specval::yarn::DirectTracer;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plan = Plan::new(Study::default())?;
    let tracer = DirectTracer::new(&plan.yarn, plan.factor_grid, plan.direct_effort, None)?;
    let response = tracer.batch(0).response;
    let direction = |degrees: f64| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let factor = |view_deg: f64| response.eval(&direction(-30.0), &direction(view_deg));

    let path = std::env::args().nth(1).unwrap_or("yarn_response.svg".into());
    let drawing = SVGBackend::new(&path, (800, 500)).into_drawing_area();
    drawing.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&drawing)
        .caption("f* at the lit side, light at -30°, 1/sr", (chart_font(), 20))
        .margin(10)
        .set_all_label_area_size(50)
        .build_cartesian_2d(-80.0..80.0, 0.0..1.2 * factor(0.0)[25])?;
    let mut axes = chart.configure_mesh();
    axes.x_desc("view angle, degrees").draw()?;
    for (wavelength, colour) in [(6, BLUE), (15, GREEN), (25, RED)] {
        let label = format!("{} nm", plan.grid.nm()[wavelength]);
        let curve = (-80..=80).map(|view| (f64::from(view), factor(f64::from(view))[wavelength]));
        let drawn = chart.draw_series(LineSeries::new(curve, colour))?.label(label);
        drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour));
    }
    chart.configure_series_labels().label_font((chart_font(), 14)).draw()?;
    Ok(drawing.present()?)
}
