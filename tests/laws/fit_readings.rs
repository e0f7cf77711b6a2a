//! Readings that a fit takes from a sample.

use specval::colour::Convention;
use specval::fit::{Channel, FitError, FitNotice, FitReadings};
use specval::rig::Geometry;
use specval::sample::Sample;
use std::fs;

fn readings(name_or_path: &str) -> Result<FitReadings, FitError> {
    FitReadings::new(&Sample::load(name_or_path).unwrap(), &Convention::default())
}

fn of_text(text: &str) -> FitReadings {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample.csv");
    fs::write(&path, text).unwrap();
    readings(path.to_str().unwrap()).unwrap()
}

#[test]
fn rgb_readings_are_those_of_the_file() {
    let readings = readings("merl-red-fabric").unwrap();
    assert_eq!(readings.channels, [Channel::Red, Channel::Green, Channel::Blue]);
    assert_eq!(readings.white, [1.0; 3]);
    let sample = Sample::load("merl-red-fabric").unwrap();
    assert_eq!(readings.geometries.len(), sample.raw().count());
    for (g, raw) in sample.raw().enumerate() {
        assert_eq!(readings.geometries[g].theta_v_deg, raw.theta_v_deg);
        assert_eq!(readings.beta.row(g).to_vec(), raw.beta);
        assert_eq!(readings.se.row(g).to_vec(), raw.se);
        let reading = sample.reading(raw.theta_i_deg, raw.theta_v_deg, &Convention::default());
        let expected = reading.unwrap().unwrap().beta;
        let found = readings.rgby_of(raw.beta).unwrap();
        assert!(expected.iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-15));
    }
    assert!(readings.notices.is_empty());

    let at_60 = readings.subset(|geometry| geometry.theta_i_deg == 60.0);
    assert_eq!(at_60.incidences_deg(), [60.0]);
    let others = readings.subset(|geometry| geometry.theta_i_deg != 60.0);
    assert_eq!(at_60.len() + others.len(), readings.len());
    let first = readings
        .geometries
        .iter()
        .position(|g| *g == at_60.geometries[0])
        .unwrap();
    assert_eq!(at_60.beta.row(0), readings.beta.row(first));
    assert_eq!(at_60.se.row(0), readings.se.row(first));
}

#[test]
fn readings_without_uncertainty_get_a_stated_one() {
    let readings = of_text("theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n0,0,0.6,0.02,0\n0,30,0.2,0.04,0\n");
    // 5 % of the reading and 1 % of the channel's mean, of the perfect diffuser in a channel that is 0.
    let expected = |beta: f64, mean: f64| (0.05 * beta).hypot(0.01 * mean);
    assert!((readings.se[(0, 0)] - expected(0.6, 0.4)).abs() < 1e-15);
    assert!((readings.se[(1, 1)] - expected(0.04, 0.03)).abs() < 1e-15);
    assert!((readings.se[(1, 2)] - 0.01).abs() < 1e-15);
    let [notice @ FitNotice::AssumedUncertainty { readings: 6, of: 6, .. }] = &readings.notices[..] else {
        panic!("{:?}", readings.notices)
    };
    assert!(notice.to_string().contains("5 % of the reading"), "{notice}");
}

#[test]
fn spectral_readings_keep_their_wavelengths() {
    let mut text = "theta_i_deg,theta_v_deg,wavelength_nm,beta,beta_se\n".to_owned();
    for nm in (400..=700).step_by(20) {
        text += &format!("30,0,{nm},{},0.01\n", f64::from(nm) / 1000.0);
    }
    let readings = of_text(&text);
    assert_eq!(readings.channels.len(), 16);
    assert_eq!(readings.channels[3], Channel::Wavelength(460.0));
    assert_eq!((readings.beta[(0, 3)], readings.se[(0, 3)]), (0.46, 0.01));
    // The perfect diffuser has luminance 1.
    assert!((readings.rgby_of(&[1.0; 16]).unwrap()[3] - 1.0).abs() < 1e-12);

    let laser = of_text("theta_i_deg,theta_v_deg,wavelength_nm,beta,beta_se\n0,0,633,0.5,0.01\n0,10,633,0.4,0.01\n");
    assert_eq!((laser.len(), laser.rgby), (2, None));
}

#[test]
fn tristimulus_values_become_rgb_with_the_perfect_diffusers_white() {
    let readings = of_text(
        "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta_x,beta_y,beta_z,beta_x_se,beta_y_se,beta_z_se\n\
         0,0,0,0,0.95047,1,1.08883,0.01,0.02,0.03\n0,0,30,0,0.4,0.2,0.05,0.01,0.02,0.03\n",
    );
    let normal = readings.geometries.iter().position(|g| *g == Geometry::NORMAL).unwrap();
    let sample = readings.beta.row(normal).to_vec();
    for (found, white) in sample.iter().zip(&readings.white) {
        assert!((found - white).abs() < 2e-3, "{sample:?} {:?}", readings.white);
    }
    assert!((readings.rgby_of(&sample).unwrap()[3] - 1.0).abs() < 1e-12);
    // Red of sRGB (IEC 61966-2-1): 3.2406 X - 1.5372 Y - 0.4986 Z.
    let red = (3.2406f64 * 0.01).hypot(1.5372 * 0.02).hypot(0.4986 * 0.03);
    assert!(
        (readings.se[(normal, 0)] / red - 1.0).abs() < 1e-3,
        "{}",
        readings.se[(0, 0)]
    );
}

#[test]
fn published_ratios_cannot_be_fitted() {
    let refused = readings("voloboy2008-cotton").unwrap_err().to_string();
    assert!(refused.contains("published colour ratios alone"), "{refused}");
}
