//! How numbers are written.

/// A number for a file: the shortest text that reads back to the same bits; `NaN` for one that is not there.
pub fn exact(value: f64) -> String {
    format!("{value:?}")
}

/// A number for a reader: `digits` significant ones, plain or with an exponent; a dash for one that is not there.
pub fn short(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
    let power = rounded.abs().log10().floor() as i32;
    if (-4..6).contains(&power) {
        let decimals = (digits as i32 - 1 - power).max(0) as usize;
        format!("{rounded:.decimals$}").replace('-', "\u{2212}")
    } else {
        format!("{value:.*e}", digits.saturating_sub(1)).replace('-', "\u{2212}")
    }
}

/// The same without zeros at the end of its decimals: `0.001`, `1e−9`.
pub fn brief(value: f64, digits: usize) -> String {
    let text = short(value, digits);
    let (number, power) = text.split_once('e').map_or((text.as_str(), None), |(n, p)| (n, Some(p)));
    let number = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    power.map_or_else(|| number.to_owned(), |power| format!("{number}e{power}"))
}

/// A share in percent with three significant digits, without the sign for percent.
pub fn percent(share: f64) -> String {
    short(100.0 * share, 3)
}

/// A power of ten as in print: `10⁻³`.
pub fn power_of_ten(power: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = power.unsigned_abs().to_string();
    let raised: String = digits.bytes().map(|b| RAISED[usize::from(b - b'0')]).collect();
    format!("10{}{raised}", if power < 0 { "⁻" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(percent(0.350_880_6), "35.1");
        assert_eq!(
            (brief(1e-9, 2), brief(0.0015, 3), brief(20.0, 2)),
            ("1e\u{2212}9".into(), "0.0015".into(), "20".into())
        );
        assert_eq!(percent(-0.017_62), "\u{2212}1.76");
        assert_eq!(percent(0.000_868_9), "0.0869");
        assert_eq!(percent(f64::NAN), "–");
        assert_eq!(percent(0.099_99), "10.0");
        assert_eq!(short(3.316_6e-7, 3), "3.32e\u{2212}7");
        assert_eq!(exact(3.311_459_562_248_979e-7), "3.311459562248979e-7");
        assert_eq!(exact(f64::NAN), "NaN");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }
}
