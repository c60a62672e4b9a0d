//! What happens on the nodes: the equation of motion, pressures that are solved for, conditions, balances.

use super::*;

impl<const D: usize> Explicit<D> {
    /// Velocities under the forces gathered so far.
    pub(super) fn accelerate(&mut self, dt: f64) {
        let Self { kernel, body, nodes, pool, .. } = self;
        let Nodes { frame, sums, reached, motion, .. } = nodes;
        let (count, length) = (frame.count(), frame.strip);
        let Motion { velocity: [vx, vy], change: [cx, cy], acceleration: [ax, ay] } = motion;
        let (gravity, flip) = (body.gravity, body.flip);
        let solve = |(sums, runs): (&StripSums, &Vec<_>), velocity, change, acceleration| {
            kernel.accelerate(EquationOfMotion { runs, sums, velocity, change, acceleration, gravity, flip, dt });
        };
        if pool.is_some() {
            fn chunks(field: &mut [f64], length: usize) -> rayon::slice::ChunksMut<'_, f64> {
                field.par_chunks_mut(length)
            }
            let [vx, vy, cx, cy, ax, ay] = [vx, vy, cx, cy, ax, ay].map(|field| chunks(&mut field[..count], length));
            sums.par_iter()
                .zip(reached.runs())
                .zip(vx)
                .zip(vy)
                .zip(cx)
                .zip(cy)
                .zip(ax)
                .zip(ay)
                .for_each(|((((((sums, vx), vy), cx), cy), ax), ay)| solve(sums, [vx, vy], [cx, cy], [ax, ay]));
        } else {
            let mut fields = [vx, vy, cx, cy, ax, ay].map(|field| field[..count].chunks_mut(length));
            for sums in sums.iter().zip(reached.runs()) {
                let [vx, vy, cx, cy, ax, ay] = fields.each_mut().map(|f| f.next().unwrap_or_default());
                solve(sums, [vx, vy], [cx, cy], [ax, ay]);
            }
        }
    }

    /// Lets the conditions act on the motion.
    pub(super) fn constrain(&mut self, dt: f64) -> Result<(), Fault> {
        let Self { kernel, scheme, body, strips, nodes, conditions, totals, pressure, time, free, damping, .. } = self;
        let kernel = kernel.as_ref();
        let (frame, pressure, time) = (nodes.frame, &pressure[0], *time);
        let water = free.as_ref().map(|free| &free.carried);
        let soil = Grains { kernel, scheme, body, water, strips, frame, pressure, time };
        for condition in conditions.iter_mut() {
            condition.accelerated(nodes, &soil, totals, dt)?;
        }
        if let Some(free) = free {
            let keeps = 1.0 / (1.0 + *damping * dt);
            free.press((&body.grid, strips), nodes, conditions, (keeps, scheme.at_centroid), dt)?;
        }
        let water = free.as_ref().map(|free| &free.carried);
        let soil = Grains { kernel, scheme, body, water, strips, frame, pressure, time };
        for condition in conditions {
            condition.followed(nodes, &soil, totals, dt);
        }
        Ok(())
    }

    /// Records what the nodes have gained, and the work of load and weight.
    pub(super) fn book_motion(&mut self, dt: f64) {
        let Self { body, strips, nodes, tops, loaded, kernel, totals, time, .. } = self;
        let kernel = kernel.as_ref();
        totals.book_motion(nodes, body.flip, dt);
        if body.surcharge.is_some() {
            let pressure = body.pressure_at(*time);
            let mut power = 0.0;
            let frame = nodes.frame;
            tops.each_push(kernel, (&body.surface, &body.grid, -pressure), strips, &frame, |node, newton| {
                power += newton * nodes.working_velocity(node, D - 1, dt);
            });
            totals.external_work += dt * power;
            totals.load_impulse -= dt * pressure * body.surface.loaded_area();
        }
        let loads = (&body.loads, &body.grid, *time);
        loaded.each_force(kernel, loads, strips, &nodes.frame, |node, axis, newton| {
            totals.external_work += dt * newton * nodes.working_velocity(node, axis, dt);
            totals.load_impulse += if axis + 1 == D { dt * newton } else { 0.0 };
        });
        if let Some(gravity) = body.gravity {
            totals.book_weight(nodes, &gravity, dt);
        }
        for condition in &self.conditions {
            condition.book(nodes, totals, dt);
        }
    }

    /// Notes the accelerations that drive the flow of the next step, where pressures are solved for.
    pub(super) fn note_accelerations(&mut self) {
        let Self { kernel, scheme, nodes, of_mesh, solver, .. } = self;
        if solver.is_none() {
            return;
        }
        if scheme.nodal {
            for (to, from) in of_mesh.iter_mut().zip(&nodes.motion.acceleration).take(D) {
                to[..from.len()].copy_from_slice(from);
            }
        } else {
            kernel.accelerations_of_mesh(nodes, of_mesh);
        }
    }

    /// Solves for the pressures of the end of the step, where that is asked for, and adds what they push.
    pub(super) fn solve_pressures(&mut self, dt: f64) -> Result<(), Fault> {
        if self.solver.is_none() {
            return Ok(());
        }
        self.accelerate(dt); // v*
        let Self { body, strips, nodes, of_mesh, pressure, faces, conditions, damping, solver, domains, .. } = self;
        let (Some(solver), Some(water)) = (solver, &body.water) else { return Ok(()) };
        solver.held.clear();
        let mut plate = &[][..];
        for condition in conditions.iter_mut().rev() {
            condition.hold_ahead(nodes, dt);
            condition.each_held(&mut |node, axis| solver.held.push((node, axis)));
            if !condition.plate().is_empty() {
                plate = condition.plate();
            }
        }
        let by = Driving {
            faces,
            flow: &water.flow,
            gravity: body.gravity.unwrap_or([0.0; D]),
            acceleration: of_mesh,
            keeps: 1.0 / (1.0 + *damping * dt),
            dt,
            has_surface: body.filled.is_known() || !faces.by_porosity.is_empty() || domains.is_some(),
        };
        solver.solve(strips, nodes, &mut pressure[0], plate, &by)?;
        solver.push(strips, nodes);
        conditions.iter_mut().for_each(|condition| condition.pushed(nodes));
        Ok(())
    }

    /// Finds the velocities that strain the soil, where they are not those of the nodes.
    pub(super) fn map_back(&mut self) {
        let Self { kernel, body, strips, nodes, mapped: Some(mapped), soil, places, .. } = self else {
            return;
        };
        let Nodes { frame, motion, .. } = &*nodes;
        let common = &Common {
            frame,
            motion,
            acceleration: &motion.acceleration,
            water: InPores::None,
            pressure: &[],
            conducts: &motion.acceleration, // no water
            rare: Rare::default(),
            soil,
            moves: false,
            elastic: None,
            materials: &body.materials,
            plastic: false,
            flow: FaceFlow::default(),
            gravity: [0.0; D],
            flip: body.flip,
            apart: 0.0,
            kept: *places,
            coupled: false,
            dt: 0.0,
        };
        for (strip, sums) in strips.iter_mut().zip(&mut mapped.sums) {
            kernel.map_back(strip, sums, common);
        }
        mapped.merge();
        for condition in &self.conditions {
            condition.join(mapped);
        }
        for node in 0..frame.count() {
            let mass = mapped.sum(SOLID_MASS, node);
            let inverse = if mass > 0.0 { 1.0 / mass } else { 0.0 };
            for d in 0..D {
                mapped.motion.velocity[d][node] = mapped.sum(MOMENTUM + d, node) * inverse;
            }
        }
        for condition in self.conditions.iter().rev() {
            condition.hold(mapped);
        }
    }
}
