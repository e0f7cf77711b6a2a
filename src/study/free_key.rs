use serde::{Deserialize, Serialize};

/// A key that a fit varies, as `[fit] free` has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FreeKey {
    /// Section and key, as `medium.particle_index`.
    pub key: String,
    /// Bounds, in the key's unit.
    pub min: f64,
    pub max: f64,
    #[serde(default, skip_serializing_if = "KeyScale::is_linear")]
    pub scale: KeyScale,
    /// What is known of the value before the fit: mean and standard deviation, both or neither.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior_mean: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior_sd: Option<f64>,
    /// Further keys that take the same value.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<String>,
}

/// Scale on which a key varies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KeyScale {
    #[default]
    Linear,
    Log,
}

impl KeyScale {
    fn is_linear(&self) -> bool {
        *self == Self::Linear
    }
}

impl FreeKey {
    fn new(key: &str, [min, max]: [f64; 2], scale: KeyScale, also: &[&str]) -> Self {
        Self {
            key: key.into(),
            min,
            max,
            scale,
            prior_mean: None,
            prior_sd: None,
            also: also.iter().map(|key| (*key).into()).collect(),
        }
    }

    /// Scattering strength, flattening and spacing of the yarns, and gloss.
    pub(super) fn defaults() -> Vec<Self> {
        let flattening = ["cloth.warp_flattening", "cloth.weft_flattening"];
        vec![
            Self::new("medium.particle_index", [1.6, 2.4], KeyScale::Linear, &[]),
            Self::new(flattening[0], [1.0, 4.0], KeyScale::Log, &flattening[1..]),
            Self::new("cloth.spacing_diameters", [1.1, 3.5], KeyScale::Log, &[]),
            Self::new("specular.weight", [0.0, 1.0], KeyScale::Linear, &[]),
            Self::new("specular.roughness", [0.05, 1.0], KeyScale::Log, &[]),
        ]
    }

    /// All keys that take the value.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.key.as_str()).chain(self.also.iter().map(String::as_str))
    }
}
