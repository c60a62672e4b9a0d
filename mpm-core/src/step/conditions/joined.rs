//! Nodes that move as one: both ends of a row that is periodic, and nodes too light to move alone.
//!
//! What was gathered at a follower is added to its leader before the equation of motion, and the follower, then without
//! mass, is given the leader's motion afterwards: masses, momenta and forces are kept, and the balances count each once.

use super::{Condition, Soil, Supports};
use crate::observe::Totals;
use crate::real::array;
use crate::step::store::nodes::{SOLID_MASS, sums};
use crate::step::store::{Frame, Nodes};

/// Neighbours of a node, the nearest first: of those that weigh the same the first one leads, in the mirror, too.
const AROUND: [[isize; 2]; 8] = [[0, -1], [0, 1], [-1, 0], [1, 0], [-1, -1], [1, -1], [-1, 1], [1, 1]];
/// Masses that differ by this share are the same.
const TIE: f64 = 1e-9;

/// Nodes that move with others.
#[derive(Debug, Clone)]
pub struct Joined<const D: usize> {
    /// Follower and leader of a periodic mesh: right and left.
    across: Vec<[u32; 2]>,
    /// Nodes lighter than this follow a heavier neighbour, kg in a mesh 1 m thick.
    least_mass: f64,
    frame: Frame<D>,
    /// Directions in which a node is fixed, one bit each; empty if no node follows for its mass.
    held: Vec<u8>,
    /// Followers and leaders of this step, for their mass.
    light: Vec<[u32; 2]>,
    /// Whom each node follows, itself if none; empty if no node follows for its mass.
    leader_of: Vec<u32>,
    /// From a node to the one above it, and nodes of a row that are not the same place.
    width: usize,
    across_cells: usize,
}

impl<const D: usize> Joined<D> {
    /// Joins left and right if the mesh is `periodic`, and nodes lighter than `least_mass` (kg, zero for none) to others. There are
    /// so many functions along each axis of the mesh.
    pub fn new(frame: &Frame<D>, along: &[usize; D], held: &Supports<D>, periodic: bool, least_mass: f64) -> Self {
        let at = |column: usize, row: usize| frame.function(&array!([row; D], d => if d == 0 { column } else { row }));
        let rows = if periodic && D == 2 { along[D - 1] } else { 0 };
        let across = (0..rows).map(|row| [at(along[0] - 1, row), at(0, row)].map(|node| node as u32)).collect();
        let mut sides = vec![0; if least_mass > 0.0 { frame.count() } else { 0 }];
        for d in (0..D).filter(|_| least_mass > 0.0) {
            held.along(d).for_each(|node| sides[node] |= 1 << d);
        }
        let leader_of = (0..sides.len() as u32).collect();
        let width = if D == 1 { frame.count() } else { frame.stride[D - 1] };
        let across_cells = along[0] - 1;
        Self { across, least_mass, frame: *frame, held: sides, light: Vec::new(), leader_of, width, across_cells }
    }

    /// Finds who follows whom.
    fn find(&mut self, nodes: &Nodes<D>) {
        self.light.clear();
        let mut light = std::mem::take(&mut self.light);
        nodes.each_reached(SOLID_MASS, |node, mass| {
            if mass > 0.0 && mass < self.least_mass * self.frame.thickness(0, node) {
                let leader = self.leader(node, nodes);
                light.extend(leader.map(|leader| [node as u32, leader as u32]));
            }
        });
        self.light = light;
        // A leader that is light itself may follow another: every one of its followers then does.
        for &[follower, leader] in &self.light {
            self.leader_of[follower as usize] = leader;
        }
        for pair in &mut self.light {
            while self.leader_of[pair[1] as usize] != pair[1] {
                pair[1] = self.leader_of[pair[1] as usize];
            }
        }
        for &[follower, _] in &self.light {
            self.leader_of[follower as usize] = follower;
        }
    }

    /// The heaviest neighbour that is fixed wherever the node is: one that is not light itself, or else, around a particle
    /// that flies alone, one that is heavier than the node. Such a particle then moves as a whole, which cannot strain it.
    fn leader(&self, node: usize, nodes: &Nodes<D>) -> Option<usize> {
        let (width, count) = (self.width as isize, self.held.len() as isize);
        let mass = |node: usize| nodes.sum(SOLID_MASS, node);
        let (x, row, mut best) = (node as isize % width, node as isize / width, node);
        // Of nodes that weigh the same the one with the lower number leads, so that none leads its own leader.
        let weight = |node: usize| (mass(node), std::cmp::Reverse(node));
        for [i, j] in AROUND {
            // Beyond the seam of a periodic mesh is its other side.
            let column = if self.across.is_empty() { x + i } else { (x + i).rem_euclid(self.across_cells as isize) };
            let neighbour = (row + j) * width + column;
            if !(0..width).contains(&column) || !(0..count).contains(&neighbour) {
                continue;
            }
            let (neighbour, held) = (neighbour as usize, self.held[node]);
            let heavier = best == node || mass(neighbour) > (1.0 + TIE) * mass(best);
            if self.held[neighbour] & held == held && weight(neighbour) > weight(node) && heavier {
                best = neighbour;
            }
        }
        (best != node).then_some(best)
    }
}

impl<const D: usize> Condition<D> for Joined<D> {
    fn gathered(&mut self, nodes: &mut Nodes<D>, _: &dyn Soil<D>) {
        for pair in &self.across {
            give(nodes, pair);
        }
        if self.least_mass > 0.0 {
            self.find(nodes);
            self.light.iter().for_each(|pair| give(nodes, pair));
        }
        nodes.pairs.clear();
        nodes.pairs.extend(self.across.iter().chain(&self.light));
    }

    fn followed(&mut self, nodes: &mut Nodes<D>, _: &dyn Soil<D>, _: &mut Totals<D>, _: f64) {
        let motion = &mut nodes.motion;
        self.hold_in([&mut motion.velocity, &mut motion.change, &mut motion.acceleration]);
    }

    fn join(&self, nodes: &mut Nodes<D>) {
        self.across.iter().chain(&self.light).for_each(|pair| give(nodes, pair));
    }

    fn hold(&self, nodes: &mut Nodes<D>) {
        self.hold_in([&mut nodes.motion.velocity]);
    }
}

impl<const D: usize> Joined<D> {
    /// Gives fields of the leaders to their followers.
    fn hold_in<const N: usize>(&self, fields: [&mut [Vec<f64>; 2]; N]) {
        for field in fields {
            for along in field.iter_mut().take(D) {
                // A leader across may be a follower for its mass: that is known first.
                for &[follower, leader] in self.light.iter().chain(&self.across) {
                    along[follower as usize] = along[leader as usize];
                }
            }
        }
    }
}

/// Gives the sums of a follower to its leader.
fn give<const D: usize>(nodes: &mut Nodes<D>, &[follower, leader]: &[u32; 2]) {
    for q in 0..sums(D) {
        let sum = std::mem::take(nodes.sum_mut(q, follower as usize));
        *nodes.sum_mut(q, leader as usize) += sum;
    }
}
