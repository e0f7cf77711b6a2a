//! What no reader takes: each refused with its place, and nothing large asked of memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use proptest::prelude::*;
use specval::formats::{Format, Location, ReadOptions, WriteOptions, parse, read, write};
use specval::spectrum::parse_spectra;
use specval::weave::WeaveDraft;

/// Remembers the largest single request.
struct Watched;

static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.fetch_max(size, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// Far above what a file of a few hundred kilobytes needs, far below what one could promise.
const LARGEST_ALLOWED: usize = 64 << 20;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats")
}

fn golden(name: &str) -> Vec<u8> {
    std::fs::read(folder().join(name)).unwrap()
}

fn text(name: &str) -> String {
    String::from_utf8(golden(name)).unwrap()
}

fn refused(name: &str, bytes: &[u8]) -> (Location, String) {
    let Err(error) = parse(name, bytes, &ReadOptions::default()) else {
        panic!("{name} was read")
    };
    assert!(error.to_string().starts_with(name), "{error}");
    (error.place.clone(), error.to_string())
}

/// Changes of a golden file and what the message must say.
#[test]
fn faults_are_named() {
    for (name, from, to, says) in [
        ("dir_iso_bw.ddr", "1.29462595", "nan", "'nan'"),
        ("dir_iso_bw.ddr", "1.29462595", "-1.29", "0 or more"),
        ("dir_iso_bw.ddr", "1.29462595", "", "'enddef'"),
        ("dir_iso_bw.ddr", "1.29462595", "1.2 1.3", "expected 'enddef'"),
        ("dir_iso_bw.ddr", "0 20 40 60", "0 40 20 60", "ascending"),
        ("dir_iso_bw.ddr", "0 20 40 60", "0 20 40 95", "'95'"),
        ("dir_iso_bw.ddr", "sigma 4", "sigma 1000000000", "room for"),
        ("dir_iso_bw.ddr", "sigma 4", "sigma 3", "'60'"),
        ("dir_iso_bw.ddr", "ASymmetrical", "PlaneSymmetrical", "0 to 180"),
        ("dir_iso_bw.ddr", "ASymmetrical", "Symmetrical", "AxiSymmetrical"),
        ("dir_iso_bw.ddr", "Luminance", "Luminanz", "Luminance or Intensity"),
        ("dir_iso_bw.ddr", "Source", "Sauce", "key word"),
        ("dir_iso_bw.ddr", "TypeColorModel BW", "TypeColorModel RGB", "'red'"),
        ("dir_iso_bw.ddr", "1 1 1 1\n def", "1 1 1\n def", "'def'"),
        ("dir_iso_rgb.ddr", "gre", "blu", "'gre'"),
        ("libbsdf_iso_spectral7.ddr", "wl 450", "wl 350", "above 400"),
        (
            "libbsdf_iso_spectral7.ddr",
            "spectral 7",
            "spectral 8",
            "end of the file",
        ),
        ("spec_bw.sdt", "0.85", "1.85", "0..1"),
        ("dir_spherical_bw.ssdd", "0.393969262", "-0.39", "0 or more"),
        ("dir_spherical_bw.ssdd", "0.393969262", "0.3 0.4", "1 values in a line"),
        ("dir_spherical_bw.ssdd", "0.393969262\n", "\n", "252 values"),
        ("dir_spherical_bw.ssdd", "0.393969262", "inf", "'inf'"),
        (
            "dir_spherical_bw.ssdd",
            "PARAM2_LIST 0 15",
            "PARAM2_LIST 15 0",
            "ascending",
        ),
        (
            "dir_spherical_bw.ssdd",
            "PARAM2_LIST 0",
            "PARAM7_LIST 0",
            "'PARAM7_LIST'",
        ),
        ("dir_spherical_bw.ssdd", "75 90\n", "75 91\n", "at most 90"),
        ("dir_spherical_bw.ssdd", "brdf", "bssrdf", "'bssrdf'"),
        ("dir_spherical_bw.ssdd", "ascii", "ebcdic", "'ebcdic'"),
        ("dir_iso_rgb.astm", "NUM_POINTS 192", "NUM_POINTS 193", "193"),
        ("dir_iso_rgb.astm", "0,0,0,0,0.4,0.2,0.1", "0,0,0,0,0.4,0.2", "7 values"),
        (
            "dir_iso_rgb.astm",
            "0,0,0,0,0.4,0.2,0.1",
            "0,0,0,0,0.4,,0.1",
            "G, a finite number",
        ),
        (
            "dir_iso_rgb.astm",
            "0,0,0,0,0.4,0.2,0.1",
            "0,0,0,0,0.4,-0.2,0.1",
            "found -0.2",
        ),
        ("dir_iso_rgb.astm", "0,0,0,0,0.4", "0,0,0,0.785398163,0.4", "once"),
        ("dir_plane_mono_zemax.bsdf", "4.000000E-01", "x", "'x'"),
        (
            "dir_plane_mono_zemax.bsdf",
            "PlaneSymmetrical",
            "ASymmetrical4D",
            "0 to 360",
        ),
        ("dir_plane_mono_zemax.bsdf", "DataEnd", "", "'DataEnd'"),
        ("dir_asym_mono_lighttools.bsdf", "TIS", "TIT", "'TIS'"),
        ("dir_asym_xyz_lighttools.bsdf", "TrisX", "TrisY", "TrisX, TrisY, TrisZ"),
        (
            "dir_asym_mono_lighttools.bsdf",
            "Wavelength 550",
            "Wavelength 500",
            "550",
        ),
        ("klems_full_lambert_0p1.xml", "<WindowElement>", "<Window>", "XML"),
        (
            "klems_full_lambert_0p1.xml",
            "Columns</In",
            "Columnes</In",
            "Columns, Rows",
        ),
        ("klems_full_lambert_0p1.xml", "0.1,", "", "21025 values"),
        ("klems_full_lambert_0p1.xml", "0.1,", "NaN,", "'NaN'"),
        ("ttree4_lambert_0p1.xml", "0.1,", "", "16 values"),
        ("ttree4_lambert_0p1.xml", "}", "", "'}'"),
    ] {
        let good = text(name);
        assert!(good.contains(from), "{name} has no {from}");
        let (place, message) = refused(name, good.replacen(from, to, 1).as_bytes());
        assert!(message.contains(says), "{name}, {from} → {to}: {message}");
        let whole = ["DataEnd", "TrisX", "PlaneSymmetrical", "Wavelength 550"].contains(&from);
        assert!(
            whole || matches!(place, Location::Line { .. } | Location::Row { .. }),
            "{message}"
        );
    }
}

#[test]
fn the_place_is_the_line_and_the_column() {
    let good = text("dir_iso_bw.ddr");
    let line = good.lines().position(|l| l.contains("1.29462595")).unwrap();
    let column = good.lines().nth(line).unwrap().find("1.29462595").unwrap();
    for end in ["\n", "\r\n", "\r"] {
        let bad = good.replacen("1.29462595", "x", 1).replace('\n', end);
        let expected = Location::Line {
            line: line + 1,
            column: column + 1,
        };
        assert_eq!(refused("a.ddr", bad.as_bytes()).0, expected);
    }
}

/// Each golden file cut anywhere is refused, but for cuts that take nothing needed.
#[test]
fn truncated_files_are_refused() {
    for entry in std::fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Ok(whole) = parse(&name, &golden(&name), &ReadOptions::default()) else {
            continue;
        };
        let bytes = golden(&name);
        for part in [1, 20, 50, 90, 99] {
            let cut = &bytes[..bytes.len() * part / 100];
            if bytes[cut.len()..].iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            if let Ok(data) = parse(&name, cut, &ReadOptions::default()) {
                // A whole first block is a file of its own.
                assert!(data.components.len() < whole.components.len(), "{name} cut to {part} %");
            }
        }
    }
}

#[test]
fn what_is_no_file_of_readings() {
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let message = |path: &Path| read(path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message(scratch.path()).contains("a folder"));
    assert!(message(&at("missing")).contains("missing"));
    std::fs::write(at("empty"), b"").unwrap();
    assert!(message(&at("empty")).contains("empty"));
    std::fs::write(at("jpeg"), b"\xff\xd8\xff\xe0 not this").unwrap();
    assert!(message(&at("jpeg")).contains("goniometric"));
    assert!(message(&self::folder().join("twill22.wif")).contains("specval weave"));
    #[cfg(unix)]
    assert!(message(Path::new("/dev/zero")).contains("device"));
    // Ten gigabytes of nothing behind a header that promises them.
    for (name, head) in [
        ("a.ddr", golden("dir_iso_bw.ddr")),
        ("b.bsdf", golden("rgl_lambert_rgb.bsdf")),
        ("c.binary", {
            [90u32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect()
        }),
    ] {
        std::fs::write(at(name), head).unwrap();
        std::fs::File::options()
            .write(true)
            .open(at(name))
            .unwrap()
            .set_len(10 << 30)
            .unwrap();
        LARGEST.store(0, Ordering::Relaxed);
        assert!(message(&at(name)).contains("10737418240 bytes"), "{name}");
        assert!(LARGEST.load(Ordering::Relaxed) < LARGEST_ALLOWED);
    }
}

/// Tensor files whose arrays promise more than the file has, or point out of it.
#[test]
fn tensor_headers_are_checked_against_the_file() {
    let good = golden("rgl_lambert_rgb.bsdf");
    let name = b"luminance";
    let at = good.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    for (offset, value) in [
        (3, u64::MAX),
        (3, good.len() as u64 - 8),
        (11, 1 << 40),
        (19, u64::MAX),
        (27, 0),
    ] {
        let mut bad = good.clone();
        bad[at + offset..at + offset + 8].copy_from_slice(&value.to_le_bytes());
        let (place, message) = refused("x.bsdf", &bad);
        assert!(matches!(place, Location::Byte(_)), "{message}");
    }
    let mut bad = good.clone();
    let inside = bad.len() - 1024;
    bad[inside..inside + 8].copy_from_slice(&[0xff; 8]);
    assert!(refused("x.bsdf", &bad).1.contains("NaN"));
    bad[16..20].copy_from_slice(&u32::MAX.to_le_bytes());
    refused("x.bsdf", &bad);
}

/// Nesting deeper than any stack, in both kinds of it.
#[test]
fn deep_nesting_is_refused() {
    let open = "<a>".repeat(100_000);
    refused("x.xml", open.as_bytes());
    let braces = text("ttree4_lambert_0p1.xml").replacen('{', &"{".repeat(100_000), 1);
    assert!(refused("x.xml", braces.as_bytes()).1.contains("nested braces"));
}

fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    LARGEST.store(0, Ordering::Relaxed);
    if let Err(error) = parse("x", bytes, &ReadOptions::default()) {
        prop_assert!(
            error.remedy.len() > 10 && error.to_string().ends_with(&*error.remedy),
            "{error}"
        );
    }
    let largest = LARGEST.load(Ordering::Relaxed);
    prop_assert!(largest < LARGEST_ALLOWED, "{largest} bytes asked for");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..400), head in 0usize..12) {
        let heads: [&[u8]; 12] = [
            b"", b"tensor_file\0\x01\0", b"VERSION 0.3\n", b"VARS a,b,c,d,e\n", b"TypeSym ", b"sigma ", b"<", b"AOI ",
            b"AngleOfIncidence ", b"theta_i_deg,", b"Z\0\0\0Z\0\0\0\xb4\0\0\0", b"def sigma 3 "];
        survives(&[heads[head], bytes.as_slice()].concat())?;
    }

    #[test]
    fn changed_files_are_survived(
        file in 0usize..12,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0usize..4), 1..6),
    ) {
        const FILES: [&str; 12] = [
            "dir_iso_bw.ddr", "spec_rgb.sdr", "dir_spherical_bw.ssdd", "dir_specular_spectral7_binary.ssdd",
            "dir_iso_rgb.astm", "dir_plane_mono_zemax.bsdf", "dir_asym_mono_lighttools.bsdf", "ttree4_lambert_0p1.xml",
            "klems_full_lambert_0p1.xml", "rgl_lambert_rgb.bsdf", "dir_btdf_sigmat_bw.ddt", "dir_specular_bilateral_xyz.ssdd",
        ];
        let mut bytes = golden(FILES[file]);
        for (place, byte, kind) in changes {
            // Headers are where the harm is.
            let end = if kind % 2 == 0 { bytes.len().min(600) } else { bytes.len() };
            let at = place.index(end);
            match kind {
                0 | 1 => bytes[at] = byte,
                2 => { bytes.remove(at); }
                _ => bytes.insert(at, byte),
            }
        }
        survives(&bytes)?;
    }
}

/// A million changed copies of a small file, none of which may crash, take 10 s or ask for 256 MiB at once.
fn a_million(what: &str, good: &[u8], taken: impl Fn(&[u8]) -> bool) {
    let mut random = randomly();
    LARGEST.store(0, Ordering::Relaxed);
    let (start, mut longest, mut count) = (Instant::now(), Duration::ZERO, 0);
    for _ in 0..1_000_000 {
        let mut bytes = good.to_vec();
        for _ in 0..1 + random(4) {
            let end = if random(2) == 0 {
                bytes.len().min(500)
            } else {
                bytes.len()
            };
            let at = random(end);
            match random(5) {
                0 => bytes[at] = random(256) as u8,
                1 => bytes[at] = b"0123456789 .-e\n{}<>"[random(19)],
                2 => bytes.insert(at, random(256) as u8),
                3 => bytes.truncate(at.max(1)),
                _ => drop(bytes.drain(at..(at + random(30)).min(bytes.len()))),
            }
            if bytes.is_empty() {
                bytes.push(b' ');
            }
        }
        let began = Instant::now();
        count += usize::from(taken(&bytes));
        longest = longest.max(began.elapsed());
    }
    told(what, 1_000_000, count, start.elapsed(), longest);
}

/// Numbers below what they are given, the same ones every time.
fn randomly() -> impl FnMut(usize) -> usize {
    let mut state = 63u64;
    move |below| {
        // Knuth's multiplier; the upper bits are good enough to choose bytes with.
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    }
}

fn told(what: &str, times: usize, count: usize, all: Duration, longest: Duration) {
    let largest = LARGEST.load(Ordering::Relaxed);
    println!(
        "{what}: {count} of {times} taken in {:.0} s, the longest in {longest:.1?}, at most {largest} bytes asked for \
         at once",
        all.as_secs_f64()
    );
    assert!(largest < 256 << 20 && longest < Duration::from_secs(10));
}

/// One ignored test for each reader and its seed: `cargo test --release --test files formats_refuse:: -- --ignored
/// NAME`.
macro_rules! a_million_of {
    ($($test:ident: $seed:literal,)+) => {$(
        #[test]
        #[ignore = "a minute or two"]
        fn $test() {
            let seed = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join($seed)).unwrap();
            a_million(stringify!($test), &seed, |bytes| parse("x", bytes, &ReadOptions::default()).is_ok());
        }
    )+};
}

a_million_of! {
    million_csv: "fuzz/corpus/csv/sphere.csv",
    million_ddr: "fuzz/corpus/ddr/dir_plane_bw.ddr",
    million_ddt: "fuzz/corpus/ddr/dir_btdf_sigmat_bw.ddt",
    million_sdr: "fuzz/corpus/sdr/spec_rgb.sdr",
    million_ssdd_text: "fuzz/corpus/ssdd/dir_spherical_bw.ssdd",
    million_ssdd_binary: "tests/data/formats/dir_specular_spectral7_binary.ssdd",
    million_astm: "fuzz/corpus/astm/five.astm",
    million_zemax: "fuzz/corpus/zemax/dir_plane_mono_zemax.bsdf",
    million_lighttools: "fuzz/corpus/lighttools/dir_asym_mono_lighttools.bsdf",
    million_klems: "fuzz/corpus/radiance/two_patches.xml",
    million_tensor_tree: "fuzz/corpus/radiance/ttree4_lambert_0p1.xml",
    million_rgl: "fuzz/corpus/rgl/rgl_warped_rgb.bsdf",
    million_merl_header: "fuzz/corpus/merl/header.binary",
    million_utia_short: "fuzz/corpus/utia/half.bin",
}

#[test]
#[ignore = "a minute or two"]
fn million_wif() {
    a_million("million_wif", &golden("twill22.wif"), |bytes| {
        WeaveDraft::parse("x", bytes).is_ok_and(|draft| draft.draft().is_ok())
    });
}

#[test]
#[ignore = "a minute or two"]
fn million_spectra() {
    for name in ["sets.txt", "argyll.sp", "waves.txt", "observer.csv"] {
        let seed = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("fuzz/corpus/spectra")
            .join(name);
        a_million(name, &std::fs::read(seed).unwrap(), |bytes| {
            parse_spectra("x", bytes).is_ok()
        });
    }
}

/// Changed copies of a file too large to copy: bytes and whole values are changed in place, and put back.
fn changed_in_place(what: &str, bytes: &mut [u8], times: usize) {
    const VALUES: [f64; 6] = [f64::NAN, f64::INFINITY, -1.0, 1e308, 5e-324, 0.25];
    let mut random = randomly();
    LARGEST.store(0, Ordering::Relaxed);
    let (start, mut longest, mut count) = (Instant::now(), Duration::ZERO, 0);
    for _ in 0..times {
        let mut before = Vec::new();
        for _ in 0..1 + random(4) {
            let end = if random(4) == 0 { 500 } else { bytes.len() - 8 };
            let at = random(end);
            before.push((at, bytes[at..at + 8].to_vec()));
            match random(2) {
                0 => bytes[at] = random(256) as u8,
                _ => bytes[at..at + 8].copy_from_slice(&VALUES[random(VALUES.len())].to_le_bytes()),
            }
        }
        let began = Instant::now();
        count += usize::from(parse("x", bytes, &ReadOptions::default()).is_ok());
        longest = longest.max(began.elapsed());
        for (at, old) in before.into_iter().rev() {
            bytes[at..at + 8].copy_from_slice(&old);
        }
    }
    told(what, times, count, start.elapsed(), longest);
}

#[test]
#[ignore = "half an hour"]
fn million_utia() {
    let mut whole = vec![0.5f64.to_le_bytes(); 1_990_656 / 8].concat();
    changed_in_place("million_utia", &mut whole, 1_000_000);
}

/// A million files of 35 MB would take a day.
#[test]
#[ignore = "some minutes"]
fn thousand_merl() {
    let lambert = write(
        &parse("x.ddr", &golden("dir_iso_rgb.ddr"), &ReadOptions::default()).unwrap(),
        Format::MERL,
        &WriteOptions::default(),
    );
    changed_in_place("thousand_merl", &mut lambert.unwrap().bytes, 1_000);
}
