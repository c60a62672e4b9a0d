//! What can be measured in a run, each beside its exact value.

mod settlement;

use mpm_core::drive::Run;
use mpm_core::scene::Scene;

use super::comparison::Comparison;
use super::spec::Measure;
use crate::error::Error;

/// Compares a run.
pub(crate) type Compare = Box<dyn Fn(&Run) -> Result<Comparison, Error>>;
/// Makes what compares runs from the scene as it should be.
type Make = fn(&Scene, &Measure) -> Result<Compare, Error>;

/// All measures by their words.
const MEASURES: &[(&str, Make)] = &[("settlement", settlement::settlement), ("profile-error", settlement::profile)];

impl Measure {
    /// What compares runs of a scene, as it should be, with the reference.
    ///
    /// # Errors
    /// No such measure, or one that does not apply to the scene.
    pub(crate) fn of_scene(&self, scene: &Scene) -> Result<Compare, Error> {
        let make = MEASURES.iter().find(|(word, _)| *word == self.of).map(|(_, make)| make);
        let words = || MEASURES.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ");
        make.ok_or_else(|| Error::refused("measure.of", format!("one of {}", words()), &self.of))?(scene, self)
    }

    /// Which of the times (s) of a stage count.
    fn counts(&self, scene: &Scene) -> impl Fn(f64) -> bool + use<> {
        let one = scene.time_per_factor().unwrap_or(f64::NAN);
        let from = if self.from_time_factor > 0.0 { 0.999 * self.from_time_factor * one } else { 0.0 };
        let (at, end) = (self.at_time_factor.map(|factor| factor * one), scene.observe_times.last().copied());
        let last = self.at_end.then_some(end).flatten();
        move |time| {
            let is = |other: f64| (time / other - 1.0).abs() < 1e-9;
            time >= from && at.is_none_or(is) && last.is_none_or(is)
        }
    }
}
