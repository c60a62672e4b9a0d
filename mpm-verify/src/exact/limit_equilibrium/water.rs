//! Pore pressure below a phreatic line.
//!
//! Two readings of the same line. Hydrostatic: equipotentials are vertical, `u = gamma_w (h - y)`; exact for water at
//! rest, Dupuit's assumption for seepage, and too high below an inclined line. Parallel: the flow near the line
//! follows it, equipotentials are normal to it, `u = gamma_w (h - y) cos^2(theta)` with its inclination theta; exact
//! in an infinite slope with seepage along it, doubtful where the water turns to leave the slope.

/// A water surface in a slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phreatic<'a> {
    /// Points (x, y) of the line, m, x increasing; beyond its ends it goes on level. Empty: no water.
    pub line: &'a [[f64; 2]],
    /// Surface of the ground (x, y), m, x increasing. Where the line is above it, the ground is the water surface: a
    /// seepage face.
    pub ground: &'a [[f64; 2]],
    /// Unit weight of water gamma_w, N/m3.
    pub water_weight: f64,
}

impl Phreatic<'_> {
    /// Height y (m) of the water surface at x (m); minus infinity without water.
    pub fn level(&self, x: f64) -> f64 {
        if self.line.is_empty() { f64::NEG_INFINITY } else { along(self.line, x).min(along(self.ground, x)) }
    }

    /// Pore pressure (Pa) at (x, y), m: `gamma_w max(0, h(x) - y)`.
    pub fn hydrostatic(&self, x: f64, y: f64) -> f64 {
        self.water_weight * (self.level(x) - y).max(0.0)
    }

    /// Pore pressure (Pa) at (x, y), m, of seepage parallel to the water surface: the hydrostatic one times the
    /// squared cosine of the inclination of the surface above it, as in an infinite slope (Taylor, *Fundamentals of
    /// Soil Mechanics*, 1948).
    pub fn parallel(&self, x: f64, y: f64) -> f64 {
        if self.line.is_empty() {
            return 0.0;
        }
        let governs = if along(self.line, x) <= along(self.ground, x) { self.line } else { self.ground };
        let slope = slope(governs, x);
        self.hydrostatic(x, y) / (1.0 + slope * slope)
    }
}

/// Height of a line at x, m; beyond its ends as at them.
pub fn along(line: &[[f64; 2]], x: f64) -> f64 {
    let (first, last) = (line[0], line[line.len() - 1]);
    if x <= first[0] {
        return first[1];
    }
    if x >= last[0] {
        return last[1];
    }
    let start = line[line.partition_point(|point| point[0] <= x) - 1];
    start[1] + slope(line, x) * (x - start[0])
}

/// Slope dy/dx of a line at x; zero beyond its ends.
pub fn slope(line: &[[f64; 2]], x: f64) -> f64 {
    let next = line.partition_point(|point| point[0] <= x);
    if next == 0 || next == line.len() {
        return 0.0;
    }
    let ([x0, y0], [x1, y1]) = (line[next - 1], line[next]);
    (y1 - y0) / (x1 - x0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: [[f64; 2]; 3] = [[0.0, 4.0], [2.0, 4.0], [10.0, 0.0]];

    #[test]
    fn the_line_ends_at_the_ground_and_goes_on_level() {
        let water = Phreatic { line: &[[0.0, 3.0], [6.0, 1.5]], ground: &GROUND, water_weight: 10.0 };
        assert_eq!([-1.0, 0.0, 4.0, 6.0, 7.0].map(|x| water.level(x)), [3.0, 3.0, 2.0, 1.5, 1.5]);
        // Above the ground from x = 7 on: a seepage face.
        assert_eq!(water.level(9.0), 0.5);
        assert_eq!([water.hydrostatic(4.0, 1.0), water.hydrostatic(4.0, 2.5)], [10.0, 0.0]);
    }

    #[test]
    fn seepage_along_an_inclined_line_has_less_pressure_than_water_at_rest() {
        let water = Phreatic { line: &[[0.0, 3.0], [6.0, 0.0]], ground: &GROUND, water_weight: 10.0 };
        let cos2 = 0.5_f64.atan().cos().powi(2);
        assert!((water.parallel(2.0, 1.0) - 10.0 * cos2).abs() < 1e-13);
        let level = Phreatic { line: &[[0.0, 3.0], [6.0, 3.0]], ..water };
        assert_eq!(level.parallel(2.0, 1.0), level.hydrostatic(2.0, 1.0));
        // On a seepage face the ground is the water surface.
        let high = Phreatic { line: &[[0.0, 9.0]], ..water };
        assert!((high.parallel(6.0, 1.0) - 10.0 * cos2).abs() < 1e-13);
        let dry = Phreatic { line: &[], ..water };
        assert_eq!([dry.hydrostatic(1.0, 0.0), dry.parallel(1.0, 0.0)], [0.0, 0.0]);
    }
}
