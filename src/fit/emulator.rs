use super::FitError;
use super::forward::{ForwardModel, ForwardRun, node_weights};
use crate::yarn::LengthBins;
use nalgebra::{DMatrix, SVD};
use ndarray::{Array1, Array2, Array3, Axis};

/// A forward model near a point, from traced runs about it: each bin of the tables is a quadratic function of the
/// point's coordinates, fitted to the runs. A fit on it needs no tracing, and the noise of a prediction is that of all
/// runs together divided by the number of coefficients.
///
/// The fit to bins is linear in their values, so it equals the same fit to β at every absorption.
#[derive(Clone, Debug)]
pub struct Emulator {
    centre: Vec<f64>,
    quadratic: bool,
    /// `[coefficient]` of `[node][geometry][bin]`.
    amounts: Vec<Array3<f64>>,
    /// `[coefficient][wavelength]`: the study's own absorption.
    mu_a_per_mm: Array2<f64>,
    /// `[coefficient][parameter]`: values of the traced parameters.
    values: Array2<f64>,
    /// `[node][bin]`.
    mean_mm: Array2<f64>,
    reference_mu_a_per_mm: Vec<f64>,
    bins: LengthBins,
    /// `[wavelength][node]`.
    node_weights: Array2<f64>,
}

/// Factor by which less absorption than was traced may raise a bin: beyond it the bin holds no light worth the name,
/// and the factor overflows.
const MOST_GROWTH: f64 = 1e12;

/// Which batches of the runs count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Batches {
    All,
    One(usize),
}

impl Emulator {
    /// Number of coefficients of a quadratic function of so many coordinates.
    pub fn coefficients(coordinates: usize) -> usize {
        (coordinates + 1) * (coordinates + 2) / 2
    }

    /// From runs about a centre: quadratic where they are more than its coefficients, linear where they are more than
    /// those of a linear function, else constant. All runs count alike.
    ///
    /// # Errors
    /// [`FitError::NoRuns`] without a run.
    pub fn new(
        model: &dyn ForwardModel,
        runs: &[&ForwardRun],
        centre: &[f64],
        batches: Batches,
    ) -> Result<Self, FitError> {
        let first = runs.first().ok_or(FitError::NoRuns)?;
        let coordinates = centre.len();
        let quadratic = runs.len() > Self::coefficients(coordinates);
        let count = match runs.len() {
            n if n > Self::coefficients(coordinates) => Self::coefficients(coordinates),
            n if n > coordinates + 1 => coordinates + 1,
            _ => 1,
        };
        let rows: Vec<Vec<f64>> = (runs.iter())
            .map(|run| terms(&run.point, centre, quadratic).take(count).collect())
            .collect();
        let design = DMatrix::from_fn(runs.len(), count, |r, c| rows[r][c]);
        let inverse = SVD::new(design, true, true)
            .pseudo_inverse(1e-9)
            .map_err(|_| FitError::NoRuns)?;
        let mean_mm = runs
            .iter()
            .fold(Array2::zeros(first.tables.mean_mm.raw_dim()), |sum, run| {
                sum + &run.tables.mean_mm
            })
            / runs.len() as f64;
        // Tables can be taken to more absorption without loss, to less not.
        let reference: Vec<f64> = (0..first.tables.traced_mu_a_per_mm.len())
            .map(|node| {
                runs.iter()
                    .map(|run| run.tables.traced_mu_a_per_mm[node])
                    .fold(0.0, f64::max)
            })
            .collect();
        let of_run = |run: &ForwardRun| {
            let all = match batches {
                Batches::All => run.tables.amounts.mean_axis(Axis(0)),
                Batches::One(batch) => Some(run.tables.amounts.index_axis(Axis(0), batch).to_owned()),
            };
            let mut amounts = all.unwrap_or_default();
            for (node, mut of_node) in amounts.outer_iter_mut().enumerate() {
                let factors: Array1<f64> = run.tables.transmittance(node, reference[node]).collect();
                of_node *= &factors;
            }
            amounts
        };
        let tables: Vec<Array3<f64>> = runs.iter().map(|run| of_run(run)).collect();
        let combined = |c: usize| {
            let mut sum = Array3::zeros(tables[0].raw_dim());
            for (r, table) in tables.iter().enumerate() {
                sum.scaled_add(inverse[(c, r)], table);
            }
            sum
        };
        let by_run = |of: fn(&ForwardRun) -> &Vec<f64>| {
            Array2::from_shape_fn((count, of(first).len()), |(c, k)| {
                runs.iter()
                    .enumerate()
                    .map(|(r, run)| inverse[(c, r)] * of(run)[k])
                    .sum()
            })
        };
        let nm = model.wavelengths_nm();
        let weights: Vec<f64> = nm.iter().flat_map(|nm| node_weights(model.nodes_nm(), *nm)).collect();
        Ok(Self {
            centre: centre.to_vec(),
            quadratic,
            amounts: (0..count).map(combined).collect(),
            mu_a_per_mm: by_run(|run| &run.mu_a_per_mm),
            values: by_run(|run| &run.values),
            mean_mm,
            reference_mu_a_per_mm: reference,
            bins: first.tables.bins.clone(),
            node_weights: Array2::from_shape_vec((nm.len(), model.nodes_nm().len()), weights)
                .map_err(|_| FitError::NoRuns)?,
        })
    }

    fn terms_at(&self, point: &[f64]) -> Vec<f64> {
        terms(point, &self.centre, self.quadratic)
            .take(self.amounts.len())
            .collect()
    }

    /// Values of the traced parameters at a point, in their units.
    pub fn values(&self, point: &[f64]) -> Vec<f64> {
        Array1::from(self.terms_at(point)).dot(&self.values).to_vec()
    }

    /// β at `[geometry][wavelength]` of a point, for an absorption added at each wavelength, 1/mm.
    pub fn beta(&self, point: &[f64], added_mu_a_per_mm: &[f64]) -> Array2<f64> {
        let terms = Array1::from(self.terms_at(point));
        let mut amounts = Array3::zeros(self.amounts[0].raw_dim());
        for (term, coefficient) in terms.iter().zip(&self.amounts) {
            amounts.scaled_add(*term, coefficient);
        }
        let own = terms.dot(&self.mu_a_per_mm);
        let (nodes, geometries, bins) = amounts.dim();
        let mut beta = Array2::zeros((geometries, added_mu_a_per_mm.len()));
        let mut factors = Array2::zeros((bins, added_mu_a_per_mm.len()));
        for node in 0..nodes {
            for (w, added) in added_mu_a_per_mm.iter().enumerate() {
                let change = own[w].max(0.0) + added - self.reference_mu_a_per_mm[node];
                let weight = self.node_weights[[w, node]];
                for bin in 0..bins {
                    let transmitted = self.bins.transmittance(bin, self.mean_mm[[node, bin]], change);
                    factors[[bin, w]] = weight * transmitted.min(MOST_GROWTH);
                }
            }
            beta += &amounts.index_axis(Axis(0), node).dot(&factors);
        }
        beta
    }
}

/// 1, the coordinates from the centre, and their squares and products.
fn terms<'a>(point: &'a [f64], centre: &'a [f64], quadratic: bool) -> impl Iterator<Item = f64> + 'a {
    let from = move |k: usize| point[k] - centre[k];
    let n = centre.len();
    let products = (0..n).flat_map(move |i| (i..n).map(move |j| from(i) * from(j)));
    std::iter::once(1.0)
        .chain((0..n).map(from))
        .chain(products.filter(move |_| quadratic))
}
