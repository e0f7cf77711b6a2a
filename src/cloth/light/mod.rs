//! Light in a woven cloth, an endless weave of smooth tubes. Light of a parallel beam is traced until it leaves above
//! or below the cloth or is absorbed.
//!
//! A [`Scene`] describes cloth, yarns and backing; each [`Integrator`] is one method to trace light in it. [`Bounces`]
//! traces from yarn to yarn by their responses f*, [`Volumetric`] through the media of the yarns; both share the
//! tracing in the air. Direct light at the ends of camera rays is `rig::Direct`.

mod air;
mod beam;
mod bounces;
mod connection;
mod detector;
mod integrator;
mod ledger;
mod outer_surface;
mod radiance_moments;
mod scene;
mod specular;
mod surface;
mod view_paths;
mod volumetric;
mod yarn_to_yarn;

pub use beam::{Beam, ClothBatch, LitBatch, LitViews};
pub use bounces::Bounces;
pub use connection::Connected;
pub use detector::{Detector, HemisphereNodes, ViewCones};
pub use integrator::Integrator;
pub use ledger::{ClothFraction, ClothLedger};
pub use radiance_moments::RadianceMoments;
pub use scene::Scene;
pub use surface::YarnSurface;
pub use view_paths::{Segments, ViewPaths};
pub use volumetric::{Inside, Volumetric};
pub use yarn_to_yarn::YarnToYarn;
