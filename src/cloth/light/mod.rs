//! Light in a woven cloth, the endless weave of smooth tubes: a parallel beam comes in, and light goes on until it has left above
//! or below, or is absorbed.
//!
//! A [`Scene`] is what light meets; each [`Integrator`] is one way to follow it there. [`Bounces`] goes from yarn to yarn by their
//! responses f*, [`Volumetric`] through the media of the yarns; direct light, which a camera's rays see, is `rig::Direct`. What
//! happens in the air is the same for both.

mod air;
mod beam;
mod bounces;
mod connection;
mod detector;
mod integrator;
mod ledger;
mod outer_surface;
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
pub use scene::Scene;
pub use surface::YarnSurface;
pub use view_paths::{Segments, ViewPaths};
pub use volumetric::{Inside, Volumetric};
pub use yarn_to_yarn::YarnToYarn;
