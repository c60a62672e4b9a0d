//! Water that spreads in an aquifer on a level base: the wetting of a dry one, and the mound of a sudden release.
//!
//! Assumptions: level impermeable base, homogeneous soil, a sharp free surface (no capillarity), pressures hydrostatic over
//! the height (Dupuit), so `n h_t = k (h h_x)_x`; no inertia. Dupuit's assumption is no part of a computation in two
//! dimensions: compare one only where the front is many heights away.
//!
//! Wetting from a face held at H: `h = H lambda^2 F(1 - x/x_f)`, `x_f = lambda sqrt(k H t/n)`, where F solves
//! `(F F')' = (1 - s) F'/2` with F(0) = 0 in the distance s from the front. Its power series begins with s/2 and converges
//! up to the face, where it gives lambda = F(1)^(-1/2) = 1.6161254468.
//!
//! Mound of the area A (pore space included): `h = n (x_f^2 - x^2)/(6 k t)`, `x_f = (9 k A t/(2 n))^(1/3)`.
//!
//! Sources: Boussinesq 1904, J. Math. Pures Appl. 10; Polubarinova-Kochina, *Theory of Ground Water Movement*, 1962;
//! mound: Barenblatt 1952, Prikl. Mat. Mekh. 16.

/// Terms of the series; the last ones are below 1e-30.
const TERMS: usize = 60;

/// A dry aquifer wetted from the face x = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Wetting {
    conductivity: f64,
    porosity: f64,
    head: f64,
    /// Coefficients of F: `series[j]` belongs to s^j.
    series: Vec<f64>,
}

impl Wetting {
    /// An aquifer of conductivity k (m/s) and porosity n whose face is held at the height H (m).
    pub fn new(conductivity: f64, porosity: f64, head: f64) -> Self {
        Self { conductivity, porosity, head, series: series() }
    }

    /// The number lambda = x_f/sqrt(k H t/n).
    pub fn lambda(&self) -> f64 {
        self.series.iter().sum::<f64>().sqrt().recip()
    }

    /// Distance of the front from the face at a time (s), m.
    pub fn front(&self, time: f64) -> f64 {
        self.lambda() * (self.conductivity * self.head * time / self.porosity).sqrt()
    }

    /// Height of the free surface at `x` (m) from the face at a time (s), m; zero ahead of the front.
    pub fn height(&self, x: f64, time: f64) -> f64 {
        let s = 1.0 - x / self.front(time);
        if s <= 0.0 {
            return 0.0;
        }
        let sum = self.series.iter().rev().fold(0.0, |sum, a| sum * s + a);
        self.head * self.lambda().powi(2) * sum
    }

    /// Water that enters through the face at a time (s), m2/s for a metre of width.
    pub fn inflow(&self, time: f64) -> f64 {
        let slope: f64 = self.series.iter().enumerate().map(|(j, a)| j as f64 * a).sum();
        self.conductivity * self.head.powi(2) * self.lambda().powi(2) * slope / self.front(time)
    }

    /// Water that has entered by a time (s), m2: n times the area under the free surface.
    pub fn stored(&self, time: f64) -> f64 {
        // The inflow falls with 1/sqrt(t).
        2.0 * self.inflow(time) * time
    }
}

/// Coefficients of F, from (F^2)'' = (1 - s) F' order by order.
fn series() -> Vec<f64> {
    let mut a = vec![0.0; TERMS];
    a[1] = 0.5;
    for n in 1..TERMS - 1 {
        // Of s^(n+2) in F^2, all but the two products with a[n + 1] a[1], which stand on the left.
        let known: f64 = (2..=n).map(|i| a[i] * a[n + 2 - i]).sum();
        let m = n as f64;
        a[n + 1] = -(m * a[n] + (m + 2.0) * (m + 1.0) * known) / ((m + 1.0) * (m + 1.0));
    }
    a
}

/// Water released at x = 0 at t = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mound {
    /// Hydraulic conductivity k, m/s.
    pub conductivity: f64,
    /// Porosity n.
    pub porosity: f64,
    /// Area under the free surface A, m2: of the wet soil, so that n A is water.
    pub area: f64,
}

impl Mound {
    /// Distance of either front from the middle at a time (s), m.
    pub fn front(&self, time: f64) -> f64 {
        (4.5 * self.conductivity * self.area * time / self.porosity).cbrt()
    }

    /// Height of the free surface at `x` (m) from the middle at a time (s), m.
    pub fn height(&self, x: f64, time: f64) -> f64 {
        let front = self.front(time);
        (self.porosity * (front * front - x * x) / (6.0 * self.conductivity * time)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    fn wetting() -> Wetting {
        Wetting::new(5e-4, 0.3, 1.0)
    }

    #[test]
    fn the_front_and_what_flows_in_agree_with_the_independent_table() {
        let wetting = wetting();
        assert!((wetting.lambda() / 1.616_125_446_804_603_7 - 1.0).abs() < 1e-15, "{}", wetting.lambda());
        let names = ["t_s", "x_front_m", "q_inlet_m2_s", "volume_under_h_m2"];
        for [time, front, inflow, area] in Table::read("09_boussinesq_front.csv").rows(names) {
            assert!((wetting.front(time) / front - 1.0).abs() < 1e-14);
            assert!((wetting.inflow(time) / inflow - 1.0).abs() < 1e-14);
            assert!((wetting.stored(time) / (0.3 * area) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_profile_agrees_with_the_independent_table() {
        let (wetting, time) = (wetting(), 1234.5);
        for [place, height] in Table::read("09_boussinesq_profile.csv").rows(["x_over_xf", "h_over_H"]) {
            let found = wetting.height(place * wetting.front(time), time);
            assert!((found - height).abs() < 1e-14, "{place}: {found} {height}");
        }
        assert_eq!(wetting.height(1.001 * wetting.front(time), time), 0.0);
    }

    #[test]
    fn what_has_entered_lies_under_the_free_surface() {
        let (wetting, time) = (wetting(), 500.0);
        let front = wetting.front(time);
        let area = super::super::quadrature::integral(|x, _| wetting.height(x, time), 0.0, front);
        assert!((0.3 * area / wetting.stored(time) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn the_mound_agrees_with_the_independent_table() {
        let mound = Mound { conductivity: 5e-4, porosity: 0.3, area: 2.0 };
        for [time, front, x, height] in Table::read("09_barenblatt_mound.csv").rows(["t_s", "x_front_m", "x_m", "h_m"])
        {
            assert!((mound.front(time) / front - 1.0).abs() < 1e-14);
            assert!((mound.height(x, time) - height).abs() < 1e-14);
        }
    }
}
