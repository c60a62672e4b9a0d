//! A standing wave over a poroelastic bed of finite depth: Biot's quasi-static equations for one wave number and one frequency
//! (Yamamoto, Koning, Sellmeijer & van Hijum 1978, *J. Fluid Mech.* 87; Madsen 1978, *Géotechnique* 28; here with a smooth,
//! impermeable base).
//!
//! With `p = P(y) cos(kx)`, `v = V(y) cos(kx)`, `u = U(y) sin(kx)`, all times `exp(i w t)`, and `h = M e - alpha p` harmonic,
//!
//! ```text
//! P'' = (k^2 + i w S/kappa) P + i w alpha h/(kappa M),        S = alpha^2/M + 1/Q
//! V'' - k^2 V = alpha P'/M - (lambda + G)/(G M) h',           U = (e - V')/k,   e = (h + alpha P)/M
//! ```
//!
//! Six functions, six conditions: v = tau = P' = 0 at the base, P = p_0 and sigma' = tau = 0 on top.

use nalgebra::{Complex, SMatrix, SVector};
use std::f64::consts::TAU;

use mpm_core::scene::{Bearing, Course, Scene};

type Number = Complex<f64>;

/// A bed under a wave.
#[derive(Debug, Clone)]
pub struct Seabed {
    height: f64,
    /// Wave number k, 1/m, and frequency w, 1/s.
    wave: [f64; 2],
    /// alpha, lambda, G, M, S.
    soil: [f64; 5],
    /// `sqrt(k^2 + i w S/kappa)`, 1/m.
    decay: Number,
    /// Pressure of the wave p_0, Pa.
    load: f64,
    shares: SVector<Number, 6>,
}

/// What a condition asks of a function.
type Of = fn(&Seabed, &Values) -> Number;

/// What a function is at a height: h, h', P, P', V, V', V''.
type Values = [Number; 7];

impl Seabed {
    /// The bed of a scene under two equal waves of water that run against each other; `None` for others.
    pub fn of(scene: &Scene) -> Option<Self> {
        let water = scene.water?;
        let [one, other] = &scene.loads[..] else { return None };
        let (Course::Wave { length, period }, Course::Wave { length: back, .. }) = (&one.course, &other.course) else {
            return None;
        };
        let Bearing::Traction { pressure, water: true, .. } = one.bearing else { return None };
        if one.bearing != other.bearing || *length != -back || (2.0 * scene.width / length - 1.0).abs() > 1e-12 {
            return None;
        }
        let soil = scene.soil();
        let (alpha, storage, mobility) = (soil.alpha(), scene.storage(), water.mobility());
        let (lame, shear, modulus) = (soil.elastic.lame(), soil.elastic.shear_modulus(), scene.oedometer_modulus());
        let wave = [TAU / length, TAU / period];
        let decay = Number::new(wave[0] * wave[0], wave[1] * storage / mobility).sqrt();
        let mut bed = Self {
            height: scene.height,
            wave,
            soil: [alpha, lame, shear, modulus, storage],
            decay,
            load: 2.0 * pressure,
            shares: SVector::zeros(),
        };
        let rows: [(f64, Of); 6] = [
            (0.0, |_, values| values[4]),
            (0.0, Self::shear),
            (0.0, |_, values| values[3]),
            (bed.height, |_, values| values[2]),
            (bed.height, Self::stress),
            (bed.height, Self::shear),
        ];
        let mut matrix = SMatrix::<Number, 6, 6>::zeros();
        for (i, (height, of)) in rows.iter().enumerate() {
            let values = bed.functions(*height);
            // Each condition in its own unit.
            let size = values.iter().map(|v| of(&bed, v).norm()).fold(f64::MIN_POSITIVE, f64::max);
            for (j, v) in values.iter().enumerate() {
                matrix[(i, j)] = of(&bed, v) / size;
            }
            bed.shares[i] = if i == 3 { Number::from(bed.load / size) } else { Number::from(0.0) };
        }
        bed.shares = matrix.lu().solve(&bed.shares)?;
        Some(bed)
    }

    /// The six functions at a height.
    fn functions(&self, height: f64) -> [Values; 6] {
        let ([k, _], [alpha, lame, shear, modulus, storage]) = (self.wave, self.soil);
        let (none, y) = (Number::from(0.0), height - self.height);
        let turned = -alpha * alpha / (modulus * modulus * storage) - (lame + shear) / (shear * modulus);
        let mut all = [[none; 7]; 6];
        for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
            let (s, e) = (sign * k, Number::from((sign * k * y).exp()));
            let p = e * (-alpha / (modulus * storage));
            let half = e * (0.5 * turned);
            all[i] = [e, e * s, p, p * s, half * y, half * (1.0 + y * s), half * (2.0 * s + y * k * k)];
            let (s, e) = (self.decay * sign, (self.decay * (sign * y)).exp());
            let factor = alpha / modulus / (self.decay * self.decay - k * k);
            let (p, slope) = (e, e * s);
            all[2 + i] = [none, none, p, slope, factor * slope, factor * slope * s, factor * slope * s * s];
            let (s, e) = (sign * k, Number::from((sign * k * y).exp()));
            all[4 + i] = [none, none, none, none, e, e * s, e * s * s];
        }
        all
    }

    /// `G (U' - k V)` of a function.
    fn shear(&self, [_, slope, _, p, v, _, bent]: &Values) -> Number {
        let ([k, _], [alpha, _, shear, modulus, _]) = (self.wave, self.soil);
        ((*slope + *p * alpha) / modulus - *bent) / k * shear - *v * (shear * k)
    }

    /// `lambda e + 2 G V'` of a function.
    fn stress(&self, [h, _, p, _, _, slope, _]: &Values) -> Number {
        let [alpha, lame, shear, modulus, _] = self.soil;
        (*h + *p * alpha) / modulus * lame + *slope * (2.0 * shear)
    }

    fn sum(&self, height: f64, of: impl Fn(&Values) -> Number) -> Number {
        self.functions(height).iter().zip(self.shares.iter()).map(|(values, share)| of(values) * share).sum()
    }

    fn turned(&self, value: Number, [x, time]: [f64; 2]) -> f64 {
        (value * Number::new(0.0, self.wave[1] * time).exp()).re * (self.wave[0] * x).cos()
    }

    /// Pore pressure at a place (m) and a time (s), Pa.
    pub fn pressure(&self, [x, height]: [f64; 2], time: f64) -> f64 {
        self.turned(self.sum(height, |values| values[2]), [x, time])
    }

    /// Vertical effective stress there, Pa, tension positive.
    pub fn effective_stress(&self, [x, height]: [f64; 2], time: f64) -> f64 {
        self.turned(self.sum(height, |values| self.stress(values)), [x, time])
    }

    /// Pressure of the wave p_0, Pa.
    pub fn load(&self) -> f64 {
        self.load
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::built_in;

    #[test]
    fn the_bed_fulfils_its_conditions_and_darcys_law() {
        let bed = Seabed::of(&built_in("seabed-wave").expect("a scene")).expect("a bed");
        let (top, time) = (bed.height, 0.3);
        let wave = bed.load * (bed.wave[1] * time).cos();
        assert!((bed.pressure([0.0, top], time) / wave - 1.0).abs() < 1e-12);
        assert!(bed.effective_stress([0.0, top], time).abs() < 1e-9 * bed.load);
        // kappa laplacian(p) = d/dt (alpha e + p/Q), by differences.
        let (y, d) = (0.6 * top, 1e-4);
        let p = |y: f64| bed.sum(y, |values| values[2]);
        let laplacian = (p(y + d) - p(y) * 2.0 + p(y - d)) / (d * d) - p(y) * bed.wave[0].powi(2);
        let [alpha, _, _, modulus, storage] = bed.soil;
        let h = bed.sum(y, |values| values[0]);
        let kept = p(y) * storage + h * (alpha / modulus);
        let rate = kept * (bed.decay * bed.decay - bed.wave[0].powi(2)) / storage;
        assert!((laplacian - rate).norm() < 1e-5 * rate.norm(), "{laplacian} {rate}");
    }
}
