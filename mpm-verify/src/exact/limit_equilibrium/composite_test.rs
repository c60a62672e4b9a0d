//! Circles cut by a firm base: closed forms without friction in the soil, and Fredlund & Krahn 1977, cases 2 and 6.

use mpm_core::scene::NormalStress;

use super::published_test::{LINE, agree, published};
use super::{Circle, FirmBase, Refused, Section, Slide, Uniform};
use crate::exact::infinite_slope::Strength;
use crate::exact::quadrature::integral;

const LEVEE: [[f64; 2]; 4] = [[0.0, 3.0], [3.0, 3.0], [9.0, 0.0], [15.0, 0.0]];
const WEIGHT: f64 = 18e3;
const PORE: f64 = 4e3;

/// A slope of clay without friction on a base with adhesion and friction, under a uniform pore pressure.
fn slide(circle: Circle, height: f64, normal_stress: NormalStress, slices: usize) -> Result<Slide, Refused> {
    let base = FirmBase { height, strength: Strength { cohesion: 2e3, friction: 0.2 }, normal_stress };
    let soil = Uniform::dry(Strength { cohesion: 5e3, friction: 0.0 }, WEIGHT);
    let section = Section { base: Some(base), pressure: &|_, _| PORE, ..Section::dry(&LEVEE, &soil) };
    section.slide(circle, slices)
}

/// The same balance by integrals: on the level base `P = W` whatever F is, so that its weight has no moment left and
/// F is `[c R arc + y_c int (c_b + (gamma h - u) tan phi_b) dx]/(moment of the weight above the arc)`.
fn balance(circle: Circle, pore: f64) -> f64 {
    let [x, y] = circle.centre;
    let half = (circle.radius * circle.radius - y * y).sqrt();
    let ground = |x: f64| if x < 3.0 { 3.0 } else { 0.5 * (9.0 - x) };
    // Where the arc enters the crest, and where it meets the base.
    let entry = x - (circle.radius * circle.radius - (y - 3.0) * (y - 3.0)).sqrt();
    let (first, toe) = (x - half, 9.0);
    assert!(entry < 3.0 && first > 3.0 && x + half > toe);
    let moment = |from: f64, to: f64| {
        integral(|left, _| (ground(from + left) - circle.bottom(from + left)) * (x - from - left), from, to)
    };
    let arc = ((x - entry) / circle.radius).asin() - ((x - first) / circle.radius).asin();
    let base = integral(|left, _| 2e3 + (WEIGHT * ground(first + left) - pore) * 0.2_f64.tan(), first, toe);
    let resisting = 5e3 * circle.radius * circle.radius * arc + y * base;
    resisting / (WEIGHT * (moment(entry, 3.0) + moment(3.0, first)))
}

#[test]
fn a_circle_cut_by_the_base_balances_its_moments() {
    for circle in [
        Circle { centre: [8.0, 6.0], radius: 7.0 },
        Circle { centre: [9.5, 9.0], radius: 9.8 },
        Circle { centre: [7.5, 3.5], radius: 5.5 },
    ] {
        for (normal_stress, pore) in [(NormalStress::Effective, PORE), (NormalStress::Total, 0.0)] {
            let slide = slide(circle, 0.0, normal_stress, 4000).expect("a slide");
            assert!((slide.exit[0] - 9.0).abs() < 1e-12, "it comes out at the toe: {:?}", slide.exit);
            let exact = balance(circle, pore);
            let found = slide.bishop().expect("a factor");
            assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
            let ordinary = slide.ordinary().expect("a factor");
            assert!((ordinary / exact - 1.0).abs() < 1e-5, "on a level base P = W as well: {ordinary} {exact}");
        }
    }
}

#[test]
fn a_base_below_the_circle_changes_nothing() {
    let circle = Circle { centre: [7.0, 6.5], radius: 5.8 };
    let factor = |height: f64| slide(circle, height, NormalStress::Effective, 300).expect("a slide").bishop();
    assert_eq!(factor(-3.0), factor(-30.0));
    // A base that the circle only just touches hardly does.
    let (touched, free) = (factor(0.7 + 1e-9).expect("a factor"), factor(0.7 - 1e-9).expect("a factor"));
    assert!((touched / free - 1.0).abs() < 1e-3, "{touched} {free}");
}

/// The same with moments about a place 4 m higher.
fn raised(slide: &Slide) -> Slide {
    let mut moved = slide.clone();
    moved.circle.centre[1] += 4.0;
    for slice in &mut moved.slices {
        let [x, y] = [slice.base[0] - moved.circle.centre[0], slice.base[1] - moved.circle.centre[1]];
        let [sin, cos] = slice.slope;
        slice.arms = [-(x * sin + y * cos), y * sin - x * cos];
    }
    moved
}

#[test]
fn without_friction_spencers_factor_of_a_broken_line_balances_forces_as_well() {
    let soil = Uniform::dry(Strength { cohesion: 9e3, friction: 0.0 }, WEIGHT);
    let line = [[1.5, 3.0], [2.5, 1.6], [4.5, 0.3], [7.0, -0.5], [9.5, -0.6], [11.0, 0.0]];
    let slide = Section::dry(&LEVEE, &soil).along(&line, [10.4, 7.0], 400).expect("a slide");
    let slides = [slide.clone(), raised(&slide)];
    let spencer = slides.each_ref().map(|slide| slide.spencer().expect("a factor")[0]);
    assert!((spencer[0] / spencer[1] - 1.0).abs() < 1e-9, "{spencer:?}");
    // By a separate program: 1.4708. The balance of moments alone depends on the centre.
    assert!((spencer[0] - 1.4708).abs() < 1e-3, "{spencer:?}");
    let moments = slides.map(|slide| slide.bishop().expect("a factor"));
    assert!((moments[0] / moments[1] - 1.0).abs() > 0.01, "{moments:?}");
}

#[test]
fn only_spencers_factor_does_not_depend_on_the_centre_of_moments() {
    let base = FirmBase {
        height: 0.0,
        strength: Strength { cohesion: 0.0, friction: 0.3 },
        normal_stress: NormalStress::Effective,
    };
    let soil = Uniform::dry(Strength { cohesion: 500.0, friction: 0.5 }, WEIGHT);
    let pressure = &|_: f64, y: f64| 1e3 * (2.0 - y);
    let section = Section { base: Some(base), pressure, ..Section::dry(&LEVEE, &soil) };
    let slide = section.slide(Circle { centre: [10.4, 7.0], radius: 8.4 }, 400).expect("a slide");
    let moved = raised(&slide);
    let bishop = [slide.bishop(), moved.bishop()].map(|factor| factor.expect("a factor"));
    let spencer = [slide.spencer(), moved.spencer()].map(|found| found.expect("a factor")[0]);
    println!("Bishop {bishop:?}, Spencer {spencer:?}");
    assert!((spencer[0] / spencer[1] - 1.0).abs() < 1e-9, "{spencer:?}");
    // The bound is Fredlund, Zhang & Lam's.
    assert!((bishop[0] / bishop[1] - 1.0).abs() > 1e-3 && (bishop[0] / bishop[1] - 1.0).abs() < 0.12, "{bishop:?}");
}

#[test]
fn composite_surfaces_of_fredlund_and_krahn() {
    // The paper has a thin weak layer (c = 0, 10 degrees) on bedrock; the centre of moments stays. Published:
    // ordinary 1.288 and 1.171, Bishop 1.377 and 1.248, Spencer 1.373 and 1.245, dry and with the piezometric line.
    // The height of the layer, 16.8 ft, was read from the drawing by others: the tolerance is what half a foot does.
    // They compute 1.299 and 1.173, 1.381 and 1.242.
    for (line, ordinary, bishop, spencer, slope) in
        [(&[][..], 1.288, 1.377, 1.373, 0.185), (&LINE[..], 1.171, 1.248, 1.245, 0.121)]
    {
        let base = FirmBase {
            height: 16.8,
            strength: Strength { cohesion: 0.0, friction: 10.0_f64.to_radians() },
            normal_stress: NormalStress::Effective,
        };
        agree(&published(line, Some(base)), [ordinary, bishop, spencer], slope, [0.022, 0.017, 0.017]);
    }
}
