use super::Lab;

/// CIEDE2000 colour difference ΔE₀₀ with k_L = k_C = k_H = 1 (ISO/CIE 11664-6; G. Sharma, W. Wu, E. N. Dalal, Color
/// Res. Appl. 30 (2005) 21, whose equation numbers the comments give).
pub fn delta_e_2000(one: Lab, two: Lab) -> f64 {
    const POW25_7: f64 = 6_103_515_625.0;
    let chroma = |lab: Lab| lab.0[1].hypot(lab.0[2]);
    // (2)-(7)
    let mean_c7 = ((chroma(one) + chroma(two)) / 2.0).powi(7);
    let g = 0.5 * (1.0 - (mean_c7 / (mean_c7 + POW25_7)).sqrt());
    let polar = |lab: Lab| {
        let a = (1.0 + g) * lab.0[1];
        let hue = lab.0[2].atan2(a).to_degrees();
        (a.hypot(lab.0[2]), if hue < 0.0 { hue + 360.0 } else { hue })
    };
    let ((c1, h1), (c2, h2)) = (polar(one), polar(two));
    let (l1, l2) = (one.0[0], two.0[0]);
    // (8)-(11)
    let grey = c1 * c2 == 0.0;
    let dh_deg = match h2 - h1 {
        _ if grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh = 2.0 * (c1 * c2).sqrt() * (dh_deg.to_radians() / 2.0).sin();
    // (12)-(14)
    let (l, c) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);
    let h_deg = match h1 + h2 {
        sum if grey => sum,
        sum if (h1 - h2).abs() <= 180.0 => sum / 2.0,
        sum if sum < 360.0 => (sum + 360.0) / 2.0,
        sum => (sum - 360.0) / 2.0,
    };
    // (15)-(22)
    let cos_deg = |angle_deg: f64| angle_deg.to_radians().cos();
    let t = 1.0 - 0.17 * cos_deg(h_deg - 30.0) + 0.24 * cos_deg(2.0 * h_deg) + 0.32 * cos_deg(3.0 * h_deg + 6.0)
        - 0.20 * cos_deg(4.0 * h_deg - 63.0);
    let turn_deg = 30.0 * (-((h_deg - 275.0) / 25.0).powi(2)).exp();
    let r_c = 2.0 * (c.powi(7) / (c.powi(7) + POW25_7)).sqrt();
    let s_l = 1.0 + 0.015 * (l - 50.0).powi(2) / (20.0 + (l - 50.0).powi(2)).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let r_t = -(2.0 * turn_deg).to_radians().sin() * r_c;
    let (dl, dc, dh) = (dl / s_l, dc / s_c, dh / s_h);
    (dl * dl + dc * dc + dh * dh + r_t * dc * dh).sqrt()
}

/// CMC l:c colour difference of a sample from a standard (F. J. J. Clarke, R. McDonald, B. Rigg, J. Soc. Dyers Colour.
/// 100 (1984) 128; ISO 105-J03). It is not symmetric. Textiles are judged with l = 2, c = 1.
pub fn delta_e_cmc(standard: Lab, sample: Lab, l: f64, c: f64) -> f64 {
    let [l1, a1, b1] = standard.0;
    let [l2, a2, b2] = sample.0;
    let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
    let (dl, dc) = (l2 - l1, c2 - c1);
    let dh2 = ((a2 - a1).powi(2) + (b2 - b1).powi(2) - dc * dc).max(0.0);
    let hue_deg = b1.atan2(a1).to_degrees().rem_euclid(360.0);
    let cos_deg = |angle_deg: f64| angle_deg.to_radians().cos();
    let t = match hue_deg {
        164.0..=345.0 => 0.56 + (0.2 * cos_deg(hue_deg + 168.0)).abs(),
        _ => 0.36 + (0.4 * cos_deg(hue_deg + 35.0)).abs(),
    };
    let c4 = c1.powi(4);
    let f = (c4 / (c4 + 1900.0)).sqrt();
    let s_l = if l1 < 16.0 {
        0.511
    } else {
        0.040975 * l1 / (1.0 + 0.01765 * l1)
    };
    let s_c = 0.0638 * c1 / (1.0 + 0.0131 * c1) + 0.638;
    let s_h = s_c * (f * t + 1.0 - f);
    (dl / (l * s_l)).hypot(dc / (c * s_c)).hypot(dh2.sqrt() / s_h)
}
