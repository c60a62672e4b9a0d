//! Frames as few bytes: two for a coordinate, one for a value in the range of its colours.
//!
//! A frame is, for its solid particles, x and y as numbers of two bytes (low byte first, 0 to 65535 over the window),
//! then a byte per particle for each quantity; for its water particles x and y alike.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use crate::frames::Shot;
use crate::report::plots::levee::Site;
use crate::report::plots::levee::map::Window;
use crate::report::quantity;

/// What the page holds of a run.
pub struct Packed<'a> {
    /// Left, lower, right and upper end of what is shown, m.
    pub window: [f64; 4],
    /// Values at the ends of the colours, for each of [`quantity::ALL`].
    pub ranges: Vec<(f64, f64)>,
    /// The frames that are held.
    pub shots: Vec<&'a Shot>,
    /// Of how many frames one is held.
    pub every: usize,
    bytes: Vec<u8>,
}

impl<'a> Packed<'a> {
    /// The frames in at most so many bytes of text; if they are more, every second, third, ... and the last.
    pub fn new(site: &Site, shots: &'a [Shot], most: usize) -> Self {
        let window = Window::of(site, shots).ends();
        let ranges: Vec<(f64, f64)> = quantity::ALL.iter().map(|q| q.range(shots)).collect();
        let all: usize = shots.iter().map(room).sum();
        // Text has four letters for three bytes.
        let every = (4 * all).div_ceil(3 * most).max(1);
        let last = shots.len().saturating_sub(1);
        let held = |(k, shot): (usize, &'a Shot)| ((last - k).is_multiple_of(every)).then_some(shot);
        let shots: Vec<&Shot> = shots.iter().enumerate().filter_map(held).collect();
        let mut bytes = Vec::with_capacity(all / every);
        for shot in &shots {
            put(shot, &window, &ranges, &mut bytes);
        }
        Self { window, ranges, shots, every, bytes }
    }

    /// The bytes as text.
    pub fn text(&self) -> String {
        BASE64_STANDARD.encode(&self.bytes)
    }
}

/// Bytes of a frame.
fn room(shot: &Shot) -> usize {
    shot.frame.solid.len() * (4 + quantity::ALL.len()) + shot.frame.water.len() * 4
}

fn put(shot: &Shot, window: &[f64; 4], ranges: &[(f64, f64)], bytes: &mut Vec<u8>) {
    let [left, low, right, high] = *window;
    let place = |x: [f64; 2], bytes: &mut Vec<u8>| {
        for share in [share(x[0], (left, right)), share(x[1], (low, high))] {
            bytes.extend(((share * 65_535.0).round() as u16).to_le_bytes());
        }
    };
    shot.frame.solid.iter().for_each(|p| place(p.x, bytes));
    for (quantity, range) in quantity::ALL.iter().zip(ranges) {
        bytes.extend(shot.frame.solid.iter().map(|p| (share((quantity.of)(p), *range) * 255.0).round() as u8));
    }
    shot.frame.water.iter().for_each(|p| place(p.x, bytes));
}

/// Where a value is in a range, 0 to 1; what is no number is at its start.
fn share(value: f64, (low, high): (f64, f64)) -> f64 {
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    if share.is_finite() { share } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn places_and_values_come_back_as_the_page_reads_them() {
        let site = Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 };
        let shots = made_up::shots(1, 2);
        let packed = Packed::new(&site, &shots, 1_000_000);
        assert_eq!((packed.shots.len(), packed.every), (3, 1));
        let bytes = BASE64_STANDARD.decode(packed.text()).expect("text of bytes");
        assert_eq!(bytes.len(), shots.iter().map(room).sum::<usize>());
        let [left, low, right, high] = packed.window;
        let start = room(&shots[0]) + room(&shots[1]);
        let solid = &shots[2].frame.solid;
        let two = |at: usize| f64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])) / 65_535.0;
        for (k, p) in solid.iter().enumerate() {
            let x = [left + two(start + 4 * k) * (right - left), low + two(start + 4 * k + 2) * (high - low)];
            assert!((x[0] - p.x[0]).abs() < 2e-4 && (x[1] - p.x[1]).abs() < 2e-4);
            for (number, (quantity, range)) in quantity::ALL.iter().zip(&packed.ranges).enumerate() {
                let byte = bytes[start + (4 + number) * solid.len() + k];
                let value = (quantity.of)(p).clamp(range.0, range.1);
                assert!((f64::from(byte) / 255.0 * range.1 - value).abs() <= 0.51 / 255.0 * range.1);
            }
        }
        let water = start + 8 * solid.len();
        let x = left + two(water) * (right - left);
        assert!((x - shots[2].frame.water[0].x[0]).abs() < 2e-4);
    }

    #[test]
    fn the_last_frame_is_always_held() {
        let site = Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 };
        let shots = made_up::shots(4, 4);
        let packed = Packed::new(&site, &shots, 45_000);
        assert!(packed.every > 1 && packed.text().len() < 60_000);
        assert_eq!(packed.shots.last().map(|s| s.time_s), shots.last().map(|s| s.time_s));
    }
}
