//! The baseline: consolidation by finite volumes, as one would write it in an hour.
//!
//! `(1/M + n/K_w) dp/dt = (k/gamma_w) d2p/dz2` on equal cells with the pressure at their middle, p = 0 at the top half a
//! cell away, no flow at the base, from the undrained pressure. Second order in space. In time BDF2 with a constant
//! step, `(3 p_new - 4 p + p_old)/(2 dt)`, started by one step of implicit Euler, whose error of order dt^2 is made
//! once. Both tridiagonal matrices are factored once (Thomas). `U = mean(q - p)/q`, counted from the unloaded state.

use mpm_core::scene::{Integrator, Scene, Side};
use mpm_verify::norms::SAMPLE_TV;

/// A column of soil, reduced to what its consolidation needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Soil {
    /// Height H, m.
    pub height: f64,
    /// c = (k/gamma_w)/(1/M + n/K_w), m2/s.
    pub diffusivity: f64,
    /// Load q, Pa.
    pub load: f64,
    /// Undrained pressure p_0, Pa.
    pub undrained: f64,
    /// Seconds per unit of Tv.
    pub time_per_factor: f64,
}

impl Soil {
    /// The soil of a scene; `None` for one that is dry, unloaded, not one-dimensional or not drained at the top alone.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let drained = scene.stages.last()?.drained;
        let top_alone = Side::ALL.iter().all(|side| drained[*side as usize] == (*side == Side::Top));
        if !(scene.is_one_dimensional() && top_alone && load.ramp_time == 0.0) {
            return None;
        }
        let storage = 1.0 / scene.oedometer_modulus() + 1.0 / scene.pore_stiffness();
        Some(Self {
            height: scene.height,
            diffusivity: water.mobility() / storage,
            load: load.pressure,
            undrained: scene.undrained_pressure(),
            time_per_factor: scene.time_per_factor()?,
        })
    }
}

/// Cells over the height and steps up to Tv = 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiniteVolumes {
    /// Cells.
    pub cells: usize,
    /// Steps; a multiple of [`STEPS`], so that every sample time ends one.
    pub steps: usize,
}

/// Steps of 0.01 Tv: the sample times are multiples of it.
pub const STEPS: usize = 100;

/// How the baseline is called where integrators stand.
pub const NAME: &str = "baseline";

/// Whether a row is about the integrator of this name.
pub fn is(integrator: &str) -> bool {
    integrator == NAME
}

/// Names of all integrators with the baseline last.
pub fn with_integrators() -> Vec<String> {
    let own = [Integrator::Explicit, Integrator::SemiImplicit, Integrator::QuasiStatic];
    own.iter().map(mpm_verify::study::word).chain([NAME.to_owned()]).collect()
}

impl FiniteVolumes {
    /// Length of a step, s.
    pub fn step(&self, soil: &Soil) -> f64 {
        soil.time_per_factor / self.steps as f64
    }

    /// U at the sample times.
    pub fn solve(&self, soil: &Soil) -> Vec<f64> {
        let width = soil.height / self.cells as f64;
        let number = soil.diffusivity * self.step(soil) / (width * width);
        let (euler, bdf2) = (Factored::new(self.cells, 1.0, number), Factored::new(self.cells, 1.5, number));
        let mut old = vec![soil.undrained; self.cells];
        let mut now = old.clone();
        euler.solve(&mut now);
        let stops = SAMPLE_TV.map(|tv| (tv * self.steps as f64).round() as usize);
        let mut degrees = Vec::with_capacity(stops.len());
        for step in 1..=self.steps {
            if step > 1 {
                for (old, now) in old.iter_mut().zip(&now) {
                    *old = 2.0 * now - 0.5 * *old;
                }
                bdf2.solve(&mut old);
                std::mem::swap(&mut old, &mut now);
            }
            if stops.contains(&step) {
                degrees.push(1.0 - now.iter().sum::<f64>() / (self.cells as f64 * soil.load));
            }
        }
        degrees
    }
}

/// `mass p_i - number (p_(i-1) - 2 p_i + p_(i+1))` factored, base first; the base has one neighbour, the top a drain.
struct Factored {
    /// Off-diagonal entry.
    beside: f64,
    /// Upper factor.
    upper: Vec<f64>,
    /// One over the pivots.
    inverse: Vec<f64>,
}

impl Factored {
    fn new(cells: usize, mass: f64, number: f64) -> Self {
        let beside = -number;
        let (mut upper, mut inverse) = (Vec::with_capacity(cells), Vec::with_capacity(cells));
        let mut before = 0.0;
        for i in 0..cells {
            // Faces: none at the base, and twice the conductance to the drain half a cell away.
            let below = if i == 0 { 0.0 } else { 1.0 };
            let above = if i + 1 == cells { 2.0 } else { 1.0 };
            let pivot = 1.0 / (mass + number * (below + above) - beside * before);
            before = beside * pivot;
            upper.push(before);
            inverse.push(pivot);
        }
        Self { beside, upper, inverse }
    }

    fn solve(&self, p: &mut [f64]) {
        let mut before = 0.0;
        for (p, inverse) in p.iter_mut().zip(&self.inverse) {
            before = (*p - self.beside * before) * inverse;
            *p = before;
        }
        let mut above = 0.0;
        for (p, upper) in p.iter_mut().zip(&self.upper).rev() {
            above = *p - upper * above;
            *p = above;
        }
    }
}

#[cfg(test)]
mod tests {
    use mpm_verify::exact::terzaghi::Terzaghi;
    use mpm_verify::norms::{largest, relative};
    use mpm_verify::rates::fit;

    use super::*;

    fn soil() -> Soil {
        Soil::of(&mpm_verify::scenes::terzaghi()).expect("a column")
    }

    /// Largest error of U against compressible water from Tv = 0.1 on, where the first jump has been forgotten.
    fn late_error(soil: &Soil, cells: usize, steps: usize) -> f64 {
        let exact = Terzaghi::compressible(&mpm_verify::scenes::terzaghi()).expect("a column");
        let found = FiniteVolumes { cells, steps }.solve(soil);
        let errors = SAMPLE_TV.iter().zip(&found).filter(|(tv, _)| **tv >= 0.1);
        largest(errors.map(|(tv, u)| relative(*u, exact.relative_settlement(tv * soil.time_per_factor))))
    }

    fn order(points: &[(f64, f64)]) -> f64 {
        fit(points).expect("errors above zero").order
    }

    fn orders(soil: &Soil) -> [f64; 2] {
        let space = [10, 20, 40, 80].map(|n| (1.0 / n as f64, late_error(soil, n, 40_000)));
        let time = [100, 200, 400, 800].map(|n| (1.0 / n as f64, late_error(soil, 3000, n)));
        [order(&space), order(&time)]
    }

    #[test]
    fn it_is_of_second_order_in_space_and_time() {
        let found = orders(&soil());
        assert!(found.iter().all(|order| (order - 2.0).abs() < 0.1), "{found:?}");
    }

    #[test]
    fn the_order_test_can_fail() {
        // A thousandth more diffusivity is an error that no refinement takes away.
        let found = orders(&Soil { diffusivity: 1.001 * soil().diffusivity, ..soil() });
        assert!(found.iter().any(|order| (order - 2.0).abs() > 0.1), "{found:?}");
    }

    #[test]
    fn a_scene_that_it_is_not_written_for_is_refused() {
        let mut scene = mpm_verify::scenes::terzaghi();
        scene.stages[0].drained[Side::Bottom as usize] = true;
        assert_eq!(Soil::of(&scene), None);
    }
}
