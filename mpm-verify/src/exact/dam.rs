//! Steady seepage through a rectangular dam: discharge, exit point, free surface, pressure at the base, stored water.
//!
//! Assumptions: homogeneous isotropic dam of length l on a level impermeable base, upright faces, water levels H1 > H2 >= 0
//! beside it, no capillarity, no rain, Darcy's law, steady. Discharge: `q = k (H1^2 - H2^2)/(2 l)`, exactly (Charny).
//!
//! The mapping, derived anew: with the complex potential W = -k h + i psi, the velocity u - i v = dW/dz lies in a region
//! bounded by v = 0 (both faces under water, and the base), v = -k (the seepage face) and the circle
//! u^2 + v^2 + k v = 0 (the free surface). It touches itself in three corners of angle zero, so that the modular function
//! maps it: `dW/dz = k K(1 - m)/K(m)` for m in the upper half plane, K the complete elliptic integral. The corners of
//! the dam are m = 1 (inlet, at H1), b and a with 0 <= a < b < 1 (base, inlet and outlet side), 0 (outlet, at H2), infinity
//! (exit point). dz/dm = K(m) g(m) and dW/dm = k K(1 - m) g(m), where g must turn by a right angle in m = a, b, 1 and
//! nowhere else: `g = C/sqrt((1 - m)(b - m)(m - a))`. All lengths are integrals of it between corners:
//!
//! - `l = C int_a^b K(m) |g| dm`, `H1 = C int_b^1`, `H2 = C int_0^a`, seepage face `C int_-inf^0`, with the same integrand;
//! - base: `x = C int_m^b K |g| dm`, `H1 - h = C int_m^b K(1 - m) |g| dm`;
//! - free surface, t = 1/m from 1 to 0: `dx = C K(t) dt/r`, `dy = -C K(1 - t) dt/r`, `r = sqrt((1 - t)(1 - b t)(1 - a t))`.
//!
//! H2/H1 and l/H1 give a and b. That H1 less the fall of the free surface is H2 and the seepage face, that its run is l
//! and that the head falls by H1 - H2 over the base is not used: the tests check it.
//!
//! Sources: Polubarinova-Kochina, *Theory of Ground Water Movement*, 1962, chapter VII; Charny 1951, Dokl. Akad. Nauk 79.

use std::f64::consts::{FRAC_PI_2, LN_2};

use super::elliptic::complete;
use super::quadrature::integral;
use super::root::root;

/// A dam with its mapping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dam {
    /// Water level on the inlet side H1, m.
    pub upstream: f64,
    /// Water level on the outlet side H2, m.
    pub downstream: f64,
    /// Length of the dam along the flow l, m.
    pub length: f64,
    corners: Corners,
    /// Length C of the mapping, m.
    scale: f64,
}

/// The corners of the base in the m-plane: b = B/(1 + B), a = A/(1 + A) with B = exp(`log_b`), A = B r/(1 + r).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corners {
    a: f64,
    b: f64,
    /// 1 - a.
    a_rest: f64,
    /// 1 - b: for a long dam b is one to all digits.
    b_rest: f64,
    /// b - a.
    gap: f64,
}

impl Corners {
    fn new(log_b: f64, r: f64) -> Self {
        let large_b = log_b.exp();
        let large_a = large_b * r / (1.0 + r);
        let (a_rest, b_rest) = (1.0 / (1.0 + large_a), 1.0 / (1.0 + large_b));
        let gap = large_b / (1.0 + r) * a_rest * b_rest;
        Self { a: large_a * a_rest, b: large_b * b_rest, a_rest, b_rest, gap }
    }

    /// l/C, with m = a sin^2 + b cos^2 of an angle.
    fn length(&self) -> f64 {
        self.base(FRAC_PI_2).0
    }

    /// Base from its inlet side to an angle counted from there, over C: (x, H1 - h).
    fn base(&self, end: f64) -> (f64, f64) {
        // m, 1 - m; without water at the outlet m ends at zero and must keep its digits there.
        let place = |angle: f64, to_end: f64| {
            let m = self.a + self.gap * (to_end + (FRAC_PI_2 - end)).sin().powi(2);
            (m, self.b_rest + self.gap * angle.sin().powi(2))
        };
        let part = |k: fn(f64, f64) -> f64| {
            let step = |angle: f64, to_end: f64| {
                let (m, rest) = place(angle, to_end);
                2.0 * k(m, rest) / rest.sqrt()
            };
            integral(step, 0.0, end)
        };
        (part(|_, rest| complete(rest)), part(|m, _| complete(m)))
    }

    /// H1/C, with 1 - m = (1 - b) sin^2 of an angle.
    fn upstream(&self) -> f64 {
        let part = |angle: f64, to_end: f64| {
            2.0 * complete(self.b_rest * angle.sin().powi(2)) / (self.gap + self.b_rest * to_end.sin().powi(2)).sqrt()
        };
        integral(part, 0.0, FRAC_PI_2)
    }

    /// H2/C, with m = a (1 - s^2).
    fn downstream(&self) -> f64 {
        if self.a == 0.0 {
            return 0.0;
        }
        let part = |s: f64, _| {
            let rest = self.a_rest + self.a * s * s;
            2.0 * self.a.sqrt() * complete(rest) / (rest * (self.gap + self.a * s * s)).sqrt()
        };
        integral(part, 0.0, 1.0)
    }

    /// Height of the seepage face over C, with -m = s^2/(1 - s^2).
    fn seepage_face(&self) -> f64 {
        let part = |s: f64, to_end: f64| {
            let (t, rest) = (s * s, to_end * (1.0 + s));
            2.0 * s * complete(rest) / ((self.b * rest + t) * (self.a * rest + t)).sqrt()
        };
        integral(part, 0.0, 1.0)
    }

    /// A step of the free surface at an angle, given by sine and cosine, over C: (dx, -dy). t = sin^2 of the angle.
    fn surface(&self, sin: f64, cos: f64) -> (f64, f64) {
        let root = ((self.b_rest + self.b * cos * cos) * (self.a_rest + self.a * cos * cos)).sqrt();
        (2.0 * sin * complete(cos * cos) / root, 2.0 * sin * complete(sin * sin) / root)
    }
}

// Angles of the free surface are counted from the inlet (t = 1) to the exit point (t = 0).
impl Dam {
    /// A dam; `None` unless `upstream` > `downstream` >= 0 and `length` > 0, all in m and finite, and where the corners
    /// of the mapping come too close together: l/H1 or q/(k H1) below about 0.06.
    pub fn new(upstream: f64, downstream: f64, length: f64) -> Option<Self> {
        if !(upstream > downstream && downstream >= 0.0 && length > 0.0 && upstream.is_finite() && length.is_finite()) {
            return None;
        }
        let share = downstream / upstream;
        let at = |log_b: f64| corners(log_b, share);
        let longer = |log_b: f64| at(log_b).map_or(f64::NAN, |c| c.length() / c.upstream() - length / upstream);
        // Narrow the bracket first: far out the mapping has no digits left.
        let guess = (-12..=11).map(|k| f64::from(k) * 5.0).find(|log_b| longer(*log_b) > 0.0)?;
        let corners = at(root(longer, guess - 5.0, guess)?)?;
        Some(Self { upstream, downstream, length, corners, scale: upstream / corners.upstream() })
    }

    /// Discharge for a conductivity k (m/s), m2/s for a metre of width.
    pub fn discharge(&self, conductivity: f64) -> f64 {
        conductivity * (self.upstream.powi(2) - self.downstream.powi(2)) / (2.0 * self.length)
    }

    /// Height of the exit point above the base, m.
    pub fn exit_height(&self) -> f64 {
        self.downstream + self.seepage_face()
    }

    /// Height of the seepage face, m.
    pub fn seepage_face(&self) -> f64 {
        self.scale * self.corners.seepage_face()
    }

    /// Height of the free surface at `x` (m) from the inlet, m.
    pub fn surface(&self, x: f64) -> f64 {
        if x <= 0.0 || x >= self.length {
            return if x <= 0.0 { self.upstream } else { self.exit_height() };
        }
        let angle = root(|angle| self.run(angle) - x, 0.0, FRAC_PI_2);
        self.height(angle.unwrap_or(FRAC_PI_2))
    }

    /// Pressure head at the base at `x` (m) from the inlet, m of water.
    pub fn base_head(&self, x: f64) -> f64 {
        if x <= 0.0 || x >= self.length {
            return if x <= 0.0 { self.upstream } else { self.downstream };
        }
        let place = |angle: f64| self.scale * self.corners.base(angle).0;
        let angle = root(|angle| place(angle) - x, 0.0, FRAC_PI_2).unwrap_or(FRAC_PI_2);
        self.upstream - self.scale * self.corners.base(angle).1
    }

    /// Water in the dam of porosity n, m2 for a metre of width: n times the area under the free surface.
    pub fn stored(&self, porosity: f64) -> f64 {
        let part = |angle: f64, to_end: f64| self.height(angle) * self.corners.surface(to_end.sin(), angle.sin()).0;
        porosity * self.scale * integral(part, 0.0, FRAC_PI_2)
    }

    /// Dupuit's parabola at `x` (m), m: the free surface of a flow that is level everywhere, for comparison.
    pub fn dupuit(&self, x: f64) -> f64 {
        let (high, low) = (self.upstream.powi(2), self.downstream.powi(2));
        (high - (high - low) * x / self.length).sqrt()
    }

    /// Way of the free surface along x up to an angle from the inlet, m.
    fn run(&self, end: f64) -> f64 {
        // sin(pi/2 - angle) = cos(angle): near the inlet its complement sin(angle) keeps its digits.
        self.scale * integral(|angle, _| self.corners.surface(angle.cos(), angle.sin()).0, 0.0, end)
    }

    /// Height of the free surface at an angle from the inlet, m.
    fn height(&self, end: f64) -> f64 {
        let rest = FRAC_PI_2 - end;
        let step = |angle: f64, to_end: f64| self.corners.surface((to_end + rest).sin(), angle.sin()).1;
        self.upstream - self.scale * integral(step, 0.0, end)
    }
}

/// The corners of a dam whose H2 is `share` of H1, for a given b.
fn corners(log_b: f64, share: f64) -> Option<Corners> {
    if share == 0.0 {
        return Some(Corners::new(log_b, 0.0));
    }
    let off = |doublings: f64| {
        let corners = Corners::new(log_b, (doublings * LN_2).exp());
        corners.downstream() / corners.upstream() - share
    };
    Some(Corners::new(log_b, (root(off, -200.0, 200.0)? * LN_2).exp()))
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    /// The dams of the tables.
    fn dams() -> Vec<(Dam, f64)> {
        let rows = Table::read("08_dam_summary.csv").rows(["H1_m", "H2_m", "l_m", "exit_height_m"]);
        rows.into_iter().map(|[high, low, length, exit]| (Dam::new(high, low, length).expect("a dam"), exit)).collect()
    }

    #[test]
    fn exit_heights_and_discharges_agree_with_the_independent_table() {
        let discharges = Table::read("08_dam_summary.csv").rows(["q_m2_s"]);
        for ((dam, exit), [discharge]) in dams().into_iter().zip(discharges) {
            let error = dam.exit_height() / exit - 1.0;
            assert!(error.abs() < 1e-12, "{error:.1e}");
            assert!((dam.discharge(5e-4) / discharge - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn free_surface_and_base_agree_with_the_independent_tables() {
        let names = ["x_m", "free_surface_y_m", "base_pressure_head_m", "dupuit_parabola_m"];
        for (case, (dam, _)) in dams().into_iter().enumerate() {
            for [x, surface, head, parabola] in Table::read(&format!("08_dam_case{case}.csv")).rows(names) {
                let errors = [dam.surface(x) - surface, dam.base_head(x) - head, dam.dupuit(x) - parabola];
                assert!(errors.iter().all(|e| e.abs() < 1e-10 * dam.upstream), "case {case}, x = {x}: {errors:?}");
            }
        }
    }

    #[test]
    fn the_mapping_closes() {
        // None of these was used to find it.
        for (high, low, length) in
            [(1.0, 0.0, 0.08), (1.0, 0.0, 8.0), (3.0, 1.0, 9.0), (1.0, 0.9, 1.0), (2.0, 1e-3, 1.0)]
        {
            let dam = Dam::new(high, low, length).unwrap_or_else(|| panic!("{high} {low} {length}"));
            let close = |found: f64, wanted: f64| {
                assert!((found - wanted).abs() < 1e-11 * high, "{high} {low} {length}: {found} {wanted}");
            };
            close(dam.scale * dam.corners.length(), length);
            close(dam.scale * dam.corners.downstream(), low);
            close(dam.run(FRAC_PI_2), length);
            close(dam.height(FRAC_PI_2), dam.exit_height());
            close(dam.scale * dam.corners.base(FRAC_PI_2).1, high - low);
        }
    }

    #[test]
    fn stored_water_lies_between_the_parabola_and_the_levels() {
        let (dam, _) = dams()[1];
        // The trapezoidal rule on the table, of second order away from the inlet.
        let rows = Table::read("08_dam_case1.csv").rows(["x_m", "free_surface_y_m"]);
        let area: f64 = rows.windows(2).map(|w| 0.5 * (w[1][0] - w[0][0]) * (w[1][1] + w[0][1])).sum();
        assert!((dam.stored(0.3) / (0.3 * area) - 1.0).abs() < 1e-4);
        let parabola = integral(|x, _| dam.dupuit(x), 0.0, 1.0);
        assert!(dam.stored(1.0) > parabola && dam.stored(1.0) < 1.0);
    }

    #[test]
    fn what_is_no_dam_is_refused() {
        for (high, low, length) in [(1.0, 1.0, 1.0), (1.0, -0.1, 1.0), (1.0, 0.0, 0.0), (f64::NAN, 0.0, 1.0)] {
            assert!(Dam::new(high, low, length).is_none());
        }
    }
}
