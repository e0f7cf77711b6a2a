use super::direction::{every_tenth_degree, rounded_deg};
use super::grid::Grid;
use super::kinds::{ChannelSet, FileProvenance, Format, Placement, Quantity, Scatter, Side};
use super::klems::KlemsMatrix;
use super::notice::ReadNotice;
use super::scattered::Scattered;
use super::specular::SpecularTable;
use super::tensor_tree::TensorTree;
use super::warped::Warped;
use crate::geometry::Vec3;

/// Goniometric data as one file holds them: values over incident and outgoing direction, in the file's own quantity,
/// parameters and nodes.
///
/// The normal is +z, all directions point away from the surface, azimuths run from x towards y.
#[derive(Clone, Debug, PartialEq)]
pub struct Goniometric {
    pub format: Format,
    /// Statements of the file about itself.
    pub provenance: FileProvenance,
    /// At least one.
    pub components: Vec<Component>,
    /// Assumptions and omissions of the reader.
    pub warnings: Vec<ReadNotice>,
}

/// One kind of scattering from one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    pub scatter: Scatter,
    /// Side the light comes from.
    pub side: Side,
    pub quantity: Quantity,
    pub channels: ChannelSet,
    pub table: Table,
}

/// Values in the parameters of their file.
#[derive(Clone, Debug, PartialEq)]
pub enum Table {
    /// A rectangular grid of four angles; linear between nodes.
    Grid(Grid),
    /// Readings at directions that need not form a grid.
    Scattered(Scattered),
    /// Half vectors through a warp.
    Warped(Warped),
    /// Constant on patches.
    Klems(KlemsMatrix),
    /// Constant on cells of an adaptive tree.
    Tree(TensorTree),
    /// By incident polar angle alone.
    Specular(SpecularTable),
}

impl Table {
    /// Evaluates for light and view both from above; `None` outside the measured range.
    pub(crate) fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec<f64>, Placement)> {
        match self {
            Self::Grid(grid) => grid.eval(omega_in, omega_out),
            Self::Scattered(scattered) => scattered.eval(omega_in, omega_out),
            Self::Warped(warped) => warped.eval(omega_in, omega_out),
            Self::Klems(matrix) => matrix.eval(omega_in, omega_out),
            Self::Tree(tree) => tree.eval(omega_in, omega_out),
            Self::Specular(_) => None,
        }
    }
}

/// Values at a pair of directions, one per channel, in the file's quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    pub quantity: Quantity,
    pub values: Vec<f64>,
    pub placement: Placement,
    /// |cos θ| of the outgoing direction.
    pub cos_out: f64,
}

impl Evaluation {
    /// f in 1/sr; `None` where the quantity has no f, or at the horizon of a quantity that holds the cosine.
    pub fn bsdf(&self) -> Option<Vec<f64>> {
        let all = self.values.iter().map(|&v| self.quantity.to_bsdf(v, self.cos_out));
        all.collect::<Option<Vec<f64>>>()
            .filter(|all| all.iter().all(|v| v.is_finite()))
    }

    /// β = π f.
    pub fn brightness_factor(&self) -> Option<Vec<f64>> {
        let mut beta = self.bsdf()?;
        beta.iter_mut().for_each(|v| *v *= std::f64::consts::PI);
        Some(beta)
    }
}

impl Goniometric {
    /// The component for the sides of `omega_in` and `omega_out`, and its values there. `None` outside the measured
    /// range.
    pub fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<Evaluation> {
        self.components.iter().find_map(|c| c.eval(omega_in, omega_out))
    }

    /// The component for a kind of scattering and a side of the light; `None` if the file has none.
    pub fn component(&self, scatter: Scatter, side: Side) -> Option<&Component> {
        self.components
            .iter()
            .find(|c| c.scatter == scatter && c.side == side && !matches!(c.table, Table::Specular(_)))
    }
}

impl Component {
    /// Description in words: "reflection of light from the front".
    pub fn words(&self) -> String {
        let scatter = match (self.scatter, &self.table) {
            (Scatter::Reflection, Table::Specular(_)) => "specular reflection",
            (Scatter::Transmission, Table::Specular(_)) => "regular transmission",
            (Scatter::Reflection, _) => "reflection",
            (Scatter::Transmission, _) => "transmission",
        };
        let side = if self.side == Side::Front { "front" } else { "back" };
        format!("{scatter} of light from the {side}")
    }

    /// Values at unit vectors towards the light and the viewer. `None` outside the measured range, on the wrong sides
    /// of the surface, and for specular tables.
    pub fn eval(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<Evaluation> {
        let (omega_in, omega_out) = self.upright(omega_in, omega_out)?;
        let (values, placement) = self.table.eval(&omega_in, &omega_out)?;
        Some(Evaluation {
            quantity: self.quantity,
            values,
            placement,
            cos_out: omega_out.z.max(0.0),
        })
    }

    /// Standard errors of the values of [`Component::eval`], one per channel, in the file's quantity; `None` if the
    /// file states none.
    pub fn standard_errors(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<Vec<f64>> {
        let Table::Scattered(scattered) = &self.table else {
            return None;
        };
        let (omega_in, omega_out) = self.upright(omega_in, omega_out)?;
        scattered.standard_errors(&omega_in, &omega_out)
    }

    /// Adds f in 1/sr of the pair rotated about the normal by each of the angles in radians, and removes from the list
    /// the angles that have a value. Terms that are invariant under rotation are evaluated once.
    pub(crate) fn add_bsdf_turned(
        &self,
        omega_in: &Vec3,
        omega_out: &Vec3,
        turns_rad: &mut Vec<f64>,
        sums: &mut [f64],
    ) {
        let Some((omega_in, omega_out)) = self.upright(omega_in, omega_out) else {
            return;
        };
        let factor = self.quantity.to_bsdf(1.0, omega_out.z.max(0.0));
        let Some(factor) = factor.filter(|factor| factor.is_finite()) else {
            return;
        };
        match &self.table {
            Table::Grid(grid) => grid.add_turned(&omega_in, &omega_out, turns_rad, factor, sums),
            Table::Scattered(scattered) => scattered.add_turned(&omega_in, &omega_out, turns_rad, factor, sums),
            Table::Warped(warped) => warped.add_turned(&omega_in, &omega_out, turns_rad, factor, sums),
            Table::Klems(_) | Table::Tree(_) => turns_rad.retain(|turn| {
                let (sin, cos) = turn.sin_cos();
                let turned = |d: &Vec3| Vec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z);
                let Some((values, _)) = self.table.eval(&turned(&omega_in), &turned(&omega_out)) else {
                    return true;
                };
                sums.iter_mut()
                    .zip(values)
                    .for_each(|(sum, value)| *sum += factor * value);
                false
            }),
            Table::Specular(_) => {}
        }
    }

    /// Both directions in the convention of tables: light and view from above. `None` on the wrong sides of the
    /// surface.
    fn upright(&self, omega_in: &Vec3, omega_out: &Vec3) -> Option<(Vec3, Vec3)> {
        let up = |side: Side| if side == Side::Front { 1.0 } else { -1.0 };
        let through = if self.scatter == Scatter::Reflection { 1.0 } else { -1.0 };
        let flipped = |d: &Vec3, sign: f64| Vec3::new(d.x, d.y, d.z * sign);
        let omega_in = flipped(omega_in, up(self.side));
        let omega_out = flipped(omega_out, up(self.side) * through);
        /// Cosines of directions on the horizon, with rounding.
        const HORIZON: f64 = -1e-9;
        (omega_in.z >= HORIZON && omega_out.z >= HORIZON).then_some((omega_in, omega_out))
    }

    /// The same table with other channels, by a linear map, if its interpolation is linear in the values: interpolating
    /// fewer channels is faster. `None` for other tables.
    pub(crate) fn with_channels(&self, channels: ChannelSet, map: impl Fn(&[f64]) -> Vec<f64>) -> Option<Self> {
        let count = channels.count();
        let table = match &self.table {
            Table::Grid(grid) => Table::Grid(grid.with_channels(count, map)?),
            Table::Scattered(scattered) => Table::Scattered(scattered.with_channels(count, map)),
            _ => return None,
        };
        Some(Self {
            channels,
            table,
            ..self.clone()
        })
    }

    /// Incident polar angles of the table's own nodes, in degrees; for tables over half vectors every tenth degree.
    pub fn incidences_deg(&self) -> Vec<f64> {
        let nodes_rad = match &self.table {
            Table::Grid(grid) => grid.incidences_rad(),
            Table::Scattered(scattered) => scattered.incidences_rad(),
            Table::Warped(warped) => warped.incidences_rad(),
            Table::Klems(matrix) => matrix.incidences_rad(),
            Table::Specular(specular) => specular.incidence().nodes_rad().to_vec(),
            Table::Tree(_) => every_tenth_degree(),
        };
        nodes_rad.into_iter().map(rounded_deg).collect()
    }

    /// Whether the table is invariant under rotation about the normal because it has no incident azimuths.
    pub fn is_isotropic(&self) -> bool {
        match &self.table {
            Table::Grid(grid) => grid.is_isotropic(),
            Table::Scattered(scattered) => scattered.is_isotropic(),
            Table::Warped(warped) => warped.is_isotropic(),
            Table::Klems(_) => false,
            Table::Tree(tree) => tree.is_isotropic(),
            Table::Specular(_) => true,
        }
    }
}
