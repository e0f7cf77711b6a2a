/// Progress callback; receives increments that add up to 1.
pub type Progress<'a> = &'a (dyn Fn(f64) + Sync);
