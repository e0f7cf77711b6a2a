//! A study with the files beside it, and a study that cannot be: where paths are looked for, and what messages name.

use specval::run::Plan;
use specval::study::Study;
use std::fs;
use std::path::Path;

fn plan_error(text: &str, folder: &Path) -> String {
    let study = Study::from_toml(text, "my.toml").unwrap().at_folder(folder);
    Plan::new(study).err().expect("this study cannot be").to_string()
}

/// Paths of every key are looked for in the study's folder, whatever the working folder is; a built-in name stays one.
#[test]
fn paths_belong_to_the_folder_of_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let write = |name: &str, text: &str| fs::write(here.join(name), text).unwrap();
    let spectrum = |value: &str| format!("wavelength_nm,value\n300,{value}\n900,{value}\n");
    write("host.csv", &spectrum("1.5"));
    write("mu_a", &spectrum("0.1"));
    write("particle.csv", &spectrum("1.6"));
    write("dye", &spectrum("0.5"));
    write("grey.csv", &spectrum("0.5"));
    write("light.csv", &spectrum("1"));
    let observer: String = (300..=900).step_by(10).map(|nm| format!("{nm},1,1,1\n")).collect();
    write("eye.csv", &format!("wavelength_nm,xbar,ybar,zbar\n{observer}"));
    write(
        "twill.wif",
        "[WIF]\nVersion=1.1\n[CONTENTS]\nWEAVING=yes\nWARP=yes\nWEFT=yes\nTHREADING=yes\nTIEUP=yes\nTREADLING=yes\n[WEAVING]\nShafts=2\nTreadles=2\nRising Shed=yes\n[WARP]\nThreads=2\n[WEFT]\nThreads=2\n[THREADING]\n1=1\n2=2\n[TIEUP]\n1=1\n2=2\n[TREADLING]\n1=1\n2=2\n",
    );
    write(
        "sample.csv",
        "theta_i_deg,theta_v_deg,wavelength_nm,beta\n0,0,390,0.5\n0,0,550,0.5\n0,0,730,0.5\n",
    );
    let keys = [
        ("medium", "host_index", "host.csv"),
        ("medium", "host_mu_a_per_mm", "mu_a"),
        ("medium", "particle_index", "particle.csv"),
        ("medium", "dye", "dye"),
        ("weft", "host_index", "host.csv"),
        ("weft", "host_mu_a_per_mm", "mu_a"),
        ("weft", "particle_index", "particle.csv"),
        ("weft", "dye", "dye"),
        ("cloth", "backing", "grey.csv"),
        ("cloth", "weave", "twill.wif"),
        ("weave", "draft", "twill.wif"),
        ("colour", "observer", "eye.csv"),
        ("colour", "illuminant", "light.csv"),
        ("measured", "sample", "sample.csv"),
    ];
    for (section, key, file) in keys {
        let text = format!("[{section}]\n{key} = \"{file}\"\n");
        let study = Study::from_toml(&text, "my.toml").unwrap();
        assert!(Plan::new(study.clone()).is_err(), "{text}: found in the working folder");
        if let Err(error) = Plan::new(study.at_folder(here)) {
            panic!("{text}: {error}");
        }
        // Where it looked, and the line.
        let missing = plan_error(&format!("[{section}]\n{key} = \"absent.{file}\"\n"), here);
        let looked = here.join(format!("absent.{file}")).display().to_string();
        assert!(
            missing.starts_with("my.toml, line 2: ") && missing.contains(&looked),
            "{missing}"
        );
    }
    for built_in in [
        "[medium]\ndye = \"RR2\"\n",
        "[colour]\nobserver = \"cie1964-10deg\"\n",
        "[cloth]\nbacking = \"white\"\n",
        "[cloth]\nweave = \"satin-5\"\n",
    ] {
        let study = Study::from_toml(built_in, "my.toml").unwrap();
        assert_eq!(study.clone().at_folder(here), study);
    }
    // A misspelt name is no path.
    assert!(plan_error("[medium]\ndye = \"RR1\"\n", here).contains("dye 'RR1' is not known"));
}

/// Cloths that cannot be woven: the message has the line of the study, names keys that exist, writes numbers as people
/// do, and what it recommends can be woven.
#[test]
fn a_cloth_that_cannot_be_is_refused_by_its_key() {
    let known = Study::commented_toml();
    let nowhere = Path::new("");
    for (text, key, least) in [
        ("[cloth]\nspacing_diameters = 1.1\n", "cloth.spacing_diameters", true),
        ("[weft]\nspacing_diameters = 1.1\n", "weft.spacing_diameters", true),
        (
            "[cloth]\nwarp_flattening = 5\nspacing_diameters = 1.9\n",
            "cloth.spacing_diameters",
            true,
        ),
        (
            "[weft]\nradius_mm = 1e-6\n[cloth]\nspacing_diameters = 1.8\n",
            "cloth.spacing_diameters",
            true,
        ),
        (
            "[cloth]\nspacing_diameters = 1.8\nradius_variation = 0.2\nrepeats = 3\n",
            "cloth.spacing_diameters",
            false,
        ),
        (
            "[cloth]\nsinusoid_amplitude_mm = 100\ncentre_line = \"sinusoid\"\n",
            "cloth.sinusoid_amplitude_mm",
            false,
        ),
        ("[cloth]\nweave = \"satin-5\"\nrepeats = 60\n", "cloth.repeats", false),
    ] {
        let message = plan_error(text, nowhere);
        let line = 1 + text
            .lines()
            .position(|line| line.starts_with(&key[6..]) || line.starts_with(&key[5..]))
            .unwrap();
        assert!(
            message.starts_with(&format!("my.toml, line {line}: `{key}`: expected ")),
            "{message}"
        );
        for quoted in message.split('`').skip(1).step_by(2) {
            let (_, name) = quoted.split_once('.').unwrap();
            assert!(known.contains(&format!("{name} = ")), "{quoted} in: {message}");
        }
        let digits = message
            .split(|c: char| !c.is_ascii_digit() && c != '.')
            .map(str::len)
            .max()
            .unwrap();
        assert!(digits <= 12, "{message}");
        if least {
            let at_least = message.split("at least ").nth(1).unwrap().split(' ').next().unwrap();
            let old = text.lines().nth(line - 1).unwrap();
            let new = format!("{} = {at_least}", key.split_once('.').unwrap().1);
            let study = Study::from_toml(&text.replace(old, &new), "my.toml").unwrap();
            assert!(Plan::new(study).is_ok(), "{message}");
        }
    }
}

/// By default a sinusoid has the smallest amplitude at which yarns do not overlap, so every spacing of Peirce's cloth
/// has one.
#[test]
fn a_sinusoid_is_possible_at_the_default_spacing() {
    let of = |more: &str| {
        let text = format!("[cloth]\ncentre_line = \"sinusoid\"\n{more}");
        Plan::new(Study::from_toml(&text, "my.toml").unwrap()).map(|plan| plan.cloth_spec.centre_line)
    };
    use specval::cloth::CentreLineKind::Sinusoid;
    let amplitude = |more: &str| match of(more) {
        Ok(Sinusoid { amplitude_mm }) => amplitude_mm,
        other => panic!("{more}: {:?}", other.map_err(|error| error.to_string())),
    };
    // Yarns of radius 0.15 mm touch at 0.15; far apart nothing more is needed.
    assert_eq!(amplitude("spacing_diameters = 3"), 0.15);
    let close = amplitude("");
    assert!((0.151..0.2).contains(&close), "{close}");
    let less = close - 0.02 * 0.15;
    assert!(of(&format!("sinusoid_amplitude_mm = {less}")).is_err());
    // Flat yarns touch lower.
    assert!(amplitude("spacing_diameters = 4\nwarp_flattening = 3\nweft_flattening = 3") < 0.1);
}
