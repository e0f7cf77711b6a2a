use super::kind::{FORMAT_VERSION, MAGIC_LIMIT};
use super::layout::{self, HEADER_LIMIT, Head, Placed};
use super::{ArrayInfo, ArtefactError, ArtefactKind, BUFFER, CHECKSUM, Element, Hashed, Identity};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file whose size and checksum have been verified. Reading never writes.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    kind: ArtefactKind,
    file: File,
    head: Head,
    /// Where the arrays begin, bytes from the file's beginning.
    start: u64,
    checksum: [u8; CHECKSUM],
}

impl Reader {
    /// As [`Reader::open`]; `None` where there is no file.
    pub fn open_if_there(path: impl Into<PathBuf>, kind: ArtefactKind) -> Result<Option<Self>, ArtefactError> {
        match Self::open(path, kind) {
            Ok(file) => Ok(Some(file)),
            Err(ArtefactError::NotReadable { cause, .. }) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Opens a file of this kind and reads all of it once to verify its size and checksum.
    pub fn open(path: impl Into<PathBuf>, kind: ArtefactKind) -> Result<Self, ArtefactError> {
        let path = path.into();
        let not_readable = |cause| ArtefactError::NotReadable {
            path: path.clone(),
            cause,
        };
        // Checked first, because opening a pipe would block for ever.
        if !fs::metadata(&path).map_err(not_readable)?.is_file() {
            return Err(ArtefactError::NotAFile { path });
        }
        let file = File::open(&path).map_err(not_readable)?;
        let found = file.metadata().map_err(not_readable)?.len();
        let mut input = BufReader::with_capacity(BUFFER, file);
        let mut hashed = Hashed::new(io::sink());

        let magic = line(&mut input, MAGIC_LIMIT).map_err(not_readable)?;
        check_magic(&path, kind, &magic)?;
        let json = line(&mut input, HEADER_LIMIT).map_err(not_readable)?;
        let damaged = |found| ArtefactError::Damaged {
            path: path.clone(),
            kind,
            found,
        };
        let head = Head::parse(&json).map_err(damaged)?;
        let start = (magic.len() + json.len()) as u64;
        let expected = layout::size(start, &head.arrays);
        let wrong_size = |found| ArtefactError::Size {
            path: path.clone(),
            kind,
            expected,
            found,
        };
        if found != expected {
            return Err(wrong_size(found));
        }

        let mut arrays = (&mut input).take(expected - start - CHECKSUM as u64);
        let mut checksum = [0; CHECKSUM];
        hashed
            .write_all(&magic)
            .and_then(|()| hashed.write_all(&json))
            .and_then(|()| io::copy(&mut arrays, &mut hashed))
            .and_then(|_| input.read_exact(&mut checksum))
            .map_err(not_readable)?;
        if hashed.finish().1 != checksum {
            return Err(damaged("contents that do not have its checksum".into()));
        }
        Ok(Self {
            file: input.into_inner(),
            path,
            kind,
            head,
            start,
            checksum,
        })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Version of the program that wrote the file.
    pub fn version(&self) -> &str {
        &self.head.version
    }

    /// SHA-256 of the file without its trailing checksum, in hexadecimal.
    pub fn sha256(&self) -> String {
        self.checksum.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    pub fn identity(&self) -> &Identity {
        &self.head.identity
    }

    /// The header that was passed to the writer.
    pub fn header(&self) -> &Value {
        &self.head.header
    }

    /// Every array, in the file's order.
    pub fn arrays(&self) -> impl Iterator<Item = &ArrayInfo> {
        self.head.arrays.iter().map(|array| &array.info)
    }

    /// Refuses a file of another run.
    pub fn expect(&self, identity: &Identity) -> Result<(), ArtefactError> {
        let differences = identity.differences(&self.head.identity);
        if differences.is_empty() {
            return Ok(());
        }
        Err(ArtefactError::Foreign {
            path: self.path.clone(),
            kind: self.kind,
            differences,
        })
    }

    /// Reads a whole array.
    pub fn array<T: Element>(&mut self, name: &str, shape: &[usize]) -> Result<Vec<T>, ArtefactError> {
        // Checked before memory is allocated, which the size of the file then bounds.
        let count = self.find::<T>(name, shape)?.info.count().unwrap_or(0);
        let mut values = vec![T::default(); count];
        self.read_part(name, shape, 0, &mut values)?;
        Ok(values)
    }

    /// Fills `values` from the value numbered `first` in the order of the file, for arrays that are too large for
    /// memory.
    pub fn read_part<T: Element>(
        &mut self,
        name: &str,
        shape: &[usize],
        first: usize,
        values: &mut [T],
    ) -> Result<(), ArtefactError> {
        let array = self.find::<T>(name, shape)?;
        let count = array.info.count().unwrap_or(0);
        if first.checked_add(values.len()).is_none_or(|end| end > count) {
            let expected = format!("{} values from value {first}", values.len());
            return Err(self.other_array(name, expected, format!("{count} values in all")));
        }
        let size = T::TYPE.bytes();
        let from = self.start + array.offset + (first * size) as u64;
        self.read_at(from, size, values)
            .map_err(|cause| ArtefactError::NotReadable {
                path: self.path.clone(),
                cause,
            })
    }

    fn read_at<T: Element>(&mut self, from: u64, size: usize, values: &mut [T]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(from))?;
        let mut bytes = vec![0; (values.len() * size).min(BUFFER)];
        for part in values.chunks_mut(BUFFER / size) {
            let bytes = &mut bytes[..part.len() * size];
            self.file.read_exact(bytes)?;
            T::read_le(bytes, part);
        }
        Ok(())
    }

    fn find<T: Element>(&self, name: &str, shape: &[usize]) -> Result<&Placed, ArtefactError> {
        let expected = || ArrayInfo::form(T::TYPE, shape);
        match self.head.arrays.iter().find(|array| array.info.name == name) {
            Some(array) if array.info.element == T::TYPE && array.info.shape == shape => Ok(array),
            Some(Placed { info, .. }) => {
                Err(self.other_array(name, expected(), ArrayInfo::form(info.element, &info.shape)))
            }
            None => {
                let names: Vec<&str> = self.arrays().map(|info| info.name.as_str()).collect();
                Err(self.other_array(name, expected(), format!("only {names:?}")))
            }
        }
    }

    fn other_array(&self, array: &str, expected: String, found: String) -> ArtefactError {
        ArtefactError::Array {
            path: self.path.clone(),
            kind: self.kind,
            array: array.to_owned(),
            expected,
            found,
        }
    }
}

/// Bytes up to and including the next end of line, or `limit` bytes where there is none before.
fn line(input: &mut impl BufRead, limit: u64) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    input.take(limit).read_until(b'\n', &mut line)?;
    Ok(line)
}

fn check_magic(path: &Path, expected: ArtefactKind, line: &[u8]) -> Result<(), ArtefactError> {
    let path = || path.to_owned();
    let Some((kind, version)) = parse_magic(line) else {
        let begins = line.strip_suffix(b"\n").unwrap_or(line);
        let begins: String = String::from_utf8_lossy(begins).chars().take(32).collect();
        return Err(ArtefactError::NotOurs {
            path: path(),
            expected,
            found: match line {
                [] => "an empty file".into(),
                _ => format!("one that begins \"{}\"", begins.escape_debug()),
            },
        });
    };
    if kind != expected {
        return Err(ArtefactError::OtherKind {
            path: path(),
            expected,
            found: kind,
        });
    }
    if version != FORMAT_VERSION {
        return Err(ArtefactError::OtherVersion {
            path: path(),
            kind,
            found: version,
        });
    }
    Ok(())
}

fn parse_magic(line: &[u8]) -> Option<(ArtefactKind, u64)> {
    let line = std::str::from_utf8(line).ok()?.strip_suffix('\n')?;
    let (word, version) = line.strip_prefix("specval-")?.split_once(' ')?;
    let kind = ArtefactKind::ALL.into_iter().find(|kind| kind.word() == word)?;
    // Only the spelling that this program writes: no sign, no leading zeros.
    let number = version.parse().ok().filter(|n: &u64| n.to_string() == version)?;
    Some((kind, number))
}
