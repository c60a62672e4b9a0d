//! Rigid plates that are moved as given: footings, walls, and what they are pushed with.

use super::{Condition, Soil};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::observe::Totals;
use crate::real::array;
use crate::scene::{MovedPlate, Scene, ShapeChoice, Side};
use crate::step::Fault;
use crate::step::store::Nodes;

/// Nodes that go with a plate.
#[derive(Debug, Clone)]
pub struct Moved<const D: usize> {
    plate: MovedPlate,
    nodes: Vec<u32>,
    /// Normal of its side, into the soil.
    axis: usize,
    inwards: f64,
    /// Velocity into the soil in the step before, m/s.
    before: f64,
    /// Velocity in this step, m/s.
    now: f64,
    time: f64,
    /// Damping, 1/s.
    damping: f64,
    /// What the soil has got from it, N s.
    pushed: [f64; 2],
}

impl<const D: usize> Moved<D> {
    /// A plate on a mesh of so many functions along each axis, and their numbers.
    pub fn new(plate: &MovedPlate, along: &[usize; D], scene: &Scene, number: impl Fn(&[usize; D]) -> usize) -> Self {
        let side = plate.on as usize;
        let (axis, upper) = (usize::from(side > 1) + D - 2, side % 2 == 1);
        let edge = if upper { along[axis] - 1 } else { 0 };
        let range = if matches!(plate.on, Side::Left | Side::Right) { plate.y } else { plate.x };
        let [low, high] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        // Where a function stands, as Greville says: half a cell before the next for those between the lines of the mesh.
        let (size, between) = (scene.cell, scene.shape == ShapeChoice::Bspline2);
        let stands = |place: usize, functions: usize| {
            let number = if between { (place as f64 - 0.5).clamp(0.0, functions as f64 - 2.0) } else { place as f64 };
            size * number
        };
        let (slack, mut nodes) = (1e-6 * size, Vec::new());
        for place in 0..along.iter().product() {
            let position = array!([0; D], d => if d == 0 { place % along[0] } else { place / along[0] });
            let at = if D == 1 { 0.0 } else { stands(position[1 - axis], along[1 - axis]) };
            if position[axis] == edge && (D == 1 || (low - slack..=high + slack).contains(&at)) {
                nodes.push(number(&position) as u32);
            }
        }
        let inwards = if upper { -1.0 } else { 1.0 };
        Self {
            plate: plate.clone(),
            nodes,
            axis,
            inwards,
            before: 0.0,
            now: 0.0,
            time: 0.0,
            damping: 0.0,
            pushed: [0.0; 2],
        }
    }

    /// Velocity in a step dt (s), m/s: at its end the displacement is that of the plate.
    fn velocity(&self, dt: f64) -> f64 {
        (self.plate.at(self.time + dt) - self.plate.at(self.time)) / dt
    }

    /// Gives its nodes a velocity into the soil, m/s.
    fn move_with(&self, nodes: &mut Nodes<D>, velocity: f64) {
        for d in self.axes() {
            let velocity = if d == self.axis { self.inwards * velocity } else { 0.0 };
            self.nodes.iter().for_each(|node| nodes.motion.velocity[d][*node as usize] = velocity);
        }
    }

    /// Axes along which its nodes are fixed.
    fn axes(&self) -> impl Iterator<Item = usize> + use<D> {
        let (axis, rough) = (self.axis, self.plate.rough);
        (0..D).filter(move |d| *d == axis || rough)
    }
}

impl<const D: usize> Condition<D> for Moved<D> {
    fn gathered(&mut self, _: &mut Nodes<D>, soil: &dyn Soil<D>) {
        self.time = soil.time();
    }

    fn each_held(&self, visit: &mut dyn FnMut(usize, usize)) {
        for d in self.axes() {
            self.nodes.iter().for_each(|node| visit(*node as usize, d));
        }
    }

    fn hold(&self, nodes: &mut Nodes<D>) {
        self.move_with(nodes, self.now);
    }

    fn hold_ahead(&mut self, nodes: &mut Nodes<D>, dt: f64) {
        self.move_with(nodes, self.velocity(dt) * (1.0 + self.damping * dt));
    }

    fn damp_by(&mut self, damping: f64) {
        self.damping = damping;
    }

    fn accelerated(
        &mut self,
        nodes: &mut Nodes<D>,
        _: &dyn Soil<D>,
        totals: &mut Totals<D>,
        dt: f64,
    ) -> Result<(), Fault> {
        self.now = self.velocity(dt);
        // Damping comes after and takes its share: what is left is the velocity of the plate.
        let (gained, damped) = (self.now - self.before, self.now * self.damping * dt);
        for d in self.axes() {
            let along = if d == self.axis { self.inwards } else { 0.0 };
            let (work_at, change) = (along * (self.now - 0.5 * gained), along * (gained + damped));
            for node in self.nodes.iter().map(|node| *node as usize) {
                let mass = nodes.mixture_mass(node);
                let given = mass * (change - nodes.motion.change[d][node]);
                totals.support_impulse[d] += given;
                totals.external_work += given * work_at;
                self.pushed[d + 2 - D] += given;
                let motion = &mut nodes.motion;
                (motion.velocity[d][node], motion.change[d][node]) = (along * (self.now + damped), change);
                motion.acceleration[d][node] = change / dt;
            }
        }
        self.before = self.now;
        Ok(())
    }

    fn pushed_by(&self) -> Option<[f64; 2]> {
        Some(self.pushed)
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.value: self.before, self.now, self.time, self.pushed);
        Ok(())
    }
}
