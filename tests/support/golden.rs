//! Files of other programs.

use specval::formats::{Goniometric, ReadOptions, read};
use std::path::{Path, PathBuf};

pub fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/formats")
        .join(name)
}

pub fn load(name: &str) -> Goniometric {
    read(&golden(name), &ReadOptions::default()).unwrap()
}
