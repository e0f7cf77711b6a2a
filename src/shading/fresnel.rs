/// Unpolarised reflectance of a smooth dielectric surface (Fresnel): `cos_i` from 0 to 1, `eta` = n_t / n_i > 0.
/// Total internal reflection gives 1.
pub fn reflectance(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}
