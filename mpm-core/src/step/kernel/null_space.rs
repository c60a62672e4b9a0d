//! The null-space filter: what the mesh does not see of the stresses of particles decays while the soil deforms.
//!
//! Where forces take the stress of a cell at one place, differences between its particles make no force, and nothing takes them back:
//! in soil that flows they grow to several times the stress itself. They are drawn to the mean of the cell, each soil to its own, by
//! `1/(1 + |strain increment|/e)`, so that they fall to 1/e over a strain e whatever the step and the mesh; soil at rest keeps them.
//! The sum of V sigma over a cell, and so every force, stays. A mean of admissible stresses is admissible, since yield surfaces are
//! convex, and has less energy: what is lost is booked with the dissipation of the soil.
//!
//! Sources: Brackbill, *J. Comput. Phys.* 75 (1988) 469-492 (ringing); Gritton & Berzins, *Comput. Part. Mech.* 4 (2017) 131-142
//! (null space of the mapping to the mesh), doi:10.1007/s40571-016-0134-3. Theirs knows no rate; this one has that of the strain.

use pulp::{Simd, WithSimd};

use super::{Cells, FlowedLanes};
use crate::constitutive::{Flow, Law};
use crate::dimension::{mean_stress, strain_increment};
use crate::real::{Real, SimdReal, array};
use crate::step::store::SolidLanes;

/// Velocity gradient that has strained a group of cells (1/s), strain over which differences fall to 1/e, and whether only mean stresses
/// are taken at one place (B-bar).
type Strained<'a, V, const D: usize> = (&'a [[SimdReal<V>; D]; D], f64, bool);

/// The filter at work on a group of cells: a function of its own, beside the kernel that few scenes need it in.
struct Filter<'p, 'a, V: Simd, const D: usize> {
    cells: &'p mut Cells<'a, V, D>,
    group: usize,
    strained: Strained<'p, V, D>,
    flowed: &'p mut FlowedLanes<V>,
}

impl<V: Simd, const D: usize> WithSimd for Filter<'_, '_, V, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) {
        self.cells.draw_together(self.group, self.strained, self.flowed);
    }
}

impl<V: Simd, const D: usize> Cells<'_, V, D> {
    /// Filters the stresses of a group of cells.
    #[inline(always)]
    pub(super) fn filter(&mut self, group: usize, strained: Strained<V, D>, flowed: &mut FlowedLanes<V>) {
        self.simd.vectorize(Filter { cells: self, group, strained, flowed });
    }

    #[inline(always)]
    fn draw_together(&mut self, group: usize, (gradient, strain, split): Strained<V, D>, flowed: &mut FlowedLanes<V>) {
        let none = SimdReal::splat(self.simd, 0.0);
        let size = self.size_of(gradient) * (1.0 / strain);
        let share = size / (size + none.like(1.0));
        for (material, law) in self.common.materials.laws().iter().enumerate() {
            let (mut full, mut sum) = (none, [none; 4]);
            for index in self.strip.solid.range(group) {
                let point = self.point(index);
                let volume = none.or(self.is_apart(&point, index, material), point.volume);
                full += volume;
                let stress = unseen(&point.stress, split);
                for s in 0..4 {
                    sum[s] += volume * stress[s];
                }
            }
            let mean = array!([none; 4], s => sum[s] / full.or_one());
            for index in self.strip.solid.range(group) {
                let mut point = self.point(index);
                let others = self.is_apart(&point, index, material);
                let (before, unseen) = (point.stress, unseen(&point.stress, split));
                for s in 0..4 {
                    let change = none.or(others, (mean[s] - unseen[s]) * share);
                    point.stress[s] += change;
                }
                let lost = law.released_lanes(&before, &point.stress);
                flowed.add(group, point.volume, &Flow { dissipation: lost, residual: none.like(f64::NEG_INFINITY) });
                point.write(self.strip.solid.block_mut(index));
            }
        }
    }

    /// Size of a strain increment: root of the sum of the squares of its components as a tensor.
    #[inline(always)]
    fn size_of(&self, gradient: &[[SimdReal<V>; D]; D]) -> SimdReal<V> {
        let strain = strain_increment(gradient, self.common.dt);
        let mut square = strain[3] * strain[3] * 0.5;
        for s in 0..3 {
            square += strain[s] * strain[s];
        }
        square.root()
    }

    #[inline(always)]
    fn point(&self, index: usize) -> SolidLanes<V, D> {
        SolidLanes::read(self.simd, self.strip.solid.block(index))
    }

    /// Which particles of a block are of another material, in a tension gap, or none.
    #[inline(always)]
    fn is_apart(&self, point: &SolidLanes<V, D>, index: usize, material: usize) -> V::m64s {
        let none = point.mass.like(0.0);
        let is_there = none.below(point.volume);
        let gone = self.simd.or_m64s(point.mass.below(point.volume * self.common.apart), self.simd.not_m64s(is_there));
        let materials = self.common.materials;
        if materials.laws().len() == 1 {
            return gone;
        }
        let mut other = point.mass.like(1.0);
        for lane in 0..V::F64_LANES {
            if usize::from(materials.of(self.strip.solid.ids[index * V::F64_LANES + lane])) == material {
                other.set_lane(lane, 0.0);
            }
        }
        self.simd.or_m64s(gone, none.below(other))
    }
}

/// What of a stress is taken at one place of the cell: all of it, or its mean (B-bar).
#[inline(always)]
fn unseen<V: Simd>(stress: &[SimdReal<V>; 4], split: bool) -> [SimdReal<V>; 4] {
    if !split {
        return *stress;
    }
    let (mean, none) = (mean_stress(stress), stress[0].like(0.0));
    [mean, mean, mean, none]
}
