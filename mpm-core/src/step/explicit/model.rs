//! A run as any other model.

use super::*;
use crate::order::sort_by_number;

impl<const D: usize> Model for Explicit<D> {
    fn advance(&mut self, dt: f64, steps: u64, done: &mut u64) -> Result<(), Fault> {
        match self.pool.clone() {
            Some(pool) => pool.install(|| self.steps(dt, steps, done)),
            None => self.steps(dt, steps, done),
        }
    }

    fn enter_stage(&mut self, stage: &Stage, _: &[f64]) -> Result<(), Fault> {
        self.damp_by(stage.damping);
        self.hold_sides(stage.solid_sides);
        if let Some(free) = &mut self.free {
            free.carried.open(&self.body.grid, stage.drained);
            self.is_stale = true;
            return Ok(());
        }
        let mut whole = self.whole();
        if let Some(water) = &mut whole.water {
            water.drained = stage.drained;
            water.rebuild(&whole.grid, &whole.solid);
        }
        self.kept.1 = self.kept_now();
        self.body = whole;
        self.settle_in();
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self) -> (Observation, BalanceTerms) {
        let (mut state, balance) = self.whole().observe(self.time, &self.totals, self.advected());
        let impulses = self.conditions.iter().filter_map(|condition| condition.pushed_by());
        state.plates = impulses.map(|impulse| Push { impulse, force: None }).collect();
        (state, balance)
    }

    fn pore_pressure(&self) -> [f64; 3] {
        let (mut sum, mut volume, mut low, mut high) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        let frame = &self.nodes.frame;
        for strip in &self.strips {
            for cell in 0..frame.strip {
                let [v, _] = strip.volume_and_mass(cell);
                if v > 0.0 {
                    let pressure = self.pressure[0][frame.pad() + strip.first + cell];
                    sum += pressure * v;
                    volume += v;
                    low = low.min(pressure);
                    high = high.max(pressure);
                }
            }
        }
        [sum / volume, low, high]
    }

    fn grid_speed(&self) -> f64 {
        let [x, y] = &self.nodes.motion.velocity;
        // One that is not a number stays: it is not at rest.
        let faster = |a: f64, b: f64| if b <= a || a.is_nan() { a } else { b };
        x.iter().zip(y).map(|(x, y)| x * x + y * y).fold(0.0, faster).sqrt()
    }

    fn bytes(&self) -> usize {
        let numbers = self.pressure.iter().chain(&self.of_mesh).map(Vec::capacity).sum::<usize>()
            + self.soil.capacity()
            + self.kept.1.capacity();
        let strips = self.strips.iter().map(Strip::bytes).sum::<usize>();
        let water = self.body.water.as_ref().map_or(0, |water| water.layer.bytes());
        let movers = self.movers.iter().map(Movers::bytes).sum::<usize>();
        strips
            + self.nodes.bytes()
            + numbers * size_of::<f64>()
            + movers
            + self.faces.bytes()
            + self.nodal.as_ref().map_or(0, |nodal| nodal.bytes())
            + self.free.as_ref().map_or(0, |free| free.bytes())
            + self.solver.as_ref().map_or(0, |solver| solver.bytes())
            + self.domains.as_ref().map_or(0, |domains| domains.bytes())
            + self.body.solid.bytes()
            + water
            + self.tops.bytes()
            + self.loaded.bytes()
    }

    fn solid_count(&self) -> usize {
        self.solid_count
    }

    fn particles(&self) -> Vec<SolidState> {
        self.whole().particles(self.advected())
    }

    fn water_particles(&self) -> Vec<WaterParticle> {
        let two = |v: &[f64; D]| [if D == 2 { v[0] } else { 0.0 }, v[D - 1]];
        let whole = self.whole();
        let points = whole.water.iter().flat_map(|water| &water.layer.points);
        let seen = |p: &WaterPoint<D>| WaterParticle {
            x: two(&p.x),
            velocity: two(&p.v),
            pressure: p.pressure,
            volume: p.volume,
        };
        points.map(seen).collect()
    }

    fn places(&self) -> Places {
        let whole = self.whole();
        let of_pores = whole.water.as_ref().map(|water| &water.layer.points[..]);
        let of_free = self.advected().map(|free| &free.layer.points[..]);
        let mut numbered: Vec<_> = whole.solid.ids.iter().zip(&whole.solid.points).collect();
        sort_by_number(&mut numbered, |(id, _)| f64::from(**id));
        Places::of(numbered.into_iter().map(|(_, point)| point), of_pores.or(of_free).unwrap_or(&[]))
    }

    fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        let mut kept = self.kept_now();
        let mut whole = self.whole();
        whole.save_or_restore(archive)?;
        if let Some(free) = &mut self.free {
            free.carried.save_or_restore(archive, &self.body.grid)?;
        }
        if let Some(origin) = &mut self.origin {
            archive.slice(origin.as_flattened_mut())?;
        }
        archive.slice(&mut kept)?;
        for list in self.nodes.motion.velocity.iter_mut().chain(&mut self.of_mesh) {
            archive.slice(list)?;
        }
        archive!(archive.value: self.damping, self.sides, self.time, self.totals);
        for condition in &mut self.conditions {
            condition.save_or_restore(archive)?;
        }
        if let Some(solver) = &mut self.solver {
            archive.value(&mut solver.work)?;
        }
        if archive.restores() {
            self.damp_by(self.damping);
            self.hold_sides(self.sides);
            self.solid_count = whole.solid.points.len();
            self.kept.1 = kept;
            self.body = whole;
            self.settle_in();
        }
        Ok(())
    }

    fn work(&self) -> Work {
        self.solver.as_ref().map_or_else(Work::default, |solver| solver.work)
    }

    fn stages(&self) -> &'static [&'static str] {
        &["loads", "equation of motion", "outflow", "particles to mesh alone", "Darcy flow, mesh to particles to mesh"]
    }

    fn do_stage(&mut self, stage: usize, dt: f64) {
        let pool = self.pool.clone();
        let mut stage = || match stage {
            0 => self.load(),
            1 => _ = self.equation_of_motion(dt),
            2 => self.darcy_flow(dt),
            3 => self.pass(false, dt),
            _ => self.pass(true, dt),
        };
        match pool {
            Some(pool) => pool.install(stage),
            None => stage(),
        }
    }
}
