//! One pass of the kernel over the strips of cells.

use rayon::prelude::*;

use super::Explicit;
use crate::step::kernel::{Common, InPores, Rare};
use crate::step::store::Nodes;
use crate::water::FaceFlow;

impl<const D: usize> Explicit<D> {
    /// One pass over all particles, on one thread or several.
    pub(super) fn pass(&mut self, moves: bool, dt: f64) {
        let Self {
            kernel,
            scheme,
            body,
            strips,
            nodes,
            of_mesh,
            pressure: [old, new],
            faces,
            soil,
            solver,
            free,
            domains,
            ..
        } = self;
        self.is_stale = false;
        let Nodes { frame, sums, motion, .. } = nodes;
        let coupled = solver.is_some();
        let mapped = self.mapped.as_deref_mut();
        if let Some(free) = free {
            free.tell(frame);
        }
        let water = if let Some(free) = free {
            free.given()
        } else if body.water.is_some() {
            InPores::Particles {
                relative: self.nodal.as_ref().map(|nodal| &nodal.relative),
                rise: solver.as_ref().map(|solver| &solver.rise[..]),
                partly_drained: body.water.as_ref().is_some_and(|water| water.partly_drained),
            }
        } else {
            InPores::None
        };
        let common = &Common {
            frame,
            motion,
            acceleration: if coupled || !scheme.nodal { of_mesh } else { &motion.acceleration },
            water,
            pressure: old,
            conducts: &faces.conducts,
            rare: Rare {
                mapped: mapped.as_ref().map(|mapped| &mapped.motion.velocity),
                ratio: (!faces.ratio[0].is_empty()).then_some(&faces.ratio),
                grains: (!faces.grains.is_empty()).then_some(&faces.grains),
                biot: (!faces.biot[0].is_empty()).then_some([&faces.biot[0], &faces.biot[1]]),
                outflow: (!faces.outflow.is_empty()).then_some(&faces.outflow),
                softness: (!faces.softness.is_empty()).then_some(&faces.softness),
                axis: frame.axis_in_cells,
                found: frame.finds_centroids(scheme.split),
                null_space: body.null_space,
                domains: domains.as_deref(),
            },
            soil,
            moves,
            elastic: body.materials.elastic(),
            materials: &body.materials,
            plastic: body.materials.are_plastic() || body.null_space.is_some(),
            flow: body.water.as_ref().map_or_else(FaceFlow::default, |water| water.flow),
            gravity: body.gravity.unwrap_or([0.0; D]),
            flip: body.flip,
            apart: body.apart,
            kept: self.places,
            coupled,
            dt,
        };
        let cells = &mut new[frame.pad()..][..frame.count()];
        if self.pool.is_some() {
            let cells = cells.par_chunks_mut(frame.strip);
            strips
                .par_iter_mut()
                .zip(sums)
                .zip(cells)
                .for_each(|((strip, sums), cells)| kernel.sweep(strip, sums, cells, common));
        } else {
            let cells = cells.chunks_mut(frame.strip);
            strips
                .iter_mut()
                .zip(sums)
                .zip(cells)
                .for_each(|((strip, sums), cells)| kernel.sweep(strip, sums, cells, common));
        }
        if faces.periodic {
            for [last, first] in frame.seam() {
                new[frame.pad() + last + 1] = new[frame.pad() + first];
                new[frame.pad() + first - 1] = new[frame.pad() + last];
            }
        }
        self.pressure.swap(0, 1);
        self.nodes.merge();
    }
}
