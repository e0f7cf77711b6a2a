//! Light between yarns at the views by next-event estimation, compared with particles that leave the cloth inside cones
//! about the views.

use rayon::prelude::*;
use specval::cloth::light::{Beam, Connected, Scene, Segments, ViewCones, ViewPaths, YarnSurface, YarnToYarn};
use specval::cloth::{Cloth, ClothSpec};
use specval::geometry::Vec3;
use specval::optics::{Interference, Medium, MediumSpec};
use specval::rig::{omega_in, omega_out};
use specval::shading::FibreGloss;
use specval::spectrum::{Spectrum, WavelengthGrid};
use specval::transport::{Cylinder, Estimate, Roulette};
use specval::yarn::{DirectTracer, Effort, Estimator, SurfaceGrid, Yarn, YarnResponseGrid};

const BATCHES: usize = 24;
/// |t| of 23 degrees of freedom that any of 60 values exceeds with probability 1e-3.
const LIMIT: f64 = 5.2;
const VIEWS_DEG: [f64; 5] = [-50.0, -20.0, 0.0, 40.0, 65.0];
const PARTICLES: usize = 16_000;

fn yarn(host_mu_a_per_mm: f64) -> Yarn {
    let spec = MediumSpec {
        host_index: Spectrum::Constant(1.557),
        particle_index: Spectrum::Constant(1.61),
        particle_kappa: Spectrum::Constant(0.0),
        host_mu_a_per_mm: Spectrum::Constant(host_mu_a_per_mm),
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

struct Case {
    spec: ClothSpec,
    yarn: Yarn,
    backing: Option<[f64; 2]>,
    surface: YarnSurface,
}

/// β of each batch, [batch][view × wavelength]: from all light in the cones, and from connections, without the light
/// that the first yarn scatters straight to the views.
fn brightness(case: &Case, most: usize) -> [Vec<Vec<f64>>; 2] {
    let cloth = Cloth::new(&case.spec).unwrap();
    let grid = YarnResponseGrid::new(6, SurfaceGrid::new(24, 6, 12).unwrap()).unwrap();
    let tracer = DirectTracer::new(&case.yarn, grid, Effort::new(1, 2, 200_000).unwrap(), None).unwrap();
    let traced = tracer.batch(0);
    let scatter = traced.response.sampler(&case.yarn).unwrap();
    let light = YarnToYarn {
        scene: Scene {
            cloth: &cloth,
            yarns: [&case.yarn; 2],
            backing: case.backing.as_ref().map(|b| &b[..]),
            surface: case.surface,
            seed: 1,
        },
        scatter: [&scatter; 2],
        most,
    };
    let beam = Beam {
        omega_in: omega_in(30.0, 0.0),
        number: 0,
    };
    let views: Vec<Vec3> = VIEWS_DEG.iter().map(|v| omega_out(*v, 0.0)).collect();
    let cones = ViewCones::new(views.clone(), 5f64.to_radians());
    let segments = Segments::new(&cloth, 0.02, 0.04);
    let of_cones = |batch| -> Vec<f64> {
        let caught = light.batch(&beam, &cones, batch, PARTICLES).caught;
        let per = |k| std::f64::consts::PI / cones.projected_solid_angle(k);
        (caught.iter().enumerate())
            .flat_map(|(k, caught)| caught.iter().map(move |c| c * per(k)))
            .collect()
    };
    let of_views = |batch| -> Vec<f64> {
        let view_paths: Vec<ViewPaths> = (views.iter().enumerate())
            .map(|(k, view)| ViewPaths::new(&light, &segments, view, k, batch, 900))
            .collect();
        let connected = Connected {
            segments: &segments,
            paths: view_paths.iter().collect(),
            cones: &cones,
            sunlit: true,
        };
        light.between(&beam, &connected, batch, PARTICLES / 8).0.concat()
    };
    [
        (0..BATCHES).into_par_iter().map(of_cones).collect(),
        (0..BATCHES).into_par_iter().map(of_views).collect(),
    ]
}

fn compare(name: &str, cones: &[Vec<f64>], views: &[Vec<f64>]) {
    for k in 0..cones[0].len() {
        let of = |batches: &[Vec<f64>]| Estimate::from_batches(batches.iter().map(|batch| batch[k]));
        let (a, b) = (of(cones), of(views));
        println!(
            "{name} {k}: cones {:.4} ± {:.4}, views {:.4} ± {:.4}",
            a.value, a.se, b.value, b.se
        );
        assert!(
            (a.value - b.value).abs() <= LIMIT * a.se.hypot(b.se),
            "{name} {k}: {a:?} {b:?}"
        );
    }
}

fn less(all: &[Vec<f64>], part: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let each = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    all.iter().zip(part).map(each).collect()
}

/// Light that met two yarns or more. White round yarns; yarns of fibres; flat glossy yarns on a grey backing.
#[test]
fn connections_agree_with_cones_for_bounces() {
    let flat = ClothSpec {
        warp_flattening: 1.3,
        weft_flattening: 1.2,
        warp_spacing_mm: 0.66,
        weft_spacing_mm: 0.66,
        ..ClothSpec::default()
    };
    let fibres = YarnSurface::Fibres(FibreGloss::new(0.3, 0.3, 0.6).unwrap());
    for (name, spec, backing, surface) in [
        ("round", ClothSpec::default(), None, YarnSurface::Lost),
        ("fibres", ClothSpec::default(), None, fibres),
        ("flat", flat, Some([0.3, 0.9]), YarnSurface::Smooth),
    ] {
        let case = Case {
            spec,
            yarn: yarn(0.3),
            backing,
            surface,
        };
        let [cones, views] = brightness(&case, usize::MAX);
        let [cones_first, views_first] = brightness(&case, 0);
        compare(name, &less(&cones, &cones_first), &less(&views, &views_first));
    }
}

/// Nearly black glossy yarns on a white backing: all light comes from surfaces and the backing.
#[test]
fn connections_agree_with_cones_for_gloss_and_backing() {
    let case = Case {
        spec: ClothSpec::default(),
        yarn: yarn(2000.0),
        backing: Some([0.4, 1.0]),
        surface: YarnSurface::Smooth,
    };
    let [cones, views] = brightness(&case, usize::MAX);
    compare("black", &cones, &views);
}
