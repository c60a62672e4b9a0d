//! Circles against closed forms: undrained moment balance, infinite slopes, sand, and what water must do.

use super::factor::Method;
use super::water::Phreatic;
use super::{Circle, Limits, Refused, Section, Slide, Uniform};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};

/// Level ground of height `height` at the left, a slope at `angle` (degrees) from x = 0 on, level ground at y = 0.
fn ground(height: f64, angle: f64, beside: f64) -> [[f64; 2]; 4] {
    let toe = height / angle.to_radians().tan();
    [[-beside, height], [0.0, height], [toe, 0.0], [toe + beside, 0.0]]
}

/// Factor of safety without friction, without slices: `c R arc/moment of the weight`.
///
/// What slides is a polygon between ground and chord, and the segment below the chord, whose first moment about the
/// centre is chord^3/12 along the line to the middle of the chord.
fn undrained(ground: &[[f64; 2]], slide: &Slide, cohesion: f64, weight: f64) -> f64 {
    let (centre, radius) = (slide.circle.centre, slide.circle.radius);
    let inner = ground.iter().filter(|corner| corner[0] > slide.entry[0] && corner[0] < slide.exit[0]);
    let mut corners: Vec<_> = std::iter::once(&slide.entry).chain(inner).chain([&slide.exit]).copied().collect();
    // Anticlockwise.
    corners.reverse();
    let next = corners.iter().cycle().skip(1);
    let polygon: f64 = corners
        .iter()
        .zip(next)
        .map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) * ((a[0] + b[0]) / 6.0 - 0.5 * centre[0]))
        .sum();
    let chord = (slide.exit[0] - slide.entry[0]).hypot(slide.exit[1] - slide.entry[1]);
    let middle = 0.5 * (slide.entry[0] + slide.exit[0]) - centre[0];
    let half = (0.5 * chord / radius).asin();
    let segment = chord.powi(3) / 12.0 * middle / (radius * half.cos());
    cohesion * radius * radius * 2.0 * half / (-weight * (polygon + segment))
}

const CLAY: Strength = Strength { cohesion: 20e3, friction: 0.0 };

#[test]
fn circles_without_friction_balance_their_moments() {
    let ground = ground(6.0, 40.0, 20.0);
    let soil = Uniform::dry(CLAY, 18e3);
    let section = Section::dry(&ground, &soil);
    let on = |x: f64| [x, 6.0 - x * 40.0_f64.to_radians().tan()];
    // A toe circle, one on the slope, one deep below the toe, one from the slope to the floor.
    for (left, right, half_angle) in [
        ([-2.0, 6.0], ground[2], 0.7),
        ([-1.0, 6.0], on(5.0), 0.4),
        ([-5.0, 6.0], [12.0, 0.0], 1.1),
        (on(2.0), [14.0, 0.0], 0.9),
    ] {
        let slide = section.slide(Circle::through(left, right, half_angle), 4000).expect("a slide");
        for (end, wanted) in [(slide.entry, left), (slide.exit, right)] {
            assert!((end[0] - wanted[0]).abs() < 1e-12 && (end[1] - wanted[1]).abs() < 1e-12, "{end:?} {wanted:?}");
        }
        let exact = undrained(&ground, &slide, CLAY.cohesion, 18e3);
        let (bishop, ordinary) = (slide.bishop().expect("a factor"), slide.ordinary().expect("a factor"));
        assert!((bishop / exact - 1.0).abs() < 5e-6, "{bishop} {exact}");
        assert!((bishop / ordinary - 1.0).abs() < 1e-12, "without friction both are the same");
    }
}

#[test]
fn critical_toe_circles_in_clay_have_the_stability_numbers_of_taylor() {
    // N = c/(F gamma H). Printed: Taylor 1937, J. Boston Soc. Civ. Eng. 24(3), as textbooks tabulate it, phi = 0,
    // critical circles through the toe. To eight digits: least closed form over both angles of the circle, computed
    // apart from this code.
    for (angle, printed, minimised) in
        [(53.0, 0.181, 0.180_314_78), (60.0, 0.191, 0.190_572_08), (75.0, 0.219, 0.219_080_28)]
    {
        let ground = ground(1.0, angle, 3.0);
        let soil = Uniform::dry(Strength { cohesion: 1.0, friction: 0.0 }, 1.0);
        let section = Section::dry(&ground, &soil);
        let toe = ground[2][0];
        let limits = Limits {
            least_depth: 0.0,
            least_area: 0.0,
            least_deep: 0.0,
            starts: [-3.0, 0.0],
            ends: [toe, toe],
            slices: 400,
            method: Method::Bishop,
        };
        let critical = section.critical(&limits).expect("a circle");
        let number = 1.0 / critical.factor;
        assert!((number - minimised).abs() < 1e-5, "{angle}: {number}");
        assert!((number - printed).abs() < 8e-4, "{angle}: {number}");
        let exact = undrained(&ground, &critical.slide, 1.0, 1.0);
        assert!((critical.factor / exact - 1.0).abs() < 3e-5);
        // Steeper than 53 degrees no other circle is worse.
        if angle > 53.0 {
            let all = section.critical(&Limits { ends: [0.0, toe + 3.0], ..limits }).expect("a circle");
            assert!((all.factor / critical.factor - 1.0).abs() < 1e-4, "{angle}: {} {:?}", all.factor, all.slide.exit);
        }
    }
}

#[test]
fn the_factor_converges_with_the_square_of_the_slices() {
    let ground = ground(12.0, 26.565_051_177, 20.0);
    let water = Phreatic { line: &[[-20.0, 9.0], [24.0, 0.0]], ground: &ground, water_weight: 9.81e3 };
    let strength = Strength { cohesion: 10e3, friction: 0.4 };
    let soil = Uniform { saturated_weight: 20e3, ..Uniform::dry(strength, 17e3) };
    let section = Section {
        level: &|x| water.level(x),
        pressure: &|x, y| water.hydrostatic(x, y),
        ..Section::dry(&ground, &soil)
    };
    let circle = Circle::through([-4.0, 12.0], [28.0, 0.0], 0.8);
    let factor = |slices: usize| section.slide(circle, slices).expect("a slide").bishop().expect("a factor");
    let exact = factor(40_000);
    let errors = [25, 100, 400].map(|slices| (factor(slices) - exact).abs());
    println!("errors {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log(4.0);
        assert!((order - 2.0).abs() < 0.35, "{errors:?} {order}");
    }
    assert!(errors[1] < 1e-3);
}

#[test]
fn a_flat_circle_in_a_long_slope_is_an_infinite_slope() {
    let angle = 20.0_f64.to_radians();
    let ground = [[0.0, 1000.0 * angle.tan()], [1000.0, 0.0]];
    let strength = Strength { cohesion: 2e3, friction: 30.0_f64.to_radians() };
    for share in [0.0, 1.0] {
        let line: &[[f64; 2]] = if share > 0.0 { &ground } else { &[] };
        let water = Phreatic { line, ground: &ground, water_weight: 9.81e3 };
        let soil = Uniform { saturated_weight: 20e3, ..Uniform::dry(strength, 17e3) };
        let section = Section {
            level: &|x| water.level(x),
            pressure: &|x, y| water.parallel(x, y),
            ..Section::dry(&ground, &soil)
        };
        let at = |x: f64| [x, (1000.0 - x) * angle.tan()];
        // One metre deep in the middle of ever longer chords.
        let errors = [25.0, 100.0, 400.0].map(|half: f64| {
            let sagitta = angle.cos();
            let half_angle = 2.0 * (sagitta * angle.cos() / half).atan();
            let circle = Circle::through(at(500.0 - half), at(500.0 + half), half_angle);
            let slide = section.slide(circle, 2000).expect("a slide");
            let slope = InfiniteSlope {
                angle,
                dry_weight: 17e3,
                saturated_weight: 20e3,
                water_weight: 9.81e3,
                strength,
                seepage: Seepage::Parallel { share },
            };
            // The factor is linear in 1/depth: that of the mean depth counts.
            let mean = slide.area / (slide.exit[0] - slide.entry[0]);
            assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
            let exact = slope.factor(mean).expect("a factor");
            let (bishop, spencer) = (slide.bishop().expect("a factor"), slide.spencer().expect("a factor")[0]);
            assert!((spencer / bishop - 1.0).abs() < 1e-3, "{spencer} {bishop}");
            (bishop / exact - 1.0).abs()
        });
        println!("errors {errors:?}");
        assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] < 1e-4, "{errors:?}");
    }
}

#[test]
fn sand_slides_at_its_surface() {
    let ground = ground(5.0, 25.0, 10.0);
    let sand = Strength { cohesion: 0.0, friction: 35.0_f64.to_radians() };
    let soil = Uniform::dry(sand, 17e3);
    let section = Section::dry(&ground, &soil);
    let surface = sand.friction.tan() / 25.0_f64.to_radians().tan();
    let toe = ground[2][0];
    let mut last = f64::INFINITY;
    for least_depth in [1.0, 0.3, 0.1, 0.01] {
        let limits = Limits {
            least_depth,
            least_area: 0.0,
            least_deep: 0.0,
            starts: [-10.0, toe],
            ends: [0.0, toe + 10.0],
            slices: 100,
            method: Method::Bishop,
        };
        let critical = section.critical(&limits).expect("a circle");
        assert!(
            (critical.slide.depth / least_depth - 1.0).abs() < 2e-3,
            "as shallow as allowed: {}",
            critical.slide.depth
        );
        assert!(critical.factor > surface && critical.factor < last, "{} {surface}", critical.factor);
        last = critical.factor;
    }
    assert!(last / surface - 1.0 < 1e-3, "{last} {surface}");
    // The least area does the same as a least depth.
    let limits = Limits {
        least_depth: 0.0,
        least_area: 2.0,
        least_deep: 0.0,
        starts: [-10.0, toe],
        ends: [0.0, toe + 10.0],
        slices: 100,
        method: Method::Bishop,
    };
    let critical = section.critical(&limits).expect("a circle");
    assert!((critical.slide.area / 2.0 - 1.0).abs() < 0.01 && critical.factor > surface, "{}", critical.slide.area);
}

#[test]
fn water_takes_strength_and_only_positive_pressure_counts() {
    let ground = ground(5.0, 30.0, 10.0);
    let strength = Strength { cohesion: 5e3, friction: 0.5 };
    let circle = Circle::through([-1.5, 5.0], [ground[2][0], 0.0], 0.6);
    let soil = Uniform::dry(strength, 18e3);
    let factor = |pressure: &dyn Fn(f64, f64) -> f64| {
        let section = Section { pressure, ..Section::dry(&ground, &soil) };
        let slide = section.slide(circle, 200).expect("a slide");
        let (bishop, ordinary) = (slide.bishop().expect("a factor"), slide.ordinary().expect("a factor"));
        assert!(bishop > ordinary, "{bishop} {ordinary}");
        bishop
    };
    let (without, half, full) = (factor(&|_, _| 0.0), factor(&|_, y| 2e3 * (3.0 - y)), factor(&|_, y| 4e3 * (3.0 - y)));
    assert!(without > half && half > full, "{without} {half} {full}");
    assert_eq!(without, factor(&|_, _| -20e3), "suction is left out");
}

#[test]
fn circles_without_a_factor_say_why() {
    let ground = ground(5.0, 30.0, 10.0);
    let soil = Uniform::dry(Strength { cohesion: 5e3, friction: 0.5 }, 18e3);
    let section = Section::dry(&ground, &soil);
    let slide = |centre, radius| section.slide(Circle { centre, radius }, 50);
    assert_eq!(slide([0.0, 30.0], 10.0), Err(Refused::Outside));
    assert_eq!(slide([-2.0, 4.0], 4.0), Err(Refused::Open), "overhangs");
    assert_eq!(slide([5.0, 30.0], 34.0), Err(Refused::Open), "goes through the ends");
    let soil = Uniform::dry(Strength { cohesion: 0.0, friction: 1.2 }, 18e3);
    let sand = Section::dry(&ground, &soil);
    let mirror = [[-20.0, 0.0], [-10.0, 0.0], [0.0, 5.0], [10.0, 5.0]];
    let back = Section { ground: &mirror, ..sand };
    // The slope falls the other way.
    let slide = back.slide(Circle { centre: [-7.0, 8.0], radius: 8.2 }, 100).expect("a slide");
    assert_eq!(slide.ordinary(), Err(Refused::NotDriven));
    assert!(slide.bishop().is_err() && slide.spencer().is_err(), "{:?}", slide.bishop());
    // A passive end of 41 degrees in rough sand: m is 0.2 at a factor of 3.1. Dry the slide has more, wet it would
    // have less.
    let circle = Circle { centre: [7.5, 4.0], radius: 5.4 };
    let dry = sand.slide(circle, 100).expect("a slide").bishop();
    assert!(dry.is_ok_and(|factor| factor > 3.1), "{dry:?}");
    let wet = Section { pressure: &|_, _| 20e3, ..sand }.slide(circle, 100).expect("a slide").bishop();
    assert_eq!(wet, Err(Refused::TooSteep));
}
