//! Choices that are sound alone but not together.

use toml::Spanned;

use super::super::raw::RawScene;
use super::super::{Fields, Integrator, LoadOn, Side, SolidSide, Start, StrainChoice};
use super::{Checked, Reader, quoted};

impl Reader<'_> {
    /// Refuses what depends on more than two things, or on numbers: pairs are in the table of capabilities.
    pub(super) fn fits_together(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        self.incompressible_water(raw, scene)?;
        self.free_water(raw, scene)?;
        self.held_walls(raw, scene)?;
        self.about_an_axis(raw, scene)?;
        if scene.integrator.solves_displacements() {
            let mut own = raw.stages.get_ref().iter().filter_map(|stage| stage.get_ref().boundaries.as_ref());
            if let (Some(own), StrainChoice::Large) = (own.next(), scene.strain) {
                let expected =
                    "soil.strain = \"small\" with it: a mesh that has moved with its soil has no sides to support";
                return self.refuse(&own.span(), "stages.boundaries", expected, "\"large\"");
            }
            self.solved_points(raw, scene)?;
            self.quasi_static_start(raw, scene)
        } else {
            self.plate_in_a_mesh_with_room(raw, scene)
        }
    }

    /// Supports act where the mesh ends: an outline that ends beside it would have a free wall in the last row of cells.
    fn held_walls(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let Some(outline) = &scene.outline else { return Ok(()) };
        let ends =
            [(Side::Right, scene.width, scene.empty_cells_beside), (Side::Top, scene.height, scene.empty_cells_above)];
        for (side, length, room) in ends {
            let d = usize::from(side == Side::Top);
            let on = |x: &[f64; 2]| (x[d] - length).abs() <= 1e-9 * length;
            let wall = outline.iter().enumerate().any(|(i, a)| on(a) && on(&outline[(i + 1) % outline.len()]));
            let count = length / scene.cell;
            let held = !scene.always(side, SolidSide::Free) && room == 0;
            if held && wall && (count - count.round()).abs() > 1e-6 {
                let expected = format!(
                    "a cell that divides the soil up to its {side} wall into whole cells, or boundaries.{side} = \"free\": the \
                     mesh supports that wall where it ends itself"
                );
                let found = format!("{} m ({count} cells over {length} m)", scene.cell);
                return self.refuse(&raw.mesh.get_ref().cell.span(), "mesh.cell", &expected, found);
            }
        }
        Ok(())
    }

    /// An axis is no face of the soil, and strain about it is small or followed step by step.
    fn about_an_axis(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let (Some(axis), Some(dimension)) = (scene.axis(), &raw.dimension) else { return Ok(()) };
        let open = scene.solid_sides[0] == SolidSide::Free || scene.stages.iter().any(|stage| stage.drained[0]);
        let large = scene.integrator.solves_displacements() && scene.strain == StrainChoice::Large;
        let expected = match (axis == 0.0 && open, large) {
            (true, _) => "a left side on rollers that is not drained, where it is the axis, or geometry.*.inner_radius",
            (_, true) => "soil.strain = \"small\" with it where displacements are solved for, or another integrator",
            _ => return Ok(()),
        };
        self.refuse(&dimension.span(), "dimension", expected, "\"axisymmetric\"")
    }

    /// Water that does not compress needs an implicit pressure and somewhere to go.
    fn incompressible_water(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let Some(table) = &raw.water else { return Ok(()) };
        let value = &table.get_ref().bulk_modulus;
        // Under a free surface no water is closed in.
        if value.get_ref().is_finite() || scene.free_surface.is_some() {
            return Ok(());
        }
        // With empty cells above the soil the top of the mesh is not that of the soil, which is then free; under a plate it only moves as one.
        let plate = scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate);
        let closed = scene.stages.iter().position(|stage| {
            let [left, right, bottom, top] =
                stage.solid_sides.unwrap_or(scene.solid_sides).map(|s| s != SolidSide::Free);
            let held = scene.empty_cells_above == 0 && left && right && bottom && (top || plate);
            held && !stage.drained.contains(&true)
        });
        if let Some(stage) = closed.and_then(|i| raw.stages.get_ref().get(i)) {
            let span = stage.get_ref().drained.as_ref().map_or(stage.span(), Spanned::span);
            let expected = "a drained side, a free side or a finite water.bulk_modulus: \
                            in a closed volume the pressure is only known up to a constant";
            return self.refuse(&span, "stages.drained", expected, "\"none\"");
        }
        Ok(())
    }

    /// A plate is the top row of nodes of an explicit step.
    fn plate_in_a_mesh_with_room(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let Some(load) = raw.surcharge.as_ref().map(Spanned::get_ref) else { return Ok(()) };
        let room = scene.empty_cells_above > 0 || scene.empty_cells_beside > 0;
        let plate = scene.surcharge.is_some_and(|s| s.on == LoadOn::Plate);
        if let (Some(on), true) = (&load.on, plate && room) {
            let expected = "\"surface\" or \"particles\" in a mesh with empty cells: the plate is the top row of nodes of the mesh";
            return self.refuse(&on.span(), "surcharge.on", expected, quoted(on.get_ref()));
        }
        Ok(())
    }

    /// Points enough, and volumes that are used.
    fn solved_points(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let quadrature = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().quadrature.as_ref());
        if let (Some(value), None) = (quadrature, scene.shape.spline_degree()) {
            let expected = "B-splines with it and quasi-static: other shapes use the particles' volumes there";
            return self.refuse(&value.span(), "scheme.quadrature", expected, quoted(value.get_ref()));
        }
        let value = &raw.mesh.get_ref().particles_per_cell;
        if scene.shape.spline_degree().is_some() && scene.particles_per_cell < 4 {
            let expected = "at least 4 with B-splines where displacements are solved for: one per cell gives fewer points than unknowns";
            return self.refuse(&value.span(), "mesh.particles_per_cell", expected, value.get_ref());
        }
        Ok(())
    }

    /// Undrained equilibrium is that of soil which cannot move sideways; elsewhere the load is better put on at t = 0,
    /// which costs no step.
    fn quasi_static_start(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let sideways = scene.solid_sides[..2].contains(&SolidSide::Free);
        match &raw.start {
            Some(start)
                if scene.integrator == Integrator::QuasiStatic
                    && sideways
                    && scene.start == Start::UndrainedEquilibrium =>
            {
                let expected = "\"unloaded\" between free sides: undrained equilibrium has no lateral strain, \
                                and quasi-static runs apply the load undrained at once";
                self.refuse(&start.span(), "start", expected, quoted(start.get_ref()))
            }
            _ => Ok(()),
        }
    }
}
