//! What makes the numbers of a study doubtful, before or after it is run, and what is done otherwise than it asks.

use super::readings::first_incidences;
use super::{Plan, RunError, Stage};
use crate::colour::ColourError;
use crate::compare::{ColourRatios, Comparison, HueComparison};
use crate::report::{Fallback, Notice};
use crate::rig::Geometry;
use crate::sample::Sample;
use crate::spectrum::plausibility;
use crate::study::{MethodChoice, OldKey, Study, StudyError};
use crate::yarn::Yarn;

impl Plan {
    /// What makes numbers of this study doubtful whatever is done with them, for the user.
    pub fn notices(&self) -> Vec<Notice> {
        let mut notices = study_notices(&self.study);
        notices.extend(self.long_paths());
        notices
    }

    /// The same before the work, and how long that will be.
    ///
    /// # Errors
    /// As [`Plan::work_notice`].
    pub fn notices_before(&self, stage: Stage) -> Result<Vec<Notice>, StudyError> {
        let mut notices = study_notices(&self.study);
        notices.extend(self.work_notice(stage)?);
        Ok(notices)
    }

    /// Refuses wavelengths that carry no colour.
    ///
    /// # Errors
    /// The key that sets them, and what needs no colour.
    pub fn require_colour(&self) -> Result<(), RunError> {
        let refuse = |source: ColourError| {
            let source = Box::new(source);
            let key = match self.study.spectrum.wavelengths_nm {
                Some(_) => "wavelengths_nm",
                None => "wavelength_step_nm",
            };
            RunError::Wavelengths { key, source }.at(&self.study.origin)
        };
        self.colour.require().map_err(refuse)
    }

    /// What makes the colours of model and sample doubtful, for the user; what needs no colour needs none of it.
    ///
    /// # Errors
    /// Wavelengths of the study or of the sample that carry no colour.
    pub fn colour_notices(&self) -> Result<Vec<Notice>, RunError> {
        self.require_colour()?;
        let mut notices = Vec::new();
        if let Some(why) = self.colour.doubt() {
            notices.push(Notice::ModelColours { why: why.into() });
        }
        if let Some(why) = self.sample.colour_doubt(self.colour.convention())? {
            notices.push(Notice::MeasuredColours { why });
        }
        Ok(notices)
    }
}

/// Old spellings of a study's file, and numbers of its media that look like those of another unit.
pub fn study_notices(study: &Study) -> Vec<Notice> {
    let old_key = |key: &OldKey| Notice::OldKey { key: key.clone() };
    let mut notices: Vec<Notice> = study.origin.old_keys().iter().map(old_key).collect();
    let weft = study.weft.medium(&study.medium);
    let mut media = vec![("medium", study.medium.particle_diameter_nm)];
    if weft.particle_diameter_nm != study.medium.particle_diameter_nm {
        media.push(("weft", weft.particle_diameter_nm));
    }
    let doubtful = |(section, diameter_nm): (&str, f64)| {
        Some(Notice::ParticleDiameter {
            section: section.into(),
            doubt: plausibility::particle_diameter(diameter_nm)?,
        })
    };
    notices.extend(media.into_iter().filter_map(doubtful));
    let radians = plausibility::radians_for_degrees(study.rig.incidences_deg.iter().copied(), []);
    notices.extend(radians.map(|doubt| Notice::StudyAngles {
        key: "rig.incidences_deg".into(),
        doubt,
    }));
    notices
}

/// What is done in another way than the study asks, as far as that is known before the comparison.
pub(super) fn study_fallbacks(plan: &Plan, geometries: &[Geometry]) -> Vec<Fallback> {
    let mut fallbacks = Vec::new();
    if geometries.len() > 1 && geometries.iter().position(|g| *g == Geometry::NORMAL) == Some(geometries.len() - 1) {
        fallbacks.push(Fallback::NormalAdded);
    }
    let other_estimator = |yarn: &Yarn| yarn.estimator_in_use() != yarn.estimator;
    if plan.different_yarns().any(other_estimator) {
        fallbacks.push(Fallback::IndependentEstimator);
    }
    let cloth = &plan.study.cloth;
    if cloth.method == MethodChoice::RadianceFactor
        && (cloth.warp_flattening != 1.0 || cloth.weft_flattening != 1.0 || cloth.radius_variation > 0.0)
    {
        fallbacks.push(Fallback::RoundYarnResponse);
    }
    if plan.study.specular.surface.is_of_yarns() {
        fallbacks.push(Fallback::YarnsShine);
    }
    fallbacks
}

/// What differs from the preprint's normalisation; nothing at normal incidence and view.
pub(super) fn of_reference(comparison: &Comparison) -> Option<Fallback> {
    if comparison.normalisation.is_empty() {
        return Some(Fallback::NotNormalised);
    }
    let at = comparison.references.first().copied();
    at.filter(|at| *at != Geometry::NORMAL)
        .map(|at| Fallback::OtherReference { at })
}

/// Why a sample without a reading at the geometries of a report is not compared.
pub(super) fn not_compared(sample: &Sample) -> Fallback {
    let name = sample.name().to_owned();
    match sample.published_ratios() {
        Some(_) => Fallback::PublishedRatiosAlone { sample: name },
        None => Fallback::NothingCompared {
            sample: name,
            incidences_deg: first_incidences(sample),
        },
    }
}

/// That model and sample plainly differ in hue.
pub(super) fn another_cloth(hue: &HueComparison) -> Option<Notice> {
    hue.plainly_different.then_some(Notice::AnotherCloth {
        model_hue_deg: hue.model_hue_deg,
        measured_hue_deg: hue.measured_hue_deg,
        model_chroma: hue.model_chroma.value,
        measured_chroma: hue.measured_chroma.value,
    })
}

/// How many times the `paths` a tilt of this run give BLUE/RED of the model to 5 %, where it is known worse.
pub(super) fn more_paths(paths: usize, ratios: &ColourRatios) -> Option<Notice> {
    /// Relative standard error at which a ratio distinguishes cloths.
    const WELL: f64 = 0.05;
    let relative_se = ratios.blue_over_red.se / ratios.blue_over_red.value.abs();
    let times = (relative_se / WELL).powi(2);
    (!ratios.red_is_zero && relative_se.is_finite() && times > 1.0).then_some(Notice::MorePaths {
        relative_se,
        times,
        paths,
    })
}
