#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| specval_fuzz::survive("x.ssdd", bytes));
