//! Whether the balances of a run are closed: each residual, its bound, and the time from which it exceeds the bound.
//!
//! Every bound has the form of what the scheme leaves out. Some of its terms were added because sound runs had shown the bound
//! to be too narrow, and were derived then:
//!
//! | balance | may be missing |
//! |---|---|
//! | dry mass | round-off of a sum over the particles |
//! | water | round-off; the energy that Darcy's law dissipates over K_w, as mass: flow carries volumes between cells of different density; the strain times what has moved, where soil strains sideways; under a plate the square of the strain; the second order of a step, `dt/2` times the square of the rate of strain along each direction; one step of it at most; what semi-implicit pressures leave of the strain; quasi-static p/K_w of what has moved, the tolerance, and under large strain half a row of particles times the strain |
//! | momentum | round-off of as many steps and rows; what water that is taken away falls with; what Newton's iteration leaves of an implicit step |
//! | energy | `omega dt (1 + ln rows)` of what may swing, the first order of a step over the waves that a load excites, omega being the lowest frequency of the column (their energies fall as 1/omega^2): of all work in dry soil, of what is stored undrained in wet soil; `dt` times the power of the stress on the fastest particle; `c dt/2` of what a damping c has taken; what a cell at a sudden drain holds, or the squares of the changes of strain in steps near their limit; what a sudden load stores undrained (semi-implicit) or half its work (quasi-static), where it is not followed in time; p/K_w; half a row of particles by which soil has moved, a cell where water fills it in part; the tolerance of a quasi-static run |
//! | stress | vertical total stress against load and weight above, in level soil between rollers: half a cell's weight, the stress of a wave of the fastest particle, what damping and flow have left of the lowest wave of a sudden load, the strain, or half a percent, times the stress; two rows of particles where they have crossed; judged once a drained wave has passed the soil four times |
//! | settlement | of level soil under large strain, against the sum of the strains of its particles: a hundredth of its largest |

use serde::Serialize;

use super::{BalanceTerms, Observation};
use crate::boundary::knows_volumes;
use crate::scene::{
    Coupling, Course, FaceLoad, Integrator, LoadOn, Piece, Scene, Side, SolidSide, StrainChoice, UpdateChoice,
};
use crate::step::quasi_static::NEWTON;

/// Settlement may differ from what the strains add up to by this share of its largest: the accuracy that is guaranteed for a settlement.
const MOST_APART: f64 = 0.01;

/// One metre of a top.
const TOP: Piece = Piece { middle: [0.0; 2], outward: [0.0, 1.0] };

/// Stress may differ by this share of that under load and weight.
const TURNING: f64 = 0.005;

/// One balance at one time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Balance {
    /// Its name: dry mass, water, momentum, energy, stress.
    pub name: &'static str,
    /// Its residual, in its unit.
    pub gap: f64,
    /// The bound of the residual.
    pub allowed: f64,
    /// kg, N s, J or Pa.
    pub unit: &'static str,
}

impl Balance {
    /// Whether the residual is within its bound; one that is not a number is not.
    pub fn closes(&self) -> bool {
        self.gap.abs() <= self.allowed
    }

    /// The residual over its bound.
    fn ratio(&self) -> f64 {
        if self.gap == 0.0 { 0.0 } else { self.gap.abs() / self.allowed }
    }
}

/// The verdict over all samples of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trust {
    /// `closed`, or `not closed` from [`Self::since_s`] on.
    pub verdict: &'static str,
    /// The balance that came nearest to its bound, or went furthest beyond it.
    pub balance: &'static str,
    /// The same under the name that this key had in the last version.
    pub ledger: &'static str,
    /// Its residual that was largest relative to its bound, in its unit.
    pub gap: f64,
    /// The bound then.
    pub allowed: f64,
    /// The unit of both.
    pub unit: &'static str,
    /// Time from which it is not closed, s since the start of the run.
    pub since_s: Option<f64>,
}

impl Trust {
    /// That of a run, from its samples in the order of time: the number of steps, the state and its balances.
    pub fn of<'a>(
        scene: &Scene,
        dt: f64,
        samples: impl IntoIterator<Item = (u64, &'a Observation, &'a BalanceTerms)>,
    ) -> Option<Self> {
        let (mut worst, mut since): (Option<Balance>, Option<f64>) = (None, None);
        for (steps, state, balance) in samples {
            if scene.integrator.solves_displacements() && state.time == 0.0 {
                continue; // the first state is there before it is in equilibrium
            }
            for balance in balances(scene, dt, steps, state, balance) {
                if !balance.closes() {
                    since = since.or(Some(state.time));
                }
                // A ratio that is no number is beyond all others.
                let beyond = |worst: Balance| balance.ratio().is_nan() || balance.ratio() > worst.ratio();
                if worst.is_none_or(beyond) {
                    worst = Some(balance);
                }
            }
        }
        worst.map(|Balance { name, gap, allowed, unit }| {
            let verdict = if since.is_none() { "closed" } else { "not closed" };
            Self { verdict, balance: name, ledger: name, gap, allowed, unit, since_s: since }
        })
    }
}

/// Balances of a run after so many steps of `dt` (s).
pub fn balances(scene: &Scene, dt: f64, steps: u64, state: &Observation, balance: &BalanceTerms) -> Vec<Balance> {
    let bounds = Bounds::new(scene, dt, steps, state, balance);
    let mut balances = Vec::with_capacity(6);
    balances.push(bounds.dry_mass(balance));
    balances.extend(bounds.water(balance));
    balances.extend(bounds.momentum(balance));
    balances.extend(bounds.energy(balance));
    balances.extend(bounds.stress());
    balances.extend(bounds.settlement(balance));
    balances
}

/// What the bounds depend on.
struct Bounds<'a> {
    scene: &'a Scene,
    state: &'a Observation,
    dt: f64,
    /// Relative round-off of sums over the particles and over the steps.
    round_off: f64,
    /// What semi-implicit pressures leave of a drained strain, of it: the last digit of what nodes move without them, in every step
    /// (`stability`).
    left_by_pressures: f64,
    /// Total stress under load and weight, Pa.
    stress: f64,
    /// p/K_w under it.
    compression: f64,
    /// Strain under it, drained, or as much as has been seen.
    strain: f64,
    /// How far soil has moved against the cells that count it, at most half a row of particles, m.
    row: f64,
    /// Undrained wave speed, m/s.
    speed: f64,
    /// Oedometer modulus of the softest soil, Pa.
    softest: f64,
    /// Coefficient of consolidation of the quickest soil, m2/s.
    quickest: f64,
}

impl<'a> Bounds<'a> {
    fn new(scene: &'a Scene, dt: f64, steps: u64, state: &'a Observation, balance: &BalanceTerms) -> Self {
        let load = scene.largest_load();
        let weight = scene.gravity.unwrap_or(0.0) * scene.mixture_density() * scene.height;
        let volume = balance.solid_mass_kg / scene.dry_density();
        let moved = balance.external_work_j.abs() / (volume * scene.oedometer_modulus());
        let (stress, modulus) = (load + weight, scene.oedometer_modulus());
        let soils = scene.by_soil();
        let of_soils = soils.iter().map(|soil| {
            let modulus = soil.oedometer_modulus();
            (modulus, soil.water.map_or(0.0, |water| water.mobility() * modulus))
        });
        let (softest, quickest) = of_soils.fold((modulus, 0.0_f64), |(m, c), (own, c_v)| (m.min(own), c.max(c_v)));
        let water = scene.pore_stiffness();
        let water = if water.is_finite() { water } else { 0.0 };
        Self {
            scene,
            state,
            dt: if dt.is_finite() { dt } else { 0.0 },
            round_off: f64::EPSILON * (scene.solid_particles() as f64 + 4.0 * steps as f64),
            left_by_pressures: f64::EPSILON
                * (4.0 * modulus / scene.mixture_density())
                * (dt / scene.cell).powi(2)
                * (steps + 1) as f64,
            stress,
            // With grains that compress what is stored undrained, and Biot's theory knows only to the first order.
            compression: scene.water.map_or(0.0, |w| {
                let of_grains = if scene.biot.is_some() { scene.soil().alpha() / water } else { 0.0 };
                stress * of_grains.max(1.0 / w.bulk_modulus)
            }),
            strain: (stress / softest).max(state.settlement.abs() / scene.height).max(moved.sqrt()),
            row: (0.5 * scene.spacing()).min(state.settlement.abs().max(if state.solid_crossings > 0 {
                scene.height
            } else {
                0.0
            })),
            speed: ((modulus + water) / scene.mixture_density()).sqrt(),
            softest,
            quickest,
        }
    }

    fn dry_mass(&self, balance: &BalanceTerms) -> Balance {
        let allowed = self.round_off * balance.solid_mass_kg;
        Balance { name: "dry mass", gap: balance.solid_residual_kg, allowed, unit: "kg" }
    }

    fn water(&self, balance: &BalanceTerms) -> Option<Balance> {
        let water = self.scene.water?;
        // Water with a free surface in soil that moves is balanced by its particles, which go with it.
        if self.scene.free_surface.is_some()
            && self.scene.stages.iter().any(|stage| stage.coupling != Coupling::Seepage)
        {
            return None;
        }
        let gap = balance.water_residual_kg;
        let moved = balance.water_in_kg.abs() + balance.water_out_kg.abs();
        let exchanged = moved + (balance.water_stored_kg - (gap + balance.water_in_kg - balance.water_out_kg)).abs();
        let mut allowed = self.round_off * (exchanged + balance.water_stored_kg);
        if self.scene.free_surface.is_none() {
            let soil = balance.solid_mass_kg / self.scene.dry_density();
            let strained = water.density * soil * self.strain;
            // An undrained front strains cell by cell at `wave c/L`, in one cell at a time; a step is off by half its square.
            let wave = self.stress / (self.speed * self.speed * self.scene.mixture_density());
            // One runs along each direction; one towards an axis or away from it strains the soil around it as well.
            let across = [0.0, 1.0, 2.0][self.scene.dimension as usize] / self.scene.width;
            let per_area = (across + 1.0 / self.scene.height) / self.scene.cell;
            let fronts = 0.5 * self.dt * self.state.time * (wave * self.speed).powi(2) * per_area;
            let second_order = fronts.min(0.5 * wave * wave * self.state.time / self.dt.max(f64::MIN_POSITIVE));
            // Q rho(p) leaves a cell and Q rho(p') reaches the next: `rho Q (p - p')/K_w` is lost on the way, which is
            // what Darcy's law dissipates there, less the work of weight and inertia.
            let on_the_way = balance.darcy_dissipation_j.abs() + balance.flow_body_work_j.abs();
            allowed += water.density * on_the_way / water.bulk_modulus;
            if !self.scene.is_one_dimensional() {
                // Faces stay where they are while soil strains along and across them, and moves water within: their areas are off.
                allowed += 2.0 * self.strain * (moved + strained);
            }
            allowed += water.density * soil * second_order / self.scene.porosity;
            if self.scene.integrator == Integrator::SemiImplicit {
                allowed += strained * self.left_by_pressures;
            }
            allowed += water.density * soil * self.compression * self.compression;
            if self.scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate) {
                // Cells under a plate are strained as if they stayed as large as they were.
                allowed += strained * self.strain;
            }
            if self.scene.update == UpdateChoice::Musl {
                // The velocities that strain the soil are those of the surface smoothed over a cell, u + L^2/8 u'': beside a
                // front of strain e they differ by L e/8.
                allowed += strained * self.scene.cell / (8.0 * self.scene.height);
            }
            if !knows_volumes(self.scene) {
                // Particles' volumes leave gaps in cells that are full of soil, by the strain.
                allowed += self.strain * (moved + strained);
            }
            if self.scene.integrator.solves_displacements() {
                allowed += self.scene.tolerance * (moved + strained);
                // Of what drains before the first time that is asked for, the dissipation is not known.
                allowed += self.compression * moved;
                if self.scene.strain == StrainChoice::Large {
                    // A new mesh takes its pores from the volumes of particles, each as its middle is strained.
                    allowed += water.density * soil * self.strain * self.row / self.scene.height;
                }
            }
        }
        Some(Balance { name: "water", gap, allowed, unit: "kg" })
    }

    fn momentum(&self, balance: &BalanceTerms) -> Option<Balance> {
        if self.scene.integrator == Integrator::QuasiStatic || self.scene.free_surface.is_some() {
            return None;
        }
        let mass = balance.solid_mass_kg + balance.water_stored_kg;
        let area = balance.solid_mass_kg / (self.scene.dry_density() * self.scene.height);
        // Every row of nodes takes the stress below it and above.
        let rows = self.scene.cells[1] as f64;
        let pushed: f64 = self.state.plates.iter().map(|push| push.impulse[0].hypot(push.impulse[1])).sum();
        let given = (self.stress * area * self.state.time + pushed) * rows + mass * self.velocity();
        // Water that is taken away goes with the speed of its soil, at most that of a fall.
        let fall = (2.0 * self.scene.gravity.unwrap_or(0.0) * self.scene.height).sqrt() + self.velocity();
        let removed = balance.water_particles_removed_kg * fall;
        // Equations are solved as far as their tolerance asks, beside load, stress and pressure together, for two functions more along
        // an axis than cells.
        let more: f64 = self.scene.cells.iter().map(|cells| 1.0 + 2.0 / *cells as f64).product();
        let solved =
            if self.scene.integrator.solves_displacements() { 3.0 * NEWTON * self.scene.tolerance * more } else { 0.0 };
        let allowed = (self.round_off + solved) * given + removed;
        Some(Balance { name: "momentum", gap: balance.momentum_residual_n_s, allowed, unit: "N s" })
    }

    /// Speed that the scene starts with or a wave of its load makes, m/s.
    fn velocity(&self) -> f64 {
        let start = self.scene.start_velocity.map_or(0.0, |[x, y]| x.hypot(y));
        start + self.stress / (self.scene.mixture_density() * self.speed)
    }

    fn energy(&self, balance: &BalanceTerms) -> Option<Balance> {
        if self.scene.free_surface.is_some() {
            return None;
        }
        let l = balance;
        let spent = [
            l.external_work_j,
            l.gravity_work_j,
            l.flow_body_work_j,
            l.darcy_dissipation_j,
            l.damping_loss_j,
            l.base_friction_j,
            l.plastic_dissipation_j,
            l.transfer_loss_j,
            l.kinetic_j,
            l.strain_j,
            l.water_j,
        ];
        let all: f64 = spent.iter().map(|work| work.abs()).sum();
        let rows = self.scene.cells[1] as f64;
        // Semi-implicit steps resolve the waves of the drained soil alone.
        let resolved = match self.scene.integrator {
            Integrator::SemiImplicit => (self.scene.oedometer_modulus() / self.scene.mixture_density()).sqrt(),
            _ => self.speed,
        };
        let frequency = 0.5 * std::f64::consts::PI * resolved / self.scene.height;
        let waves = frequency * self.dt * (1.0 + rows.ln());
        // Water in cells that soil fills in part is counted as if it filled them.
        let wet = self.scene.water.is_some() && !knows_volumes(self.scene) && self.state.solid_crossings > 0;
        let row = if wet { self.scene.cell } else { self.row };
        let mut share = self.compression + row / self.scene.height + self.round_off;
        // What load and weight store in soil that has not drained yet: at first no more has been spent.
        let soil = l.solid_mass_kg / self.scene.dry_density();
        let stored = |modulus: f64| 0.5 * self.stress * self.stress / modulus * soil;
        let drained = stored(self.softest);
        // Soil that is free sideways shears without draining.
        let confined = self.speed * self.speed * self.scene.mixture_density();
        let shear = 4.0 * self.scene.elastic.shear_modulus();
        let undrained =
            stored(if self.scene.is_one_dimensional() { confined } else { confined.min(shear) }).min(drained);
        let damping = self.scene.stages.iter().fold(0.0, |most: f64, stage| most.max(stage.damping));
        let speed = self.state.max_speed + self.scene.start_velocity.map_or(0.0, |[x, y]| x.hypot(y));
        let moving = (self.stress + l.strain_j.max(0.0) / soil) * soil / self.scene.height * speed;
        let mut sudden = self.dt * moving + 0.5 * damping * self.dt * l.damping_loss_j;
        if self.scene.water.is_some() {
            // The soil's own stress is that before the step: `M/2` times the square of every change of strain. After a sudden
            // drain each mode of the mesh changes by factors 1 - x, and its squares add up to x/(2 - x), x at most 4 c_v dt/L^2.
            let cell = self.scene.cell;
            let of_limit = (2.0 * self.quickest * self.dt / (cell * cell)).min(0.99);
            let front = 0.5 * of_limit * cell / (1.0 - of_limit).sqrt();
            sudden += drained * cell.max(front) / self.scene.height;
        }
        match self.scene.integrator {
            Integrator::SemiImplicit => sudden += 0.5 * l.external_work_j.abs().min(2.0 * undrained),
            Integrator::QuasiStatic | Integrator::Implicit => {
                share += 10.0 * self.scene.tolerance;
                // What drains before the first time that is asked for, a permeable layer for one, is known only when it has.
                // So is half the work of a weight, or of a geostatic start, that is not in balance at first.
                let released = l.gravity_work_j.abs().max(l.released_j.abs());
                sudden += 0.5 * (l.external_work_j.abs() + released);
            }
            _ => {}
        }
        // Water lets no more swing than a load stores before it drains.
        let swings = if self.scene.water.is_some() { 2.0 * undrained + l.kinetic_j } else { all + undrained };
        let allowed = share * (all + undrained) + waves * swings + sudden;
        Some(Balance { name: "energy", gap: l.energy_residual_j, allowed, unit: "J" })
    }

    /// Vertical total stress against load and weight above.
    fn stress(&self) -> Option<Balance> {
        let scene = self.scene;
        let loaded = scene.surcharge.is_none_or(|load| load.on != LoadOn::Particles);
        let free = scene.solid_sides[Side::Top as usize] == SolidSide::Free;
        let passages = 4.0 * scene.height / (scene.oedometer_modulus() / scene.mixture_density()).sqrt();
        let elastic = scene.is_elastic() && scene.free_surface.is_none();
        let steady = |load: &FaceLoad| {
            let steady = matches!(load.course, Course::Constant | Course::Ramp(_));
            steady && load.on == Some(Side::Top) && !load.is_water()
        };
        let judged = scene.is_one_dimensional() && loaded && free && elastic && scene.loads.iter().all(steady);
        if !judged || self.state.time < passages || scene.integrator.solves_displacements() {
            return None;
        }
        let weight = scene.gravity.unwrap_or(0.0) * scene.mixture_density();
        let load = scene.surcharge.map_or(0.0, |s| s.at(self.state.time) - s.pressure);
        let of = |load: &FaceLoad| -load.force(&TOP)[1] * load.course.at(self.state.time, 0.0);
        let load = load + scene.loads.iter().map(of).sum::<f64>();
        let off = |row: &super::ProfileRow| {
            let carried = row.pressure_pa - row.effective_stress_pa;
            carried - load - scene.total_stress_at(row.material_height_m)
        };
        let gap = self.state.profile.iter().map(off).fold(
            0.0,
            |worst: f64, off| {
                if off.abs() <= worst.abs() { worst } else { off }
            },
        );
        // A wave that is reflected has twice the stress of its particles' speed; damping takes what it does to all soil above.
        let damping = scene.stages.iter().fold(0.0, |most: f64, stage| most.max(stage.damping));
        let moving = scene.mixture_density() * (2.0 * self.speed + damping * scene.height) * self.state.max_speed;
        let by_place = weight * (0.5 * scene.cell + 4.0 * self.row);
        // Particles' own volumes are right while the surface stays within a fifth of a cell.
        let strain = if knows_volumes(scene) { self.strain } else { self.strain.min(0.2 * scene.cell / scene.height) };
        let allowed = by_place + moving + strain.max(TURNING) * self.stress + self.swings(damping);
        Some(Balance { name: "stress", gap, allowed, unit: "Pa" })
    }

    /// Stress that the lowest wave of a sudden load still has where it turns and no speed tells of it, Pa.
    ///
    /// Its frequency is `omega = pi c/(2 H)`. Water that flows a wave length damps it: the modulus `M + Q i omega/(i omega + r)`
    /// with `Q = K_w/n` and `r = (k/gamma_w) Q (pi/2H)^2` loses `tan delta`, and with it half of `omega tan delta` per second.
    fn swings(&self, damping: f64) -> f64 {
        let scene = self.scene;
        let wave = 0.5 * std::f64::consts::PI / scene.height;
        let stiffness = scene.pore_stiffness();
        let loss = match scene.water {
            Some(water) if stiffness.is_finite() => {
                let (omega, rate) = (wave * self.speed, water.mobility() * stiffness * wave * wave);
                let share = stiffness / (omega * omega + rate * rate);
                0.5 * omega * (share * omega * rate / (self.softest + share * omega * omega))
            }
            // Without a stiffness of its own the water leaves as fast as it is pressed.
            Some(water) => 0.5 / (water.mobility() * scene.mixture_density()),
            None => 0.0,
        };
        let ends = scene.loads.iter().flat_map(|load| load.course.corners());
        let ramp = ends.fold(scene.surcharge.map_or(0.0, |load| load.ramp_time), f64::max);
        let since = self.state.time - ramp.min(self.state.time);
        2.0 * self.stress * (-(0.5 * damping + loss) * since).exp()
    }

    /// Settlement of the surface against what the strains of the particles add up to.
    fn settlement(&self, balance: &BalanceTerms) -> Option<Balance> {
        let scene = self.scene;
        let judged = scene.is_one_dimensional() && scene.strain == StrainChoice::Large && !scene.has_several_soils();
        if !judged || !knows_volumes(scene) || scene.integrator.solves_displacements() {
            return None;
        }
        let soil = balance.solid_mass_kg / scene.dry_density();
        let strained = scene.height * (1.0 - self.state.soil_volume / soil) + scene.first_settlement();
        let gap = self.state.settlement - strained;
        let allowed = scene.height * (MOST_APART * self.strain + self.round_off);
        Some(Balance { name: "settlement", gap, allowed, unit: "m" })
    }
}
