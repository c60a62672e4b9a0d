//! Which exact solution applies to a scene, or what it lacks.

use mpm_core::scene::{Integrator, LoadOn, Scene, Side, Start, StrainChoice, Until};

use crate::cases::mandel;
use crate::exact::dynamic::DynamicColumn;
use crate::exact::large_strain::LargeStrain;
use crate::exact::mandel::Mandel;
use crate::exact::terzaghi::Terzaghi;

/// q/M up to which a column of finite strain is compared, under a lighter load, with a solution of small strains.
pub const SMALL: f64 = 0.02;
/// Share of the load that the inertia of a column drained at both ends may take at the first sample time. At ten times
/// Table 1's slowness it takes 1e-3 and changes the settlement by less than 0.01 %; at Table 1's own 11 %, and 31 %.
const INERTIA: f64 = 2e-3;

/// An exact solution.
#[derive(Debug, Clone)]
pub enum Solution {
    /// Terzaghi's series with compressible water; Olson's under a ramp.
    Series(Terzaghi),
    /// The column with inertia, and whether its load grows over a ramp.
    Dynamic(DynamicColumn, Terzaghi),
    /// The column of large strain.
    Large(LargeStrain, Terzaghi),
    /// Mandel's block.
    Block(Mandel),
}

impl Solution {
    /// Settlement at a time (s), m; NaN where a table has no row.
    pub fn settlement(&self, time: f64) -> f64 {
        match self {
            Self::Series(exact) => exact.settlement(time),
            Self::Dynamic(exact, _) => exact.settlement(time),
            Self::Large(exact, _) => exact.settlement(time).unwrap_or(f64::NAN),
            Self::Block(exact) => exact.settlement(time),
        }
    }

    /// Whether the load grows over a ramp.
    pub fn ramps(&self) -> bool {
        match self {
            Self::Series(exact) | Self::Dynamic(_, exact) | Self::Large(_, exact) => exact.ramp > 0.0,
            Self::Block(_) => false,
        }
    }

    /// Time factor c t/H_d^2 of a time (s).
    pub fn time_factor(&self, time: f64) -> f64 {
        match self {
            Self::Series(exact) | Self::Dynamic(_, exact) | Self::Large(_, exact) => exact.time_factor(time),
            Self::Block(exact) => exact.time_factor(time),
        }
    }

    /// Drainage path H_d, m.
    pub fn path(&self) -> f64 {
        match self {
            Self::Series(exact) | Self::Dynamic(_, exact) | Self::Large(_, exact) => exact.path,
            Self::Block(exact) => exact.half_width,
        }
    }

    /// In words.
    pub fn words(&self) -> String {
        let words = match self {
            Self::Series(exact) if exact.ramp > 0.0 => "Olson's series for a load that grows, compressible water",
            Self::Series(exact) if exact.double => "Terzaghi's series with compressible water, both ends drained",
            Self::Series(_) => "Terzaghi's series with compressible water",
            Self::Dynamic(..) => "the exact u-p column with inertia",
            Self::Large(..) => "the converged column of large strain",
            Self::Block(_) => "Mandel's problem",
        };
        words.to_owned()
    }
}

/// The solution of a scene that is run as `light`; messages speak of the scene as it was written.
///
/// # Errors
/// Key, what was expected and what was found.
pub fn solution(light: &Scene, scene: &Scene) -> Result<Solution, String> {
    soil_and_water(scene)?;
    integrator(scene)?;
    stages(scene)?;
    if scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate) {
        return block(scene);
    }
    column(scene)?;
    let series = Terzaghi::compressible(light).ok_or_else(|| refusal("[water]", "a loaded wet column", "another"))?;
    if strain(scene)? {
        let large = LargeStrain::new(scene).ok_or_else(|| {
            let expected = format!(
                "a load of at most {SMALL} M = {:.4e} Pa, soil.strain = \"small\", or q/M = -ln 0.8 with water that does \
                 not compress, drained at the top, start = \"unloaded\"",
                SMALL * scene.oedometer_modulus()
            );
            refusal("surcharge.pressure", &expected, &load_words(scene))
        })?;
        if let Some(time) = scene.observe_times.iter().find(|time| large.settlement(**time).is_none()) {
            let expected = "times of the table reference-data/exact/05_large_strain_S_A.csv";
            return Err(refusal("observe.times", expected, &format!("{time} s")));
        }
        return Ok(Solution::Large(large, series));
    }
    if scene.integrator == Integrator::QuasiStatic {
        return Ok(Solution::Series(series));
    }
    waves(scene, &series)?;
    match DynamicColumn::new(light) {
        Some(dynamic) => Ok(Solution::Dynamic(dynamic, series)),
        None => Ok(Solution::Series(series)),
    }
}

/// `key: expected ..., found ...`.
fn refusal(key: &str, expected: &str, found: &str) -> String {
    format!("{key}: expected {expected}, found {found}")
}

fn soil_and_water(scene: &Scene) -> Result<(), String> {
    let refuse = |key: &str, expected: &str, found: &str| Err(refusal(key, expected, found));
    if scene.strength.is_some() {
        return refuse("soil.law", "linear_elastic: the exact solutions are elastic", "mohr_coulomb");
    }
    if scene.water.is_none() {
        return refuse("[water]", "pore water: the exact solutions are those of consolidation", "a dry scene");
    }
    if scene.free_surface.is_some() {
        return refuse("water.free_surface", "no such table: the soil is saturated", "a free surface");
    }
    if let Some(gravity) = scene.gravity {
        return refuse("gravity", "no such key: the exact solutions have no weight", &format!("{gravity} m/s2"));
    }
    if scene.surcharge.is_none() {
        return refuse("[surcharge]", "a load that the soil consolidates under", "none");
    }
    if scene.displaced.is_some() || scene.shift > 0.0 {
        return refuse("mesh", "particles and cells in their even places", "displaced ones: their error has no order");
    }
    if scene.observe_times.is_empty() {
        return refuse("[observe]", "times or time factors to compare at", "none");
    }
    Ok(())
}

fn integrator(scene: &Scene) -> Result<(), String> {
    match scene.integrator {
        Integrator::Explicit | Integrator::SemiImplicit | Integrator::QuasiStatic => Ok(()),
        Integrator::TwoClocks | Integrator::Coupled => {
            let expected = "\"explicit\", \"semi-implicit\" or \"quasi-static\"";
            Err(refusal("time.integrator", expected, &format!("\"{}\"", crate::study::word(scene.integrator))))
        }
    }
}

fn stages(scene: &Scene) -> Result<(), String> {
    let [stage] = scene.stages.as_slice() else {
        let expected =
            "one: what came before it is in no exact solution (start = \"undrained-equilibrium\" stands for it)";
        return Err(refusal("[[stages]]", expected, &scene.stages.len().to_string()));
    };
    if stage.damping > 0.0 {
        return Err(refusal("stages.damping", "none", &format!("{} 1/s", stage.damping)));
    }
    if !matches!(stage.until, Until::Time(_)) {
        return Err(refusal("stages.until", "time or time_factor", "an end that follows from the run"));
    }
    Ok(())
}

fn block(scene: &Scene) -> Result<Solution, String> {
    let exact = Mandel::new(scene).ok_or_else(|| {
        let expected = "Mandel's problem under it: start = \"unloaded\", a step load, left and bottom \"roller\", right and \
                        top \"free\", only the right side drained, no gravity";
        refusal("surcharge.on", expected, "\"plate\" in another scene")
    })?;
    if scene.strain != StrainChoice::Small {
        return Err(refusal("soil.strain", "\"small\": Mandel's solution is that of small strains", "\"large\""));
    }
    let late = scene.observe_times.iter().any(|time| mandel::counts(&exact, *time));
    if !late {
        let expected = format!("a time from T = c t/a^2 = {} on", mandel::TIME_FACTOR);
        return Err(refusal("[observe]", &expected, "none"));
    }
    Ok(Solution::Block(exact))
}

/// A column that soil and water move along.
fn column(scene: &Scene) -> Result<(), String> {
    let load = scene.surcharge.map_or(LoadOn::Surface, |load| load.on);
    if !scene.is_one_dimensional() {
        let expected = "a level column between rollers, tight at its sides, under one load all over its top";
        return Err(refusal("boundaries", expected, "a scene that moves in two dimensions"));
    }
    if load == LoadOn::Particles {
        let expected = "\"surface\": a load on the top row of particles leaves half a spacing above it unloaded, an error of \
                        first order in L";
        return Err(refusal("surcharge.on", expected, "\"particles\""));
    }
    let drained = scene.stages[0].drained;
    if drained != [false, false, false, true] && drained != [false, false, true, true] {
        let sides: Vec<&str> = Side::ALL.into_iter().filter(|side| drained[*side as usize]).map(Side::word).collect();
        let found = if sides.is_empty() { "none".to_owned() } else { format!("{sides:?}") };
        return Err(refusal("stages.drained", "[\"top\"] or [\"top\", \"bottom\"]", &found));
    }
    Ok(())
}

/// Whether the strains are large.
fn strain(scene: &Scene) -> Result<bool, String> {
    let ratio = scene.surcharge.map_or(0.0, |load| load.pressure) / scene.oedometer_modulus();
    if scene.strain == StrainChoice::Small || ratio <= SMALL {
        return Ok(false);
    }
    if scene.integrator == Integrator::QuasiStatic {
        return Ok(true);
    }
    let expected = format!("at most {SMALL} M = {:.4e} Pa", SMALL * scene.oedometer_modulus());
    Err(refusal("surcharge.pressure", &expected, &load_words(scene)))
}

fn load_words(scene: &Scene) -> String {
    let pressure = scene.surcharge.map_or(0.0, |load| load.pressure);
    format!("{pressure} Pa = {:.4} M", pressure / scene.oedometer_modulus())
}

/// rho_w/rho.
fn water_share(scene: &Scene) -> f64 {
    scene.water.map_or(0.0, |water| water.density) / scene.mixture_density()
}

/// What the waves of a dynamic scene may do to a solution without them.
fn waves(scene: &Scene, series: &Terzaghi) -> Result<(), String> {
    let period = scene.height * (scene.mixture_density() / (scene.oedometer_modulus() + scene.pore_stiffness())).sqrt();
    if scene.start == Start::Unloaded && series.ramp < period {
        let expected = format!(
            "at least {period:.3e} s, in which a wave passes the height (or start = \"undrained-equilibrium\"): no mesh \
             carries the shock of a sudden load"
        );
        return Err(refusal("surcharge.ramp_time", &expected, &format!("{} s", series.ramp)));
    }
    let (carried, weight) = (series.undrained / series.load, water_share(scene));
    if scene.darcy_inertia && carried < weight {
        let expected = format!(
            "false where the water carries a smaller share of a load, Q/(M + Q) = {carried:.3}, than of the weight, rho_w/rho = \
             {weight:.3}: with rho_w a_s in Darcy's law every wave then grows by itself"
        );
        return Err(refusal("scheme.darcy_inertia", &expected, "true"));
    }
    if !series.double {
        return Ok(());
    }
    // The soil above the drained base falls as a half space consolidates, by (q/M) sqrt(c t): what its mass needs, over q.
    let first = scene.observe_times.iter().copied().find(|time| *time > 0.0).unwrap_or(f64::NAN);
    let mass = scene.mixture_density() * 0.5 * scene.height;
    let share = 0.25 * mass * series.coefficient.sqrt() / (series.modulus * first.powf(1.5));
    if share <= INERTIA {
        return Ok(());
    }
    let expected = format!(
        "a soil slow enough (water.hydraulic_conductivity), or times late enough, that inertia takes at most {INERTIA} of \
         the load at the first of them: no exact solution has both ends drained and inertia (or integrator = \
         \"quasi-static\")"
    );
    Err(refusal("stages.drained", &expected, &format!("{share:.2e} at {first:.3e} s")))
}
