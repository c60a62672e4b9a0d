//! What can be measured in a run, each beside its exact value.

mod balances;
pub(crate) mod free_surface;
pub(crate) mod heads;
pub(crate) mod mandel;
mod pressures;
mod settlement;
pub(crate) mod sliding;
mod solids;
mod stages;
mod unsaturated;
mod waves;

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
const MEASURES: &[(&str, Make)] = &[
    ("settlement", settlement::settlement),
    ("settlement-in-stages", stages::stages),
    ("profile-error", settlement::profile),
    ("pressure-in-layers", settlement::in_layers),
    ("pressure-radial", pressures::radial),
    ("pressure-seabed", pressures::seabed),
    ("pressure-around-well", pressures::around_well),
    ("pressure-beside-wells", pressures::beside_wells),
    ("pressure-steady-well", pressures::steady_well),
    ("pressure-sealed-disc", pressures::sealed_disc),
    ("pressure-narrowed-pores", pressures::narrowed_pores),
    ("pressure-along-slope", heads::along_slope),
    ("heads-in-series", heads::in_series),
    ("heads-along-layers", heads::along_layers),
    ("heads-refracted", heads::refraction),
    ("flow-along-layers", heads::flow_along_layers),
    ("discharge-of-zones", heads::discharge_of_zones),
    ("way-along-slope", heads::way_along_slope),
    ("filled-by-rain", heads::filled_by_rain),
    ("dissipation", heads::dissipation),
    ("stress-under-strip", solids::strip_stress),
    ("mean-settlement", solids::mean_settlement),
    ("plate-force", solids::plate_force),
    ("released", solids::released),
    ("pressure-under-strip", solids::strip_pressure),
    ("pressure-mandel", mandel::pressure),
    ("pressure-undrained", waves::undrained),
    ("pressure-at-mid-height", waves::at_mid_height),
    ("pressure-at-base", waves::at_base),
    ("arrival-at-mid-height", waves::arrival),
    ("step", waves::step),
    ("speed", balances::speed),
    ("water-balance", balances::water_balance),
    ("energy", balances::energy),
    ("way-of-block", sliding::way),
    ("friction-work", sliding::friction_work),
    ("velocity-of-slab", sliding::slab),
    ("front", free_surface::front),
    ("tip", free_surface::tip),
    ("discharge-of-dam", free_surface::discharge),
    ("exit-of-dam", free_surface::exit),
    ("surface-of-dam", free_surface::surface),
    ("stored-in-dam", free_surface::stored),
    ("column-drains", free_surface::drains),
    ("rain", free_surface::rain),
    ("infiltration", unsaturated::infiltration),
    ("steady-suction", unsaturated::steady),
    ("wetted-box", unsaturated::wetted_box),
    ("discharge-of-capillary-dam", unsaturated::capillary_dam),
    ("exit-of-capillary-dam", unsaturated::capillary_exit),
];

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
