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

/// A number as in print, `digits` significant ones without zeros at their end: `0.35`, `2200`, `4.5 × 10⁻⁵`.
pub fn print(value: f64, digits: usize) -> String {
    if !value.is_finite() || value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        return brief(value, digits);
    }
    let (number, power) = parts(value, digits);
    let number = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { &number };
    if number == "1" { power } else { format!("{number} × {power}") }
}

/// Digits and power of ten of a number.
fn parts(value: f64, digits: usize) -> (String, String) {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let (number, power) = text.split_once('e').unwrap_or((&text, "0"));
    (number.replace('-', "\u{2212}"), power_of_ten(power.parse().unwrap_or(0)))
}

/// The numbers of one column of a table in one notation: all plain, or all with a power of ten; a dash for one that is not there.
pub fn column(values: &[f64], digits: usize) -> Vec<String> {
    let sizes = || values.iter().map(|value| value.abs()).filter(|size| *size > 0.0 && size.is_finite());
    let plain = sizes().all(|size| (1e-3..1e6).contains(&size));
    let text = |value: &f64| match *value {
        value if !value.is_finite() || value == 0.0 || plain => short(value, digits),
        value => {
            let (number, power) = parts(value, digits);
            format!("{number} × {power}")
        }
    };
    values.iter().map(text).collect()
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
        assert_eq!(
            [0.35, 2200.0, 4.5e-5, -1e-9, 1e7].map(|v| print(v, 3)),
            ["0.35", "2200", "4.5 × 10⁻⁵", "\u{2212}1 × 10⁻⁹", "10⁷"]
        );
    }

    #[test]
    fn a_column_has_one_notation() {
        assert_eq!(column(&[0.5, 20.0, 0.0, f64::NAN], 2), ["0.50", "20", "0", "–"]);
        assert_eq!(column(&[0.5, 2e-9], 2), ["5.0 × 10⁻¹", "2.0 × 10⁻⁹"]);
    }
}
