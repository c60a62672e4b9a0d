//! Closed forms of modified Cam-Clay: triaxial compression, drained and undrained, and K_0.
//!
//! With eta = q/p the flow rule is `d eps_q^p = d eps_v^p 2 eta/(M^2 - eta^2)`, the surface `p_c = p (1 + eta^2/M^2)`, and
//! `d eps_v^p = (lambda - kappa) d ln p_c`. Along `q = 3 (p - p_0)`, `p = 3 p_0/(3 - eta)`; without change of volume
//! `p (1 + eta^2/M^2)^L` stays, L = 1 - kappa/lambda. Elastic strains follow p and q, G = r K with a constant Poisson's ratio.
//!
//! Source: Wood 1990, *Soil behaviour and critical state soil mechanics*, ch. 5; Peric 2006, doi:10.1002/nag.517. Integrals by
//! partial fractions, which the tests take numerically.

use mpm_core::scene::CamClay;

use super::root::root;

/// The soil of the tables 13, remoulded and without attraction.
pub const SOIL: CamClay = CamClay {
    lambda: 0.10,
    kappa: 0.02,
    poisson_ratio: 0.25,
    bulk_modulus: None,
    critical_slope: 1.0,
    preconsolidation: 0.0,
    overconsolidation: 1.0,
    attraction: 0.0,
};
/// Triaxial compression from an isotropic stress.
#[derive(Debug, Clone, Copy)]
pub struct Triaxial {
    /// The soil, without attraction.
    pub soil: CamClay,
    /// p at the start, Pa.
    pub start: f64,
    /// p_c at the start, Pa.
    pub preconsolidation: f64,
}

/// G/K of a soil.
fn shear_of_bulk(soil: &CamClay) -> f64 {
    1.5 * (1.0 - 2.0 * soil.poisson_ratio) / (1.0 + soil.poisson_ratio)
}

impl Triaxial {
    fn slope(&self) -> f64 {
        self.soil.critical_slope
    }

    /// p at a stress ratio while the lateral stress is held, Pa.
    pub fn drained_pressure(&self, eta: f64) -> f64 {
        3.0 * self.start / (3.0 - eta)
    }

    /// Stress ratio at yield while the lateral stress is held.
    pub fn drained_yield(&self) -> f64 {
        let (a, b) = (3.0 * self.start / self.slope().powi(2), self.preconsolidation);
        let c = 3.0 * (self.start - self.preconsolidation);
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
    }

    /// Change of volume (compression positive) and deviatoric strain at a stress ratio, drained, before or after yield.
    pub fn drained(&self, eta: f64, yielded: bool) -> [f64; 2] {
        let (soil, m) = (&self.soil, self.slope());
        let p = self.drained_pressure(eta);
        let r = shear_of_bulk(soil);
        // q = 3 (p - p_0), so that both elastic strains are integrals of dp.
        let over = match soil.bulk_modulus {
            Some(bulk) => (p - self.start) / bulk,
            None => soil.kappa * (p / self.start).ln(),
        };
        let (mut volume, mut shear) = (over, over / r);
        if yielded {
            let plastic = soil.lambda - soil.kappa;
            volume += plastic * (p * (1.0 + (eta / m).powi(2)) / self.preconsolidation).ln();
            let part = |eta: f64| {
                let along = -(m - eta).abs().ln() / (3.0 - m) - (m + eta).ln() / (3.0 + m)
                    + 6.0 * (3.0 - eta).ln() / (9.0 - m * m);
                along + (((m + eta) / (m - eta)).abs().ln() - 2.0 * (eta / m).atan()) / m
            };
            shear += plastic * (part(eta) - part(self.drained_yield()));
        }
        [volume, shear]
    }

    /// Stress ratio at yield without change of volume.
    pub fn undrained_yield(&self) -> f64 {
        self.slope() * (self.preconsolidation / self.start - 1.0).sqrt()
    }

    /// p (Pa) and deviatoric strain at a stress ratio without change of volume, K = p/kappa.
    pub fn undrained(&self, eta: f64, yielded: bool) -> [f64; 2] {
        let (soil, m) = (&self.soil, self.slope());
        let r = shear_of_bulk(soil);
        let from = self.undrained_yield();
        if !yielded {
            return [self.start, soil.kappa / (3.0 * r) * eta];
        }
        let share = 1.0 - soil.kappa / soil.lambda;
        let p = self.start * ((m * m + from * from) / (m * m + eta * eta)).powf(share);
        let elastic = |eta: f64| eta - 2.0 * share * (eta - m * (eta / m).atan());
        let plastic = |eta: f64| (((m + eta) / (m - eta)).abs().ln() - 2.0 * (eta / m).atan()) / m;
        let elastic = soil.kappa / (3.0 * r) * (from + elastic(eta) - elastic(from));
        [p, elastic + soil.kappa * share * (plastic(eta) - plastic(from))]
    }
}

/// Lateral over vertical effective stress of normally consolidated soil that never strained sideways, K = p/kappa: the stress ratio
/// at which two thirds of the change of volume are deviatoric, `kappa eta/(3 r) + (lambda - kappa) 2 eta/(M^2 - eta^2) = 2 lambda/3`.
pub fn at_rest(soil: &CamClay) -> Option<f64> {
    let (m, r) = (soil.critical_slope, shear_of_bulk(soil));
    let missing = |eta: f64| {
        soil.kappa * eta / (3.0 * r) + (soil.lambda - soil.kappa) * 2.0 * eta / (m * m - eta * eta)
            - 2.0 / 3.0 * soil.lambda
    };
    let eta = root(missing, 0.0, m * (1.0 - 1e-12))?;
    Some((3.0 - eta) / (3.0 + 2.0 * eta))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The plastic deviatoric strain by the flow rule, in small steps of the change of volume.
    fn by_steps(path: &Triaxial, eta: f64) -> f64 {
        let (from, m, count) = (path.drained_yield(), SOIL.critical_slope, 100_000);
        let at = |i: usize| from + (eta - from) * i as f64 / count as f64;
        let size = |eta: f64| (path.drained_pressure(eta) * (1.0 + (eta / m).powi(2))).ln();
        let plastic = SOIL.lambda - SOIL.kappa;
        (0..count)
            .map(|i| {
                let middle = 0.5 * (at(i) + at(i + 1));
                plastic * (size(at(i + 1)) - size(at(i))) * 2.0 * middle / (m * m - middle * middle)
            })
            .sum()
    }

    #[test]
    fn the_integrals_are_those_of_the_flow_rule() {
        for (ratio, eta) in [(1.0, 0.9), (1.5, 0.9), (8.0, 1.2)] {
            let path = Triaxial { soil: SOIL, start: 1e5, preconsolidation: ratio * 1e5 };
            let [_, whole] = path.drained(eta, true);
            let [_, elastic] = path.drained(eta, false);
            let summed = by_steps(&path, eta);
            assert!(((whole - elastic) / summed - 1.0).abs() < 1e-6, "{ratio}: {whole} {elastic} {summed}");
        }
    }

    #[test]
    fn the_coefficient_at_rest_is_that_of_the_table() {
        assert!((at_rest(&SOIL).expect("K_0") - 0.719_033_054_401_010_4).abs() < 1e-12);
    }
}
