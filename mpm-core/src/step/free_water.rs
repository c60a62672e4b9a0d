//! Water with a free surface beside the step of the soil: what this feels of it, and how the water follows its motion.

use pulp::Simd;

use super::Fault;
use super::conditions::Condition;
use super::kernel::InPores;
use super::store::{Frame, Nodes, Strip};
use crate::grid::Grid;
use crate::water::{AdvectedWater, Pushed};

/// The water and what the soil feels of it. Nodes have the numbers of the mesh, which those of functions of one cell are.
#[derive(Debug)]
pub struct FreeWater<const D: usize> {
    /// The water.
    pub carried: AdvectedWater<D>,
    /// What the soil of each cell feels, by the numbers of the frame: see [`InPores::Given`].
    felt: [Vec<f64>; 4],
    /// 1/kg of each node and direction; zero where something holds it.
    inverse: Vec<[f64; D]>,
    /// The node that each node moves with, itself if none.
    leader: Vec<u32>,
}

impl<const D: usize> FreeWater<D> {
    /// Beside a mesh.
    pub fn new(carried: AdvectedWater<D>, grid: &Grid<D>, frame: &Frame<D>) -> Self {
        let nodes = grid.node_count();
        let mut water = Self {
            carried,
            felt: std::array::from_fn(|_| vec![0.0; frame.length()]),
            inverse: vec![[0.0; D]; nodes],
            leader: vec![0; nodes],
        };
        water.tell(grid, frame);
        water
    }

    /// Takes over what the soil feels.
    pub fn tell(&mut self, grid: &Grid<D>, frame: &Frame<D>) {
        for (cell, position) in grid.walk() {
            let number = frame.number(&position);
            self.felt.iter_mut().zip(self.carried.given(cell)).for_each(|(felt, given)| felt[number] = given);
        }
    }

    /// What the soil feels.
    pub fn given(&self) -> InPores<'_> {
        let [pressure, per_volume, lower, middle] = &self.felt;
        InPores::Given { pressure, per_volume, lower, middle }
    }

    /// Lets the pressures of a step dt (s) act on the motion of the nodes, and the water follow it. `keeps` is what damping keeps of
    /// a velocity; the stress of a cell may act at the centroid of its particles.
    ///
    /// # Errors
    /// Where and what went wrong.
    pub fn press<V: Simd>(
        &mut self,
        (grid, strips): (&Grid<D>, &[Strip<V, D>]),
        nodes: &mut Nodes<D>,
        conditions: &[Box<dyn Condition<D>>],
        (keeps, at_centroid): (f64, bool),
        dt: f64,
    ) -> Result<(), Fault> {
        let Self { carried, inverse, leader, .. } = self;
        for (cell, position) in grid.walk() {
            let number = nodes.frame.number(&position);
            let (strip, cell_of_strip) = (&strips[number / nodes.frame.strip], number % nodes.frame.strip);
            let [volume, _] = strip.volume_and_mass(cell_of_strip);
            carried.note(cell, volume, at_centroid.then(|| strip.centroid(cell_of_strip)));
        }
        for (node, (inverse, leader)) in inverse.iter_mut().zip(&mut *leader).enumerate() {
            let mass = nodes.mixture_mass(node);
            *inverse = [if mass > 0.0 { keeps / mass } else { 0.0 }; D];
            *leader = node as u32;
        }
        conditions.iter().for_each(|condition| condition.each_held(&mut |node, axis| inverse[node][axis] = 0.0));
        for [follower, first] in &nodes.pairs {
            leader[*follower as usize] = *first;
        }
        let pushed = Pushed { grid, inverse, leader };
        carried.press(grid, &pushed, &mut nodes.motion, dt).map_err(|(place, what)| Fault { place, what })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let felt = self.felt.iter().map(Vec::capacity).sum::<usize>() * size_of::<f64>();
        self.carried.bytes() + felt + self.inverse.capacity() * size_of::<[f64; D]>()
    }
}
