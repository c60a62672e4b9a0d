//! A sharp wetting front that moves into dry soil from a face under a constant head.
//!
//! Assumptions: rigid homogeneous soil, saturated behind the front and at its initial saturation before it, pressure
//! zero at the front (no capillarity, free air), Darcy's law, no inertia, incompressible water. Then the head h of the
//! inlet, and the weight of the water over the wetted length x, are spent on that length: `n_f dx/dt = k (h/x + s)`
//! with s = 0 for horizontal flow, 1 downwards, -1 upwards, and n_f = n (1 - S_0) the pore space to be filled. So
//!
//! - horizontal: `x = sqrt(2 k h t/n_f)`;
//! - down: `t = (n_f/k) [x - h ln(1 + x/h)]`;
//! - up: `t = (n_f/k) [-x - h ln(1 - x/h)]`, which ends at x = h.
//!
//! Without inertia the front starts infinitely fast: an early time, k h/(n x) against sqrt(2 g h), is no place to compare.
//!
//! Source: Green & Ampt 1911, Journal of Agricultural Science 4(1), doi:10.1017/S0021859600001441.

use super::root::root;

/// Where the water goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Level.
    Horizontal,
    /// With its weight.
    Down,
    /// Against its weight.
    Up,
}

/// A front on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WettingFront {
    /// Where it goes.
    pub way: Way,
    /// Hydraulic conductivity k, m/s.
    pub conductivity: f64,
    /// Pressure head h at the inlet, m of water.
    pub head: f64,
    /// Porosity n.
    pub porosity: f64,
    /// Saturation S_0 ahead of the front.
    pub initial_saturation: f64,
}

impl WettingFront {
    /// Pore space that a unit of advance fills, n (1 - S_0).
    pub fn fillable(&self) -> f64 {
        self.porosity * (1.0 - self.initial_saturation)
    }

    /// Time (s) at which the front is `place` (m) from the inlet; infinite where it never comes.
    pub fn time(&self, place: f64) -> f64 {
        self.time_scale() * scaled_time(self.way, place / self.head)
    }

    /// Distance of the front from the inlet at a time (s), m.
    ///
    /// # Panics
    /// Never for positive head, conductivity and pore space and a time that is a number, zero or more.
    pub fn position(&self, time: f64) -> f64 {
        let t = time / self.time_scale();
        // The level front is behind the one that falls and before the one that judged. Falling: y < sqrt(2 t) + t
        // (Chatzigeorgiou 2013, IEEE Communications Letters 17(8)).
        let level = (2.0 * t).sqrt();
        let (low, high) = match self.way {
            Way::Horizontal => return self.head * level,
            Way::Down => (level, level + t),
            Way::Up => (0.0, level.min(1.0)),
        };
        let ahead = |y: f64| scaled_time(self.way, y) - t;
        // Ends that meet to round-off: nothing is left to find.
        self.head * root(ahead, low, high).unwrap_or(if self.way == Way::Up { high } else { low })
    }

    /// Speed of the front when it is at `place` (m), m/s.
    pub fn velocity(&self, place: f64) -> f64 {
        self.conductivity / self.fillable() * (self.head / place + self.weight())
    }

    /// Water that enters a unit of the inlet when the front is at `place` (m), m/s.
    pub fn inflow(&self, place: f64) -> f64 {
        self.fillable() * self.velocity(place)
    }

    /// Time n_f h/k, s.
    fn time_scale(&self) -> f64 {
        self.fillable() * self.head / self.conductivity
    }

    /// Share of its weight that drives the water.
    fn weight(&self) -> f64 {
        match self.way {
            Way::Horizontal => 0.0,
            Way::Down => 1.0,
            Way::Up => -1.0,
        }
    }
}

/// k t/(n_f h) of a front at y = x/h.
fn scaled_time(way: Way, y: f64) -> f64 {
    match way {
        Way::Horizontal => 0.5 * y * y,
        Way::Down => less_logarithm(y),
        Way::Up if y >= 1.0 => f64::INFINITY,
        Way::Up => less_logarithm(-y),
    }
}

/// y - ln(1 + y), also where the two cancel.
fn less_logarithm(y: f64) -> f64 {
    if y.abs() > 0.1 {
        return y - y.ln_1p();
    }
    // y^2/2 - y^3/3 + ...: 17 terms for the last digit at 0.1, summed from the smallest.
    (2..=18).rev().fold(0.0, |sum, power| (1.0 / f64::from(power) - sum) * y) * y
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    fn front(way: Way, head: f64) -> WettingFront {
        WettingFront { way, conductivity: 5e-4, head, porosity: 0.3, initial_saturation: 0.0 }
    }

    #[test]
    fn agrees_with_the_independent_tables() {
        for (name, head) in [("07_green_ampt_h1.csv", 1.0), ("07_green_ampt_h0.25.csv", 0.25)] {
            // Upwards the table loses digits near the inlet, where x and h ln(1 - x/h) cancel.
            for (way, x, q, allowed) in [
                (Way::Horizontal, "x_horizontal_m", "q_horizontal_m_s", 1e-14),
                (Way::Down, "x_down_m", "q_down_m_s", 1e-14),
                (Way::Up, "x_up_m", "q_up_m_s", 2e-12),
            ] {
                let front = front(way, head);
                for [time, place, inflow] in Table::read(name).rows(["t_s", x, q]) {
                    let errors = [
                        front.position(time) / place - 1.0,
                        (front.inflow(place) - inflow) / front.conductivity / 50.0,
                        // Near its end the digits of a climbing front's place do not hold its time.
                        if place < 0.9 * head { 0.5 * (front.time(place) / time - 1.0) } else { 0.0 },
                    ];
                    assert!(errors.iter().all(|e| e.abs() < allowed), "{way:?}, {time} s: {errors:?}");
                }
            }
        }
    }

    #[test]
    fn the_speed_is_that_of_the_place() {
        for way in [Way::Horizontal, Way::Down, Way::Up] {
            let front = front(way, 1.0);
            let (time, step) = (300.0, 1e-2);
            let slope = (front.position(time + step) - front.position(time - step)) / (2.0 * step);
            assert!((front.velocity(front.position(time)) / slope - 1.0).abs() < 1e-8, "{way:?}");
        }
    }

    #[test]
    fn wet_soil_is_filled_sooner() {
        let dry = front(Way::Down, 1.0);
        let wet = WettingFront { initial_saturation: 0.6, ..dry };
        assert!((wet.position(40.0) - dry.position(100.0)).abs() < 1e-14);
    }

    #[test]
    fn the_climbing_front_stops_where_the_head_is_spent() {
        let front = front(Way::Up, 0.25);
        assert_eq!(front.time(0.25), f64::INFINITY);
        assert!((front.position(1e6) - 0.25).abs() < 1e-15 && front.position(0.0) == 0.0);
    }
}
