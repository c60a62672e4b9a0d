//! Velocities that particles give back to the nodes once they have theirs of the end of the step, for strains that do not depend on
//! nodes with next to no mass.
//!
//! **Mapped back** (MUSL; Sulsky, Zhou & Schreyer 1995, doi:10.1016/0010-4655(94)00170-7): a node with next to no mass may be
//! accelerated as it likes: what its particles get is `N_i f_i/m_i`, and finite. With velocities of the nodes (USL) the cell
//! of such a node is strained by `f_i/m_i`, and a step that is stable inside the soil is not at its edge.
//!
//! **Affine** (Nakamura, Matsumura & Mizutani 2023, doi:10.1016/j.cma.2022.115720; Jiang, Schroeder & Teran 2017,
//! doi:10.1016/j.jcp.2017.02.050): a particle gives a node its velocity at the place of the node, `v_p + L_p (x_i - x_p)`, L_p its
//! velocity gradient. Without it a node at an edge, whose particles are all on one side of it, gets the
//! velocity of these, and a body that only turns is strained there by as much as it turns.

use pulp::{Simd, WithSimd};

use super::scatter::Scatter;
use super::{Affine, Closing, Common, Contribution, Fields, Functions, Moves, Nodal};
use crate::real::{SimdReal, array};
use crate::step::store::nodes::{SUMS, StripSums};
use crate::step::store::{Motion, SimdCells, SolidLanes, Strip};

/// Masses and momenta of the end of the step from the particles of a strip to the nodes.
pub struct MapBack<'a, F, const D: usize> {
    /// The functions.
    pub functions: F,
    /// The strip.
    pub strip: &'a mut Strip<D>,
    /// What it gives to the nodes.
    pub sums: &'a mut StripSums,
    /// What all strips share.
    pub common: &'a Common<'a, D>,
}

impl<F: Functions<D>, const D: usize> WithSimd for MapBack<'_, F, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let Self { functions, strip, sums, common } = self;
        let strip = strip.vectors(simd);
        let Common { frame, motion: moving, flip, kept, .. } = *common;
        let none = SimdReal::splat(simd, 0.0);
        let (mut motion, mut gathered) = (functions.at_rest(simd), functions.nothing(simd));
        let mut room = [Nodal::splat(simd, 0.0); SUMS];
        let mut scatter = Scatter::<V, D>::begin(simd, F::REACH, sums, frame);
        for group in 0..strip.groups() {
            let SimdCells { position, at: centroid, .. } = strip.cell(group);
            let edges = functions.edges(&position, &frame.cells);
            let at = strip.first + group * V::F64_LANES;
            let Motion { velocity, change, .. } = moving;
            let found = frame.finds_centroids(F::SPLIT);
            let fields = Fields { simd, velocity, change, mapped: None, frame, at, found };
            functions.find_motion(&mut motion, &fields, &edges, &centroid);
            functions.clear(simd, &mut gathered, (false, false));
            for index in strip.solid.range(group) {
                let point = SolidLanes::<V, D>::read(simd, strip.solid.block(index));
                let xi = array!([none; D], d => point.x[d] * frame.inverse_size - position[d]);
                let Moves { change, .. } = functions.moves(&motion, &edges, &xi, frame.inverse_size);
                let v = array!([none; D], d => point.v[d] * flip + change[d]);
                let mut affine = None;
                if kept.affine.is_some() {
                    affine = Some(Affine(functions.gradient_at(&motion, &edges, &xi, frame.inverse_size)));
                }
                let point =
                    Contribution { xi, mass: point.mass, volume: none, v, stress: [none; 4], affine, from_axis: None };
                functions.add(&mut gathered, &edges, &point, (false, false, frame.inverse_size));
            }
            let closing = Closing::of(none);
            let given = functions.finish(&mut gathered, &edges, &closing, frame.inverse_size, &mut room);
            scatter.add(F::REACH, sums, group * V::F64_LANES, given);
        }
        scatter.end(F::REACH, sums, strip.groups() * V::F64_LANES);
    }
}
