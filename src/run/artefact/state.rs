use super::YarnLayout;
use super::arrays::{ArrayEntry, ArrayValues, write};
use super::catalogue::{BatchTables, LEDGERS, Part, SumTables};
use super::layout::parse;
use crate::artefact::{ArtefactError, ArtefactKind, Reader};
use crate::run::RunError;
use crate::transport::Ledger;
use std::path::Path;

/// Everything that one batch of tracing says about the yarn alone.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnBatch {
    /// Traced incident direction × wavelength, wavelength fastest.
    pub ledgers: Vec<Ledger>,
    pub tables: BatchTables,
}

/// Batches of the yarn added up in their order. Only the ledgers are kept batch by batch; the rest takes the same
/// memory for any number of them.
#[derive(Clone, Debug, PartialEq)]
pub struct YarnSums {
    /// [batch][traced incident direction × wavelength].
    pub ledgers: Vec<Vec<Ledger>>,
    pub tables: SumTables,
}

impl YarnSums {
    pub fn new(layout: &YarnLayout) -> Self {
        Self {
            ledgers: Vec::new(),
            tables: SumTables::zeros(layout),
        }
    }

    /// Adds the next batch.
    pub fn add(&mut self, batch: YarnBatch) {
        self.ledgers.push(batch.ledgers);
        self.tables.add(&batch.tables);
    }

    /// Writes the state of the run; a file that is there is replaced in one step.
    pub fn save(&self, layout: &YarnLayout, path: &Path) -> Result<(), RunError> {
        let ledgers = self.ledgers.iter().enumerate();
        let mut entries: Vec<ArrayEntry> = ledgers
            .map(|(batch, ledgers)| ledgers_entry(layout, batch, ledgers))
            .collect();
        entries.extend(self.tables.entries(layout, Part::Sums));
        let header = serde_json::json!({ "batches": self.ledgers.len(), "axes": layout.axes });
        write(path, ArtefactKind::State, layout, &header, entries)
    }

    /// Reads the state of a run of this layout, bit for bit; `None` where there is no file.
    ///
    /// # Errors
    /// A file that is damaged or the state of another run. It stays as it is.
    pub fn load(layout: &YarnLayout, path: &Path) -> Result<Option<Self>, RunError> {
        let Some(mut file) = Reader::open_if_there(path, ArtefactKind::State)? else {
            return Ok(None);
        };
        file.expect(&layout.identity()?)?;
        let batches: usize = parse(path, ArtefactKind::State, "header.batches", &file.header()["batches"])?;
        let ledgers = (0..batches).map(|batch| read_ledgers(&mut file, layout, batch));
        let ledgers = ledgers.collect::<Result<_, _>>()?;
        let mut tables = SumTables::read(&mut file, layout, Part::Sums, true)?;
        tables.set_batches(batches as u64);
        Ok(Some(Self { ledgers, tables }))
    }
}

fn ledgers_name(batch: usize) -> String {
    format!("{batch}.{}", LEDGERS.name)
}

/// The ledgers of one batch as an array of a shard or a state.
pub(super) fn ledgers_entry<'a>(layout: &YarnLayout, batch: usize, ledgers: &[Ledger]) -> ArrayEntry<'a> {
    let amounts: Vec<f64> = ledgers.iter().flat_map(Ledger::amounts).collect();
    LEDGERS.entry(layout, ledgers_name(batch), ArrayValues::F64(amounts.into()))
}

pub(super) fn read_ledgers(file: &mut Reader, layout: &YarnLayout, batch: usize) -> Result<Vec<Ledger>, ArtefactError> {
    let amounts: Vec<f64> = file.array(&ledgers_name(batch), &LEDGERS.shape(layout))?;
    Ok(amounts
        .as_chunks()
        .0
        .iter()
        .copied()
        .map(Ledger::from_amounts)
        .collect())
}
