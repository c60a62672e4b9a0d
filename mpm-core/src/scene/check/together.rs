//! Choices that are sound alone but not together.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::RawScene;
use super::super::{
    DarcyChoice, Dimension, Integrator, LoadOn, Scene, ShapeChoice, Side, SolidSide, Start, StepChoice, StrainChoice,
    TimeMethod, Until,
};
use super::{Checked, Reader, quoted};

impl Reader<'_> {
    /// Refuses what the integrator of a scene cannot do, or would not heed.
    pub(super) fn fits_together(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        self.load(raw, scene)?;
        self.incompressible_water(raw, scene)?;
        self.two_clocks(raw, scene)?;
        self.transfers(raw, scene)?;
        if scene.integrator == Integrator::QuasiStatic {
            self.quasi_static_scheme(raw, scene)?;
            self.quasi_static_time(raw, scene)?;
            self.quasi_static_start(raw, scene)
        } else {
            self.wide_kernels(raw, scene)?;
            self.only_quasi_static(raw, scene)
        }
    }

    /// Kernels over stencils know one pressure per cell and the flow through faces, and want water to be implicit in.
    fn wide_kernels(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let semi = scene.integrator == Integrator::SemiImplicit;
        let integrator = raw.time.as_ref().and_then(|time| time.get_ref().integrator.as_ref());
        if let (Some(value), true, None) = (integrator, semi, scene.water) {
            let expected = "a [water] table beside it: a dry scene has no pressure to solve for";
            return self.refuse(&value.span(), "time.integrator", expected, quoted(value.get_ref()));
        }
        if let Some(value) = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().shape.as_ref())
            && scene.shape == ShapeChoice::Bspline3
        {
            // At an open end the slope 3 (1 - xi)^2/L of the first function has the mean 15/16 at two particles, 63/64 at four.
            let expected = "integrator = \"quasi-static\" beside it, which fits weights: particles of equal volumes do not \
                            balance a uniform stress at the ends of cubic B-splines, and \"bspline2\" is nearer";
            return self.refuse(&value.span(), "scheme.shape", expected, quoted(value.get_ref()));
        }
        let corners = !scene.shape.is_wide();
        let darcy = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().darcy.as_ref());
        if let (Some(value), DarcyChoice::Nodal, true) = (darcy, scene.darcy, semi || !corners) {
            let expected = "\"face\", or integrator = \"explicit\" and shape = \"centre\" or \"linear\" beside it";
            return self.refuse(&value.span(), "scheme.darcy", expected, quoted(value.get_ref()));
        }
        Ok(())
    }

    /// Ways to carry velocities that the explicit step alone knows.
    fn transfers(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let Some(scheme) = raw.scheme.as_ref().map(Spanned::get_ref) else { return Ok(()) };
        if let (Some(word), Some(base), false) = (&scheme.update, &raw.base, scene.update.is_default()) {
            let expected =
                format!("\"usl\" beside [base] (line {}): friction is with the nodes", self.line(&base.span()));
            return self.refuse(&word.span(), "scheme.update", &expected, quoted(word.get_ref()));
        }
        if scene.integrator == Integrator::Explicit && scene.free_surface.is_none() {
            return Ok(());
        }
        let expected = "integrator = \"explicit\" beside it, in a scene without a free surface of water";
        if let (Some(word), false) = (&scheme.transfer, scene.transfer.is_default()) {
            return self.refuse(&word.span(), "scheme.transfer", expected, quoted(word.get_ref()));
        }
        if let (Some(word), false) = (&scheme.update, scene.update.is_default()) {
            return self.refuse(&word.span(), "scheme.update", expected, quoted(word.get_ref()));
        }
        Ok(())
    }

    /// Where the load stands, and what depends on it.
    fn load(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let (Some(load), Some(table)) = (scene.surcharge, &raw.surcharge) else { return Ok(()) };
        let held =
            [Side::Left, Side::Right].into_iter().find(|side| scene.solid_sides[*side as usize] == SolidSide::Fixed);
        if let (LoadOn::Plate, Some(side)) = (load.on, held) {
            let expected = "\"surface\" beside it, or \"roller\" or \"free\" sides: soil that is held at the edge of a plate \
                            cannot follow it, and its stress grows with every refinement";
            let span = table.get_ref().on.as_ref().map_or(table.span(), Spanned::span);
            return self.refuse(
                &span,
                "surcharge.on",
                expected,
                format!("\"plate\" with boundaries.{side} = \"fixed\""),
            );
        }
        let Some(strip) = &table.get_ref().strip else { return Ok(()) };
        if scene.dimension == Dimension::Column {
            let expected = "dimension = \"plane-strain\" beside it: a column is loaded all over";
            return self.refuse(&strip.span(), "surcharge.strip", expected, "\"column\"");
        }
        if load.on == LoadOn::Plate {
            let expected = "on = \"surface\" or \"particles\" beside it: a plate spreads its load itself";
            return self.refuse(&strip.span(), "surcharge.strip", expected, "\"plate\"");
        }
        if let (Some(start), Start::UndrainedEquilibrium) = (&raw.start, scene.start) {
            let expected = "\"unloaded\" under a strip: undrained equilibrium is that of a load all over";
            return self.refuse(&start.span(), "start", expected, quoted(start.get_ref()));
        }
        Ok(())
    }

    /// Water that does not compress needs an implicit pressure and somewhere to go.
    fn incompressible_water(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let Some(table) = &raw.water else { return Ok(()) };
        let value = &table.get_ref().bulk_modulus;
        // Under a free surface no water is closed in, but an explicit pressure needs its stiffness all the same.
        let free = scene.free_surface.is_some() && scene.integrator != Integrator::Explicit;
        if value.get_ref().is_finite() || free {
            return Ok(());
        }
        if scene.integrator == Integrator::Explicit {
            let expected = "a finite bulk modulus (Pa): the explicit step follows its pressure wave";
            return self.refuse(&value.span(), "water.bulk_modulus", expected, value.get_ref());
        }
        // With headroom the top of the mesh is not that of the soil, which is then free.
        let held = scene.headroom_cells == 0 && scene.solid_sides.iter().all(|side| *side != SolidSide::Free);
        let closed = scene.stages.iter().position(|stage| !stage.drained.contains(&true));
        if let (true, Some(stage)) = (held, closed.and_then(|i| raw.stages.get_ref().get(i))) {
            let span = stage.get_ref().drained.as_ref().map_or(stage.span(), Spanned::span);
            let expected = "a drained side, a free side or a finite water.bulk_modulus: \
                            closed in and held, the pressure is only known up to a constant";
            return self.refuse(&span, "stages.drained", expected, "\"none\"");
        }
        Ok(())
    }

    /// Keys that the other integrators have no use for.
    fn only_quasi_static(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let mesh = raw.mesh.get_ref();
        if let Some(value) = &mesh.shift {
            return self.beside_quasi_static(&value.span(), "mesh.shift", scene.integrator);
        }
        if let Some(table) = &mesh.displaced {
            return self.beside_quasi_static(&table.span(), "mesh.displaced", scene.integrator);
        }
        if let (Some(value), StrainChoice::Small) = (&raw.soil.get_ref().strain, scene.strain) {
            let expected = "\"large\", or integrator = \"quasi-static\": the others move their particles";
            return self.refuse(&value.span(), "soil.strain", expected, quoted(value.get_ref()));
        }
        if let Some(value) = raw.scheme.as_ref().and_then(|s| s.get_ref().jump_penalty.as_ref()) {
            return self.beside_quasi_static(&value.span(), "scheme.jump_penalty", scene.integrator);
        }
        let Some(load) = raw.surcharge.as_ref().map(Spanned::get_ref) else { return Ok(()) };
        let room = scene.headroom_cells > 0 || scene.sideroom_cells > 0;
        let plate = scene.surcharge.is_some_and(|s| s.on == LoadOn::Plate);
        if let (Some(on), true) = (&load.on, plate && (room || scene.free_surface.is_some())) {
            let expected =
                "\"surface\" or \"particles\" in a mesh with room to move: the plate is its top row of nodes";
            return self.refuse(&on.span(), "surcharge.on", expected, quoted(on.get_ref()));
        }
        Ok(())
    }

    pub(super) fn beside_quasi_static<T>(&self, span: &Range<usize>, key: &str, found: Integrator) -> Checked<T> {
        let found = match found {
            Integrator::Explicit => "\"explicit\"",
            Integrator::SemiImplicit => "\"semi-implicit\"",
            Integrator::QuasiStatic => "\"quasi-static\"",
            Integrator::TwoClocks => "\"two-clocks\"",
            Integrator::Coupled => "\"coupled\"",
        };
        self.refuse(span, key, "integrator = \"quasi-static\" beside it", found)
    }

    /// Space: no inertia, face flow, points enough.
    fn quasi_static_scheme(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        if let Some(scheme) = raw.scheme.as_ref().map(Spanned::get_ref) {
            if let (Some(value), false) = (&scheme.quadrature, scene.shape.spline_degree().is_some()) {
                let expected = "B-splines beside it and quasi-static: other shapes use the particles' volumes there";
                return self.refuse(&value.span(), "scheme.quadrature", expected, quoted(value.get_ref()));
            }
            if let (Some(value), DarcyChoice::Nodal) = (&scheme.darcy, scene.darcy) {
                let expected = "\"face\" beside quasi-static: the nodal flow is a velocity of an explicit step";
                return self.refuse(&value.span(), "scheme.darcy", expected, quoted(value.get_ref()));
            }
            if let Some(value) = scheme.darcy_inertia.as_ref().filter(|inertia| *inertia.get_ref()) {
                let expected = "false, or no such key: quasi-static has no inertia";
                return self.refuse(&value.span(), "scheme.darcy_inertia", expected, value.get_ref());
            }
            if let Some(value) = &scheme.flip {
                let expected = "no such key beside quasi-static, which carries no velocities";
                return self.refuse(&value.span(), "scheme.flip", expected, value.get_ref());
            }
        }
        let value = &raw.mesh.get_ref().particles_per_cell;
        if scene.shape.spline_degree().is_some() && scene.particles_per_cell < 4 {
            let expected = "at least 4 with B-splines and quasi-static: one per cell is fewer points than unknowns";
            return self.refuse(&value.span(), "mesh.particles_per_cell", expected, value.get_ref());
        }
        Ok(())
    }

    /// Time: steps from the tolerance, no waves to wait for or to damp.
    fn quasi_static_time(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        if let Some(time) = raw.time.as_ref().map(Spanned::get_ref) {
            if let (Some(value), StepChoice::Paper) = (&time.step, scene.step) {
                return self.refuse(&value.span(), "time.step", "\"auto\" or a step above 0 (s)", "\"paper\"");
            }
            if let (Some(value), TimeMethod::Krylov, StrainChoice::Large) = (&time.method, scene.method, scene.strain) {
                let expected = "soil.strain = \"small\" beside it: the Krylov method is for linear scenes";
                return self.refuse(&value.span(), "time.method", expected, quoted(value.get_ref()));
            }
        }
        for (raw, stage) in raw.stages.get_ref().iter().map(Spanned::get_ref).zip(&scene.stages) {
            if let Some(value) = raw.damping.as_ref().filter(|damping| *damping.get_ref() > 0.0) {
                let expected = "no damping beside quasi-static, which has no inertia";
                return self.refuse(&value.span(), "stages.damping", expected, value.get_ref());
            }
            if let Until::PorePressure { .. } = stage.until {
                let expected = "time or time_factor: quasi-static carries a load undrained at once";
                return self.refuse(&raw.until.span(), "stages.until", expected, "pore_pressure_within");
            }
        }
        Ok(())
    }

    /// Undrained equilibrium is that of soil which cannot move sideways; elsewhere the load is better put on at t = 0,
    /// which costs no step.
    fn quasi_static_start(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let sideways = scene.solid_sides[..2].contains(&SolidSide::Free);
        match &raw.start {
            Some(start) if sideways && scene.start == Start::UndrainedEquilibrium => {
                let expected = "\"unloaded\" between free sides: undrained equilibrium has no lateral strain, \
                                and quasi-static carries the load undrained at once";
                self.refuse(&start.span(), "start", expected, quoted(start.get_ref()))
            }
            _ => Ok(()),
        }
    }
}
