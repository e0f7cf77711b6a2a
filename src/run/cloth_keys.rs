//! A cloth that cannot be woven, in the keys of the study that asked for it.

use crate::cloth::{ClothError, ClothSpec, System};
use crate::number::shown;
use crate::study::{Study, StudyError};

/// The error with the key that brings about what is wrong, its value, and one that would do. An error of no key stays
/// none.
pub(super) fn at_key(study: &Study, spec: &ClothSpec, error: &ClothError) -> Option<StudyError> {
    let value = |key: &str, expected: String, found: String, remedy: String| {
        Some(StudyError::Value {
            place: study.origin.place(key),
            key: key.into(),
            expected,
            found,
            remedy,
        })
    };
    let vary = match study.cloth.radius_variation > 0.0 || study.cloth.spacing_variation > 0.0 {
        true => ", or reduce `cloth.radius_variation` and `cloth.spacing_variation`",
        false => "",
    };
    let at_least = |system: System, factor: f64, or_else: &str| {
        let (key, spacing) = spacing_key(study, system);
        // Rounded up, so that what is recommended holds.
        let least = shown((spacing * factor * 1e4).ceil() * 1e-4);
        value(
            key,
            format!("at least {least} yarn diameters, {or_else}"),
            shown(spacing),
            format!("increase it{vary}"),
        )
    };
    let amplitude = study.cloth.sinusoid_amplitude_mm;
    match error {
        ClothError::Jammed {
            system,
            crossed,
            spacing_mm,
            minimum_mm,
            ..
        } => at_least(
            *crossed,
            minimum_mm / spacing_mm,
            &format!("or the {system} yarns have no room between the {crossed} yarns that they cross"),
        ),
        ClothError::Overlap {
            neighbours: Some(system),
            overlap_mm,
            ..
        } => {
            let spacing_mm = match system {
                System::Warp => spec.warp_spacing_mm,
                System::Weft => spec.weft_spacing_mm,
            };
            let or_else = format!("or neighbouring {system} yarns overlap by {} mm", shown(*overlap_mm));
            at_least(*system, 1.0 + overlap_mm / spacing_mm, &or_else)
        }
        ClothError::Overlap { .. } | ClothError::TooCurved { .. } => {
            let expected =
                |of: &str| format!("{of} at which yarns neither overlap nor bend tighter than they are thick");
            match amplitude {
                Some(amplitude_mm) => value(
                    "cloth.sinusoid_amplitude_mm",
                    expected("an amplitude"),
                    format!("{} mm, where {}", shown(amplitude_mm), error.fault()),
                    "leave it out to have the smallest that is possible, or increase `cloth.spacing_diameters`".into(),
                ),
                None => {
                    let (key, spacing) = spacing_key(study, System::Warp);
                    value(
                        key,
                        expected("a spacing"),
                        format!("{}, where {}", shown(spacing), error.fault()),
                        format!("increase it{vary}"),
                    )
                }
            }
        }
        ClothError::TooManyCrossings { found, limit } => {
            let repeats = study.cloth.repeats;
            let one = *found as f64 / f64::from(repeats).powi(2);
            let most = (*limit as f64 / one).sqrt().floor();
            if most >= 1.0 {
                return value(
                    "cloth.repeats",
                    format!("at most {most} repeats of this weave, which have {limit} crossings of yarns or fewer"),
                    repeats.to_string(),
                    "reduce it".into(),
                );
            }
            value(
                "cloth.weave",
                format!("a weave of at most {limit} crossings of yarns in one repeat"),
                format!("{}, which has {one}", study.cloth.weave),
                "take a draft with fewer yarns".into(),
            )
        }
        ClothError::NeverInterlaces { .. } | ClothError::EmptyDraft | ClothError::RaggedDraft { .. } => {
            Some(of_weave(study, error))
        }
        ClothError::Length { .. } | ClothError::Ratio { .. } => None,
    }
}

/// The error of a draft that is no weave.
pub(super) fn of_weave(study: &Study, error: &ClothError) -> StudyError {
    let key = "cloth.weave";
    StudyError::Value {
        place: study.origin.place(key),
        key: key.into(),
        expected: "a weave in which every yarn changes sides".into(),
        found: format!("{}, of which {}", study.cloth.weave, error.fault()),
        remedy: "print it with `specval weave`, and change the draft".into(),
    }
}

/// The key that says how far the yarns of a system are apart, and its value.
fn spacing_key(study: &Study, system: System) -> (&'static str, f64) {
    match (system, study.weft.spacing_diameters) {
        (System::Weft, Some(spacing)) => ("weft.spacing_diameters", spacing),
        _ => ("cloth.spacing_diameters", study.cloth.spacing_diameters),
    }
}
