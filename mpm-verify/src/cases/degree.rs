//! The degree of consolidation U = S/(q H/M) at every sample time, beside an exact one, and its refinements.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Scene, StepChoice};

use super::finished;
use crate::error::Error;
use crate::experiment::refinement::{PARTICLES, Refinement, STEP, Sampled, TOLERANCE};
use crate::norms::worst;

/// A settlement that is compared, and how its error is counted.
pub(super) struct Degree<'a> {
    /// Exact settlement at a time (s), m.
    exact: &'a dyn Fn(f64) -> f64,
    /// q H/M or what else the settlement ends at, m.
    whole: f64,
    /// Seconds per unit of the time factor.
    per_factor: Option<f64>,
    /// Times before this one do not count, s.
    from: f64,
    /// Whether the error is relative to the exact U, or U's own difference.
    relative: bool,
}

impl<'a> Degree<'a> {
    /// The error relative to U, at all times, of a scene that is not spoilt.
    pub fn relative(scene: &Scene, exact: &'a dyn Fn(f64) -> f64) -> Self {
        let load = scene.surcharge.map_or(f64::NAN, |s| s.pressure);
        Self::of_whole(scene, load * scene.height / scene.oedometer_modulus(), exact)
    }

    /// The same for a scene whose final settlement is `whole` (m).
    pub fn of_whole(scene: &Scene, whole: f64, exact: &'a dyn Fn(f64) -> f64) -> Self {
        Self { exact, whole, per_factor: scene.time_per_factor(), from: 0.0, relative: true }
    }

    /// Only from a time on, s.
    pub fn from(self, time: f64) -> Self {
        Self { from: 0.999 * time, ..self }
    }

    /// The signed error of a settlement (m) at a time (s) against another.
    fn off(&self, settlement: f64, against: f64) -> f64 {
        (settlement - against) / if self.relative { against } else { self.whole }
    }

    fn counts(&self, sample: &Sample) -> bool {
        sample.stage_time >= self.from
    }

    /// The largest error of a run over its sample times, signed.
    pub fn error(&self, run: &Run) -> f64 {
        let off = |s: &Sample| self.off(s.state.settlement, (self.exact)(s.stage_time));
        worst(run.observed().filter(|s| self.counts(s)).map(off))
    }

    /// The largest difference between two runs of the same times, signed, counted as the error is.
    fn difference(&self, run: &Run, finer: &Run) -> f64 {
        let both = run.observed().zip(finer.observed()).filter(|(s, _)| self.counts(s));
        worst(both.map(|(s, other)| self.off(s.state.settlement, other.state.settlement)))
    }

    /// Every sample time of a run.
    pub fn samples(&self, run: &Run) -> Vec<Sampled> {
        let sampled = |s: &Sample| {
            let exact = (self.exact)(s.stage_time);
            Sampled {
                quantity: if self.relative { "U".to_owned() } else { "U, error of U itself".to_owned() },
                unit: "-".to_owned(),
                time: s.stage_time,
                factor: self.per_factor.map(|one| s.stage_time / one),
                computed: s.state.settlement / self.whole,
                exact: exact / self.whole,
                error: self.off(s.state.settlement, exact),
                counts: self.counts(s),
            }
        };
        run.observed().map(sampled).collect()
    }

    /// Errors of scenes on finer and finer meshes, and the samples of the last one.
    pub fn on_meshes(&self, scenes: impl Iterator<Item = Scene>) -> Result<(Errors, Vec<Sampled>), Error> {
        let (mut errors, mut samples) = (Vec::new(), Vec::new());
        for scene in scenes {
            let run = finished(&scene)?;
            errors.push((scene.cell, self.error(&run)));
            samples = self.samples(&run);
        }
        Ok((errors, samples))
    }

    /// Errors of a scene with several numbers of rows, and the samples of the last one.
    pub fn refine(&self, base: &Scene, rows: &[usize]) -> Result<(Errors, Vec<Sampled>), Error> {
        let scenes = rows.iter().map(|rows| base.with_rows(*rows)).collect::<Result<Vec<_>, _>>()?;
        self.on_meshes(scenes.into_iter())
    }

    /// A scene in steps `first`, `first`/2, ... (s): the difference of each run to that with half its step, so that the
    /// error of the mesh, which both have, drops out and a power of the step shows as it is.
    pub fn in_time(
        &self,
        base: &Scene,
        first: f64,
        count: u32,
        required_order: Option<[f64; 2]>,
    ) -> Result<Refinement, Error> {
        let stepped = |halvings| {
            let step = first / 2.0_f64.powi(halvings);
            let run = finished(&base.edited(|s| s.step = StepChoice::Fixed(step))?)?;
            Ok::<_, Error>((step, run))
        };
        let runs = (0..=count as i32).map(stepped).collect::<Result<Vec<_>, _>>()?;
        let errors = runs.windows(2).map(|pair| (pair[0].0, self.difference(&pair[0].1, &pair[1].1))).collect();
        let against = format!("the same run at half the step, L = {} m: the error of the mesh drops out", base.cell);
        Ok(Refinement { required_order, ..Refinement::new(STEP, errors, against) })
    }

    /// A scene under tolerances that fall: the difference of each run to one under a hundredth of the smallest. A
    /// tolerance is a bound, so that no order is expected: no error may exceed `times` its own tolerance.
    pub fn in_tolerance(&self, base: &Scene, tolerances: &[f64], times: f64) -> Result<Refinement, Error> {
        let at = |tolerance| finished(&base.edited(|s| s.tolerance = tolerance)?);
        let least = tolerances.iter().copied().fold(f64::INFINITY, f64::min);
        let finest = at((0.01 * least).max(1e-10))?;
        let error = |tolerance: &f64| Ok((*tolerance, self.difference(&at(*tolerance)?, &finest)));
        let errors: Errors = tolerances.iter().map(error).collect::<Result<_, Error>>()?;
        let against = format!("the same run under a hundredth of the smallest tolerance, L = {} m", base.cell);
        Ok(Refinement { required_share: Some(times), ..Refinement::new(TOLERANCE, errors, against) })
    }

    /// A scene with several numbers of particles per cell on its own mesh, against the exact solution. The mesh leaves an
    /// error that no particles take away, so that no order is expected; `most` bounds every error.
    pub fn in_particles(&self, base: &Scene, counts: &[usize], most: f64) -> Result<Refinement, Error> {
        let with = |count: &usize| {
            let run = finished(&base.edited(|s| s.particles_per_cell = *count)?)?;
            Ok((*count as f64, self.error(&run)))
        };
        let errors = counts.iter().map(with).collect::<Result<_, Error>>()?;
        let against =
            format!("the exact solution, L = {} m: the error of the mesh stays, no order is expected", base.cell);
        Ok(Refinement { required_error: Some(most), ..Refinement::new(PARTICLES, errors, against) })
    }
}

/// (refinement parameter, signed error).
pub(super) type Errors = Vec<(f64, f64)>;
