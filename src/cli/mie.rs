use super::{Failure, Terminal};
use num_complex::Complex64;
use serde::Serialize;
use specval::number::shown;
use specval::optics::Mie;
use std::fmt::Write;

/// The relative index is m = (n_p + iκ)/n_h, particle over host; absorption is +i. The size parameter is
/// x = π d n_h/λ with the vacuum wavelength λ.
///
/// q_ext, q_sca and q_abs are cross sections over the geometric one, πd²/4. q_back = 4 |S(180°)|²/x² is the radar
/// backscattering efficiency: 4π times the differential cross section dC/dΩ at 180°, per sr, over πd²/4; of a scatterer
/// that is isotropic it is q_sca. It is not the share of light that is scattered backwards. Some programs leave the 4π
/// out: their value is q_back/4π.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Arguments {
    /// Real part of the relative refractive index, > 0.
    #[arg(long, required_unless_present = "conducting")]
    m_re: Option<f64>,
    /// Imaginary part of the relative refractive index, >= 0.
    #[arg(long, default_value_t = 0.0)]
    m_im: f64,
    /// Size parameter, 1e-6 to 1e5.
    #[arg(long)]
    x: f64,
    /// A perfectly conducting sphere instead of an index.
    #[arg(long, conflicts_with_all = ["m_re", "m_im"])]
    conducting: bool,
    /// Scattering angles in degrees, 0 to 180, separated by commas.
    #[arg(long, value_name = "DEG,DEG", value_delimiter = ',', default_values_t = [0.0, 90.0, 180.0], value_parser = angle)]
    angles: Vec<f64>,
}

/// Efficiencies as the command's help defines them; amplitudes are those of Bohren and Huffman (1983), 4.74.
#[derive(Serialize)]
struct Sphere {
    q_ext: f64,
    q_sca: f64,
    q_abs: f64,
    q_back: f64,
    g: f64,
    angles_deg: Vec<f64>,
    s1: Vec<Complex64>,
    s2: Vec<Complex64>,
}

pub fn run(arguments: &Arguments, terminal: &Terminal) -> Result<(), Failure> {
    let mie = match arguments.m_re {
        Some(m_re) => Mie::sphere(Complex64::new(m_re, arguments.m_im), arguments.x)?,
        None => Mie::conducting(arguments.x)?,
    };
    let efficiencies = mie.efficiencies();
    let (s1, s2) = arguments
        .angles
        .iter()
        .map(|&angle_deg| mie.amplitudes(cosine(angle_deg)))
        .unzip();
    let sphere = Sphere {
        q_ext: efficiencies.q_ext,
        q_sca: efficiencies.q_sca,
        q_abs: efficiencies.q_abs,
        q_back: efficiencies.q_back,
        g: efficiencies.g,
        angles_deg: arguments.angles.clone(),
        s1,
        s2,
    };
    terminal.result(&sphere, text)
}

/// Exact at 90°, where the cosine of the rounded angle in radians is 6e-17.
fn cosine(angle_deg: f64) -> f64 {
    if angle_deg == 90.0 {
        0.0
    } else {
        angle_deg.to_radians().cos()
    }
}

fn text(sphere: &Sphere) -> String {
    let mut text = String::new();
    for (name, value) in [
        ("q_ext", sphere.q_ext),
        ("q_sca", sphere.q_sca),
        ("q_abs", sphere.q_abs),
        ("q_back", sphere.q_back),
        ("g", sphere.g),
    ] {
        let _ = writeln!(text, "{name:<7} {}", shown(value));
    }
    let _ = writeln!(
        text,
        "\n{:>10} {:>20} {:>20} {:>20} {:>20}",
        "angle, deg", "re s1", "im s1", "re s2", "im s2"
    );
    for ((angle_deg, s1), s2) in sphere.angles_deg.iter().zip(&sphere.s1).zip(&sphere.s2) {
        let _ = writeln!(
            text,
            "{angle_deg:>10} {:>20} {:>20} {:>20} {:>20}",
            shown(s1.re),
            shown(s1.im),
            shown(s2.re),
            shown(s2.im)
        );
    }
    text
}

fn angle(typed: &str) -> Result<f64, String> {
    match typed.trim().parse() {
        Ok(angle_deg) if (0.0..=180.0).contains(&angle_deg) => Ok(angle_deg),
        _ => Err("expected a scattering angle in degrees, 0 to 180; write --angles 0,90,180".to_owned()),
    }
}
