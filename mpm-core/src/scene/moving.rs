//! Soil that moves through the cells of its mesh: when it does, what that asks of a scheme, and what no scheme bears.

use super::{Dimension, Elastic, Integrator, LoadOn, Scene, ShapeChoice, Side, SolidSide, UpdateChoice};

/// The usual share of a full node's mass below which nodes move with a neighbour.
const LIGHT_NODES: f64 = 0.1;
/// Cells that a load may push a surface down through under linear functions.
const MOST_SETTLED: f64 = 0.5;

/// A load that no run with the scene's scheme gives a useful answer to.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("surcharge.pressure: expected {expected}, found {found}; --force runs it all the same")]
pub struct UnfitLoad {
    /// What the scheme bears.
    pub expected: &'static str,
    /// What the load would do.
    pub found: String,
}

impl Scene {
    /// Whether soil may come to fill cells in part: it has an outline or room beside it, nothing holds its base, or its load
    /// and weight would settle its surface by more than a fifth of a cell.
    pub fn moves_through_cells(&self) -> bool {
        let load = self.surcharge.map_or(0.0, |s| s.pressure.abs());
        let weight = self.gravity.unwrap_or(0.0) * self.mixture_density() * self.height;
        let softest = self.layers.iter().map(|layer| layer.elastic.oedometer_modulus());
        let settled = (load + 0.5 * weight) / softest.fold(self.oedometer_modulus(), f64::min) * self.height;
        self.outline.is_some()
            || self.sideroom_cells > 0
            || self.solid_sides[Side::Bottom as usize] == SolidSide::Free
            || settled > 0.2 * self.cell
    }

    /// Cells that a particle may cross, on average, before linear functions have made too much noise; `u64::MAX` where nothing
    /// limits them: other functions, PIC, soil with a strength or with water, whose drag damps it, or a scene that is forced.
    ///
    /// A particle that crosses a face jumps from one gradient to another. What that stirs does not die out without damping or
    /// PIC: in the hard case `crossing-column` the stress is off by a tenth after 100 cells, by six tenths after 300, and by
    /// more than itself after 1000; with MUSL a tenth is reached after 10.
    pub fn most_crossings(&self) -> u64 {
        let noisy = self.integrator == Integrator::Explicit && self.has_jumping_gradients() && self.flip == 1.0;
        let noisy = noisy && self.strength.is_none() && self.water.is_none();
        match (noisy && !self.force, self.update) {
            (false, _) => u64::MAX,
            (true, UpdateChoice::Usl) => 100,
            (true, UpdateChoice::Musl) => 10,
        }
    }

    /// Share of a full node's mass below which nodes move with a neighbour where the scene does not say it: the explicit step
    /// of linear functions has no stable length for a node of no mass.
    pub fn usual_light_nodes(&self) -> f64 {
        let room = self.outline.is_some() || self.sideroom_cells > 0;
        let explicit = self.integrator == Integrator::Explicit;
        let alone = explicit && self.has_jumping_gradients() && self.moves_through_cells();
        // Of a particle that is alone, nodes with less than a quarter of it.
        let one = 0.25 * self.spacing().powi(if self.dimension == Dimension::Column { 1 } else { 2 });
        let full = self.cell.powi(if self.dimension == Dimension::Column { 1 } else { 2 });
        if room || alone { LIGHT_NODES.max(one / full) } else { 0.0 }
    }

    /// Whether shape functions are linear in a cell or less, so that gradients jump at its faces.
    fn has_jumping_gradients(&self) -> bool {
        !matches!(self.shape, ShapeChoice::Gimp | ShapeChoice::Bspline2)
    }

    /// What a surcharge leaves behind: settlement (m), and the smallest porosity of any layer (not above the first).
    ///
    /// Cauchy stress q and a constant modulus make each layer `exp(-q/M)` times as thick, with M + Q in place of M in soil
    /// that nothing drains.
    fn under_load(&self) -> (f64, f64) {
        let closed = self.water.is_some() && self.free_surface.is_none();
        let closed = closed && !self.stages.iter().any(|stage| stage.drained.contains(&true));
        let water = if closed { self.pore_stiffness() } else { 0.0 };
        let load = self.surcharge.map_or(0.0, |s| s.pressure);
        let of = |elastic: &Elastic, thickness: f64| {
            let strain = load / (elastic.oedometer_modulus() + water);
            let porosity = self.porosity - (1.0 - self.porosity) * strain.max(0.0).exp_m1();
            (-(-strain).exp_m1() * thickness, porosity)
        };
        if self.layers.is_empty() {
            return of(&self.elastic, self.height);
        }
        let each = self.thicknesses().map(|(layer, thickness)| of(&layer.elastic, thickness));
        each.fold((0.0, self.porosity), |(settled, least), (s, n)| (settled + s, least.min(n)))
    }

    /// Porosity of the soil that a surcharge has compressed most, `1 - (1 - n) h_0/h`, -; not above the first.
    pub(crate) fn compressed_porosity(&self) -> f64 {
        self.under_load().1
    }

    /// Refuses a load that pushes a surface down through its cells under linear functions, or squeezes out more water than
    /// there is, unless the scene is forced.
    ///
    /// With linear functions the stress of a top cell that is filled in part to f is `q` times the load's share of the upper
    /// node over f: anything from q/2 to 3 q/2 as the surface comes down, and the soil below follows. In the hard case
    /// `loaded-surface` semi-implicit settlements are off by 6 % after 0.3 cells, 15 % after half a cell, 36 % after one.
    ///
    /// # Errors
    /// What is refused, and why.
    pub fn bears_its_load(&self) -> Result<(), UnfitLoad> {
        let steps = matches!(self.integrator, Integrator::Explicit | Integrator::SemiImplicit);
        let load = self.surcharge.filter(|load| load.on != LoadOn::Plate && steps && !self.force);
        let Some(load) = load else { return Ok(()) };
        let (settled, porosity) = self.under_load();
        if self.has_jumping_gradients() && settled.abs() > MOST_SETTLED * self.cell {
            let expected = "shape = \"bspline2\" or \"gimp\", or integrator = \"quasi-static\", under a load that moves the \
                            surface by more than half a cell: linear functions are wrong there";
            let found =
                format!("{:.4e} Pa, which would move it by {:.2} cells", load.pressure, settled.abs() / self.cell);
            return Err(UnfitLoad { expected, found });
        }
        if self.water.is_some() && porosity <= 0.0 {
            let expected = "a load under which the soil keeps water in its pores";
            let (share, first) = (settled / self.height, self.porosity);
            let found = format!("{:.4e} Pa, which would shorten soil of porosity {first} by {share:.3}", load.pressure);
            return Err(UnfitLoad { expected, found });
        }
        Ok(())
    }
}
