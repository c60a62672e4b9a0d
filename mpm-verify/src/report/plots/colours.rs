//! Colours of a quantity: dark is little, light is much, also in black and white and for colour-blind readers.
//!
//! The map is viridis (Smith & van der Walt 2015, in the public domain under CC0), between ten of its colours.

use plotters::style::RGBColor;

/// The map at equal distances from its start to its end.
const STOPS: [RGBColor; 10] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 40, 120),
    RGBColor(62, 74, 137),
    RGBColor(49, 104, 142),
    RGBColor(38, 130, 142),
    RGBColor(31, 158, 137),
    RGBColor(53, 183, 121),
    RGBColor(109, 205, 89),
    RGBColor(180, 222, 44),
    RGBColor(253, 231, 37),
];

/// The colour at a place between the start (0) and the end (1) of the map; beyond them that of the end.
pub fn at(place: f64) -> RGBColor {
    let along = place.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let stop = (along as usize).min(STOPS.len() - 2);
    let (from, to, share) = (STOPS[stop], STOPS[stop + 1], along - stop as f64);
    let mixed = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mixed(from.0, to.0), mixed(from.1, to.1), mixed(from.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_runs_from_dark_to_light() {
        assert_eq!((at(-1.0), at(0.0), at(1.0), at(2.0)), (STOPS[0], STOPS[0], STOPS[9], STOPS[9]));
        let light = |c: RGBColor| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let steps: Vec<f64> = (0..=50).map(|k| light(at(f64::from(k) / 50.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]), "{steps:?}");
    }
}
