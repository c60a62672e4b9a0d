//! Frames as few bytes: differences from the frame before, deflated.
//!
//! A frame is, in this order: x and y of its solid particles (numbers of two bytes, 0 to 65535 over the window), a byte per particle
//! for each quantity (0 to 255 over its range), x and y of its water particles. Of every number the difference from the same place
//! of the frame before is kept (from zero where there is none), folded so that small differences of either sign are small numbers
//! (0, -1, 1, -2, ... as 0, 1, 2, 3, ...). Of a list of numbers of two bytes, all low bytes come first.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;

use crate::frames::Shot;
use crate::report::quantity;

/// Packed frames.
pub struct Packed {
    deflated: Vec<u8>,
}

/// A frame as lists of numbers.
#[derive(Default)]
struct Lists {
    wide: [Vec<u16>; 4],
    narrow: Vec<Vec<u8>>,
}

impl Packed {
    /// Frames in a window (left, lower, right, upper end, m) with their quantities in these ranges.
    ///
    /// # Errors
    /// None in memory; what the encoder says.
    pub fn new(window: &[f64; 4], ranges: &[(f64, f64)], shots: &[&Shot]) -> std::io::Result<Self> {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let mut before = Lists::default();
        for shot in shots {
            let now = lists(shot, window, ranges);
            encoder.write_all(&differences(&now, &before))?;
            before = now;
        }
        Ok(Self { deflated: encoder.finish()? })
    }

    /// The bytes as text.
    pub fn text(&self) -> String {
        BASE64_STANDARD.encode(&self.deflated)
    }
}

fn lists(shot: &Shot, [left, low, right, high]: &[f64; 4], ranges: &[(f64, f64)]) -> Lists {
    let wide = |value: f64, ends: (f64, f64)| (share(value, ends) * 65_535.0).round() as u16;
    let mut solid: Vec<_> = shot.frame.solid.iter().collect();
    solid.sort_by_key(|p| p.id);
    let water = &shot.frame.water;
    let narrow = quantity::ALL.iter().zip(ranges).map(|(quantity, range)| {
        solid.iter().map(|p| (share((quantity.of)(p), *range) * 255.0).round() as u8).collect()
    });
    Lists {
        wide: [
            solid.iter().map(|p| wide(p.x[0], (*left, *right))).collect(),
            solid.iter().map(|p| wide(p.x[1], (*low, *high))).collect(),
            water.iter().map(|p| wide(p.x[0], (*left, *right))).collect(),
            water.iter().map(|p| wide(p.x[1], (*low, *high))).collect(),
        ],
        narrow: narrow.collect(),
    }
}

fn differences(now: &Lists, before: &Lists) -> Vec<u8> {
    let wide = |list: usize| {
        let from = before.wide[list].iter().copied().chain(std::iter::repeat(0));
        let folded: Vec<u16> = now.wide[list].iter().zip(from).map(|(a, b)| fold(a.wrapping_sub(b))).collect();
        let low = folded.iter().map(|v| v.to_le_bytes()[0]);
        low.chain(folded.iter().map(|v| v.to_le_bytes()[1])).collect::<Vec<u8>>()
    };
    let narrow = now.narrow.iter().enumerate().flat_map(|(list, values)| {
        let from = before.narrow.get(list).into_iter().flatten().copied().chain(std::iter::repeat(0));
        values.iter().zip(from).map(|(a, b)| fold_narrow(a.wrapping_sub(b))).collect::<Vec<u8>>()
    });
    [wide(0), wide(1), narrow.collect(), wide(2), wide(3)].concat()
}

/// A difference modulo 2^16, small for small ones of either sign.
fn fold(difference: u16) -> u16 {
    let signed = difference as i16;
    ((signed << 1) ^ (signed >> 15)) as u16
}

fn fold_narrow(difference: u8) -> u8 {
    let signed = difference as i8;
    ((signed << 1) ^ (signed >> 7)) as u8
}

/// Where a value is in a range, 0 to 1; what is no number is at its start.
fn share(value: f64, (low, high): (f64, f64)) -> f64 {
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    if share.is_finite() { share } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::frames::made_up;
    use crate::report::plots::levee::Site;
    use crate::report::plots::levee::map::Window;

    /// As the page does it.
    fn unfold(folded: u16) -> i32 {
        i32::from(folded >> 1) ^ -i32::from(folded & 1)
    }

    #[test]
    fn places_and_values_come_back_as_the_page_reads_them() {
        let site = Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 };
        let shots = made_up::shots(2, 3);
        let all: Vec<&Shot> = shots.iter().collect();
        let window = Window::of(&site, &shots).ends();
        let ranges: Vec<(f64, f64)> = quantity::ALL.iter().map(|q| q.range(&shots)).collect();
        let packed = Packed::new(&window, &ranges, &all).expect("packed");
        let deflated = BASE64_STANDARD.decode(packed.text()).expect("text of bytes");
        let mut bytes = Vec::new();
        flate2::read::DeflateDecoder::new(&deflated[..]).read_to_end(&mut bytes).expect("inflated");
        let (mut at, mut wide, mut narrow) = (0, vec![vec![0_u16; 4000]; 4], vec![vec![0_u8; 4000]; 4]);
        for shot in &shots {
            let (solid, water) = (&shot.frame.solid, &shot.frame.water);
            for (list, count) in [(0, solid.len()), (1, solid.len())] {
                take_wide(&bytes, &mut at, &mut wide[list], count);
            }
            for values in &mut narrow {
                for value in values.iter_mut().take(solid.len()) {
                    *value = value.wrapping_add(unfold(u16::from(bytes[at])) as u8);
                    at += 1;
                }
            }
            for (list, count) in [(2, water.len()), (3, water.len())] {
                take_wide(&bytes, &mut at, &mut wide[list], count);
            }
            let mut sorted: Vec<_> = solid.iter().collect();
            sorted.sort_by_key(|p| p.id);
            for (k, p) in sorted.iter().enumerate() {
                let x = window[0] + f64::from(wide[0][k]) / 65_535.0 * (window[2] - window[0]);
                assert!((x - p.x[0]).abs() < 2e-4);
                for (number, (quantity, range)) in quantity::ALL.iter().zip(&ranges).enumerate() {
                    let value = (quantity.of)(p).clamp(range.0, range.1);
                    assert!((f64::from(narrow[number][k]) / 255.0 * range.1 - value).abs() <= 0.51 / 255.0 * range.1);
                }
            }
            for (k, p) in water.iter().enumerate() {
                let y = window[1] + f64::from(wide[3][k]) / 65_535.0 * (window[3] - window[1]);
                assert!((y - p.x[1]).abs() < 2e-4);
            }
        }
        assert_eq!(at, bytes.len());
    }

    fn take_wide(bytes: &[u8], at: &mut usize, list: &mut [u16], count: usize) {
        for k in 0..count {
            let folded = u16::from_le_bytes([bytes[*at + k], bytes[*at + count + k]]);
            list[k] = list[k].wrapping_add(unfold(folded) as u16);
        }
        *at += 2 * count;
    }

    #[test]
    fn a_shot_that_repeats_costs_next_to_nothing() {
        let shots = made_up::shots(2, 0);
        let (window, ranges) = ([0.0, 0.0, 12.0, 4.0], vec![(0.0, 1.0); quantity::ALL.len()]);
        let once = Packed::new(&window, &ranges, &[&shots[0]]).expect("packed").deflated.len();
        let often = Packed::new(&window, &ranges, &[&shots[0]; 20]).expect("packed").deflated.len();
        assert!(often < once + 19 * 100, "{once} {often}");
    }
}
