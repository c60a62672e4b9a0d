//! Guards: area and centre of clipped parts are those of the polygon on any mesh, and the tests of polygons.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::*;

/// The half levee of the paper: crest 3 m wide at 3 m, slope 1:2.
const LEVEE: [[f64; 2]; 4] = [[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
/// Not convex: two legs under a bridge.
const BRIDGE: [[f64; 2]; 8] =
    [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [2.0, 2.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];

/// Errors of area and centre of parts, as shares of the area and of the size.
fn errors(polygon: &[[f64; 2]], parts: &[Part]) -> [f64; 2] {
    let (sum, centre) = total(parts);
    let whole = area(polygon).abs();
    let exact = centroid(polygon);
    let off = (0..2).map(|d| (centre[d] - exact[d]).abs()).fold(0.0, f64::max);
    [(sum / whole - 1.0).abs(), off / whole.sqrt()]
}

#[test]
fn the_levee_is_kept_on_every_mesh() {
    for spacing in [0.2, 0.1, 0.05, 0.15, 1.0 / 3.0, 0.07, 0.4] {
        for polygon in [&LEVEE[..], &BRIDGE[..]] {
            let parts = parts(polygon, spacing);
            assert!(errors(polygon, &parts).into_iter().all(|e| e < 1e-12), "{spacing} {:?}", errors(polygon, &parts));
            assert!(parts.iter().all(|p| p.area >= SLIVER * spacing * spacing), "a sliver at {spacing}");
        }
    }
}

#[test]
fn an_edge_on_the_crest_loses_no_row() {
    // 3.0/0.1 is 30.000000000000004 in binary numbers, 0.3/0.1 is 2.9999999999999996.
    for (height, spacing, rows) in [(3.0, 0.1, 30), (0.3, 0.1, 3), (0.7, 0.1, 7)] {
        let block = [[0.0, 0.0], [spacing, 0.0], [spacing, height], [0.0, height]];
        assert_eq!(parts(&block, spacing).len(), rows);
        assert_eq!(whole(&block, spacing).len(), rows);
    }
}

#[test]
fn whole_squares_are_of_first_order() {
    let error = |spacing| errors(&LEVEE, &whole(&LEVEE, spacing))[0];
    // A spacing that divides neither crest nor slope.
    let [coarse, fine] = [0.17, 0.017].map(error);
    assert!(coarse > 1e-4 && coarse < 0.05 && fine > 1e-6 && fine < 0.01, "{coarse:.1e} {fine:.1e}");
}

#[test]
fn points_that_are_no_outline_are_found() {
    assert_eq!(check(&LEVEE), Ok(()));
    assert_eq!(check(&BRIDGE), Ok(()));
    assert_eq!(check(&LEVEE[..2]), Err(Fault::TooFew(2)));
    assert_eq!(check(&[[0.0, 0.0], [1.0, 0.0], [1.0, -0.1]]), Err(Fault::Outside(2)));
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert_eq!(check(&bow), Err(Fault::Crossing(0, 2)));
    assert_eq!(check(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]]), Err(Fault::Crossing(0, 1)));
    assert_eq!(check(&[[0.0, 0.0], [0.0, 0.0], [1.0, 1.0]]), Err(Fault::Crossing(0, 1)));
}

#[test]
fn depth_is_that_below_the_outline() {
    assert!((depth(&LEVEE, &[1.0, 1.0]) - 2.0).abs() < 1e-15);
    assert!((depth(&LEVEE, &[5.0, 1.0]) - 1.0).abs() < 1e-15);
    assert_eq!(depth(&LEVEE, &[9.5, 1.0]), 0.0);
    assert!(inside(&BRIDGE, &[0.5, 1.0]) && !inside(&BRIDGE, &[1.5, 1.0]) && inside(&BRIDGE, &[1.5, 2.5]));
}

/// Star-shaped polygons about (5, 5), which need not be convex, either way round.
fn polygons() -> impl Strategy<Value = Vec<[f64; 2]>> {
    (prop::collection::vec(0.5..4.9_f64, 3..12), 0.0..TAU, any::<bool>()).prop_map(|(radii, turned, back)| {
        let count = radii.len() as f64;
        let at = |(i, r): (usize, &f64)| {
            let angle = turned + TAU * i as f64 / count;
            [5.0 + r * angle.cos(), 5.0 + r * angle.sin()]
        };
        let mut points: Vec<[f64; 2]> = radii.iter().enumerate().map(at).collect();
        if back {
            points.reverse();
        }
        points
    })
}

proptest! {
    #[test]
    fn area_and_centre_are_kept(polygon in polygons(), spacing in 0.05..3.0_f64) {
        prop_assert_eq!(check(&polygon), Ok(()));
        let parts = parts(&polygon, spacing);
        let [area, centre] = errors(&polygon, &parts);
        prop_assert!(area < 1e-12 && centre < 1e-12, "area {area:.1e}, centre {centre:.1e}");
        prop_assert!(parts.iter().all(|p| p.area > 0.0));
    }
}
