//! Slip circles, by which strength reduction is held against limit equilibrium, against what they must be: Taylor's critical toe
//! circles in clay, and a flat circle in a long slope, which is an infinite slope without and with water that flows along it.

use super::{Error, Lacks, Mutant, Outcome, Program};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};
use crate::exact::limit_equilibrium::factor::Method;
use crate::exact::limit_equilibrium::water::Phreatic;
use crate::exact::limit_equilibrium::{Circle, Limits, Section, Uniform};
use crate::experiment::refinement::RUNS;
use crate::norms::largest;

/// The case.
pub const CASE: Program = Program {
    name: "limit-equilibrium",
    about: "slip circles (Bishop, Spencer) against Taylor's stability numbers and infinite slopes with seepage: factors",
    run: || outcome(1.0),
    mutant: Some(Mutant { what: "cohesion 0.1 % too large", run: || outcome(1.001) }),
};

/// Angle of a slope in clay (degrees) and the least `c/(F gamma H)` of toe circles, from the closed form of one circle minimised over
/// both of its angles.
const TAYLOR: [(f64, f64); 3] = [(53.0, 0.180_314_78), (60.0, 0.190_572_08), (75.0, 0.219_080_28)];
const DRY_WEIGHT: f64 = 17e3;
const SATURATED_WEIGHT: f64 = 20e3;
const WATER_WEIGHT: f64 = 9.81e3;
/// Half of the chord of a circle that is 1 m deep in a slope of 1000 m.
const HALF: f64 = 400.0;

/// Relative errors of the factors; the soil of the circles has its cohesion times a factor.
fn outcome(stronger: f64) -> Result<Outcome, Error> {
    let mut off = Vec::new();
    for (angle, number) in TAYLOR {
        let toe = 1.0 / angle.to_radians().tan();
        let ground = [[-3.0, 1.0], [0.0, 1.0], [toe, 0.0], [toe + 3.0, 0.0]];
        let soil = Uniform::dry(Strength { cohesion: stronger, friction: 0.0 }, 1.0);
        let section = Section::dry(&ground, &soil);
        let limits = Limits {
            least_depth: 0.0,
            least_area: 0.0,
            least_deep: 0.0,
            starts: [-3.0, 0.0],
            ends: [toe, toe],
            slices: 400,
            method: Method::Bishop,
        };
        let critical = section.critical(&limits).ok_or(Lacks("circle"))?;
        off.push(critical.factor * number - 1.0);
    }
    let angle = 20.0_f64.to_radians();
    let ground = [[0.0, 1000.0 * angle.tan()], [1000.0, 0.0]];
    let friction = 30.0_f64.to_radians();
    for share in [0.0, 1.0] {
        let line: &[[f64; 2]] = if share > 0.0 { &ground } else { &[] };
        let water = Phreatic { line, ground: &ground, water_weight: WATER_WEIGHT };
        let strength = Strength { cohesion: stronger * 2e3, friction };
        let soil = Uniform { strength, dry_weight: DRY_WEIGHT, saturated_weight: SATURATED_WEIGHT };
        let section = Section {
            level: &|x| water.level(x),
            pressure: &|x, y| water.parallel(x, y),
            ..Section::dry(&ground, &soil)
        };
        let at = |x: f64| [x, (1000.0 - x) * angle.tan()];
        let half_angle = 2.0 * (angle.cos() * angle.cos() / HALF).atan();
        let circle = Circle::through(at(500.0 - HALF), at(500.0 + HALF), half_angle);
        let slide = section.slide(circle, 2000)?;
        let slope = InfiniteSlope {
            angle,
            dry_weight: DRY_WEIGHT,
            saturated_weight: SATURATED_WEIGHT,
            water_weight: WATER_WEIGHT,
            strength: Strength { cohesion: 2e3, friction },
            seepage: Seepage::Parallel { share },
        };
        // The factor is linear in 1/depth: that of the mean depth counts.
        let exact = slope.factor(slide.area / (2.0 * HALF)).ok_or(Lacks("factor"))?;
        let bishop = slide.bishop()?;
        let [spencer, _] = slide.spencer()?;
        off.extend([bishop / exact - 1.0, spencer / exact - 1.0]);
    }
    Ok(Outcome {
        integrator: "none".to_owned(),
        scheme: "slices".to_owned(),
        errors: vec![(off.len() as f64, largest(off.into_iter()))],
        required_error: 2e-4,
        refined_by: RUNS,
        ..Outcome::default()
    })
}
