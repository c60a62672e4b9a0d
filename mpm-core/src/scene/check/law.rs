//! The law of the skeleton: its elasticity, and its strength if it has one.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::{RawCamClay, RawLaw, RawMohrCoulomb, RawScene, RawSoil};
use super::super::{CamClay, Elastic, Strength};
use super::faults::Faults;
use super::{Checked, Reader};

/// Elasticity, and strength or hardening.
pub(super) type Law = (Elastic, Option<Strength>, Option<CamClay>);

impl Reader<'_> {
    /// A law at a key, of a scene of a height (m).
    pub(super) fn law(&self, key: &str, law: &Spanned<RawLaw>, raw: &RawScene, height: f64) -> Checked<Law> {
        match law.get_ref() {
            RawLaw::LinearElastic(law) => Ok((
                self.elastic(&format!("{key}.linear_elastic"), &law.youngs_modulus, &law.poisson_ratio)?,
                None,
                None,
            )),
            RawLaw::MohrCoulomb(law) => {
                let key = format!("{key}.mohr_coulomb");
                let mut faults = Faults::default();
                let elastic = faults.take(self.elastic(&key, &law.youngs_modulus, &law.poisson_ratio));
                let strength = faults.take(self.strength(&key, law));
                faults.or(elastic.zip(strength).map(|(elastic, strength)| (elastic, Some(strength), None)))
            }
            RawLaw::ModifiedCamClay(clay) => {
                let (soil, elastic) = self.cam_clay((key, law.span()), clay, raw, height)?;
                Ok((elastic, None, Some(soil)))
            }
        }
    }

    /// Hardening, and the elasticity at the largest pressure that the scene is to reach: explicit steps are stable up to there.
    fn cam_clay(
        &self,
        (place, span): (&str, Range<usize>),
        law: &RawCamClay,
        raw: &RawScene,
        height: f64,
    ) -> Checked<(CamClay, Elastic)> {
        let key = |name: &str| format!("{place}.modified_cam_clay.{name}");
        let lambda = self.positive(&law.lambda, &key("lambda"), "strain over ln p")?;
        let kappa = self
            .within(&law.kappa, &key("kappa"), "0 < kappa < lambda", |kappa| kappa > 0.0 && kappa < lambda)
            .map_err(|fault| fault.with(format!("lambda = {lambda}")))?;
        let expected = "-1 < nu < 0.5";
        let poisson_ratio =
            self.within(&law.poisson_ratio, &key("poisson_ratio"), expected, |nu| nu > -1.0 && nu < 0.5)?;
        let pressure = |value: &Option<Spanned<f64>>, name: &str| match value {
            Some(value) => self.within(value, &key(name), "a finite pressure of 0 or more (Pa)", |p| p >= 0.0),
            None => Ok(0.0),
        };
        let soil = CamClay {
            lambda,
            kappa,
            poisson_ratio,
            bulk_modulus: match &law.bulk_modulus {
                Some(value) => Some(self.positive(value, &key("bulk_modulus"), "Pa")?),
                None => None,
            },
            critical_slope: self.positive(&law.critical_slope, &key("critical_slope"), "q/p")?,
            preconsolidation: pressure(&law.preconsolidation, "preconsolidation")?,
            overconsolidation: match &law.overconsolidation {
                Some(value) => self.within(value, &key("overconsolidation"), "1 or more", |ratio| ratio >= 1.0)?,
                None => 1.0,
            },
            attraction: pressure(&law.attraction, "attraction")?,
        };
        let geostatic = raw.start.iter().any(|start| ["geostatic", "given"].contains(&start.get_ref().as_str()));
        let stiff = soil.bulk_modulus.is_some() && soil.preconsolidation > 0.0;
        if !(geostatic || stiff || soil.attraction > 0.0) {
            let expected = "an attraction above 0 (Pa), a bulk_modulus with a preconsolidation above 0, or start = \"geostatic\" \
                            with it: without stress this soil has neither strength nor stiffness";
            return self.refuse(&span, place, expected, "none of them");
        }
        let load = raw.surcharge.as_ref().map_or(0.0, |load| load.get_ref().pressure.get_ref().abs());
        let density = raw.soil.get_ref().grain_density.as_ref().map_or(3e3, |density| *density.get_ref());
        let weight = raw.gravity.as_ref().map_or(0.0, |gravity| gravity.get_ref() * density * height);
        let largest = soil.preconsolidation.max(load + weight) + soil.attraction;
        let bulk = soil.bulk_modulus.unwrap_or(largest / kappa);
        Ok((soil, Elastic { youngs_modulus: 3.0 * bulk * (1.0 - 2.0 * poisson_ratio), poisson_ratio }))
    }

    fn elastic(&self, law: &str, modulus: &Spanned<f64>, ratio: &Spanned<f64>) -> Checked<Elastic> {
        let key = |name: &str| format!("{law}.{name}");
        let mut faults = Faults::default();
        let modulus = faults.take(self.positive(modulus, &key("youngs_modulus"), "Pa"));
        let bounds = |nu: f64| nu > -1.0 && nu < 0.5;
        let ratio = faults.take(self.within(ratio, &key("poisson_ratio"), "-1 < nu < 0.5", bounds));
        let both = modulus.zip(ratio);
        faults.or(both.map(|(youngs_modulus, poisson_ratio)| Elastic { youngs_modulus, poisson_ratio }))
    }

    fn strength(&self, place: &str, law: &RawMohrCoulomb) -> Checked<Strength> {
        let key = |name: &str| format!("{place}.{name}");
        let expected = "a finite cohesion of 0 or more (Pa)";
        let mut faults = Faults::default();
        let cohesion = faults.take(self.within(&law.cohesion, &key("cohesion"), expected, |c| c >= 0.0));
        let expected = "0 <= phi < 90 (degrees)";
        let within = |phi: f64| (0.0..90.0).contains(&phi);
        let friction_angle = faults.take(self.within(&law.friction_angle, &key("friction_angle"), expected, within));
        let (cohesion, friction_angle) = faults.or(cohesion.zip(friction_angle))?;
        if friction_angle == 0.0 && cohesion == 0.0 {
            let expected = "a cohesion above 0 (Pa) with an angle of friction of 0";
            return self.refuse(&law.cohesion.span(), &key("cohesion"), expected, cohesion);
        }
        let dilation_angle = match &law.dilation_angle {
            Some(value) => {
                let expected = "0 <= psi <= phi, the angle of friction (degrees)";
                self.within(value, &key("dilation_angle"), expected, |psi| (0.0..=friction_angle).contains(&psi))
                    .map_err(|fault| fault.with(format!("phi = {friction_angle}")))?
            }
            None => 0.0,
        };
        let dilation_fades_over = law.dilation_fades_over.as_ref();
        let dilation_fades_over = dilation_fades_over
            .map(|value| self.positive(value, &key("dilation_fades_over"), "plastic shear strain"))
            .transpose()?;
        let strength = Strength { cohesion, friction_angle, dilation_angle, tension_cutoff: None, dilation_fades_over };
        let tension_cutoff = match &law.tension_cutoff {
            Some(value) => {
                let apex = strength.apex();
                let expected = "0 <= sigma_t <= c/tan(phi), the apex (Pa)";
                let cutoff =
                    self.within(value, &key("tension_cutoff"), expected, |stress| (0.0..=apex).contains(&stress));
                Some(cutoff.map_err(|fault| fault.with(format!("c/tan(phi) = {apex} Pa")))?)
            }
            None => None,
        };
        Ok(Strength { tension_cutoff, ..strength })
    }

    /// Soil that dilates gains volume without a tension gap.
    pub(super) fn separation(&self, soil: &RawSoil, strength: Option<&Strength>) -> Checked<Option<f64>> {
        let Some(value) = &soil.separation else { return Ok(None) };
        let key = "soil.separation";
        match strength {
            Some(Strength { dilation_angle: 0.0, dilation_fades_over: None, .. }) => {}
            found => {
                let expected = "mohr_coulomb with dilation_angle = 0 from the start";
                let found = match found {
                    Some(Strength { dilation_fades_over: Some(over), .. }) => format!("dilation_fades_over = {over}"),
                    Some(strength) => format!("dilation_angle = {}", strength.dilation_angle),
                    None => "linear_elastic".to_owned(),
                };
                return self.refuse(&value.span(), key, expected, found);
            }
        }
        Ok(Some(self.within(value, key, "0 < strain <= 0.1 (gain of volume)", |e| e > 0.0 && e <= 0.1)?))
    }
}
