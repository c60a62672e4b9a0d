//! Thresholds from the history: of times, which nobody accepts, and of counts that depend on the compiler where none is accepted for
//! the one at hand.
//!
//! A number may be as far above its median over the last nights as `DEVIATIONS` robust standard deviations. A time is reported only
//! if it was beyond that last night, too: load on the machine comes and goes, a slower program stays.

use super::compiled::counted;
use super::history::History;
use crate::experiment::accepted::Accepted;
use crate::experiment::number::{Label, Number};

/// Nights that a threshold is made from, at most.
const NIGHTS: usize = 30;
/// The fewest nights that make one.
pub const LEAST: usize = 8;
/// Robust standard deviations (1.4826 times the median absolute deviation, Rousseeuw & Croux 1993,
/// doi:10.1080/01621459.1993.10476408) within which a number is where it was.
const DEVIATIONS: f64 = 6.0;
/// Share of the median by which a time may always grow.
const TIMES: f64 = 0.1;

/// The median of some numbers, without those that are not finite.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let upper = values.get(middle)?;
    Some(if values.len() % 2 == 1 { *upper } else { 0.5 * (values[middle - 1] + upper) })
}

/// Median of some nights, and how far a number with a relative tolerance may be from it.
fn threshold(values: &[f64], relative: f64) -> Option<(f64, f64)> {
    let middle = median(values.iter().copied()).filter(|_| values.len() >= LEAST)?;
    let deviation = 1.4826 * median(values.iter().map(|value| (value - middle).abs()))?;
    Some((middle, (DEVIATIONS * deviation).max(relative * middle.abs())))
}

/// Tolerance of a number whatever its history.
fn least(number: &Number) -> f64 {
    if number.label == Label::Time { TIMES } else { number.tolerance.relative }
}

/// Baselines from the history for the numbers of a night that can have no other.
pub fn baselines(known: &[Accepted], numbers: &[Number], history: &History) -> Vec<Accepted> {
    let without = numbers.iter().filter(|number| {
        (number.label == Label::Time || counted(&number.quantity).is_some())
            && !known.iter().any(|row| number.is_of(&row.case, &row.quantity))
    });
    let row = |number: &Number| {
        let values = history.values(&number.case, &number.quantity, NIGHTS);
        let (value, absolute) = threshold(&values, least(number))?;
        Some(Accepted {
            case: number.case.clone(),
            quantity: number.quantity.clone(),
            label: number.label,
            value,
            relative: 0.0,
            absolute,
            since: String::new(),
            why: format!("median of {} nights", values.len()),
        })
    };
    without.filter_map(row).collect()
}

/// The value of a number that is compared: of a time the smaller one of this and of last night.
pub fn compared(number: &Number, history: &History) -> f64 {
    match history.last(&number.case, &number.quantity) {
        Some(last) if number.label == Label::Time => number.value.min(last),
        _ => number.value,
    }
}

/// Expected false alarms: reports of times of a program that did not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseAlarms {
    /// Times.
    pub numbers: usize,
    /// Nights of the history.
    pub nights: usize,
    /// Times of single nights beyond the threshold of all these nights.
    pub beyond: usize,
    /// Times of these nights.
    pub all: usize,
}

impl FalseAlarms {
    /// Counts in the history, for the times among some numbers.
    pub fn of(numbers: &[Number], history: &History) -> Option<Self> {
        let mut found = Self { numbers: 0, nights: 0, beyond: 0, all: 0 };
        for number in numbers.iter().filter(|number| number.label == Label::Time) {
            let values = history.values(&number.case, &number.quantity, NIGHTS);
            let Some((middle, allowed)) = threshold(&values, least(number)) else { continue };
            found.numbers += 1;
            found.nights = found.nights.max(values.len());
            found.beyond += values.iter().filter(|value| **value > middle + allowed).count();
            found.all += values.len();
        }
        (found.numbers > 0).then_some(found)
    }

    /// Expected number in 30 nights, if one night says nothing of the next: the share of single nights beyond the threshold (with one
    /// more than were seen), squared, for each time.
    pub fn in_thirty_nights(self) -> f64 {
        let share = (self.beyond + 1) as f64 / (self.all + 1) as f64;
        30.0 * self.numbers as f64 * share * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::number::Tolerance;
    use crate::nightly::moved::moved;

    fn number(quantity: &str, label: Label, value: f64) -> Number {
        Number::new("gate", quantity, label, value, Tolerance::relative(0.01))
    }

    /// Numbers that moved after some nights, and the last one.
    fn reported(quantity: &str, label: Label, nights: &[f64]) -> usize {
        let (last, earlier) = nights.split_last().expect("a night");
        let mut history = History::default();
        for (day, value) in earlier.iter().enumerate() {
            history.note(&format!("d{day} c"), &[number(quantity, label, *value)]);
        }
        let tonight = [number(quantity, label, *last)];
        moved(&baselines(&[], &tonight, &history), &tonight, &history, "now c").len()
    }

    #[test]
    fn times_are_compared_with_their_history_and_reported_on_the_second_night() {
        let usual = [1.0, 1.1, 0.9, 1.05, 0.95, 1.0, 1.02, 0.98, 1.04];
        let then = |more: &[f64]| reported("time_ratio", Label::Time, &[&usual, more].concat());
        assert_eq!((then(&[1.1]), then(&[3.0]), then(&[3.0, 3.0]), then(&[3.0, 1.0])), (0, 0, 1, 0));
        assert_eq!(then(&[0.3, 0.3]), 0, "a faster machine is no news");
        assert_eq!(reported("time_ratio", Label::Time, &[1.0, 1.0, 3.0, 3.0]), 0, "too few nights");
    }

    #[test]
    fn counts_of_another_compiler_are_compared_with_their_history() {
        let nights = [1000.0; 9];
        let then = |last: f64| reported("instructions (x)", Label::Count, &[&nights[..], &[last]].concat());
        assert_eq!((then(1009.0), then(1020.0), then(980.0)), (0, 1, 1));
    }

    #[test]
    fn false_alarms_are_expected_as_often_as_the_nights_say() {
        let mut history = History::default();
        for day in 0..20 {
            let value = if day == 7 { 9.0 } else { 1.0 + 0.01 * f64::from(day % 3) };
            history.note(&format!("d{day} c"), &[number("time_ratio", Label::Time, value)]);
        }
        let found = FalseAlarms::of(&[number("time_ratio", Label::Time, 1.0)], &history).expect("a history");
        assert_eq!(found, FalseAlarms { numbers: 1, nights: 20, beyond: 1, all: 20 });
        assert!((found.in_thirty_nights() - 30.0 * (2.0_f64 / 21.0).powi(2)).abs() < 1e-12);
        assert_eq!(FalseAlarms::of(&[], &history), None);
    }
}
