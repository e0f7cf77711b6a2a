#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(draft) = specval::weave::WeaveDraft::parse("x.wif", bytes) {
        let _ = (draft.repeat(), draft.draft());
    }
});
