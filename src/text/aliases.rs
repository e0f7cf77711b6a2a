//! Titles that columns have in the tables of instruments, spreadsheets and scripts, and the form in which they are
//! compared.

/// Columns of this program's own tables.
pub(super) const NAMES: [&str; 22] = [
    "theta_i_deg",
    "theta_v_deg",
    "phi_i_deg",
    "theta_o_deg",
    "phi_o_deg",
    "wavelength_nm",
    "beta",
    "beta_se",
    "beta_r",
    "beta_g",
    "beta_b",
    "beta_x",
    "beta_y",
    "beta_z",
    "beta_r_se",
    "beta_g_se",
    "beta_b_se",
    "beta_x_se",
    "beta_y_se",
    "beta_z_se",
    "value",
    "name",
];

/// Other titles of these columns, in the form of [`plain`] without a unit.
pub(super) const WAVELENGTHS: &[&str] = &[
    "wavelength",
    "wavelengths",
    "wave_length",
    "wl",
    "wvl",
    "lambda",
    "lam",
    "nm",
    "nanometer",
    "nanometers",
    "nanometre",
    "nanometres",
    "wellenlange",
    "wellenlaenge",
    "longueur_d_onde",
    "longitud_de_onda",
    "lunghezza_d_onda",
    "comprimento_de_onda",
    "golflengte",
    "vaglangd",
    "\u{434}\u{43b}\u{438}\u{43d}\u{430}_\u{432}\u{43e}\u{43b}\u{43d}\u{44b}",
    "\u{6ce2}\u{957f}",
    "\u{6ce2}\u{9577}",
];
pub(super) const INCIDENCE: &[&str] = &[
    "theta_i",
    "theta_in",
    "theta_inc",
    "theta_incident",
    "thetai",
    "thetain",
    "aoi",
    "incidence",
    "incidence_angle",
    "incident_angle",
    "incident",
    "angle_of_incidence",
    "illumination",
    "illumination_angle",
    "einfallswinkel",
    "angle_d_incidence",
    "zenith_i",
    "zenith_in",
];
pub(super) const VIEW: &[&str] = &[
    "theta_v",
    "theta_view",
    "theta_r",
    "theta_o",
    "theta_s",
    "theta_out",
    "theta_det",
    "theta_ref",
    "thetav",
    "thetar",
    "thetao",
    "thetas",
    "thetaout",
    "view",
    "view_angle",
    "viewing_angle",
    "detector",
    "detector_angle",
    "detection_angle",
    "observation_angle",
    "reflection_angle",
    "ausfallswinkel",
    "beobachtungswinkel",
    "zenith_o",
    "zenith_r",
    "zenith_v",
    "zenith_out",
];
pub(super) const INCIDENT_AZIMUTH: &[&str] = &[
    "phi_i",
    "phi_in",
    "phi_inc",
    "phii",
    "phiin",
    "azimuth_i",
    "azimuth_in",
    "incident_azimuth",
    "incidence_azimuth",
];
pub(super) const VIEW_AZIMUTH: &[&str] = &[
    "phi_o",
    "phi_out",
    "phi_r",
    "phi_s",
    "phi_v",
    "phi_view",
    "phio",
    "phiout",
    "phir",
    "phis",
    "phiv",
    "azimuth_o",
    "azimuth_r",
    "azimuth_v",
    "azimuth_out",
    "view_azimuth",
    "viewing_azimuth",
    "detector_azimuth",
    "outgoing_azimuth",
];
pub(super) const BETA: &[&str] = &[
    "radiance_factor",
    "brightness_factor",
    "luminance_factor",
    "reflectance_factor",
    "reflectance",
    "brf",
    "beta",
    "r",
    "value",
];
pub(super) const BETA_SE: &[&str] = &[
    "beta_se",
    "se",
    "std",
    "sigma",
    "uncertainty",
    "standard_error",
    "standard_uncertainty",
];
pub(super) const RGB: [(&str, &[&str]); 3] = [
    ("beta_r", &["r", "red", "beta_red"]),
    ("beta_g", &["g", "green", "beta_green"]),
    ("beta_b", &["b", "blue", "beta_blue"]),
];

/// Units that end a title in the form of [`plain`].
pub(super) const DEGREES: &[&str] = &["deg", "degree", "degrees"];
pub(super) const RADIANS: &[&str] = &["rad", "radian", "radians"];
pub(super) const NANOMETRES: &[&str] = &[
    "nm",
    "nanometer",
    "nanometers",
    "nanometre",
    "nanometres",
    "\u{43d}\u{43c}",
];
pub(super) const MICROMETRES: &[&str] = &[
    "um",
    "micron",
    "microns",
    "micrometer",
    "micrometers",
    "micrometre",
    "micrometres",
];
pub(super) const ANGSTROMS: &[&str] = &["a", "angstrom", "angstroms"];

/// Lower case without accents, Greek letters by name; blanks, brackets and dots are one underscore, words in one are
/// split where a capital follows a small letter.
pub(super) fn plain(title: &str) -> String {
    let mut plain = String::new();
    let mut was_small = false;
    for c in title.replace('\u{b0}', "deg").chars() {
        let splits = c.is_uppercase() && was_small && plain.chars().filter(|c| *c != '_').count() > 3;
        was_small = c.is_lowercase();
        if splits {
            plain.push('_');
        }
        for c in c.to_lowercase() {
            match c {
                // Marks of letters that are written as two characters.
                '\u{300}'..='\u{36f}' => {}
                '\u{e0}'..='\u{e5}' => plain.push('a'),
                '\u{e7}' => plain.push('c'),
                '\u{e8}'..='\u{eb}' => plain.push('e'),
                '\u{f2}'..='\u{f6}' => plain.push('o'),
                '\u{f9}'..='\u{fc}' => plain.push('u'),
                '\u{b5}' | '\u{3bc}' => plain.push('u'),
                '\u{3b2}' => plain += "beta",
                '\u{3b8}' | '\u{3d1}' => plain += "theta",
                '\u{3bb}' => plain += "lambda",
                '\u{3c1}' => plain += "rho",
                '\u{3c6}' | '\u{3d5}' => plain += "phi",
                c if c.is_alphanumeric() => plain.push(c),
                _ if !plain.is_empty() && !plain.ends_with('_') => plain.push('_'),
                _ => {}
            }
        }
    }
    plain.truncate(plain.trim_end_matches('_').len());
    plain
}

/// What to do about a column of f in 1/sr, by its title.
pub(crate) fn remedy_for_brdf(titles: &str) -> Option<&'static str> {
    let mut words = titles.split(|c: char| !c.is_ascii_alphanumeric());
    let is_brdf = |word: &str| {
        ["brdf", "btdf", "bsdf", "f"]
            .iter()
            .any(|known| word.eq_ignore_ascii_case(known))
    };
    words.any(is_brdf).then_some(
        "a BRDF or BTDF f, in 1/sr, is read as the brightness factor beta = pi f: multiply it by pi and name it beta",
    )
}
