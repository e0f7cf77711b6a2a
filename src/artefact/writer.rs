use super::layout::{self, HEADER_LIMIT, Head, Placed};
use super::{ArrayInfo, ArtefactError, ArtefactKind, BUFFER, Element, Hashed, Identity};
use crate::output::{Destination, Output, OutputError};
use serde_json::Value;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes one file whole or not at all, or into a stream: see [`Output`].
#[derive(Debug)]
pub struct Writer {
    output: BufWriter<Hashed<Output>>,
    /// As the caller named it.
    path: PathBuf,
    arrays: Vec<Placed>,
    /// The array being written, and how many of its values have been written.
    current: usize,
    written: usize,
    failed: bool,
}

impl Writer {
    /// Writes the header. `header` is stored beside the arrays; [`Writer::append`] writes the `arrays` in this order.
    pub fn create(
        path: impl Into<PathBuf>,
        kind: ArtefactKind,
        identity: &Identity,
        header: &Value,
        arrays: &[ArrayInfo],
    ) -> Result<Self, ArtefactError> {
        let path = path.into();
        let undeclared = |expected: String, found| ArtefactError::Undeclared {
            path: path.clone(),
            expected,
            found,
        };
        let arrays = layout::place(arrays)
            .map_err(|found| undeclared("arrays of different names that fit into a file".into(), found))?;
        let head = Head {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            identity: identity.clone(),
            header: header.clone(),
            arrays,
        };
        let mut lines = kind.magic().into_bytes();
        lines.push(b'\n');
        let magic = lines.len();
        serde_json::to_writer(&mut lines, &head)
            .map_err(|cause| undeclared("a header that JSON can hold".into(), cause.to_string()))?;
        lines.push(b'\n');
        if (lines.len() - magic) as u64 > HEADER_LIMIT {
            let found = format!("{} bytes; write large tables as arrays", lines.len() - magic);
            return Err(undeclared(format!("a header of at most {HEADER_LIMIT} bytes"), found));
        }
        // JSON that is nested too deeply to be read back must fail now, not after the run.
        Head::parse(&lines[magic..]).map_err(|found| undeclared("a header that can be read back".into(), found))?;
        let output = Destination::find(&path).and_then(|place| Output::create(&place));
        let mut output = BufWriter::with_capacity(BUFFER, Hashed::new(output.map_err(not_written)?));
        output.write_all(&lines).map_err(not_writable(&path))?;
        Ok(Self {
            output,
            arrays: head.arrays,
            current: 0,
            written: 0,
            failed: false,
            path,
        })
    }

    /// Writes the next values of an array, in any number of calls. An array must be complete before the next one
    /// begins. After an error the file can no longer be finished.
    pub fn append<T: Element>(
        &mut self,
        array: &str,
        values: impl IntoIterator<Item = T>,
    ) -> Result<(), ArtefactError> {
        // Cleared only on success, so that a panic inside the iterator counts as a failure too.
        let failed_before = std::mem::replace(&mut self.failed, true);
        self.begin::<T>(array)?;
        let count = self.count();
        for value in values {
            if self.written == count {
                return Err(self.undeclared(format!("{count} values of `{array}`"), "more".into()));
            }
            value.write_le(&mut self.output).map_err(not_writable(&self.path))?;
            self.written += 1;
        }
        self.failed = failed_before;
        Ok(())
    }

    /// Writes the checksum, waits until the file is on the disk, and moves it to its place.
    pub fn finish(mut self) -> Result<(), ArtefactError> {
        self.skip_complete(None);
        if let Some(next) = self.arrays.get(self.current) {
            let expected = format!("{} values of `{}`", self.count(), next.info.name);
            return Err(self.undeclared(expected, format!("{}", self.written)));
        }
        if self.failed {
            return Err(self.undeclared("all values to be written".into(), "an earlier error".into()));
        }
        let not_writable = not_writable(&self.path);
        let hashed = self.output.into_inner().map_err(|e| not_writable(e.into_error()))?;
        let (mut output, checksum) = hashed.finish();
        output.write_all(&checksum).map_err(not_writable)?;
        output.finish().map_err(not_written)
    }

    /// Makes this array the current one if it is next.
    fn begin<T: Element>(&mut self, array: &str) -> Result<(), ArtefactError> {
        self.skip_complete(Some(array));
        match self.arrays.get(self.current) {
            Some(next) if next.info.name == array && next.info.element == T::TYPE => Ok(()),
            Some(next) => {
                let expected = format!(
                    "values {} to {} of `{}` as {}",
                    self.written,
                    self.count(),
                    next.info.name,
                    next.info.element
                );
                Err(self.undeclared(expected, format!("`{array}` as {}", T::TYPE)))
            }
            None => Err(self.undeclared("no further array".into(), format!("`{array}`"))),
        }
    }

    /// Skips complete arrays, up to one of this name.
    fn skip_complete(&mut self, until: Option<&str>) {
        while let Some(array) = self.arrays.get(self.current)
            && Some(array.info.name.as_str()) != until
            && self.written == self.count()
        {
            self.current += 1;
            self.written = 0;
        }
    }

    /// Values of the array being written.
    fn count(&self) -> usize {
        let current = self.arrays.get(self.current);
        current.and_then(|array| array.info.count()).unwrap_or(0)
    }

    fn undeclared(&self, expected: String, found: String) -> ArtefactError {
        ArtefactError::Undeclared {
            path: self.path.clone(),
            expected,
            found,
        }
    }
}

fn not_written(cause: OutputError) -> ArtefactError {
    match cause {
        OutputError::NotWritable { path, cause } => ArtefactError::NotWritable { path, cause },
        other => ArtefactError::Output(other),
    }
}

fn not_writable(path: &Path) -> impl Fn(io::Error) -> ArtefactError + Copy + '_ {
    |cause| ArtefactError::NotWritable {
        path: path.to_owned(),
        cause,
    }
}
