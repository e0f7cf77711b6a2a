use super::{Failure, Terminal};
use serde::Serialize;
use specval::formats::{
    self, AngleUnit, Axis, Channels, Component, Fold, Goniometric, Hemispherical, Parameters, Provenance, Quantity,
    ReadOptions, Scatter, Side, Table,
};
use std::fmt::Write;
use std::path::PathBuf;

/// What some formats leave open.
#[derive(Debug, clap::Args)]
pub struct Reading {
    /// The file holds transmission; for Integra and ASTM files, which do not say.
    #[arg(long, conflicts_with = "reflection")]
    transmission: bool,
    /// The file holds reflection, whatever its name.
    #[arg(long)]
    reflection: bool,
    /// Angles of an ASTM file are in degrees, not radians.
    #[arg(long)]
    degrees: bool,
    /// Factor from a UTIA file's numbers to 1/sr.
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    scale: Option<f64>,
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0".into()),
    }
}

impl Reading {
    pub fn options(&self) -> ReadOptions {
        let scatter = match (self.transmission, self.reflection) {
            (true, _) => Some(Scatter::Transmission),
            (_, true) => Some(Scatter::Reflection),
            _ => None,
        };
        ReadOptions {
            scatter,
            angle_unit: self.degrees.then_some(AngleUnit::Degrees),
            scale: self.scale,
        }
    }
}

/// What the file is, its angles, wavelengths, symmetry and provenance, the directional-hemispherical reflectance of each
/// incidence, and warnings.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Goniometric file of any format.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

#[derive(Serialize)]
struct Inspection {
    format: &'static str,
    provenance: Provenance,
    components: Vec<Part>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Part {
    scatter: Scatter,
    /// Where the light comes from.
    side: Side,
    quantity: Quantity,
    channels: Vec<String>,
    wavelength_nm: Option<Vec<f64>>,
    parameters: &'static str,
    axes: Vec<AxisRow>,
    symmetry: String,
    reflectance: Vec<Reflectance>,
}

#[derive(Serialize)]
struct AxisRow {
    name: &'static str,
    nodes_deg: Vec<f64>,
}

/// ∫ f cos θ dω, or the specular fraction, of light from azimuth 0.
#[derive(Serialize)]
struct Reflectance {
    theta_i_deg: f64,
    values: Vec<f64>,
    /// Estimated errors of the integration, not of the measurement.
    errors: Vec<f64>,
    /// Share of the projected hemisphere that was measured.
    measured: f64,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let data = formats::read(&arguments.file, &arguments.reading.options())?;
    terminal.result(&inspect(data), text)
}

fn inspect(data: Goniometric) -> Inspection {
    let mut warnings = data.warnings;
    let components: Vec<Part> = data.components.iter().map(part).collect();
    for part in &components {
        for r in &part.reflectance {
            let most = r.values.iter().copied().fold(0.0, f64::max);
            if most > 1.0 + 1e-3 {
                warnings.push(format!(
                    "more light leaves than comes at incidence {} degrees: {most:.4}",
                    r.theta_i_deg
                ));
            }
            if r.measured < 1.0 && part.quantity != Quantity::Fraction {
                warnings.push(format!(
                    "at incidence {} degrees {:.1} % of the projected hemisphere was measured; the rest counts as 0",
                    r.theta_i_deg,
                    100.0 * r.measured
                ));
            }
        }
    }
    Inspection {
        format: data.format.name(),
        provenance: data.provenance,
        components,
        warnings,
    }
}

fn part(component: &Component) -> Part {
    let (parameters, axes, fold) = describe(&component.table);
    let isotropic = if component.is_isotropic() {
        "isotropic"
    } else {
        "anisotropic"
    };
    let symmetry = match fold {
        Some(words) => format!("{isotropic}, {words}"),
        None => isotropic.to_owned(),
    };
    let reflectance = component.incidences_deg().into_iter().filter_map(|theta_i_deg| {
        let theta_i_rad = theta_i_deg.to_radians();
        let found = match &component.table {
            Table::Specular(table) => {
                let values = table.fraction(theta_i_rad, 0.0)?;
                let errors = vec![0.0; values.len()];
                let measured = 1.0;
                Hemispherical {
                    values,
                    errors,
                    measured,
                }
            }
            _ => component.directional_hemispherical(theta_i_rad, 0.0)?,
        };
        Some(Reflectance {
            theta_i_deg,
            values: found.values,
            errors: found.errors,
            measured: found.measured,
        })
    });
    Part {
        scatter: component.scatter,
        side: component.side,
        quantity: component.quantity,
        channels: component.channels.names(),
        wavelength_nm: match &component.channels {
            Channels::Wavelengths(grid) => Some(grid.nm().to_vec()),
            _ => None,
        },
        parameters,
        axes,
        symmetry,
        reflectance: reflectance.collect(),
    }
}

/// Name of the parameters, axes, and what symmetry shortened them.
fn describe(table: &Table) -> (&'static str, Vec<AxisRow>, Option<&'static str>) {
    let row = |name: &'static str, axis: &Axis| AxisRow {
        name,
        nodes_deg: axis
            .nodes_rad()
            .iter()
            .map(|a| (a.to_degrees() * 1e9).round() / 1e9)
            .collect(),
    };
    match table {
        Table::Grid(grid) => {
            let (parameters, names) = match grid.parameters() {
                Parameters::Spherical => ("spherical", ["theta_i", "phi_i", "theta_o", "phi_o"]),
                Parameters::Specular { .. } => (
                    "about the mirror direction",
                    ["theta_i", "phi_i", "theta_specular", "phi_specular"],
                ),
                Parameters::HalfDifference => ("half and difference vector", ["theta_h", "phi_h", "theta_d", "phi_d"]),
                Parameters::Distorted { .. } => (
                    "distorted spherical",
                    ["theta_i", "phi_i", "theta_distorted", "phi_distorted"],
                ),
            };
            let fold = match grid.fold() {
                Fold::None => None,
                Fold::Mirror => Some("mirror-symmetric about the plane of incidence"),
                Fold::HalfTurn => Some("reciprocal"),
                Fold::MirrorAndHalfTurn => Some("mirror-symmetric about the plane of incidence, reciprocal"),
            };
            let axes = names.into_iter().zip(grid.axes()).map(|(name, axis)| row(name, axis));
            (parameters, axes.collect(), fold)
        }
        Table::Scattered(_) => ("readings by direction", Vec::new(), None),
        Table::Warped(table) => (
            "half vector through a warp",
            vec![row("theta_i", table.incidence()), row("phi_i", table.azimuth())],
            None,
        ),
        Table::Klems(_) => ("Klems patches", Vec::new(), None),
        Table::Tree(_) => ("tensor tree", Vec::new(), None),
        Table::Specular(table) => ("incidence", vec![row("theta_i", table.incidence())], None),
    }
}

fn text(of: &Inspection) -> String {
    let mut text = format!("format       {}\n", of.format);
    if let Some(source) = &of.provenance.source {
        let _ = writeln!(text, "source       {source}");
    }
    for (name, value) in &of.provenance.statements {
        let _ = writeln!(text, "{name:<12} {}", value.escape_debug());
    }
    for comment in &of.provenance.comments {
        let _ = writeln!(text, "comment      {}", comment.escape_debug());
    }
    for part in &of.components {
        let quantity = match part.quantity {
            Quantity::Bsdf => "f, 1/sr",
            Quantity::BsdfCosine => "f cos(theta_o), 1/sr",
            Quantity::BrightnessFactor => "brightness factor, pi f",
            Quantity::Fraction => "fraction of the flux",
            Quantity::Unscaled => "of no stated scale",
        };
        let scatter = match part.scatter {
            Scatter::Reflection => "reflection",
            Scatter::Transmission => "transmission",
        };
        let side = if part.side == Side::Front { "front" } else { "back" };
        let _ = writeln!(text, "\n{scatter} of light from the {side}: {quantity}");
        let _ = writeln!(text, "channels     {}", part.channels.join(" "));
        let _ = writeln!(text, "parameters   {}; {}", part.parameters, part.symmetry);
        for axis in &part.axes {
            let nodes: Vec<String> = axis.nodes_deg.iter().map(|a| a.to_string()).collect();
            let shown = match nodes.len() {
                0..=20 => nodes.join(" "),
                n => format!("{} {} ... {} ({n} nodes)", nodes[0], nodes[1], nodes[n - 1]),
            };
            let _ = writeln!(text, "{:<14} {shown} deg", axis.name);
        }
        if !part.reflectance.is_empty() {
            let _ = writeln!(
                text,
                "theta_i, deg   hemispherical, a value a channel, and the largest error of its integration"
            );
        }
        for r in &part.reflectance {
            let values: Vec<String> = r.values.iter().map(|v| format!("{v:.6}")).collect();
            let error = r.errors.iter().copied().fold(0.0, f64::max);
            let _ = writeln!(text, "{:<14} {} ± {error:.1e}", r.theta_i_deg, values.join(" "));
        }
    }
    for warning in &of.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
