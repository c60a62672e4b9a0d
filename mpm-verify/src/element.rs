//! Element tests: one law, one uniform strain, and stresses that are held while the rest is driven.

use mpm_core::constitutive::{Law, State};
use nalgebra::{DMatrix, DVector};

use crate::error::Error::{self, Unfit};

/// Newton steps at most; between planes a handful is enough.
const MOST: usize = 50;
/// How exactly held stresses are held, as a share of the largest stress.
const EXACT: f64 = 1e-13;

/// A soil element with stress components xx, yy, zz, xy (Pa, tension positive) and engineering shear strain.
#[derive(Debug, Clone)]
pub struct Element<L> {
    law: L,
    /// Stress, Pa.
    pub stress: [f64; 4],
    /// State variables.
    pub state: State,
    /// Strain since the start.
    pub strain: [f64; 4],
}

impl<L: Law> Element<L> {
    /// An element under a first stress (Pa), unstrained.
    pub fn new(law: L, stress: [f64; 4]) -> Self {
        Self { state: law.first_state(&stress), law, stress, strain: [0.0; 4] }
    }

    /// One step: the driven strain increment, and as much of each `free` strain as keeps the stress that does work on it:
    /// `free . (stress - held) = 0`. Newton's method on the consistent tangent.
    ///
    /// # Errors
    /// No stress was found, or the tangent is singular along the free strains.
    pub fn step(&mut self, driven: &[f64; 4], free: &[[f64; 4]], held: &[f64; 4]) -> Result<(), Error> {
        let count = free.len();
        let mut amounts = DVector::zeros(count);
        for _ in 0..MOST {
            let strain: [f64; 4] =
                std::array::from_fn(|s| driven[s] + (0..count).map(|k| amounts[k] * free[k][s]).sum::<f64>());
            let (mut stress, mut state) = (self.stress, self.state);
            self.law.update(&mut stress, &strain, &mut state);
            let over = DVector::from_fn(count, |k, _| (0..4).map(|s| free[k][s] * (stress[s] - held[s])).sum::<f64>());
            let scale = stress.iter().chain(held).fold(0.0_f64, |most, s| most.max(s.abs()));
            if over.amax() <= EXACT * scale {
                for s in 0..4 {
                    self.strain[s] += strain[s];
                }
                (self.stress, self.state) = (stress, state);
                return Ok(());
            }
            let tangent = self.law.tangent(&self.stress, &strain, &self.state);
            let along = DMatrix::from_fn(4, count, |s, k| free[k][s]);
            let matrix = along.transpose() * tangent * &along;
            amounts -= matrix.lu().solve(&over).ok_or(Unfit("the tangent is singular along the free strains"))?;
        }
        Err(Error::Found(format!("no stress that holds {held:?} Pa at strain {:?}", self.strain)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::constitutive::LinearElastic;
    use mpm_core::scene::Elastic;

    #[test]
    fn uniaxial_stress_shows_youngs_modulus() {
        let soil = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };
        let mut element = Element::new(LinearElastic::new(&soil), [-1e4, -1e4, -1e4, 0.0]);
        let aside = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        element.step(&[0.0, -1e-3, 0.0, 0.0], &aside, &[-1e4, 0.0, -1e4, 0.0]).expect("a stress");
        assert!((element.stress[1] + 3e4).abs() < 1e-6 && (element.strain[0] - 3e-4).abs() < 1e-15);
    }
}
