//! Soil that moves through the cells of its mesh: when it does, what that asks of a scheme, and what no scheme bears.

use super::{
    Dimension, DomainChoice, Fields, Integrator, LoadOn, ShapeChoice, Side, Soil, SolidSide, Start, StrainChoice,
    UpdateChoice, Waves,
};

/// The usual share of a full node's mass below which nodes move with a neighbour.
const LIGHT_NODES: f64 = 0.1;
/// Cells that the surface may move through where the volume of soil in a cell is only known from its particles, or where
/// functions reach beyond a cell: at a tenth of a cell its stress is off by as much.
const MOST_SETTLED: f64 = 0.1;
/// A porosity that is 0 but for round-off is that of pores which close at the very end.
const CLOSED_PORES: f64 = 1e-9;
/// The same under a plate, which is the top row of nodes: soil must stay below it.
const MOST_UNDER_PLATE: f64 = 0.5;
/// Strain up to which the geometry may be kept as it was: small strain is off by half of it.
const MOST_SMALL_STRAIN: f64 = 0.1;
/// Passages of a wave of the drained soil over the height after which waves have died out, or are not what is asked for.
pub(crate) const PASSAGES: f64 = 10.0;
/// Share of a settlement that may be missing because the transfer of velocities makes the soil viscous.
const MOST_LATE: f64 = 0.01;
/// Above this a small strain is worth a word: it is off by more than 1 %.
const NOTABLE_SMALL_STRAIN: f64 = 0.02;

/// A load or a weight that no run with the scene's scheme gives a useful answer to.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: expected {expected}, found {found}; --force runs it anyway")]
pub struct UnfitLoad {
    /// The key to change.
    pub key: &'static str,
    /// What the scheme bears.
    pub expected: &'static str,
    /// What load and weight would do.
    pub found: String,
}

/// What load and weight do to level soil in one dimension, without a run: elastic, finite strain, at the end.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Settlement from the state the run starts from, m; negative for heave.
    pub settlement_m: f64,
    /// Largest strain in size, logarithmic, compression positive.
    pub strain: f64,
    /// Smallest porosity, -; not above the first.
    pub porosity: f64,
}

/// Settlement in cells up to which soil is not taken to move through them.
pub(crate) const THROUGH_CELLS: f64 = 0.2;

/// Error of a dynamic settlement, of the mean strain, while hardly a particle leaves its cell: particles have the stress and strain
/// of the middle of a cell from whose middle they have gone. Measured on 4 to 57 rows: +0.4 under a load, -0.65 under weight.
const OFF_BEFORE: f64 = 0.65;

/// The most that this comes to as particles cross, times the rows: 2.4 % of 8 rows at mean strains of 1 to 15 %.
const OFF_PER_ROW: f64 = 0.2;

/// The same of particles that are boxes, times the square of the rows: 1.0 % of 10 rows at a mean strain of 30 %, 0.5 % at 20 %.
const OFF_OF_BOXES: f64 = 1.0;

impl Fields {
    /// Whether soil may come to fill cells in part, so that nodes may be light and steps shorter: it has an outline or empty cells beside
    /// it, nothing holds its base, or its load and weight would move its surface by more than a fifth of a cell. That is a matter
    /// of how the same equations are solved; which are solved does not depend on the mesh.
    pub fn moves_through_cells(&self) -> bool {
        self.outline.is_some()
            || self.empty_cells_beside > 0
            || self.solid_sides[Side::Bottom as usize] == SolidSide::Free
            || self.estimate().settlement_m.abs() > THROUGH_CELLS * self.cell
    }

    /// Cells that a particle may cross, on average, before linear functions have made too much noise; `u64::MAX` where nothing
    /// limits them: other functions, PIC, soil with a strength or with water, whose drag damps it, or a scene that is forced.
    ///
    /// A particle that crosses a face jumps from one gradient to another. What that stirs does not die out without damping or
    /// PIC: in the hard case `crossing-column` the stress is off by a tenth after 100 cells, by six tenths after 300, and by
    /// more than itself after 1000; with MUSL a tenth is reached after 10.
    pub fn most_crossings(&self) -> u64 {
        let noisy = self.integrator == Integrator::Explicit && self.has_jumping_gradients() && self.flip == 1.0;
        let noisy = noisy && self.is_elastic() && self.water.is_none();
        match (noisy && !self.force, self.update) {
            (false, _) => u64::MAX,
            (true, UpdateChoice::Usl) => 100,
            (true, UpdateChoice::Musl) => 10,
        }
    }

    /// Share of a full node's mass below which nodes move with a neighbour where the scene does not say it: the explicit step
    /// of linear functions has no stable length for a node of no mass.
    pub fn usual_light_nodes(&self) -> f64 {
        // Semi-implicit pressures push every node: none follows another.
        let solves = self.integrator == Integrator::SemiImplicit;
        let room = (self.empty_cells_beside > 0 || self.outline.is_some()) && !self.stands() && !solves;
        let explicit = self.integrator == Integrator::Explicit;
        let alone = explicit && self.has_jumping_gradients() && self.moves_through_cells() && !self.lends_inertia();
        // Of a particle that is alone, nodes with less than a quarter of it.
        let one = 0.25 * self.spacing().powi(if self.dimension == Dimension::Column { 1 } else { 2 });
        let full = self.cell.powi(if self.dimension == Dimension::Column { 1 } else { 2 });
        if room || alone { LIGHT_NODES.max(one / full) } else { 0.0 }
    }

    /// Whether nodes of the surface with too little mass for an explicit step get added inertia: where the geometry says how much
    /// soil a cell holds, a node that moved with its neighbour would keep that soil from straining with the rest.
    pub fn lends_inertia(&self) -> bool {
        let explicit = self.integrator == Integrator::Explicit && self.light_nodes == 0.0;
        let known = crate::boundary::knows_volumes(self) || self.stands();
        explicit && known && self.moves_through_cells()
    }

    /// Whether soil of any outline stands where it is: it is fixed below, starts at rest, cannot yield, and no water moves the surface of
    /// what it carries. Nodes that moved with others would make a surface within its cell stiff.
    fn stands(&self) -> bool {
        let held = self.solid_sides[Side::Bottom as usize] != SolidSide::Free && self.base.is_none();
        let still = self.start_velocity.is_none() && self.free_surface.is_none() && self.is_elastic();
        self.outline.is_some() && held && still && !self.shape.is_wide()
    }

    /// Whether shape functions are linear in a cell or less, so that gradients jump at its faces.
    fn has_jumping_gradients(&self) -> bool {
        !self.shape.is_wide()
    }

    /// What load and weight do at the end. Cauchy stress s and a constant modulus make soil `exp(-s/M)` times as thick as it
    /// was unloaded, with M + Q in place of M in soil that nothing drains; what a geostatic start carries has been done before.
    pub fn estimate(&self) -> Estimate {
        let wet = self.water.is_some() && self.free_surface.is_none();
        let closed = wet && !self.stages.iter().any(|stage| stage.drained.contains(&true));
        let buoyancy = self.water.map_or(0.0, |w| if wet && !closed { w.density } else { 0.0 });
        let gravity = self.gravity.unwrap_or(0.0);
        // What drains, the soil bears.
        let load = self.load_on_top() + if closed { 0.0 } else { self.largest_excess() };
        let borne = matches!(self.start, Start::Geostatic | Start::Given);
        let of = |soil: &Soil, [least, most]: [f64; 2], thickness: f64| {
            let stiffness = if closed { self.pore_stiffness_of(soil) } else { 0.0 };
            let modulus = soil.elastic.oedometer_modulus() + stiffness;
            // Mean of exp(-weight/M) over the layer: (1 - exp(-x))/x exp(-first).
            let mean = |first: f64, last: f64| {
                let x = (last - first) / modulus;
                (-first / modulus).exp() * if x.abs() < 1e-12 { 1.0 } else { -(-x).exp_m1() / x }
            };
            let before = if borne { 1.0 } else { mean(least, most) };
            let after = (-load / modulus).exp() * before;
            let from = if borne { 1.0 } else { mean(0.0, 0.0) };
            let strain = (load + if borne { 0.0 } else { most }) / modulus;
            let other = (load + if borne { 0.0 } else { least }) / modulus;
            ((from - after) * thickness, [strain, other])
        };
        // From the surface down, under the weight of what is above.
        let mut above = 0.0;
        let mut layers: Vec<(f64, [f64; 2])> = Vec::new();
        for ([base, top], soil) in self.middle().into_iter().rev() {
            let weight = gravity * (self.mixture_density_of(&soil) - buoyancy) * (top - base);
            layers.push(of(&soil, [above, above + weight], top - base));
            above += weight;
        }
        let strains = layers.iter().flat_map(|(_, strains)| *strains);
        let most = strains.clone().fold(0.0, f64::max);
        Estimate {
            settlement_m: layers.iter().map(|(settled, _)| settled).sum(),
            strain: strains.fold(0.0, |worst: f64, e| if e.abs() > worst.abs() { e } else { worst }),
            porosity: self.porosity - (1.0 - self.porosity) * most.exp_m1(),
        }
    }

    /// What the scene's own choices cost that they say nothing about; one sentence each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let strain = self.estimate().strain.abs();
        if self.strain == StrainChoice::Small && strain > NOTABLE_SMALL_STRAIN && self.is_level_column() {
            let off = 50.0 * strain;
            notes.push(format!(
                "soil.strain = \"small\" under a strain of {:.1} %: settlements have an error of about {off:.1} %",
                1e2 * strain
            ));
        }
        let (rows, settled) = (self.cells[1] as f64, self.estimate().settlement_m.abs());
        // Errors of boxes that stretch with the soil fall nearly as of second order.
        let contiguous = self.particle_domain == DomainChoice::Contiguous;
        let most = if contiguous { OFF_OF_BOXES / (rows * rows) } else { OFF_PER_ROW / rows };
        let off = (OFF_BEFORE * settled / self.height).min(most);
        let dynamic = !self.integrator.solves_displacements() && self.integrator != Integrator::Staggered;
        if dynamic && self.is_level_column() && self.is_elastic() && off > 0.01 {
            notes.push(format!(
                "the surface moves by {:.2} cells, of {rows} rows: settlements have an error of up to {:.1} %; {}more rows or \
                 integrator = \"quasi-static\" are nearer",
                settled / self.cell,
                1e2 * off,
                if contiguous { "" } else { "particle_domain = \"contiguous\", " }
            ));
        }
        let asked = self.observe_times.first().copied().unwrap_or(f64::INFINITY);
        let is_excited =
            self.start == Start::Unloaded && self.surcharge.is_some_and(|load| load.ramp_time < self.passage());
        if self.integrator == Integrator::SemiImplicit && is_excited && asked < PASSAGES * self.passage() {
            notes.push(format!(
                "observed from {asked:.2e} s on, {:.2} passages of a wave through the soil after a quick load: an implicit pressure damps \
                 the waves of the water; integrator = \"implicit\" resolves them",
                asked / self.passage()
            ));
        }
        notes
    }

    /// Time in which a wave of the drained soil passes its height, s.
    pub fn passage(&self) -> f64 {
        self.height * (self.mixture_density() / self.oedometer_modulus()).sqrt()
    }

    /// Share of the settlement that soil which drains is behind by at the first observed time, because a part `1 - flip` of
    /// velocities is smoothed over a cell in every step: `rho (1 - flip) L^2/(8 dt)` is a viscosity, over M a time by which all is
    /// late, and settlement grows as the root of time. Columns with PIC are behind by three quarters of that at Tv = 0.5.
    fn late_by_transfer(&self) -> Option<f64> {
        let drains = self.water.is_some() && self.stages.last().is_some_and(|stage| stage.drained.contains(&true));
        let first = self.observe_times.first().filter(|_| drains && self.free_surface.is_none() && self.flip < 1.0)?;
        let dt = crate::stability::choose_step(self).ok()?;
        let viscosity = self.mixture_density() * (1.0 - self.flip) * self.cell * self.cell / (8.0 * dt);
        Some(0.5 * viscosity / self.oedometer_modulus() / first)
    }

    /// Whether errors of waves count in implicit steps that are first asked for a time (s since the start of their stage).
    pub fn resolves_waves(&self, asked: f64) -> bool {
        match (self.integrator, self.waves) {
            (Integrator::Implicit, Waves::Auto) => asked < PASSAGES * self.passage(),
            (Integrator::Implicit, Waves::Resolved) => true,
            _ => false,
        }
    }

    /// Refuses what no run of the scene's scheme gives a useful answer to: soil that moves through its cells where a scheme does
    /// not follow it, small strain that is not small, more water squeezed out than there is. A scene that is forced goes.
    ///
    /// # Errors
    /// What is refused, and what to use.
    pub fn bears_its_load(&self) -> Result<(), UnfitLoad> {
        if self.force || !self.is_level_column() || !self.is_elastic() {
            return Ok(());
        }
        let Estimate { settlement_m, strain, porosity } = self.estimate();
        let would = format!(
            "load and weight that would move the surface by {settlement_m:.4} m, {:.2} cells, at a strain of up to {:.1} %",
            settlement_m.abs() / self.cell,
            1e2 * strain.abs()
        );
        let refuse = |key, expected| Err(UnfitLoad { key, expected, found: would.clone() });
        if self.strain == StrainChoice::Small && strain.abs() > MOST_SMALL_STRAIN {
            return refuse("soil.strain", "\"large\" where strains are: small strain is off by half of them");
        }
        if self.water.is_some() && porosity < -CLOSED_PORES {
            return refuse("surcharge.pressure", "a load that leaves water in the pores of the soil");
        }
        if self.integrator.solves_displacements() {
            return Ok(());
        }
        let moved = settlement_m.abs() / self.cell;
        if self.surcharge.is_some_and(|load| load.on == LoadOn::Plate) {
            return if moved <= MOST_UNDER_PLATE {
                Ok(())
            } else {
                refuse("surcharge.on", "integrator = \"quasi-static\" with a plate that moves by more than half a cell")
            };
        }
        if !self.has_jumping_gradients() && moved > MOST_SETTLED {
            return refuse(
                "scheme.shape",
                "\"centre\", \"linear\" or \"b-bar\", or integrator = \"quasi-static\", where the surface moves by more than a \
                 tenth of a cell: wider functions do not see where it is",
            );
        }
        if self.shape == ShapeChoice::Gimp
            && self.empty_cells_above > 0
            && self.solid_sides[Side::Bottom as usize] != SolidSide::Free
        {
            return Err(UnfitLoad {
                key: "mesh.empty_cells_above",
                expected: "0 with \"gimp\", whose functions reach beyond the surface: the nodes there have almost no mass",
                found: self.empty_cells_above.to_string(),
            });
        }
        let (single, on_points) =
            (self.particles_per_cell == 1, self.surcharge.is_some_and(|s| s.on == LoadOn::Particles));
        if self.shape.spline_degree().is_some() && single && (self.gravity.is_some() || on_points) {
            return Err(UnfitLoad {
                key: "mesh.particles_per_cell",
                expected: "4 or more with B-splines under weight or a load on particles: one per cell gives fewer points than unknowns",
                found: "1".to_owned(),
            });
        }
        if let Some(late) = self.late_by_transfer().filter(|late| *late > MOST_LATE) {
            return Err(UnfitLoad {
                key: "scheme.flip",
                expected: "nearer to 1, or longer steps (time.step, time.safety): the velocity that particles lose in every step acts like a \
                           viscosity, and soil that drains settles late",
                found: format!("{}, which delays the settlement by {:.1} % at the first time", self.flip, 1e2 * late),
            });
        }
        let known = crate::boundary::knows_volumes(self);
        if !known && moved > MOST_SETTLED {
            return refuse(
                "scheme.quadrature",
                "\"fitted\" between rollers, or integrator = \"quasi-static\", where the surface moves by more than a tenth of a cell: \
                 particles' volumes do not say how much of a cell is soil",
            );
        }
        if settlement_m < 0.0
            && moved > 0.5 / self.particles_per_direction() as f64
            && (self.empty_cells_above as f64) < moved
        {
            return refuse(
                "mesh.empty_cells_above",
                "at least at least as many rows of empty cells as the surface rises by",
            );
        }
        if strain < -1e-3 && self.particles_per_direction() == 1 {
            return refuse(
                "mesh.particles_per_cell",
                "4 or more in soil that swells: single particles would leave cells empty",
            );
        }
        Ok(())
    }
}
