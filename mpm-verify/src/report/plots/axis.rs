//! An axis: what is on it, its range, its ticks.

use crate::report::numbers::{exact, power_of_ten, short};

/// How values map to length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// In proportion.
    Linear,
    /// In proportion to the logarithm; only positive values have a place.
    Log,
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, for readers.
    pub label: String,
    /// Quantity and unit as a column of the CSV: `mesh_m`.
    pub column: &'static str,
    /// How values map to length.
    pub scale: Scale,
    /// Values at the start (left, bottom) and end; found from the data if not given.
    pub range: Option<(f64, f64)>,
    /// Places and texts of ticks; found from the range if not given.
    pub named: Option<Vec<(f64, String)>>,
    /// Whether its ticks go without texts: those of a panel below hold for it too.
    pub quiet: bool,
}

/// Largest numbers on a linear axis that are written as they are.
const READABLE: std::ops::Range<f64> = 1e-3..1e5;

/// A tick: where, and its text; an empty text for a minor one.
pub type Tick = (f64, String);

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str, column: &'static str) -> Self {
        Self { label: label.to_owned(), column, scale: Scale::Linear, range: None, named: None, quiet: false }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, column: &'static str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label, column) }
    }

    /// With a given range; a first value above the second turns the axis round.
    pub fn range(self, start: f64, end: f64) -> Self {
        Self { range: Some((start, end)), ..self }
    }

    /// With given ticks.
    pub fn named(self, ticks: Vec<Tick>) -> Self {
        Self { named: Some(ticks), ..self }
    }

    /// Without name and texts of ticks.
    pub fn quiet(self) -> Self {
        Self { label: String::new(), quiet: true, ..self }
    }

    /// A value as the CSV has it: the text of a given tick at its place, otherwise the number.
    pub fn number(&self, value: f64) -> String {
        let tick = self.named.iter().flatten().find(|(place, _)| *place == value);
        tick.map_or_else(|| exact(value), |(_, text)| text.clone())
    }

    /// Whether a value has a place on the axis.
    pub fn takes(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    fn stretch(&self, value: f64) -> f64 {
        if self.scale == Scale::Log { value.log10() } else { value }
    }

    /// Sets the range, if it is not given, so that it holds some values with room at both ends.
    pub fn fit(&mut self, values: impl Iterator<Item = f64>) {
        if self.range.is_some() {
            return;
        }
        let (low, high) = values
            .filter(|v| self.takes(*v))
            .map(|v| self.stretch(v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            self.range = Some(if self.scale == Scale::Log { (0.1, 1.0) } else { (0.0, 1.0) });
            return;
        }
        let (share, least) = if self.scale == Scale::Log { (0.06, 0.05) } else { (0.06, 0.05 * high.abs().max(1e-12)) };
        let room = (share * (high - low)).max(least);
        let (low, high) = (low - room, high + room);
        self.range = Some(if self.scale == Scale::Log { (10f64.powf(low), 10f64.powf(high)) } else { (low, high) });
    }

    /// Where a value is between the start (0) and the end (1) of a fitted axis.
    pub fn place(&self, value: f64) -> f64 {
        let (start, end) = self.range.unwrap_or((0.0, 1.0));
        let (start, end) = (self.stretch(start), self.stretch(end));
        (self.stretch(value) - start) / (end - start)
    }

    /// Power of ten that the texts of the ticks leave out, a multiple of three, for numbers too small or too large to read.
    fn power(&self) -> i32 {
        let (start, end) = self.range.unwrap_or((0.0, 1.0));
        let most = start.abs().max(end.abs());
        // Without a label nothing would say what is left out.
        let is_bare = self.label.is_empty() && !self.quiet;
        if self.scale == Scale::Log || self.named.is_some() || is_bare || most == 0.0 || READABLE.contains(&most) {
            return 0;
        }
        3 * (most.log10() / 3.0).floor() as i32
    }

    /// Quantity and unit with the power of ten that the texts of the ticks leave out: `settlement (10⁻⁶ m)`.
    pub fn title(&self) -> String {
        let power = match self.power() {
            _ if self.quiet => return String::new(),
            0 => return self.label.clone(),
            power => power_of_ten(power),
        };
        match self.label.rsplit_once(" (") {
            Some((quantity, "-)" | "–)")) => format!("{quantity} ({power})"),
            Some((quantity, unit)) => format!("{quantity} ({power} {unit}"),
            None => format!("{} ({power})", self.label),
        }
    }

    /// Ticks within the range, minor ones with an empty text.
    pub fn ticks(&self) -> Vec<Tick> {
        let (start, end) = self.range.unwrap_or((0.0, 1.0));
        let (low, high) = (start.min(end), start.max(end));
        let ticks = match (&self.named, self.scale) {
            (Some(named), _) => named.clone(),
            (None, Scale::Linear) => linear_ticks(low, high, 10f64.powi(self.power())),
            (None, Scale::Log) => log_ticks(low, high),
        };
        ticks.into_iter().filter(|(v, _)| (-1e-9..=1.0 + 1e-9).contains(&self.place(*v))).collect()
    }
}

/// Multiples of 1, 2 or 5 times a power of ten, about six of them, with texts in some unit.
fn linear_ticks(low: f64, high: f64, unit: f64) -> Vec<Tick> {
    let (low, high) = (low / unit, high / unit);
    let rough = (high - low) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(10.0 * power);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let text = |v: f64| if v == 0.0 { "0".to_owned() } else { format!("{v:.decimals$}").replace('-', "\u{2212}") };
    (first..=last).map(|k| k as f64 * step).map(|v| (v * unit, text(v))).collect()
}

/// Powers of ten with text, and 2 and 5 times those on a short axis; the multiples between without text. On a long
/// axis every second power or fewer, and nothing between.
fn log_ticks(low: f64, high: f64) -> Vec<Tick> {
    let decades = (high / low).log10();
    let sparse = (decades / 7.0).ceil().max(1.0) as i32;
    let text = |multiple: i32, power: i32| {
        let shown = (multiple == 1 && power % sparse == 0)
            || (decades < 2.6 && [2, 5].contains(&multiple))
            || (decades < 0.7 && ![7, 9].contains(&multiple));
        match (shown, multiple) {
            (true, 1) if !(-3..=3).contains(&power) => power_of_ten(power),
            (true, _) => short(f64::from(multiple) * 10f64.powi(power), 1),
            (false, _) => String::new(),
        }
    };
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    (first..=last)
        .flat_map(|power| (1..if sparse > 1 { 2 } else { 10 }).map(move |multiple| (multiple, power)))
        .map(|(multiple, power)| (f64::from(multiple) * 10f64.powi(power), text(multiple, power)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, t)| t).filter(|t| !t.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(texts(&Axis::linear("", "").range(-0.02, 1.02)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(&Axis::log("", "").range(0.009, 0.11)), ["0.01", "0.02", "0.05", "0.1"]);
        assert_eq!(texts(&Axis::log("", "").range(1e-8, 1e3)), ["10⁻⁸", "10⁻⁶", "10⁻⁴", "0.01", "1", "100"]);
        assert_eq!(texts(&Axis::log("", "").range(1e-6, 1e-2)), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01"]);
    }

    #[test]
    fn very_small_and_very_large_numbers_leave_a_power_of_ten_to_the_label() {
        let axis = |label: &str, end: f64| Axis::linear(label, "").range(0.0, end);
        let small = axis("settlement (m)", 8.1e-10);
        assert_eq!(texts(&small), ["0", "200", "400", "600", "800"]);
        assert!((small.ticks()[1].0 - 2e-10).abs() < 1e-22);
        let titles =
            [("settlement (m)", 8.1e-10), ("time (s)", 2.1e7), ("error", 3e-6), ("share (-)", 3e-6), ("", 3e-6)];
        let titles = titles.map(|(label, end)| axis(label, end).title());
        assert_eq!(titles, ["settlement (10⁻¹² m)", "time (10⁶ s)", "error (10⁻⁶)", "share (10⁻⁶)", ""]);
        assert_eq!(axis("pressure (kPa)", 5e4).title(), "pressure (kPa)");
        assert_eq!(texts(&axis("time (s)", 2.1e7)), ["0", "5", "10", "15", "20"]);
    }

    #[test]
    fn a_range_holds_its_data_and_skips_what_has_no_place() {
        let mut axis = Axis::log("", "");
        axis.fit([0.1, f64::NAN, -1.0, 0.0, 10.0].into_iter());
        assert!(axis.place(0.1) > 0.0 && axis.place(10.0) < 1.0 && (axis.place(1.0) - 0.5).abs() < 1e-9);
        let mut empty = Axis::log("", "");
        empty.fit(std::iter::empty());
        assert_eq!(empty.range, Some((0.1, 1.0)));
    }
}
