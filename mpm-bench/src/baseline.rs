//! The baseline: consolidation by finite volumes, as one would write it in an hour.
//!
//! `(1/M + n/K_w) dp/dt = (k/gamma_w) d2p/dz2` with the pressure at the middle of each cell, p = 0 at the top half a cell
//! away, no flow at the base, from the undrained pressure. Second order in space. In time BDF2, started by one step of
//! implicit Euler, whose error of order dt^2 is made once. Tridiagonal matrices, each factored once (Thomas).
//! `U = mean(q - p)/q`, counted from the unloaded state.
//!
//! Two of them, so that nothing is compared with a straw man: the plain one has equal cells and a constant step; the
//! graded one has cells that grow with the depth and a constant number of steps from one sample time to the next, which
//! is what one does after having seen that all the error of the plain one is made near the surface in the first steps.

use mpm_core::scene::{Integrator, Scene, Side};
use mpm_verify::norms::SAMPLE_TV;
use mpm_verify::study::{INTEGRATORS, word};

use crate::row::MOVING;

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
    /// The soil of a scene; `None` for one that is dry, unloaded, in layers, not one-dimensional or not drained at the top alone.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let drained = scene.stages.last()?.drained;
        let top_alone = Side::ALL.iter().all(|side| drained[*side as usize] == (*side == Side::Top));
        let uniform = scene.is_one_dimensional() && scene.layers.is_empty();
        if !(uniform && top_alone && load.ramp_time == 0.0) {
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

/// A run of the baseline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiniteVolumes {
    /// How cells and steps are laid.
    pub kind: Kind,
    /// Cells over the height.
    pub cells: usize,
    /// Steps up to Tv = 1: a multiple of [`Kind::unit`].
    pub steps: usize,
}

/// How cells and steps are laid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Equal cells, a constant step.
    Plain,
    /// Faces at depths H (i/N)^2, as many steps to each sample time.
    Graded,
}

impl Kind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Plain, Self::Graded];

    /// Its name where shape functions stand.
    pub fn scheme(self) -> &'static str {
        match self {
            Self::Plain => "finite-volume",
            Self::Graded => "finite-volume-graded",
        }
    }

    /// Its name in sentences.
    pub fn word(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Graded => "graded",
        }
    }

    /// What the number of steps is a multiple of, so that every sample time ends one.
    pub fn unit(self) -> usize {
        match self {
            // The sample times are multiples of 0.01.
            Self::Plain => 100,
            Self::Graded => SAMPLE_TV.len(),
        }
    }
}

/// How the baseline is called where integrators stand.
pub const NAME: &str = "baseline";

/// Whether a name where integrators stand is that of the baseline.
pub fn is(integrator: &str) -> bool {
    integrator == NAME
}

/// Names of all integrators, those whose mesh moves after the others, and the baseline last.
pub fn with_integrators() -> Vec<String> {
    let moving = [Integrator::QuasiStatic, Integrator::Implicit].map(|own| format!("{}{MOVING}", word(own)));
    INTEGRATORS.iter().map(word).chain(moving).chain([NAME.to_owned()]).collect()
}

impl FiniteVolumes {
    /// Length of a step, s; the average one where they differ.
    pub fn step(&self, soil: &Soil) -> f64 {
        soil.time_per_factor / self.steps as f64
    }

    /// Heights of the cells, base first, m.
    fn widths(&self, soil: &Soil) -> Vec<f64> {
        let depth = |i: usize| {
            let share = i as f64 / self.cells as f64;
            soil.height * if self.kind == Kind::Graded { share * share } else { share }
        };
        (0..self.cells).rev().map(|i| depth(i + 1) - depth(i)).collect()
    }

    /// U at the sample times.
    pub fn solve(&self, soil: &Soil) -> Vec<f64> {
        let cells = Cells::new(&self.widths(soil), soil.diffusivity);
        let mut now = vec![soil.undrained; self.cells];
        // Nothing is known before the start: a first step of implicit Euler.
        let (mut old, mut old_step, mut time) = (Vec::new(), f64::NAN, 0.0);
        let mut degrees = Vec::with_capacity(SAMPLE_TV.len());
        for tv in SAMPLE_TV {
            let span = tv * soil.time_per_factor - time;
            let count = match self.kind {
                Kind::Plain => (self.steps as f64 * span / soil.time_per_factor).round() as usize,
                Kind::Graded => self.steps / SAMPLE_TV.len(),
            };
            let step = span / count as f64;
            let mut constant = None;
            for _ in 0..count {
                if old.is_empty() {
                    old.clone_from(&now);
                    cells.factored(1.0, step).solve(&mut now, &cells.widths);
                } else {
                    let ratio = step / old_step;
                    let changed = (ratio - 1.0).abs() > 1e-9;
                    let (lead, last, before) = bdf2(ratio);
                    old.iter_mut().zip(&now).for_each(|(old, now)| *old = last * now - before * *old);
                    if changed {
                        cells.factored(lead, step).solve(&mut old, &cells.widths);
                    } else {
                        let factored = constant.get_or_insert_with(|| cells.factored(lead, step));
                        factored.solve(&mut old, &cells.widths);
                    }
                    std::mem::swap(&mut old, &mut now);
                }
                old_step = step;
            }
            time = tv * soil.time_per_factor;
            let mean = now.iter().zip(&cells.widths).map(|(p, w)| p * w).sum::<f64>() / soil.height;
            degrees.push(1.0 - mean / soil.load);
        }
        degrees
    }
}
/// `(lead p_new - last p + before p_old)/dt`, second order for a step that is `ratio` times the one before.
fn bdf2(ratio: f64) -> (f64, f64, f64) {
    ((1.0 + 2.0 * ratio) / (1.0 + ratio), 1.0 + ratio, ratio * ratio / (1.0 + ratio))
}

/// Cells with the conductances between them.
struct Cells {
    /// Heights, base first, m.
    widths: Vec<f64>,
    /// c over the distance to the middle of the next cell above, the last one to the drain, m/s.
    above: Vec<f64>,
}

impl Cells {
    fn new(widths: &[f64], diffusivity: f64) -> Self {
        let distance = |i: usize| 0.5 * (widths[i] + widths.get(i + 1).copied().unwrap_or(0.0));
        Self { widths: widths.to_vec(), above: (0..widths.len()).map(|i| diffusivity / distance(i)).collect() }
    }

    /// `lead w_i p_i - dt (flow from both neighbours)` factored.
    fn factored(&self, lead: f64, step: f64) -> Factored {
        let count = self.widths.len();
        let (mut lower, mut upper, mut inverse) =
            (Vec::with_capacity(count), Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut below, mut before) = (0.0, 0.0);
        for (width, above) in self.widths.iter().zip(&self.above) {
            let above = step * above;
            let pivot = 1.0 / (lead * width + below + above - below * before);
            before = above * pivot;
            lower.push(below);
            upper.push(before);
            inverse.push(pivot);
            below = above;
        }
        Factored { lower, upper, inverse }
    }
}

/// A factored tridiagonal matrix; what is off its diagonal is negative and stored without the sign.
struct Factored {
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// One over the pivots.
    inverse: Vec<f64>,
}

impl Factored {
    /// Solves for `p` with the right side `w_i p_i`.
    fn solve(&self, p: &mut [f64], widths: &[f64]) {
        let mut below = 0.0;
        for (((p, width), lower), inverse) in p.iter_mut().zip(widths).zip(&self.lower).zip(&self.inverse) {
            below = (*p * width + lower * below) * inverse;
            *p = below;
        }
        let mut above = 0.0;
        for (p, upper) in p.iter_mut().zip(&self.upper).rev() {
            above = *p + upper * above;
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
    fn late_error(soil: &Soil, kind: Kind, cells: usize, steps: usize) -> f64 {
        let exact = Terzaghi::compressible(&mpm_verify::scenes::terzaghi()).expect("a column");
        let found = FiniteVolumes { kind, cells, steps }.solve(soil);
        let errors = SAMPLE_TV.iter().zip(&found).filter(|(tv, _)| **tv >= 0.1);
        largest(errors.map(|(tv, u)| relative(*u, exact.relative_settlement(tv * soil.time_per_factor))))
    }

    fn order(points: &[(f64, f64)]) -> f64 {
        fit(points).expect("errors above zero").order
    }

    /// Orders in space and time.
    fn orders(soil: &Soil, kind: Kind) -> [f64; 2] {
        let space = [10, 20, 40, 80].map(|n| (1.0 / n as f64, late_error(soil, kind, n, 200 * kind.unit())));
        let time = [1, 2, 4].map(|n| (1.0 / n as f64, late_error(soil, kind, 3000, 8 * n * kind.unit())));
        [order(&space), order(&time)]
    }

    #[test]
    fn both_are_of_second_order_in_space_and_time() {
        for kind in Kind::ALL {
            let found = orders(&soil(), kind);
            assert!(found.iter().all(|order| (order - 2.0).abs() < 0.2), "{kind:?}: {found:?}");
        }
    }

    #[test]
    fn the_order_test_can_fail() {
        // A hundredth more diffusivity is an error that no refinement takes away.
        for kind in Kind::ALL {
            let found = orders(&Soil { diffusivity: 1.01 * soil().diffusivity, ..soil() }, kind);
            assert!(found.iter().any(|order| (order - 2.0).abs() > 0.2), "{kind:?}: {found:?}");
        }
    }

    #[test]
    fn a_scene_that_it_is_not_written_for_is_refused() {
        let scene = mpm_verify::scenes::terzaghi();
        let scene = scene.edited(|scene| scene.stages[0].drained[Side::Bottom as usize] = true).expect("a sound scene");
        assert_eq!(Soil::of(&scene), None);
    }
}
