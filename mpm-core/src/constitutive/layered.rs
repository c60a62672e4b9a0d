//! Soil in layers: one linear elastic law and one conductivity each, and which particle has which.
//!
//! A step asks [`Laws`] for the law of a particle. Soil with one law everywhere answers with itself and keeps no mark at
//! its particles, so that it pays nothing for the question.

use std::fmt::Debug;

use super::{Law, LinearElastic};

/// Most layers of a scene.
pub const MOST_LAYERS: usize = 8;

/// The laws of a soil with S stress components.
pub trait Laws<const S: usize>: Copy + Send + Sync + 'static {
    /// The law of one particle.
    type One: Law<S>;
    /// What a place keeps of its layer; nothing where there is one law.
    type Mark: Copy + Debug + Send + Sync + 'static;
    /// Whether there are layers.
    const LAYERED: bool;
    /// Mark of the particle that was seeded with a number.
    fn mark_of(&self, id: u32) -> Self::Mark;
    /// Mark of a height above the base, m.
    fn mark_at(&self, height: f64) -> Self::Mark;
    /// Law at a mark.
    fn law(&self, mark: Self::Mark) -> &Self::One;
    /// Hydraulic conductivity at a mark over that of the scene's water.
    fn conductivity(&self, mark: Self::Mark) -> f64;
}

impl<L: Law<S>, const S: usize> Laws<S> for L {
    type One = Self;
    type Mark = ();
    const LAYERED: bool = false;

    #[inline(always)]
    fn mark_of(&self, _: u32) {}

    #[inline(always)]
    fn mark_at(&self, _: f64) {}

    #[inline(always)]
    fn law(&self, (): ()) -> &Self {
        self
    }

    #[inline(always)]
    fn conductivity(&self, (): ()) -> f64 {
        1.0
    }
}

/// Linear elastic layers, from the base up.
#[derive(Debug, Clone, Copy)]
pub struct Layered<const S: usize> {
    layers: [Stratum<S>; MOST_LAYERS],
}

/// One layer.
#[derive(Debug, Clone, Copy)]
pub struct Stratum<const S: usize> {
    /// Its law.
    pub law: LinearElastic<S>,
    /// Its hydraulic conductivity over that of the scene's water.
    pub conductivity: f64,
    /// Its top above the base, m.
    pub top: f64,
    /// Number of the first particle above it, as they were seeded.
    pub end: u32,
}

impl<const S: usize> Layered<S> {
    /// The layers from the base up, at most [`MOST_LAYERS`]; `None` without any.
    pub fn new(layers: &[Stratum<S>]) -> Option<Self> {
        // The last layer goes on for ever: soil that swells stays in it.
        let last = Stratum { top: f64::INFINITY, end: u32::MAX, ..*layers.last()? };
        Some(Self { layers: std::array::from_fn(|i| if i + 1 < layers.len() { layers[i] } else { last }) })
    }

    fn first(&self, below: impl Fn(&Stratum<S>) -> bool) -> u8 {
        self.layers.iter().position(below).unwrap_or(MOST_LAYERS - 1) as u8
    }
}

impl<const S: usize> Laws<S> for Layered<S>
where
    LinearElastic<S>: Law<S>,
{
    type One = LinearElastic<S>;
    type Mark = u8;
    const LAYERED: bool = true;

    #[inline(always)]
    fn mark_of(&self, id: u32) -> u8 {
        self.first(|layer| id < layer.end)
    }

    fn mark_at(&self, height: f64) -> u8 {
        self.first(|layer| height < layer.top)
    }

    #[inline(always)]
    fn law(&self, mark: u8) -> &LinearElastic<S> {
        &self.layers[usize::from(mark)].law
    }

    #[inline(always)]
    fn conductivity(&self, mark: u8) -> f64 {
        self.layers[usize::from(mark)].conductivity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Elastic;

    #[test]
    fn particles_and_heights_find_their_layer() {
        let law = |e| LinearElastic::column(&Elastic { youngs_modulus: e, poisson_ratio: 0.3 });
        let layer = |e, conductivity, top, end| Stratum { law: law(e), conductivity, top, end };
        let layers = [layer(1.0, 1.0, 0.3, 6), layer(2.0, 10.0, 0.5, 10), layer(4.0, 0.1, 1.0, 20)];
        let soil = Layered::new(&layers).expect("layers");
        let by_id = [0, 5, 6, 9, 10, 19, 25].map(|id| soil.conductivity(soil.mark_of(id)));
        assert_eq!(by_id, [1.0, 1.0, 10.0, 10.0, 0.1, 0.1, 0.1]);
        let by_height = [0.0, 0.29, 0.31, 0.49, 0.51, 1.2].map(|y| soil.conductivity(soil.mark_at(y)));
        assert_eq!(by_height, [1.0, 1.0, 10.0, 10.0, 0.1, 0.1]);
        let stress = |y| {
            let mut stress = [0.0; 2];
            soil.law(soil.mark_at(y)).update(&mut stress, &[-1.0, 0.0]);
            stress[0]
        };
        assert!((stress(0.9) / stress(0.1) - 4.0).abs() < 1e-12);
        assert!(Layered::<2>::new(&[]).is_none());
    }
}
