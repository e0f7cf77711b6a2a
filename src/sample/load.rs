use std::fmt::Write;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::curves::curves;
use super::description::{Chosen, Description, Uncertainty};
use super::error::SampleError;
use super::goniometric::GoniometricData;
use super::measured::{Data, Sample};
use super::ratios::{PublishedRatios, ratios};
use crate::formats::{self, Format, ReadOptions};
use crate::goniometric::Goniometric;
use crate::input::{MOST_TEXT, read_file};
use crate::spectrum::{CsvTable, UnknownName};
use crate::text::encoding::beginning;
use crate::text::{Heading, heading};

struct BuiltIn {
    name: &'static str,
    description: &'static str,
    data: &'static [u8],
}

macro_rules! built_in {
    ($name:literal, $data:literal) => {
        BuiltIn {
            name: $name,
            description: include_str!(concat!("../../measurements/", $name, "/sample.toml")),
            data: include_bytes!(concat!("../../measurements/", $name, "/", $data)),
        }
    };
}

const COTTON: BuiltIn = built_in!("voloboy2008-cotton", "data.csv");
const BUILT_IN: [BuiltIn; 6] = [
    built_in!("merl-red-fabric", "data.csv"),
    built_in!("merl-red-fabric2", "data.csv"),
    COTTON,
    built_in!("rgl-acrylic-felt-pink", "acrylic_felt_pink_rgb.bsdf"),
    built_in!("rgl-acrylic-felt-green", "acrylic_felt_green_rgb.bsdf"),
    built_in!("mecho-6216", "klems_aniso_high.xml"),
];

/// The file of readings in a sample's folder that states no other.
const DATA: &str = "data.csv";

/// Table 1 of the preprint: ratios of the real cotton and the range of its model.
pub fn published_ratios() -> Result<PublishedRatios, SampleError> {
    Ok(ratios(&CsvTable::parse(COTTON.name, COTTON.data)?)?)
}

impl Sample {
    /// A built-in sample by name, else a folder with `sample.toml` and `data.csv`, else a bare CSV file or a
    /// goniometric file of any format of [`crate::formats`]. A folder that has the name of a built-in sample is reached
    /// as `./name`.
    ///
    /// The data are spectral, with the columns `theta_i_deg,theta_v_deg,wavelength_nm,beta` and perhaps `beta_se`, or
    /// RGB, `theta_i_deg,theta_v_deg,beta_r,beta_g,beta_b` and perhaps `beta_r_se,beta_g_se,beta_b_se`; angles in
    /// degrees, theta_v_deg negative on the light's side of the normal; β dimensionless, 1 for a perfect diffuser.
    pub fn load(name_or_path: &str) -> Result<Self, SampleError> {
        Self::load_chosen(name_or_path, Chosen::default())
    }

    /// [`Sample::load`] of a component of the file; tables of readings in the plane of incidence have reflection from
    /// the front alone.
    pub fn load_chosen(name_or_path: &str, chosen: Chosen) -> Result<Self, SampleError> {
        if let Some(known) = BUILT_IN.iter().find(|sample| sample.name == name_or_path) {
            let toml = format!("measurements/{}/sample.toml", known.name);
            let description = describe(&toml, known.description)?;
            let path = format!("measurements/{}/{}", known.name, data_name(&description));
            return Self::described(description, &path, known.data, chosen);
        }
        let path = Path::new(name_or_path);
        if path.is_dir() {
            let member = |name: &str| {
                let member = path.join(name);
                if member.exists() {
                    Ok(member)
                } else {
                    Err(SampleError::Incomplete {
                        folder: name_or_path.into(),
                        missing: name.into(),
                    })
                }
            };
            let toml = member("sample.toml")?;
            let text = String::from_utf8(read(&toml)?).map_err(|e| SampleError::Description {
                path: toml.display().to_string(),
                message: format!("expected text in UTF-8: {e}"),
            })?;
            let description = describe(&toml.display().to_string(), &text)?;
            let data = member(data_name(&description))?;
            // Told its size and format before it is read as a whole.
            if !is_csv(data_name(&description)) {
                formats::format_of(&data)?;
            }
            Self::described(description, &data.display().to_string(), &read(&data)?, chosen)
        } else if path.exists() {
            let stem = path.file_stem().unwrap_or(path.as_os_str());
            let description = Description {
                name: stem.to_string_lossy().into_owned(),
                source: name_or_path.into(),
                licence: "not stated".into(),
                kind: None,
                relative_standard_uncertainty: None,
                colour: None,
                data: None,
                channel: None,
                isotropic: None,
            };
            match formats::format_of(path) {
                // A folder or an empty file is told in the words of the reader of CSV.
                Ok(Format::CSV) | Err(_) => {
                    let bytes = read(path)?;
                    if is_over_the_sphere(&bytes) {
                        let data = formats::parse(name_or_path, &bytes, &ReadOptions::default())?;
                        return Self::goniometric(name_or_path, description, data, &bytes, chosen);
                    }
                    Self::new(description, name_or_path, &bytes, chosen)
                }
                // Read for its values first: that refuses a file too large for its format.
                Ok(_) => {
                    let data = formats::read(path, &ReadOptions::default())?;
                    Self::goniometric(name_or_path, description, data, &read(path)?, chosen)
                }
            }
        } else {
            let known = BUILT_IN.iter().map(|sample| sample.name);
            Err(SampleError::Unknown(UnknownName::new("sample", name_or_path, known)))
        }
    }

    /// The file beside a `sample.toml`, of whichever format.
    fn described(description: Description, path: &str, bytes: &[u8], chosen: Chosen) -> Result<Self, SampleError> {
        if is_csv(path) && !is_over_the_sphere(bytes) {
            return Self::new(description, path, bytes, chosen);
        }
        let data = formats::parse(path, bytes, &ReadOptions::default())?;
        Self::goniometric(path, description, data, bytes, chosen)
    }

    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|sample| sample.name)
    }

    pub fn uncertainty(&self) -> Uncertainty {
        match (&self.data, self.description.relative_standard_uncertainty) {
            (Data::SampleCurves(curves), _) if curves.has_se() => Uncertainty::Columns,
            (Data::Goniometric(data), _) if data.has_se() => Uncertainty::Columns,
            (Data::SampleCurves(_) | Data::Goniometric(_), Some(relative)) => Uncertainty::Relative(relative),
            _ => Uncertainty::NotStated,
        }
    }

    fn new(description: Description, path: &str, bytes: &[u8], chosen: Chosen) -> Result<Self, SampleError> {
        if chosen.or_default() != Chosen::default().or_default() {
            return Err(SampleError::NotComparable {
                path: path.into(),
                expected: chosen.words(),
                found: Chosen::default().words(),
                remedy: Chosen::REMEDY.into(),
            });
        }
        let table = CsvTable::parse(path, bytes)?;
        let data = if table.column("row").is_some() {
            Data::Ratios(ratios(&table)?)
        } else {
            Data::SampleCurves(curves(table, description.relative_standard_uncertainty)?)
        };
        Ok(Self {
            description,
            data,
            digest: digest(bytes),
        })
    }

    fn goniometric(
        path: &str,
        description: Description,
        data: Goniometric,
        bytes: &[u8],
        chosen: Chosen,
    ) -> Result<Self, SampleError> {
        let data = GoniometricData::new(path, &description, data, chosen)?;
        Ok(Self {
            // A file without azimuths of incidence is isotropic by its format.
            description: Description {
                isotropic: description.isotropic.or(data.is_isotropic().then_some(true)),
                ..description
            },
            data: Data::Goniometric(Box::new(data)),
            digest: digest(bytes),
        })
    }
}

fn data_name(description: &Description) -> &str {
    description.data.as_deref().unwrap_or(DATA)
}

fn is_csv(path: &str) -> bool {
    Path::new(path)
        .extension()
        .is_some_and(|it| it.eq_ignore_ascii_case("csv"))
}

/// Whether a CSV has readings outside the plane of incidence, in the columns of `formats`.
fn is_over_the_sphere(bytes: &[u8]) -> bool {
    const HEAD: usize = 64 << 10;
    let text = beginning(&bytes[..bytes.len().min(HEAD)]);
    // Lines of a preamble, and one `sep=;`, may stand before the header.
    text.split(['\n', '\r']).find_map(heading) == Some(Heading::Sphere)
}

fn digest(bytes: &[u8]) -> String {
    let mut digest = String::new();
    for byte in Sha256::digest(bytes) {
        // Writing to a string cannot fail.
        let _ = write!(digest, "{byte:02x}");
    }
    digest
}

fn describe(path: &str, text: &str) -> Result<Description, SampleError> {
    let refuse = |message: String| SampleError::Description {
        path: path.into(),
        message,
    };
    let description: Description = toml::from_str(text).map_err(|e| refuse(e.to_string()))?;
    if description.kind.is_none() {
        return Err(refuse(
            "kind is missing: expected \"measured\", \"fit\" or \"synthetic\"".into(),
        ));
    }
    if let Some(data) = description.data.as_deref() {
        let path = Path::new(data);
        if path.file_name() != Some(path.as_os_str()) {
            return Err(refuse(format!(
                "data: expected the name of a file in the same folder, found '{data}'; put the readings beside sample.toml"
            )));
        }
    }
    match description.relative_standard_uncertainty {
        Some(u) if !(0.0..1.0).contains(&u) => Err(refuse(format!(
            "relative_standard_uncertainty: expected a fraction of the value, 0 up to 1, found {u}; 5 % is 0.05"
        ))),
        _ => Ok(description),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, SampleError> {
    read_file(path, MOST_TEXT).map_err(|e| SampleError::Read {
        path: path.display().to_string(),
        reason: e.to_string(),
    })
}
