//! Quantities of the soil that pictures colour it by.

use mpm_core::observe::SolidState;

use crate::frames::{Shot, mean_stress};
use crate::report::numbers::brief;

/// A quantity of a solid particle.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// Short name: `strain`.
    pub name: &'static str,
    /// Name of its maps of a levee, without ending.
    pub picture: &'static str,
    /// Name and unit, for readers: `pore pressure (kPa)`.
    pub label: &'static str,
    /// The same as a column of a CSV: `pore_pressure_kpa`.
    pub column: &'static str,
    /// Its value in that unit.
    pub of: fn(&SolidState) -> f64,
    /// Least value at the top of its colour scale: nothing that happens to a slope is smaller, and has no bright colour.
    pub least: f64,
}

/// Deviator strain since counting began, without unit.
pub const STRAIN: Quantity = Quantity {
    name: "strain",
    picture: "levee-strain",
    label: "deviator strain",
    column: "deviator_strain",
    of: |p| p.deviator_strain,
    least: 1e-2,
};

/// Pore pressure, kPa.
pub const PRESSURE: Quantity = Quantity {
    name: "pressure",
    picture: "levee-pressure",
    label: "pore pressure (kPa)",
    column: "pore_pressure_kpa",
    of: |p| p.pore_pressure / 1e3,
    least: 0.1,
};

/// Length of the displacement since counting began, m.
pub const DISPLACEMENT: Quantity = Quantity {
    name: "displacement",
    picture: "levee-displacement",
    label: "displacement (m)",
    column: "displacement_m",
    of: |p| p.displacement[0].hypot(p.displacement[1]),
    least: 1e-3,
};

/// Mean effective stress, kPa, compression positive.
pub const MEAN_STRESS: Quantity = Quantity {
    name: "mean-stress",
    picture: "levee-mean-stress",
    label: "mean effective stress (kPa)",
    column: "mean_effective_stress_kpa",
    of: |p| mean_stress(p) / 1e3,
    least: 0.1,
};

/// Logarithm (base 10) of the speed in m/s.
pub const SPEED: Quantity = Quantity {
    name: "speed",
    picture: "levee-speed",
    label: "speed (m/s, powers of 10)",
    column: "log10_speed_m_s",
    of: |p| p.velocity[0].hypot(p.velocity[1]).log10(),
    least: 1.0,
};

/// All that have pictures of their own.
pub const ALL: [Quantity; 4] = [STRAIN, PRESSURE, DISPLACEMENT, MEAN_STRESS];

/// Percentile at which colour scales are clipped: one particle must not set the scale for all others.
const PERCENTILE: f64 = 0.995;
/// What is said of a scale that is.
pub const CLIPPED: &str = "Colour scale clipped at the 99.5th percentile";

/// Functions have no identity to compare: columns have.
impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.column == other.column
    }
}

impl Quantity {
    /// Values at the ends of its colour scale, one for all frames: zero, and the largest 99.5th percentile of a frame, or `least`.
    pub fn range<'a>(&self, shots: impl IntoIterator<Item = &'a Shot>) -> (f64, f64) {
        let (low, high) = range(shots, self.of);
        (low, high.max(self.least))
    }

    /// Sentence on a colour scale that ends below some values of the frames; empty for another.
    pub fn clipped(&self, shots: &[&Shot], (_, high): (f64, f64)) -> String {
        let values = shots.iter().flat_map(|shot| shot.frame.solid.iter().map(self.of)).filter(|v| v.is_finite());
        let most = values.fold(high, f64::max);
        if most > high { format!(" {CLIPPED}: {} goes up to {}.", self.label, brief(most, 3)) } else { String::new() }
    }
}

/// The same of any value of a particle.
pub fn range<'a>(shots: impl IntoIterator<Item = &'a Shot>, of: impl Fn(&SolidState) -> f64) -> (f64, f64) {
    let tops = shots.into_iter().filter_map(|shot| robust(shot.frame.solid.iter().map(&of))).map(|(_, high)| high);
    let top = tops.fold(0.0, f64::max);
    (0.0, if top > 0.0 { top } else { 1.0 })
}

/// The 0.5th and the 99.5th percentile of the values that are numbers; nothing if there are none.
pub fn robust(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)? as f64;
    Some((values[((1.0 - PERCENTILE) * last).floor() as usize], values[(PERCENTILE * last).ceil() as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn a_range_is_that_of_all_frames_without_outliers() {
        let mut shots = made_up::shots(1, 2);
        let (low, high) = DISPLACEMENT.range(&shots);
        assert!(low == 0.0 && (1.5..2.1).contains(&high), "{high}");
        shots[2].frame.solid[0].displacement = [1e3, 0.0];
        shots[2].frame.solid[1].displacement = [f64::NAN, 0.0];
        assert!(DISPLACEMENT.range(&shots).1 < 2.1);
        assert_eq!(robust((0..=1000).map(f64::from)), Some((5.0, 995.0)));
        assert_eq!(robust([f64::NAN].into_iter()), None);
        assert_eq!(STRAIN.range(&[]), (0.0, 1.0));
        let few: Vec<&Shot> = shots.iter().collect();
        assert_eq!(DISPLACEMENT.clipped(&few, (0.0, 2e3)), "");
        assert!(DISPLACEMENT.clipped(&few, (0.0, 2.0)).ends_with("displacement (m) goes up to 1000."));
        // Strains of a slope that stands are no band of failure.
        shots[0].frame.solid.iter_mut().for_each(|p| p.deviator_strain *= 1e-3);
        assert_eq!(STRAIN.range(&shots[..1]), (0.0, 1e-2));
    }

    #[test]
    fn values_are_in_the_unit_of_the_label() {
        let soil = SolidState {
            stress: [-1e3, -2e3, -3e3, 5e2],
            pore_pressure: 4e3,
            displacement: [3.0, -4.0],
            deviator_strain: 0.0,
            ..made_up::shots(1, 0)[0].frame.solid[0]
        };
        assert_eq!(ALL.map(|q| (q.of)(&soil)), [0.0, 4.0, 5.0, 2.0]);
        assert_eq!((SPEED.of)(&SolidState { velocity: [0.06, 0.08], ..soil }), -1.0);
        assert!(ALL.iter().all(|q| q.label.contains("kPa") == q.column.ends_with("_kpa")));
    }
}
