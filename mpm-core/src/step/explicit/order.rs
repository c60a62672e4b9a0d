//! Between steps: particles go to where they belong, and what depends on it is found again.

use super::*;

impl<const D: usize> Explicit<D> {
    /// Takes the particles of the body into the strips and gathers them.
    pub(super) fn settle_in(&mut self) {
        let Self { body, nodes: Nodes { frame, .. }, strips, kept: (more, kept), .. } = self;
        for strip in strips.iter_mut() {
            strip.solid.fill(frame, strip.first, &body.solid, (*more, kept));
            if let Some(water) = &body.water {
                strip.water.fill(frame, strip.first, &water.layer, (0, &[]));
            }
        }
        let Body { grid, solid, water, materials, .. } = &mut self.body;
        if let Some(water) = water {
            water.look_at_soil(grid, solid, &materials.soils);
        }
        self.open_faces();
        // What is left of the layers are their cells and counts.
        let Body { solid, water, .. } = &mut self.body;
        *solid = std::mem::take(solid).without_points();
        if let Some(water) = water {
            water.layer = std::mem::take(&mut water.layer).without_points();
        }
        for cell in 0..self.nodes.frame.count() {
            self.follow_faces(cell);
        }
        self.find_surface();
        self.nodes.reached.follow(&self.nodes.frame, &self.strips);
        self.pass(false, 0.0);
        if self.body.water.as_ref().is_some_and(|water| water.partly_drained) {
            self.note_open_cells();
        }
    }

    /// Notes where the particles of a cell are that carry faces of the soil.
    fn follow_faces(&mut self, cell: usize) {
        self.tops.follow(&self.strips, &self.nodes.frame, cell);
        self.loaded.follow(&self.strips, &self.nodes.frame, cell);
    }

    /// Opens the cells that hold no water to the air, where it leaves with its particles.
    pub(super) fn note_open_cells(&mut self) {
        let Self { body: Body { grid, solid, water: Some(water), .. }, strips, nodes: Nodes { frame, .. }, .. } = self
        else {
            return;
        };
        water.note_open(grid, solid, |cell| {
            let number = frame.number(&grid.cell_position(*cell));
            !strips[number / frame.strip].holds(number % frame.strip)
        });
        strips.iter_mut().for_each(|strip| strip.sums.changed = false);
        self.open_faces();
    }

    /// Finds the surface from the particles where they are.
    pub(super) fn find_surface(&mut self) {
        let Self { body, strips, tops, nodes, soil, .. } = self;
        if body.filled.is_known() {
            body.filled.follow(&body.grid, &body.surface, |top| tops.carrier(strips, top));
            Tops::note_soil(&body.filled, &nodes.frame, soil, true);
            self.faces.note_reach(&self.body.filled, &self.body.grid);
        }
    }

    /// Finds it where the particles will be at the end of a step, as the kernel moves them.
    pub(super) fn find_surface_ahead(&mut self, dt: f64) {
        let Self { kernel, body, strips, tops, nodes, mapped, soil, domains, places, .. } = self;
        if body.filled.is_known() {
            let boxes = domains.as_deref().zip(places.extent);
            tops.look_ahead(kernel.as_ref(), strips, (nodes, mapped.as_deref(), boxes), dt);
            let moved = body.filled.follow(&body.grid, &body.surface, |top| tops.ahead(top));
            Tops::note_soil(&body.filled, &nodes.frame, soil, moved);
        }
    }

    /// Finds which faces conduct.
    pub(super) fn open_faces(&mut self) {
        let Body { grid, solid, water, .. } = &mut self.body;
        if let Some(water) = water {
            self.faces.open(grid, solid, water);
        }
        if let Some(solver) = &mut self.solver {
            solver.forget();
        }
    }

    /// Restores the order of the cells after particles have left theirs.
    pub(super) fn sort(&mut self) -> Result<(), Fault> {
        if let Some(period) = self.body.period {
            for strip in &mut self.strips {
                strip.solid.wrap(period);
                strip.water.wrap(period);
            }
        }
        let Self { nodes: Nodes { frame, .. }, strips, movers: [solid, water], .. } = self;
        crossing::find(strips, frame, |s| &mut s.solid, solid);
        crossing::find(strips, frame, |s| &mut s.water, water);
        // Where soils differ, so do the cells that they come to; and an outline cuts others.
        let differ = self.body.water.as_ref().is_some_and(Pores::is_uneven);
        let may_leave = self.body.water.as_ref().is_some_and(Pores::may_leave);
        // Without water in its pores soil may go anywhere in the mesh: no face of a cell depends on it.
        let bare = self.body.water.is_none();
        let goes = if bare {
            solid.list.iter().all(|mover| mover.to.is_some())
        } else {
            !differ
                && crossing::keeps_outline(strips, frame, |s| &mut s.solid, solid, false)
                && crossing::keeps_outline(strips, frame, |s| &mut s.water, water, may_leave)
        };
        if goes {
            let mut removed = 0.0;
            let mass = 2 * D;
            crossing::carry(strips, frame, |s| &mut s.solid, (solid, !bare), |_| {});
            crossing::carry(strips, frame, |s| &mut s.water, (water, true), |gone| removed += gone[mass]);
            self.body.solid.crossings += solid.list.len() as u64;
            self.body.solid.order += 1;
            if let Some(own) = &mut self.body.water {
                // As where the outline changes, crossings beside a removal are not counted.
                own.layer.crossings += if removed > 0.0 { 0 } else { water.list.len() as u64 };
                own.removed_mass += removed;
            }
            for i in 0..self.movers[0].list.len() {
                let mover = self.movers[0].list[i];
                for cell in [Some(mover.from), mover.to].into_iter().flatten() {
                    self.follow_faces(cell);
                }
            }
            self.find_surface();
            self.nodes.reached.follow(&self.nodes.frame, &self.strips);
            self.pass(false, 0.0);
            return self.look_at_crossings();
        }
        self.sort_all()?;
        self.look_at_crossings()
    }

    /// The same where the soil has a new outline, or a particle has left it.
    pub(super) fn sort_all(&mut self) -> Result<(), Fault> {
        let mut whole = self.whole();
        let Body { solid, water, grid, surface, .. } = &mut whole;
        solid.sort(grid).map_err(|e| Fault {
            place: format!("solid particle {} at {:?} m", solid.ids[e.index], e.x),
            what: "outside the mesh".to_owned(),
        })?;
        surface.follow(solid);
        if let Some(water) = water {
            water.settle(grid, solid).map_err(|(place, what)| Fault { place, what })?;
        }
        self.kept.1 = self.kept_now();
        self.body = whole;
        self.settle_in();
        Ok(())
    }

    /// Stops before the noise of crossings is as large as the stress.
    #[cold]
    pub(super) fn look_at_crossings(&self) -> Result<(), Fault> {
        let Body { solid, most_crossings, .. } = &self.body;
        if self.damping > 0.0 || solid.crossings <= *most_crossings {
            return Ok(());
        }
        let each = solid.crossings / self.solid_count as u64;
        let what = format!(
            "its particles have crossed {each} cells each: the stress of linear functions then has noise of a tenth or more \
             and grows; \"bspline2\", \"gimp\", damping or flip < 1 reduces it, --force continues"
        );
        Err(Fault { place: "the soil".to_owned(), what })
    }

    /// What the particles keep beside their records now, by their numbers.
    pub(super) fn kept_now(&self) -> Vec<f64> {
        let (more, mut kept) = (self.kept.0, self.kept.1.clone());
        for strip in self.strips.iter().filter(|_| more > 0) {
            for cell in 0..self.nodes.frame.strip {
                for slot in 0..strip.solid.count(cell) {
                    let first = more * strip.solid.id(cell, slot) as usize;
                    for i in 0..more {
                        kept[first + i] = strip.solid.number(cell, slot, SolidPoint::<D>::COUNT + i);
                    }
                }
            }
        }
        kept
    }

    /// The body with its particles.
    pub(super) fn whole(&self) -> Body<D> {
        let mut body = self.body.clone();
        let frame = &self.nodes.frame;
        let (mut points, mut ids, mut start) = (Vec::with_capacity(self.solid_count), Vec::new(), vec![0]);
        let (mut drops, mut drop_ids, mut drop_start) = (Vec::<WaterPoint<D>>::new(), Vec::new(), vec![0]);
        for (_, position) in body.grid.walk() {
            let number = frame.number(&position);
            let (strip, cell) = (&self.strips[number / frame.strip], number % frame.strip);
            strip.solid.append(cell, &mut points, &mut ids);
            start.push(points.len() as u32);
            strip.water.append(cell, &mut drops, &mut drop_ids);
            drop_start.push(drops.len() as u32);
        }
        body.solid = Layer::in_order(&body.solid, points, ids, start);
        if let Some(water) = &mut body.water {
            water.layer = Layer::in_order(&water.layer, drops, drop_ids, drop_start);
        }
        body.surface.follow(&body.solid);
        body
    }
}

/// What particles keep beside their records at first, so many numbers by their number, and where: no velocity gradient, the first
/// state, the size that they are seeded with.
pub(super) fn first_kept<const D: usize>(body: &Body<D>, affine: bool) -> (usize, Vec<f64>, Kept) {
    let mut more = 0;
    let mut place = |wanted: bool, numbers: usize| {
        let first = SolidPoint::<D>::COUNT + more;
        more += if wanted { numbers } else { 0 };
        wanted.then_some(first)
    };
    let (affine, state) = (place(affine, D * D), place(body.materials.have_state(), STATES));
    let places = Kept { affine, state, extent: place(body.contiguous, D), strain: None };
    let mut kept = vec![0.0; more * body.solid.points.len()];
    for (point, id) in body.solid.points.iter().zip(&body.solid.ids) {
        let own = &mut kept[more * *id as usize..][..more];
        if let Some(first) = places.state {
            let state = body.materials.law(body.materials.of(*id)).first_state(&point.stress);
            own[first - SolidPoint::<D>::COUNT..][..STATES].copy_from_slice(&state);
        }
        if let Some(first) = places.extent {
            // Where an outline cuts it a particle is smaller.
            let area = point.volume / body.grid.thickness(point.x[0]);
            let size = if D == 1 { body.seed.spacing } else { area.sqrt().min(body.seed.spacing) };
            own[first - SolidPoint::<D>::COUNT..][..D].fill(size);
        }
    }
    (more, kept, places)
}
