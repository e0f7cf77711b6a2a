use super::super::notice::worded;
use super::super::{Failure, Terminal, in_words};
use super::ChosenComponent;
use super::series::Series;
use serde::Serialize;
use specval::formats::registry;
use specval::formats::{
    Axis, ChannelSet, Component, Directions, FileProvenance, Fold, Goniometric, Hemispherical, KlemsBasis, Parameters,
    Quantity, Scatter, Scattered, Side, Table,
};
use specval::number::significant;
use std::fmt::Write;
use std::path::Path;

#[derive(Serialize)]
struct Inspection {
    format: &'static str,
    provenance: FileProvenance,
    /// How the format's own words for the sides are meant.
    convention: Option<&'static str>,
    components: Vec<Part>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Part {
    #[serde(skip)]
    words: String,
    scatter: Scatter,
    /// Where the light comes from.
    side: Side,
    quantity: Quantity,
    channels: Vec<String>,
    wavelength_nm: Option<Vec<f64>>,
    parameters: String,
    axes: Vec<AxisRow>,
    /// Pairs of directions that the file has values for, in its own parameters.
    pairs: usize,
    symmetry: String,
    reflectance: Vec<Reflectance>,
}

#[derive(Serialize)]
struct AxisRow {
    name: &'static str,
    #[serde(rename = "nodes_deg")]
    nodes: Series,
    count: usize,
    /// Where all steps are equal.
    step_deg: Option<f64>,
}

impl AxisRow {
    fn new(name: &'static str, nodes_deg: Vec<f64>) -> Self {
        let nodes = Series::new(nodes_deg);
        Self {
            name,
            count: nodes.count(),
            step_deg: nodes.step(),
            nodes,
        }
    }
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

pub fn show(path: &Path, data: Goniometric, chosen: &ChosenComponent, terminal: &Terminal) -> Result<(), Failure> {
    let inspection = inspect(data, chosen).map_err(|error| format!("{}: {error}", in_words(path)))?;
    terminal.result(&inspection, text)
}

/// None of the components was asked for.
#[derive(Debug, thiserror::Error)]
#[error("expected a component that --scatter and --side name, found {found}; leave them out to see all")]
struct NoneChosen {
    found: String,
}

fn inspect(data: Goniometric, chosen: &ChosenComponent) -> Result<Inspection, Failure> {
    let mut warnings: Vec<String> = worded(&data.warnings).collect();
    let components: Vec<Part> = data.components.iter().filter(|c| chosen.holds(c)).map(part).collect();
    if components.is_empty() {
        let found: Vec<String> = data.components.iter().map(Component::words).collect();
        let found = found.join("; ");
        return Err(NoneChosen { found }.into());
    }
    for part in &components {
        warnings.extend(part.warnings());
    }
    Ok(Inspection {
        format: data.format.name(),
        provenance: data.provenance,
        convention: registry::descriptor(data.format).convention,
        components,
        warnings,
    })
}

impl Part {
    /// One for each kind, with how often it is met.
    fn warnings(&self) -> Vec<String> {
        let rows = &self.reflectance;
        let mut warnings = Vec::new();
        let most = |r: &Reflectance| r.values.iter().copied().fold(0.0, f64::max);
        let above = rows.iter().filter(|r| most(r) > 1.0 + 1e-3);
        if let Some(worst) = above.clone().max_by(|a, b| most(a).total_cmp(&most(b))) {
            warnings.push(format!(
                "more light leaves than comes at {} of {} incidences, most at {} degrees: {:.4}",
                above.count(),
                rows.len(),
                worst.theta_i_deg,
                most(worst)
            ));
        }
        let partial = rows
            .iter()
            .filter(|r| r.measured < 1.0 && self.quantity != Quantity::Fraction);
        if let Some(worst) = partial.clone().min_by(|a, b| a.measured.total_cmp(&b.measured)) {
            warnings.push(format!(
                "at {} of {} incidences the projected hemisphere was measured in part alone, least at {} degrees: \
                 {:.1} %; the rest counts as 0",
                partial.count(),
                rows.len(),
                worst.theta_i_deg,
                100.0 * worst.measured
            ));
        }
        warnings
    }
}

fn part(component: &Component) -> Part {
    let Described {
        parameters,
        axes,
        pairs,
        fold,
    } = describe(component);
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
        words: component.words(),
        scatter: component.scatter,
        side: component.side,
        quantity: component.quantity,
        channels: component.channels.names(),
        wavelength_nm: match &component.channels {
            ChannelSet::Wavelengths(grid) => Some(grid.nm().to_vec()),
            _ => None,
        },
        parameters,
        axes,
        pairs,
        symmetry,
        reflectance: reflectance.collect(),
    }
}

struct Described {
    parameters: String,
    axes: Vec<AxisRow>,
    pairs: usize,
    /// What symmetry shortened the axes.
    fold: Option<&'static str>,
}

fn describe(component: &Component) -> Described {
    let row = |name: &'static str, axis: &Axis| {
        let nodes = axis.nodes_rad().iter();
        AxisRow::new(name, nodes.map(|a| (a.to_degrees() * 1e9).round() / 1e9).collect())
    };
    let mut fold = None;
    let (parameters, axes, pairs) = match &component.table {
        Table::Grid(grid) => {
            let (parameters, names) = names_of(component.scatter, grid.parameters());
            fold = match grid.fold() {
                Fold::None => None,
                Fold::Mirror => Some("mirror-symmetric about the plane of incidence"),
                Fold::HalfTurn => Some("reciprocal"),
                Fold::MirrorAndHalfTurn => Some("mirror-symmetric about the plane of incidence, reciprocal"),
            };
            let axes = names.into_iter().zip(grid.axes()).map(|(name, axis)| row(name, axis));
            (parameters, axes.collect(), grid.shape().iter().product())
        }
        Table::Scattered(scattered) => {
            let (axes, count) = axes_of(scattered);
            ("readings by direction".to_owned(), axes, count)
        }
        Table::Warped(table) => {
            fold = table.symmetry();
            let (theta, phi) = (row("theta_i", table.incidence()), row("phi_i", table.azimuth()));
            let square = table.size() * table.size();
            let pairs = theta.count * phi.count * square;
            let n = table.size();
            let parameters = format!("half vector through a warp, {n} x {n} nodes at each incidence");
            (parameters, vec![theta, phi], pairs)
        }
        Table::Klems(matrix) => {
            let (incident, exiting) = (matrix.incident(), matrix.exiting());
            let words = |basis: &KlemsBasis| format!("{} of {}", basis.count(), basis.name);
            let parameters = format!("patches: {} incident, {} exiting", words(incident), words(exiting));
            let axes = vec![limits("theta_i_limits", incident), limits("theta_o_limits", exiting)];
            (parameters, axes, incident.count() * exiting.count())
        }
        Table::Tree(tree) => {
            let rank = if tree.is_isotropic() { 3 } else { 4 };
            let cells = tree.cells();
            let parameters =
                format!("tensor tree of rank {rank}, {cells} cells; directions by place in the unit square");
            (parameters, Vec::new(), cells)
        }
        Table::Specular(table) => {
            let (theta, phi) = (row("theta_i", table.incidence()), row("phi_i", table.azimuth()));
            let pairs = theta.count * phi.count;
            let mirror = match component.scatter {
                Scatter::Reflection => "mirror direction alone, by incidence",
                Scatter::Transmission => "straight direction alone, by incidence",
            };
            (mirror.to_owned(), vec![theta, phi], pairs)
        }
    };
    Described {
        parameters,
        axes,
        pairs,
        fold,
    }
}

/// Words for the parameters and names of the four angles.
fn names_of(scatter: Scatter, parameters: &Parameters) -> (String, [&'static str; 4]) {
    let tilted = |offsets_rad: &[f64]| match offsets_rad.iter().any(|&offset| offset != 0.0) {
        true => ", tilted by an offset at each incidence",
        false => "",
    };
    let through = scatter == Scatter::Transmission;
    let axis = if through { "straight" } else { "mirror" };
    match parameters {
        Parameters::Spherical => ("spherical".into(), ["theta_i", "phi_i", "theta_o", "phi_o"]),
        Parameters::HalfDifference => (
            "half and difference vector".into(),
            ["theta_h", "phi_h", "theta_d", "phi_d"],
        ),
        Parameters::Specular { offsets_rad } => (
            format!("about the {axis} direction{}", tilted(offsets_rad)),
            match through {
                true => ["theta_i", "phi_i", "theta_straight", "phi_straight"],
                false => ["theta_i", "phi_i", "theta_specular", "phi_specular"],
            },
        ),
        Parameters::Distorted { offsets_rad } => (
            format!("distorted spherical, about the {axis} direction{}", tilted(offsets_rad)),
            ["theta_i", "phi_i", "theta_distorted", "phi_distorted"],
        ),
    }
}

fn limits(name: &'static str, basis: &KlemsBasis) -> AxisRow {
    let upper = basis.rings().map(|([_, upper], _)| upper);
    AxisRow::new(name, std::iter::once(0.0).chain(upper).collect())
}

/// Each angle's different values, and the number of readings.
fn axes_of(scattered: &Scattered) -> (Vec<AxisRow>, usize) {
    let names: &[&'static str] = match scattered.directions() {
        Directions::Sphere => &["theta_i", "phi_i", "theta_o", "phi_o"],
        Directions::Plane => &["theta_i", "theta_v"],
    };
    let readings = scattered.readings();
    let axis = |(level, name): (usize, &&'static str)| {
        let all = readings
            .iter()
            .map(|(angles, _)| (angles[level].to_degrees() * 1e9).round() / 1e9);
        AxisRow::new(name, all.collect())
    };
    (names.iter().enumerate().map(axis).collect(), readings.len())
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
    if let Some(convention) = of.convention {
        let _ = writeln!(text, "convention   {convention}");
    }
    for part in &of.components {
        let quantity = match part.quantity {
            Quantity::Bsdf => "f, 1/sr",
            Quantity::BsdfCosine => "f cos(theta_o), 1/sr",
            Quantity::BrightnessFactor => "brightness factor, pi f",
            Quantity::Fraction => "fraction of the flux",
            Quantity::Unscaled => "of no stated scale",
        };
        let _ = writeln!(text, "\n{}: {quantity}", part.words);
        let channels = match &part.wavelength_nm {
            Some(nm) => format!("{} nm", Series::new(nm.clone()).words()),
            None => part.channels.join(" "),
        };
        let _ = writeln!(text, "channels     {channels}");
        let _ = writeln!(text, "parameters   {}; {}", part.parameters, part.symmetry);
        for axis in &part.axes {
            let _ = writeln!(text, "{:<14} {} deg", axis.name, axis.nodes.words());
        }
        let _ = writeln!(text, "pairs of directions {}", part.pairs);
        if !part.reflectance.is_empty() {
            let _ = writeln!(
                text,
                "theta_i, deg   hemispherical, a value a channel, and the largest error of its integration"
            );
        }
        for r in &part.reflectance {
            let values: Vec<String> = r.values.iter().map(|v| format!("{v:.6}")).collect();
            let error = r.errors.iter().copied().fold(0.0, f64::max);
            let _ = writeln!(
                text,
                "{:<14} {} ± {}",
                r.theta_i_deg,
                values.join(" "),
                significant(error, 2)
            );
        }
    }
    for warning in &of.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
