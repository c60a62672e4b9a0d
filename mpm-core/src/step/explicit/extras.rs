//! What few runs have: other water, pressures that are solved for, a track of displacement and strain.

use super::*;
use crate::real::array_of;

impl<const D: usize> Explicit<D> {
    /// The same with velocities of the water at the nodes, in place of flow through faces.
    pub fn with_nodal_flow(mut self) -> Self {
        self.nodal = Some(Box::new(NodalFlow::new(&self.nodes, self.scheme.pressure_at_particles)));
        self
    }

    /// The same with pressures that are solved for: those of the end of a step (`step/pressure.rs`).
    pub fn with_solved_pressures(mut self) -> Self {
        let solver = PressureSystem::new(self.nodes.frame);
        for strip in &mut self.strips {
            strip.coupling = vec![0.0; solver.of_strip()];
        }
        self.solver = Some(Box::new(solver));
        self.nodes.work_at = 1.0;
        let length = self.nodes.frame.length();
        self.of_mesh = [(); 2].map(|()| vec![0.0; length]);
        self.pass(false, 0.0);
        self
    }

    /// Gives the cells what they have of particles that are boxes.
    pub(super) fn share_boxes(&mut self) {
        let Self { body, strips, nodes, pressure, domains, soil, solver, faces, .. } = self;
        let Some(domains) = domains else { return };
        let frame = nodes.frame;
        // A pressure that is solved for has not pushed yet.
        let pushes = body.water.is_some() && solver.is_none();
        let pressed = |cell: usize| {
            let alpha = faces.biot[0].get(cell).copied().unwrap_or(1.0);
            if pushes { alpha * pressure[0][frame.pad() + cell] } else { 0.0 }
        };
        domains.share_stresses(strips, nodes, soil, pressed);
        if let (Some(water), false) = (&body.water, body.filled.is_known() || solver.is_none() || faces.has_cuts()) {
            // Where no surface is followed boxes say how far the soil goes. An explicit step would have no limit under a thin rest.
            let full = water.flow.area / frame.inverse_size;
            faces.note_fill(|cell| domains.volume(cell) / (full * frame.thickness(1, cell)));
        }
    }

    /// The same with water that has a free surface.
    pub fn with_free_water(mut self, carried: AdvectedWater<D>) -> Self {
        self.free = Some(Box::new(FreeWater::new(carried, &self.body.grid, &self.nodes.frame)));
        self.begin_balances();
        self.is_stale = true;
        self
    }

    /// The water, if it has a free surface.
    pub(in crate::step) fn advected(&self) -> Option<&AdvectedWater<D>> {
        self.free.as_ref().map(|free| &free.carried)
    }

    /// The same, to be changed: the forces on the soil are computed again before it moves.
    pub(in crate::step) fn advected_mut(&mut self) -> Option<&mut AdvectedWater<D>> {
        self.is_stale = true;
        self.free.as_mut().map(|free| &mut free.carried)
    }

    /// Takes the water along to where the soil is now.
    pub(in crate::step) fn carry_water(&mut self) {
        let whole = self.whole();
        if let Some(carried) = self.advected_mut() {
            carried.carry(&whole.grid, &whole.solid);
        }
    }

    /// What the soil of a particle remembered when what is kept was last taken from the strips.
    pub(super) fn state_of(&self, id: u32) -> State {
        let first = |place: usize| self.kept.0 * id as usize + place - SolidPoint::<D>::COUNT;
        array_of(|s| self.places.state.map_or(0.0, |place| self.kept.1[first(place) + s]))
    }

    /// Restarts the balances with the state as it is.
    pub(in crate::step) fn begin_balances(&mut self) {
        self.kept.1 = self.kept_now();
        let whole = self.whole();
        self.totals = Totals::default();
        self.totals.start(&whole.cell_values(self.advected()));
        self.totals.flowed = whole.flowed_at_first(|id| self.state_of(id));
        self.time = 0.0;
    }

    /// Begins to count displacement and strain; the velocity gradients that particles keep stay.
    pub(in crate::step) fn begin_track(&mut self) {
        let (whole, kept) = (self.whole(), self.kept_now());
        let mut origin = vec![[0.0; D]; self.solid_count];
        for (point, id) in whole.solid.points.iter().zip(&whole.solid.ids) {
            origin[*id as usize] = point.x;
        }
        self.origin = Some(origin);
        let before = self.kept.0 - self.places.strain.map_or(0, |_| 4);
        let per_particle = before + 4;
        let mut more = vec![0.0; per_particle * self.solid_count];
        for id in (0..self.solid_count).filter(|_| before > 0) {
            more[per_particle * id..][..before].copy_from_slice(&kept[self.kept.0 * id..][..before]);
        }
        self.kept = (per_particle, more);
        self.places.strain = Some(SolidPoint::<D>::COUNT + before);
        self.body = whole;
        self.settle_in();
    }

    /// Whether displacement and strain are counted.
    pub(in crate::step) fn is_tracked(&self) -> bool {
        self.origin.is_some()
    }

    /// Visits every particle: its number, itself, where it was when counting began (m), its strain since then.
    pub(in crate::step) fn each_particle(&self, mut visit: impl FnMut(u32, &SolidPoint<D>, [f64; D], [f64; 4])) {
        let frame = &self.nodes.frame;
        for (_, position) in self.body.grid.walk() {
            let number = frame.number(&position);
            let (solid, cell) = (&self.strips[number / frame.strip].solid, number % frame.strip);
            for slot in 0..solid.count(cell) {
                let (id, point) = (solid.id(cell, slot), solid.particle::<SolidPoint<D>, D>(cell, slot));
                let strain = |first: usize| array_of(|s| solid.number(cell, slot, first + s));
                let from = self.origin.as_ref().map_or(point.x, |origin| origin[id as usize]);
                visit(id, &point, from, self.places.strain.map_or([0.0; 4], strain));
            }
        }
    }

    /// All particles stop.
    pub(in crate::step) fn stop(&mut self) {
        for strip in &mut self.strips {
            strip.solid.fill_numbers(D..2 * D, 0.0);
        }
        self.is_stale = true;
    }

    /// Changes the materials.
    pub(in crate::step) fn change_materials(&mut self, materials: Materials) {
        self.body.materials = materials;
    }

    /// What the run is made of, beside its particles.
    pub(in crate::step) fn body(&self) -> &Body<D> {
        &self.body
    }

    /// Nodes: sums for the next step, motion of the last.
    pub(in crate::step) fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    /// Sums of the steps.
    pub(in crate::step) fn totals(&mut self) -> &mut Totals<D> {
        &mut self.totals
    }

    /// Time (s) passes without a step of the soil.
    pub(in crate::step) fn pass_time(&mut self, time: f64) {
        self.time += time;
    }

    /// Holds the sides as a stage says, or else as the scene does.
    pub(super) fn hold_sides(&mut self, own: Option<[SolidSide; 4]>) {
        self.sides = own;
        self.conditions.iter_mut().for_each(|condition| condition.hold_sides(own));
    }

    /// Damping from now on, 1/s.
    pub(in crate::step) fn damp_by(&mut self, rate: f64) {
        self.damping = rate;
        self.conditions.iter_mut().for_each(|condition| condition.damp_by(rate));
    }

    /// Friction on the base, if there is any.
    pub(in crate::step) fn friction(&mut self) -> Option<&mut Friction> {
        self.conditions.iter_mut().find_map(|condition| condition.friction())
    }
}
