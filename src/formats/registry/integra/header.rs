//! What stands before the data.

use crate::formats::error::{FormatError, remedy};
use crate::formats::text::{Token, Tokens};
use crate::goniometric::{Fold, Quantity, ReadNotice};

pub(super) struct Header<'a> {
    pub(super) source: Option<String>,
    pub(super) fold: Fold,
    pub(super) rotational: bool,
    pub(super) colour: Option<ColourHeader>,
    pub(super) quantity: Quantity,
    pub(super) relative: bool,
    pub(super) psi_deg: Option<Vec<f64>>,
    pub(super) sigma_deg: Vec<f64>,
    pub(super) sigmat_deg: Option<Vec<f64>>,
    pub(super) phi_deg: Option<Vec<f64>>,
    pub(super) theta_deg: Vec<f64>,
    pub(super) warnings: Vec<ReadNotice>,
    /// First word of the data.
    pub(super) data: Token<'a>,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum ColourHeader {
    Bw,
    Rgb,
    Spectral(usize),
}

impl ColourHeader {
    pub(super) fn blocks(self) -> usize {
        match self {
            Self::Bw => 1,
            Self::Rgb => 3,
            Self::Spectral(count) => count,
        }
    }
}

pub(super) const BLOCK: &str = "'bw', 'red', 'gre', 'blu' or 'wl'";

pub(super) fn is_block(token: &Token) -> bool {
    ["bw", "red", "gre", "green", "blu", "blue", "wl"]
        .iter()
        .any(|word| token.is(word))
}

pub(super) fn header<'a>(tokens: &mut Tokens<'a>, diffuse: bool) -> Result<Header<'a>, FormatError> {
    let (mut source, mut colour, mut symmetry) = (None, None, None);
    let (mut quantity, mut relative) = (Quantity::BrightnessFactor, false);
    let (mut psi, mut sigma, mut sigmat, mut phi, mut theta) = (None, None, None, None, None);
    let mut warnings = Vec::new();
    let data = loop {
        let token = tokens.expect("a key word of the header, or the first block of data")?;
        if is_block(&token) {
            break token;
        }
        let once = |there: bool| match there {
            true => Err(tokens.unexpected(&token, "each key word once", remedy::ONE_OF_TWO)),
            false => Ok(()),
        };
        match token.word.to_ascii_lowercase().as_str() {
            "source" => {
                once(source.is_some())?;
                source = Some(one_of(tokens, &["Measured", "Generated", "Edited", "Morphed"])?.to_owned());
            }
            "typecolormodel" => {
                once(colour.is_some())?;
                colour = Some(match one_of(tokens, &["BW", "RGB", "spectral"])? {
                    "BW" => ColourHeader::Bw,
                    "RGB" => ColourHeader::Rgb,
                    _ => ColourHeader::Spectral(tokens.count("wavelengths")?),
                });
            }
            "typesym" if diffuse => {
                once(symmetry.is_some())?;
                let words = ["AxiSymmetrical", "PlaneSymmetrical", "ASymmetrical", "DirSymmetrical"];
                symmetry = Some(one_of(tokens, &words)?);
                if tokens.peek().is_some_and(|t| t.is("4D")) {
                    tokens.next();
                }
                if symmetry == Some("DirSymmetrical") {
                    let expected = "AxiSymmetrical, PlaneSymmetrical or ASymmetrical";
                    let remedy = "export the file with one of these: what DirSymmetrical leaves out is not documented";
                    return Err(tokens.unexpected(&token, expected, remedy));
                }
            }
            "typedata" if diffuse => {
                quantity = match one_of(tokens, &["Luminance", "Intensity"])? {
                    "Luminance" => Quantity::BrightnessFactor,
                    _ => Quantity::BsdfCosine,
                };
                relative = one_of(tokens, &["Absolute", "Relative"])? == "Relative";
            }
            "psi" if diffuse => {
                once(psi.is_some())?;
                let count = tokens.count("angles psi")?;
                psi = Some(tokens.angles_deg(count, "angles psi", 0.0..=360.0)?);
            }
            "sigma" => {
                once(sigma.is_some())?;
                let count = tokens.count("angles sigma")?;
                sigma = Some(tokens.angles_deg(count, "angles sigma", 0.0..=90.0)?);
            }
            "sigmat" if diffuse => {
                once(sigmat.is_some())?;
                let count = sigma.as_ref().map(Vec::len);
                let count = count.ok_or_else(|| {
                    tokens.unexpected(&token, "'sigma' before 'sigmat'", "move the list sigma before it")
                })?;
                let mut angles = Vec::new();
                tokens.numbers(
                    count,
                    "angles sigmat in degrees, 0..90, one a sigma",
                    &(0.0..=90.0),
                    &mut angles,
                )?;
                sigmat = Some(angles);
            }
            "phi" if diffuse => {
                once(phi.is_some())?;
                let count = tokens.count("angles phi")?;
                phi = Some(tokens.angles_deg(count, "angles phi", 0.0..=360.0)?);
            }
            "theta" if diffuse => {
                once(theta.is_some())?;
                let count = tokens.count("angles theta")?;
                theta = Some(tokens.angles_deg(count, "angles theta", 0.0..=180.0)?);
            }
            _ => {
                let expected = "a key word of the header, or the first block of data";
                return Err(tokens.unexpected(&token, expected, remedy::SPELLING_OR_COUNT));
            }
        }
    };
    let missing = |word: &str| {
        let remedy = format!("write the list of angles {word}, with its count, before the data");
        let expected = format!("'{word}' in the header");
        tokens
            .source
            .error(data.at, expected, "the first block of data", remedy)
    };
    if diffuse && symmetry.is_none() {
        warnings.push(ReadNotice::NoSymmetry);
    }
    let symmetry = symmetry.unwrap_or("PlaneSymmetrical");
    let rotational = symmetry == "AxiSymmetrical";
    if diffuse && phi.is_none() && !rotational {
        return Err(missing("phi"));
    }
    Ok(Header {
        source,
        fold: if symmetry == "PlaneSymmetrical" {
            Fold::Mirror
        } else {
            Fold::None
        },
        rotational,
        colour,
        quantity,
        relative,
        psi_deg: psi,
        sigma_deg: sigma.ok_or_else(|| missing("sigma"))?,
        sigmat_deg: sigmat,
        phi_deg: phi,
        theta_deg: if diffuse {
            theta.ok_or_else(|| missing("theta"))?
        } else {
            Vec::new()
        },
        warnings,
        data,
    })
}

/// The word as it is spelt here; other readers take any case.
pub(super) fn one_of<'w>(tokens: &mut Tokens, words: &[&'w str]) -> Result<&'w str, FormatError> {
    let expected = words.join(" or ");
    let token = tokens.expect(&expected)?;
    let known = words.iter().find(|word| token.is(word));
    known
        .copied()
        .ok_or_else(|| tokens.unexpected(&token, expected, remedy::SPELLING))
}
