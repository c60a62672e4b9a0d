//! Stability of an infinite slope with seepage: factor of safety of a plane at a depth, and Davis' reduced strength.
//!
//! Assumptions: a layer of unbounded length at the angle beta, failure on planes parallel to its surface, Mohr-Coulomb
//! strength c, phi; total stresses of the weight alone, sigma = gamma d cos^2 beta and tau = gamma d sin beta cos beta at
//! the vertical depth d; pore pressure u of a steady seepage. `F = [c + (sigma - u) tan phi]/tau`. Below an effective
//! stress of zero the plane has no friction to lose: F is then no factor of safety, and `None`.
//!
//! Sources: Taylor, *Fundamentals of Soil Mechanics*, 1948; Iverson & Major 1986, Water Resources Research 22(11),
//! doi:10.1029/WR022i011p01543; reduced strength: Davis 1968, in *Soil Mechanics: Selected Topics*, ed. Lee.

use super::root::root;

/// Strength of a soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Friction angle phi, rad.
    pub friction: f64,
}

impl Strength {
    /// Cohesion and tan(phi) divided by a factor.
    pub fn divided(self, factor: f64) -> Self {
        Self { cohesion: self.cohesion / factor, friction: (self.friction.tan() / factor).atan() }
    }

    /// What a soil of dilation angle `psi` (rad) can carry on a plane without extension along it, once it yields
    /// (simple shear): `tan phi* = sin phi cos psi/(1 - sin phi sin psi)`, `c* = c cos phi cos psi/(1 - sin phi sin psi)`.
    /// With psi = phi the strength itself. Source: Davis 1968.
    pub fn reduced(self, psi: f64) -> Self {
        let below = 1.0 - self.friction.sin() * psi.sin();
        let friction = (self.friction.sin() * psi.cos() / below).atan();
        Self { cohesion: self.cohesion * self.friction.cos() * psi.cos() / below, friction }
    }
}

/// How water flows through the slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seepage {
    /// Along the slope, its surface at `share` of the depth above the plane: u = gamma_w share d cos^2 beta. The soil above
    /// the water is dry.
    Parallel {
        /// Water depth over d, 0 (dry) to 1 (saturated).
        share: f64,
    },
    /// Out of the saturated slope at an angle (rad) to its surface: u = gamma_w d cos beta (cos beta + sin beta tan delta).
    /// With delta = beta it is horizontal and u = gamma_w d; with delta = 0 it is parallel.
    Leaving {
        /// Angle between flow and surface delta, rad.
        angle: f64,
    },
}

/// An infinite slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InfiniteSlope {
    /// Its angle beta, rad.
    pub angle: f64,
    /// Unit weight of the dry soil, N/m3.
    pub dry_weight: f64,
    /// Unit weight of the saturated soil, N/m3.
    pub saturated_weight: f64,
    /// Unit weight of water gamma_w, N/m3.
    pub water_weight: f64,
    /// Strength.
    pub strength: Strength,
    /// Seepage.
    pub seepage: Seepage,
}

/// Stresses on a plane, Pa, compression positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Total normal stress.
    pub normal: f64,
    /// Shear stress.
    pub shear: f64,
    /// Pore pressure.
    pub pore: f64,
}

impl InfiniteSlope {
    /// Horizontal seepage, as at the toe of a slope.
    pub fn horizontal(self) -> Self {
        Self { seepage: Seepage::Leaving { angle: self.angle }, ..self }
    }

    /// Mean unit weight above a plane, N/m3.
    pub fn mean_weight(&self) -> f64 {
        match self.seepage {
            Seepage::Parallel { share } => (1.0 - share) * self.dry_weight + share * self.saturated_weight,
            Seepage::Leaving { .. } => self.saturated_weight,
        }
    }

    /// Stresses at a vertical depth (m).
    pub fn plane(&self, depth: f64) -> Plane {
        let (sin, cos) = self.angle.sin_cos();
        let weight = self.mean_weight() * depth;
        let head = match self.seepage {
            Seepage::Parallel { share } => share * cos * cos,
            Seepage::Leaving { angle } => cos * (cos + sin * angle.tan()),
        };
        Plane { normal: weight * cos * cos, shear: weight * sin * cos, pore: self.water_weight * depth * head }
    }

    /// Factor of safety at a vertical depth (m); `None` where the effective normal stress is negative.
    pub fn factor(&self, depth: f64) -> Option<f64> {
        let plane = self.plane(depth);
        let effective = plane.normal - plane.pore;
        let strength = self.strength.cohesion + effective * self.strength.friction.tan();
        (effective >= 0.0).then(|| strength / plane.shear)
    }

    /// Vertical depth (m) at which the factor of safety is one; `None` if it is above one everywhere or there is no
    /// cohesion. Negative effective stresses count.
    pub fn critical_depth(&self) -> Option<f64> {
        let unit = self.plane(1.0);
        let excess = unit.shear - (unit.normal - unit.pore) * self.strength.friction.tan();
        (excess > 0.0 && self.strength.cohesion > 0.0).then(|| self.strength.cohesion / excess)
    }

    /// Angle (rad) at which the same slope without cohesion just stands, of the same seepage (horizontal stays
    /// horizontal); `None` if it stands at any below 90 degrees.
    pub fn critical_angle(&self) -> Option<f64> {
        let horizontal = self.seepage == Seepage::Leaving { angle: self.angle };
        let excess = |angle: f64| {
            let steep = Self { angle, ..*self };
            let plane = if horizontal { steep.horizontal() } else { steep }.plane(1.0);
            plane.shear - (plane.normal - plane.pore) * self.strength.friction.tan()
        };
        root(excess, 1e-9, std::f64::consts::FRAC_PI_4)
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    const TABLE: &str = "11_infinite_slope.csv";

    fn slope(set: f64, seepage: Seepage) -> InfiniteSlope {
        // Two readings of 1800 kg/m3: of the grains, or of the saturated soil.
        let (dry, saturated) = if set == 0.0 { (12_360.6, 15_303.6) } else { (14_715.0, 17_658.0) };
        InfiniteSlope {
            angle: 0.5_f64.atan(),
            dry_weight: dry,
            saturated_weight: saturated,
            water_weight: 9810.0,
            strength: Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() },
            seepage,
        }
    }

    #[test]
    fn agrees_with_the_independent_table() {
        let names = [
            "density_set",
            "depth_m",
            "seepage_kind",
            "m",
            "delta_deg",
            "u_Pa",
            "sigma_n_total_Pa",
            "tau_Pa",
            "FS",
            "d_crit_m",
        ];
        let mut seen = 0;
        for [set, depth, kind, share, delta, pore, normal, shear, factor, critical] in Table::read(TABLE).rows(names) {
            let leaving = Seepage::Leaving { angle: delta.to_radians() };
            let slope = slope(set, if kind == 0.0 { Seepage::Parallel { share } } else { leaving });
            let plane = slope.plane(depth);
            for (found, wanted) in [(plane.pore, pore), (plane.normal, normal), (plane.shear, shear)] {
                assert!((found - wanted).abs() < 1e-12 * normal, "{found} {wanted}");
            }
            match slope.factor(depth) {
                Some(found) => assert!((found - factor).abs() < 1e-12, "{found} {factor}"),
                None => assert!(normal < pore),
            }
            let found = slope.critical_depth().unwrap_or(-1.0);
            assert!((found / critical - 1.0).abs() < 1e-12, "{found} {critical}");
            seen += 1;
        }
        assert!(seen > 50);
    }

    #[test]
    fn slopes_without_cohesion_stand_up_to_the_angles_of_the_table() {
        for (set, parallel, horizontal) in [(0.0, 11.709_004_22, 10.946_4), (1.0, 14.391_601_4, 13.407_630_73)] {
            let slope = slope(set, Seepage::Parallel { share: 1.0 });
            let degrees = |slope: InfiniteSlope| slope.critical_angle().expect("an angle").to_degrees();
            assert!((degrees(slope) - parallel).abs() < 1e-8);
            assert!((degrees(slope.horizontal()) - horizontal).abs() < 1e-6);
        }
    }

    #[test]
    fn flow_along_the_surface_leaves_at_no_angle() {
        let parallel = slope(0.0, Seepage::Parallel { share: 1.0 });
        let leaving = slope(0.0, Seepage::Leaving { angle: 0.0 });
        assert_eq!(parallel.factor(1.0), leaving.factor(1.0));
    }

    #[test]
    fn simple_shear_of_a_soil_without_dilation() {
        let strength = Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() };
        // psi = 0: tan phi* = sin phi, c* = c cos phi; psi = phi: nothing is lost.
        let reduced = strength.reduced(0.0);
        assert!((reduced.friction.tan() - 0.5).abs() < 1e-15);
        assert!((reduced.cohesion - 500.0 * strength.friction.cos()).abs() < 1e-12);
        let same = strength.reduced(strength.friction);
        assert!((same.friction - strength.friction).abs() < 1e-15 && (same.cohesion - 500.0).abs() < 1e-12);
    }

    #[test]
    fn simple_shear_ends_at_the_reduced_strength_of_the_element_tables() {
        // Ultimate shear stress of the element tests, c = 500 Pa, phi = 30 deg, psi = 0, sigma_yy = 10 kPa.
        let reduced = Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() }.reduced(0.0);
        let ultimate = reduced.cohesion + 1e4 * reduced.friction.tan();
        assert!((ultimate - 5_433.012_702).abs() < 1e-6, "{ultimate}");
    }
}
