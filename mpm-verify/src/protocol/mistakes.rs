//! Known mistakes: a result that agrees with the exact solution of a mistake much better than with that of the problem has made it.
//!
//! Each mistake is a change of the problem, whose exact solution is asked for in place of the right one, or a change of what is read.

use mpm_core::scene::{Fields, Side};

use super::case::{Case, Place};
use super::results::{Answer, Row};

/// A known mistake.
#[derive(Clone, Copy)]
pub struct Mistake {
    /// Its name in tables.
    pub name: &'static str,
    /// What a code does that makes it.
    pub words: &'static str,
    how: How,
}

/// What makes its solution.
#[derive(Clone, Copy)]
enum How {
    /// The exact solution of another problem.
    Solves(fn(&mut Fields)),
    /// Numbers that are read in another way: what makes right ones of them, from the problem, its refinement and the unit.
    Reads(fn(&Fields, f64, &str) -> Reading),
}

/// A number that was read as `factor * number + offset` has its right value.
#[derive(Clone, Copy, PartialEq)]
struct Reading {
    factor: f64,
    offset: f64,
}

const fn times(factor: f64) -> Reading {
    Reading { factor, offset: 0.0 }
}

/// Nothing to change: the mistake is none for such a number.
const SAME: Reading = times(1.0);

/// How much closer to the solution of a mistake than to the right one a result has to be.
const CLOSER: f64 = 0.25;
/// The same of a result that passes.
const CLOSEST: f64 = 0.15;
/// Share of the error of a scheme of second order below which no mistake is looked for.
const NOTHING: f64 = 0.05;
/// Mistakes whose solutions are as close are both named.
const ALIKE: f64 = 1.3;

fn faster(fields: &mut Fields, factor: f64) {
    if let Some(water) = &mut fields.water {
        water.hydraulic_conductivity *= factor;
    }
    for layer in &mut fields.layers {
        layer.hydraulic_conductivity *= factor;
    }
    for region in &mut fields.regions {
        region.soil.hydraulic_conductivity *= factor;
    }
}

fn stiffer(fields: &mut Fields, of: fn(&mut mpm_core::scene::Elastic)) {
    of(&mut fields.elastic);
    fields.layers.iter_mut().for_each(|layer| of(&mut layer.elastic));
}

fn heavier(fields: &mut Fields, factor: f64) {
    if let Some(load) = &mut fields.surcharge {
        load.pressure *= factor;
    }
    for load in &mut fields.loads {
        if let mpm_core::scene::Bearing::Traction { pressure, .. } = &mut load.bearing {
            *pressure *= factor;
        }
    }
}

/// Part of the load that the skeleton bears at once where the start is undrained equilibrium, as settlement, m.
fn at_once(fields: &Fields) -> f64 {
    if fields.start != mpm_core::scene::Start::UndrainedEquilibrium {
        return 0.0;
    }
    let (load, modulus) = (fields.surcharge.map_or(0.0, |load| load.pressure), fields.oedometer_modulus());
    let weight = 0.5 * fields.gravity.unwrap_or(0.0) * fields.mixture_density() * fields.height;
    (1.0 - fields.undrained_share()) * (load + weight) * fields.height / modulus
}

/// All of them. Where two have the same solution the first is named first.
pub const MISTAKES: &[Mistake] = &[
    Mistake {
        name: "incompressible",
        words: "the formula of incompressible water, where the water is compressible",
        how: How::Solves(|f| {
            if let Some(water) = &mut f.water {
                // Stiff enough, and no step is too short for the scene to be read.
                water.bulk_modulus *= 1e4;
            }
        }),
    },
    Mistake {
        name: "c_v-without-storage",
        words: "c_v = k M/gamma_w, without the storage of the water",
        how: How::Solves(|f| faster(f, 1.0 + f.oedometer_modulus() / f.pore_stiffness())),
    },
    Mistake {
        name: "path-halved",
        words: "drainage path half as long: drained at both ends, or half the height taken",
        how: How::Solves(|f| faster(f, 4.0)),
    },
    Mistake {
        name: "path-doubled",
        words: "drainage path twice as long: drained at one end only, or the whole height taken",
        how: How::Solves(|f| faster(f, 0.25)),
    },
    Mistake {
        name: "time-doubled",
        words: "time or conductivity twice as large",
        how: How::Solves(|f| faster(f, 2.0)),
    },
    Mistake { name: "time-halved", words: "time or conductivity half as large", how: How::Solves(|f| faster(f, 0.5)) },
    Mistake {
        name: "unit-weight-as-density",
        words: "the density of water in place of its unit weight: flow 9.81 times as fast",
        how: How::Solves(|f| faster(f, 9.81)),
    },
    Mistake {
        name: "gravity-twice",
        words: "gravity counted twice in the unit weight: flow 9.81 times as slow",
        how: How::Solves(|f| faster(f, 1.0 / 9.81)),
    },
    Mistake {
        name: "total-for-effective",
        words: "total in place of effective stress: the soil bears the load at once",
        how: How::Solves(|f| faster(f, 1e5)),
    },
    Mistake {
        name: "lateral-stress",
        words: "Young's modulus in place of the oedometer modulus: lateral stress left out",
        how: How::Solves(|f| stiffer(f, |elastic| elastic.poisson_ratio = 0.0)),
    },
    Mistake {
        name: "bulk-modulus",
        words: "the bulk modulus in place of the oedometer modulus",
        how: How::Solves(|f| {
            stiffer(f, |elastic| {
                // K = M (1 + nu)/(3 (1 - nu)).
                let nu = elastic.poisson_ratio;
                elastic.youngs_modulus *= (1.0 + nu) / (3.0 * (1.0 - nu));
            });
        }),
    },
    Mistake {
        name: "porosity",
        words: "solid volume fraction in place of porosity",
        how: How::Solves(|f| {
            f.porosity = 1.0 - f.porosity;
            f.layers.iter_mut().for_each(|layer| layer.porosity = 1.0 - layer.porosity);
        }),
    },
    Mistake {
        name: "load-at-once",
        words: "the load applied at once, where it grows",
        how: How::Solves(|f| {
            if let Some(load) = &mut f.surcharge {
                load.ramp_time = 0.0;
            }
        }),
    },
    Mistake { name: "load-doubled", words: "the load twice as large", how: How::Solves(|f| heavier(f, 2.0)) },
    Mistake { name: "load-halved", words: "the load half as large", how: How::Solves(|f| heavier(f, 0.5)) },
    Mistake {
        name: "weight-without-buoyancy",
        words: "the weight of the grains without the buoyancy of the water",
        how: How::Solves(|f| {
            if let Some(water) = &mut f.water {
                // The buoyant weight is (1 - n) (rho_s - rho_w) g.
                f.grain_density += water.density;
            }
        }),
    },
    Mistake {
        name: "grain-density",
        words: "the density of the grains in place of that of the mixture",
        how: How::Solves(|f| {
            let water = f.water.map_or(0.0, |water| water.density);
            f.grain_density = (f.grain_density - f.porosity * water) / (1.0 - f.porosity);
        }),
    },
    Mistake {
        name: "dry-density",
        words: "the density of dry soil in place of that of the mixture",
        how: How::Solves(|f| {
            let water = f.water.map_or(0.0, |water| water.density);
            f.grain_density -= f.porosity * water / (1.0 - f.porosity);
        }),
    },
    Mistake {
        name: "both-ends",
        words: "the base drained, where it is tight",
        how: How::Solves(|f| f.stages.iter_mut().for_each(|stage| stage.drained[Side::Bottom as usize] = true)),
    },
    Mistake {
        name: "load-half-a-spacing-too-low",
        words: "the load half a spacing below the surface: soil above it carries nothing",
        how: How::Reads(|_, refinement, unit| if unit == "m" { times(1.0 / (1.0 - 0.5 / refinement)) } else { SAME }),
    },
    Mistake {
        name: "sign",
        words: "the opposite sign: of gravity, of compression, or of a settlement",
        how: How::Reads(|_, _, _| times(-1.0)),
    },
    Mistake {
        name: "from-the-loaded-state",
        words: "settlement counted from the loaded undrained state in place of the unloaded one",
        how: How::Reads(|fields, _, unit| Reading {
            factor: 1.0,
            offset: if unit == "m" { at_once(fields) } else { 0.0 },
        }),
    },
    Mistake {
        name: "kilo",
        words: "a unit a thousand times as large: kPa, or km",
        how: How::Reads(|_, _, _| times(1e3)),
    },
    Mistake {
        name: "milli",
        words: "a unit a thousandth as large: mm, or mPa",
        how: How::Reads(|_, _, _| times(1e-3)),
    },
    Mistake {
        name: "head-for-pressure",
        words: "pressure head in place of pressure",
        how: How::Reads(|fields, _, unit| match fields.water {
            Some(water) if unit == "Pa" => times(water.unit_weight),
            _ => SAME,
        }),
    },
    Mistake {
        name: "share-of-the-load",
        words: "pressure over the load in place of pressure",
        how: How::Reads(|fields, _, unit| match fields.surcharge {
            Some(load) if unit == "Pa" => times(load.pressure),
            _ => SAME,
        }),
    },
    Mistake {
        name: "half",
        words: "half of what is asked: one side of a symmetric problem",
        how: How::Reads(|_, _, _| times(2.0)),
    },
    Mistake {
        name: "twice",
        words: "twice what is asked: both sides of a symmetric problem",
        how: How::Reads(|_, _, _| times(0.5)),
    },
];

impl Mistake {
    /// The answer as this mistake reads it; `None` where that makes no difference. The solution of another problem reads as it is.
    fn read(&self, case: &Case, answer: &Answer) -> Option<Answer> {
        let How::Reads(reading) = self.how else { return Some(answer.clone()) };
        let mut changed = false;
        let mut read = answer.clone();
        for (refinement, rows) in &mut read.levels {
            for row in rows {
                let unit = &case.wanted[row.quantity].unit;
                let how = case.scene().map_or(SAME, |scene| reading(scene, *refinement, unit));
                changed |= how != SAME;
                row.value = how.factor * row.value + how.offset;
            }
        }
        changed.then_some(read)
    }

    /// How far an answer is from the solution of this mistake; `None` where that is the right one, or there is none.
    fn error(&self, case: &Case, answer: &Answer) -> Option<f64> {
        let read = self.read(case, answer)?;
        let How::Solves(alter) = self.how else { return error(case, &read, &mut |_| {}) };
        error(case, &read, &mut |fields| alter(fields))
    }
}

/// How far an answer is from the exact solution of an altered problem on meshes without end, as far as its levels tell; else on the finest.
fn error(case: &Case, answer: &Answer, alter: &mut dyn FnMut(&mut Fields)) -> Option<f64> {
    let (refinement, rows) = answer.levels.last()?;
    let far = extrapolated(case, answer);
    let found = case.compared_as(*refinement, far.as_ref().unwrap_or(rows), alter).ok()?;
    Some(found.error().abs()).filter(|error| error.is_finite())
}

/// Numbers on a mesh without end, from the two finest levels and an error of second order. A solver that chooses its places has other
/// ones on each mesh.
fn extrapolated(case: &Case, answer: &Answer) -> Option<Vec<Row>> {
    let [.., (coarse, before), (fine, rows)] = &answer.levels[..] else { return None };
    if case.wanted.iter().any(|wanted| matches!(wanted.place, Place::Heights | Place::Field)) {
        return None;
    }
    let share = 1.0 / ((fine / coarse).powi(2) - 1.0);
    let one = |row: &Row| {
        let same = |other: &&Row| other.quantity == row.quantity && other.time == row.time && row.stands(other.place);
        let other = before.iter().find(same)?;
        Some(Row { value: row.value + share * (row.value - other.value), ..*row })
    };
    rows.iter().map(one).collect()
}

/// The mistakes that an answer resembles, the likeliest first; none where it is like none of them. `passed` is whether it would pass:
/// then it has to be as much closer to a mistake.
pub fn seen(case: &Case, answer: &Answer, passed: bool) -> Vec<&'static Mistake> {
    let Some(right) = error(case, answer, &mut |_| {}) else { return Vec::new() };
    let close = if passed { CLOSEST } else { CLOSER };
    // An answer that is right is like none.
    if right <= NOTHING * case.expected[1] {
        return Vec::new();
    }
    let alike = MISTAKES.iter().filter_map(|mistake| {
        let own = mistake.error(case, answer)?;
        (own <= close * right).then_some((own, mistake))
    });
    let mut alike: Vec<(f64, &Mistake)> = alike.collect();
    alike.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = alike.first().map_or(0.0, |(error, _)| *error);
    alike.into_iter().take_while(|(error, _)| *error <= ALIKE * least).map(|(_, mistake)| mistake).collect()
}

#[cfg(test)]
mod tests {
    use super::super::case::chosen;
    use super::super::score::{Verdict, score};
    use super::*;

    /// The right answer of a solver of second order to a case, one number at each time, with a mistake.
    fn made(case: &Case, mistake: Option<&Mistake>, error: f64) -> Option<Answer> {
        let level = |refinement: &f64| -> Option<(f64, Vec<Row>)> {
            let wanted = &case.wanted[0];
            let blank: Vec<Row> = wanted.times.iter().map(|time| Row::one(0, *time, 1.0)).collect();
            let found = match mistake.map(|mistake| mistake.how) {
                Some(How::Solves(alter)) => case.compared_as(*refinement, &blank, &mut |fields| alter(fields)),
                _ => case.compared(*refinement, &blank),
            };
            // Some mistakes make no problem that has a solution.
            let found = found.ok()?;
            let value = |row: &Row| {
                let look =
                    found.rows.iter().find(|look| (look.time - row.time).abs() < 1e-9 * row.time).expect("a time");
                // What is compared is the value over a size.
                let exact = look.exact[0] / look.computed[0];
                let numeric = exact * (1.0 + error * (look.time / wanted.times[0]).powf(-0.5) / refinement.powi(2));
                let reading = match (mistake.map(|mistake| mistake.how), case.scene()) {
                    (Some(How::Reads(reading)), Some(scene)) => reading(scene, *refinement, &wanted.unit),
                    _ => SAME,
                };
                Row { value: (numeric - reading.offset) / reading.factor, ..*row }
            };
            Some((*refinement, blank.iter().map(value).collect()))
        };
        Some(Answer { levels: case.refinements.iter().map(level).collect::<Option<_>>()?, faults: Vec::new() })
    }

    #[test]
    fn mistakes_are_named_and_right_answers_have_none() {
        let cases = [
            "consolidation",
            "consolidation-ramp",
            "consolidation-double",
            "consolidation-with-inertia",
            "self-weight",
        ];
        let (mut planted, mut named) = (0, 0);
        for (seed, cases) in [(0, &cases[..]), (4, &cases[2..3])] {
            let cases: Vec<String> = cases.iter().map(|name| (*name).to_owned()).collect();
            for case in chosen(&cases, seed).expect("cases") {
                // Errors in space of either sign and of several sizes.
                for error in [8.0, -3.0, 0.5] {
                    let right = score(&case, &made(&case, None, error).expect("numbers"), &Default::default(), &[]);
                    assert_eq!(
                        (right.verdict, &right.mistakes[..]),
                        (Verdict::Passes, &[][..]),
                        "{}: {right:?}",
                        case.name
                    );
                }
                let right = made(&case, None, 0.0).expect("numbers");
                for mistake in MISTAKES {
                    let Some(answer) = made(&case, Some(mistake), 1.0) else { continue };
                    let apart = |(a, b): (&Row, &Row)| (a.value / b.value - 1.0).abs();
                    let last = |answer: &Answer| answer.levels.last().expect("a level").1.clone();
                    let differs = last(&answer).iter().zip(&last(&right)).map(apart).fold(0.0, f64::max);
                    // What hardly changes a number is no mistake that could be seen in it.
                    if !(differs > 3e-3 && differs.is_finite()) {
                        continue;
                    }
                    let found = score(&case, &answer, &Default::default(), &[]);
                    planted += 1;
                    named += usize::from(found.mistakes.iter().any(|name| name == mistake.name));
                    if !found.mistakes.iter().any(|name| name == mistake.name) {
                        println!("{} seed {seed}: {} taken for {:?}", case.name, mistake.name, found.mistakes);
                    }
                    assert_ne!(found.verdict, Verdict::Passes, "{}: {}", case.name, mistake.name);
                }
            }
        }
        assert!(planted >= 70 && 10 * named >= 9 * planted, "{named} of {planted}");
    }
}
