//! The factor of safety of any slope: strength reduction with three flow rules.
//!
//! The headline is Davis B; the associated value is the upper end of its bracket, the flow rule of the scene stands between
//! ([`Reduction`]). [`State::factors`] finds all three from one state of soil and water, in parallel.

pub mod equilibrium;
pub mod ladder;
pub mod page;

use mpm_core::failure::{Bracket, Driver, Found, Scales, Search, Trial};
use mpm_core::observe::Frame;
use mpm_core::scene::{Reduction, Scene};

use crate::error::Error::{self, Lacks, Unfit};
use crate::experiment::pool;

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
        let one = |place: usize, (by, name): &(Reduction, &str)| {
            let mut tell = |b: &Bracket, trial: &Trial| {
                progress(&format!(
                    "{name}: with its strength over {} it {} after {} steps (speed {:.2e}, stored {:.2e}); between {:.3} and {:.3}",
                    trial.factor, trial.outcome, trial.steps, trial.speed, trial.stored, b.low, b.high
                ));
            };
            self.factor(&Search { by: *by, within, guess: guesses[place] }, &mut tell)
        };
        let mut found = pool::each(jobs, &RULES, one, |_, _| ()).into_iter().map(|found| found.and_then(|found| found));
        let mut next = || found.next().unwrap_or(Err(Lacks("result")));
        let [davis, associated, given] = [next(), next(), next()];
        Ok(Factors { found: [davis?, associated?, given?] })
    }
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

/// See [`guesses`].
const ABOVE: f64 = 1.06;
