//! Which exact solution applies to a scene, or what it lacks: the one list of them. [`solution`] asks for what a refinement can be judged on;
//! [`Solution::of`] is what is shown beside any run of a scene.

use mpm_core::scene::{
    Coupling, Dimension, Feed, Integrator, LoadOn, Scene, Side, SoilLayer, SolidSide, Start, StrainChoice, Until,
};

use super::columns::{Consolidation, DryColumn, INERTIA};
use crate::cases::suite::{Case, problems, suite};
use crate::error::Error;
use crate::exact::bearing::Prandtl;
use crate::exact::boussinesq::Wetting;
use crate::exact::dam::Dam;
use crate::exact::earth_pressure::Rankine;
use crate::exact::infinite_slope::Seepage;
use crate::exact::layered::Layered;
use crate::exact::mandel::Mandel;
use crate::exact::sliding::Sliding;
use crate::exact::terzaghi::Terzaghi;
use crate::exact::wetting_front::{Way, WettingFront};
use crate::experiment::measure::mandel::TIME_FACTOR;
use crate::experiment::spec::Spec;

/// An exact solution.
#[derive(Debug, Clone)]
pub enum Solution {
    /// A column that consolidates, of any strain, weight, drainage and layers.
    Wet(Box<Consolidation>),
    /// A dry column.
    Dry(DryColumn),
    /// Mandel's block.
    Block(Mandel),
    /// A front that wets dry soil.
    Front(WettingFront),
    /// Steady seepage through a rectangular dam.
    Dam(Dam),
    /// Water that spreads on a level base.
    Mound(Wetting),
    /// A block on a base with friction.
    Sliding(Sliding),
    /// An infinite slope whose strength is reduced until it slides: vertical depth (m) and seepage.
    Slope(f64, Seepage),
    /// A column that consolidates in its last stage after Terzaghi, whatever its scheme.
    Series(Terzaghi),
    /// Terzaghi's column under one load times factors that are linear between times (s).
    Ramps(Terzaghi, Vec<[f64; 2]>),
    /// A column of elastic layers that consolidates in its last stage.
    Layers(Layered),
    /// The limit load of a strip footing.
    Footing(Prandtl),
    /// The thrust of soil on a smooth wall.
    Wall(Rankine),
    /// A case of the verification suite with this very scene: its name and title.
    Suite(&'static Spec, &'static str),
}

impl Solution {
    /// What it is called, with its assumptions.
    pub fn words(&self) -> String {
        match self {
            Self::Wet(column) => column.words(),
            Self::Dry(column) => column.words(),
            Self::Block(_) => "Mandel's problem (small strain, no inertia, no weight, rigid plate without friction)".to_owned(),
            Self::Front(front) => {
                let way = match front.way {
                    Way::Horizontal => "level",
                    Way::Down => "downwards",
                    Way::Up => "upwards",
                };
                format!("the sharp front of Green and Ampt, {way} (soil at rest, no capillarity, no inertia of the water)")
            }
            Self::Dam(_) => {
                "steady seepage through a rectangular dam (soil at rest, no capillarity; discharge of Charny)".to_owned()
            }
            Self::Mound(_) => {
                "Boussinesq's wetting of a dry aquifer (hydrostatic over the height, soil at rest, from four heights on)".to_owned()
            }
            Self::Sliding(_) => "a rigid block with Coulomb friction (no rotation, no strain)".to_owned(),
            Self::Slope(depth, _) => format!(
                "limit equilibrium of an infinite slope, plane at the depth {depth} m (strength reduced until it slides)"
            ),
            Self::Series(_) => {
                "Terzaghi's series with compressible water (small strain, linear elasticity, no inertia, no weight)".to_owned()
            }
            Self::Ramps(..) => {
                "Terzaghi's series, superposed for a load that changes in time (small strain, linear elasticity, no inertia, no weight)"
                    .to_owned()
            }
            Self::Layers(_) => {
                "eigenfunctions of the layers (small strain, linear elasticity, no inertia, no weight)".to_owned()
            }
            Self::Footing(_) => {
                "Prandtl's limit load N_c c of a strip footing (rigid-plastic soil with associated flow, no weight or no friction)".to_owned()
            }
            Self::Wall(wall) => {
                let state = if wall.active { "active" } else { "passive" };
                format!("Rankine's {state} thrust on a smooth wall (soil at yield throughout the wedge)")
            }
            Self::Suite(spec, title) => format!("{title} (case {} of the verification suite)", spec.name),
        }
    }

    /// What else the scene carries beside the solution, one sentence each.
    pub fn beside(&self, scene: &Scene) -> Vec<String> {
        match self {
            Self::Wet(column) => column.beside(scene),
            Self::Dry(column) => column.beside(scene),
            Self::Block(_) => vec!["inertia and large strain: none".to_owned()],
            Self::Front(_) | Self::Dam(_) | Self::Mound(_) => {
                vec!["strain of the soil: not judged, the water moves in soil at rest".to_owned()]
            }
            Self::Sliding(_) => {
                let strain = scene.mixture_density() * scene.gravity.unwrap_or(0.0) * scene.height
                    / scene.elastic.youngs_modulus;
                vec![format!("strain of the block under its weight: {strain:.1e}, not in the solution")]
            }
            Self::Slope(..) => vec!["elasticity: moves the slope before it slides, not in the solution".to_owned()],
            _ => Vec::new(),
        }
    }

    /// Whether a scene is a column that consolidates as an exact solution without weight says.
    pub fn consolidates(scene: &Scene) -> bool {
        consolidation(scene).is_some()
    }

    /// The solution to show beside a run of a scene: that of consolidation in the last stage, a limit load, or what [`solution`] finds or the
    /// verification suite measures.
    pub fn of(scene: &Scene) -> Option<Self> {
        consolidation(scene)
            .or_else(|| Prandtl::of(scene).map(Self::Footing))
            .or_else(|| Rankine::of(scene).map(Self::Wall))
            .or_else(|| solution(scene).ok())
            .or_else(|| suite_case(scene))
    }
}

/// The solution of a column that consolidates in its last stage without weight; what came before it, the scheme and inertia do not matter.
fn consolidation(scene: &Scene) -> Option<Solution> {
    if !scene.stages.last().is_some_and(|stage| stage.drained.contains(&true)) || scene.gravity.is_some() {
        return None;
    }
    let elastic = scene.is_elastic();
    if let Some(exact) = Terzaghi::compressible(scene).filter(|_| elastic) {
        return Some(Solution::Series(exact));
    }
    if let Some((exact, factors)) = Terzaghi::under_one_load(scene).filter(|_| elastic) {
        return Some(Solution::Ramps(exact, factors));
    }
    Layered::of(scene).filter(|_| !scene.layers.is_empty()).map(Solution::Layers)
}

/// The first case of the verification suite that measures a scene as it is.
fn suite_case(scene: &Scene) -> Option<Solution> {
    let measures = |case: &'static Case| {
        let spec = case.spec().filter(|spec| spec.measure.is_some() && spec.is_of(scene))?;
        Some(Solution::Suite(spec, &problems()[case.problem].title))
    };
    suite().iter().find_map(measures)
}

/// The solution of a scene.
///
/// # Errors
/// Key, what was expected and what was found.
pub fn solution(scene: &Scene) -> Result<Solution, Error> {
    if scene.cam_clay.is_some() {
        return Err(Error::refused("soil.law", "linear_elastic or mohr_coulomb", "modified_cam_clay"));
    }
    even(scene)?;
    if scene.periodic {
        return slope(scene);
    }
    stages(scene)?;
    if scene.free_surface.is_some() {
        return seepage(scene);
    }
    if scene.base.is_some() {
        return sliding(scene);
    }
    if scene.surcharge.is_some_and(|load| load.on == LoadOn::Plate) {
        return block(scene);
    }
    column(scene)?;
    if scene.water.is_none() {
        return DryColumn::new(scene).map(Solution::Dry);
    }
    integrator(scene)?;
    if scene.integrator != Integrator::QuasiStatic {
        waves(scene)?;
    }
    Consolidation::new(scene).map(|column| Solution::Wet(Box::new(column)))
}

fn even(scene: &Scene) -> Result<(), Error> {
    if scene.displaced.is_some() || scene.shift > 0.0 {
        let (expected, found) =
            ("particles and cells in their even places", "displaced ones: their error has no order");
        return Err(Error::refused("mesh", expected, found));
    }
    if !scene.has_plain_ground() {
        let expected = "one soil or layers of constant conductivity, under a surcharge or weight alone";
        let found = "regions, wells, loads on faces, reservoirs, plates, [initial], inclined bedding or pores that conductivity goes with";
        return Err(Error::refused("[[regions]]", expected, found));
    }
    if scene.water.is_some_and(|water| water.anisotropy != 1.0) && !scene.is_one_dimensional() {
        return Err(Error::refused(
            "water.anisotropy",
            "1: no exact solution in two dimensions has another",
            "another",
        ));
    }
    let weighs = |layer: &SoilLayer| (layer.grain_density, layer.porosity) != (scene.grain_density, scene.porosity);
    if scene.gravity.is_some() && scene.layers.iter().any(weighs) {
        let expected = "the density and porosity of [soil] under gravity";
        return Err(Error::refused("[[layers]]", expected, "layers that weigh differently"));
    }
    if scene.outline.is_some() {
        return Err(Error::refused(
            "[geometry]",
            "a column or a block: no exact solution has an outline",
            "an outline",
        ));
    }
    if scene.observe_times.is_empty() {
        return Err(Error::refused("[observe]", "times or time factors to compare at", "none"));
    }
    Ok(())
}

fn integrator(scene: &Scene) -> Result<(), Error> {
    match scene.integrator {
        Integrator::Explicit | Integrator::SemiImplicit | Integrator::QuasiStatic | Integrator::Implicit => Ok(()),
        Integrator::Staggered | Integrator::Coupled => {
            let expected = "\"explicit\", \"semi-implicit\", \"quasi-static\" or \"implicit\"";
            Err(Error::refused("time.integrator", expected, format!("\"{}\"", crate::study::word(scene.integrator))))
        }
    }
}

fn stages(scene: &Scene) -> Result<(), Error> {
    let [stage] = scene.stages.as_slice() else {
        let expected =
            "one: what came before it is in no exact solution (start = \"undrained-equilibrium\" stands for it)";
        return Err(Error::refused("[[stages]]", expected, scene.stages.len().to_string()));
    };
    if stage.damping > 0.0 && scene.water.is_some() {
        return Err(Error::refused("stages.damping", "none", format!("{} 1/s", stage.damping)));
    }
    if !matches!(stage.until, Until::Time(_)) {
        return Err(Error::refused("stages.until", "time or time_factor", "an end that follows from the run"));
    }
    Ok(())
}

fn block(scene: &Scene) -> Result<Solution, Error> {
    let exact = Mandel::new(scene).ok_or_else(|| {
        let expected = "Mandel's problem under it: start = \"unloaded\", a step load, left and bottom \"roller\", right and \
                        top \"free\", only the right side drained, no gravity";
        Error::refused("surcharge.on", expected, "\"plate\" in another scene")
    })?;
    if scene.strain != StrainChoice::Small {
        return Err(Error::refused(
            "soil.strain",
            "\"small\": Mandel's solution is that of small strains",
            "\"large\"",
        ));
    }
    if !scene.observe_times.iter().any(|time| exact.time_factor(*time) >= TIME_FACTOR * (1.0 - 1e-6)) {
        let expected = format!("a time from T = c t/a^2 = {} on", TIME_FACTOR);
        return Err(Error::refused("[observe]", &expected, "none"));
    }
    Ok(Solution::Block(exact))
}

/// A column that soil and water move along.
fn column(scene: &Scene) -> Result<(), Error> {
    let load = scene.surcharge.map_or(LoadOn::Surface, |load| load.on);
    if !scene.is_plain_column() {
        let expected = "a level column between rollers, tight at its sides, under one load all over its top";
        return Err(Error::refused("boundaries", expected, "a scene that moves in two dimensions"));
    }
    if load == LoadOn::Particles {
        let expected = "\"surface\": a load on the top row of particles leaves half a spacing above it unloaded, an error of \
                        first order in L";
        return Err(Error::refused("surcharge.on", expected, "\"particles\""));
    }
    if scene.surcharge.is_none() && scene.gravity.is_none() {
        return Err(Error::refused("[surcharge]", "a load or gravity that the soil settles under", "neither"));
    }
    let load = scene.surcharge.map_or(0.0, |load| load.pressure);
    if load < 0.0 && (!scene.is_elastic() || scene.separation.is_some()) {
        let expected = "compression: soil with a strength or a tension gap has no exact solution in extension";
        return Err(Error::refused("surcharge.pressure", expected, format!("{load} Pa")));
    }
    if !scene.is_elastic() && (!scene.layers.is_empty() || scene.start == Start::Geostatic) {
        let expected = "one soil that is loaded from no stress where it may yield";
        return Err(Error::refused("soil.law", expected, "layers or start = \"geostatic\""));
    }
    Ok(())
}

/// What the waves of a dynamic wet column may do to a solution without them.
fn waves(scene: &Scene) -> Result<(), Error> {
    let period = scene.height * (scene.mixture_density() / (scene.oedometer_modulus() + scene.pore_stiffness())).sqrt();
    let (ramp, weight) = (scene.surcharge.map_or(0.0, |s| s.ramp_time), scene.gravity.is_some());
    if scene.start == Start::Unloaded && (ramp < period || weight) {
        let expected = format!(
            "at least {period:.3e} s and no weight, in which a wave passes the height (or start = \
             \"undrained-equilibrium\"): no mesh carries the shock of a sudden load"
        );
        let found = if weight { "gravity that acts at once".to_owned() } else { format!("{ramp} s") };
        return Err(Error::refused("surcharge.ramp_time", &expected, &found));
    }
    if scene.darcy_inertia && scene.inertia_feeds_waves() {
        let expected = format!(
            "false where the water carries a smaller share of a load, Q/(M + Q) = {:.3}, than of the weight, rho_w/rho = \
             {:.3}: with rho_w a_s in Darcy's law every wave then grows by itself",
            scene.undrained_share(),
            scene.water.map_or(0.0, |water| water.density) / scene.mixture_density()
        );
        return Err(Error::refused("scheme.darcy_inertia", &expected, "true"));
    }
    Ok(())
}

/// Refuses a column drained in another way whose inertia shows at every time.
pub(super) fn inertia_shows(share: f64, time: f64) -> Error {
    let expected = format!(
        "a soil slow enough (water.hydraulic_conductivity), or times late enough, that inertia takes at most {INERTIA} of the \
         load at one of them: no exact solution with inertia has both ends drained, layers or no drainage (or integrator = \
         \"quasi-static\")"
    );
    Error::refused("stages.drained", &expected, format!("{share:.2e} at {time:.3e} s"))
}

/// Water that moves through soil at rest.
fn seepage(scene: &Scene) -> Result<Solution, Error> {
    let (free, water) = (scene.free_surface.as_ref(), scene.water);
    let (Some(free), Some(water)) = (free, water) else {
        return Err(Error::refused("[water]", "water with a free surface", "none"));
    };
    if free.retention.is_some() {
        let expected = "sharp fronts: what unsaturated soil does is compared in its own cases";
        return Err(Error::refused("water.free_surface.retention", expected, "a retention"));
    }
    let moved = scene.stages[0].coupling != Coupling::Seepage || !scene.layers.is_empty();
    if moved || free.wet.is_some() || free.level.is_some_and(|level| level > 0.0) {
        let expected = "dry or moist soil of one kind at rest, fed from t = 0";
        return Err(Error::refused("water.free_surface", expected, "soil that moves, layers, or water at t = 0"));
    }
    let head = |side: Side| match free.feeds[side as usize] {
        Some(Feed::Head(head)) => Some(head),
        _ => None,
    };
    let fed: Vec<Side> = Side::ALL.into_iter().filter(|side| free.feeds[*side as usize].is_some()).collect();
    let drained: Vec<Side> = Side::ALL.into_iter().filter(|side| scene.stages[0].drained[*side as usize]).collect();
    let found = format!("fed at {fed:?}, drained at {drained:?}");
    let front = |way, head| {
        let (conductivity, porosity) = (water.hydraulic_conductivity, scene.porosity);
        Ok(Solution::Front(WettingFront { way, conductivity, head, porosity, initial_saturation: free.saturation }))
    };
    let flat = scene.dimension == Dimension::PlaneStrain;
    match (fed.as_slice(), drained.as_slice(), scene.gravity) {
        ([Side::Left], [], None) if flat => front(Way::Horizontal, head(Side::Left).unwrap_or(f64::NAN)),
        ([Side::Top], [], Some(_)) => front(Way::Down, head(Side::Top).unwrap_or(f64::NAN) - scene.height),
        ([Side::Bottom], [], Some(_)) => front(Way::Up, head(Side::Bottom).unwrap_or(f64::NAN)),
        ([Side::Left], [], Some(_)) if flat && free.saturation == 0.0 => mound(scene, head(Side::Left)),
        ([Side::Left], [Side::Right], Some(_)) | ([Side::Left, Side::Right], _, Some(_)) if flat => {
            let tail = head(Side::Right).unwrap_or(0.0);
            let dam = head(Side::Left).filter(|up| *up <= scene.height).and_then(|up| Dam::new(up, tail, scene.width));
            let expected = "heads H1 > H2 >= 0 within the height of the dam";
            dam.map(Solution::Dam).ok_or_else(|| Error::refused("water.free_surface.feed", expected, &found))
        }
        _ => {
            let expected =
                "a head at the left, top or bottom alone (fronts), or at the left of a dam that drains at the right";
            Err(Error::refused("water.free_surface.feed", expected, &found))
        }
    }
    .and_then(|solution| match &solution {
        Solution::Front(front) if !(front.head.is_finite() && front.head > 0.0) => {
            Err(Error::refused("water.free_surface.feed", "a head above zero at the fed side", &found))
        }
        _ => Ok(solution),
    })
}

fn mound(scene: &Scene, head: Option<f64>) -> Result<Solution, Error> {
    let (Some(head), Some(water)) = (head, scene.water) else {
        return Err(Error::refused("water.free_surface.feed", "a head", "a velocity"));
    };
    let exact = Wetting::new(water.hydraulic_conductivity, scene.porosity, head);
    let within = |time: &&f64| (4.0 * head..scene.width).contains(&exact.front(**time));
    if scene.observe_times.iter().find(within).is_none() {
        let expected = "a time at which the tip of the water is between four heights and the end of the soil";
        return Err(Error::refused("[observe]", expected, "none"));
    }
    Ok(Solution::Mound(exact))
}

fn sliding(scene: &Scene) -> Result<Solution, Error> {
    let free =
        [Side::Left, Side::Right, Side::Top].iter().all(|side| scene.solid_sides[*side as usize] == SolidSide::Free);
    let stiff = scene.is_elastic() && scene.water.is_none() && scene.surcharge.is_none();
    let exact = Sliding::new(scene).filter(|_| free && stiff && scene.dimension == Dimension::PlaneStrain);
    let exact = exact.ok_or_else(|| {
        let expected = "a dry elastic block with free sides under gravity alone";
        Error::refused("[base]", expected, "friction under another scene")
    })?;
    if exact.distance(*scene.observe_times.last().unwrap_or(&0.0)) <= 0.0 {
        return Err(Error::refused("[base]", "a block that slides", "one that stays where it is"));
    }
    Ok(Solution::Sliding(exact))
}

fn slope(scene: &Scene) -> Result<Solution, Error> {
    let strength =
        scene.strength.filter(|_| scene.slope_angle.is_some_and(|b| b > 0.0) && scene.free_surface.is_some());
    let (Some(_), Some(free), [Coupling::Seepage, Coupling::Soil]) =
        (strength, &scene.free_surface, scene.stages.iter().map(|stage| stage.coupling).collect::<Vec<_>>().as_slice())
    else {
        let expected = "a periodic slope with a strength and a free surface, and two stages: seepage, then the soil";
        return Err(Error::refused("boundaries", expected, "another periodic scene"));
    };
    let [psi, phi] = strength.map_or([0.0; 2], |s| [s.dilation_angle, s.friction_angle]);
    if psi > 0.0 && psi != phi {
        let expected = format!("0 or {phi} degrees: between them the strength of a slope is not unique");
        return Err(Error::refused("soil.law.dilation_angle", &expected, format!("{psi}")));
    }
    let depth = scene.height / scene.slope_angle.unwrap_or(0.0).to_radians().cos();
    let share = free.level.unwrap_or(0.0) / scene.height;
    if free.feeds.iter().any(Option::is_some) || !(0.0..=1.0).contains(&share) {
        let expected = "a level within the slope and no feed: water that flows along it";
        return Err(Error::refused("water.free_surface", expected, "another seepage"));
    }
    Ok(Solution::Slope(depth, Seepage::Parallel { share }))
}
