//! Wavelengths in titles.

/// The wavelength in nm that a title such as `390`, `R390`, `390 nm`, `390_NM`, `X390`, `SPEC_390`, `SPECTRAL_NM390` or
/// `Reflectance (390 nm)` names.
pub(crate) fn band_nm(title: &str) -> Option<f64> {
    const PREFIXES: [&str; 19] = [
        "",
        "r",
        "x",
        "w",
        "wl",
        "l",
        "lambda",
        "rlambda",
        "nm",
        "wavelength",
        "beta",
        "rho",
        "spec",
        "spectral",
        "spectralnm",
        "refl",
        "reflectance",
        "radiancefactor",
        "brf",
    ];
    /// A letter and a smaller number count columns.
    const LEAST_NM: f64 = 100.0;
    let lower = title
        .to_lowercase()
        .replace('\u{3bb}', "lambda")
        .replace('\u{3b2}', "beta");
    let is_between = |c: char| c.is_whitespace() || matches!(c, '_' | '(' | ')' | '[' | ']');
    let bare: String = lower.chars().filter(|&c| !is_between(c)).collect();
    let bare = bare.strip_suffix("nm").filter(|rest| !rest.is_empty()).unwrap_or(&bare);
    let bare = bare.trim_end_matches('.');
    let (prefix, number) = bare.split_at(bare.find(|c: char| c.is_ascii_digit())?);
    let digits = number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if !digits || !PREFIXES.contains(&prefix) {
        return None;
    }
    number
        .parse()
        .ok()
        .filter(|&nm| nm >= LEAST_NM || (nm > 0.0 && prefix.is_empty()))
}
