use super::{Batch, Plan, RunError, Simulator};
use crate::artefact::{ArrayInfo, ArtefactKind, ElementType, Identity, Reader, Writer};
use crate::cloth::light::{ClothFraction, ClothLedger};
use crate::output;
use crate::report::InputDigest;
use crate::study::Study;
use crate::transport::{Fraction, FractionList, Ledger};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Everything that determines the bits of a batch, beside seed and program version.
#[derive(Serialize)]
struct Settings<'a> {
    command: &'a str,
    study: &'a Study,
    inputs: &'a [InputDigest],
}

/// The file from which an interrupted simulation resumes: its batches so far, bit for bit.
#[derive(Debug)]
pub struct StateFile {
    /// `None` for a run that leaves no state.
    path: Option<PathBuf>,
    identity: Identity,
}

impl StateFile {
    /// Nothing is read or written yet, and nothing ever without a path. `command` is the subcommand, because each
    /// measures other geometries.
    pub fn new(path: Option<PathBuf>, command: &str, plan: &Plan) -> Result<Self, RunError> {
        let settings = Settings {
            command,
            study: &plan.study,
            inputs: &plan.inputs,
        };
        Ok(Self {
            path,
            identity: Identity::new(plan.study.seed, &settings)?,
        })
    }

    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The batches of the file, from number 0; `None` where there is no file.
    ///
    /// # Errors
    /// A file that is damaged, or of another command, study, seed or program version. It stays as it is.
    pub fn load(&self, simulator: &Simulator) -> Result<Option<Vec<Batch>>, RunError> {
        let Some(path) = &self.path else { return Ok(None) };
        let Some(mut file) = Reader::open_if_there(path, ArtefactKind::State)? else {
            return Ok(None);
        };
        file.expect(&self.identity)?;
        let batches = file.arrays().next().and_then(|info| info.shape.first().copied());
        let batches = batches.unwrap_or(0);
        let infos = Arrays::new(simulator, batches);
        let [ledgers, diffuse, cloth] = infos.in_order().map(|info| file.array::<f64>(&info.name, &info.shape));
        let (ledgers, diffuse, cloth) = (ledgers?, diffuse?, cloth?);
        let wavelengths = simulator.ledger_shape()[1];
        let batch = |batch| Batch {
            ledgers: amounts(of_batch(&ledgers, batch, &infos.ledgers))
                .map(Ledger::from_amounts)
                .collect(),
            diffuse: of_batch(&diffuse, batch, &infos.diffuse)
                .chunks_exact(wavelengths)
                .map(<[f64]>::to_vec)
                .collect(),
            cloth: amounts(of_batch(&cloth, batch, &infos.cloth))
                .map(ClothLedger::from_amounts)
                .collect(),
        };
        Ok(Some((0..batches).map(batch).collect()))
    }

    /// Replaces the file, whole or not at all.
    pub(super) fn save(&self, simulator: &Simulator, batches: &[Batch]) -> Result<(), RunError> {
        let Some(path) = &self.path else { return Ok(()) };
        let infos = Arrays::new(simulator, batches.len());
        let header = serde_json::json!({ "batches": batches.len() });
        let mut file = Writer::create(path, ArtefactKind::State, &self.identity, &header, &infos.in_order())?;
        let ledgers = batches.iter().flat_map(|batch| &batch.ledgers);
        file.append(&infos.ledgers.name, ledgers.flat_map(Ledger::amounts))?;
        let diffuse = batches.iter().flat_map(|batch| batch.diffuse.iter().flatten());
        file.append(&infos.diffuse.name, diffuse.copied())?;
        let cloth = batches.iter().flat_map(|batch| &batch.cloth);
        file.append(&infos.cloth.name, cloth.flat_map(ClothLedger::amounts))?;
        Ok(file.finish()?)
    }

    /// Removes the file once the results are written.
    pub fn remove(self) -> Result<(), RunError> {
        Ok(self.path.map_or(Ok(()), |path| output::remove(&path))?)
    }
}

/// The amounts of N fractions of one ledger after the other.
fn amounts<const N: usize>(values: &[f64]) -> impl Iterator<Item = [f64; N]> {
    values.as_chunks().0.iter().copied()
}

/// Names of all fractions of a list, in words.
fn words<F: FractionList>() -> String {
    let names: Vec<String> = F::ALL
        .iter()
        .map(|fraction| fraction.name().replace('_', " "))
        .collect();
    names.join(", ")
}

/// The values of one batch.
fn of_batch<'a>(values: &'a [f64], batch: usize, info: &ArrayInfo) -> &'a [f64] {
    let size: usize = info.shape[1..].iter().product();
    &values[batch * size..(batch + 1) * size]
}

/// The arrays of the file, for one number of batches.
struct Arrays {
    ledgers: ArrayInfo,
    diffuse: ArrayInfo,
    cloth: ArrayInfo,
}

impl Arrays {
    fn new(simulator: &Simulator, batches: usize) -> Self {
        let array = |name: &str, unit: &str, axes: String, shape: &[usize]| ArrayInfo {
            name: name.into(),
            unit: unit.into(),
            axes,
            shape: shape.to_vec(),
            element: ElementType::F64,
        };
        let [directions, wavelengths] = simulator.ledger_shape();
        let [incidences, _] = simulator.cloth_shape();
        let geometries = simulator.geometries().len();
        let flux = "fraction of the incident flux";
        Self {
            ledgers: array(
                "ledgers",
                flux,
                format!(
                    "batch, traced incident direction, wavelength, ({})",
                    words::<Fraction>()
                ),
                &[batches, directions, wavelengths, Fraction::COUNT],
            ),
            diffuse: array(
                "diffuse",
                "1",
                "batch, geometry, wavelength".into(),
                &[batches, geometries, wavelengths],
            ),
            cloth: array(
                "cloth",
                flux,
                format!("batch, incidence, wavelength, ({})", words::<ClothFraction>()),
                &[batches, incidences, wavelengths, ClothFraction::COUNT],
            ),
        }
    }

    fn in_order(&self) -> [ArrayInfo; 3] {
        [&self.ledgers, &self.diffuse, &self.cloth].map(Clone::clone)
    }
}
