//! Drafts, Peirce's geometry and the rejection of invalid cloth.

use specval::cloth::{CentreLine, CentreLineKind, Cloth, ClothError, ClothSpec, Draft, PeirceSegment, System, Weave};

const WEAVES: [(Weave, usize); 4] = [
    (Weave::Plain, 1),
    (Weave::Twill21, 2),
    (Weave::Twill31, 3),
    (Weave::Satin5, 4),
];

#[test]
fn drafts_interlace_once_per_repeat_and_repeat_along_the_twill_line() {
    for (weave, warps_on_top) in &WEAVES {
        let draft = weave.draft();
        let n = draft.yarns(System::Warp);
        assert_eq!(n, draft.yarns(System::Weft));
        assert_eq!(n, warps_on_top + 1);
        let step = if *weave == Weave::Satin5 { 2 } else { 1 };
        for k in 0..n {
            let up = |system| draft.on_top(system, k).iter().filter(|&&up| up).count();
            assert_eq!(up(System::Warp), *warps_on_top, "{weave:?} warp {k}");
            assert_eq!(up(System::Weft), n - warps_on_top, "{weave:?} weft {k}");
            for j in 0..n {
                assert_eq!(draft.warp_on_top(k, j), draft.warp_on_top(k + 1, j + step), "{weave:?}");
                assert_eq!(draft.warp_on_top(k, j), draft.warp_on_top(k + n, j + n));
                assert_eq!(draft.on_top(System::Warp, j)[k], !draft.on_top(System::Weft, k)[j]);
            }
        }
        let rows: Vec<Vec<bool>> = (0..n)
            .map(|i| (0..n).map(|j| draft.warp_on_top(i, j)).collect())
            .collect();
        assert_eq!(Draft::new(&rows), Ok(draft));
    }
}

#[test]
fn satin_has_no_adjacent_interlacings() {
    let draft = Weave::Satin5.draft();
    for i in 0..5 {
        for j in 0..5 {
            let neighbours = [(i + 1, j + 1), (i + 1, j + 4), (i + 1, j), (i, j + 1)];
            if !draft.warp_on_top(i, j) {
                assert!(neighbours.iter().all(|&(a, b)| draft.warp_on_top(a, b)));
            }
        }
    }
}

#[test]
fn invalid_drafts_are_rejected() {
    assert_eq!(Draft::new(&[]), Err(ClothError::EmptyDraft));
    assert_eq!(Draft::new(&[vec![], vec![]]), Err(ClothError::EmptyDraft));
    assert_eq!(
        Draft::new(&[vec![true, false], vec![false]]),
        Err(ClothError::RaggedDraft {
            row: 1,
            expected: 2,
            found: 1
        })
    );
    assert_eq!(
        Draft::new(&[vec![true, true, false], vec![false, true, true]]),
        Err(ClothError::NeverInterlaces {
            system: System::Warp,
            index: 1
        })
    );
    assert_eq!(
        Draft::new(&[vec![true, false], vec![false, true], vec![true, true]]),
        Err(ClothError::NeverInterlaces {
            system: System::Weft,
            index: 2
        })
    );
}

#[test]
fn peirce_equations_are_satisfied() {
    for (p, h, d) in [(0.54, 0.3, 0.6), (0.6, 0.2, 0.5), (2.0, 0.1, 0.7), (1.0, 0.9, 0.95)] {
        let PeirceSegment {
            length_mm: l,
            weave_angle_rad: theta,
        } = PeirceSegment::solve(p, h, d).unwrap();
        let (sin, cos) = theta.sin_cos();
        assert!(((l - d * theta) * cos + d * sin - p).abs() < 1e-14, "p");
        assert!(((l - d * theta) * sin + d * (1.0 - cos) - h).abs() < 1e-14, "h");
        assert!(l - d * theta >= 0.0 && theta > 0.0);
    }
    // Equal yarns that share the crimp jam at √3 diameters and 60°.
    let jam = 3f64.sqrt();
    let tight = PeirceSegment::solve(jam, 1.0, 2.0).unwrap();
    assert!((tight.weave_angle_rad.to_degrees() - 60.0).abs() < 1e-6);
    assert!((PeirceSegment::jam_spacing_mm(1.0, 2.0) - jam).abs() < 1e-15);
    assert_eq!(PeirceSegment::solve(1.732, 1.0, 2.0), None);
}

fn lines(kind: CentreLineKind, weave: &Weave, spacing_mm: f64, radius_sum_mm: f64) -> Vec<CentreLine> {
    let draft = weave.draft();
    [System::Warp, System::Weft]
        .into_iter()
        .flat_map(|system| (0..draft.yarns(system)).map(move |k| (system, k)))
        .map(|(system, k)| CentreLine::new(kind, system, draft.on_top(system, k), spacing_mm, radius_sum_mm).unwrap())
        .collect()
}

#[test]
fn centre_lines_are_periodic_and_smooth_and_match_their_length_integral() {
    let kinds = [CentreLineKind::Peirce, CentreLineKind::Sinusoid { amplitude_mm: 0.2 }];
    for (kind, (weave, _)) in kinds.into_iter().flat_map(|k| WEAVES.iter().map(move |w| (k, w))) {
        for line in lines(kind, weave, 0.54, 0.3) {
            let repeat = line.repeat_mm();
            let n = 4000 * line.crossings();
            let step = repeat / n as f64;
            let mut length = 0.0;
            for k in 0..n {
                let s = (k as f64 + 0.5) * step;
                let (height, slope) = line.height_and_slope(s);
                let (low, high) = (
                    line.height_and_slope(s - 0.5 * step),
                    line.height_and_slope(s + 0.5 * step),
                );
                assert!(
                    (high.0 - low.0 - slope * step).abs() < 1e-8,
                    "slope is the derivative of height"
                );
                assert!((high.1 - low.1).abs() < 0.02, "the tangent does not jump");
                assert!((line.height_and_slope(s - 3.0 * repeat).0 - height).abs() < 1e-12);
                assert!(height.abs() <= line.crest_mm() + 1e-15);
                length += step * 1f64.hypot(slope);
            }
            // Midpoint rule; the second derivative jumps at the ends of arcs.
            assert!(
                (length - line.length_mm()).abs() < 1e-7 * length,
                "{length} {}",
                line.length_mm()
            );
        }
    }
}

#[test]
fn peirce_yarns_touch_at_every_crossing_and_overlap_nowhere() {
    let contact = 0.3;
    for (weave, _) in &WEAVES {
        let draft = weave.draft();
        let all = lines(CentreLineKind::Peirce, weave, 0.54, contact);
        let (warps, wefts) = all.split_at(draft.yarns(System::Warp));
        for (j, warp) in warps.iter().enumerate() {
            for (i, weft) in wefts.iter().enumerate() {
                let (x, y) = ((i as f64 + 0.5) * 0.54, (j as f64 + 0.5) * 0.54);
                let distance = |dx: f64, dy: f64| {
                    let dz = warp.height_and_slope(x + dx).0 - weft.height_and_slope(y + dy).0;
                    (dx * dx + dy * dy + dz * dz).sqrt()
                };
                assert!((distance(0.0, 0.0) - contact).abs() < 1e-14);
                for a in -60..=60 {
                    for b in -60..=60 {
                        let found = distance(0.005 * f64::from(a), 0.005 * f64::from(b));
                        assert!(found >= contact - 1e-13, "{weave:?} warp {j} weft {i}: {found}");
                    }
                }
            }
        }
    }
}

fn refusal(spec: ClothSpec) -> ClothError {
    Cloth::new(&spec).expect_err("this cloth cannot be")
}

#[test]
fn invalid_cloth_is_rejected_with_a_remedy() {
    let jammed = refusal(ClothSpec {
        weft_spacing_mm: 1.732 * 0.3,
        ..ClothSpec::default()
    });
    assert!(
        matches!(
            jammed,
            ClothError::Jammed {
                system: System::Warp,
                crossed: System::Weft,
                ..
            }
        ),
        "{jammed}"
    );
    assert!(
        jammed
            .to_string()
            .contains("increase weft_spacing_mm to at least 0.519615"),
        "{jammed}"
    );

    // A cosine of this amplitude touches at the crossing like Peirce's arc but curves away faster than the yarn it
    // crosses: 0.54² / (π² 0.15) = 0.197 mm instead of 0.3 mm.
    let sinusoid = |amplitude_mm, spacing_mm| ClothSpec {
        centre_line: CentreLineKind::Sinusoid { amplitude_mm },
        warp_spacing_mm: spacing_mm,
        weft_spacing_mm: spacing_mm,
        ..ClothSpec::default()
    };
    match refusal(sinusoid(0.15, 0.54)) {
        ClothError::Overlap {
            first,
            second,
            neighbours: None,
            overlap_mm,
            remedy,
        } => {
            assert_eq!((first.as_str(), second.as_str()), ("warp 0", "weft 0"));
            assert!(overlap_mm > 1e-4 && overlap_mm < 0.05, "{overlap_mm}");
            assert!(remedy.contains("increase the yarn spacings"));
        }
        other => panic!("{other}"),
    }
    // Crossing at heights ±0.1 the axes are 0.2 mm apart at the crossing itself, and at this spacing nowhere closer.
    match refusal(sinusoid(0.1, 2.0)) {
        ClothError::Overlap { overlap_mm, .. } => assert!((overlap_mm - 0.1).abs() < 1e-9, "{overlap_mm}"),
        other => panic!("{other}"),
    }
    assert!(Cloth::new(&sinusoid(0.1501, 0.7)).is_ok());
    assert!(matches!(
        refusal(sinusoid(0.3, 0.5)),
        ClothError::TooCurved {
            system: System::Warp,
            ..
        }
    ));

    let crowded = refusal(ClothSpec {
        weave: Weave::Satin5,
        warp_radius_mm: 0.15,
        weft_radius_mm: 0.01,
        warp_spacing_mm: 0.299,
        ..ClothSpec::default()
    });
    assert!(
        crowded
            .to_string()
            .contains("each warp and the next warp overlap by 0.001 mm"),
        "{crowded}"
    );
    let crowded = refusal(ClothSpec {
        weave: Weave::Satin5,
        repeats: [100, 100],
        ..ClothSpec::default()
    });
    assert!(
        matches!(crowded, ClothError::TooManyCrossings { found: 250_000, .. }),
        "{crowded}"
    );
    for (name, spec) in [
        (
            "warp_radius_mm",
            ClothSpec {
                warp_radius_mm: f64::NAN,
                ..ClothSpec::default()
            },
        ),
        (
            "weft_spacing_mm",
            ClothSpec {
                weft_spacing_mm: -1.0,
                ..ClothSpec::default()
            },
        ),
        ("amplitude_mm", sinusoid(0.0, 0.54)),
    ] {
        assert!(refusal(spec).to_string().starts_with(name));
    }
}

#[test]
fn every_weave_is_valid_with_equal_and_unequal_yarns() {
    for (weave, _) in WEAVES {
        assert!(
            Cloth::new(&ClothSpec {
                weave: weave.clone(),
                ..ClothSpec::default()
            })
            .is_ok()
        );
        let unequal = ClothSpec {
            weave,
            weft_radius_mm: 0.1,
            ..ClothSpec::default()
        };
        assert!(Cloth::new(&unequal).is_ok());
    }
}
