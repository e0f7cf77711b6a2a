//! Artefact files: what is written reads back bit for bit, and what is not as it was written is refused.

use proptest::prelude::*;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use specval::artefact::{ArrayInfo, ArtefactError, ArtefactKind, Element, ElementType, Identity, Reader, Writer};
use std::error::Error;
use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const MEAN: [f64; 6] = [0.1, -0.0, f64::INFINITY, 5e-324, f64::MIN, 6.0];
const SE: [f32; 3] = [1.5, f32::NEG_INFINITY, -0.0];
const PATHS: [u64; 2] = [u64::MAX, 1 << 53 | 1];

fn array(name: &str, shape: &[usize], element: ElementType) -> ArrayInfo {
    ArrayInfo {
        name: name.into(),
        unit: "1/sr".into(),
        axes: "tilt; wavelength".into(),
        shape: shape.into(),
        element,
    }
}

fn arrays() -> Vec<ArrayInfo> {
    vec![
        array("mean", &[2, 3], ElementType::F64),
        array("none", &[4, 0], ElementType::F64),
        array("se", &[3], ElementType::F32),
        array("paths", &[2], ElementType::U64),
    ]
}

fn settings() -> Value {
    json!({"seed": 1, "trace": {"batches": 8, "fold": true}, "rig": {"incidences_deg": [0.0, 30.0, 60.0]}})
}

fn identity() -> Identity {
    Identity::new(1, &settings()).unwrap()
}

fn header() -> Value {
    json!({"wavelength_nm": [380.0, 0.1 + 0.2], "batch": 3, "note": "line\nend"})
}

fn write(path: &Path, kind: ArtefactKind) -> Result<(), ArtefactError> {
    let mut writer = Writer::create(path, kind, &identity(), &header(), &arrays())?;
    writer.append("mean", MEAN[..4].iter().copied())?;
    writer.append("mean", MEAN[4..].iter().copied())?;
    writer.append("se", SE)?;
    writer.append("paths", PATHS)?;
    writer.finish()
}

/// A folder with one small state file.
fn state() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.state");
    write(&path, ArtefactKind::State).unwrap();
    (folder, path)
}

fn names(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn everything_reads_back() {
    let (folder, path) = state();
    assert_eq!(names(&folder), ["run.state"]);
    let mut reader = Reader::open(&path, ArtefactKind::State).unwrap();
    assert_eq!(reader.identity(), &identity());
    reader.expect(&identity()).unwrap();
    assert_eq!(reader.header(), &header());
    assert_eq!(reader.version(), env!("CARGO_PKG_VERSION"));
    assert!(reader.arrays().eq(&arrays()));
    let bits: Vec<u64> = MEAN.map(f64::to_bits).to_vec();
    let mean: Vec<f64> = reader.array("mean", &[2, 3]).unwrap();
    assert_eq!(mean.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), bits);
    // Any order, any number of times.
    assert_eq!(reader.array::<u64>("paths", &[2]).unwrap(), PATHS);
    assert_eq!(reader.array::<f32>("se", &[3]).unwrap(), SE);
    assert!(reader.array::<f64>("none", &[4, 0]).unwrap().is_empty());
    let mut part = [0.0; 2];
    reader.read_part("mean", &[2, 3], 3, &mut part).unwrap();
    assert_eq!(part, MEAN[3..5]);
    assert!(reader.read_part("mean", &[2, 3], 5, &mut part).is_err());
    assert!(reader.read_part("mean", &[2, 3], usize::MAX, &mut part).is_err());
}

/// The format as documented, taken apart without the reader.
#[test]
fn the_bytes_are_as_documented() {
    let (_folder, path) = state();
    let bytes = fs::read(path).unwrap();
    let (before, checksum) = bytes.split_at(bytes.len() - 32);
    assert_eq!(Sha256::digest(before).as_slice(), checksum);
    let mut lines = before.splitn(3, |b| *b == b'\n');
    assert_eq!(lines.next().unwrap(), b"specval-state 1");
    let head: Value = serde_json::from_slice(lines.next().unwrap()).unwrap();
    assert_eq!(head["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(head["identity"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(head["identity"]["trace"]["batches"], 8);
    assert_eq!(head["header"], header());
    assert_eq!(
        head["arrays"][2],
        json!({"name": "se", "unit": "1/sr", "axes": "tilt; wavelength", "shape": [3], "element": "f32", "offset": 48, "length": 12})
    );
    let mut expected = Vec::new();
    MEAN.iter().for_each(|v| expected.extend(v.to_le_bytes()));
    SE.iter().for_each(|v| expected.extend(v.to_le_bytes()));
    PATHS.iter().for_each(|v| expected.extend(v.to_le_bytes()));
    assert_eq!(lines.next().unwrap(), expected);
}

#[test]
fn every_flipped_bit_is_refused() {
    let (_folder, path) = state();
    let whole = fs::read(&path).unwrap();
    // In place: writing a file anew thousands of times is what takes long here.
    let mut file = fs::OpenOptions::new().write(true).open(&path).unwrap();
    let mut put = |i: usize, byte: u8| {
        file.seek(SeekFrom::Start(i as u64)).unwrap();
        file.write_all(&[byte]).unwrap();
    };
    for (i, &byte) in whole.iter().enumerate() {
        for bit in 0..8 {
            put(i, byte ^ 1 << bit);
            let error = Reader::open(&path, ArtefactKind::State).expect_err(&format!("bit {bit} of byte {i}"));
            assert!(error.to_string().contains("run.state: expected "), "{error}");
        }
        put(i, byte);
    }
    assert_eq!(fs::read(&path).unwrap(), whole, "reading never writes");
    Reader::open(&path, ArtefactKind::State).unwrap();
}

#[test]
fn every_other_length_is_refused() {
    let (_folder, path) = state();
    let expected = fs::metadata(&path).unwrap().len();
    let file = fs::OpenOptions::new().write(true).open(&path).unwrap();
    for length in (0..=expected + 1).rev().filter(|length| *length != expected) {
        file.set_len(length).unwrap();
        let error = Reader::open(&path, ArtefactKind::State).expect_err(&format!("{length} bytes"));
        assert!(error.to_string().contains("run.state: expected "), "{error}");
        let arrays_are_declared = length + 100 > expected;
        let by_size =
            matches!(error, ArtefactError::Size { expected: e, found, .. } if (e, found) == (expected, length));
        assert!(by_size || !arrays_are_declared, "{error}");
    }
}

#[test]
fn other_kinds_versions_and_programs_are_refused() {
    let (folder, path) = state();
    let error = Reader::open(&path, ArtefactKind::Shard).unwrap_err();
    assert!(matches!(
        error,
        ArtefactError::OtherKind {
            expected: ArtefactKind::Shard,
            found: ArtefactKind::State,
            ..
        }
    ));
    assert!(
        error.to_string().contains("expected a shard, found the state of a run"),
        "{error}"
    );

    let mut newer = fs::read(&path).unwrap();
    newer["specval-state ".len()] = b'2';
    fs::write(&path, newer).unwrap();
    let error = Reader::open(&path, ArtefactKind::State).unwrap_err();
    assert!(matches!(error, ArtefactError::OtherVersion { found: 2, .. }), "{error}");
    assert!(
        error.to_string().contains("format version 1, found version 2"),
        "{error}"
    );

    for (bytes, shown) in [
        (&b""[..], "an empty file"),
        (b"specval trace 1\n{}\n", "specval trace 1"),
        (b"\x89PNG\r\n", "PNG\\r"),
    ] {
        fs::write(&path, bytes).unwrap();
        let error = Reader::open(&path, ArtefactKind::State).unwrap_err();
        assert!(matches!(error, ArtefactError::NotOurs { .. }), "{error}");
        assert!(error.to_string().contains(shown), "{error}");
    }
    let error = Reader::open(folder.path(), ArtefactKind::State).unwrap_err();
    assert!(matches!(error, ArtefactError::NotAFile { .. }), "{error}");
    let error = Reader::open(folder.path().join("absent"), ArtefactKind::State).unwrap_err();
    assert!(
        matches!(error, ArtefactError::NotReadable { .. }) && error.source().is_some(),
        "{error}"
    );
}

/// Sizes in a header are not believed: no memory is taken for them.
#[test]
fn inconsistent_headers_with_a_valid_checksum_are_refused() {
    let (_folder, path) = state();
    let whole = fs::read(&path).unwrap();
    let text = String::from_utf8_lossy(&whole[..whole.len() - 32 - 76]).into_owned();
    for (from, to) in [
        ("\"shape\":[2,3]", "\"shape\":[2,4]"),
        ("\"shape\":[2,3]", "\"shape\":[4611686018427387904,4]"),
        ("\"shape\":[2,3]", "\"shape\":[-1]"),
        ("\"offset\":48,\"length\":12", "\"offset\":40,\"length\":12"),
        (
            "\"shape\":[2],\"element\":\"u64\",\"offset\":60,\"length\":16",
            "\"shape\":[9007199254740992],\"element\":\"u64\",\"offset\":60,\"length\":72057594037927936",
        ),
        ("\"name\":\"se\"", "\"name\":\"mean\""),
        ("\"element\":\"f32\"", "\"element\":\"f16\""),
    ] {
        let lie = text.replacen(from, to, 1);
        assert_ne!(lie, text, "{from}");
        let mut bytes = lie.into_bytes();
        bytes.extend(&whole[whole.len() - 32 - 76..whole.len() - 32]);
        bytes.extend(Sha256::digest(&bytes));
        fs::write(&path, bytes).unwrap();
        let error = Reader::open(&path, ArtefactKind::State).expect_err(to);
        assert!(
            matches!(error, ArtefactError::Damaged { .. } | ArtefactError::Size { .. }),
            "{error}"
        );
    }
}

#[test]
fn files_of_another_run_are_refused_by_the_settings_that_differ() {
    let (_folder, path) = state();
    let reader = Reader::open(&path, ArtefactKind::State).unwrap();
    let mut other = settings();
    other["trace"]["batches"] = json!(16);
    other["rig"]["incidences_deg"][2] = json!(45.0);
    other["trace"]["roulette"] = json!({"survival": 0.5});
    other["seed"] = json!(2);
    let other = Identity::new(2, &other).unwrap();
    let differences = other.differences(reader.identity());
    let found: Vec<[&str; 3]> = differences
        .iter()
        .map(|d| [d.key.as_str(), d.here.as_str(), d.there.as_str()])
        .collect();
    let expected = [
        ["rig.incidences_deg.2", "45.0", "60.0"],
        ["seed", "2", "1"],
        ["trace.batches", "16", "8"],
        ["trace.roulette", "{\"survival\":0.5}", "absent"],
    ];
    assert_eq!(found, expected);
    let error = reader.expect(&other).unwrap_err();
    assert!(matches!(&error, ArtefactError::Foreign { differences: d, .. } if *d == differences));
    for part in [
        "run.state",
        "`trace.batches`: expected 16, found 8",
        "`seed`: expected 2, found 1",
    ] {
        assert!(error.to_string().contains(part), "{error}");
    }

    // Many, and long ones: the first few, cut, and how many more.
    let many: Vec<u32> = (0..100).collect();
    let many = Identity::new(1, &json!({"a": many, "b": 1, "c": 1, "d": 1, "e": 1})).unwrap();
    let text = reader.expect(&many).unwrap_err().to_string();
    assert!(
        text.contains("`a`: expected [0,1,2,") && text.contains("…") && text.contains("and 3 more"),
        "{text}"
    );
    assert!(!text.contains("`e`"), "{text}");
}

/// A file of another program version belongs to another run.
#[test]
fn the_program_version_is_part_of_the_identity() {
    let (_folder, path) = state();
    let whole = fs::read(&path).unwrap();
    let before = &whole[..whole.len() - 32];
    let here = format!("\"version\":\"{}\"", env!("CARGO_PKG_VERSION")).into_bytes();
    let mut bytes = before.to_vec();
    while let Some(at) = bytes.windows(here.len()).position(|w| w == here) {
        bytes.splice(at..at + here.len(), *b"\"version\":\"0.0.9\"");
    }
    bytes.extend(Sha256::digest(&bytes));
    fs::write(&path, bytes).unwrap();
    let reader = Reader::open(&path, ArtefactKind::State).unwrap();
    assert_eq!(reader.version(), "0.0.9");
    let text = reader.expect(&identity()).unwrap_err().to_string();
    assert!(text.contains("`version`: expected"), "{text}");
}

#[test]
fn an_identity_has_one_seed_and_named_settings() {
    for settings in [json!({"seed": 2}), json!({"version": "0"}), json!([1]), Value::Null] {
        let error = Identity::new(1, &settings).unwrap_err();
        assert!(matches!(error, ArtefactError::Identity { .. }), "{error}");
    }
    assert_eq!(Identity::new(7, &json!({})).unwrap().value()["seed"], 7);
}

#[test]
fn an_interrupted_write_leaves_the_old_file() {
    let (folder, path) = state();
    let old = fs::read(&path).unwrap();
    type Step = fn(&mut Writer) -> Result<(), ArtefactError>;
    let steps: [Step; 6] = [
        |_| Ok(()),
        |w| w.append("mean", MEAN[..5].iter().copied()),
        |w| w.append("mean", MEAN).and_then(|()| w.append("mean", [7.0])),
        |w| w.append("se", SE),
        |w| w.append("mean", SE),
        |w| w.append("absent", MEAN),
    ];
    for (i, step) in steps.into_iter().enumerate() {
        let create = || Writer::create(&path, ArtefactKind::State, &identity(), &json!(null), &arrays()).unwrap();
        let mut writer = create();
        assert_eq!(names(&folder).len(), 2, "beside its place");
        let _ = step(&mut writer);
        drop(writer);
        assert_eq!(names(&folder), ["run.state"], "dropped after step {i}");

        let mut writer = create();
        let _ = step(&mut writer);
        let error = writer.finish().expect_err(&format!("finished after step {i}"));
        assert!(
            error.to_string().contains("run.state: not written: expected "),
            "{error}"
        );
        assert_eq!(names(&folder), ["run.state"], "refused after step {i}");
        assert_eq!(fs::read(&path).unwrap(), old);
    }

    // An error that was passed over spoils the file for good.
    let mut writer = Writer::create(&path, ArtefactKind::State, &identity(), &header(), &arrays()).unwrap();
    assert!(writer.append("mean", MEAN.into_iter().chain([7.0])).is_err());
    writer.append("se", SE).unwrap();
    writer.append("paths", PATHS).unwrap();
    assert!(writer.finish().is_err());
    assert_eq!(fs::read(&path).unwrap(), old);
}

#[test]
fn two_writers_of_one_place_do_not_mix() {
    let (folder, path) = state();
    let create = |n: u64| {
        let one = [array("n", &[], ElementType::U64)];
        let mut writer = Writer::create(&path, ArtefactKind::State, &identity(), &json!(null), &one).unwrap();
        writer.append("n", [n]).unwrap();
        writer
    };
    let (first, second) = (create(1), create(2));
    first.finish().unwrap();
    let mut held = Reader::open(&path, ArtefactKind::State).unwrap();
    second.finish().unwrap();
    assert_eq!(held.array::<u64>("n", &[]).unwrap(), [1]);
    let mut last = Reader::open(&path, ArtefactKind::State).unwrap();
    assert_eq!(last.array::<u64>("n", &[]).unwrap(), [2]);
    assert_eq!(names(&folder), ["run.state"]);
}

#[test]
fn unwritable_places_are_refused_before_any_work() {
    let (folder, path) = state();
    let create =
        |path: &Path| Writer::create(path, ArtefactKind::State, &identity(), &header(), &arrays()).unwrap_err();
    let error = create(&folder.path().join("absent/run.state"));
    assert!(matches!(error, ArtefactError::NotWritable { .. }), "{error}");
    let error = create(&path.join("below"));
    assert!(matches!(error, ArtefactError::NotWritable { .. }), "{error}");
    for place in [folder.path(), Path::new("")] {
        let error = create(place);
        assert!(matches!(error, ArtefactError::Output(_)), "{error}");
    }

    let refused = |header: Value, arrays: &[ArrayInfo]| {
        let error = Writer::create(&path, ArtefactKind::State, &identity(), &header, arrays).unwrap_err();
        assert!(matches!(error, ArtefactError::Undeclared { .. }), "{error}");
    };
    let twice = array("a", &[1], ElementType::F64);
    refused(header(), &[twice.clone(), twice]);
    refused(header(), &[array("a", &[usize::MAX, 2], ElementType::F64)]);
    refused(header(), &[array("a", &[usize::MAX], ElementType::F32)]);
    refused((0..200).fold(json!(1), |inner, _| json!([inner])), &[]);
    assert_eq!(names(&folder), ["run.state"]);
}

#[cfg(unix)]
#[test]
fn links_and_devices_stay_what_they_are() {
    write(Path::new("/dev/null"), ArtefactKind::State).unwrap();
    assert!(!Path::new("/dev/null").is_file());
    let (folder, path) = state();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&path, &link).unwrap();
    fs::write(&path, "old").unwrap();
    write(&link, ArtefactKind::State).unwrap();
    assert!(link.is_symlink());
    Reader::open(&path, ArtefactKind::State).unwrap();
}

#[test]
fn other_shapes_and_elements_are_refused() {
    let (_folder, path) = state();
    let mut reader = Reader::open(&path, ArtefactKind::State).unwrap();
    let text = reader.array::<f64>("mean", &[3, 2]).unwrap_err().to_string();
    assert!(
        text.contains("run.state: array `mean`: expected f64 [3, 2], found f64 [2, 3]"),
        "{text}"
    );
    let text = reader.array::<u64>("mean", &[2, 3]).unwrap_err().to_string();
    assert!(text.contains("expected u64 [2, 3], found f64 [2, 3]"), "{text}");
    let text = reader.array::<f64>("means", &[2, 3]).unwrap_err().to_string();
    assert!(text.contains("only [\"mean\", \"none\", \"se\", \"paths\"]"), "{text}");
}

/// Writes in pieces of one size and reads in pieces of another, both across the ends of buffers.
fn through_a_file<T: Element>(values: &[T], written: usize, read: usize) -> Vec<T> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shard");
    let shape = [values.len()];
    let mut writer = Writer::create(
        &path,
        ArtefactKind::Shard,
        &identity(),
        &json!({}),
        &[array("x", &shape, T::TYPE)],
    )
    .unwrap();
    for piece in values.chunks(written) {
        writer.append("x", piece.iter().copied()).unwrap();
    }
    writer.finish().unwrap();
    let mut reader = Reader::open(&path, ArtefactKind::Shard).unwrap();
    let mut back = vec![T::default(); values.len()];
    for (i, piece) in back.chunks_mut(read).enumerate() {
        reader.read_part("x", &shape, i * read, piece).unwrap();
    }
    back
}

#[test]
fn large_arrays_cross_every_buffer() {
    let values: Vec<u64> = (0..100_000)
        .map(|i: u64| i.wrapping_mul(0x9e37_79b9_7f4a_7c15))
        .collect();
    assert_eq!(through_a_file(&values, 777, 30_011), values);
    let halves: Vec<f32> = values.iter().map(|v| *v as f32).collect();
    assert_eq!(through_a_file(&halves, 100_000, 100_000), halves);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any bits at all: NaN with any payload, both zeros, numbers below the normal ones.
    #[test]
    fn arrays_keep_their_bits(bits in prop::collection::vec(any::<u64>(), 0..300), written in 1_usize..50, read in 1_usize..50) {
        let special = [f64::NAN.to_bits() | 0xbeef, 0x7ff0_0000_0000_0001, 0xfff8_0000_0000_0007, (-0.0_f64).to_bits()];
        let bits: Vec<u64> = special.into_iter().chain(bits).collect();
        let doubles: Vec<f64> = bits.iter().map(|b| f64::from_bits(*b)).collect();
        let back: Vec<u64> = through_a_file(&doubles, written, read).iter().map(|v| v.to_bits()).collect();
        prop_assert_eq!(&back, &bits);
        let singles: Vec<u32> = bits.iter().map(|b| *b as u32 ^ 0x7f80_0001).collect();
        let floats: Vec<f32> = singles.iter().map(|b| f32::from_bits(*b)).collect();
        let back: Vec<u32> = through_a_file(&floats, written, read).iter().map(|v| v.to_bits()).collect();
        prop_assert_eq!(back, singles);
    }

    /// A study's numbers are the same run after the file as before it, to the last bit.
    #[test]
    fn settings_keep_their_bits(values in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 1..40), seed: u64) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let identity = Identity::new(seed, &json!({"values": values})).unwrap();
        Writer::create(&path, ArtefactKind::State, &identity, &json!(values), &[]).unwrap().finish().unwrap();
        let reader = Reader::open(&path, ArtefactKind::State).unwrap();
        prop_assert!(reader.expect(&identity).is_ok());
        let back: Vec<u64> = reader.header().as_array().unwrap().iter().map(|v| v.as_f64().unwrap().to_bits()).collect();
        prop_assert_eq!(back, values.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
    }
}
