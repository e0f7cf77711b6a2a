//! What makes the numbers of a study doubtful, before or after it is run.

use super::{Plan, RunError, Stage};
use crate::colour::ColourError;
use crate::report::Notice;
use crate::spectrum::plausibility;
use crate::study::{Study, StudyError};

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
    let old_key = |words: &String| Notice::OldKey { words: words.clone() };
    let mut notices: Vec<Notice> = study.origin.notices().iter().map(old_key).collect();
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
