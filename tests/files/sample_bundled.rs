//! Built-in samples whose readings are goniometric files: the instrument's mask, patches, one channel.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use specval::colour::Convention;
use specval::fit::{Channel, FitReadings};
use specval::goniometric::{Scatter, Side};
use specval::sample::{Chosen, RawReading, Sample, SampleError, SampleKind, SampleNotice};

const FELTS: [&str; 2] = ["rgl-acrylic-felt-pink", "rgl-acrylic-felt-green"];

/// Places in the pink felt's file, which has 8 incidences of 32 x 32 nodes: the mask's bits, and the values in the order
/// incidence, channel, row, column.
const VALID: usize = 657_912;
const RGB: usize = 559_600;

fn pink() -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("measurements");
    fs::read(root.join("rgl-acrylic-felt-pink/acrylic_felt_pink_rgb.bsdf")).unwrap()
}

/// β of red by geometry, angles as bits, of a file of the felt.
fn readings(bytes: &[u8]) -> BTreeMap<[u64; 2], f64> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("felt.bsdf");
    fs::write(&path, bytes).unwrap();
    let sample = Sample::load(path.to_str().unwrap()).unwrap();
    let of = |reading: RawReading| {
        let geometry = [reading.theta_i_deg, reading.theta_v_deg].map(f64::to_bits);
        (geometry, reading.beta[0])
    };
    sample.raw().map(of).collect()
}

#[test]
fn felts_are_measured_isotropic_and_say_what_was_not_seen() {
    for (name, unseen) in FELTS.into_iter().zip([1125, 1016]) {
        let sample = Sample::load(name).unwrap();
        assert_eq!(
            (sample.name(), sample.description().kind),
            (name, Some(SampleKind::Measured))
        );
        assert_eq!(
            (sample.description().licence.as_str(), sample.is_isotropic()),
            ("CC0-1.0", Some(true))
        );
        let of_file = format!("did not see {unseen} of 8192 nodes");
        let words: Vec<String> = sample.notices().iter().map(ToString::to_string).collect();
        assert!(words.iter().any(|words| words.contains(&of_file)), "{words:?}");
        let [count, of] = sample
            .notices()
            .iter()
            .find_map(|notice| match notice {
                SampleNotice::NotSeen { count, of } => Some([*count, *of]),
                _ => None,
            })
            .unwrap();
        assert_eq!(of - count, sample.geometries().count());
        // The rig of the preprint is measured as a whole, the horizon not at all.
        for theta_i in [0.0, 30.0, 60.0] {
            assert!((-12..=14).all(|k| sample.covers(theta_i, 5.0 * f64::from(k))));
        }
        assert!(sample.geometries().all(|(theta_i, _)| theta_i < 89.0));
        assert!(!sample.covers(85.0, 0.0));
    }
}

#[test]
fn a_reading_is_left_out_where_it_depends_on_a_node_that_was_not_seen() {
    let mut all_seen = pink();
    all_seen[VALID..VALID + 1024].fill(0xff);
    let before = readings(&all_seen);
    // Incidence, row, column; rows 0 and 16 are near the plane of incidence.
    let mut in_all = 0;
    let columns = (2..32)
        .step_by(5)
        .flat_map(|column| [[0, 16, column], [2, 15, column], [4, 0, column]]);
    for [slice, row, column] in columns {
        let node = row * 32 + column;
        let mut masked = all_seen.clone();
        masked[VALID + (slice * 1024 + node) / 8] ^= 0x80 >> (node % 8);
        let mut changed = all_seen.clone();
        for channel in 0..3 {
            let at = RGB + 4 * ((slice * 3 + channel) * 1024 + node);
            let value = f32::from_le_bytes(changed[at..at + 4].try_into().unwrap());
            changed[at..at + 4].copy_from_slice(&(1.5 * value).to_le_bytes());
        }
        let (masked, changed) = (readings(&masked), readings(&changed));
        let lost: Vec<_> = before
            .keys()
            .filter(|geometry| !masked.contains_key(*geometry))
            .collect();
        // Angles of incidence are rounded to 1e-9 degrees, which lends the next slice less than this.
        let depends = |(geometry, beta): &(&[u64; 2], &f64)| (changed[*geometry] / *beta - 1.0).abs() > 1e-7;
        let depend: Vec<_> = before.iter().filter(depends).map(|(geometry, _)| geometry).collect();
        in_all += lost.len();
        assert_eq!(lost, depend, "{slice} {node}");
    }
    assert!((5..before.len()).contains(&in_all), "{in_all}");
    let mut none_seen = pink();
    none_seen[VALID..VALID + 1024].fill(0);
    assert!(readings(&none_seen).is_empty());
}

#[test]
fn the_woven_screen_has_luminance_of_patches_on_both_sides() {
    let xml =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("measurements/mecho-6216/klems_aniso_high.xml"));
    let xml = xml.unwrap();
    // WINDOW's back is the front here; the first patch is the normal's own.
    for (direction, scatter, side) in [
        ("Reflection Back", Scatter::Reflection, Side::Front),
        ("Reflection Front", Scatter::Reflection, Side::Back),
        ("Transmission Back", Scatter::Transmission, Side::Front),
        ("Transmission Front", Scatter::Transmission, Side::Back),
    ] {
        let (_, block) = xml
            .split_once(&format!("<WavelengthDataDirection>{direction}<"))
            .unwrap();
        let (_, block) = block.split_once("<ScatteringData>").unwrap();
        let first: f64 = block
            .split([',', ' ', '\n', '\t'])
            .find_map(|word| word.parse().ok())
            .unwrap();
        let chosen = Chosen {
            scatter: Some(scatter),
            side: Some(side),
        };
        let sample = Sample::load_chosen("mecho-6216", chosen).unwrap();
        assert!(sample.is_luminance() && sample.is_isotropic() == Some(false));
        assert_eq!(sample.is_transmission(), scatter == Scatter::Transmission);
        let reading = sample.reading(0.0, 0.0, &Convention::default()).unwrap().unwrap();
        for beta in reading.beta {
            assert!((beta - PI * first).abs() <= 1e-12 * beta, "{direction}: {beta}");
        }
        // The four channels are one reading.
        assert_eq!(reading.covariance, [[(0.05 * reading.beta[0]).powi(2); 4]; 4]);
        let notices = sample.notices();
        assert!(
            notices.contains(&SampleNotice::PatchMeans { patches: [145, 145] }),
            "{notices:?}"
        );
        assert!(notices.contains(&SampleNotice::LuminanceAlone), "{notices:?}");
    }
}

#[test]
fn a_folder_names_its_file_of_readings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let describe = |data: &str| {
        let text = "name = \"mine\"\nsource = \"my rig\"\nlicence = \"CC0\"\nkind = \"measured\"\n".to_owned();
        fs::write(folder.path().join("sample.toml"), text + data).unwrap();
    };
    describe("data = \"felt.bsdf\"\nrelative_standard_uncertainty = 0.1\n");
    match Sample::load(path) {
        Err(SampleError::Incomplete { missing, .. }) => assert_eq!(missing, "felt.bsdf"),
        other => panic!("{other:?}"),
    }
    fs::write(folder.path().join("felt.bsdf"), pink()).unwrap();
    let sample = Sample::load(path).unwrap();
    assert_eq!(sample.digest(), Sample::load(FELTS[0]).unwrap().digest());
    // A file without azimuths of incidence is isotropic by its format.
    assert_eq!(sample.is_isotropic(), Some(true));
    let reading = sample.reading(30.0, 10.0, &Convention::default()).unwrap().unwrap();
    assert!((reading.se()[0] - 0.1 * reading.beta[0]).abs() < 1e-12);
    for elsewhere in ["../felt.bsdf", "/felt.bsdf", "", ".."] {
        describe(&format!("data = \"{elsewhere}\"\n"));
        let message = Sample::load(path).unwrap_err().to_string();
        assert!(message.contains("in the same folder"), "{elsewhere}: {message}");
    }
    // One channel is luminance only where the description says so.
    let mono = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats/dir_iso_bw.ddr");
    fs::copy(mono, folder.path().join("grey.ddr")).unwrap();
    describe("data = \"grey.ddr\"\n");
    let message = Sample::load(path).unwrap_err().to_string();
    assert!(message.contains("channel = \"luminance\""), "{message}");
    describe("data = \"grey.ddr\"\nchannel = \"luminance\"\n");
    assert!(Sample::load(path).unwrap().is_luminance());
    describe("data = \"grey.ddr\"\nchannel = \"brightness\"\n");
    assert!(matches!(Sample::load(path), Err(SampleError::Description { .. })));
}

#[test]
fn fits_read_luminance_as_one_channel() {
    let sample = Sample::load("mecho-6216").unwrap();
    let readings = FitReadings::new(&sample, &Convention::default()).unwrap();
    assert_eq!(readings.channels, [Channel::Luminance]);
    assert_eq!(readings.beta.ncols(), 1);
    assert_eq!(readings.rgby_of(&[0.25]), Some([0.25; 4]));
}
