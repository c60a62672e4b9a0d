//! Modified Cam-Clay: an elliptic yield surface whose size p_c hardens and softens with the plastic change of volume.
//!
//! In stresses with p = -tr(sigma)/3 and q = sqrt(3/2) |s|, compression positive for p, both counted from the attraction a
//! (the isotropic tension that cementation bears; none in a remoulded clay), p^ = p + a, p_c^ = p_c + a:
//!
//! ```text
//! f = q^2/M^2 + p^ (p^ - p_c^) <= 0       d eps_p = d gamma df/d sigma       d p_c^/p_c^ = d eps_v^p/(lambda - kappa)
//! ```
//!
//! lambda and kappa are the slopes of isotropic compression and swelling in (ln p^, eps_v) with logarithmic strains (Butterfield
//! 1979): those in (ln p, e) over 1 + e_0. The bulk modulus is constant, or p^/kappa; Poisson's ratio is constant, so that G follows K.
//!
//! Sources: Roscoe & Burland 1968; Wood 1990, *Soil behaviour and critical state soil mechanics*, ch. 5 (the surface and closed
//! forms); Borja & Lee 1990, doi:10.1016/0045-7825(90)90152-C, and Borja 1991, doi:10.1016/0045-7825(91)90007-N (implicit
//! return, consistent tangent). In a step G is that of its start, and p^ and p_c^ are integrated exactly.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::{Flow, Law, State};
use crate::real::map_of;
use crate::scene::CamClay;

/// Most iterations of a return; each halves its bracket at least.
const ITERATIONS: usize = 200;
/// How exactly a return meets the surface, as a share of its size.
const EXACT: f64 = 1e-14;

/// The law of a soil.
#[derive(Debug, Clone, Copy)]
pub struct ModifiedCamClay {
    soil: CamClay,
    /// 1 / M^2.
    flat: f64,
    /// lambda - kappa.
    plastic: f64,
    /// G/K.
    shear_of_bulk: f64,
}

/// An update on its way: everything in p^ and q.
struct Update {
    /// Change of volume of the step, compression positive.
    compressed: f64,
    /// p^ and p_c^ at the start, Pa.
    from: [f64; 2],
    shear: f64,
    /// Trial deviator, xx, yy, zz, xy, Pa, and its q.
    trial: [f64; 4],
    sheared: f64,
    /// Multiplier (1/Pa), and what is plastic of the change of volume.
    gamma: f64,
    lost: f64,
}

impl ModifiedCamClay {
    /// The law of a soil.
    pub fn new(soil: &CamClay) -> Self {
        let nu = soil.poisson_ratio;
        Self {
            soil: *soil,
            flat: soil.critical_slope.powi(-2),
            plastic: soil.lambda - soil.kappa,
            shear_of_bulk: 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu),
        }
    }

    /// p^ (Pa) and the deviator of a stress.
    fn split(&self, stress: &[f64; 4]) -> (f64, [f64; 4]) {
        let mean = (stress[0] + stress[1] + stress[2]) / 3.0;
        (self.soil.attraction - mean, [stress[0] - mean, stress[1] - mean, stress[2] - mean, stress[3]])
    }

    /// K at a p^, Pa.
    fn bulk(&self, p: f64) -> f64 {
        self.soil.bulk_modulus.unwrap_or_else(|| p / self.soil.kappa)
    }

    /// p^ after an elastic compression, Pa.
    fn compressed(&self, p: f64, strain: f64) -> f64 {
        match self.soil.bulk_modulus {
            Some(bulk) => p + bulk * strain,
            None => p * (strain / self.soil.kappa).exp(),
        }
    }

    /// f, Pa2.
    fn over(&self, q: f64, p: f64, size: f64) -> f64 {
        self.flat * q * q + p * (p - size)
    }

    /// p^ and p_c^ of an update once so much of the change of volume is plastic, Pa.
    fn after(&self, update: &Update, lost: f64) -> [f64; 2] {
        let [p, size] = update.from;
        [self.compressed(p, update.compressed - lost), size * (lost / self.plastic).exp()]
    }

    /// The plastic change of volume that belongs to a multiplier: `x = gamma (2 p^ - p_c^)`, monotone in x.
    fn lost(&self, update: &Update, gamma: f64) -> f64 {
        let residual = |x: f64| {
            let [p, size] = self.after(update, x);
            let slope = 1.0 + gamma * (2.0 * self.bulk(p) + size / self.plastic);
            (x - gamma * (2.0 * p - size), slope)
        };
        let mut x = update.lost;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for _ in 0..ITERATIONS {
            let (over, slope) = residual(x);
            if over == 0.0 {
                return x;
            }
            if over > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - over / slope;
            let next = match (newton > low && newton < high, (high - low).is_finite()) {
                (true, _) => newton,
                (false, true) => 0.5 * (low + high),
                // Pressures change by a factor e.
                (false, false) => x - self.soil.kappa.copysign(over),
            };
            if (next - x).abs() <= 1e-16 + 1e-15 * x.abs() {
                return next;
            }
            x = next;
        }
        x
    }

    /// Starts an update with the trial stress; returns by it where that is outside the surface.
    fn updated(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> Update {
        let (p, deviator) = self.split(stress);
        let compressed = -(strain[0] + strain[1] + strain[2]);
        let shear = self.shear_of_bulk * self.bulk(p);
        let mut trial = deviator;
        for s in 0..3 {
            trial[s] += 2.0 * shear * (strain[s] + compressed / 3.0);
        }
        trial[3] += shear * strain[3];
        let from = [p, state[0] + self.soil.attraction];
        let mut update = Update { compressed, from, shear, trial, sheared: size(&trial), gamma: 0.0, lost: 0.0 };
        if self.off(&update) > EXACT {
            self.back(&mut update);
        }
        update
    }

    /// `ln(p^ + q^2/(M^2 p^)) - ln(p_c^)` at the present multiplier: zero where f is, and nearly linear however large a trial is.
    fn off(&self, update: &Update) -> f64 {
        let [p, size] = self.after(update, update.lost);
        let q = update.sheared * self.shrunk(update);
        ((p + self.flat * q * q / p) / size).ln()
    }

    /// What is left of the trial deviator: `1/(1 + 6 G gamma/M^2)`.
    fn shrunk(&self, update: &Update) -> f64 {
        1.0 / (1.0 + 6.0 * update.shear * update.gamma * self.flat)
    }

    /// Finds the multiplier at which f = 0: Newton's method within a bracket.
    fn back(&self, update: &mut Update) {
        let at = |gamma: f64, update: &mut Update| {
            update.gamma = gamma;
            update.lost = self.lost(update, gamma);
            self.off(update)
        };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut gamma = 0.0;
        let mut off = self.off(update);
        for _ in 0..ITERATIONS {
            if off > 0.0 {
                low = gamma
            } else {
                high = gamma
            }
            if off.abs() <= EXACT {
                break;
            }
            let slope = self.slope(update);
            let newton = gamma - off / slope;
            let inside = newton > low && newton < high && newton.is_finite();
            let unit = 1.0 / (update.shear + self.bulk(update.from[0]));
            gamma = match (inside, high.is_finite()) {
                (true, _) => newton,
                (false, true) => 0.5 * (low + high),
                (false, false) => 2.0 * low + unit,
            };
            off = at(gamma, update);
            if high.is_finite() && high - low <= f64::EPSILON * high {
                break;
            }
        }
    }

    /// Derivatives of both equations of a return by (x, gamma), by the change of volume and by the trial q:
    /// `R_1 = x - gamma (2 p^ - p_c^)`, `R_2 = f`.
    fn linearised(&self, update: &Update) -> (Matrix2<f64>, Vector2<f64>, Vector2<f64>) {
        let [p, size] = self.after(update, update.lost);
        let (bulk, harder) = (self.bulk(p), size / self.plastic);
        let (gamma, shrunk) = (update.gamma, self.shrunk(update));
        let q = update.sheared * shrunk;
        let along = 2.0 * p - size;
        let matrix = Matrix2::new(
            1.0 + gamma * (2.0 * bulk + harder),
            -along,
            -along * bulk - p * harder,
            -2.0 * self.flat * q * q * 6.0 * update.shear * self.flat * shrunk,
        );
        let by_volume = Vector2::new(-2.0 * gamma * bulk, along * bulk);
        let by_shear = Vector2::new(0.0, 2.0 * self.flat * q * shrunk);
        (matrix, by_volume, by_shear)
    }

    /// Slope of [`Self::off`] with the multiplier, while x follows.
    fn slope(&self, update: &Update) -> f64 {
        let (m, ..) = self.linearised(update);
        let [p, _] = self.after(update, update.lost);
        let (follows, shrunk) = (-m[(0, 1)] / m[(0, 0)], self.shrunk(update));
        let q = update.sheared * shrunk;
        let (of_p, of_q) = (-self.bulk(p) * follows, -q * 6.0 * update.shear * self.flat * shrunk);
        2.0 * (p * of_p + self.flat * q * of_q) / (p * p + self.flat * q * q) - of_p / p - follows / self.plastic
    }

    /// The stress of an update, Pa.
    fn stress(&self, update: &Update) -> [f64; 4] {
        let [p, _] = self.after(update, update.lost);
        let (mean, shrunk) = (self.soil.attraction - p, self.shrunk(update));
        let mut stress = map_of(&update.trial, |s| shrunk * s);
        stress[..3].iter_mut().for_each(|s| *s += mean);
        stress
    }
}

/// q of a deviator, Pa.
fn size(deviator: &[f64; 4]) -> f64 {
    let [xx, yy, zz, xy] = deviator;
    (1.5 * (xx * xx + yy * yy + zz * zz + 2.0 * xy * xy)).sqrt()
}

impl Law for ModifiedCamClay {
    fn has_state(&self) -> bool {
        true
    }

    /// p_c: the one that is given, or what the stress needs to be on the surface, where that is larger.
    fn first_state(&self, stress: &[f64; 4]) -> State {
        let (p, deviator) = self.split(stress);
        let q = size(&deviator);
        let needed = if p > 0.0 { p + self.flat * q * q / p - self.soil.attraction } else { 0.0 };
        [self.soil.preconsolidation.max(self.soil.overconsolidation * needed)]
    }

    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], state: &mut State) -> Flow {
        let update = self.updated(stress, strain, state);
        let new = self.stress(&update);
        let work: f64 = (0..4).map(|s| 0.5 * (stress[s] + new[s]) * strain[s]).sum();
        // What is not stored of the work done: plastic work, and what little a constant Poisson's ratio takes.
        let dissipation = work - (self.energy(&new) - self.energy(stress));
        *stress = new;
        state[0] = self.after(&update, update.lost)[1] - self.soil.attraction;
        Flow { dissipation, residual: self.yield_residual(&new, state) }
    }

    fn is_symmetric(&self) -> bool {
        false // hardening is no potential of its own
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> SMatrix<f64, 4, 4> {
        let update = self.updated(stress, strain, state);
        let [p, _] = self.after(&update, update.lost);
        let (bulk, shear, shrunk) = (self.bulk(p), update.shear, self.shrunk(&update));
        let flows = update.gamma > 0.0;
        let (matrix, by_volume, by_shear) = self.linearised(&update);
        let solved = |right: Vector2<f64>| matrix.lu().solve(&-right).unwrap_or_else(Vector2::zeros);
        let (of_volume, of_shear) = if flows { (solved(by_volume), solved(by_shear)) } else { Default::default() };
        let mut tangent = SMatrix::<f64, 4, 4>::zeros();
        for j in 0..4 {
            let compressed = if j < 3 { -1.0 } else { 0.0 };
            let mut deviator = [0.0; 4];
            for s in 0..3 {
                deviator[s] = 2.0 * shear * (if s == j { 1.0 } else { 0.0 } + compressed / 3.0);
            }
            deviator[3] = if j == 3 { shear } else { 0.0 };
            let t = &update.trial;
            let along = t[0] * deviator[0] + t[1] * deviator[1] + t[2] * deviator[2] + 2.0 * t[3] * deviator[3];
            let sheared = if update.sheared > 0.0 { 1.5 * along / update.sheared } else { 0.0 };
            let [lost, gamma] = (of_volume * compressed + of_shear * sheared).into();
            let mean = -bulk * (compressed - lost);
            let less = shrunk * shrunk * 6.0 * shear * self.flat * gamma;
            for i in 0..4 {
                tangent[(i, j)] = shrunk * deviator[i] - less * t[i] + if i < 3 { mean } else { 0.0 };
            }
        }
        tangent
    }

    /// `int p d eps_v + q^2/(6 G)`.
    fn energy(&self, stress: &[f64; 4]) -> f64 {
        let (p, deviator) = self.split(stress);
        let (bulk, q) = (self.bulk(p), size(&deviator));
        let of_volume = match self.soil.bulk_modulus {
            Some(bulk) => 0.5 * (p - self.soil.attraction).powi(2) / bulk,
            None => {
                let attraction = self.soil.attraction;
                let borne = if attraction > 0.0 { attraction * (1.0 + (p / attraction).ln()) } else { 0.0 };
                self.soil.kappa * (p - borne)
            }
        };
        of_volume + q * q / (6.0 * self.shear_of_bulk * bulk)
    }

    /// f over p_c^ squared.
    fn yield_residual(&self, stress: &[f64; 4], state: &State) -> f64 {
        let (p, deviator) = self.split(stress);
        let size_of_surface = state[0] + self.soil.attraction;
        self.over(size(&deviator), p, size_of_surface) / (size_of_surface * size_of_surface)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soil(bulk_modulus: Option<f64>, preconsolidation: f64) -> ModifiedCamClay {
        ModifiedCamClay::new(&CamClay {
            lambda: 0.10,
            kappa: 0.02,
            poisson_ratio: 0.25,
            bulk_modulus,
            critical_slope: 1.0,
            preconsolidation,
            overconsolidation: 1.0,
            attraction: 0.0,
        })
    }

    #[test]
    fn its_tangent_is_that_of_its_differences() {
        // Normally, lightly and heavily over-consolidated.
        for (bulk, preconsolidation) in [(None, 1e5), (Some(5e6), 1e5), (None, 1.5e5), (None, 8e5), (Some(5e6), 8e5)] {
            let law = soil(bulk, preconsolidation);
            let start = [-0.8e5, -1.2e5, -1e5, 1e4];
            for strain in [
                [-2e-3, -5e-3, 0.0, 1e-3],
                [2e-2, -4e-2, 1e-2, 3e-2],
                [4e-2, -4e-2, 0.0, 1e-3],
                [-4e-2, -4e-2, -4e-2, 1e-2],
                [1e-4, 2e-4, 1e-4, 5e-5],
            ] {
                check_tangent!(law, start, strain, 5e6);
            }
        }
    }

    #[test]
    fn stresses_stay_on_their_surface_however_long_the_step() {
        for strain in [-0.3, -0.1, -1e-3, 1e-3, 0.1] {
            for shear in [0.0, 1e-3, 0.1, 0.5] {
                for preconsolidation in [1e5, 1e6] {
                    let law = soil(None, preconsolidation);
                    let mut stress = [-1e5, -1e5, -1e5, 0.0];
                    let mut state = law.first_state(&stress);
                    let flow = law.update(&mut stress, &[0.0, strain, 0.0, shear], &mut state);
                    assert!(flow.residual < 1e-12, "{strain} {shear} {preconsolidation}: {flow:?}");
                    assert!((flow.residual - law.yield_residual(&stress, &state)).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn tiny_steps_of_stiff_soil_are_taken() {
        let law = ModifiedCamClay::new(&CamClay { lambda: 1e-3, kappa: 2e-4, ..soil(None, 0.0).soil });
        for size in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0] {
            let mut stress = [-2500.0, -2500.0, -2500.0, 0.0];
            let mut state = law.first_state(&stress);
            for step in 0..100 {
                let strain = if step % 7 < 5 { -size } else { size };
                let flow = law.update(&mut stress, &[0.0, strain, 0.0, 0.0], &mut state);
                assert!(
                    stress.iter().all(|s| s.is_finite()) && flow.residual < 1e-12,
                    "{size} {step}: {stress:?} {flow:?}"
                );
            }
        }
    }

    /// Isochoric shear of normally consolidated soil: `p/p_0 = (1 + eta^2/M^2)^-(1 - kappa/lambda)` (Wood 1990, eq. 5.43), and the
    /// end at critical state.
    #[test]
    fn undrained_shear_follows_its_path() {
        let law = soil(None, 1e5);
        let mut stress = [-1e5, -1e5, -1e5, 0.0];
        let mut state = law.first_state(&stress);
        let steps = 20_000;
        for step in 1..=steps {
            law.update(&mut stress, &[1e-5, -2e-5, 1e-5, 0.0], &mut state);
            if step % 1000 == 0 {
                let (p, deviator) = law.split(&stress);
                let eta = size(&deviator) / p;
                let expected = 1e5 * (1.0 + eta * eta).powf(-0.8);
                assert!((p / expected - 1.0).abs() < 1e-4, "{p} {expected} at eta = {eta}");
            }
        }
        let (p, deviator) = law.split(&stress);
        assert!((size(&deviator) / p - 1.0).abs() < 1e-3);
    }
}
