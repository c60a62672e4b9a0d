//! The paper's levee: what its factors must do, and their values.

use mpm_core::scene::NormalStress;

use super::factor::Method;
use super::levee::{Levee, LeveeFactors};
use super::water::Equipotentials;
use super::{Critical, FirmBase};
use crate::exact::infinite_slope::Strength;

/// Water levels (x, y), m: a straight line from the tank, and levels when the water has come to the toe.
const STRAIGHT: [[f64; 2]; 2] = [[0.0, 2.3], [8.35, 0.0]];
const LATE: [[f64; 2]; 6] = [[0.0, 2.3], [2.0, 1.94], [4.0, 1.52], [6.0, 1.05], [7.0, 0.79], [8.0, 0.48]];
/// Least depth of the slides, m.
const DEPTH: f64 = 0.3;

fn levee(base_angle: f64) -> Levee {
    let strength = Strength { cohesion: 0.0, friction: base_angle.to_radians() };
    Levee::paper(FirmBase { height: 0.0, strength, normal_stress: NormalStress::Effective })
}

fn factors(base_angle: f64, line: &[[f64; 2]], equipotentials: Equipotentials) -> LeveeFactors {
    let levee = levee(base_angle);
    levee.factors(line, equipotentials, &levee.limits(DEPTH, Method::Bishop))
}

fn value(critical: &Option<Critical>) -> f64 {
    critical.as_ref().expect("a slide").factor
}

#[test]
fn water_weak_bases_and_lost_dilation_take_strength() {
    let all = [(30.0, Equipotentials::Vertical), (30.0, Equipotentials::Normal), (8.5, Equipotentials::Vertical)]
        .map(|(angle, equipotentials)| factors(angle, &LATE, equipotentials));
    for LeveeFactors { full, reduced } in &all {
        assert!(value(&full.wet) < value(&full.dry) && value(&reduced.wet) < value(&reduced.dry));
        // Without dilation cohesion and tan(phi) are both cos(phi) of what they were, those of the contact are not.
        for (less, more) in [(&reduced.dry, &full.dry), (&reduced.wet, &full.wet)] {
            let ratio = value(less) / value(more);
            assert!(ratio > 30.0_f64.to_radians().cos() - 1e-4 && ratio < 1.0, "{ratio}");
        }
    }
    let [rough, along, smooth] = &all;
    // Dry sand on a base as rough as itself has tan(phi)/tan(beta); cohesion adds to it.
    assert!(value(&rough.full.dry) > 2.0 * rough.full.strength.friction.tan());
    assert!(value(&rough.reduced.dry) > 2.0 * rough.reduced.strength.friction.tan());
    // Equipotentials normal to the line leave less pressure; a smooth base holds less.
    assert!(value(&along.full.wet) > value(&rough.full.wet));
    assert!(value(&smooth.full.dry) < value(&rough.full.dry) && value(&smooth.full.wet) < value(&rough.full.wet));
    // Water that leaves the slope horizontally everywhere is the worst there is, and stands no deeper than 0.12 m.
    let toe = rough.full.toe.expect("a factor");
    assert!(toe < value(&rough.full.wet) && rough.full.toe_depth.is_some_and(|depth| (0.1..0.12).contains(&depth)));
    // The slide comes out at the toe, not below the base.
    let slide = &rough.full.wet.as_ref().expect("a slide").slide;
    assert!((slide.exit[0] - 9.0).abs() < 0.01 && slide.points().iter().all(|point| point[1] >= 0.0));
    assert!(slide.depth >= 0.99 * DEPTH);
}

/// Factors of dry slides, slides below the straight line and below the late levels, with the strength and Davis'
/// reduced one; slides at least 0.3 m deep, hydrostatic pressure, friction of the base alone.
fn values(base_angle: f64, method: Method) -> [[f64; 3]; 2] {
    let levee = levee(base_angle);
    let limits = levee.limits(DEPTH, method);
    [levee.strength, levee.strength.reduced(levee.dilation)].map(|strength| {
        [&[][..], &STRAIGHT, &LATE].map(|line| {
            let critical = levee.critical(strength, line, Equipotentials::Vertical, &limits).expect("a slide");
            let (factor, slide) = (critical.factor, &critical.slide);
            let [bishop, spencer] = [slide.factor(Method::Bishop), slide.factor(Method::Spencer)];
            println!(
                "base {base_angle} degrees, tan(phi) {:.3}, {method:?} {factor:.4} (Bishop {:.4}, Spencer {:.4}): from \
                 ({:.2}, {:.2}) to ({:.2}, {:.2}), depth {:.2} m, area {:.2} m2, centre ({:.2}, {:.2}), radius {:.2} m, \
                 tension {:.2}",
                strength.friction.tan(),
                bishop.unwrap_or(f64::NAN),
                spencer.unwrap_or(f64::NAN),
                slide.entry[0],
                slide.entry[1],
                slide.exit[0],
                slide.exit[1],
                slide.depth,
                slide.area,
                slide.circle.centre[0],
                slide.circle.centre[1],
                slide.circle.radius,
                slide.tension(factor),
            );
            factor
        })
    })
}

/// What this code found when it was written: regression, no truth.
fn unchanged(found: [[f64; 3]; 2], before: [[f64; 3]; 2]) {
    for (found, before) in found.as_flattened().iter().zip(before.as_flattened()) {
        assert!((found - before).abs() < 2e-3, "{found} {before}");
    }
}

#[test]
fn values_on_a_rough_base() {
    unchanged(values(30.0, Method::Bishop), [[1.3507, 1.2863, 0.9033], [1.1806, 1.1539, 0.8329]]);
    unchanged(values(30.0, Method::Spencer), [[1.3624, 1.3283, 0.9619], [1.1863, 1.1719, 0.8677]]);
}

#[test]
fn values_on_the_base_of_the_paper() {
    unchanged(values(8.5, Method::Bishop), [[0.9257, 0.7550, 0.4197], [0.8433, 0.6962, 0.3987]]);
    unchanged(values(8.5, Method::Spencer), [[0.9343, 0.7562, 0.4500], [0.8550, 0.7024, 0.4303]]);
}
