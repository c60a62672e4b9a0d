//! Water with a free surface beside the step of the soil: what this feels of it, and how the water follows its motion.

use super::Fault;
use super::conditions::Condition;
use super::kernel::InPores;
use super::store::nodes::MIXTURE_MASS;
use super::store::{Frame, Nodes, Strip};
use crate::grid::Grid;
use crate::water::{AdvectedWater, Pressures, Pushed};

/// The water and what the soil feels of it. Nodes have the numbers of the mesh, which those of functions of one cell are.
#[derive(Debug)]
pub struct FreeWater<const D: usize> {
    /// The water.
    pub carried: AdvectedWater<D>,
    /// What the soil of each cell feels, by the numbers of the frame: see [`InPores::Given`].
    felt: [Vec<f64>; 4],
    /// Where each cell is: strip, and number there.
    place: Vec<[u32; 2]>,
    /// 1/kg of each node and direction; zero where something holds it.
    inverse: Vec<[f64; D]>,
    /// The node that each node moves with, itself if none.
    leader: Vec<u32>,
}

impl<const D: usize> FreeWater<D> {
    /// Beside a mesh.
    pub fn new(carried: AdvectedWater<D>, grid: &Grid<D>, frame: &Frame<D>) -> Self {
        let nodes = frame.count();
        let place = |(_, position): (usize, [usize; D])| {
            let number = frame.number(&position);
            [number / frame.strip, number % frame.strip].map(|number| number as u32)
        };
        let mut water = Self {
            carried,
            place: grid.walk().map(place).collect(),
            felt: std::array::from_fn(|_| vec![0.0; frame.length()]),
            inverse: vec![[0.0; D]; nodes],
            leader: (0..nodes as u32).collect(),
        };
        water.tell(frame);
        water
    }

    /// Takes over what the soil feels.
    pub fn tell(&mut self, frame: &Frame<D>) {
        let Self { carried, felt, place, .. } = self;
        let has_changed = carried.has_changed();
        let mut tell = |cell: usize| {
            let [strip, number] = place[cell].map(|number| number as usize);
            felt.iter_mut()
                .zip(carried.given(cell))
                .for_each(|(felt, given)| felt[strip * frame.strip + number] = given);
        };
        if has_changed {
            (0..place.len()).for_each(tell);
        } else if carried.pressures != Pressures::Held {
            carried.water.cells.iter().for_each(|cell| tell(*cell as usize));
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
    pub fn press(
        &mut self,
        (grid, strips): (&Grid<D>, &[Strip<D>]),
        nodes: &mut Nodes<D>,
        conditions: &[Box<dyn Condition<D>>],
        (keeps, at_centroid): (f64, bool),
        dt: f64,
    ) -> Result<(), Fault> {
        let Self { carried, place, inverse, leader, .. } = self;
        for i in 0..carried.water.cells.len() {
            let cell = carried.water.cells[i] as usize;
            let [strip, number] = place[cell].map(|number| number as usize);
            let [volume, _] = strips[strip].volume_and_mass(number);
            carried.note(cell, volume, at_centroid.then(|| strips[strip].centroid(number)));
        }
        nodes.each_reached(MIXTURE_MASS, |node, mass| {
            inverse[node] = [if mass > 0.0 { keeps / mass } else { 0.0 }; D];
            leader[node] = node as u32;
        });
        conditions.iter().for_each(|condition| condition.each_held(&mut |node, axis| inverse[node][axis] = 0.0));
        for [follower, first] in &nodes.pairs {
            leader[*follower as usize] = *first;
        }
        let pushed = Pushed { grid, inverse, leader };
        carried.press(grid, &pushed, &mut nodes.motion, dt).map_err(|(place, what)| Fault { place, what })?;
        carried.sweep(nodes, dt);
        Ok(())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let felt = self.felt.iter().map(Vec::capacity).sum::<usize>() * size_of::<f64>();
        self.carried.bytes() + felt + self.inverse.capacity() * size_of::<[f64; D]>()
    }
}
