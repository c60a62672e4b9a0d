//! One-dimensional compression from an isotropic stress: to K_0, along the curve that ordinary differential equations give.

use mpm_core::constitutive::ModifiedCamClay;
use mpm_core::scene::CamClay;

use super::super::{Error, Lacks, Mutant, Outcome, Program};
use super::{FLATTER, REQUIRED, SOIL, flatter, own};
use crate::element::Element;
use crate::exact::cam_clay::at_rest;
use crate::exact::oracle::Table;
use crate::experiment::refinement::{Parameter, Sampled};
use crate::norms::largest;

/// The case.
pub const CASE: Program = Program {
    name: "cc-oedometer",
    about: "Cam-Clay that does not strain sideways: stresses, and K_0 at the end",
    run: || outcome(own),
    mutant: Some(Mutant { what: FLATTER, run: || outcome(flatter) }),
};

/// Stress at the start, Pa.
const START: f64 = 5e3;
/// Steps between the rows of the table.
const PARTS: [u32; 4] = [64, 128, 256, 512];
/// What is refined.
const PART: Parameter = ("step, share of a row", "-");

fn outcome(fault: fn(CamClay) -> CamClay) -> Result<Outcome, Error> {
    let table = Table::parse(include_str!("../../../../reference-data/exact/13_cam_clay_oedometer.csv"));
    let rows = table.rows(["eps", "sigma_v_over_a", "K0"]);
    let rest = at_rest(&SOIL).ok_or(Lacks("K_0"))?;
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for parts in PARTS {
        samples.clear();
        let mut element = Element::new(ModifiedCamClay::new(&fault(SOIL)), [-START, -START, -START, 0.0]);
        let mut from = 0.0;
        let look = |quantity: &str, time: f64, computed: f64, exact: f64| Sampled {
            quantity: format!("{quantity}; the time is the strain"),
            unit: "-".to_owned(),
            time,
            factor: None,
            computed,
            exact,
            error: computed / exact - 1.0,
            counts: true,
        };
        for [strain, vertical, ratio] in &rows {
            for _ in 0..parts {
                element.step(&[0.0, -(strain - from) / f64::from(parts), 0.0, 0.0], &[], &[0.0; 4])?;
            }
            from = *strain;
            let [x, y, ..] = element.stress;
            samples.push(look("vertical stress over the first", from, -y / START, *vertical));
            samples.push(look("lateral over vertical stress", from, x / y, *ratio));
        }
        let [x, y, ..] = element.stress;
        samples.push(look("K_0", from, x / y, rest));
        errors.push((1.0 / f64::from(parts), largest(samples.iter().map(|s| s.error))));
    }
    Ok(Outcome {
        integrator: "element test".to_owned(),
        scheme: "modified-cam-clay".to_owned(),
        errors,
        required_error: REQUIRED,
        required_order: Some(1.0),
        refined_by: PART,
        samples,
        ..Outcome::default()
    })
}
