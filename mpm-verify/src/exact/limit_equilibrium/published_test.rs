//! Published examples: Fredlund & Krahn 1977, cases 1 and 5, and the first slope of the ACADS study.

use super::factor::Method;
use super::water::Phreatic;
use super::{Circle, FirmBase, Limits, Section, Slide, Uniform};
use crate::exact::infinite_slope::Strength;

/// Feet and pounds of the paper's drawing: 40 ft at 2:1 above 20 ft.
const GROUND: [[f64; 2]; 4] = [[0.0, 60.0], [60.0, 60.0], [140.0, 20.0], [160.0, 20.0]];
/// 600 psf and 20 degrees.
const SOIL: Strength = Strength { cohesion: 600.0, friction: 20.0 * std::f64::consts::PI / 180.0 };
/// The paper's circle: the centre is printed, the radius of 80 ft is that of its drawing as other programs carry it.
const CIRCLE: Circle = Circle { centre: [120.0, 90.0], radius: 80.0 };
/// Piezometric line, as other programs carry it: it falls from 20 ft below the crest to the toe.
pub(super) const LINE: [[f64; 2]; 2] = [[0.0, 40.0], [140.0, 20.0]];
/// Unit weights of soil and water, pcf.
const WEIGHTS: [f64; 2] = [120.0, 62.4];

/// The slide of the paper on its circle, dry or under a piezometric line, and on a base.
pub(super) fn published(line: &[[f64; 2]], base: Option<FirmBase>) -> Slide {
    let water = Phreatic { line, ground: &GROUND, water_weight: WEIGHTS[1] };
    let soil = Uniform::dry(SOIL, WEIGHTS[0]);
    let section = Section {
        base,
        level: &|x| water.level(x),
        pressure: &|x, y| water.hydrostatic(x, y),
        ..Section::dry(&GROUND, &soil)
    };
    section.slide(CIRCLE, 1000).expect("a slide")
}

/// Ordinary, Bishop and Spencer agree with what is published within shares of it, and so does the slope of Spencer's forces.
pub(super) fn agree(slide: &Slide, published: [f64; 3], slope: f64, within: [f64; 3]) {
    let [by_spencer, angle] = slide.spencer().expect("a factor");
    let found = [slide.ordinary().expect("a factor"), slide.bishop().expect("a factor"), by_spencer];
    println!("ordinary, Bishop, Spencer: {found:?}, slope of the forces {}", angle.tan());
    for ((found, published), within) in found.iter().zip(published).zip(within) {
        assert!((found / published - 1.0).abs() < within, "{found} and {published}");
    }
    assert!((angle.tan() - slope).abs() < 0.03, "{}", angle.tan());
}

#[test]
fn a_circle_of_fredlund_and_krahn() {
    // The paper's table: ordinary, Bishop, Spencer with the slope of his forces, dry and with the piezometric line.
    // Others who computed it again: ordinary 1.929 and 1.695, Bishop 2.078 and 1.831, Spencer 2.076 and 1.827.
    for (line, ordinary, bishop, spencer, slope) in
        [(&[][..], 1.928, 2.080, 2.073, 0.237), (&LINE[..], 1.693, 1.834, 1.830, 0.247)]
    {
        let slide = published(line, None);
        assert!((slide.entry[0] - 45.838).abs() < 1e-3 && (slide.exit[0] - 158.730).abs() < 1e-3);
        agree(&slide, [ordinary, bishop, spencer], slope, [4e-3, 3e-3, 3e-3]);
    }
}

#[test]
fn the_simple_slope_of_the_acads_study() {
    // Giam & Donald 1989, Monash University, Civil Engineering Research Report 8/1989: EX1(a), 10 m at 2:1, c = 3
    // kPa, phi = 19.6 degrees, 20 kN/m3, firm 5 m below the toe. The referees' factor is 1.00; 18 answers by Bishop's
    // method have a mean of 0.993, as vendors of such programs print it, and one of them finds 0.987 itself.
    let ground = [[0.0, 10.0], [20.0, 10.0], [40.0, 0.0], [60.0, 0.0]];
    let soil = Uniform::dry(Strength { cohesion: 3e3, friction: 19.6_f64.to_radians() }, 20e3);
    let section = Section::dry(&ground, &soil);
    let limits = Limits {
        least_depth: 0.5,
        least_area: 0.0,
        least_deep: 0.0,
        starts: [0.0, 40.0],
        ends: [20.0, 60.0],
        slices: 200,
        method: Method::Bishop,
    };
    let critical = section.critical(&limits).expect("a circle");
    let (circle, ordinary) = (critical.slide.circle, critical.slide.ordinary().expect("a factor"));
    println!("Bishop {}, ordinary {ordinary}, {circle:?}, depth {}", critical.factor, critical.slide.depth);
    assert!(critical.factor > 0.980 && critical.factor < 1.0, "{}", critical.factor);
    assert!((critical.slide.exit[0] - 40.0).abs() < 0.5, "through the toe: {:?}", critical.slide.exit);
    assert!(ordinary < critical.factor);
    // No circle of a fine net around it is worse.
    for shift in
        [[-0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, -0.2, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, -0.2], [0.0, 0.0, 0.2]]
    {
        let [x, y] = circle.centre;
        let moved = Circle { centre: [x + shift[0], y + shift[1]], radius: circle.radius + shift[2] };
        let factor = section.slide(moved, 200).expect("a slide").bishop().expect("a factor");
        assert!(factor > critical.factor - 1e-6, "{factor} {}", critical.factor);
    }
}
