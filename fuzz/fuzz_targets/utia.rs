#![no_main]

/// Bytes of every file of the format.
const SIZE: usize = 1_990_656;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if !bytes.is_empty() {
        let whole: Vec<u8> = bytes.iter().copied().cycle().take(SIZE).collect();
        specval_fuzz::survive("x.bin", &whole);
    }
});
