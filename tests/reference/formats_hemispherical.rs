//! Hemispherical values in the parameters of the file, values at poles and at the horizon, and what a writer keeps of
//! them.

use std::f64::consts::{FRAC_1_PI, PI};

use specval::formats::{ChannelSet, Format, Goniometric, ReadOptions, WriteOptions, direction, parse, write};
use specval::geometry::Vec3;

use crate::golden::load;

fn degrees(theta: f64, phi: f64) -> Vec3 {
    direction(theta.to_radians(), phi.to_radians())
}

fn bsdf(data: &Goniometric, omega_in: &Vec3, omega_out: &Vec3) -> f64 {
    data.eval(omega_in, omega_out).unwrap().bsdf().unwrap()[0]
}

fn text(name: &str, text: &str) -> Goniometric {
    parse(name, text.as_bytes(), &ReadOptions::default()).unwrap()
}

/// Reflectance of the first component and the estimated error of its integration.
fn reflectance(data: &Goniometric, theta_deg: f64, phi_deg: f64) -> (f64, f64) {
    let found = data.components[0].directional_hemispherical(theta_deg.to_radians(), phi_deg.to_radians());
    let found = found.unwrap();
    (found.values[0], found.errors[0])
}

/// A narrow lobe: libbsdf's reflectance by fine quadrature, and the same table as multiples of it.
#[test]
fn narrow_lobes_are_integrated_at_their_nodes() {
    let (found, error) = reflectance(&load("absolute_narrow.ddr"), 0.0, 0.0);
    println!("{found} ± {error}");
    assert!(
        (found / 0.04205 - 1.0).abs() < 0.002 && error < 1e-3 * found,
        "{found} ± {error}"
    );
    let relative = load("relative_narrow.ddr");
    for (theta, expected) in [(0.0, 31.83), (60.0, 283.8)] {
        let found = bsdf(&relative, &degrees(theta, 0.0), &degrees(theta, 180.0));
        println!("f({theta}) {found}");
        assert!((found / expected - 1.0).abs() < 0.01, "{theta}: {found}");
    }
}

/// Of a tensor tree at normal incidence, where the unused half of its first axis begins; and Klems' half basis.
#[test]
fn radiance_files_have_the_values_of_radiance() {
    let normal = Vec3::z();
    let tree = load("ttree3_small.xml");
    // The function is 0.26 there, its leaves around are 0.2476, 0.2527, 0.2557 and 0.2608. Radiance takes one of them
    // by the signs of zeros: 0.2476 at the normal itself, 0.2557 or 0.2527 at 1e-6 degrees from it; here it is the mean
    // over azimuths.
    let found = bsdf(&tree, &normal, &normal);
    assert!((found - 0.2542).abs() < 1e-4, "{found}");
    // Sums over leaves are those over directions, here by an even rule of 200 × 400 points.
    for theta in [0.0, 40.0, 80.0] {
        let omega_in = degrees(theta, 30.0);
        let mut sum = 0.0;
        for (ring, sector) in (0..200).flat_map(|r| (0..400).map(move |s| (r, s))) {
            let sin = ((f64::from(ring) + 0.5) / 200.0).sqrt();
            let out = direction(sin.asin(), (f64::from(sector) + 0.5) / 400.0 * 2.0 * PI);
            sum += PI / 80_000.0 * bsdf(&tree, &omega_in, &out);
        }
        let (found, error) = reflectance(&tree, theta, 30.0);
        assert!(
            (found / sum - 1.0).abs() < 1e-3 && error == 0.0,
            "{theta}: {found} {sum}"
        );
    }
    let half = load("klems_half_bsdf2klems.xml");
    // Summed from the numbers of the file, of the first column and of that of the patch at 26 degrees, azimuth 90.
    for (theta, expected) in [(0.0, 0.441278057), (26.0, 0.441190034)] {
        let (found, error) = reflectance(&half, theta, 270.0);
        assert!((found - expected).abs() < 1e-8 && error == 0.0, "{theta}: {found}");
    }
    assert!((bsdf(&half, &normal, &normal) - 0.2901).abs() < 1e-9);
}

/// A basis is as the file's blocks say, whatever its name; without blocks it is the one of that name.
#[test]
fn blocks_of_a_file_decide_on_its_basis() {
    let file = |blocks: &str, values: usize| {
        format!(
            "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure>{blocks}</DataDefinition><WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Reflection Back</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis><ScatteringData>{}</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>",
            "0.1,".repeat(values)
        )
    };
    let block = |low: f64, high: f64, n: usize| {
        format!(
            "<AngleBasisBlock><nPhis>{n}</nPhis><ThetaBounds><LowerTheta>{low}</LowerTheta><UpperTheta>{high}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        )
    };
    let own = format!(
        "<AngleBasis><AngleBasisName>LBNL/Klems Quarter</AngleBasisName>{}{}</AngleBasis>",
        block(0.0, 20.0, 1),
        block(20.0, 90.0, 2)
    );
    for file in [file(&own, 9), file("", 41 * 41)] {
        let (found, _) = reflectance(&text("x.xml", &file), 30.0, 0.0);
        assert!((found - 0.1 * PI).abs() < 1e-12, "{found}");
    }
    assert!(parse("x.xml", file(&own, 41 * 41).as_bytes(), &ReadOptions::default()).is_err());
}

/// f cos θ of f = 0.3: f between the nodes and at the horizon, where the cosine is 0.
#[test]
fn intensity_tables_are_interpolated_as_f() {
    let data = load("intensity_horizon.ddr");
    for (theta_i, theta_o, phi) in [
        (0.0, 75.0, 10.0),
        (0.0, 89.9, 0.0),
        (0.0, 90.0, 0.0),
        (15.0, 45.0, 180.0),
        (30.0, 89.0, 180.0),
    ] {
        let found = bsdf(&data, &degrees(theta_i, 0.0), &degrees(theta_o, phi));
        assert!((found - 0.3).abs() < 1e-6, "{theta_i} {theta_o}: {found}");
    }
    for theta in [0.0f64, 30.0] {
        let found = data.components[0]
            .directional_hemispherical(theta.to_radians(), 0.0)
            .unwrap();
        assert!((found.values[0] - 0.3 * PI * found.measured).abs() < 1e-4, "{found:?}");
    }
    assert!(
        data.warnings.iter().any(|w| w.to_string().contains("horizon")),
        "{:?}",
        data.warnings
    );
}

/// At a pole, which is one direction, the value is the mean over the azimuths, whatever azimuth rounding gives.
#[test]
fn poles_have_one_value() {
    let ddr = "Source Measured\nTypeSym ASymmetrical\nTypeColorModel BW\nTypeData Luminance Absolute\nsigma 2\n 0 \
               60\nphi 5\n 0 90 180 270 360\ntheta 2\n 0 180\nbw\n kbdf\n 1 1\n def\n1 1\n2 1\n3 1\n4 1\n1 1\n1 1\n2 \
               1\n3 1\n4 1\n1 1\nenddef\n";
    let ssdd = "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE \
                spherical_coordinate_system\nPARAM0_LIST 0 60\nPARAM1_LIST 0 90 180 270 360\nPARAM2_LIST 0 \
                90\nPARAM3_LIST 0 360\nDATA ascii\n";
    // Incident polar angle fastest, then its azimuth: 1, 2, 3, 4, 1 at the normal.
    let rows = "1\n0\n2\n0\n3\n0\n4\n0\n1\n0\n".repeat(4);
    let csv = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta\n0,0,0,0,1\n0,0,0,90,2\n0,0,0,180,3\n0,0,0,270,4\n0,0,60,0,1\n0,0,60,90,1\n0,0,60,180,1\n0,0,60,270,1\n";
    for (data, scale) in [
        (text("x.ddr", ddr), FRAC_1_PI),
        (text("x.ssdd", &format!("{ssdd}{rows}")), 1.0),
        (text("x.csv", csv), FRAC_1_PI),
    ] {
        for (theta_i, phi) in [(0.0, 0.0), (1e-12, 200.0)] {
            for theta_o in [0.0, 1e-12] {
                let found = bsdf(&data, &degrees(theta_i, phi), &degrees(theta_o, phi + 77.0));
                assert!(
                    (found - 2.5 * scale).abs() < 1e-9,
                    "{:?} {theta_i} {phi}: {found}",
                    data.format
                );
            }
        }
    }
    assert!(
        text("x.ddr", ddr)
            .warnings
            .iter()
            .any(|w| w.to_string().contains("pole"))
    );
}

/// f of GGX with Smith's G2 and a Fresnel factor that is constant, light at azimuth 0.
fn ggx(alpha: f64, fresnel: f64, i: &Vec3, o: &Vec3) -> f64 {
    if i.z <= 0.0 || o.z <= 0.0 {
        return 0.0;
    }
    let smith = |c: f64| ((1.0 + alpha * alpha * (1.0 - c * c) / (c * c)).sqrt() - 1.0) / 2.0;
    let cos = (i + o).normalize().z;
    let d = alpha * alpha / (PI * (cos * cos * (alpha * alpha - 1.0) + 1.0).powi(2));
    fresnel * d / ((1.0 + smith(i.z) + smith(o.z)) * 4.0 * i.z * o.z)
}

/// ∫ f cos θ dω of a lobe like GGX by a midpoint rule over slopes of facets, even in the share of their distribution.
fn over_facets(alpha: f64, theta_deg: f64, f: impl Fn(&Vec3, &Vec3) -> f64) -> f64 {
    let (rings, sectors) = (2000, 180);
    let i = degrees(theta_deg, 0.0);
    let mut sum = 0.0;
    for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
        let u = (f64::from(ring) + 0.5) / f64::from(rings);
        let theta = (alpha * (u / (1.0 - u)).sqrt()).atan();
        let h = direction(theta, (f64::from(sector) + 0.5) / f64::from(sectors) * 2.0 * PI);
        let o = h * (2.0 * h.dot(&i)) - i;
        if h.dot(&i) > 0.0 && o.z > 0.0 {
            let d = alpha * alpha / (PI * (h.z * h.z * (alpha * alpha - 1.0) + 1.0).powi(2));
            // Of D cos θ_h dω_h each point has the same share.
            let per_facet = 4.0 * h.dot(&i) / (d * h.z);
            sum += f(&i, &o) * o.z * per_facet / f64::from(rings * sectors);
        }
    }
    sum
}

/// A lobe over half and difference vector, nodes closer at its top.
fn half_difference(alpha: f64, fresnel: f64) -> Goniometric {
    let words = |list: &[f64]| list.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let theta_h: Vec<f64> = (0..=60).map(|k| f64::from(k * k) / 40.0).collect();
    let theta_d: Vec<f64> = (0..=30).map(|k| 3.0 * f64::from(k)).collect();
    let phi_d: Vec<f64> = (0..=24).map(|k| 15.0 * f64::from(k)).collect();
    let mut file = format!(
        "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE \
         half_difference_coordinate_system\nPARAM0_LIST {}\nPARAM2_LIST {}\nPARAM3_LIST {}\nDATA ascii\n",
        words(&theta_h),
        words(&theta_d),
        words(&phi_d)
    );
    for phi in &phi_d {
        for theta in &theta_d {
            for h in &theta_h {
                let half = degrees(*h, 0.0);
                let d = degrees(*theta, *phi);
                let (sin, cos) = h.to_radians().sin_cos();
                let i = Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x);
                file += &format!("{}\n", ggx(alpha, fresnel, &i, &(half * (2.0 * half.dot(&i)) - i)));
            }
        }
    }
    text("x.ssdd", &file)
}

/// Narrow lobes of other parametrisations: the integral of the table by another rule, and of the function it was made
/// from, from which a table of few nodes departs.
#[test]
fn lobes_behind_a_warp_and_over_half_vectors_are_integrated() {
    for (data, alpha, fresnel, departs) in [
        (load("rgl_metal_rgb.bsdf"), 0.08, 0.9, 0.02),
        (half_difference(0.05, 0.6), 0.05, 0.6, 0.02),
    ] {
        for theta in [0.0, 30.0, 60.0] {
            let (found, error) = reflectance(&data, theta, 50.0);
            let table = over_facets(alpha, theta, |i, o| bsdf(&data, i, o));
            let function = over_facets(alpha, theta, |i, o| ggx(alpha, fresnel, i, o));
            println!("{} {theta}: {found} ± {error}, {table}, {function}", data.format);
            assert!((found / table - 1.0).abs() < 1e-3, "{theta}: {found} for {table}");
            assert!(
                (found / function - 1.0).abs() < departs,
                "{theta}: {found} for {function}"
            );
            assert!(error < 1e-3 * found);
        }
    }
}

/// Whatever format a narrow lobe is written in, its hemispherical values stay, and a notice has the largest change.
#[test]
fn resampling_keeps_hemispherical_values() {
    for (data, formats) in [
        (
            load("absolute_narrow.ddr"),
            vec![Format::CSV, Format::RGL, Format::RADIANCE_XML],
        ),
        (
            load("rgl_metal_rgb.bsdf"),
            vec![
                Format::DDR,
                Format::SSDD,
                Format::ASTM,
                Format::MERL,
                Format::RADIANCE_XML,
            ],
        ),
        (
            half_difference(0.05, 0.6),
            vec![Format::DDR, Format::CSV, Format::RADIANCE_XML],
        ),
    ] {
        let data = &data;
        for format in formats {
            let written = write(data, format, &WriteOptions::default()).unwrap();
            let back = parse("x.ddr", &written.bytes, &ReadOptions::default()).unwrap();
            println!(
                "{} as {format}, {} bytes: {:?}",
                data.format,
                written.bytes.len(),
                written.notices
            );
            for theta in [0.0, 30.0, 60.0] {
                // Of RGB, Klems matrices have XYZ.
                if format == Format::RADIANCE_XML && data.components[0].channels != ChannelSet::Monochrome {
                    continue;
                }
                // Patches hold the mean over their ring of incidences, of 4 directions.
                let ring: Vec<f64> = match (format, theta) {
                    (Format::RADIANCE_XML, 0.0) => [0.0, 5.0].to_vec(),
                    (Format::RADIANCE_XML, _) => [theta - 5.0, theta + 5.0].to_vec(),
                    _ => vec![theta],
                };
                let sin2 = |deg: f64| deg.to_radians().sin().powi(2);
                let (low, high) = (sin2(ring[0]), sin2(ring[ring.len() - 1]));
                let shares = (0..16).map(|k| (f64::from(k) + 0.5) / 16.0);
                let incidences = shares.map(|t| (low + t * (high - low)).sqrt().asin().to_degrees());
                let before = incidences.map(|t| reflectance(data, t, 0.0).0).sum::<f64>() / 16.0;
                let (after, _) = reflectance(&back, theta, 0.0);
                println!("  {theta}: {before:.5} {after:.5}");
                let tolerance = if format == Format::RADIANCE_XML { 0.02 } else { 0.003 };
                assert!(
                    (after / before - 1.0).abs() < tolerance,
                    "{} as {format}, {theta}: {before} {after}",
                    data.format
                );
            }
            assert!(
                written
                    .notices
                    .iter()
                    .map(ToString::to_string)
                    .any(|n| n.contains("hemispherical") && n.contains("integrated to within")),
                "{:?}",
                written.notices
            );
        }
    }
}
