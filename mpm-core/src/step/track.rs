//! What failing soil is followed by: displacement and deviator strain.

use crate::dimension::{Gradient, Kinematics};
use crate::keep::Keeper;
use crate::particles::{Layer, SolidPoint};

/// Particles by their numbers, since counting began.
#[derive(Debug, Clone)]
pub struct Track<const D: usize, const S: usize> {
    /// Where they were, m.
    pub origin: Vec<[f64; D]>,
    /// Strain (tensor components in the order of the stress, turned with the soil).
    pub strain: Vec<[f64; S]>,
}

impl<const D: usize, const S: usize> Track<D, S> {
    /// Begins to count.
    pub fn new(solid: &Layer<SolidPoint<D, S>, D>) -> Self {
        let mut origin = vec![[0.0; D]; solid.points.len()];
        for (point, id) in solid.points.iter().zip(&solid.ids) {
            origin[*id as usize] = point.x;
        }
        Self { strain: vec![[0.0; S]; origin.len()], origin }
    }

    /// Adds the strain of a particle in a step.
    #[inline(always)]
    pub fn stretch<K: Kinematics<D, S>>(&mut self, id: u32, gradient: &Gradient<D>, dt: f64) {
        let strain = &mut self.strain[id as usize];
        K::rotate(strain, gradient, dt);
        let more = K::strain_increment(gradient, dt);
        for s in 0..S {
            // Engineering shear is twice the component of the tensor.
            strain[s] += if s >= 3 { 0.5 * more[s] } else { more[s] };
        }
    }

    /// Deviator strain sqrt(2/3 e:e) of a particle.
    pub fn deviator(&self, id: u32) -> f64 {
        let strain = &self.strain[id as usize];
        let normal = 3.min(S);
        let mean = strain[..normal].iter().sum::<f64>() / 3.0;
        let mut sum: f64 = (0..3).map(|s| (if s < normal { strain[s] } else { 0.0 } - mean).powi(2)).sum();
        sum += strain[normal..].iter().map(|shear| 2.0 * shear * shear).sum::<f64>();
        (2.0 / 3.0 * sum).sqrt()
    }

    /// Writes or reads the state.
    pub fn keep(&mut self, keeper: &mut Keeper) {
        keeper.entries(&mut self.origin, |x, keeper| keeper.f64s(x));
        keeper.entries(&mut self.strain, |e, keeper| keeper.f64s(e));
    }
}
