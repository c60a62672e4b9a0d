//! The paper's Darcy operator: a relative velocity v* at the nodes, Eq. (1) with the sign of the body term corrected
//! (`reference-data/paper/errata.md`, 1): `v* = k [ sum V G p + sum rho_w V N (g - a_s) ] / sum n rho_w g V N`.
//!
//! v* is the true relative velocity, the Darcy flux divided by n (errata, 5). In two dimensions it couples only diagonal neighbours,
//! where flow through faces couples cells that share one (`mpm-verify stability` measures what that does).

use super::store::{Nodes, Strip};
use crate::dimension::{basis, internal_force, to_corners};
use crate::observe::Totals;
use crate::particles::WaterPoint;
use crate::real::array_of;
use crate::water::pores::Pores;

/// Relative velocities at the nodes and the sums they come from.
#[derive(Debug, Clone)]
pub struct NodalFlow<const D: usize> {
    /// Whether pressures act where their particles are, and not at the centre of their cell.
    at_particles: bool,
    /// `sum V G p`, N.
    gradient: Vec<[f64; D]>,
    /// `sum V N`, m3.
    volume: Vec<f64>,
    /// `sum n V N`, m3.
    pores: Vec<f64>,
    /// v*, m/s.
    pub relative: [Vec<f64>; 2],
}

impl<const D: usize> NodalFlow<D> {
    /// Nothing flows yet.
    pub fn new(nodes: &Nodes<D>, at_particles: bool) -> Self {
        let count = nodes.frame.length();
        Self {
            at_particles,
            gradient: vec![[0.0; D]; count],
            volume: vec![0.0; count],
            pores: vec![0.0; count],
            relative: [(); 2].map(|()| vec![0.0; count]),
        }
    }

    /// Gathers pressures and pores of the cells.
    fn gather(&mut self, strips: &[Strip<D>], nodes: &Nodes<D>, (pores, grains): (&Pores<D>, &[f64])) {
        let frame = &nodes.frame;
        self.gradient.fill([0.0; D]);
        self.volume.fill(0.0);
        self.pores.fill(0.0);
        for strip in strips {
            for cell in 0..frame.strip {
                let [soil, mass] = strip.volume_and_mass(cell);
                let count = strip.water.count(cell);
                if count == 0 {
                    continue;
                }
                let position = frame.position(strip.first + cell);
                let (mut weighted, mut volumes) = ([[0.0]; 4], [[0.0]; 4]);
                for slot in 0..count {
                    let point: WaterPoint<D> = strip.water.particle(cell, slot);
                    let xi = array_of(|d| point.x[d] * frame.inverse_size - position[d] as f64);
                    let phi = basis::<D, f64>(&xi);
                    for k in 0..1 << D {
                        weighted[k][0] += point.volume * point.pressure * phi[k];
                        volumes[k][0] += point.volume * phi[k];
                    }
                }
                if self.at_particles {
                    let share = soil / volumes[0][0];
                    for k in 0..1 << D {
                        weighted[k][0] *= share;
                        volumes[k][0] *= share;
                    }
                } else {
                    let pressure = weighted[0][0] / volumes[0][0];
                    let centre = basis::<D, f64>(&[0.5; D]);
                    for k in 0..1 << D {
                        volumes[k][0] = soil * centre[k];
                        weighted[k][0] = pressure * volumes[k][0];
                    }
                }
                // sum_wp V G_i p: the force of the pressure alone.
                let isotropic = |moment: f64| [moment, moment, moment, 0.0];
                let first = array_of(|d| isotropic(weighted[1 + d][0]));
                let force = internal_force::<D, f64>(&isotropic(weighted[0][0]), &first, frame.inverse_size);
                let (force, volume) = (to_corners::<D, D, _>(&force), to_corners::<D, 1, _>(&volumes));
                let grains = grains.get(strip.first + cell).copied().unwrap_or(pores.flow.grain_inverse);
                let porosity = 1.0 - mass * grains / soil;
                for a in 0..1 << D {
                    let node = strip.first + cell + frame.offset(a);
                    for d in 0..D {
                        self.gradient[node][d] += force[a][d];
                    }
                    self.volume[node] += volume[a][0];
                    self.pores[node] += porosity * volume[a][0];
                }
            }
        }
    }

    /// Finds v* and records the flow of a step dt (s). `drained` and `closed` visit the nodes of faces that let water out and that do not:
    /// node, axis, outwards.
    pub fn flow(
        &mut self,
        (strips, nodes, pores, grains): (&[Strip<D>], &Nodes<D>, &Pores<D>, &[f64]),
        gravity: &[f64; D],
        faces: impl Iterator<Item = (bool, usize, f64, [usize; 2])> + Clone,
        totals: &mut Totals<D>,
        dt: f64,
    ) {
        self.gather(strips, nodes, (pores, grains));
        let flow = &pores.flow;
        let (mobility, density) = (flow.conductance / nodes.frame.inverse_size, flow.density);
        let body = |node: usize, d: usize| density * (gravity[d] - flow.inertia * nodes.motion.acceleration[d][node]);
        for node in 0..self.volume.len().min(nodes.motion.velocity[0].len()) {
            let (volume, pores) = (self.volume[node], self.pores[node]);
            for d in 0..D {
                // Eq. (1), sign corrected
                let driven = if volume > 0.0 { self.gradient[node][d] + body(node, d) * volume } else { 0.0 };
                self.relative[d][node] = if volume > 0.0 { mobility * driven / pores } else { 0.0 };
            }
        }
        // Undrained: the normal component vanishes (section 3 of the paper).
        for (_, axis, _, nodes) in faces.clone().filter(|(drained, ..)| !drained) {
            nodes.into_iter().for_each(|node| self.relative[axis][node] = 0.0);
        }
        for node in (0..self.volume.len()).filter(|node| self.volume[*node] > 0.0) {
            for d in 0..D {
                let flux = self.relative[d][node] * self.pores[node];
                totals.darcy_dissipation += dt * flux * flux / (mobility * self.volume[node]);
                totals.flow_body_work += dt * flux * body(node, d);
            }
        }
        for (_, axis, outwards, of_face) in faces.filter(|(drained, ..)| *drained) {
            for node in of_face {
                let porosity = self.pores[node] / self.volume[node];
                let out = dt * 0.5 * outwards * porosity * self.relative[axis][node] * flow.area;
                totals.water_out += out.max(0.0);
                totals.water_in -= out.min(0.0);
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let numbers =
            [&self.volume, &self.pores].iter().chain(&self.relative.each_ref()).map(|n| n.capacity()).sum::<usize>();
        numbers * size_of::<f64>() + self.gradient.capacity() * size_of::<[f64; D]>()
    }
}
