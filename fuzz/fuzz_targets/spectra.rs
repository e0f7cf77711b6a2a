#![no_main]

use specval::spectrum::{Spectrum, parse_observer, parse_spectra, parse_spectrum};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(spectra) = parse_spectra("x", bytes) {
        assert!(!spectra.is_empty());
    }
    if let Ok(Spectrum::Table { samples, .. }) = parse_spectrum("x", bytes, 0.0..=1.0) {
        assert!(samples.values().iter().all(|value| (0.0..=1.0).contains(value)));
    }
    let _ = parse_observer("x", bytes);
});
