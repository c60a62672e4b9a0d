//! Known mistakes: a result that agrees with the exact solution of a mistake much better than with that of the problem has made it.
//!
//! Each mistake is a change of the problem, whose exact solution is asked for in place of the right one, or a change of what is read.

use mpm_core::scene::{Fields, Side};

use super::case::Case;
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
                water.bulk_modulus *= 1e9;
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
    Mistake {
        name: "time-halved",
        words: "time or conductivity half as large",
        how: How::Solves(|f| faster(f, 0.5)),
    },
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
    Mistake {
        name: "load-doubled",
        words: "the load twice as large",
        how: How::Solves(|f| heavier(f, 2.0)),
    },
    Mistake {
        name: "load-halved",
        words: "the load half as large",
        how: How::Solves(|f| heavier(f, 0.5)),
    },
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
    Mistake { name: "kilo", words: "a unit a thousand times as large: kPa, or km", how: How::Reads(|_, _, _| times(1e3)) },
    Mistake { name: "milli", words: "a unit a thousandth as large: mm, or mPa", how: How::Reads(|_, _, _| times(1e-3)) },
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
    Mistake { name: "half", words: "half of what is asked: one side of a symmetric problem", how: How::Reads(|_, _, _| times(2.0)) },
    Mistake { name: "twice", words: "twice what is asked: both sides of a symmetric problem", how: How::Reads(|_, _, _| times(0.5)) },
];

impl Mistake {
    /// How far an answer is from the solution of this mistake, level by level; `None` where it makes no difference or has no solution.
    fn errors(&self, case: &Case, answer: &Answer) -> Option<Vec<f64>> {
        let one = |(refinement, rows): &(f64, Vec<Row>)| -> Option<f64> {
            let found = match self.how {
                How::Solves(alter) => case.compared_as(*refinement, rows, &mut |fields| alter(fields)).ok()?,
                How::Reads(reading) => {
                    let mut read = rows.clone();
                    let mut changed = false;
                    for row in &mut read {
                        let unit = &case.wanted[row.quantity].unit;
                        let how = match case.scene() {
                            Some(scene) => reading(scene, *refinement, unit),
                            // Without a problem to ask, a factor alone.
                            None if matches!(self.name, "sign" | "kilo" | "milli" | "half" | "twice") => {
                                reading(any(), *refinement, unit)
                            }
                            None => SAME,
                        };
                        changed |= how != SAME;
                        row.value = how.factor * row.value + how.offset;
                    }
                    changed.then(|| case.compared(*refinement, &read).ok())??
                }
            };
            Some(found.error().abs()).filter(|error| error.is_finite())
        };
        answer.levels.iter().map(one).collect()
    }
}

/// Some scene, for readings that ask none.
fn any() -> &'static Fields {
    static SCENE: std::sync::LazyLock<mpm_core::scene::Scene> =
        std::sync::LazyLock::new(|| crate::scenes::built_in("terzaghi").unwrap_or_else(|e| panic!("{e}")));
    &SCENE
}

/// The mistakes that an answer with these errors against the right solution looks like, the likeliest first; none where it is like
/// none of them. Its finest level decides, and no level may contradict.
pub fn seen(case: &Case, answer: &Answer, errors: &[f64]) -> Vec<&'static Mistake> {
    let Some(right) = errors.last().filter(|error| error.is_finite()) else { return Vec::new() };
    let alike = MISTAKES.iter().filter_map(|mistake| {
        let own = mistake.errors(case, answer)?;
        let agrees = own.iter().zip(errors).all(|(own, right)| *own <= right.abs() || right.is_nan());
        let last = *own.last()?;
        (agrees && last <= CLOSER * right.abs()).then_some((last, mistake))
    });
    let mut alike: Vec<(f64, &Mistake)> = alike.collect();
    alike.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = alike.first().map_or(0.0, |(error, _)| *error);
    alike.into_iter().take_while(|(error, _)| *error <= ALIKE * least).map(|(_, mistake)| mistake).collect()
}
