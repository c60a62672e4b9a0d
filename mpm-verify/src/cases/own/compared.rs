//! A run beside the exact solution of its scene: curves, numbers in engineering units, errors.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Scene, Side};
use serde::{Deserialize, Serialize};

use super::applies::Solution;
use crate::error::Error::{self, Lacks};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::measure::{free_surface, mandel, sliding};
use crate::report::numbers::short;

/// A number of a run beside the exact one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Beside {
    /// Name of the quantity.
    pub quantity: String,
    /// Unit of both.
    pub unit: String,
    /// The number of the run.
    pub computed: f64,
    /// The exact one.
    pub exact: f64,
}

impl Beside {
    /// Difference as a share of the exact number.
    pub fn error(&self) -> f64 {
        self.computed / self.exact - 1.0
    }
}

/// The largest error of a quantity over the observed times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Largest {
    /// The quantity, with what it is measured in.
    pub quantity: String,
    /// Unit of the error; `-` if it is a share.
    pub unit: String,
    /// The error.
    pub error: f64,
}

/// An error as a share, in percent for readers.
pub fn share(error: f64) -> String {
    if error.abs() < 1e-5 { "below 0.001 %".to_owned() } else { format!("{} %", short(100.0 * error, 2)) }
}

/// A run beside the exact solution of its scene, as `summary.json` has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Author of the solution.
    pub name: String,
    /// The solution with its assumptions.
    pub solution: String,
    /// Effects that the scene has and the solution neglects.
    pub beside: Vec<String>,
    /// Numbers at the end.
    pub numbers: Vec<Beside>,
    /// Largest errors over the observed times.
    pub largest: Vec<Largest>,
}

impl Found {
    /// A run of a scene beside a solution; `None` where the run has nothing to compare.
    pub fn of(solution: &Solution, scene: &Scene, run: &Run) -> Option<Self> {
        let numbers = solution.numbers(scene, run);
        let compared = solution.compared(scene, run).unwrap_or_default();
        let largest = compared.iter().map(|c| Largest {
            quantity: c.quantity.clone(),
            unit: c.unit.to_owned(),
            error: c.error(),
        });
        let largest: Vec<Largest> = largest.filter(|largest| largest.error.is_finite()).collect();
        (!numbers.is_empty() || !largest.is_empty()).then(|| Self {
            name: solution.name().to_owned(),
            solution: solution.words(),
            beside: solution.beside(scene),
            numbers,
            largest,
        })
    }

    /// The first number and its error in words: `limit load 50.1 kPa, exact 51.4 kPa (Prandtl): error -2.5 %`.
    pub fn headline(&self) -> String {
        match (self.numbers.first(), self.largest.first()) {
            (Some(number), _) => {
                let Beside { quantity, unit, computed, exact } = number;
                let unit = if unit == "–" { String::new() } else { format!(" {unit}") };
                let [computed, exact] = [computed, exact].map(|value| short(*value, 3));
                let error = share(number.error());
                format!("{quantity} {computed}{unit}, exact {exact}{unit} ({}): error {error}", self.name)
            }
            (None, Some(Largest { quantity, unit, error })) if unit == "-" => {
                format!("{quantity}: largest error {}", share(*error))
            }
            (None, Some(Largest { quantity, unit, error })) => {
                format!("{quantity}: largest error {} {unit}", short(*error, 2))
            }
            (None, None) => String::new(),
        }
    }
}

/// Force of the soil on all plates that are moved, N per metre: the current one, or the mean since the sample before.
pub fn plates(now: &Sample, before: Option<&Sample>) -> Option<[f64; 2]> {
    let mut sum = [0.0; 2];
    for (i, push) in now.state.plates.iter().enumerate() {
        let then = before.map_or([0.0; 2], |before| before.state.plates[i].impulse);
        let time = now.state.time - before.map_or(0.0, |before| before.state.time);
        let mean = [0, 1].map(|d| if time > 0.0 { (push.impulse[d] - then[d]) / time } else { 0.0 });
        let force = push.force.unwrap_or(mean);
        (0..2).for_each(|d| sum[d] += force[d]);
    }
    (!now.state.plates.is_empty()).then_some(sum)
}

impl Solution {
    /// Name of the solution, for a legend.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Wet(_) | Self::Dry(_) | Self::Suite(..) => "exact",
            Self::Block(_) => "Mandel",
            Self::Front(_) => "Green and Ampt",
            Self::Dam(_) => "Charny",
            Self::Mound(_) => "Boussinesq",
            Self::Sliding(_) => "rigid block",
            Self::Slope(..) => "infinite slope",
            Self::Series(_) => "Terzaghi",
            Self::Ramps(..) => "Terzaghi, superposed",
            Self::Layers(_) => "eigenfunctions of the layers",
            Self::Footing(_) => "Prandtl",
            Self::Wall(_) => "Rankine",
        }
    }

    /// Settlement at a time (s) since the start of the last stage, m; `None` where the solution has none. Of a column with weight or large
    /// strain it is known at the observed times alone, and not a number at others.
    pub fn settlement(&self, scene: &Scene, time: f64) -> Option<f64> {
        match self {
            Self::Wet(column) => Some(column.settlement(time)),
            Self::Dry(column) => Some(column.settlement(scene, time)),
            Self::Block(exact) => Some(exact.settlement(time)),
            Self::Series(exact) => Some(exact.settlement(time)),
            Self::Ramps(exact, factors) => Some(exact.under(factors, time)),
            Self::Layers(exact) => Some(exact.settlement(time)),
            _ => None,
        }
    }

    /// Settlement after all excess pressure has gone, m, under a load that stays.
    pub fn final_settlement(&self, scene: &Scene) -> Option<f64> {
        let stays = matches!(self, Self::Block(_) | Self::Series(_) | Self::Layers(_));
        self.settlement(scene, 1e30).filter(|whole| stays && *whole > 0.0)
    }

    /// Pore pressure at a height (m) and a time (s) since the start of the last stage, Pa; `None` where the solution has none.
    pub fn pressure(&self, height: f64, time: f64) -> Option<f64> {
        match self {
            Self::Wet(column) => Some(column.pressure(height, time)),
            Self::Series(exact) => Some(exact.pressure(height, time)),
            Self::Layers(exact) => Some(exact.pressure(height, time)),
            _ => None,
        }
    }

    /// Steady discharge, m3/s per metre.
    pub fn discharge(&self, scene: &Scene) -> Option<f64> {
        let Self::Dam(dam) = self else { return None };
        scene.water.map(|water| dam.discharge(water.hydraulic_conductivity))
    }

    /// Place of a wetting front or of the tip of the water at a time (s), m.
    pub fn front(&self, time: f64) -> Option<f64> {
        match self {
            Self::Front(front) => Some(front.position(time)),
            Self::Mound(exact) => Some(exact.front(time)),
            _ => None,
        }
    }

    /// Place of the front or the tip in a run, m.
    pub fn front_of(&self, scene: &Scene, sample: &Sample) -> Option<f64> {
        let water = sample.state.water.as_ref()?;
        match self {
            Self::Front(front) => Some(free_surface::place_of(scene, water, front)),
            Self::Mound(_) => Some(water.front_x_m),
            _ => None,
        }
    }

    /// Mean pressure on a footing (Pa) or thrust on a wall (N per metre) at the limit.
    pub fn limit(&self) -> Option<f64> {
        match self {
            Self::Footing(exact) => Some(exact.load),
            Self::Wall(exact) => Some(exact.thrust),
            _ => None,
        }
    }

    /// Mean pressure (Pa) or thrust (N per metre) at a sample of a run; `before` is the sample before it.
    pub fn limit_of(&self, scene: &Scene, now: &Sample, before: Option<&Sample>) -> Option<f64> {
        match (self, scene.surcharge) {
            (Self::Footing(_), Some(load)) => Some(load.at(now.state.time)),
            (Self::Footing(exact), None) => plates(now, before).map(|[_, y]| -y / exact.half_width),
            (Self::Wall(exact), _) => plates(now, before).map(|[x, _]| if exact.side == Side::Left { x } else { -x }),
            _ => None,
        }
    }

    /// Numbers of a run at its end beside the exact ones.
    pub fn numbers(&self, scene: &Scene, run: &Run) -> Vec<Beside> {
        let Some((last, before)) = run.samples.split_last() else { return Vec::new() };
        let time = last.stage_time;
        let number = |quantity: &str, unit: &str, computed: Option<f64>, exact: Option<f64>, scale: f64| {
            let (computed, exact) = (computed? * scale, exact? * scale);
            let (quantity, unit) = (quantity.to_owned(), unit.to_owned());
            (computed.is_finite() && exact.is_finite() && exact != 0.0).then_some(Beside {
                quantity,
                unit,
                computed,
                exact,
            })
        };
        let water = last.state.water.as_ref();
        let settlement = Some(last.state.settlement);
        let limit = if matches!(self, Self::Wall(_)) { ("thrust on the wall", "kN/m") } else { ("limit load", "kPa") };
        let degree = self.final_settlement(scene);
        [
            number(limit.0, limit.1, self.limit_of(scene, last, before.last()), self.limit(), 1e-3),
            number("settlement", "mm", settlement, self.settlement(scene, time), 1e3),
            degree.and_then(|whole| {
                number("degree of consolidation", "–", settlement, self.settlement(scene, time), 1.0 / whole)
            }),
            number("discharge", "m³/day per m", water.map(|w| w.outflow_m3_s), self.discharge(scene), 86400.0),
            number("front", "m", self.front_of(scene, last), self.front(time), 1.0),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// A run beside the solution at the observed times.
    ///
    /// # Errors
    /// Reason why the run cannot be compared.
    pub(crate) fn compared(&self, scene: &Scene, run: &Run) -> Result<Vec<Comparison>, Error> {
        let last = || run.samples.last().ok_or(Lacks("sample"));
        Ok(match self {
            Self::Wet(column) => column.looks(scene, run),
            Self::Dry(column) => column.looks(scene, run),
            Self::Block(exact) => vec![mandel::from_factor(mandel::looks(run, exact, 0.0), mandel::TIME_FACTOR)],
            Self::Front(front) => vec![relative(free_surface::front_of(scene, run, front))],
            Self::Mound(exact) => {
                let mut tips = relative(free_surface::tip_of(scene, run, exact)?);
                let far =
                    |time: f64| exact.front(time) >= 4.0 * exact.height(0.0, time) && exact.front(time) < scene.width;
                tips.rows.iter_mut().for_each(|look| look.counts = far(look.time));
                vec![tips]
            }
            Self::Sliding(exact) => vec![sliding::way_of(run, exact)?],
            Self::Dam(dam) => {
                let state = last()?.state.water.ok_or(Lacks("free surface"))?;
                let time = last()?.stage_time;
                let discharge = self.discharge(scene).unwrap_or(f64::NAN);
                let one = |what: &str, found: f64, exact: f64| {
                    Comparison::worst(what, vec![Compared::one(time, found / exact, 1.0)])
                };
                vec![
                    one("outflow over the discharge of the steady flow", state.outflow_m3_s, discharge),
                    one("inflow over the discharge of the steady flow", state.inflow_m3_s, discharge),
                    one("water over that below the free surface", state.mobile_m3, dam.stored(scene.mobile_porosity())),
                ]
            }
            Self::Suite(spec, _) => {
                let measure = spec.measure.as_ref().ok_or(Lacks("measure"))?;
                vec![measure.of_scene(scene)?(run)?]
            }
            Self::Series(_) | Self::Ramps(..) | Self::Layers(_) => vec![self.settlements(scene, run)],
            Self::Slope(..) | Self::Footing(_) | Self::Wall(_) => Vec::new(),
        })
    }

    /// Errors of the settlement at the observed times of the last stage, with time factors where the scene is one column of one soil: shares
    /// of the exact settlement under a load that stays, else of the largest. Empty where the solution has no settlement.
    pub fn settlement_errors(&self, scene: &Scene, run: &Run) -> Vec<(Option<f64>, f64)> {
        let rows = self.settlement(scene, 0.0).map(|_| self.settlements(scene, run).rows).unwrap_or_default();
        let error = |row: &Compared| (row.factor, (row.computed[0] - row.exact[0]).abs());
        rows.iter().map(error).filter(|(_, error)| error.is_finite()).collect()
    }

    /// Settlements at the observed times of the last stage: relative to the exact one under a load that stays, else to the largest.
    fn settlements(&self, scene: &Scene, run: &Run) -> Comparison {
        let stage = run.samples.last().map_or(0, |s| s.stage);
        let samples = run.observed().filter(|s| s.stage == stage && s.stage_time > 0.0);
        let pairs = samples.map(|s| (s, self.settlement(scene, s.stage_time).unwrap_or(f64::NAN)));
        let pairs: Vec<(&Sample, f64)> = pairs.collect();
        let largest = pairs.iter().map(|(_, exact)| exact.abs()).fold(0.0, f64::max);
        let stays = self.final_settlement(scene).is_some();
        let one = scene.time_per_factor().filter(|_| scene.is_one_dimensional() && scene.layers.is_empty());
        let row = |(s, exact): &(&Sample, f64)| {
            let size = if stays { exact.abs() } else { largest };
            let row = Compared::one(s.stage_time, s.state.settlement / size, exact / size);
            Compared { factor: one.map(|one| s.stage_time / one), ..row }
        };
        let of = if stays { "settlement over the exact one" } else { "settlement over the largest exact one" };
        Comparison::worst(of, pairs.iter().map(row).collect())
    }
}

/// Numbers as shares of the exact ones.
fn relative(mut compared: Comparison) -> Comparison {
    for row in &mut compared.rows {
        row.computed
            .iter_mut()
            .zip(&mut row.exact)
            .for_each(|(found, exact)| (*found, *exact) = (*found / *exact, 1.0));
    }
    Comparison { quantity: format!("{} over the exact one", compared.quantity), unit: "-", ..compared }
}
