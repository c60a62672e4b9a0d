//! Quantities as people write them: three or four significant digits and a unit that fits.

use mpm_verify::report::numbers::short;

/// Units of a quantity, the largest first, each with its size in SI.
type Units = [(&'static str, f64)];

const LENGTHS: &Units = &[("m", 1.0), ("mm", 1e-3)];
const STRESSES: &Units = &[("MPa", 1e6), ("kPa", 1e3), ("Pa", 1.0)];
const FORCES: &Units = &[("MN/m", 1e6), ("kN/m", 1e3), ("N/m", 1.0)];
const TIMES: &Units =
    &[("years", 31_557_600.0), ("days", 86_400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3)];
const FLOWS: &Units = &[("m3/s", 1.0), ("m3/h", 1.0 / 3600.0), ("m3/day", 1.0 / 86_400.0), ("l/day", 1e-3 / 86_400.0)];

/// A value in the largest unit in which it is at least one, else in the smallest.
fn in_units(value: f64, units: &Units) -> String {
    let fits = |(_, size): &&(&str, f64)| value.abs() >= 0.999_95 * size;
    let (unit, size) = units.iter().find(fits).or(units.last()).copied().unwrap_or(("", 1.0));
    format!("{} {unit}", short(value / size, 4).replace('\u{2212}', "-"))
}

/// A length, m.
pub fn length(value: f64) -> String {
    in_units(value, LENGTHS)
}

/// A stress or a pressure, Pa.
pub fn stress(value: f64) -> String {
    in_units(value, STRESSES)
}

/// A force per metre, N/m.
pub fn force(value: f64) -> String {
    in_units(value, FORCES)
}

/// A time, s.
pub fn time(value: f64) -> String {
    in_units(value, TIMES)
}

/// A discharge, m3/s.
pub fn flow(value: f64) -> String {
    in_units(value, FLOWS)
}

/// A share, in percent.
pub fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share, 3).replace('\u{2212}', "-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_that_people_use() {
        assert_eq!([0.000_343_9, 2.0, -0.05].map(length), ["0.3439 mm", "2.000 m", "-50.00 mm"]);
        assert_eq!([9.81e3, 0.5, 3e7].map(stress), ["9.810 kPa", "0.5000 Pa", "30.00 MPa"]);
        assert_eq!([7200.0, 0.73, 90.0].map(time), ["2.000 h", "730.0 ms", "1.500 min"]);
        assert_eq!(
            (flow(2e-5), percent(0.017_38), force(12e3)),
            ("1.728 m3/day".into(), "1.74 %".into(), "12.00 kN/m".into())
        );
    }
}
