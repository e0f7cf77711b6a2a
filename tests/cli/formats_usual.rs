//! Files as people have them: other encodings, reduced azimuths, damage, and components that a format does not hold.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;

use specval::formats::{
    Encoding, Format, Goniometric, ReadOptions, Scatter, Side, WriteNotice, WriteOptions, direction, parse, write,
};
use specval::geometry::Vec3;

use crate::runs::json;

use crate::golden::{golden, load};

fn text(name: &str) -> String {
    fs::read_to_string(golden(name)).unwrap()
}

fn read(name: &str, bytes: &[u8]) -> Goniometric {
    parse(name, bytes, &ReadOptions::default()).unwrap()
}

fn refused(name: &str, bytes: &[u8]) -> String {
    let error = parse(name, bytes, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with(&*error.remedy), "{error}");
    error.to_string()
}

/// f of the component towards a direction, 1/sr.
fn f(data: &Goniometric, omega_in: &Vec3, omega_out: &Vec3) -> f64 {
    data.components[0].eval(omega_in, omega_out).unwrap().bsdf().unwrap()[0]
}

fn warned(data: &Goniometric, words: &str) -> bool {
    data.warnings.iter().any(|warning| warning.to_string().contains(words))
}

#[test]
fn text_and_xml_of_other_encodings_are_read() {
    let (omega_in, omega_out) = (direction(0.3, 0.0), direction(0.5, 1.0));
    for name in [
        "klems_full_lambert_0p1.xml",
        "dir_iso_bw.ddr",
        "dir_spherical_bw.ssdd",
        "dir_iso_rgb.astm",
    ] {
        let whole = text(name);
        let expected = f(&read(name, whole.as_bytes()), &omega_in, &omega_out);
        for bytes_of in [u16::to_le_bytes, u16::to_be_bytes] {
            let marked = format!("\u{feff}{whole}");
            let utf16: Vec<u8> = marked.encode_utf16().flat_map(bytes_of).collect();
            assert_eq!(f(&read(name, &utf16), &omega_in, &omega_out), expected, "{name}");
        }
    }
    let xml = text("klems_full_lambert_0p1.xml");
    let declaration = xml.find("?>").unwrap() + 2;
    let rest = &xml[declaration..];
    let latin = [
        b"<?xml version='1.0' encoding='ISO-8859-1'?><!-- M\xfcller -->",
        rest.as_bytes(),
    ]
    .concat();
    for bytes in [
        latin,
        format!("<?xml version='1.0'?>\n<!DOCTYPE WindowElement SYSTEM \"WindowElement.dtd\">{rest}").into_bytes(),
        rest.trim_start().as_bytes().to_vec(),
    ] {
        let data = read("x.xml", &bytes);
        assert!((f(&data, &omega_in, &omega_out) - 0.1).abs() < 1e-12);
        assert!(data.warnings.is_empty(), "{:?}", data.warnings);
    }
    // What programs print before it.
    for before in ["genBSDF: 12 % done\nwarning: no glazing\n", "\n"] {
        let data = read("x.xml", format!("{before}{xml}").as_bytes());
        assert!((f(&data, &omega_in, &omega_out) - 0.1).abs() < 1e-12);
        assert_eq!(warned(&data, "(2 lines)"), before.len() > 1, "{:?}", data.warnings);
    }
    let bad = format!("first line\n{}", xml.replacen("<Layer>", "<Layer", 1));
    let line = xml[..xml.find("<Layer>").unwrap()].lines().count() + 1;
    let told = refused("x.xml", bad.as_bytes());
    let near = (line..line + 4).any(|line| told.contains(&format!("line {line},")));
    assert!(near, "{told}, line {line}");
}

#[test]
fn what_is_no_data_is_told_what_it_is() {
    let page = "<!DOCTYPE html>\n<html><body>&lt;WindowElement&gt;</body></html>";
    assert!(refused("bsdf.xml", page.as_bytes()).contains("web page"));
    assert!(refused("a.ddr", b"<html><head><title>404</title>").contains("web page"));
    assert!(refused("a.csv", b"PK\x03\x04rest").contains("ZIP archive"));
    assert!(refused("a.bsdf", b"version https://git-lfs.github.com/spec/v1\n").contains("Git LFS"));
    let entities = format!(
        "<?xml version='1.0'?><!DOCTYPE WindowElement [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>{}",
        &text("klems_full_lambert_0p1.xml").split_once("?>").unwrap().1
    );
    assert!(refused("x.xml", entities.as_bytes()).contains("ENTITY"));
    assert!(refused("x.xml", b"<?xml version='1.0'?><svg></svg>").contains("XML of another kind"));
}

/// The value of each 32-bit or 64-bit number changed.
fn changed<const N: usize>(bytes: &[u8], change: fn(&mut [u8])) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.chunks_exact_mut(N).for_each(change);
    bytes
}

#[test]
fn damaged_binaries_are_told() {
    let reverse: fn(&mut [u8]) = |word| word.reverse();
    let negate: fn(&mut [u8]) = |word| word[word.len() - 1] ^= 0x80;
    let ssdd = fs::read(golden("dir_specular_spectral7_binary.ssdd")).unwrap();
    let data = ssdd.windows(12).position(|w| w == b"DATA binary\n").unwrap() + 12;
    let end = data + (ssdd.len() - data) / 4 * 4;
    let with = |change| [&ssdd[..data], &changed::<4>(&ssdd[data..end], change), &ssdd[end..]].concat();
    assert!(refused("x.ssdd", &with(reverse)).contains("reversed order"));
    assert!(refused("x.ssdd", &with(negate)).contains("0 or more"));
    assert!(refused("x.ssdd", &[&ssdd[..], &[0; 8]].concat()).contains("bytes behind the last block"));

    let utia: Vec<u8> = (0..1_990_656 / 8)
        .flat_map(|i| (0.1 + 0.37 * f64::from(i % 7)).to_le_bytes())
        .collect();
    assert_eq!(read("x.bin", &utia).format, Format::UTIA);
    assert!(refused("x.bin", &changed::<8>(&utia, reverse)).contains("reversed order"));
    assert!(refused("x.bin", &changed::<8>(&utia, negate)).contains("none above 0"));

    let merl: Vec<u8> = [90u32, 90, 180].iter().flat_map(|n| n.to_be_bytes()).collect();
    assert!(refused("x.binary", &merl).contains("big-endian"));

    let rgl = fs::read(golden("rgl_warped_rgb.bsdf")).unwrap();
    let longer = read("x.bsdf", &[&rgl[..], &[7; 100]].concat());
    assert!(warned(&longer, "behind the last array"), "{:?}", longer.warnings);
    assert!(!warned(&read("x.bsdf", &rgl), "behind the last array"));
}

#[test]
fn colours_outside_the_rgb_space_are_read() {
    let data = load("rgl_negative_rgb.bsdf");
    assert!(
        warned(&data, "check the sign") && warned(&data, "down to -0.1"),
        "{:?}",
        data.warnings
    );
    assert_eq!(f(&data, &direction(0.2, 0.0), &direction(0.4, 1.0)), 0.0);
}

/// A tensor file without a warp of a function of the directions, at these azimuths of incidence.
fn tensors(phi_i: &[f64], of: impl Fn(&Vec3, &Vec3) -> f64) -> Vec<u8> {
    const N: usize = 33;
    let theta_i = [0.0, 0.4, 0.8, 1.2];
    let slices = phi_i.len() * theta_i.len();
    let mut rgb = Vec::new();
    for (phi, theta) in phi_i
        .iter()
        .flat_map(|phi| theta_i.iter().map(move |theta| (*phi, *theta)))
    {
        let square = (0..N * N).map(|node| {
            let (y, x) = ((node / N) as f64 / (N - 1) as f64, (node % N) as f64 / (N - 1) as f64);
            let (omega_in, half) = (direction(theta, phi), direction(x * x * FRAC_PI_2, y * TAU - PI));
            let omega_out = half * (2.0 * half.dot(&omega_in)) - omega_in;
            of(&omega_in, &omega_out) * omega_out.z
        });
        let square: Vec<f64> = square.collect();
        (0..3).for_each(|_| rgb.extend_from_slice(&square));
    }
    let (p, t, n) = (phi_i.len(), theta_i.len(), N);
    let fields: [(&str, u8, Vec<usize>, Vec<f64>); 9] = [
        ("description", 1, vec![1], vec![32.0]),
        ("jacobian", 1, vec![1], vec![1.0]),
        ("phi_i", 10, vec![p], phi_i.to_vec()),
        ("theta_i", 10, vec![t], theta_i.to_vec()),
        ("ndf", 10, vec![2, 2], vec![1.0; 4]),
        ("sigma", 10, vec![2, 2], vec![0.25; 4]),
        ("vndf", 10, vec![p, t, 2, 2], vec![1.0; 4 * slices]),
        ("luminance", 10, vec![p, t, n, n], vec![1.0; slices * n * n]),
        ("rgb", 10, vec![p, t, 3, n, n], rgb),
    ];
    let head: usize = fields
        .iter()
        .map(|(name, _, shape, _)| 13 + name.len() + 8 * shape.len())
        .sum();
    let mut file = [b"tensor_file\0\x01\0".as_slice(), &9u32.to_le_bytes()].concat();
    let mut content = Vec::new();
    for (name, kind, shape, values) in &fields {
        file.extend((name.len() as u16).to_le_bytes());
        file.extend(name.as_bytes());
        file.extend((shape.len() as u16).to_le_bytes());
        file.push(*kind);
        file.extend(((18 + head + content.len()) as u64).to_le_bytes());
        shape.iter().for_each(|n| file.extend((*n as u64).to_le_bytes()));
        for value in values {
            match kind {
                1 => content.push(*value as u8),
                _ => content.extend((*value as f32).to_le_bytes()),
            }
        }
    }
    file.extend(content);
    file
}

/// Half and a quarter of the azimuths say the same as all of them, of materials with the symmetry.
#[test]
fn reduced_azimuths_of_tensor_files_are_unfolded() {
    let azimuths = |count: usize| -> Vec<f64> { (0..count).map(|i| f64::from(i as u32) / 8.0 * PI - PI).collect() };
    let mirrored = |i: &Vec3, o: &Vec3| 0.2 + 0.1 * (i.x * i.x - i.y * i.y) + 0.05 * o.y * o.y + 0.04 * i.x * o.x;
    let turned = move |i: &Vec3, o: &Vec3| mirrored(i, o) + 0.06 * o.x * o.y + 0.03 * i.x * o.y;
    for (reduction, whole, part) in [
        (2, tensors(&azimuths(17), turned), tensors(&azimuths(9), turned)),
        (4, tensors(&azimuths(17), mirrored), tensors(&azimuths(5), mirrored)),
    ] {
        let (whole, part) = (read("whole.bsdf", &whole), read("part.bsdf", &part));
        assert!(warned(&part, "as Mitsuba does") && !warned(&whole, "as Mitsuba does"));
        for k in 0..60 {
            let k = f64::from(k);
            let (omega_in, omega_out) = (direction(0.02 * k, 0.7 * k), direction(1.3 - 0.015 * k, 2.3 * k));
            let expected = f(&whole, &omega_in, &omega_out);
            let found = f(&part, &omega_in, &omega_out);
            assert!(
                (found - expected).abs() < 2e-6,
                "{reduction}, {k}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn azimuths_a_turn_apart_are_one_direction() {
    let head = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,beta\n30,0,30,0,0.3\n30,0,30,90,0.3\n30,0,30,180,0.3\n30,0,30,270,0.3\n";
    assert!(refused("a.csv", format!("{head}30,0,30,360,0.9\n").as_bytes()).contains("line 6"));
    assert!(refused("a.csv", format!("{head}30,0,30,-90,0.9\n").as_bytes()).contains("360 degrees apart"));
    let same = read("a.csv", format!("{head}30,0,30,360,0.3\n").as_bytes());
    assert!(
        (f(
            &same,
            &direction(30f64.to_radians(), 0.0),
            &direction(30f64.to_radians(), 6.0)
        ) - 0.3 / PI)
            .abs()
            < 1e-12
    );
    let table = "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE \
                 spherical_coordinate_system\nPARAM0_LIST 0 80\nPARAM2_LIST 10 80\nPARAM3_LIST 0 180 360\nDATA \
                 ascii\n1\n1\n1\n1\n1\n1\n1\n1\n2\n1\n1\n1\n";
    assert!(warned(&read("a.ssdd", table.as_bytes()), "differ by up to 50.0 %"));
}

/// libbsdf holds the last azimuth up to 360 degrees; files that are written close the circle.
#[test]
fn written_azimuths_close_at_360() {
    let values: Vec<String> = (0..2 * 4 * 2 * 4)
        .map(|i| format!("{}", 0.1 + f64::from(i) / 100.0))
        .collect();
    for (kind, offset) in [("spherical", 0), ("specular", 0), ("spherical", 45)] {
        let list: Vec<String> = (0..4).map(|i| (offset + 90 * i).to_string()).collect();
        let list = list.join(" ");
        let source = format!(
            "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE {kind}_coordinate_system\nPARAM0_LIST 10 \
             80\nPARAM1_LIST {list}\nPARAM2_LIST 10 80\nPARAM3_LIST {list}\nDATA ascii\n{}\n",
            values.join("\n")
        );
        let source = read("open.ssdd", source.as_bytes());
        let mut options = WriteOptions::default();
        for (format, encoding) in [
            (Format::SSDD, Encoding::Text),
            (Format::SSDD, Encoding::Binary),
            (Format::DDR, Encoding::Text),
        ] {
            if kind == "spherical" && format == Format::DDR {
                continue;
            }
            options.encoding = encoding;
            let bytes = write(&source, format, &options).unwrap().bytes;
            let head = String::from_utf8_lossy(&bytes[..400]).into_owned();
            let lists: Vec<&str> = head.lines().filter(|line| line.trim_end().ends_with(" 360")).collect();
            assert_eq!(lists.len(), 2, "{head}");
            let back = read("closed.ddr", &bytes);
            for k in 0..40 {
                let k = f64::from(k);
                let omega_in = direction(0.2 + 0.02 * k, 0.9 * k);
                let omega_out = direction(1.0, 2.1 * k);
                let Some(expected) = source.eval(&omega_in, &omega_out) else {
                    continue;
                };
                let found = f(&back, &omega_in, &omega_out);
                assert!(
                    (found - expected.bsdf().unwrap()[0]).abs() < 1e-6,
                    "{kind} {format} {k}"
                );
            }
        }
    }
    let fractions = "VERSION 0.3\nDATA_TYPE specular_reflectance\nCOLOR_MODEL monochrome\nPARAM0_LIST 0 \
                     80\nPARAM1_LIST 0 180\nDATA ascii\n0.1\n0.2\n0.3\n0.4\n";
    let bytes = write(
        &read("x.ssdd", fractions.as_bytes()),
        Format::SSDD,
        &WriteOptions::default(),
    );
    let written = String::from_utf8(bytes.unwrap().bytes).unwrap();
    assert!(
        written.contains("PARAM1_LIST 0 180 360\nDATA ascii\n0.1\n0.2\n0.3\n0.4\n0.1\n0.2\n"),
        "{written}"
    );
}

/// A file whose first component is transmission, and one that has its light on the back alone.
fn xml(directions: &[(&str, &str)]) -> String {
    let whole = text("klems_full_lambert_0p1.xml");
    let (from, to) = (
        whole.find("<WavelengthData>").unwrap(),
        whole.rfind("</Layer>").unwrap(),
    );
    let block = &whole[from..to];
    let all = directions.iter().map(|(direction, value)| {
        let block = block.replace("Reflection Back", direction);
        block.replace("0.1,", &format!("{value},"))
    });
    format!("{}{}{}", &whole[..from], all.collect::<String>(), &whole[to..])
}

#[test]
fn components_are_chosen_and_named() {
    let both = read(
        "x.xml",
        xml(&[("Transmission Back", "0.02"), ("Reflection Back", "0.1")]).as_bytes(),
    );
    for format in [Format::CSV, Format::ASTM] {
        let written = write(&both, format, &WriteOptions::default()).unwrap();
        assert_eq!(written.components, ["reflection of light from the front"], "{format}");
        assert!(
            written
                .notices
                .iter()
                .any(|n| n.to_string().ends_with("transmission of light from the front"))
        );
    }
    let transmission = WriteOptions {
        scatter: Some(Scatter::Transmission),
        ..WriteOptions::default()
    };
    let written = write(&both, Format::CSV, &transmission).unwrap();
    assert_eq!(written.components, ["transmission of light from the front"]);
    let down = direction(2.5, 0.5);
    assert!((f(&read("x.csv", &written.bytes), &direction(0.1, 0.0), &down) - 0.02).abs() < 1e-6);
    assert!(write(&both, Format::RGL, &transmission).is_err());
    assert_eq!(
        write(&both, Format::SSDD, &WriteOptions::default())
            .unwrap()
            .components
            .len(),
        2
    );

    // The back is never turned into the front unasked.
    let back = read("x.xml", xml(&[("Reflection Front", "0.1")]).as_bytes());
    for format in [Format::CSV, Format::ASTM, Format::DDR, Format::RGL, Format::SSDD] {
        let told = write(&back, format, &WriteOptions::default()).unwrap_err().to_string();
        assert!(
            told.contains("from the back") && told.contains("--side"),
            "{format}: {told}"
        );
    }
    let asked = WriteOptions {
        side: Some(Side::Back),
        ..WriteOptions::default()
    };
    let written = write(&back, Format::SSDD, &asked).unwrap();
    assert_eq!(written.components, ["reflection of light from the back"]);
    assert!(
        written
            .notices
            .contains(&WriteNotice::SideNotStated { format: Format::SSDD }),
        "{:?}",
        written.notices
    );
    let klems = write(&back, Format::RADIANCE_XML, &WriteOptions::default()).unwrap();
    assert_eq!(read("x.xml", &klems.bytes).components[0].side, Side::Back);
}

/// f at incidence near the normal is 0.1, at 80 degrees 0.2, so that exchanging the directions matters.
#[test]
fn merl_says_what_reciprocity_costs() {
    let table = |low: f64, high: f64| {
        let values: Vec<String> = (0..8)
            .map(|i| if i % 2 == 0 { low } else { high }.to_string())
            .collect();
        let source = format!(
            "VERSION 0.3\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE spherical_coordinate_system\nPARAM0_LIST \
             0 90\nPARAM2_LIST 0 90\nPARAM3_LIST 0 360\nDATA ascii\n{}\n",
            values.join("\n")
        );
        write(
            &read("x.ssdd", source.as_bytes()),
            Format::MERL,
            &WriteOptions::default(),
        )
        .unwrap()
    };
    let told = |notices: &[WriteNotice]| {
        let reciprocal = |notice: &&WriteNotice| matches!(notice, WriteNotice::Reciprocal { .. });
        notices.iter().find(reciprocal).map(ToString::to_string)
    };
    let written = table(0.1, 0.2);
    let notice = told(&written.notices).unwrap();
    // (0.2 − 0.1)/(0.2 + 0.1) where one direction is the normal and the other near the horizon.
    assert!(
        notice.contains("by up to 33.") || notice.contains("by up to 32."),
        "{notice}"
    );
    let back = read("x.binary", &written.bytes);
    let (a, b) = (direction(0.1, 0.0), direction(1.2, 2.0));
    assert!((f(&back, &a, &b) / f(&back, &b, &a) - 1.0).abs() < 1e-2);
    assert_eq!(told(&table(0.1, 0.1).notices), None);
}

#[test]
fn inspect_shows_every_kind_of_file() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    put(
        "both.xml",
        &xml(&[("Transmission Back", "0.02"), ("Reflection Front", "0.1")]),
    );
    put(
        "dye.csv",
        "wavelength_nm,red,blue\n400,0.1,0.6\n500,0.2,0.4\n600,0.5,0.1\n",
    );
    put(
        "readings.csv",
        "theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b\n0,-45,0.1,0.2,0.3\n0,45,0.1,0.2,0.3\n30,45,0.4,0.2,0.3\n",
    );
    let golden = |name: &str| golden(name).display().to_string();
    let klems = json(folder, &["inspect", "both.xml"]);
    assert_eq!(klems["components"][0]["axes"][0]["count"], 10);
    assert_eq!(klems["components"][0]["pairs"], 145 * 145);
    assert!(klems["convention"].as_str().unwrap().contains("WINDOW"));
    let chosen = json(folder, &["inspect", "both.xml", "--side", "back"]);
    assert_eq!(chosen["components"].as_array().unwrap().len(), 1);
    assert_eq!(chosen["components"][0]["side"], "back");
    let none = crate::command::specval(
        folder,
        &["inspect", "both.xml", "--side", "back", "--scatter", "transmission"],
    );
    assert!(String::from_utf8_lossy(&none.stderr).contains("reflection of light from the back"));
    let readings = json(folder, &["inspect", "readings.csv"]);
    let axes = &readings["components"][0]["axes"];
    assert_eq!(
        (&axes[0]["count"], &axes[1]["nodes_deg"]),
        (&2.into(), &serde_json::json!([-45.0, 45.0]))
    );
    assert_eq!(readings["components"][0]["pairs"], 3);
    let dye = json(folder, &["inspect", "dye.csv"]);
    assert_eq!(
        (&dye["format"], &dye["spectra"][1]["highest"]),
        (&"spectra".into(), &0.6.into())
    );
    let draft = json(folder, &["inspect", &golden("twill22.wif")]);
    assert_eq!(
        (&draft["warps"], &draft["repeat"]),
        (&8.into(), &serde_json::json!([4, 4]))
    );
    let sample = json(folder, &["inspect", "merl-red-fabric"]);
    assert_eq!(
        (&sample["geometries"], &sample["format"]),
        (&81.into(), &"sample".into())
    );
    // Angles of a BTDF are about the straight direction, and even steps are said.
    let btdf = crate::command::specval(folder, &["inspect", &golden("dir_btdf_sigmat_bw.ddt")]);
    let words = String::from_utf8(btdf.stdout).unwrap();
    assert!(
        words.contains("straight direction") && words.contains("theta_straight") && !words.contains("mirror"),
        "{words}"
    );
    assert!(
        words.contains("0 to 60, step 20 (4) deg") && words.matches("warning:").count() == 1,
        "{words}"
    );
}

#[test]
fn convert_says_what_it_writes() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    fs::write(
        folder.join("in.xml"),
        xml(&[("Transmission Back", "0.02"), ("Reflection Back", "0.1")]),
    )
    .unwrap();
    let said = crate::command::specval(folder, &["convert", "in.xml", "out.csv"]);
    assert!(String::from_utf8_lossy(&said.stdout).contains("reflection of light from the front"));
    assert!(String::from_utf8_lossy(&said.stderr).contains("transmission of light from the front"));
    let through = json(folder, &["convert", "in.xml", "t.csv", "--scatter", "transmission"]);
    assert_eq!(
        through["components"],
        serde_json::json!(["transmission of light from the front"])
    );
    let refused = crate::command::specval(folder, &["convert", "in.xml", "t.ddr", "--scatter", "transmission"]);
    assert!(String::from_utf8_lossy(&refused.stderr).contains(".ddt"));
    assert!(!folder.join("t.ddr").exists());
}
