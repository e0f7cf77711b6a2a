use super::layout::{Array, YarnLayout};
use crate::artefact::{ArrayInfo, ArtefactError, ElementType, Reader, Writer};
use crate::run::YarnBatch;
use crate::transport::{Fraction, Ledger};
use crate::yarn::LengthTally;

/// Arrays of one batch in a shard, in the order of [`append_batch`].
pub(super) fn batch_arrays(layout: &YarnLayout, batch: usize) -> [ArrayInfo; 7] {
    let [amount, moment] = layout.factor_by_length();
    [
        (ledgers(layout), "ledgers", ElementType::F64),
        (layout.energy_by_length(), "energy_by_length", ElementType::F64),
        (layout.factor(), "radiance_factor_direct", ElementType::F64),
        (layout.factor(), "radiance_factor_bssrdf", ElementType::F64),
        (layout.bssrdf(), "bssrdf_fraction", ElementType::F32),
        (amount, "radiance_factor_by_length", ElementType::F32),
        (moment, "radiance_factor_by_length_moment", ElementType::F32),
    ]
    .map(|(array, what, element)| array.info(name(batch, what), element))
}

/// Name of a batch's array.
fn name(batch: usize, what: &str) -> String {
    format!("{batch}.{what}")
}

/// The fractions of a ledger that are not derived from others.
pub(super) fn ledgers(layout: &YarnLayout) -> Array {
    Array {
        unit: "fraction of the incident flux",
        axes: "traced direction, wavelength; reflected, ballistic, scattered, absorbed, roulette, sharing",
        shape: vec![layout.incident.traced(), layout.wavelengths(), Fraction::COUNT],
    }
}

pub(super) fn flat(ledgers: &[Ledger]) -> impl Iterator<Item = f64> {
    ledgers.iter().flat_map(Ledger::amounts)
}

pub(super) fn from_flat(values: &[f64]) -> Vec<Ledger> {
    values.as_chunks().0.iter().copied().map(Ledger::from_amounts).collect()
}

pub(super) fn append_batch(file: &mut Writer, number: usize, batch: &YarnBatch) -> Result<(), ArtefactError> {
    let of = |what| name(number, what);
    file.append(&of("ledgers"), flat(&batch.ledgers))?;
    file.append(&of("energy_by_length"), batch.energy_by_length.iter().copied())?;
    file.append(&of("radiance_factor_direct"), batch.direct.iter().copied())?;
    file.append(&of("radiance_factor_bssrdf"), batch.summed.iter().copied())?;
    file.append(&of("bssrdf_fraction"), batch.bssrdf.iter().copied())?;
    let lengths = &batch.by_length;
    file.append(&of("radiance_factor_by_length"), lengths.amount.iter().copied())?;
    file.append(
        &of("radiance_factor_by_length_moment"),
        lengths.moment_mm.iter().copied(),
    )
}

pub(super) fn read_batch(file: &mut Reader, layout: &YarnLayout, number: usize) -> Result<YarnBatch, ArtefactError> {
    let of = |what| name(number, what);
    let [amount, moment] = layout.factor_by_length();
    Ok(YarnBatch {
        ledgers: from_flat(&file.array::<f64>(&of("ledgers"), &ledgers(layout).shape)?),
        energy_by_length: file.array(&of("energy_by_length"), &layout.energy_by_length().shape)?,
        direct: file.array(&of("radiance_factor_direct"), &layout.factor().shape)?,
        summed: file.array(&of("radiance_factor_bssrdf"), &layout.factor().shape)?,
        bssrdf: file.array(&of("bssrdf_fraction"), &layout.bssrdf().shape)?,
        by_length: LengthTally {
            amount: file.array(&of("radiance_factor_by_length"), &amount.shape)?,
            moment_mm: file.array(&of("radiance_factor_by_length_moment"), &moment.shape)?,
        },
    })
}
