//! The law of the skeleton: its elasticity, and its strength if it has one.

use toml::Spanned;

use super::super::raw::{RawLaw, RawMohrCoulomb, RawSoil};
use super::super::{Elastic, Strength};
use super::{Checked, Reader};

impl Reader<'_> {
    pub(super) fn law(&self, soil: &RawSoil) -> Checked<(Elastic, Option<Strength>)> {
        match soil.law.get_ref() {
            RawLaw::LinearElastic(law) => {
                Ok((self.elastic("linear_elastic", &law.youngs_modulus, &law.poisson_ratio)?, None))
            }
            RawLaw::MohrCoulomb(law) => {
                let elastic = self.elastic("mohr_coulomb", &law.youngs_modulus, &law.poisson_ratio)?;
                Ok((elastic, Some(self.strength(law)?)))
            }
        }
    }

    fn elastic(&self, law: &str, modulus: &Spanned<f64>, ratio: &Spanned<f64>) -> Checked<Elastic> {
        let key = |name: &str| format!("soil.law.{law}.{name}");
        Ok(Elastic {
            youngs_modulus: self.positive(modulus, &key("youngs_modulus"), "Pa")?,
            poisson_ratio: self.within(ratio, &key("poisson_ratio"), "-1 < nu < 0.5", |nu| nu > -1.0 && nu < 0.5)?,
        })
    }

    fn strength(&self, law: &RawMohrCoulomb) -> Checked<Strength> {
        let key = |name: &str| format!("soil.law.mohr_coulomb.{name}");
        let expected = "a finite cohesion of 0 or more (Pa)";
        let cohesion = self.within(&law.cohesion, &key("cohesion"), expected, |c| c >= 0.0)?;
        let expected = "0 <= phi < 90 (degrees)";
        let within = |phi: f64| (0.0..90.0).contains(&phi);
        let friction_angle = self.within(&law.friction_angle, &key("friction_angle"), expected, within)?;
        if friction_angle == 0.0 && cohesion == 0.0 {
            let expected = "a cohesion above 0 (Pa) beside an angle of friction of 0";
            return self.refuse(&law.cohesion.span(), &key("cohesion"), expected, cohesion);
        }
        let dilation_angle = match &law.dilation_angle {
            Some(value) => {
                let expected = format!("0 <= psi <= {friction_angle}, the angle of friction (degrees)");
                self.within(value, &key("dilation_angle"), &expected, |psi| (0.0..=friction_angle).contains(&psi))?
            }
            None => 0.0,
        };
        let strength = Strength { cohesion, friction_angle, dilation_angle, tension_cutoff: None };
        let tension_cutoff = match &law.tension_cutoff {
            Some(value) => {
                let apex = strength.apex();
                let expected = format!("0 <= sigma_t <= {apex} Pa, the apex c/tan(phi)");
                Some(self.within(value, &key("tension_cutoff"), &expected, |stress| (0.0..=apex).contains(&stress))?)
            }
            None => None,
        };
        Ok(Strength { tension_cutoff, ..strength })
    }

    /// Soil that dilates gains volume without coming apart.
    pub(super) fn separation(&self, soil: &RawSoil, strength: Option<&Strength>) -> Checked<Option<f64>> {
        let Some(value) = &soil.separation else { return Ok(None) };
        let key = "soil.separation";
        match strength {
            Some(Strength { dilation_angle: 0.0, .. }) => {}
            found => {
                let expected = "mohr_coulomb without dilation beside it";
                let found =
                    found.map_or("linear_elastic".to_owned(), |s| format!("dilation_angle = {}", s.dilation_angle));
                return self.refuse(&value.span(), key, expected, found);
            }
        }
        Ok(Some(self.within(value, key, "0 < strain <= 0.1 (gain of volume)", |e| e > 0.0 && e <= 0.1)?))
    }
}
