//! Triaxial compression, drained and undrained, of normally, lightly and heavily over-consolidated soil.

use mpm_core::constitutive::ModifiedCamClay;
use mpm_core::scene::CamClay;

use super::super::{Error, Mutant, Outcome, Program, Unfit};
use super::{FLATTER, REQUIRED, SOIL, flatter, own};
use crate::element::Element;
use crate::exact::cam_clay::Triaxial;
use crate::experiment::refinement::{Parameter, Sampled};
use crate::norms::largest;

/// Lateral stresses are held.
pub const DRAINED: Program = Program {
    name: "cc-drained",
    about: "Cam-Clay in a drained triaxial cell: strains at a stress ratio",
    run: || drained(own),
    mutant: Some(Mutant { what: FLATTER, run: || drained(flatter) }),
};

/// The volume is held.
pub const UNDRAINED: Program = Program {
    name: "cc-undrained",
    about: "Cam-Clay in an undrained triaxial cell: pressure and strain",
    run: || undrained(own),
    mutant: Some(Mutant { what: FLATTER, run: || undrained(flatter) }),
};

/// p at the start, Pa.
const START: f64 = 1e5;
/// p_c over it.
const RATIOS: [f64; 3] = [1.0, 1.5, 8.0];
/// Paths end where the stress ratio is that near to critical state, as a share of M: strains grow without bound there.
const NEAR: f64 = 0.05;
/// Axial strain increments.
const STEPS: [f64; 4] = [1.6e-5, 8e-6, 4e-6, 2e-6];
/// What is refined.
const STRAIN_STEP: Parameter = ("axial strain increment", "-");
/// Comparison along a path.
const LOOKS: usize = 20;

type Fault = fn(CamClay) -> CamClay;

fn soil(ratio: f64, bulk_modulus: Option<f64>) -> CamClay {
    CamClay { bulk_modulus, preconsolidation: ratio * START, ..SOIL }
}

/// p, q and the deviatoric strain of an element.
fn invariants(element: &Element<ModifiedCamClay>) -> [f64; 3] {
    let [x, y, z, _] = element.stress;
    [-(x + y + z) / 3.0, x - y, 2.0 / 3.0 * (element.strain[0] - element.strain[1])]
}

/// Both values of a look beside the exact ones: `[name, computed, exact, scale]`.
type Values = [(&'static str, f64, f64, f64); 2];

/// Steps an element to the end of its path.
fn path(
    ratio: f64,
    soil: CamClay,
    step: f64,
    advance: impl Fn(&mut Element<ModifiedCamClay>, f64) -> Result<(), Error>,
    compared: impl Fn(&Element<ModifiedCamClay>, bool) -> Values,
) -> Result<Vec<Sampled>, Error> {
    let mut element = Element::new(ModifiedCamClay::new(&soil), [-START, -START, -START, 0.0]);
    let (first, m) = (element.state[0], SOIL.critical_slope);
    let mut samples = Vec::new();
    let mut looked = 0.0;
    loop {
        advance(&mut element, step)?;
        let [p, q, _] = invariants(&element);
        let yielded = element.state[0] != first;
        let eta = q / p;
        let end = yielded && (eta / m - 1.0).abs() < NEAR;
        let along = -element.strain[1];
        if along - looked > 0.4 / LOOKS as f64 || end {
            looked = along;
            for (name, computed, exact, scale) in compared(&element, yielded) {
                samples.push(Sampled {
                    quantity: format!("{name}, p_c/p_0 = {ratio}; the time is the axial strain"),
                    unit: "-".to_owned(),
                    time: along,
                    factor: None,
                    computed: computed / scale,
                    exact: exact / scale,
                    error: (computed - exact) / scale,
                    counts: true,
                });
            }
        }
        if end {
            return Ok(samples);
        }
        if along > 1.0 {
            return Err(Unfit("critical state was not reached"));
        }
    }
}

/// The outcome of paths at all steps.
fn refined(paths: impl Fn(f64) -> Result<Vec<Sampled>, Error>) -> Result<Outcome, Error> {
    let mut errors = Vec::new();
    let mut samples = Vec::new();
    for step in STEPS {
        samples = paths(step)?;
        errors.push((step, largest(samples.iter().map(|s| s.error))));
    }
    Ok(Outcome {
        integrator: "element test".to_owned(),
        scheme: "modified-cam-clay".to_owned(),
        errors,
        required_error: REQUIRED,
        required_order: Some(1.0),
        refined_by: STRAIN_STEP,
        samples,
        ..Outcome::default()
    })
}

fn drained(fault: Fault) -> Result<Outcome, Error> {
    refined(|step| {
        let mut all = Vec::new();
        for bulk in [None, Some(5e6)] {
            for ratio in RATIOS {
                let exact = Triaxial { soil: soil(ratio, bulk), start: START, preconsolidation: ratio * START };
                let end = exact.drained(SOIL.critical_slope * (1.0 - NEAR), true)[1].abs();
                let sideways = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
                let held = [-START, 0.0, -START, 0.0];
                let advance = |element: &mut Element<_>, h: f64| element.step(&[0.0, -h, 0.0, 0.0], &sideways, &held);
                let compared = |element: &Element<_>, yielded: bool| {
                    let [p, q, shear] = invariants(element);
                    let volume = -(element.strain[0] + element.strain[1] + element.strain[2]);
                    let strains = exact.drained(q / p, yielded);
                    [("change of volume", volume, strains[0], end), ("deviatoric strain", shear, strains[1], end)]
                };
                all.extend(path(ratio, fault(exact.soil), step, advance, compared)?);
            }
        }
        Ok(all)
    })
}

fn undrained(fault: Fault) -> Result<Outcome, Error> {
    refined(|step| {
        let mut all = Vec::new();
        for ratio in RATIOS {
            let exact = Triaxial { soil: soil(ratio, None), start: START, preconsolidation: ratio * START };
            let end = exact.undrained(SOIL.critical_slope * (1.0 - NEAR), true)[1].abs();
            let advance = |element: &mut Element<_>, h: f64| element.step(&[0.5 * h, -h, 0.5 * h, 0.0], &[], &[0.0; 4]);
            let compared = |element: &Element<_>, yielded: bool| {
                let [p, q, shear] = invariants(element);
                let [expected, strain] = exact.undrained(q / p, yielded);
                [("p/p_0", p, expected, START), ("deviatoric strain", shear, strain, end)]
            };
            all.extend(path(ratio, fault(exact.soil), step, advance, compared)?);
        }
        Ok(all)
    })
}
