//! Columns: what their exact solutions say of settlement and pressure at the sample times, and what else a scene carries.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Fields, Integrator, Scene, Side, Start, StrainChoice};

use super::applies::inertia_shows;
use crate::error::Error;
use crate::exact::bar::Bar;
use crate::exact::column::{Column, final_settlement};
use crate::exact::dynamic::DynamicColumn;
use crate::experiment::comparison::{Compared, Comparison, Norm};

/// Share of the load that inertia may take at a time that counts, where no exact solution has it. At ten times Table 1's slowness a
/// column drained at both ends loses 1e-3 to it and changes its settlement by less than 0.01 %.
pub const INERTIA: f64 = 2e-3;
/// A swing has died when it has decayed by exp(-12).
const DIED: f64 = 12.0;
/// Settlements below this share of the largest are measured in that share of it: a settlement of zero has no relative error.
const LEAST: f64 = 0.1;

/// A column that consolidates.
#[derive(Debug, Clone)]
pub struct Consolidation {
    /// Without inertia.
    column: Column,
    /// The linear column with inertia and without: what inertia adds.
    inertia: Option<(DynamicColumn, DynamicColumn)>,
    /// Speed of the undrained wave, m/s; zero without inertia.
    speed: f64,
    /// An implicit pressure damps the waves of sudden drainage: settlements with and without them are both right.
    damps: bool,
    /// First time that counts, s: before, inertia takes too much where no exact solution has it.
    from: f64,
    /// Smallest settlement and pressure that errors are measured in, m and Pa.
    least: [f64; 2],
    facts: Facts,
}

/// What is said of a column.
#[derive(Debug, Clone)]
struct Facts {
    kind: String,
    beside: Vec<String>,
}

impl Consolidation {
    /// The column of a wet scene.
    ///
    /// # Errors
    /// Key, what was expected and what was found.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let column = Column::of(scene).ok_or_else(|| {
            let expected = "strains that leave water in the pores, so that the equations of the column have a solution";
            Error::refused("[soil]", expected, "a column that runs out of pores")
        })?;
        let moves = scene.integrator != Integrator::QuasiStatic;
        let linear = Fields { strain: StrainChoice::Small, ..Fields::clone(scene) };
        let inertia = match moves {
            true if scene.is_elastic() => DynamicColumn::new(&linear).zip(DynamicColumn::without_inertia(&linear)),
            _ => None,
        };
        let (stiffness, density) = (scene.oedometer_modulus() + scene.pore_stiffness(), scene.mixture_density());
        let from = if moves && inertia.is_none() { from(scene)? } else { 0.0 };
        let settlements = scene.observe_times.iter().map(|time| column.settlement(*time).abs());
        let largest = settlements.fold(1e-3 * final_settlement(scene, 0.0).abs(), f64::max);
        let excess = column.largest_excess;
        if largest == 0.0 && excess == 0.0 {
            return Err(Error::refused("surcharge.pressure", "a load or a weight above zero", "0 Pa"));
        }
        let facts = facts(scene, &column, inertia.as_ref(), from);
        Ok(Self {
            column,
            inertia,
            speed: if moves { (stiffness / density).sqrt() } else { 0.0 },
            damps: scene.integrator == Integrator::SemiImplicit,
            from,
            least: [LEAST * largest, excess],
            facts,
        })
    }

    /// The solution with its assumptions.
    pub fn words(&self) -> String {
        self.facts.kind.clone()
    }

    /// What the scene carries.
    pub fn beside(&self, _: &Scene) -> Vec<String> {
        self.facts.beside.clone()
    }

    /// Largest error of the solution itself.
    pub fn uncertainty(&self) -> f64 {
        let (settlement, pressure) = self.column.uncertainty();
        settlement.max(pressure)
    }

    /// What the time factor's unit is of, s.
    pub(in crate::cases) fn looks(&self, scene: &Scene, run: &Run) -> Vec<Comparison> {
        // While a wave crosses two cells a mesh knows no value better than the exact one changes.
        let cross = if self.speed > 0.0 { 2.0 * scene.cell / self.speed } else { 0.0 };
        let factor = |time: f64| scene.time_per_factor().map(|one| time / one);
        let counts = |time: f64| time >= self.from * (1.0 - 1e-9);
        let settlement = |s: &Sample| {
            let (time, found) = (s.stage_time, s.state.settlement);
            let still = self.column.settlement(time);
            let added = |t: f64| self.inertia.as_ref().map_or(0.0, |(with, _)| with.settlement(t));
            let (right, slack) = self.right(found, still, self.added(time), spread(added, time, cross));
            let size = right.abs().max(self.least[0]);
            let off = beyond(found - right, slack);
            Compared {
                time,
                factor: factor(time),
                computed: vec![(right + off) / size],
                exact: vec![right / size],
                counts: counts(time),
                places: Vec::new(),
            }
        };
        let pressures = |s: &Sample| {
            let time = s.stage_time;
            let (mut computed, mut exact) = (Vec::new(), Vec::new());
            for row in &s.state.profile {
                let height = row.material_height_m;
                let still = self.column.pressure(height, time);
                let (with, without) = self.inertia.as_ref().map_or((0.0, 0.0), |(with, without)| {
                    (with.pressure(height, time), without.pressure(height, time))
                });
                let at = |t: f64| self.inertia.as_ref().map_or(0.0, |(with, _)| with.pressure(height, t));
                let (right, slack) = self.right(row.pressure_pa, still, with - without, spread(at, time, cross));
                computed.push((right + beyond(row.pressure_pa - right, slack)) / self.least[1]);
                exact.push(right / self.least[1]);
            }
            Compared { time, factor: factor(time), computed, exact, counts: counts(time), places: Vec::new() }
        };
        let settled = Comparison::worst("settlement over the exact one", run.observed().map(settlement).collect());
        let pressed =
            Comparison::worst("pore pressure over the largest excess", run.observed().map(pressures).collect());
        vec![settled, Comparison { over_places: Norm::Rms, ..pressed }]
    }

    /// Settlement at a sample time (s), m; not a number at another.
    pub(super) fn settlement(&self, time: f64) -> f64 {
        self.column.settlement(time) + self.added(time)
    }

    /// Pore pressure at a sample time (s) in the soil that was at a height (m) at first, without inertia, Pa; not a number at another.
    pub(super) fn pressure(&self, height: f64, time: f64) -> f64 {
        self.column.pressure(height, time)
    }

    /// What inertia adds to the settlement at a time, m.
    fn added(&self, time: f64) -> f64 {
        self.inertia.as_ref().map_or(0.0, |(with, without)| with.settlement(time) - without.settlement(time))
    }

    /// The right value beside a found one, and what it may be off by: with inertia, or, where an implicit pressure damps its waves,
    /// whatever lies between with and without.
    fn right(&self, found: f64, still: f64, added: f64, spread: f64) -> (f64, f64) {
        match self.damps {
            true => (found.clamp(still.min(still + added), still.max(still + added)), spread),
            false => (still + added, spread),
        }
    }
}

/// How much a value bends within a time: zero where it is smooth, all of a kink.
fn spread(value: impl Fn(f64) -> f64, time: f64, within: f64) -> f64 {
    if within == 0.0 || time < within {
        return 0.0;
    }
    (value(time + within) - 2.0 * value(time) + value(time - within)).abs()
}

/// What of a difference is beyond a slack, with its sign.
fn beyond(off: f64, slack: f64) -> f64 {
    if off.is_nan() { off } else { off.signum() * (off.abs() - slack).max(0.0) }
}

/// First time at which inertia takes less than [`INERTIA`] of the load where no exact solution has it, s.
///
/// The soil above a drained base falls as a half space consolidates, by (q/M) sqrt(c t): what its mass needs, over q.
fn from(scene: &Scene) -> Result<f64, Error> {
    let soils = scene.by_layer();
    let fastest = soils.iter().map(|(_, soil)| {
        let storage = 1.0 / soil.oedometer_modulus() + 1.0 / soil.pore_stiffness();
        let coefficient = soil.water.map_or(0.0, |w| w.mobility()) / storage;
        coefficient.sqrt() / soil.oedometer_modulus()
    });
    let fastest = fastest.fold(0.0, f64::max);
    let share = |time: f64| 0.25 * 0.5 * scene.height * scene.mixture_density() * fastest / time.powf(1.5);
    let times = || scene.observe_times.iter().copied().filter(|time| *time > 0.0);
    times().find(|time| share(*time) <= INERTIA).ok_or_else(|| {
        let last = times().next_back().unwrap_or(f64::NAN);
        inertia_shows(share(last), last)
    })
}

/// In words: the solution, and what is in it and what is not.
fn facts(scene: &Scene, column: &Column, inertia: Option<&(DynamicColumn, DynamicColumn)>, from: f64) -> Facts {
    let large = scene.strain == StrainChoice::Large;
    let load = scene.surcharge.map_or(0.0, |s| s.pressure);
    let ramp = scene.surcharge.map_or(0.0, |s| s.ramp_time);
    let drained = scene.stages[0].drained;
    let ends = match (drained[Side::Bottom as usize], drained[Side::Top as usize]) {
        (true, true) => "both ends drained",
        (false, true) => "drained at the top",
        (true, false) => "drained at the base",
        (false, false) => "undrained",
    };
    let plain = scene.gravity.is_none() && scene.layers.is_empty() && scene.is_elastic();
    let name = match (large, plain, inertia.is_some()) {
        (false, true, true) => "the exact u-p column with inertia",
        (false, true, false) if ramp > 0.0 => "Olson's series for a load that grows",
        (false, true, false) => "Terzaghi's series with compressible water",
        (false, false, _) => "the column of small strain",
        (true, ..) => "the column of finite strain, Cauchy stress -M ln J",
    };
    let layers = if scene.layers.is_empty() { String::new() } else { format!(", {} layers", scene.layers.len()) };
    let (settled, pressed) = column.uncertainty();
    let kind = format!(
        "{name}, {ends}{layers} (known to {:.0e} of settlement, {:.0e} of pressure)",
        settled.max(1e-9),
        pressed.max(1e-9)
    );
    let strain = final_settlement(scene, load) / scene.height;
    let strain_of_other = if large { StrainChoice::Small } else { StrainChoice::Large };
    let other = Fields { strain: strain_of_other, ..Fields::clone(scene) };
    let differs = final_settlement(&other, load) / scene.height / strain - 1.0;
    let mut beside = vec![match large {
        true => format!(
            "strain: {strain:.2e} in the end, large in the solution (small strain would settle {:+.2} %)",
            100.0 * differs
        ),
        false => format!(
            "strain: {strain:.2e} in the end, small as the scene has it (large strain would settle {:+.2} %)",
            100.0 * differs
        ),
    }];
    beside.push(match scene.gravity {
        Some(gravity) => format!("weight: {gravity} m/s2, in the solution"),
        None => "weight: none".to_owned(),
    });
    let water = scene.water.map_or(f64::INFINITY, |w| w.bulk_modulus);
    beside.push(match water.is_finite() {
        true => format!(
            "compressibility of the water: in the solution, it carries {:.4} of a load at once",
            scene.undrained_share()
        ),
        false => "compressibility of the water: none".to_owned(),
    });
    let first = scene.observe_times.iter().copied().find(|t| *t > 0.0).unwrap_or(f64::NAN);
    beside.push(match (scene.integrator, inertia) {
        (Integrator::QuasiStatic, _) => "inertia: none, quasi-static".to_owned(),
        (integrator, Some((with, without))) => {
            let size = without.settlement(first).abs().max(LEAST * strain.abs() * scene.height);
            let added = (with.settlement(first) - without.settlement(first)) / size;
            let damped = if integrator == Integrator::SemiImplicit { "; an implicit pressure may damp it" } else { "" };
            format!("inertia: in the solution as that of the linear column, {:+.3} % of settlement at the first time{damped}", 100.0 * added)
        }
        (_, None) => format!("inertia: not in the solution; times count from {from:.3e} s on, where it takes less than {INERTIA} of the load"),
    });
    if !scene.is_elastic() {
        beside.push("strength: Mohr-Coulomb along one axis, in the solution".to_owned());
    }
    Facts { kind, beside }
}

/// A dry column, that swings or has come to rest.
#[derive(Debug, Clone)]
pub struct DryColumn {
    /// Where it is elastic and of one soil: its swing.
    bar: Option<Bar>,
    /// First time that counts, s.
    from: f64,
    final_load: f64,
}

impl DryColumn {
    /// The column of a dry scene.
    ///
    /// # Errors
    /// Key, what was expected and what was found.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let final_load = scene.surcharge.map_or(0.0, |s| s.pressure);
        if scene.start == Start::UndrainedEquilibrium {
            return Err(Error::refused(
                "start",
                "\"unloaded\" or \"geostatic\"",
                "\"undrained-equilibrium\" of a dry column",
            ));
        }
        if scene.integrator == Integrator::QuasiStatic {
            return Ok(Self { bar: None, from: 0.0, final_load });
        }
        let bar = Bar::new(scene);
        let small = final_settlement(scene, final_load).abs() / scene.height < SWINGS_SMALL;
        if bar.is_some() && scene.is_elastic() && small {
            return Ok(Self { bar, from: 0.0, final_load });
        }
        let still = scene.start == Start::Geostatic && scene.surcharge.is_none();
        let ramp = scene.surcharge.map_or(0.0, |s| s.ramp_time);
        let swing = Bar::new(&scene.edited(|s| {
            s.start = Start::Unloaded;
            s.layers = Vec::new();
        })?);
        let decay = swing.map_or(0.0, |bar| bar.decay());
        let from = if still { 0.0 } else { ramp + DIED / decay };
        // Soil with a strength keeps what a swing has done to it.
        let period = swing.map_or(0.0, |bar| 4.0 * scene.height / bar.speed);
        if !scene.is_elastic() && ramp < 10.0 * period {
            let expected = format!("at least {:.3e} s, ten periods: what yields in a swing stays", 10.0 * period);
            return Err(Error::refused("surcharge.ramp_time", &expected, format!("{ramp} s")));
        }
        if scene.observe_times.last().is_none_or(|time| *time < from) {
            let expected = format!("a time from {from:.3e} s on, when the swing has died (stages.damping)");
            return Err(Error::refused("[observe]", &expected, "none"));
        }
        Ok(Self { bar: None, from, final_load })
    }

    /// The solution with its assumptions.
    pub fn words(&self) -> String {
        match self.bar {
            Some(_) => "the modes of a dry column with its damping (elastic, small strain)".to_owned(),
            None => "a dry column at rest under load and weight (closed form)".to_owned(),
        }
    }

    /// What the scene carries.
    pub fn beside(&self, scene: &Scene) -> Vec<String> {
        let strain = final_settlement(scene, self.final_load) / scene.height;
        let large = scene.strain == StrainChoice::Large;
        vec![
            format!("strain: {strain:.2e} in the end, {} in the solution", if large { "large" } else { "small" }),
            format!("weight: {}", scene.gravity.map_or("none".to_owned(), |g| format!("{g} m/s2, in the solution"))),
            match self.bar {
                Some(_) => "inertia: in the solution as that of the linear column".to_owned(),
                None => format!("inertia: none from {:.3e} s on, which counts", self.from),
            },
        ]
    }

    /// Settlement at a time (s) counted from the unloaded state, or from the first one where that bears the weight, m.
    pub(super) fn settlement(&self, scene: &Scene, time: f64) -> f64 {
        let load = scene.surcharge.map_or(0.0, |s| s.at(time));
        let at_first = if scene.start == Start::Geostatic { final_settlement(scene, 0.0) } else { 0.0 };
        match self.bar {
            // What large strain adds to the static settlement it adds to the swing.
            Some(bar) => {
                let linear = Fields { strain: StrainChoice::Small, ..Fields::clone(scene) };
                bar.settlement(time) * final_settlement(scene, self.final_load)
                    / final_settlement(&linear, self.final_load)
            }
            None => final_settlement(scene, load) - at_first,
        }
    }

    /// The settlement.
    pub(in crate::cases) fn looks(&self, scene: &Scene, run: &Run) -> Vec<Comparison> {
        let cross = self.bar.map_or(0.0, |bar| 2.0 * scene.cell / bar.speed);
        let largest = final_settlement(scene, self.final_load).abs();
        let last = run.samples.last();
        let samples: Vec<&Sample> = run.observed().chain(last.filter(|s| !s.observed)).collect();
        let counts = |time: f64| time >= self.from * (1.0 - 1e-9);
        let settlement = |s: &&Sample| {
            let (time, found) = (s.stage_time, s.state.settlement);
            let right = self.settlement(scene, time);
            let slack = spread(|t| self.settlement(scene, t), time, if self.bar.is_some() { cross } else { 0.0 });
            let size = right.abs().max(LEAST * largest);
            let computed = vec![(right + beyond(found - right, slack)) / size];
            Compared {
                time,
                factor: None,
                computed,
                exact: vec![right / size],
                counts: counts(time),
                places: Vec::new(),
            }
        };
        vec![Comparison::worst("settlement over the exact one", samples.iter().map(settlement).collect())]
    }
}

/// Largest strain of a column whose swing is compared with the linear one.
const SWINGS_SMALL: f64 = 2e-3;
