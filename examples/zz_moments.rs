use specval::cloth::light::*;
use specval::cloth::{Cloth, ClothSpec};
use specval::optics::{Medium, Phase, PhaseTable};
use specval::rig::{omega_in, omega_out};
use specval::spectrum::WavelengthGrid;
use specval::transport::{Cylinder, Roulette};
use specval::yarn::{Estimator, LengthBins, Yarn};
use std::time::Instant;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let (mu_s, g, mu_a, theta_i, particles, batches) = (a[0], a[1], a[2], a[3], a[4] as usize, a[5] as usize);
    let spec = ClothSpec {
        warp_flattening: 3.0,
        weft_flattening: 3.0,
        warp_spacing_mm: 0.765,
        weft_spacing_mm: 0.765,
        ..ClothSpec::default()
    };
    let cloth = Cloth::new(&spec).unwrap();
    let grid = WavelengthGrid::new(vec![550.0]).unwrap();
    let phase =
        Phase::Table(PhaseTable::from_density(257, |c| (1.0 - g * g) / (1.0 + g * g - 2.0 * g * c).powf(1.5)).unwrap());
    let medium = Medium::from_coefficients(&grid, vec![1.557], vec![mu_s], vec![mu_a], vec![phase]).unwrap();
    let yarn = Yarn {
        cylinder: Cylinder::new(0.15).unwrap(),
        medium,
        roulette: Roulette::default(),
        estimator: Estimator::Independent,
    };
    let scene = Scene {
        cloth: &cloth,
        yarns: [&yarn, &yarn],
        backing: None,
        surface: YarnSurface::Lost,
        seed: 1,
    };
    let light = Volumetric::new(scene, particles).unwrap();
    let beam = Beam {
        omega_in: omega_in(theta_i, 0.0),
        number: 7,
    };
    let views: Vec<f64> = vec![-60.0, -30.0, 0.0, 30.0, 60.0, 70.0];
    let bins = LengthBins::logarithmic(0.003, 10.0, 24).unwrap();
    for order in [4usize, 6, 8, 10, 12] {
        let det = RadianceMoments::new(order, bins.clone(), 0.0);
        let t = Instant::now();
        let mut vals = vec![vec![]; views.len()];
        let mut refl = 0.0;
        for b in 0..batches {
            let r = light.batch(&beam, &det, b);
            refl += r.ledger[0][ClothFraction::Reflected] / batches as f64;
            for (v, th) in views.iter().enumerate() {
                let w = det.weights(*th);
                let mut s = 0.0;
                for (k, w) in w.iter().enumerate() {
                    for l in 0..24 {
                        s += w * r.caught[det.places(k, l)[0]][0];
                    }
                }
                vals[v].push(s);
            }
        }
        let dt = t.elapsed().as_secs_f64();
        print!("order {order:2} {dt:6.2}s R {refl:.4}");
        pr(&vals, dt);
    }
    let det = ViewCones::new(views.iter().map(|v| omega_out(*v, 0.0)).collect(), 5f64.to_radians());
    let t = Instant::now();
    let mut vals = vec![vec![]; views.len()];
    for b in 0..batches {
        let r = light.batch(&beam, &det, b);
        for v in 0..views.len() {
            vals[v].push(r.caught[v][0] * std::f64::consts::PI / det.projected_solid_angle(v));
        }
    }
    print!("cones    {:6.2}s         ", t.elapsed().as_secs_f64());
    pr(&vals, 1.0);
}
fn pr(vals: &[Vec<f64>], _dt: f64) {
    for v in vals {
        let n = v.len() as f64;
        let m = v.iter().sum::<f64>() / n;
        let s = (v.iter().map(|x| (x - m).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        print!("  {m:.4}±{s:.4}");
    }
    println!();
}
