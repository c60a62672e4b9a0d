//! How much water unsaturated soil holds under suction, and how well it still conducts.
//!
//! Effective saturation `S_e = (S - S_r)/(1 - S_r)`: the share of the mobile pores that holds water. Suction is a head, `s = -p/gamma_w` (m).
//!
//! | law | S_e | k_r | source |
//! |---|---|---|---|
//! | van Genuchten-Mualem | `(1 + (alpha s)^n)^-m`, m = 1 - 1/n | `S_e^(1/2) (1 - (1 - S_e^(1/m))^m)^2` | van Genuchten 1980, doi:10.2136/sssaj1980.03615995004400050002x; both over what they are at the entry of air, if there is one: Ippisch et al. 2006, doi:10.1016/j.advwatres.2005.12.011 |
//! | Gardner | `exp(-alpha s)` | `exp(-alpha s)` | Gardner 1958, doi:10.1097/00010694-195804000-00006 |
//! | Brooks-Corey | `(s_e/s)^lambda` above the air entry s_e | `S_e^(3 + 2/lambda)` | Brooks & Corey 1964, Hydrology Paper 3, Colorado State University |

use serde::{Deserialize, Serialize};

/// A law of retention and relative conductivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Retention {
    /// Van Genuchten's with Mualem's conductivity.
    VanGenuchten {
        /// alpha, 1/m.
        alpha: f64,
        /// n > 1.
        n: f64,
        /// Suction head at which air enters, m; 0 in van Genuchten's own law, whose conductivity falls infinitely fast at first where
        /// n < 2.
        entry: f64,
    },
    /// Gardner's: exponential in the suction.
    Gardner {
        /// alpha, 1/m.
        alpha: f64,
    },
    /// Brooks and Corey's with Burdine's conductivity.
    BrooksCorey {
        /// Suction at which air enters, m.
        entry: f64,
        /// Index of the distribution of pore sizes lambda.
        index: f64,
    },
}

/// State of the pores at a pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moist {
    /// The pressure, Pa.
    pub pressure: f64,
    /// S_e.
    pub wet: f64,
    /// `dS_e/dp`, 1/Pa.
    pub capacity: f64,
    /// k_r.
    pub conducts: f64,
    /// `dk_r/dp`, 1/Pa.
    pub conducts_more: f64,
}

impl Moist {
    /// Full pores.
    pub const FULL: Self = Self { pressure: 0.0, wet: 1.0, capacity: 0.0, conducts: 1.0, conducts_more: 0.0 };
}

/// Least relative conductivity: below it water is as good as fixed, and a system of it singular.
const LEAST: f64 = 1e-12;

impl Retention {
    /// The state at a pressure (Pa) of water of a unit weight, N/m3.
    pub fn at(&self, pressure: f64, unit_weight: f64) -> Moist {
        let s = -pressure / unit_weight;
        if s <= 0.0 {
            return Moist { pressure, ..Moist::FULL };
        }
        // Values, and their derivatives by the suction head.
        let ([wet, conducts], [less, conducts_less]) = match *self {
            Self::VanGenuchten { alpha, n, entry } => {
                if s <= entry {
                    return Moist { pressure, ..Moist::FULL };
                }
                let m = 1.0 - 1.0 / n;
                let x = (alpha * s).powf(n);
                // 1 - (x/(1 + x))^m without cancellation in dry soil.
                let part = |x: f64| -(m * (-1.0 / (1.0 + x)).ln_1p()).exp_m1();
                let (full, whole) = match entry {
                    0.0 => (1.0, 1.0),
                    entry => ((1.0 + (alpha * entry).powf(n)).powf(m), part((alpha * entry).powf(n))),
                };
                let wet = full * (1.0 + x).powf(-m);
                let b = part(x) / whole;
                let a = wet.sqrt();
                let by_s = n * x / s;
                let b_by_x = -m / whole * (x / (1.0 + x)).powf(m - 1.0) / (1.0 + x).powi(2);
                let k_by_x = -0.5 * m * a / (1.0 + x) * b * b + 2.0 * a * b * b_by_x;
                ([wet, a * b * b], [-m * wet / (1.0 + x) * by_s, k_by_x * by_s])
            }
            Self::Gardner { alpha } => {
                let wet = (-alpha * s).exp();
                ([wet; 2], [-alpha * wet; 2])
            }
            Self::BrooksCorey { entry, index } => {
                if s <= entry {
                    return Moist { pressure, ..Moist::FULL };
                }
                let wet = (entry / s).powf(index);
                let power = 3.0 + 2.0 / index;
                let conducts = wet.powf(power);
                ([wet, conducts], [-index * wet / s, -index * power * conducts / s])
            }
        };
        Moist {
            pressure,
            wet,
            capacity: -less / unit_weight,
            conducts: conducts.max(LEAST),
            conducts_more: if conducts > LEAST { -conducts_less / unit_weight } else { 0.0 },
        }
    }

    /// Pressure (Pa) at which a share of the pores between 0 and 1 is wet; the highest of them where all are.
    pub fn pressure(&self, wet: f64, unit_weight: f64) -> f64 {
        /// Less than this no soil is dried to.
        const DRIEST: f64 = 1e-12;
        let wet = wet.max(DRIEST);
        if wet >= 1.0 {
            return 0.0;
        }
        let s = match *self {
            Self::VanGenuchten { alpha, n, entry } => {
                let m = 1.0 - 1.0 / n;
                let full = (1.0 + (alpha * entry).powf(n)).powf(m);
                ((-(wet / full).ln() / m).exp_m1()).powf(1.0 / n) / alpha
            }
            Self::Gardner { alpha } => -wet.ln() / alpha,
            Self::BrooksCorey { entry, index } => entry * wet.powf(-1.0 / index),
        };
        -s * unit_weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Retention; 4] = [
        Retention::VanGenuchten { alpha: 0.64, n: 4.65, entry: 0.0 },
        Retention::VanGenuchten { alpha: 3.0, n: 1.4, entry: 0.1 },
        Retention::Gardner { alpha: 1.5 },
        Retention::BrooksCorey { entry: 0.2, index: 2.5 },
    ];
    const GAMMA: f64 = 9810.0;

    #[test]
    fn derivatives_are_those_of_the_values() {
        for law in LAWS {
            for s in [0.01, 0.15, 0.7, 1.3, 4.0] {
                let (p, d) = (-s * GAMMA, 1e-4 * s * GAMMA);
                let (low, here, high) = (law.at(p - d, GAMMA), law.at(p, GAMMA), law.at(p + d, GAMMA));
                let by = |a: f64, b: f64| (b - a) / (2.0 * d);
                assert!((by(low.wet, high.wet) - here.capacity).abs() <= 1e-6 * here.capacity + 1e-11, "{law:?} {s}");
                let slope = by(low.conducts, high.conducts);
                assert!((slope - here.conducts_more).abs() <= 1e-6 * here.conducts_more + 1e-11, "{law:?} {s}");
            }
        }
    }

    #[test]
    fn pressures_and_shares_go_with_each_other() {
        for law in LAWS {
            for wet in [1e-9, 1e-3, 0.2, 0.9, 0.999] {
                let p = law.pressure(wet, GAMMA);
                assert!((law.at(p, GAMMA).wet / wet - 1.0).abs() < 1e-9, "{law:?} {wet}");
            }
            let full = Moist { pressure: 10.0, ..Moist::FULL };
            assert_eq!((law.at(10.0, GAMMA), law.pressure(1.0, GAMMA)), (full, 0.0));
        }
    }
}
