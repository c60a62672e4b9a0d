//! Water with a free surface in soil that may move: the interaction of soil and water in a step of the soil.
//!
//! The soil feels the pressures of the cells (`free_surface`), on the soil of each cell: carried back to particles, a thin wet layer
//! would push too hard. They are fixed while the soil comes to rest, or follow its motion, implicitly or explicitly.

use serde::{Deserialize, Serialize};

use super::Pushed;
use super::free_surface::{
    Along, Filling, FreeSurface, Kind, Medium, MovingStep, Rounding, SoilMap, Square, Squeeze, Standing, Surroundings,
    WaterLayer, squares,
};
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::dimension::in_two;
use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::real::array_of;
use crate::scene::{Bearing, FaceLoad, Feed, FreeSurfaceWater, Scene, SolidSide, WaterProperties};
use crate::seeding;
use crate::soils::Soils;
use crate::sparse::Unsolved;
use crate::step::store::{Motion, Nodes};

/// Soil that has moved this far takes its water along before it moves on, in cells.
const FAR: f64 = 0.02;

/// Least share of the bottom of a cell that its soil stands on.
const LEAST_COVER: f64 = 0.02;
/// Exchange between blocks of full cells, in parts of what elastic shear would make of the same pressures, 1/(2 G). Elastic soil
/// would do with a quarter; soil that flows resists less. On the levee's slide (0.4 m, 9 particles per cell) the checkerboard
/// index is at most 10 % without and 4.6 % with a quarter. Over nine runs whose cohesion or conductivity differ by less than 0.5 % it
/// is 0.8 to 1.0 % with 32, the crest settling by 0.15 to 0.27 m, and 0.7 to 0.9 % with 128, by 0.15 to 0.20 m. With the stops of
/// `mpm-verify levee` it is 1.03 % with 32 and 0.84 % with 128. At 0.2 m it is 3.4 % without and 0.3 % with 128. No help everywhere:
/// with 4 particles per cell it is about 2 % with either, and on the levee of Table 3 1.5 % with 32, 2.8 % with 128.
const SMOOTHING: f64 = 128.0;

/// What the pressures do while the soil moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pressures {
    /// They are fixed.
    Held,
    /// They follow, with those of the end of the step.
    Implicit,
    /// They follow from the start of the step.
    Explicit,
}

/// The water of a scene with a free surface.
#[derive(Debug)]
pub struct AdvectedWater<const D: usize> {
    /// Water in the cells.
    pub water: FreeSurface<D>,
    /// Its particles.
    pub layer: WaterLayer<D>,
    /// What surrounds the soil.
    pub around: Surroundings,
    /// What feeds it, and the time (s) at which that was last sampled.
    fed: Option<FreeSurfaceWater>,
    fed_at: f64,
    /// What the pressures do while the soil moves.
    pub pressures: Pressures,
    /// Work of the pressures on the soil, J.
    pub work: f64,
    /// Water that moving soil has left behind, m3.
    pub left_behind: f64,
    /// Pressures and cells in a step of the soil.
    pub squeeze: Squeeze<D>,
    /// Particles per cell along one direction.
    per_direction: usize,
    properties: WaterProperties,
    /// Water that full cells exchange where their pressures part, per volume and pressure, 1/Pa.
    smoothing: f64,
    /// Share of the pressures that the soil feels.
    share: f64,
    /// Whether cells have come to feel something else, but by a step of the soil.
    changed: bool,
    /// Mean over the soil of a cell of the pressure where it is positive, Pa.
    felt: Vec<f64>,
    /// Height where the pressure acts, as a share of that of the soil's centroid: water presses more the deeper it stands.
    lower: Vec<f64>,
    /// Water per volume of soil, kg/m3.
    per_volume: Vec<f64>,
    /// Height of the middle of the water above the bottom of the cell, in cells.
    middle: Vec<f64>,
    /// Soil of the cells in this step.
    soil: Vec<Filling<D>>,
    /// Boxes of the particles when the soil was last sampled.
    boxes: Vec<Square<D>>,
    /// How the nodes have moved since, m, and how far any may have.
    swept: Vec<[f64; D]>,
    way: f64,
    /// Time since the water particles last followed water that flows while the soil moves, s.
    waits: f64,
}

impl<const D: usize> AdvectedWater<D> {
    /// The water of a scene at t = 0; `face_area` in m2.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(
        scene: &Scene,
        properties: WaterProperties,
        grid: &Grid<D>,
        (solid, soils): (&Layer<SolidPoint<D>, D>, &Soils),
        face_area: f64,
    ) -> Result<Self, Unsolved> {
        let (weight, size) = (scene.water_weight(), scene.cell);
        let softest = scene.soils().iter().map(|soil| soil.elastic.shear_modulus()).fold(f64::INFINITY, f64::min);
        let medium = Medium {
            conductance: soils.largest_conductivity() * properties.mobility() * face_area / size,
            size,
            cell_volume: face_area * size,
            weight: array_of(|d| weight[d + 2 - D]),
            unit_weight: properties.unit_weight,
            porosity: scene.mobile_porosity(),
            retention: scene.free_surface.as_ref().and_then(|free| free.retention),
        };
        let per_direction = scene.particles_per_direction();
        let map = SoilMap::new(grid, solid, face_area, per_direction, soils);
        let fed = scene.free_surface.clone();
        let feeds = fed.as_ref().map_or([None; 4], |free| free.feeds_at(0.0));
        let held = scene.solid_sides.map(|side| side != SolidSide::Free);
        let standing = |load: &FaceLoad| Standing { load: load.clone(), level: load.course.at(0.0, 0.0), held };
        let reservoirs = scene.loads.iter().filter(|load| load.bearing == Bearing::Reservoir);
        let standing = reservoirs.map(standing).collect();
        let heads = fed.as_ref().map_or_else(Default::default, |free| free.heads.clone());
        let around = Surroundings { open: [false; 4], feeds, heads, periodic: scene.periodic, standing };
        let mut water = FreeSurface::new(grid, medium, (map, soils.clone()), &around)?;
        let content: Vec<f64> = grid
            .walk()
            .map(|(cell, position)| {
                if water.soil.is_soil(cell) {
                    water.pores(cell) * (wet_area(scene, &position) / water.soil.share[cell]).min(1.0)
                } else {
                    0.0
                }
            })
            .collect();
        match medium.retention {
            Some(law) => {
                let middle = |position: [usize; D]| in_two(&position.map(|i| (i as f64 + 0.5) * grid.size));
                let first: Vec<f64> = grid.walk().map(|(_, at)| scene.first_pressure(&middle(at))).collect();
                water.soak(&law, &first);
            }
            None => water.fill(&content),
        }
        let cells = grid.cell_count();
        let mut boxes = Vec::new();
        squares(solid, medium.cell_volume, &mut boxes);
        let mut squeeze = Squeeze::default();
        squeeze.build(grid, &water);
        let mut carried = Self {
            layer: WaterLayer::new(grid, &water, per_direction, properties.density),
            water,
            around,
            fed,
            fed_at: 0.0,
            pressures: Pressures::Held,
            work: 0.0,
            left_behind: 0.0,
            squeeze,
            per_direction,
            properties,
            smoothing: SMOOTHING / (2.0 * softest),
            share: 1.0,
            changed: true,
            felt: vec![0.0; cells],
            lower: vec![1.0; cells],
            per_volume: vec![0.0; cells],
            middle: vec![0.5; cells],
            soil: vec![Filling { volume: 0.0, at: [0.5; D], pressed: [0.5; D] }; cells],
            boxes,
            swept: vec![[0.0; D]; grid.node_count()],
            way: 0.0,
            waits: 0.0,
        };
        let Self { water, around, .. } = &mut carried;
        water.feed_exactly(grid, around, fed_along(scene, grid.cells));
        carried.show();
        Ok(carried)
    }

    /// Lets the soil feel the water as it is.
    pub fn show(&mut self) {
        self.feel(1.0);
        let Self { water, .. } = self;
        for cell in 0..water.content.len() {
            (self.per_volume[cell], self.middle[cell]) = (0.0, 0.5);
            if water.soil.is_soil(cell) {
                let soil = water.soil.share[cell] * water.medium.cell_volume;
                let held = water.content[cell] + self.squeeze.surplus[cell];
                // With what is there before any front comes.
                let stays = water.soil.stays[cell];
                self.per_volume[cell] = self.properties.density * (held + stays) / soil;
                if water.kind[cell] == Kind::Standing {
                    // What stays is all over the soil.
                    let wet = water.wet_share(cell).clamp(0.0, 1.0);
                    let moist = if stays > 0.0 { stays / (held + stays) } else { 0.0 };
                    self.middle[cell] = 0.5 * water.soil.share[cell] * (wet + moist * (1.0 - wet));
                }
            }
        }
    }

    /// Lets the soil feel a share of the pressures.
    pub fn feel(&mut self, share: f64) {
        self.share = share;
        self.changed = true;
        self.felt.fill(0.0);
        self.lower.fill(1.0);
        self.feel_now();
    }

    /// Lets the soil feel the pressures as they are now.
    fn feel_now(&mut self) {
        for &cell in &self.water.cells {
            let cell = cell as usize;
            self.felt[cell] = self.share * self.water.mean_pressure(cell);
            self.lower[cell] = self.water.lower(cell);
        }
    }

    /// Whether the soil has come to feel something else since this was last asked, as cells that are no soil may.
    pub fn has_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Changes which sides let water out.
    pub fn open(&mut self, grid: &Grid<D>, open: [bool; 4]) {
        if self.around.open != open {
            self.around.open = open;
            self.water.surround(grid, &self.around);
        }
    }

    /// Looks at the water that stands before the soil, and at what feeds it, at a time, s.
    pub fn look_outside(&mut self, grid: &Grid<D>, time: f64) {
        let mut changed = self.feed(time);
        for water in &mut self.around.standing {
            let level = water.load.course.at(time, 0.0);
            changed |= level != water.level;
            water.level = level;
        }
        if changed {
            self.water.surround(grid, &self.around);
        }
    }

    /// How long (s) from a time on what is outside changes evenly: no step of the water passes a jump.
    pub fn even_for(&self, time: f64) -> f64 {
        // A time that was reached but for round-off.
        let from = time + 1e-12 * time.abs();
        let feeds = self.fed.iter().flat_map(|free| &free.courses);
        let levels = self.around.standing.iter().map(|water| &water.load.course);
        feeds.chain(levels).map(|course| course.bends_after(from)).fold(f64::INFINITY, f64::min) - time
    }

    /// Sets the feeds of a time, s; whether they have changed.
    fn feed(&mut self, time: f64) -> bool {
        self.fed_at = time;
        let Some(feeds) = self.fed.as_ref().map(|free| free.feeds_at(time)) else { return false };
        std::mem::replace(&mut self.around.feeds, feeds) != feeds
    }

    /// How far the soil may have moved since the water was last carried along, in cells.
    pub fn way(&self, grid: &Grid<D>) -> f64 {
        self.way * grid.inverse_size
    }

    /// Takes the water along to where the soil is now.
    pub fn carry(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>) {
        let Self { water, squeeze, boxes, around, layer, swept, .. } = self;
        layer.ride(grid, swept, around.periodic);
        let lost = water.carry(grid, solid, boxes, &mut squeeze.surplus, (around, self.per_direction));
        self.left_behind += lost.iter().map(|(_, lost)| lost).sum::<f64>();
        layer.book_lost(grid, water, &lost);
        squeeze.build(grid, water);
        self.swept.fill([0.0; D]);
        self.way = 0.0;
        self.show();
    }

    /// Gives back for a time (s) what cells hold beyond their pores.
    pub fn returns(&mut self, time: f64) {
        self.squeeze.give_back(&mut self.water, time);
    }

    /// Pressure that the soil of a cell feels, Pa.
    pub fn felt(&self, cell: usize) -> f64 {
        self.felt[cell]
    }

    /// What is wrong where the particles are not those of the water in the cells: more than half a particle is missing, or too
    /// many, for each cell where water has entered or left, or some of it was never recorded.
    pub fn unbalanced(&self) -> Option<String> {
        /// Roundings of a cell in a booking: of its content and of what is pending, one for each face and some more.
        const EACH: f64 = 16.0;
        let (cells, particles, pending) = (self.stored(), self.layer.stored(), self.layer.pending());
        let Rounding { pending: most, bookings, particle } = self.layer.rounding();
        // What is less than the round-off of a particle's water is none.
        let flowed = cells.abs() + particles + self.water.inflow + self.water.outflow + particle;
        // Both sums over the cells round once per cell as well.
        let sums = 2.0 * self.felt.len() as f64;
        let round_off = f64::EPSILON * (EACH * (bookings + 1) as f64 + sums) * flowed;
        let lost = cells - particles - pending;
        let wrong = lost.abs() > round_off || pending.abs() > most + round_off;
        (wrong || lost.is_nan()).then(|| {
            format!(
                "the cells hold {cells:.6e} m3 and the particles {particles:.6e} m3: {pending:.3e} m3 is pending, of at most \
                 {most:.3e}, and {lost:.3e} m3 was never booked, of at most {round_off:.1e}"
            )
        })
    }

    /// Water in cells and waiting, m3.
    pub fn stored(&self) -> f64 {
        self.water.stored() + self.squeeze.surplus.iter().sum::<f64>()
    }
}

/// What feeds with a velocity meet of the soil at t = 0, in cells along their sides: rain what lies under the open sky, in
/// proportion to its width, the others their side up to where they end. `mesh` counts the cells.
fn fed_along<const D: usize>(scene: &Scene, mesh: [usize; D]) -> Along {
    let feeds = scene.free_surface.as_ref().map_or([None; 4], |free| free.feeds);
    let soil = scene.outline_or_box();
    std::array::from_fn(|side| match feeds[side] {
        Some(Feed::Velocity { height, .. }) if D == 2 => {
            let axis = usize::from(side < 2);
            let cell = |i: usize| [i as f64 * scene.cell, (i + 1) as f64 * scene.cell];
            let top = if side < 2 { height } else { f64::INFINITY };
            let length = |[low, high]: [f64; 2]| seeding::length_along(&soil, side, [low, high.min(top)], scene.width);
            (0..mesh[axis]).map(|i| length(cell(i)) / scene.cell).collect()
        }
        _ => Vec::new(),
    })
}

/// Share of a cell that is wet at t = 0.
fn wet_area<const D: usize>(scene: &Scene, position: &[usize; D]) -> f64 {
    let Some(free) = &scene.free_surface else { return 0.0 };
    let low = position.map(|i| i as f64 * scene.cell);
    if let Some(wet) = &free.wet {
        let row = seeding::between(wet, 1, low[D - 1], low[D - 1] + scene.cell);
        let part = seeding::between(&row, 0, low[0], low[0] + scene.cell);
        return (seeding::area(&part) / (scene.cell * scene.cell)).max(0.0);
    }
    free.level.map_or(0.0, |level| ((level - low[D - 1]) / scene.cell).clamp(0.0, 1.0))
}

impl<const D: usize> AdvectedWater<D> {
    /// Notes the soil of a cell in this step: its volume (m3) and centroid (cell coordinates), where that is where its stress acts.
    pub fn note(&mut self, cell: usize, volume: f64, centroid: Option<[f64; D]>) {
        let at = centroid.unwrap_or([0.5; D]);
        let mut pressed = at;
        if centroid.is_some() {
            pressed[D - 1] *= self.lower[cell];
        }
        self.soil[cell] = Filling { volume, at, pressed };
    }

    /// What the soil of a cell feels: pressure (Pa), water per volume of soil (kg/m3), factor on the height of the centroid where the
    /// pressure acts, height of the middle of the water, in cells.
    pub fn given(&self, cell: usize) -> [f64; 4] {
        [self.felt[cell], self.per_volume[cell], self.lower[cell], self.middle[cell]]
    }

    /// Lets the pressures of a step dt (s) act on the motion of the nodes, and the water follow it.
    ///
    /// # Errors
    /// Where and what went wrong.
    pub fn press(
        &mut self,
        grid: &Grid<D>,
        pushed: &Pushed<D>,
        motion: &mut Motion,
        dt: f64,
    ) -> Result<(), (String, String)> {
        let bulk_modulus = self.properties.bulk_modulus;
        if self.pressures == Pressures::Held {
            self.work += self.squeeze.work_of(&self.felt, &self.soil, pushed, motion, dt);
        } else {
            let step = MovingStep {
                dt,
                implicit: self.pressures == Pressures::Implicit,
                bulk_modulus,
                smoothing: self.smoothing,
            };
            let Self { squeeze, water, soil, .. } = self;
            let pressed = squeeze.press(water, soil, pushed, motion, &step).map_err(|cell| {
                let place = grid.cell_position(cell).map(|i| (i as f64 + 0.5) * grid.size);
                (format!("the cell at {place:?} m"), "no pressure balances its water".to_owned())
            })?;
            self.work += pressed.work;
            self.waits += dt;
            if self.layer.book(&self.water, dt) {
                self.layer.move_by(grid, &self.water, self.waits, self.around.periodic);
                self.waits = 0.0;
            }
            self.share = 1.0;
            self.feel_now();
        }
        Ok(())
    }

    /// Notes how nodes move in a step dt (s).
    pub fn sweep(&mut self, nodes: &Nodes<D>, dt: f64) {
        let mut fastest: f64 = 0.0;
        let count = self.swept.len();
        for run in nodes.reached.each_run() {
            let run = run.start.min(count)..run.end.min(count);
            for d in 0..D {
                let velocities = &nodes.motion.velocity[d][run.clone()];
                for (swept, velocity) in self.swept[run.clone()].iter_mut().zip(velocities) {
                    swept[d] += dt * velocity;
                    fastest = if velocity.abs() > fastest { velocity.abs() } else { fastest };
                }
            }
        }
        self.way += dt * fastest;
    }

    /// Whether soil that moves under pressures that follow has left its water too far behind.
    pub fn is_behind(&self, grid: &Grid<D>) -> bool {
        self.pressures != Pressures::Held && self.way(grid) > FAR
    }

    /// Pressure on the base under a cell of the lowest row (Pa), and the share of its bottom that is under soil.
    pub fn on_base(&self, cell: usize) -> (f64, f64) {
        let water = &self.water;
        let half = 0.5 * water.medium.rise() * water.medium.size;
        let pressure = if water.kind[cell].unknown() { (water.pressure[cell] + half).max(0.0) } else { 0.0 };
        // In the lowest row the faces below the cells have their numbers.
        (self.share * pressure, water.soil.cover[D - 1][cell][1].max(LEAST_COVER))
    }

    /// Mass of water in a volume (m3) of the soil of a cell, kg.
    pub fn mass_in(&self, cell: usize, volume: f64) -> f64 {
        self.per_volume[cell] * volume
    }

    /// rho_w, kg/m3.
    pub fn density(&self) -> f64 {
        self.properties.density
    }

    /// Saves or restores what steps to come depend on.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive, grid: &Grid<D>) -> Result<(), RestoreError> {
        archive!(archive.value: self.around.open, self.pressures, self.fed_at);
        self.feed(self.fed_at);
        for water in &mut self.around.standing {
            archive.value(&mut water.level)?;
        }
        self.water.save_or_restore(archive, grid, &self.around)?;
        self.layer.save_or_restore(archive)?;
        archive!(archive.slice: self.squeeze.surplus, self.felt, self.lower, self.per_volume, self.middle);
        archive!(archive.slice: self.boxes, *self.swept.as_flattened_mut());
        archive!(archive.value: self.work, self.left_behind, self.way, self.waits, self.share);
        if archive.restores() {
            self.squeeze.build(grid, &self.water);
            self.changed = true;
        }
        Ok(())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let floats = [&self.felt, &self.per_volume, &self.middle].iter().map(|v| v.capacity()).sum::<usize>();
        self.water.bytes() + floats * size_of::<f64>() + self.soil.capacity() * size_of::<Filling<D>>()
    }
}
