//! SSDD files: any values in any parameters come back, as text and in binary.

use proptest::prelude::*;
use specval::formats::{
    ChannelSet, Encoding, Format, Goniometric, ReadOptions, Scatter, Side, Table, WriteError, WriteNotice,
    WriteOptions, parse, write,
};

use crate::golden::{golden, load};

const BINARY: WriteOptions = WriteOptions {
    scatter: None,
    side: None,
    encoding: Encoding::Binary,
};

/// Where the data of the first block begin.
fn data_of(bytes: &[u8]) -> &[u8] {
    let mark = b"DATA binary\n";
    let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
    &bytes[at + mark.len()..]
}

/// A binary file gives the numbers of the binary file it was, several blocks, and what the source of the data is.
#[test]
fn ssdd_holds_binary_values() {
    let name = "dir_specular_spectral7_binary.ssdd";
    let data = load(name);
    let written = write(&data, Format::SSDD, &BINARY).unwrap();
    assert!(written.notices.is_empty(), "{:?}", written.notices);
    let original = std::fs::read(golden(name)).unwrap();
    let values = data_of(&original);
    assert_eq!(&data_of(&written.bytes)[..values.len()], values);

    let both = load("lbgen_lambert_bsdf_mono.ssdd");
    assert_eq!(both.components.len(), 2);
    let written = write(&both, Format::SSDD, &BINARY).unwrap();
    let back = parse("x.ssdd", &written.bytes, &ReadOptions::default()).unwrap();
    assert_eq!(back.components.len(), 2);
    for scatter in [Scatter::Reflection, Scatter::Transmission] {
        let of = |data: &Goniometric| {
            data.component(scatter, Side::Front)
                .unwrap()
                .directional_hemispherical(0.5, 0.0)
                .unwrap()
                .values[0]
        };
        assert!((of(&back) / of(&both) - 1.0).abs() < 1e-7);
    }

    let measured = parse(
        "x.ddr",
        &std::fs::read(golden("dir_iso_rgb.ddr")).unwrap(),
        &ReadOptions::default(),
    );
    let measured = measured.unwrap();
    assert!(measured.provenance.source.is_some());
    for options in [WriteOptions::default(), BINARY] {
        let written = write(&measured, Format::SSDD, &options).unwrap();
        let back = parse("x.ssdd", &written.bytes, &ReadOptions::default()).unwrap();
        let lower = |data: &Goniometric| data.provenance.source.as_deref().unwrap().to_ascii_lowercase();
        assert_eq!(lower(&back), lower(&measured));
        let told = written.notices.contains(&WriteNotice::RoundedTo32Bits);
        assert_eq!(told, options == BINARY);
    }

    let text = std::fs::read_to_string(golden("dir_iso_bw.ddr")).unwrap();
    let text = text
        .replacen("kbdf\n 1 1 1 1", "kbdf\n 1e20 1 1 1", 1)
        .replacen("1.29462595", "1e20", 1);
    let huge = parse("x.ddr", text.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(matches!(
        write(&huge, Format::SSDD, &BINARY),
        Err(WriteError::CannotHold { .. })
    ));
}

/// libbsdf takes a '#' at the beginning of binary data for a comment.
#[test]
fn binary_values_begin_with_no_comment() {
    for first in [*b"#bc>", *b" #c>", *b"\n#c>", *b"\r #>", *b"    ", *b"abc>"] {
        let head =
            "VERSION 0.3\nDATA_TYPE specular_reflectance\nCOLOR_MODEL monochrome\nPARAM0_LIST 0 10\nDATA binary\n";
        let bytes = [head.as_bytes(), &first, b"#bc>"].concat();
        let data = parse("x.ssdd", &bytes, &ReadOptions::default()).unwrap();
        let written = write(&data, Format::SSDD, &BINARY).unwrap().bytes;
        let begins = data_of(&written)
            .iter()
            .find(|byte| !byte.is_ascii_whitespace() && **byte != 0x0b);
        assert_ne!(begins, Some(&b'#'), "{first:?}");
        let back = parse("x.ssdd", &written, &ReadOptions::default()).unwrap();
        let (Table::Specular(a), Table::Specular(b)) = (&data.components[0].table, &back.components[0].table) else {
            panic!("no specular table")
        };
        for node in 0..2 {
            assert!((b.at(node, 0)[0] / a.at(node, 0)[0] - 1.0).abs() < 1e-6, "{first:?}");
        }
    }
}

/// An SSDD file of any values in one of the parameter types.
fn ssdd() -> impl Strategy<Value = String> {
    let lists = (2usize..4, 1usize..4, 2usize..4, 2usize..5, 0usize..3, 1usize..4);
    lists.prop_flat_map(|(n0, n1, n2, n3, kind, channels)| {
        let values = prop::collection::vec(0.0..10.0f64, n0 * n1 * n2 * n3 * channels);
        values.prop_map(move |values| {
            let list = |n: usize, last: f64| {
                let step = last / (n.max(2) - 1) as f64;
                (0..n)
                    .map(|i| (i as f64 * step).to_string())
                    .collect::<Vec<_>>()
                    .join(" ")
            };
            let kind = ["spherical", "specular", "half_difference"][kind];
            let colour = match channels {
                1 => "COLOR_MODEL monochrome".to_owned(),
                2 => "COLOR_MODEL spectrum\nWAVELENGTH_LIST 450.5 700".to_owned(),
                _ => "COLOR_MODEL xyz".to_owned(),
            };
            let rows = values
                .chunks(channels)
                .map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" "));
            let azimuths = if n1 > 1 {
                format!("PARAM1_LIST {}\n", list(n1, 360.0))
            } else {
                String::new()
            };
            format!(
                "VERSION 0.3\nDATA_TYPE brdf\n{colour}\nPARAM_TYPE {kind}_coordinate_system\nPARAM0_LIST {}\n{azimuths}\
                 PARAM2_LIST {}\nPARAM3_LIST {}\nDATA ascii\n{}\n",
                list(n0, 80.0),
                list(n2, 90.0),
                list(n3, 360.0),
                rows.collect::<Vec<_>>().join("\n")
            )
        })
    })
}

proptest! {
    /// Binary values are those of the text to the precision of 32 bits.
    #[test]
    fn binary_nodes_survive(text in ssdd()) {
        let data = parse("x.ssdd", text.as_bytes(), &ReadOptions::default()).unwrap();
        let written = write(&data, Format::SSDD, &BINARY).unwrap();
        let back = parse("x.ssdd", &written.bytes, &ReadOptions::default()).unwrap();
        let (Table::Grid(grid), Table::Grid(found)) = (&data.components[0].table, &back.components[0].table) else {
            panic!("no grid")
        };
        prop_assert_eq!(found.shape(), grid.shape());
        let [n0, n1, n2, n3] = grid.shape();
        for i in 0..n0 * n1 * n2 * n3 {
            let node = [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2];
            for channel in 0..data.components[0].channels.count() {
                let (value, found) = (grid.at(node, channel), found.at(node, channel));
                prop_assert!((value - found).abs() <= 1e-6 * value);
            }
        }
    }

    /// Every node comes back to the last digit but one.
    #[test]
    fn nodes_survive(text in ssdd()) {
        let data = parse("x.ssdd", text.as_bytes(), &ReadOptions::default()).unwrap();
        let Table::Grid(grid) = &data.components[0].table else { panic!("no grid") };
        let specular = text.contains("specular");
        for format in [Format::SSDD, Format::DDR] {
            if format == Format::DDR && (!specular || data.components[0].channels == ChannelSet::Xyz) {
                continue;
            }
            let written = write(&data, format, &WriteOptions::default()).unwrap();
            let back = parse("x.ddr", &written.bytes, &ReadOptions::default()).unwrap();
            let component = &back.components[0];
            let Table::Grid(found) = &component.table else { panic!("no grid") };
            prop_assert_eq!(found.shape(), grid.shape());
            let [n0, n1, n2, n3] = grid.shape();
            for i in 0..n0 * n1 * n2 * n3 {
                let node = [i % n0, i / n0 % n1, i / n0 / n1 % n2, i / n0 / n1 / n2];
                for channel in 0..component.channels.count() {
                    let value = component.quantity.to_bsdf(found.at(node, channel), 1.0).unwrap();
                    prop_assert!((value - grid.at(node, channel)).abs() <= 1e-14 * value);
                }
            }
        }
    }
}
