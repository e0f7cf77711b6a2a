//! Gloss of a woven cloth of fibres: energy, agreement of both integrators, views against cones and camera rays, and S
//! against Z twist.

use rand::RngExt;
use rayon::prelude::*;
use specval::cloth::light::{
    Beam, ClothBatch, ClothFraction, ClothLedger, Connected, Detector, Scene, Segments, ViewCones, ViewPaths,
    Volumetric, YarnSurface, YarnToYarn,
};
use specval::cloth::{Cloth, ClothSpec};
use specval::geometry::Vec3;
use specval::optics::{Interference, Medium, MediumSpec, fresnel};
use specval::rig::{omega_in, omega_out};
use specval::shading::FibreGloss;
use specval::spectrum::{Spectrum, WavelengthGrid};
use specval::transport::{Cylinder, Estimate, Purpose, Roulette, Stream};
use specval::yarn::{DirectTracer, Effort, Estimator, SurfaceGrid, Yarn, YarnResponse, YarnResponseGrid};
use std::f64::consts::PI;

const BATCHES: usize = 24;
/// |t| of 23 degrees of freedom that one value exceeds with probability 1e-4, and any of 40 with 4e-3.
const LIMIT: f64 = 4.7;
const INDEX: f64 = 1.557;

struct Nothing;

impl Detector for Nothing {
    fn bins(&self) -> usize {
        0
    }

    fn find(&self, _: &Vec3, _: f64, _: impl FnMut(usize, f64)) {}
}

fn gloss(twist_deg: f64, along: f64, across: f64) -> FibreGloss {
    FibreGloss::new(twist_deg.to_radians(), along, across).unwrap()
}

fn yarn(mu_a_per_mm: f64) -> Yarn {
    let spec = MediumSpec {
        host_index: Spectrum::Constant(INDEX),
        particle_index: Spectrum::Constant(1.61),
        particle_kappa: Spectrum::Constant(0.0),
        host_mu_a_per_mm: Spectrum::Constant(mu_a_per_mm),
        particle_diameter_nm: 150.0,
        volume_fraction: 0.14,
        interference: Interference::Independent,
    };
    Yarn {
        cylinder: Cylinder::new(0.15).unwrap(),
        medium: Medium::new(&spec, &WavelengthGrid::new(vec![450.0, 650.0]).unwrap()).unwrap(),
        roulette: Roulette::default(),
        estimator: Estimator::Shared,
    }
}

/// A yarn that absorbs all light that enters it: at most 1e-4 of it is scattered before it is absorbed.
fn black() -> Yarn {
    yarn(1e6)
}

/// The default weave of a yarn and its surface.
struct Weave {
    cloth: Cloth,
    yarn: Yarn,
    surface: YarnSurface,
}

impl Weave {
    fn new(yarn: Yarn, surface: YarnSurface) -> Self {
        Self {
            cloth: Cloth::new(&ClothSpec::default()).unwrap(),
            yarn,
            surface,
        }
    }

    fn volumetric(&self, beam: &Beam, particles: usize) -> Vec<ClothBatch> {
        let scene = Scene {
            cloth: &self.cloth,
            yarns: [&self.yarn; 2],
            backing: None,
            surface: self.surface,
            seed: 1,
        };
        let light = Volumetric::new(scene, particles).unwrap();
        (0..BATCHES)
            .into_par_iter()
            .map(|batch| light.batch(beam, &Nothing, batch))
            .collect()
    }

    /// Bounces with f* from a table of `paths` paths; none for a black yarn.
    fn by_factors<T: Send>(&self, paths: u64, most: usize, of: impl Fn(&YarnToYarn<'_>, usize) -> T + Sync) -> Vec<T> {
        let grid = YarnResponseGrid::new(4, SurfaceGrid::new(12, 4, 8).unwrap()).unwrap();
        (0..BATCHES)
            .into_par_iter()
            .map(|batch| {
                let response = match paths {
                    0 => YarnResponse::zeros(grid, self.yarn.medium.grid().len()),
                    _ => {
                        let effort = Effort::new(1, BATCHES, paths).unwrap();
                        let tracer = DirectTracer::new(&self.yarn, grid, effort, None).unwrap();
                        tracer.batch(batch).response
                    }
                };
                let scatter = response.sampler(&self.yarn).unwrap();
                let light = YarnToYarn {
                    scene: Scene {
                        cloth: &self.cloth,
                        yarns: [&self.yarn; 2],
                        backing: None,
                        surface: self.surface,
                        seed: 1,
                    },
                    scatter: [&scatter; 2],
                    most,
                };
                of(&light, batch)
            })
            .collect()
    }

    /// β of each view at each batch, and the ledgers, of light that met at most `most` yarns after the first.
    fn views(&self, beam: &Beam, cones: &ViewCones, most: usize, particles: usize) -> Vec<Vec<f64>> {
        self.by_factors(0, most, |light, batch| {
            let segments = Segments::new(&self.cloth, 0.02, 0.04);
            let views = cones.views().iter().enumerate();
            let view_paths: Vec<ViewPaths> = views
                .map(|(k, view)| ViewPaths::new(light, &segments, view, k, batch, 100))
                .collect();
            let connected = Connected {
                segments: &segments,
                paths: view_paths.iter().collect(),
                cones,
                sunlit: true,
            };
            let (beta, _) = light.between(beam, &connected, batch, particles);
            beta.iter().map(|beta| beta[0]).collect()
        })
    }
}

fn beam(theta_deg: f64, azimuth_deg: f64) -> Beam {
    Beam {
        omega_in: omega_in(theta_deg, azimuth_deg),
        number: 0,
    }
}

fn estimate(batches: &[ClothBatch], wavelength: usize, of: impl Fn(&ClothLedger) -> f64) -> Estimate {
    Estimate::from_batches(batches.iter().map(|batch| of(&batch.ledger[wavelength])))
}

fn at_view(batches: &[Vec<f64>], k: usize) -> Estimate {
    Estimate::from_batches(batches.iter().map(|batch| batch[k]))
}

fn z(a: Estimate, b: Estimate) -> f64 {
    (a.value - b.value) / a.se.hypot(b.se)
}

/// Ledgers close to the rounding of single precision with both integrators, and without absorption all light traced
/// through the medium leaves. False-alarm rate 4e-4.
#[test]
fn ledgers_close() {
    let fibres = YarnSurface::Fibres(gloss(20.0, 0.1, 0.6));
    let beam = beam(50.0, 20.0);
    let white = Weave::new(yarn(0.0), fibres);
    let traced = white.volumetric(&beam, 1000);
    let scattered = Weave::new(yarn(2.0), fibres).by_factors(10_000, usize::MAX, |light, batch| {
        light.batch(&beam, &Nothing, batch, 300)
    });
    for w in 0..2 {
        for batch in traced.iter().chain(&scattered) {
            assert!(batch.ledger[w].residual().abs() < 1e-9, "{:?}", batch.ledger[w]);
        }
        assert!(
            traced
                .iter()
                .all(|batch| batch.ledger[w][ClothFraction::Absorbed] == 0.0)
        );
        let out = estimate(&traced, w, |l| l[ClothFraction::Reflected] + l.transmitted());
        println!("{:.5} ± {:.5} leaves", out.value, out.se);
        assert!((out.value - 1.0).abs() <= LIMIT * out.se, "{out:?}");
    }
}

/// For black yarns, which only have gloss, both integrators give the same reflectance; fibres without roughness reflect
/// like smooth yarns. False-alarm rate 4e-4 for 4 values.
#[test]
fn black_yarns_reflect_equally_in_both_integrators() {
    let beam = beam(40.0, 25.0);
    let by_factors = |surface, particles| {
        Weave::new(black(), surface).by_factors(0, usize::MAX, |light, batch| {
            light.batch(&beam, &Nothing, batch, particles)
        })
    };
    let fibres = YarnSurface::Fibres(gloss(-30.0, 0.15, 0.6));
    let traced = Weave::new(black(), fibres).volumetric(&beam, 20_000);
    let scattered = by_factors(fibres, 20_000);
    let mirror_like = by_factors(YarnSurface::Fibres(gloss(20.0, 0.001, 0.001)), 20_000);
    let smooth = by_factors(YarnSurface::Smooth, 20_000);
    for (name, a, b) in [
        ("traced, by f*", &traced, &scattered),
        ("without roughness, smooth", &mirror_like, &smooth),
    ] {
        for of in [(|l| l[ClothFraction::Reflected]) as fn(&ClothLedger) -> f64, |l| {
            l[ClothFraction::ThroughYarns]
        }] {
            let [a, b] = [a, b].map(|batches| estimate(batches, 0, of));
            println!("{name}: {:.6} ± {:.6}, {:.6} ± {:.6}", a.value, a.se, b.value, b.se);
            assert!(z(a, b).abs() <= LIMIT, "{name}: {a:?} {b:?}");
        }
    }
}

/// Light reflected by the first yarn, connected from particles of the beam to the views, equals what camera rays give:
/// L = F p E⊥ cosθ_in / cosθ_out at lit points. The variance of the rays is unbounded where cosθ_out is small, but
/// grows only as the logarithm of their number. False-alarm rate 2.4e-3 for 24 values.
#[test]
fn connected_gloss_equals_camera_rays() {
    const RAYS: usize = 4000;
    let gloss = gloss(20.0, 0.15, 0.6);
    let weave = Weave::new(black(), YarnSurface::Fibres(gloss));
    let cones = ViewCones::new(
        (-5..=6).map(|k| omega_out(10.0 * f64::from(k), 25.0)).collect(),
        5f64.to_radians(),
    );
    for theta_deg in [0.0, 40.0] {
        let beam = beam(theta_deg, 25.0);
        let light = beam.omega_in;
        let shown = weave.views(&beam, &cones, 0, 2000);
        let [cell_x, cell_y] = weave.cloth.cell_mm();
        let seen: Vec<Vec<f64>> = (0..BATCHES)
            .into_par_iter()
            .map(|batch| {
                let of_view = |(k, view): (usize, &Vec3)| {
                    let mut rng = Stream::open(1, Purpose::Camera, k, batch, 0);
                    let away = view * (2.0 * weave.cloth.top_mm() / view.z);
                    let mut sum = 0.0;
                    for _ in 0..RAYS {
                        let origin = Vec3::new(rng.random::<f64>() * cell_x, rng.random::<f64>() * cell_y, 0.0) + away;
                        let Some(hit) = weave.cloth.first_hit(origin, -view) else {
                            continue;
                        };
                        let [omega_in, omega_out] = [&light, view].map(|omega| hit.frame.to_local(omega));
                        if omega_in.z > 0.0 && weave.cloth.first_hit(hit.position, light).is_none() {
                            let reflectance = fresnel::reflectance(omega_in.z, INDEX);
                            sum += reflectance * gloss.density(&omega_in, &omega_out) * omega_in.z / omega_out.z;
                        }
                    }
                    PI * sum / (RAYS as f64 * light.z)
                };
                cones.views().iter().enumerate().map(of_view).collect()
            })
            .collect();
        for k in 0..cones.views().len() {
            let [shown, seen] = [&shown, &seen].map(|batches| at_view(batches, k));
            println!(
                "{theta_deg} deg, view {k}: {:.5} ± {:.5} shown, {:.5} ± {:.5} seen",
                shown.value, shown.se, seen.value, seen.se
            );
            assert!(z(shown, seen).abs() <= LIMIT, "{theta_deg} {k}");
        }
    }
}

/// Views count all light exactly once: they equal the light in cones about them. False-alarm rate 7e-4 for 7 values.
#[test]
fn views_count_all_light_once() {
    const PARTICLES: usize = 30_000;
    let weave = Weave::new(black(), YarnSurface::Fibres(gloss(20.0, 0.3, 0.6)));
    let beam = beam(40.0, 25.0);
    let cones = ViewCones::new(
        (-3..=3).map(|k| omega_out(15.0 * f64::from(k), 25.0)).collect(),
        4f64.to_radians(),
    );
    let shown = weave.views(&beam, &cones, usize::MAX, 1000);
    let caught = weave.by_factors(0, usize::MAX, |light, batch| {
        let caught = light.batch(&beam, &cones, batch, PARTICLES).caught;
        let beta = |(k, caught): (usize, &Vec<f64>)| PI * caught[0] / cones.projected_solid_angle(k);
        caught.iter().enumerate().map(beta).collect::<Vec<f64>>()
    });
    for k in 0..cones.views().len() {
        let [shown, caught] = [&shown, &caught].map(|batches| at_view(batches, k));
        println!(
            "view {k}: {:.5} ± {:.5} shown, {:.5} ± {:.5} caught",
            shown.value, shown.se, caught.value, caught.se
        );
        assert!(z(shown, caught).abs() <= LIMIT, "{k}");
    }
}

/// A cloth of S yarns is the mirror image of that of Z yarns, and differs from it. False-alarm rate 6e-4 for 6 values.
#[test]
fn s_twist_is_the_mirror_image_of_z_twist() {
    let of = |twist_deg: f64, omega_in: Vec3, views: Vec<Vec3>| {
        let weave = Weave::new(black(), YarnSurface::Fibres(gloss(twist_deg, 0.1, 0.6)));
        let cones = ViewCones::new(views, 5f64.to_radians());
        weave.views(&Beam { omega_in, number: 0 }, &cones, usize::MAX, 3000)
    };
    let mirror = |d: &Vec3| Vec3::new(d.x, -d.y, d.z);
    let light = omega_in(40.0, 30.0);
    let views: Vec<Vec3> = [-20.0, 10.0, 45.0]
        .into_iter()
        .flat_map(|theta_deg| [30.0, 80.0].map(|azimuth_deg| omega_out(theta_deg, azimuth_deg)))
        .collect();
    let z_twist = of(30.0, light, views.clone());
    let s_twist = of(-30.0, light, views.clone());
    let in_mirror = of(-30.0, mirror(&light), views.iter().map(mirror).collect());
    let mut apart = 0.0f64;
    for k in 0..views.len() {
        let [z_twist, s_twist, in_mirror] = [&z_twist, &s_twist, &in_mirror].map(|batches| at_view(batches, k));
        println!(
            "view {k}: Z {:.5} ± {:.5}, S mirrored {:.5}, S {:.5}",
            z_twist.value, z_twist.se, in_mirror.value, s_twist.value
        );
        assert!(z(z_twist, in_mirror).abs() <= LIMIT, "{k}");
        apart = apart.max(z(z_twist, s_twist).abs());
    }
    assert!(apart > 10.0, "{apart}");
}
