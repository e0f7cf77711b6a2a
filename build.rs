//! Sets `SPECVAL_BUILD`, which tells builds apart in `--version`: the commit, where there is one, and a digest of the sources.
//!
//! Reads the files of the repository itself, so it needs no git, and a source archive builds as well.

use std::fs;
use std::path::{Path, PathBuf};

/// What the program is compiled from.
const SOURCES: [&str; 6] = ["src", "spectra", "measurements", "Cargo.toml", "Cargo.lock", "build.rs"];

fn main() {
    let mut digest = Fnv::new();
    for source in SOURCES {
        // Changes of anything else need no new build.
        println!("cargo:rerun-if-changed={source}");
        add(Path::new(source), &mut digest);
    }
    let sources = format!("sources {:016x}", digest.0);
    let build = match commit() {
        Some(commit) => format!("commit {}, {sources}", commit.get(..12).unwrap_or(&commit)),
        None => sources,
    };
    println!("cargo:rustc-env=SPECVAL_BUILD={build}");
}

/// The commit that is checked out, in hexadecimal; in a worktree too.
fn commit() -> Option<String> {
    let mut git = PathBuf::from(".git");
    if let Ok(text) = fs::read_to_string(&git) {
        git = text.trim().strip_prefix("gitdir: ")?.into();
    }
    let head = read(&git.join("HEAD"))?;
    // Grows with every commit, also where the branch's own file does not exist because its reference is packed.
    read(&git.join("logs/HEAD"));
    let Some(name) = head.strip_prefix("ref: ") else {
        return Some(head);
    };
    let common = match read(&git.join("commondir")) {
        Some(path) => git.join(path),
        None => git,
    };
    read(&common.join(name)).or_else(|| {
        let packed = read(&common.join("packed-refs"))?;
        let line = packed.lines().find(|line| line.ends_with(&format!(" {name}")))?;
        Some(line.split(' ').next()?.to_owned())
    })
}

/// A file's text without blanks around it; a change of the file makes a new build.
fn read(path: &Path) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    println!("cargo:rerun-if-changed={}", path.display());
    Some(text.trim().to_owned())
}

/// Names and contents, in an order that no file system decides about.
fn add(path: &Path, digest: &mut Fnv) {
    if let Ok(entries) = fs::read_dir(path) {
        let mut entries: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        entries.sort();
        entries.iter().for_each(|entry| add(entry, digest));
    } else if let Ok(bytes) = fs::read(path) {
        digest.add(path.to_string_lossy().as_bytes());
        digest.add(&bytes);
    }
}

/// FNV-1a, 64 bits (Fowler, Noll and Vo).
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
