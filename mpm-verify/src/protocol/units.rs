//! Units of neutral cases: their suffixes in the names of keys, and what a change of scale makes of a number.

/// How much longer lengths, times and stresses are: a problem that is scaled by these has the same solution in dimensionless form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Lengths.
    pub length: f64,
    /// Times.
    pub time: f64,
    /// Stresses.
    pub stress: f64,
}

impl Scale {
    /// Nothing is changed.
    pub const ONE: Self = Self { length: 1.0, time: 1.0, stress: 1.0 };

    /// The factor on a number in a unit; `None` for a unit that is not known.
    pub fn factor(self, unit: &str) -> Option<f64> {
        let [length, time, stress] = UNITS.iter().find(|(name, ..)| *name == unit)?.2;
        Some(self.length.powi(length) * self.time.powi(time) * self.stress.powi(stress))
    }
}

/// Units by their names, the suffix of keys in them, and their powers of length, time and stress. Soil is 1 m thick, which nothing scales:
/// a volume per metre is an area. Mass is stress times length times time squared.
const UNITS: &[(&str, &str, [i32; 3])] = &[
    ("-", "", [0, 0, 0]),
    ("degrees", "_deg", [0, 0, 0]),
    ("integer", "", [0, 0, 0]),
    ("cells", "", [0, 0, 0]),
    ("spacings", "", [0, 0, 0]),
    ("m", "_m", [1, 0, 0]),
    ("1/m", "_per_m", [-1, 0, 0]),
    ("m2", "_m2", [2, 0, 0]),
    ("m3", "_m3", [2, 0, 0]),
    ("s", "_s", [0, 1, 0]),
    ("1/s", "_per_s", [0, -1, 0]),
    ("m/s", "_m_s", [1, -1, 0]),
    ("m/s2", "_m_s2", [1, -2, 0]),
    ("m3/s", "_m3_s", [2, -1, 0]),
    ("m3/s per metre", "_m3_s", [2, -1, 0]),
    ("Pa", "_pa", [0, 0, 1]),
    ("Pa s", "_pa_s", [0, 1, 1]),
    ("N", "_n", [1, 0, 1]),
    ("J", "_j", [2, 0, 1]),
    ("kg/m3", "_kg_m3", [-2, 2, 1]),
    ("N/m3", "_n_m3", [-1, 0, 1]),
];

/// The suffix of keys in a unit; that of each part of pairs is left out.
pub fn suffix(unit: &str) -> &'static str {
    UNITS.iter().find(|(name, ..)| *name == unit).map_or("", |(_, suffix, _)| suffix)
}

/// The unit of a key with a suffix: the longest that fits.
pub fn of_key(key: &str) -> &'static str {
    // Of units with one suffix the first.
    let fits = UNITS.iter().rev().filter(|(_, suffix, _)| key.ends_with(suffix));
    fits.max_by_key(|(_, suffix, _)| suffix.len()).map_or("-", |(name, ..)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_scale_keeps_what_has_no_dimension() {
        let scale = Scale { length: 2.0, time: 3.0, stress: 5.0 };
        let factor = |unit: &str| scale.factor(unit).expect(unit);
        // Consolidation: k M t/(gamma_w H^2).
        let time_factor = factor("m/s") * factor("Pa") * factor("s") / (factor("N/m3") * factor("m2"));
        // A wave: c^2 = M/rho; weight: rho g H/M; Darcy: k/gamma_w = intrinsic permeability over viscosity.
        let wave = factor("Pa") / factor("kg/m3") / factor("m/s").powi(2);
        let weight = factor("kg/m3") * factor("m/s2") * factor("m") / factor("Pa");
        let darcy = factor("m/s") / factor("N/m3") * factor("Pa s") / factor("m2");
        for number in [time_factor, wave, weight, darcy] {
            assert!((number - 1.0).abs() < 1e-14, "{number}");
        }
        assert_eq!((scale.factor("furlong"), of_key("height_m"), of_key("gravity_m_s2")), (None, "m", "m/s2"));
        assert_eq!((of_key("poisson_ratio"), of_key("rate_m3_s"), suffix("Pa")), ("-", "m3/s", "_pa"));
    }
}
