//! Numbers of a run at its sample times beside exact ones, one at each time or a whole field, and how far runs differ.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{FieldPoint, ProfileRow};

use super::refinement::{PARTICLES, Refinement, STEP, Sampled, TOLERANCE};
use crate::error::Error;
use crate::norms::worst;

/// How differences become one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Norm {
    /// The largest, with its sign.
    Largest,
    /// Their root mean square.
    Rms,
}

impl Norm {
    /// Of these differences; NaN if one is.
    fn of(self, differences: &[f64]) -> f64 {
        match self {
            Self::Largest => worst(differences.iter().copied()),
            Self::Rms => (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt(),
        }
    }
}

/// What a run shows at one time, in units of a size that the case chooses.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Compared {
    /// Time since the start of the stage, s.
    pub time: f64,
    /// The same as a time factor, where the case has one.
    pub factor: Option<f64>,
    /// Numbers of the run: one, or one per place.
    pub computed: Vec<f64>,
    /// What they should be.
    pub exact: Vec<f64>,
    /// Whether the time counts.
    pub counts: bool,
    /// Where the numbers are, x and y in m; empty where there is one number or where places are not told.
    pub places: Vec<[f64; 2]>,
}

impl Compared {
    /// One number at a time that counts.
    pub fn one(time: f64, computed: f64, exact: f64) -> Self {
        Self { time, factor: None, computed: vec![computed], exact: vec![exact], counts: true, places: Vec::new() }
    }
}

impl Compared {
    /// Computed and exact numbers at places.
    fn at_places(time: f64, found: impl Iterator<Item = ([f64; 2], [f64; 2])>) -> Self {
        let mut all = Self { time, factor: None, computed: vec![], exact: vec![], counts: true, places: vec![] };
        for (place, [computed, exact]) in found {
            all.places.push(place);
            all.computed.push(computed);
            all.exact.push(exact);
        }
        all
    }
}

/// The looks at a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Comparison {
    /// What is looked at, with the size it is measured in.
    pub quantity: String,
    /// Unit of the numbers; `-` if they are shares of that size.
    pub unit: &'static str,
    /// Over the places of a look.
    pub over_places: Norm,
    /// Over the times.
    pub over_times: Norm,
    /// Whether differences are shares of the exact number.
    pub relative: bool,
    /// Times, in order.
    pub rows: Vec<Compared>,
}

impl Comparison {
    /// One number at each time, of which the worst counts.
    pub fn worst(quantity: impl Into<String>, rows: Vec<Compared>) -> Self {
        Self {
            quantity: quantity.into(),
            unit: "-",
            over_places: Norm::Largest,
            over_times: Norm::Largest,
            relative: false,
            rows,
        }
    }

    /// Numbers at places of the cells at some samples; `of` gives the computed and the exact number of a cell that counts.
    pub fn field<'a>(
        quantity: impl Into<String>,
        samples: impl IntoIterator<Item = &'a Sample>,
        of: impl Fn(&FieldPoint, f64) -> Option<[f64; 2]>,
    ) -> Self {
        let at = |sample: &Sample| {
            let found = |point: &FieldPoint| Some(([point.x_m, point.y_m], of(point, sample.stage_time)?));
            Compared::at_places(sample.stage_time, sample.state.field.iter().filter_map(found))
        };
        Self::worst(quantity, samples.into_iter().map(at).collect())
    }

    /// The same over the height of a column, at the places that its soil had at first.
    pub fn profile<'a>(
        quantity: impl Into<String>,
        samples: impl IntoIterator<Item = &'a Sample>,
        of: impl Fn(f64, &ProfileRow, f64) -> [f64; 2],
    ) -> Self {
        let at = |sample: &Sample| {
            let found =
                |row: &ProfileRow| ([0.0, row.material_height_m], of(row.material_height_m, row, sample.stage_time));
            Compared::at_places(sample.stage_time, sample.state.profile.iter().map(found))
        };
        Self::worst(quantity, samples.into_iter().map(at).collect())
    }

    /// One number at the end.
    pub fn single(quantity: impl Into<String>, run: &Run, computed: f64, exact: f64) -> Self {
        let end = run.samples.last().map_or(f64::NAN, |sample| sample.stage_time);
        Self::worst(quantity, vec![Compared::one(end, computed, exact)])
    }

    /// How far a look is off.
    fn off(&self, look: &Compared) -> f64 {
        self.apart(&look.computed, &look.exact)
    }

    fn apart(&self, these: &[f64], those: &[f64]) -> f64 {
        // Numbers that are missing must not pass for equal ones.
        if these.len() != those.len() || these.is_empty() {
            return f64::NAN;
        }
        let size = |exact: f64| if self.relative { exact } else { 1.0 };
        let differences: Vec<f64> = these.iter().zip(those).map(|(a, b)| (a - b) / size(*b)).collect();
        self.over_places.of(&differences)
    }

    /// The error over the times that count.
    pub fn error(&self) -> f64 {
        let off: Vec<f64> = self.rows.iter().filter(|look| look.counts).map(|look| self.off(look)).collect();
        if off.is_empty() { f64::NAN } else { self.over_times.of(&off) }
    }

    /// The difference to another run with the same times and places, as the error is counted.
    pub fn difference(&self, other: &Self) -> f64 {
        if self.rows.len() != other.rows.len() {
            return f64::NAN;
        }
        let both = self.rows.iter().zip(&other.rows).filter(|(look, _)| look.counts);
        let apart: Vec<f64> = both.map(|(look, other)| self.apart(&look.computed, &other.computed)).collect();
        self.over_times.of(&apart)
    }

    /// Every time: the number itself, or of a field the place that is furthest off and the error of all.
    pub fn samples(&self) -> Vec<Sampled> {
        let sampled = |look: &Compared| {
            let far = |i: &usize| (look.computed[*i] - look.exact[*i]).abs();
            let place = (0..look.computed.len()).max_by(|a, b| far(a).total_cmp(&far(b)));
            let of = |values: &[f64]| place.map_or(f64::NAN, |place| values[place]);
            let where_it_is = if look.computed.len() > 1 { ", where it is furthest off" } else { "" };
            Sampled {
                quantity: format!("{}{where_it_is}", self.quantity),
                unit: self.unit.to_owned(),
                time: look.time,
                factor: look.factor,
                computed: of(&look.computed),
                exact: of(&look.exact),
                error: self.off(look),
                counts: look.counts,
            }
        };
        self.rows.iter().map(sampled).collect()
    }
}

/// Runs in steps `first`, `first`/2, ... (s) on cells of edge `cell` (m): the difference of each to that with half its
/// step, so that the error of the mesh, which both have, drops out and a power of the step shows as it is.
pub(crate) fn in_time(
    run: impl Fn(f64) -> Result<Comparison, Error>,
    cell: f64,
    first: f64,
    count: u32,
    required_order: Option<f64>,
) -> Result<Refinement, Error> {
    let stepped = |halvings| {
        let step = first / 2.0_f64.powi(halvings);
        Ok::<_, Error>((step, run(step)?))
    };
    let runs = (0..=count as i32).map(stepped).collect::<Result<Vec<_>, _>>()?;
    let errors = runs.windows(2).map(|pair| (pair[0].0, pair[0].1.difference(&pair[1].1))).collect();
    let against = format!("the same run at half the step, L = {cell} m: the error of the mesh drops out");
    Ok(Refinement { required_order, ..Refinement::new(STEP, errors, against) })
}

/// Runs with several numbers of particles per cell, on cells of edge `cell` (m), against the exact solution. The mesh
/// leaves an error that no particles take away, so that no order is expected; `most` bounds every error.
pub(crate) fn in_particles(
    run: impl Fn(usize) -> Result<Comparison, Error>,
    cell: f64,
    counts: &[usize],
    most: f64,
) -> Result<Refinement, Error> {
    let errors = counts.iter().map(|count| Ok((*count as f64, run(*count)?.error()))).collect::<Result<_, Error>>()?;
    let against = format!("the exact solution, L = {cell} m: the error of the mesh stays, no order is expected");
    Ok(Refinement { required_error: Some(most), ..Refinement::new(PARTICLES, errors, against) })
}

/// Runs under tolerances that fall, on cells of edge `cell` (m): the difference of each to one under a hundredth of the smallest. A
/// tolerance is a bound, so that no order is expected: no difference may exceed `times` its own tolerance.
pub(crate) fn in_tolerance(
    run: impl Fn(f64) -> Result<Comparison, Error>,
    cell: f64,
    tolerances: &[f64],
    times: f64,
) -> Result<Refinement, Error> {
    let least = tolerances.iter().copied().fold(f64::INFINITY, f64::min);
    let finest = run((0.01 * least).max(1e-10))?;
    let error = |tolerance: &f64| Ok((*tolerance, run(*tolerance)?.difference(&finest)));
    let errors = tolerances.iter().map(error).collect::<Result<_, Error>>()?;
    let against = format!("the same run under a hundredth of the smallest tolerance, L = {cell} m");
    Ok(Refinement { required_share: Some(times), ..Refinement::new(TOLERANCE, errors, against) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(times: [f64; 2], computed: [[f64; 2]; 2]) -> Comparison {
        let look = |i: usize| Compared {
            time: times[i],
            factor: None,
            computed: computed[i].to_vec(),
            exact: vec![1.0, 1.0],
            counts: true,
            places: Vec::new(),
        };
        Comparison { over_places: Norm::Rms, ..Comparison::worst("p", vec![look(0), look(1)]) }
    }

    #[test]
    fn errors_and_differences_are_those_of_the_norms() {
        let looks = field([1.0, 2.0], [[1.3, 0.6], [1.0, 1.1]]);
        assert!((looks.error() - (0.125_f64).sqrt()).abs() < 1e-15);
        let mean = Comparison { over_times: Norm::Rms, ..looks.clone() };
        assert!((mean.error() - (0.065_f64).sqrt()).abs() < 1e-15);
        let signed = Comparison { over_places: Norm::Largest, ..looks.clone() };
        assert!((signed.error() + 0.4).abs() < 1e-15);
        assert_eq!(looks.difference(&looks), 0.0);
        let samples = looks.samples();
        assert_eq!((samples[0].computed, samples[0].exact, samples[1].computed), (0.6, 1.0, 1.1));
        assert!(samples[0].quantity.ends_with("furthest off") && samples[0].error == looks.error());
        let early = Compared { counts: false, ..looks.rows[0].clone() };
        let late = Comparison { rows: vec![early, looks.rows[1].clone()], ..looks };
        assert!((late.error() - (0.005_f64).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn what_is_missing_is_no_agreement() {
        let looks = Comparison::worst("p", vec![Compared::one(1.0, 1.0, 1.0)]);
        assert!(looks.difference(&Comparison { rows: Vec::new(), ..looks.clone() }).is_nan());
        assert!(Comparison { rows: Vec::new(), ..looks.clone() }.error().is_nan());
        let short = Compared { computed: Vec::new(), ..looks.rows[0].clone() };
        assert!(Comparison { rows: vec![short], ..looks.clone() }.error().is_nan());
        let lost = Comparison { rows: vec![Compared::one(1.0, f64::NAN, 1.0)], ..looks };
        assert!(lost.error().is_nan() && lost.samples()[0].error.is_nan());
    }

    #[test]
    fn an_order_in_the_step_is_found_whatever_the_mesh_leaves() {
        let run = |dt: f64| Ok(Comparison::worst("u", vec![Compared::one(1.0, 1.3 + 5.0 * dt, 1.0)]));
        let refined = in_time(run, 0.1, 0.01, 4, Some(1.0)).expect("runs");
        assert_eq!((refined.failed(), refined.errors.len()), (None, 4));
        let refined = in_time(run, 0.1, 0.01, 4, Some(2.0)).expect("runs");
        assert!(refined.failed().is_some());
        let with = |count: usize| Ok(Comparison::worst("u", vec![Compared::one(1.0, 1.0 + 0.1 / count as f64, 1.0)]));
        assert!(in_particles(with, 0.1, &[1, 4], 0.11).expect("runs").failed().is_none());
        assert!(in_particles(with, 0.1, &[1, 4], 0.09).expect("runs").failed().is_some());
    }
}
