//! Designs of sweeps: what their points cover.

use specval::fit::{Axis, Design};

fn axes(words: &[&str]) -> Vec<Axis> {
    words.iter().map(|word| word.parse().unwrap()).collect()
}

/// Numbers of points in equal strata of 0 to 1.
fn strata(values: impl Iterator<Item = f64>, count: usize) -> Vec<usize> {
    let mut strata = vec![0; count];
    values.for_each(|value| strata[(value * count as f64) as usize] += 1);
    strata
}

#[test]
fn a_grid_has_every_combination_once() {
    let points = Design::Grid
        .points(&axes(&["a=1:100:3:log", "b=0:1:2", "c=7,5"]), 1)
        .unwrap();
    assert_eq!(points.len(), 12);
    for (place, point) in points.iter().enumerate() {
        let expected = [
            [1.0, 10.0, 100.0][place / 4],
            [0.0, 1.0][place / 2 % 2],
            [7.0, 5.0][place % 2],
        ];
        assert!(
            std::iter::zip(point, expected).all(|(a, b)| (a - b).abs() < 1e-12),
            "{point:?}"
        );
    }
}

#[test]
fn a_latin_hypercube_and_a_sobol_sequence_have_a_point_in_each_stratum_of_each_axis() {
    let of = axes(&["a=0:1", "b=0:1", "c=0:1"]);
    for design in [Design::LatinHypercube { points: 64 }, Design::Sobol { points: 64 }] {
        let points = design.points(&of, 3).unwrap();
        for axis in 0..3 {
            assert_eq!(
                strata(points.iter().map(|point| point[axis]), 64),
                [1; 64],
                "{design:?} {axis}"
            );
        }
        assert_eq!(points, design.points(&of, 3).unwrap());
        assert_ne!(points, design.points(&of, 4).unwrap());
        // Columns are not one another's.
        assert!(points.iter().any(|point| (point[0] - point[1]).abs() > 0.3));
    }
    // Sobol points of two axes fill squares evenly too.
    let points = Design::Sobol { points: 64 }.points(&of, 3).unwrap();
    let cell = |point: &Vec<f64>| ((point[0] * 4.0).floor() + (point[1] * 4.0).floor() / 4.0) / 4.0;
    let cells = strata(points.iter().map(cell), 16);
    assert_eq!(cells, [4; 16]);
}

#[test]
fn values_of_whole_keys_are_whole_and_lists_stay() {
    let ranged = axes(&["trace.batches=2:9:4"]).remove(0).in_steps_of(1);
    let points = Design::Grid.points(&[ranged], 1).unwrap();
    assert_eq!(points, [[2.0], [4.0], [7.0], [9.0]]);
    let open = axes(&["trace.z_cells=3:9"]).remove(0).in_steps_of(2);
    let points = Design::LatinHypercube { points: 50 }.points(&[open], 1).unwrap();
    assert!(
        points
            .iter()
            .all(|point| point[0] % 2.0 == 0.0 && (4.0..=10.0).contains(&point[0]))
    );
    let listed = axes(&["trace.z_cells=3,5"]).remove(0).in_steps_of(2);
    assert_eq!(Design::Grid.points(&[listed], 1).unwrap(), [[3.0], [5.0]]);
}
