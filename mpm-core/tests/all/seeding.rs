//! Guards: area and centre of clipped parts are those of the polygon on any mesh, and the tests of polygons.

use std::f64::consts::TAU;

use proptest::prelude::*;

use mpm_core::seeding::*;

/// Parts below this share of a square are merged into a neighbour.
const SLIVER: f64 = 0.1;

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

/// Beside a slope of 45 degrees two neighbours of a sliver are alike but for round-off.
#[test]
fn the_mirror_image_of_a_slope_has_the_parts_of_its_mirror_image() {
    let (spacing, cells) = (0.0675, 13.0);
    let slope = [[0.04968, 0.0], [0.741825, 0.0], [0.54216, 0.377055], [0.426735, 0.377055]];
    let mirrored = slope.map(|[x, y]| [cells * spacing - x, y]);
    let sorted = |mut parts: Vec<Part>| {
        parts.sort_by_key(|part| [1, 0].map(|d| (part.centroid[d] / spacing).floor() as usize));
        parts
    };
    let back = parts(&mirrored, spacing).into_iter().map(|part| {
        let [x, y] = part.centroid;
        Part { centroid: [cells * spacing - x, y], ..part }
    });
    let (one, other) = (sorted(parts(&slope, spacing)), sorted(back.collect()));
    assert_eq!(one.len(), other.len());
    for (a, b) in one.iter().zip(&other) {
        let off = (a.centroid[0] - b.centroid[0]).hypot(a.centroid[1] - b.centroid[1]);
        assert!(off < 1e-9 * spacing && (a.area - b.area).abs() < 1e-9 * spacing * spacing, "{a:?} {b:?}");
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
    assert_eq!(check(&LEVEE, 0.0), Ok(()));
    assert_eq!(check(&BRIDGE, 0.0), Ok(()));
    assert_eq!(check(&LEVEE[..2], 0.0), Err(Fault::TooFew(2)));
    assert_eq!(check(&[[0.0, 0.0], [1.0, 0.0], [1.0, -0.1]], 0.0), Err(Fault::Outside(2)));
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert_eq!(check(&bow, 0.0), Err(Fault::Crossing(0, 2)));
    assert_eq!(check(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]], 0.0), Err(Fault::Crossing(0, 1)));
    assert_eq!(check(&[[0.0, 0.0], [0.0, 0.0], [1.0, 1.0]], 0.0), Err(Fault::Crossing(0, 1)));
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
        prop_assert_eq!(check(&polygon, 0.0), Ok(()));
        let parts = parts(&polygon, spacing);
        let [area, centre] = errors(&polygon, &parts);
        prop_assert!(area < 1e-12 && centre < 1e-12, "area {area:.1e}, centre {centre:.1e}");
        prop_assert!(parts.iter().all(|p| p.area > 0.0));
    }
}

#[test]
fn the_crest_is_what_is_highest_and_level_or_else_the_peak() {
    let below = |polygon: &[[f64; 2]], spacing: f64| {
        let parts = parts(polygon, spacing);
        let crest = below_crest(polygon, &parts, spacing);
        let width: f64 = crest.iter().map(|(_, width)| width).sum();
        let places: Vec<[f64; 2]> = crest.iter().map(|(i, _)| parts[*i].centroid).collect();
        (width, places)
    };
    for spacing in [0.2, 0.07, 1.0 / 3.0] {
        let (width, places) = below(&LEVEE, spacing);
        // A sliver of the crest may be left out.
        assert!((width - 3.0).abs() <= SLIVER * spacing + 1e-12, "{spacing}: {width}");
        assert!(places.iter().all(|[x, y]| *x < 3.0 + spacing && *y > 3.0 - 1.5 * spacing), "{spacing}: {places:?}");
        let peak = [[0.0, 0.0], [4.0, 0.0], [1.3, 2.0]];
        let (_, places) = below(&peak, spacing);
        assert!(places.len() == 1 && (places[0][0] - 1.3).hypot(places[0][1] - 2.0) < 1.5 * spacing, "{places:?}");
    }
}

#[test]
fn a_tenth_of_a_square_of_the_crest_counts_in_the_mirror_as_it_does_here() {
    // The crest begins at 7.9 squares and ends at 10.94; in the mirror at 15.06 and 18.1.
    let (spacing, across) = (0.429, 26.0 * 0.429);
    let slope = [[0.547404, 0.0], [9.058764, 0.0], [4.69326, 4.85628], [3.3891, 4.85628]];
    let mirrored = slope.map(|[x, y]| [across - x, y]);
    let count = |slope: &[[f64; 2]]| below_crest(slope, &parts(slope, spacing), spacing).len();
    assert_eq!(count(&slope), count(&mirrored));
}

#[test]
fn lengths_along_sides_are_those_of_the_outline() {
    let all = [0.0, f64::INFINITY];
    for (polygon, sides) in [(&LEVEE[..], [3.0, 0.0, 9.0, 9.0]), (&BRIDGE[..], [3.0, 3.0, 2.0, 3.0])] {
        let width = polygon.iter().fold(0.0, |w: f64, x| w.max(x[0]));
        for (side, length) in sides.into_iter().enumerate() {
            let mirrored: Vec<[f64; 2]> = polygon.iter().map(|[x, y]| [width - x, *y]).collect();
            let other = [1, 0, 2, 3][side];
            let found = [length_along(polygon, side, all, width), length_along(&mirrored, other, all, width)];
            assert!(found.iter().all(|l| (l - length).abs() < 1e-12), "side {side}: {found:?}, expected {length}");
        }
    }
    assert!((length_along(&LEVEE, 3, [8.8, 9.2], 9.0) - 0.2).abs() < 1e-12);
    assert!((length_along(&BRIDGE, 2, [0.5, 2.5], 3.0) - 1.0).abs() < 1e-12);
}

/// Whether any two edges of a polygon meet: every pair is asked.
fn meets(points: &[[f64; 2]]) -> bool {
    let count = points.len();
    let edge = |i: usize| [points[i], points[(i + 1) % count]];
    (0..count).any(|i| {
        (i + 1..count).any(|j| {
            let next = j == i + 1 || (i == 0 && j == count - 1);
            if next { folds(&edge(i), &edge(j)) } else { touch(&edge(i), &edge(j)) }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn the_sweep_finds_what_all_pairs_find(
        // Few places: corners on edges, edges on edges and edges of no length abound.
        places in prop::collection::vec((0..5_u8, 0..5_u8), 3..9),
        anywhere in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64), 3..7),
        star in polygons(),
        at in any::<prop::sample::Index>(),
        put in (0.0..10.0_f64, 0.0..10.0_f64),
    ) {
        let places: Vec<[f64; 2]> = places.iter().map(|(x, y)| [f64::from(*x), f64::from(*y)]).collect();
        let anywhere: Vec<[f64; 2]> = anywhere.iter().map(|(x, y)| [*x, *y]).collect();
        let mut moved = star.clone();
        moved[at.index(star.len())] = [put.0, put.1];
        for points in [places, anywhere, star, moved] {
            prop_assert_eq!(check(&points, 0.0).is_err(), meets(&points), "{:?}", points);
        }
    }
}

#[test]
fn outlines_of_a_hundred_thousand_corners_are_checked_in_a_second() {
    const CORNERS: usize = 100_000;
    let star = |i: usize| {
        let (angle, radius) = (TAU * i as f64 / CORNERS as f64, if i.is_multiple_of(2) { 4.9 } else { 0.5 });
        [5.0 + radius * angle.cos(), 5.0 + radius * angle.sin()]
    };
    let comb = |i: usize| [2.0 * (i as f64 / 4.0).floor() + [0.0, 0.0, 1.0, 1.0][i % 4], [1.0, 9.0, 9.0, 1.0][i % 4]];
    let shapes: [Vec<[f64; 2]>; 2] = [
        (0..CORNERS).map(star).collect(),
        [[1e6, 0.0], [0.0, 0.0]].into_iter().chain((0..CORNERS).map(comb)).collect(),
    ];
    for mut points in shapes {
        let clock = std::time::Instant::now();
        assert_eq!(check(&points, 0.0), Ok(()));
        // The last corner lies beyond thousands of the others.
        points[CORNERS - 1] = [5.0, 9.95];
        assert!(check(&points, 0.0).is_err());
        let took = clock.elapsed().as_secs_f64();
        println!("{} corners twice: {took:.2} s", points.len());
        // Ten times what it takes; all pairs take minutes.
        assert!(took < 5.0, "{took:.1} s");
    }
}
