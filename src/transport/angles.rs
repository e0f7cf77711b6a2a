use super::lane_math::LANES;
use crate::fault::{self, Fault};
use crate::optics::{Phase, PhaseTable};

/// Scattering angles drawn from phase functions, one for each lane.
pub(super) struct Deflections {
    /// Column of the alias table it is drawn from, position in that column from 0 to 1, and contents of the column.
    column: [u64; LANES],
    rest: [f64; LANES],
    fetched: Fetched,
    pub cos_theta: [f64; LANES],
    /// Interval between nodes of the table that contains the angle (an index, stored as a float), and position in it
    /// from the first node (0) to the second (1). Undefined if the phase functions are not tables.
    pub interval: [f64; LANES],
    pub place: [f64; LANES],
}

impl Default for Deflections {
    fn default() -> Self {
        Self {
            column: [0; LANES],
            rest: [0.0; LANES],
            fetched: Fetched::default(),
            cos_theta: [0.0; LANES],
            interval: [0.0; LANES],
            place: [0.0; LANES],
        }
    }
}

/// Contents of the alias-table column of each lane.
struct Fetched {
    own: [f32; LANES],
    alias: [f32; LANES],
    own_lean: [f32; LANES],
    alias_lean: [f32; LANES],
}

impl Default for Fetched {
    fn default() -> Self {
        Self {
            own: [1.0; LANES],
            alias: [0.0; LANES],
            own_lean: [0.5; LANES],
            alias_lean: [0.5; LANES],
        }
    }
}

/// Phase functions of several wavelengths, prepared for sampling.
#[derive(Clone, Debug)]
pub(super) enum Angles<'a> {
    Tables(Columns),
    Functions(Vec<&'a Phase>),
}

/// Alias tables on common nodes. Walker's alias method chooses the interval, whose linear density is then inverted,
/// without a branch or a search. Columns are stored wavelength by wavelength.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    intervals: usize,
    columns: Vec<Column>,
}

/// A column in single precision: a relative error of 10⁻⁸ in a probability is harmless, and a table then fits the
/// first-level cache.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// Probability of the column's own interval; the rest belongs to the interval `alias` (an index, stored as a
    /// float).
    own: f32,
    alias: f32,
    /// Density at the first node over the sum at both nodes, for the interval and for its alias.
    lean: [f32; 2],
}

/// 2⁵²: adding it to an integer stored as a float moves the integer to the low bits.
const WHOLE: f64 = 4_503_599_627_370_496.0;

impl<'a> Angles<'a> {
    pub fn new(phases: &[&'a Phase]) -> Self {
        match common_tables(phases) {
            Some((nodes, tables)) => {
                let intervals = nodes - 1;
                let columns = tables.iter().flat_map(|table| columns(table)).collect();
                Self::Tables(Columns { intervals, columns })
            }
            None => Self::Functions(phases.to_vec()),
        }
    }

    /// First half of a draw from the phase function of each lane's wavelength (an index, stored as a float), with a
    /// uniform random number `u` in [0, 1). Separate from [`Angles::draw`] because vector loads stall on values just
    /// written lane by lane.
    #[inline(always)]
    pub fn fetch(&self, wavelength: &[f64; LANES], u: &[f64; LANES], deflection: &mut Deflections) {
        match self {
            Self::Tables(columns) if fault::active(Fault::NeighbourAngle) => {
                let wavelengths = (columns.columns.len() / columns.intervals) as f64;
                columns.fetch(&wavelength.map(|w| (w + 1.0) % wavelengths), u, deflection);
            }
            Self::Tables(columns) => columns.fetch(wavelength, u, deflection),
            Self::Functions(phases) => {
                for lane in 0..LANES {
                    deflection.cos_theta[lane] = phases[wavelength[lane] as usize].sample(u[lane]);
                }
            }
        }
    }

    /// Second half of a draw: computes the angles from what [`Angles::fetch`] loaded.
    #[inline(always)]
    pub fn draw(&self, deflection: &mut Deflections) {
        if let Self::Tables(columns) = self {
            columns.draw(deflection);
        }
    }
}

impl Columns {
    #[inline(always)]
    fn fetch(&self, wavelength: &[f64; LANES], u: &[f64; LANES], deflection: &mut Deflections) {
        let intervals = self.intervals as f64;
        for i in 0..LANES {
            let at = u[i] * intervals;
            let near = (at + WHOLE) - WHOLE;
            let k = if near > at { near - 1.0 } else { near };
            deflection.interval[i] = k;
            deflection.rest[i] = at - k;
            deflection.column[i] = (wavelength[i] * intervals + k + WHOLE).to_bits() & u64::from(u32::MAX);
        }
        // A separate loop with a bounds check, so that the compiler does not emit the much slower gather instruction.
        for i in 0..LANES {
            let column = &self.columns[deflection.column[i] as usize];
            deflection.fetched.own[i] = column.own;
            deflection.fetched.alias[i] = column.alias;
            [deflection.fetched.own_lean[i], deflection.fetched.alias_lean[i]] = column.lean;
        }
    }

    #[inline(always)]
    fn draw(&self, deflection: &mut Deflections) {
        let step = 1.0 / self.intervals as f64;
        let of = &deflection.fetched;
        let (mut v, mut lean) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (k, rest) = (deflection.interval[i], deflection.rest[i]);
            // Load both alternatives first: choosing between loads would be a branch.
            let own = f64::from(of.own[i]);
            let (lean_here, lean_there) = (f64::from(of.own_lean[i]), f64::from(of.alias_lean[i]));
            let (below, above, alias) = (own, 1.0 - own, f64::from(of.alias[i]));
            let mine = rest < own;
            let from = if mine { 0.0 } else { own };
            let width = if mine { below } else { above };
            v[i] = (rest - from) / width;
            lean[i] = if mine { lean_here } else { lean_there };
            deflection.interval[i] = if mine { k } else { alias };
        }
        for i in 0..LANES {
            let root = (lean[i] * lean[i] + (1.0 - 2.0 * lean[i]) * v[i]).max(0.0).sqrt();
            let place = v[i] / (lean[i] + root).max(f64::MIN_POSITIVE);
            let t = deflection.interval[i] * step;
            deflection.cos_theta[i] = 1.0 - 2.0 * (t * t + place * step * (2.0 * t + step));
            deflection.place[i] = place;
        }
    }
}

/// Columns of Walker's alias method for one table, by Vose's algorithm (1991).
fn columns(table: &PhaseTable) -> Vec<Column> {
    let density = table.density();
    let intervals = density.len() - 1;
    // Interval k is 2(2k + 1)/n² wide in cos θ.
    let mut share: Vec<f64> = (0..intervals)
        .map(|k| (density[k] + density[k + 1]) * (2 * k + 1) as f64)
        .collect();
    let total: f64 = share.iter().sum();
    share.iter_mut().for_each(|s| *s *= intervals as f64 / total);
    let lean = |k: usize| {
        let sum = density[k] + density[k + 1];
        if sum > 0.0 { (density[k] / sum) as f32 } else { 0.5 }
    };
    let mut columns: Vec<Column> = (0..intervals)
        .map(|k| Column {
            own: 1.0,
            alias: k as f32,
            lean: [lean(k); 2],
        })
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..intervals).partition(|&k| share[k] < 1.0);
    while let (Some(poor), Some(&rich)) = (small.pop(), large.last()) {
        columns[poor].own = share[poor] as f32;
        columns[poor].alias = rich as f32;
        columns[poor].lean[1] = lean(rich);
        share[rich] -= 1.0 - share[poor];
        if share[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
    columns
}

/// Number of nodes and tables of the phase functions, if all are tables on the same nodes.
pub(super) fn common_tables<'a>(phases: &[&'a Phase]) -> Option<(usize, Vec<&'a PhaseTable>)> {
    let tables: Vec<&PhaseTable> = phases
        .iter()
        .filter_map(|phase| match phase {
            Phase::Table(table) => Some(table),
            Phase::HenyeyGreenstein(_) => None,
        })
        .collect();
    let nodes = tables.first()?.density().len();
    let alike = tables.len() == phases.len() && tables.iter().all(|table| table.density().len() == nodes);
    alike.then_some((nodes, tables))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stratified draws reproduce the distribution: the mean cosine is g, and the frequency of each interval is its
    /// integral.
    #[test]
    fn draws_follow_the_table() {
        let table = PhaseTable::from_density(181, |c| 0.1 + (1.0 + c).powi(4)).unwrap();
        let (g, density) = (table.g(), table.density().to_vec());
        let phase = Phase::Table(table);
        let angles = Angles::new(&[&phase, &phase]);
        let n = 2_000_000;
        let mut mean = 0.0;
        let mut shares = vec![0.0; 180];
        let mut deflection = Deflections::default();
        for i in 0..n / LANES {
            let u = std::array::from_fn(|lane| ((i * LANES + lane) as f64 + 0.5) / n as f64);
            angles.fetch(&[1.0; LANES], &u, &mut deflection);
            angles.draw(&mut deflection);
            for lane in 0..LANES {
                mean += deflection.cos_theta[lane] / n as f64;
                shares[deflection.interval[lane] as usize] += 1.0 / n as f64;
                assert!((0.0..=1.0).contains(&deflection.place[lane]));
            }
        }
        assert!((mean - g).abs() < 1e-6, "{mean} {g}");
        for (k, share) in shares.iter().enumerate() {
            let expected =
                std::f64::consts::PI * (density[k] + density[k + 1]) * 2.0 * (2 * k + 1) as f64 / (180.0 * 180.0);
            assert!((share - expected).abs() < 2e-6, "interval {k}: {share} {expected}");
        }
    }
}
