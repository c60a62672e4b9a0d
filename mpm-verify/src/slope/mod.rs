//! The factor of safety of any slope: strength reduction with three flow rules.
//!
//! The headline is Davis B; the associated value is the upper end of its bracket, the flow rule of the scene stands between
//! ([`Reduction`]). [`State::factors`] finds all three from one state of soil and water, in parallel.

pub mod equilibrium;
pub mod ladder;
pub mod page;

use mpm_core::failure::{Bracket, Driver, Found, Scales, Search, Trial};
use mpm_core::observe::Frame;
use mpm_core::scene::{Reduction, Region, Scene};

use crate::error::Error::{self, Unfit};
use crate::experiment::pool;
use crate::report::numbers::short;

/// The flow rules, the headline first, with what they are called.
pub const RULES: [(Reduction, &str); 3] =
    [(Reduction::Davis, "Davis B"), (Reduction::Associated, "associated"), (Reduction::AsGiven, "as given")];

/// What is found with each of [`RULES`].
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    /// Davis B, associated, as given.
    pub found: [Found; 3],
}

/// Soil and water of a scene at some time, of which factors are asked.
#[derive(Debug)]
pub struct State<'a> {
    scene: &'a Scene,
    bytes: Vec<u8>,
    /// Free surface of the water (x, y), m.
    pub level: Vec<[f64; 2]>,
    /// Slides are at least so deep, m.
    pub depth: f64,
    /// Time, s, and the cells of the run then.
    time: f64,
    frame: Frame,
}

impl<'a> State<'a> {
    /// After the water has seeped for a time (s) through soil that is held.
    ///
    /// # Errors
    /// What was expected of the scene and found, or what went wrong in a step.
    pub fn after(scene: &'a Scene, time: f64) -> Result<Self, Error> {
        let mut driver = at_rest(scene)?;
        driver.seep_only(time)?;
        Ok(Self::of(scene, &mut driver))
    }

    /// As a run has it now.
    pub fn of(scene: &'a Scene, driver: &mut Driver) -> Self {
        let (level, depth) = (driver.surface(), Scales::of(scene).depth());
        Self { scene, bytes: driver.checkpoint(), level, depth, time: driver.time, frame: driver.frame() }
    }

    /// Limit equilibrium with its water: with the strength of the soils, and with Davis' reduced one.
    ///
    /// # Errors
    /// Why there is none.
    pub fn slices(&self) -> Result<[equilibrium::Factors; 2], Error> {
        equilibrium::factors(self.scene, &self.water(), self.depth)
    }

    /// Spencer's factor of another scene with this water.
    ///
    /// # Errors
    /// Why there is none.
    pub fn spencer_of(&self, scene: &Scene) -> Result<f64, Error> {
        equilibrium::spencer(scene, &self.water(), self.depth)
    }

    fn water(&self) -> equilibrium::Water<'_> {
        // Before water has seeped its pressures are hydrostatic.
        let cells = Some(&self.frame).filter(|_| self.time > 0.0);
        equilibrium::Water { level: &self.level, time: self.time, cells }
    }

    /// One factor.
    ///
    /// # Errors
    /// What went wrong in a step.
    pub fn factor(&self, search: &Search, progress: &mut dyn FnMut(&Bracket, &Trial)) -> Result<Found, Error> {
        let mut driver = Driver::new(self.scene)?;
        driver.restore(&self.bytes)?;
        Ok(driver.safety(search, progress)?)
    }

    /// The factors with all flow rules, first looked for at some factors, on so many threads.
    ///
    /// # Errors
    /// What went wrong in a step.
    pub fn factors(
        &self,
        (within, guesses): (f64, [f64; 3]),
        jobs: usize,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<Factors, Error> {
        let (first, of) = distinct(self.scene, RULES.map(|(by, _)| by));
        let one = |_: usize, place: &usize| {
            let (by, name) = RULES[*place];
            let mut tell = |b: &Bracket, trial: &Trial| {
                progress(&format!(
                    "{name}: with its strength over {} it {} after {} steps (speed {:.2e}, stored {:.2e}); between {:.3} and {:.3}",
                    trial.factor, trial.outcome, trial.steps, trial.speed, trial.stored, b.low, b.high
                ));
            };
            self.factor(&Search { by, within, guess: guesses[*place] }, &mut tell)
        };
        let found = pool::each(jobs, &first, one, |_, _| ()).into_iter().map(|found| found.and_then(|found| found));
        let found = found.collect::<Result<Vec<_>, _>>()?;
        Ok(Factors { found: of.map(|place| found[place].clone()) })
    }
}

/// Places of the flow rules that differ from those before them in this scene, and for each rule which of these it is: without friction,
/// or where the soil dilates as much as it rubs, some are the same.
pub fn distinct<const N: usize>(scene: &Scene, rules: [Reduction; N]) -> (Vec<usize>, [usize; N]) {
    let soils = scene.soils();
    let same = |a: Reduction, b: Reduction| {
        soils.iter().filter_map(|soil| soil.strength).all(|strength| {
            let [a, b] = [a, b].map(|by| strength.reduced(OTHER, by));
            let near = |a: f64, b: f64| (a - b).abs() <= ROUND_OFF * a.abs();
            near(a.cohesion, b.cohesion)
                && near(a.friction_angle, b.friction_angle)
                && near(a.dilation_angle, b.dilation_angle)
                && a.dilation_fades_over == b.dilation_fades_over
        })
    };
    let mut first: Vec<usize> = Vec::new();
    let of = std::array::from_fn(|place| {
        let earlier = first.iter().position(|other| same(rules[*other], rules[place]));
        earlier.unwrap_or_else(|| {
            first.push(place);
            first.len() - 1
        })
    });
    (first, of)
}

/// What the mesh of a scene is too coarse for, in words: layers and regions of few cells across. All soils in a cell are strained alike, so that it
/// bears what the stronger ones bear, and a weak seam slides only along cells that lie in it.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let bases = std::iter::once(0.0).chain(scene.layers.iter().map(|layer| layer.up_to));
    let layers = scene.layers.iter().zip(bases).map(|(layer, base)| ("layer", layer.up_to - base));
    // Of a band as long as it is thick, half of that; of a long one, its thickness.
    let regions = scene.regions.iter().map(|Region { polygon, .. }| {
        let around: f64 = (0..polygon.len())
            .map(|i| {
                let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                (b[0] - a[0]).hypot(b[1] - a[1])
            })
            .sum();
        ("region", 2.0 * mpm_core::seeding::area(polygon).abs() / around)
    });
    let layers = layers.enumerate();
    let all = layers.chain(regions.enumerate()).filter(|(_, (_, thickness))| *thickness < ACROSS * scene.cell);
    all.map(|(place, (kind, thickness))| {
        let (across, cell) = (thickness / scene.cell, short(thickness / ACROSS, 2));
        format!(
            "{kind} {} is some {} m thick, {} cells: if it is weak, what strength reduction finds is too high; on cells of {cell} m it has {ACROSS} \
             across",
            place + 1,
            short(thickness, 2),
            short(across, 2),
        )
    })
    .collect()
}

/// A run whose soil has come to rest with the strength that the lowest factor needs.
///
/// # Errors
/// What was expected of the scene and found, or what went wrong in a step.
pub fn at_rest(scene: &Scene) -> Result<Driver<'_>, Error> {
    let mut driver = Driver::new(scene)?;
    let settled = driver.load_for_safety()?;
    settled.at_rest().then_some(driver).ok_or(Unfit("the slope does not stand with five times its strength"))
}

/// Where to look for the factors first: a little above what limit equilibrium says, so that the first trial slides.
pub fn guesses(slices: &Result<[equilibrium::Factors; 2], Error>) -> [f64; 3] {
    let [full, davis] = match slices {
        Ok(found) => found.each_ref().map(|factors| factors.any_shape.or(factors.spencer).or(factors.bishop)),
        Err(_) => [None; 2],
    };
    let above = |factor: Option<f64>| factor.map_or(1.0, |factor| ABOVE * factor);
    [above(davis), above(full), above(full)]
}

/// Cells across a layer from which on it bears hardly more than its own strength.
const ACROSS: f64 = 4.0;
/// A factor at which flow rules are compared, and how close strengths are that are the same.
const OTHER: f64 = 1.5;
const ROUND_OFF: f64 = 1e-12;

/// See [`guesses`].
const ABOVE: f64 = 1.06;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::SLOPES;

    fn slope(name: &str) -> Scene {
        let text = SLOPES.iter().find(|(known, _)| *known == name).expect("a slope").1;
        Scene::parse(text, name).expect("a scene")
    }

    #[test]
    fn flow_rules_that_are_the_same_for_the_soils_are_searched_once() {
        let rules = RULES.map(|(by, _)| by);
        assert_eq!(distinct(&slope("acads-1a"), rules), (vec![0, 1, 2], [0, 1, 2]));
        assert_eq!(distinct(&slope("taylor-60-0"), rules), (vec![0], [0, 0, 0]));
        // As much dilation as friction is associated, with the strength of Davis.
        let dilates = slope("acads-1a").patched(&[("soil.law.mohr_coulomb.dilation_angle", 19.6.into())]);
        assert_eq!(distinct(&dilates.expect("a scene"), rules), (vec![0], [0, 0, 0]));
    }

    #[test]
    fn layers_of_few_cells_are_named() {
        let warnings = warnings(&slope("acads-4"));
        assert!(
            warnings.len() == 1 && warnings[0].starts_with("region 1 is some 0.57 m thick, 1.1 cells"),
            "{warnings:?}"
        );
        assert_eq!(super::warnings(&slope("acads-1c")), Vec::<String>::new());
    }
}
