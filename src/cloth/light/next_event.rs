use super::Detector;
use super::air::Air;
use super::refracted::Refracted;
use crate::cloth::{Cloth, System};
use crate::geometry::Vec3;
use crate::optics::Medium;
use crate::transport::{Collision, Exit};
use rand::Rng;

/// Views to which one scattering event is connected: all in turn would cost more than the variance it saves.
const VIEWS_AN_EVENT: usize = 4;
/// Share of the optical depth below the surface with whose exponential the chance of a connection falls: events deep
/// inside contribute little.
const DEPTH_SHARE: f64 = 0.5;
/// Distance, in units of the length inside, within which two ways leave at the same point.
const SAME: f64 = 1e-4;

/// Next-event estimation inside yarns: connects scattering events to views through the yarn's smooth surface, at one
/// wavelength. Each event adds its light to the views, where a cone of 5° would catch one path of about 130.
///
/// [`Refracted::find`] decides which light is connected: the way from the event to a view that it finds. Light of a
/// path that leaves by the way that it finds from the path's last event is left to the connections; light on any other
/// way is scored as it leaves. So every way counts once, whether or not the search finds all.
pub(super) struct NextEvent<'a> {
    pub cloth: &'a Cloth,
    pub system: System,
    pub medium: &'a Medium,
    /// Index of the wavelength in the medium's grid.
    pub wavelength: usize,
    /// Unit vectors towards the views.
    pub views: &'a [Vec3],
}

impl NextEvent<'_> {
    fn index(&self) -> f64 {
        self.medium.host_index()[self.wavelength]
    }

    fn way(&self, from: Vec3, towards: Vec3) -> Option<Refracted> {
        Refracted::find(self.cloth, self.system, self.index(), from, towards)
    }

    /// Whether connections of the last scattering event include the light that leaves here.
    pub fn cover(&self, exit: &Exit<'_>) -> bool {
        let Some(from) = exit.scattered_at.filter(|_| !self.views.is_empty()) else {
            return false;
        };
        let found = self.way(from, exit.direction);
        found.is_some_and(|way| (way.position - exit.position).norm() < SAME * way.length_mm)
    }

    /// Adds the light of an event to the views. `length_mm`: path length in yarns before this one.
    pub fn connect<D: Detector, R: Rng>(&self, event: &Collision, length_mm: f64, air: &mut Air<'_, D, R>) {
        let w = self.wavelength;
        let extinction = self.medium.mu_s_per_mm()[w] + self.medium.mu_a_per_mm()[w];
        let (_, normal) = self.cloth.surface(self.system, event.position.into());
        // Along the gradient: no shorter than the depth, and finite deep inside, where the gradient vanishes.
        let depth_mm = (self.cloth).inside_distance(self.system, event.position.into(), normal, f64::INFINITY);
        let chance = (-DEPTH_SHARE * extinction * depth_mm).exp();
        // Written so that NaN, on the axis of a yarn, goes on with certainty.
        if air.random() >= chance {
            return;
        }
        let chance = if chance.is_nan() { 1.0 } else { chance };
        let views = self.views.len();
        let taken = views.min(VIEWS_AN_EVENT);
        let spacing = views as f64 / taken as f64;
        let start = air.random();
        for k in 0..taken {
            let view = (((start + k as f64) * spacing) as usize).min(views - 1);
            let towards = self.views[view];
            let Some(way) = self.way(event.position, towards) else {
                continue;
            };
            if self.cloth.first_hit(way.position, towards).is_some() {
                continue;
            }
            let scattered = self.medium.phase(w).pdf(event.direction.dot(&way.direction));
            let reaches = way.transmittance * way.solid_angle_ratio * (-extinction * way.length_mm).exp();
            let per_steradian = event.weight * scattered * reaches * spacing / chance;
            air.see(view, length_mm + event.length_mm + way.length_mm, per_steradian);
        }
    }
}
