use super::{Batch, Plan, RunError, Simulator};
use crate::artefact::{ArrayInfo, ElementType, Identity, Kind, Reader, Writer};
use crate::cloth::light::{ClothFraction, ClothLedger};
use crate::output;
use crate::report::InputDigest;
use crate::study::Study;
use crate::transport::{Fraction, FractionList, Ledger};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// All that decides about the bits of a batch, beside seed and program version.
#[derive(Serialize)]
struct Settings<'a> {
    command: &'a str,
    study: &'a Study,
    inputs: &'a [InputDigest],
}

/// The file from which an interrupted simulation goes on: its batches so far, bit for bit.
#[derive(Debug)]
pub struct StateFile {
    /// `None` for a run that leaves no state.
    path: Option<PathBuf>,
    identity: Identity,
}

impl StateFile {
    /// Nothing is read or written yet; nothing ever is where there is no place for it. `command` is the subcommand, since each measures other geometries.
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

    /// The batches kept there, from number 0 on; `None` where there is no file.
    ///
    /// # Errors
    /// A file that is damaged, or of another command, study, seed or program version. It stays as it is.
    pub fn load(&self, simulator: &Simulator) -> Result<Option<Vec<Batch>>, RunError> {
        let Some(path) = &self.path else { return Ok(None) };
        let Some(mut file) = Reader::open_if_there(path, Kind::State)? else {
            return Ok(None);
        };
        file.expect(&self.identity)?;
        let batches = file.arrays().next().and_then(|info| info.shape.first().copied());
        let infos = arrays(simulator, batches.unwrap_or(0));
        let wavelengths = simulator.ledger_shape()[1];
        let mut stored = Vec::with_capacity(infos.len());
        for info in &infos {
            stored.push(file.array::<f64>(&info.name, &info.shape)?);
        }
        let of_batch = |array: usize, batch: usize| {
            let size: usize = infos[array].shape[1..].iter().product();
            &stored[array][batch * size..(batch + 1) * size]
        };
        let batch = |batch| Batch {
            ledgers: amounts(of_batch(0, batch)).map(Ledger::from_amounts).collect(),
            diffuse: of_batch(1, batch)
                .chunks_exact(wavelengths)
                .map(<[f64]>::to_vec)
                .collect(),
            cloth: amounts(of_batch(2, batch)).map(ClothLedger::from_amounts).collect(),
        };
        Ok(Some((0..batches.unwrap_or(0)).map(batch).collect()))
    }

    /// Replaces the file, whole or not at all.
    pub(super) fn save(&self, simulator: &Simulator, batches: &[Batch]) -> Result<(), RunError> {
        let Some(path) = &self.path else { return Ok(()) };
        let infos = arrays(simulator, batches.len());
        let header = serde_json::json!({ "batches": batches.len() });
        let mut file = Writer::create(path, Kind::State, &self.identity, &header, &infos)?;
        let ledgers = batches.iter().flat_map(|batch| &batch.ledgers);
        file.append(&infos[0].name, ledgers.flat_map(Ledger::amounts))?;
        let diffuse = batches.iter().flat_map(|batch| batch.diffuse.iter().flatten());
        file.append(&infos[1].name, diffuse.copied())?;
        let cloth = batches.iter().flat_map(|batch| &batch.cloth);
        file.append(&infos[2].name, cloth.flat_map(ClothLedger::amounts))?;
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

/// What the file holds for this many batches.
fn arrays(simulator: &Simulator, batches: usize) -> [ArrayInfo; 3] {
    let array = |name: &str, unit: &str, axes: &str, shape: &[usize]| ArrayInfo {
        name: name.into(),
        unit: unit.into(),
        axes: axes.into(),
        shape: shape.to_vec(),
        element: ElementType::F64,
    };
    let [directions, wavelengths] = simulator.ledger_shape();
    [
        array(
            "ledgers",
            "fraction of the incident flux",
            &format!(
                "batch, traced incident direction, wavelength, ({})",
                words::<Fraction>()
            ),
            &[batches, directions, wavelengths, Fraction::COUNT],
        ),
        array(
            "diffuse",
            "1",
            "batch, geometry, wavelength",
            &[batches, simulator.geometries().len(), wavelengths],
        ),
        array(
            "cloth",
            "fraction of the incident flux",
            &format!("batch, incidence, wavelength, ({})", words::<ClothFraction>()),
            &[
                batches,
                simulator.cloth_shape()[0],
                simulator.cloth_shape()[1],
                ClothFraction::COUNT,
            ],
        ),
    ]
}
