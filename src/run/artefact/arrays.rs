//! Arrays of files, whatever the type of their elements.

use super::YarnLayout;
use super::tables::{LengthTable, TraceTable};
use crate::artefact::{ArrayInfo, ArtefactError, ArtefactKind, Element, ElementType, Reader, Writer};
use crate::run::RunError;
use crate::transport::BatchSums;
use crate::yarn::{LengthSums, LengthTally};
use std::borrow::Cow;
use std::path::Path;

/// Values of an array to write.
pub enum ArrayValues<'a> {
    F64(Cow<'a, [f64]>),
    F32(Cow<'a, [f32]>),
}

/// Where the values of an array are read into.
pub enum ArrayTarget<'a> {
    F64(&'a mut Vec<f64>),
    F32(&'a mut Vec<f32>),
}

/// What is kept of a quantity, as arrays: its amount, squares or standard errors of it, and its moment, as far as there
/// are any.
pub trait Held {
    fn values(&self) -> Vec<ArrayValues<'_>>;

    fn values_mut(&mut self) -> Vec<ArrayTarget<'_>>;

    /// Number of batches that sums are of.
    fn set_batches(&mut self, _: u64) {}
}

impl<'a> From<&'a Vec<f64>> for ArrayValues<'a> {
    fn from(values: &'a Vec<f64>) -> Self {
        Self::F64(values.into())
    }
}

impl<'a> From<&'a Vec<f32>> for ArrayValues<'a> {
    fn from(values: &'a Vec<f32>) -> Self {
        Self::F32(values.into())
    }
}

impl<'a> From<&'a mut Vec<f64>> for ArrayTarget<'a> {
    fn from(values: &'a mut Vec<f64>) -> Self {
        Self::F64(values)
    }
}

impl<'a> From<&'a mut Vec<f32>> for ArrayTarget<'a> {
    fn from(values: &'a mut Vec<f32>) -> Self {
        Self::F32(values)
    }
}

/// `Held` of a type by its fields.
macro_rules! held {
    ($type:ty: $($field:tt),+ $(; counts $batches:ident)?) => {
        impl Held for $type {
            fn values(&self) -> Vec<ArrayValues<'_>> {
                vec![$((&self.$field).into()),+]
            }

            fn values_mut(&mut self) -> Vec<ArrayTarget<'_>> {
                vec![$((&mut self.$field).into()),+]
            }

            $(fn set_batches(&mut self, batches: u64) {
                self.$batches = batches;
            })?
        }
    };
}

held!(LengthTally: amount, moment_mm);
held!(BatchSums: sum, square; counts batches);
held!(LengthSums: amount, square, moment_mm; counts batches);
held!(TraceTable: mean, se);
held!(LengthTable: mean, se, moment_mm);

impl<T> Held for Vec<T>
where
    for<'a> ArrayValues<'a>: From<&'a Vec<T>>,
    for<'a> ArrayTarget<'a>: From<&'a mut Vec<T>>,
{
    fn values(&self) -> Vec<ArrayValues<'_>> {
        vec![self.into()]
    }

    fn values_mut(&mut self) -> Vec<ArrayTarget<'_>> {
        vec![self.into()]
    }
}

impl Held for Option<TraceTable> {
    fn values(&self) -> Vec<ArrayValues<'_>> {
        self.as_ref().map(Held::values).unwrap_or_default()
    }

    fn values_mut(&mut self) -> Vec<ArrayTarget<'_>> {
        self.get_or_insert_default().values_mut()
    }
}

/// An array of a file, described and with its values.
pub(super) struct ArrayEntry<'a> {
    pub info: ArrayInfo,
    pub values: ArrayValues<'a>,
}

impl ArrayValues<'_> {
    pub fn element(&self) -> ElementType {
        match self {
            Self::F64(_) => ElementType::F64,
            Self::F32(_) => ElementType::F32,
        }
    }
}

impl ArrayEntry<'_> {
    pub fn append(self, file: &mut Writer) -> Result<(), ArtefactError> {
        match self.values {
            ArrayValues::F64(values) => file.append(&self.info.name, values.iter().copied()),
            ArrayValues::F32(values) => file.append(&self.info.name, values.iter().copied()),
        }
    }
}

/// Writes a file of these arrays whole or not at all.
pub(super) fn write(
    path: &Path,
    kind: ArtefactKind,
    layout: &YarnLayout,
    header: &serde_json::Value,
    entries: Vec<ArrayEntry>,
) -> Result<(), RunError> {
    let infos: Vec<ArrayInfo> = entries.iter().map(|entry| entry.info.clone()).collect();
    let mut file = Writer::create(path, kind, &layout.identity()?, header, &infos)?;
    for entry in entries {
        entry.append(&mut file)?;
    }
    Ok(file.finish()?)
}

pub(super) fn read_into(
    file: &mut Reader,
    name: &str,
    shape: &[usize],
    target: ArrayTarget,
) -> Result<(), ArtefactError> {
    fn read<T: Element>(
        file: &mut Reader,
        name: &str,
        shape: &[usize],
        values: &mut Vec<T>,
    ) -> Result<(), ArtefactError> {
        *values = file.array(name, shape)?;
        Ok(())
    }
    match target {
        ArrayTarget::F64(values) => read(file, name, shape, values),
        ArrayTarget::F32(values) => read(file, name, shape, values),
    }
}
