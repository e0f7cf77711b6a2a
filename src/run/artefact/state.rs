use super::YarnLayout;
use super::batch_arrays::{flat, from_flat, ledgers};
use super::layout::parse;
use crate::artefact::{ElementType, Kind, Reader, Writer};
use crate::run::{RunError, YarnSums};
use crate::transport::{BatchSums, Ledger};
use crate::yarn::LengthSums;
use std::path::Path;

impl YarnSums {
    /// Writes where the run stands; what stood there before is replaced in one step.
    pub fn save(&self, layout: &YarnLayout, path: &Path) -> Result<(), RunError> {
        let mut arrays = Vec::new();
        for batch in 0..self.ledgers.len() {
            arrays.push(ledgers(layout).info(format!("{batch}.ledgers"), ElementType::F64));
        }
        let doubles = [
            ("energy_by_length", layout.energy_by_length(), &self.energy_by_length),
            ("radiance_factor_direct", layout.factor(), &self.direct),
            ("radiance_factor_bssrdf", layout.factor(), &self.summed),
            ("bssrdf_fraction", layout.bssrdf(), &self.bssrdf),
        ];
        for (name, array, _) in &doubles {
            for part in ["sum", "square"] {
                arrays.push(array.info(format!("{name}.{part}"), ElementType::F64));
            }
        }
        let [amount, moment] = layout.factor_by_length();
        let lengths = &self.by_length;
        let singles = [
            ("by_length.sum", amount.clone(), &lengths.amount),
            ("by_length.square", amount, &lengths.square),
            ("by_length.moment", moment, &lengths.moment_mm),
        ];
        for (name, array, _) in &singles {
            arrays.push(array.info(*name, ElementType::F32));
        }
        let header = serde_json::json!({ "batches": self.ledgers.len(), "axes": layout.axes });
        let mut file = Writer::create(path, Kind::State, &layout.identity()?, &header, &arrays)?;
        for (batch, ledgers) in self.ledgers.iter().enumerate() {
            file.append(&format!("{batch}.ledgers"), flat(ledgers))?;
        }
        for (name, _, sums) in doubles {
            file.append(&format!("{name}.sum"), sums.sum.iter().copied())?;
            file.append(&format!("{name}.square"), sums.square.iter().copied())?;
        }
        for (name, _, values) in singles {
            file.append(name, values.iter().copied())?;
        }
        Ok(file.finish()?)
    }

    /// Reads where a run of this layout stood, bit for bit; `None` where there is no file. The state of another run is
    /// refused, and stays as it is.
    pub fn load(layout: &YarnLayout, path: &Path) -> Result<Option<Self>, RunError> {
        let Some(mut file) = Reader::open_if_there(path, Kind::State)? else {
            return Ok(None);
        };
        file.expect(&layout.identity()?)?;
        let batches: usize = parse(path, Kind::State, "header.batches", &file.header()["batches"])?;
        let mut of_batches: Vec<Vec<Ledger>> = Vec::new();
        for batch in 0..batches {
            let values = file.array::<f64>(&format!("{batch}.ledgers"), &ledgers(layout).shape)?;
            of_batches.push(from_flat(&values));
        }
        let mut sums = |name: &str, shape: &[usize]| -> Result<BatchSums, RunError> {
            Ok(BatchSums {
                batches: batches as u64,
                sum: file.array(&format!("{name}.sum"), shape)?,
                square: file.array(&format!("{name}.square"), shape)?,
            })
        };
        let factor = layout.factor().shape;
        let energy_by_length = sums("energy_by_length", &layout.energy_by_length().shape)?;
        let direct = sums("radiance_factor_direct", &factor)?;
        let summed = sums("radiance_factor_bssrdf", &factor)?;
        let bssrdf = sums("bssrdf_fraction", &layout.bssrdf().shape)?;
        let [amount, moment] = layout.factor_by_length();
        Ok(Some(Self {
            ledgers: of_batches,
            energy_by_length,
            direct,
            summed,
            bssrdf,
            by_length: LengthSums {
                batches: batches as u64,
                amount: file.array("by_length.sum", &amount.shape)?,
                square: file.array("by_length.square", &amount.shape)?,
                moment_mm: file.array("by_length.moment", &moment.shape)?,
            },
        }))
    }
}
