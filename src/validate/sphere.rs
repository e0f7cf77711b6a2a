use num_complex::Complex64;
use serde::Deserialize;

use super::reference::rows;
use super::{Check, ValidateError};
use crate::optics::Mie;

#[derive(Debug, Deserialize)]
struct Row {
    kind: String,
    m_re: Option<f64>,
    m_im: Option<f64>,
    x: f64,
    #[serde(rename = "Qext_mp")]
    q_ext: f64,
    #[serde(rename = "Qsca_mp")]
    q_sca: f64,
    #[serde(rename = "Qback_mp")]
    q_back: f64,
    g_mp: f64,
}

/// One homogeneous or perfectly conducting sphere.
pub(super) struct SphereProblem(Row);

pub(super) fn problems() -> Result<Vec<SphereProblem>, ValidateError> {
    let table: Vec<Row> = rows(
        "mie_wiscombe.csv",
        include_str!("../../tests/data/mie/mie_wiscombe.csv"),
    )?;
    let mut problems: Vec<SphereProblem> = Vec::new();
    for row in table {
        let problem = SphereProblem(row);
        // The table lists a sphere once for each publication of its values; keep the first.
        if problems.iter().all(|p| p.name() != problem.name()) {
            problems.push(problem);
        }
    }
    Ok(problems)
}

impl SphereProblem {
    pub fn name(&self) -> String {
        let x = self.0.x;
        match (self.0.m_re, self.0.m_im) {
            (Some(n), Some(kappa)) if self.0.kind != "pec" => format!("sphere m={n}+{kappa}i x={x}"),
            _ => format!("sphere conducting x={x}"),
        }
    }

    pub fn checks(&self) -> Result<Vec<Check>, ValidateError> {
        let row = &self.0;
        let mie = match (row.m_re, row.m_im) {
            (Some(n), Some(kappa)) if row.kind != "pec" => Mie::sphere(Complex64::new(n, kappa), row.x)?,
            _ => Mie::conducting(row.x)?,
        };
        let q = mie.efficiencies();
        let tolerance = if row.x <= 1e4 { 1e-10 } else { 1e-8 };
        let pairs = [
            ("q_ext", q.q_ext, row.q_ext),
            ("q_sca", q.q_sca, row.q_sca),
            ("q_back", q.q_back, row.q_back),
            ("g", q.g, row.g_mp),
        ];
        Ok(pairs
            .into_iter()
            .map(|(quantity, value, reference)| Check {
                problem: self.name(),
                quantity: quantity.to_owned(),
                value,
                se: 0.0,
                reference,
                reference_se: 0.0,
                z: (value - reference) / (tolerance * reference.abs()),
            })
            .collect())
    }
}
