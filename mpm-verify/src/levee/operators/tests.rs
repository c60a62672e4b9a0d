//! Both operators on rectangles, where all is known.

use std::f64::consts::PI;

use super::*;
use crate::frames::made_up;

/// A block of full cells, `inside` of them unknown, in a mesh with room around it.
fn block(inside: [usize; 2]) -> Region {
    let cells = inside.map(|n| n + 4);
    let is = |k: usize, end: usize| (1..end - 1).contains(&k);
    let full = |cell: usize| is(cell % cells[0], cells[0]) && is(cell / cells[0], cells[1]);
    Region::new(cells, (0..cells[0] * cells[1]).map(full).collect(), false)
}

/// A mesh that is full all over, tight on all sides.
fn tight(cells: [usize; 2], slips: bool) -> Region {
    Region { slips, ..Region::new(cells, vec![true; cells[0] * cells[1]], false) }
}

fn values(region: &Region, of: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
    (0..region.full.len()).map(|cell| if region.full[cell] { of(region.middle(cell)) } else { 0.0 }).collect()
}

fn alternating(region: &Region) -> Vec<f64> {
    values(region, |x| if ((x[0] + x[1]) as usize).is_multiple_of(2) { -1.0 } else { 1.0 })
}

/// `H K H` of a head.
fn energy(region: &Region, operator: Operator, head: &[f64]) -> f64 {
    region.outflow(operator, head).iter().zip(&region.unknown).map(|(out, cell)| out * head[*cell]).sum()
}

/// `2 (1 - cos a cos b)` for the nodal operator, `4 - 2 cos a - 2 cos b` for the face operator, divided.
fn ratio([a, b]: [f64; 2]) -> f64 {
    (1.0 - a.cos() * b.cos()) / (2.0 - a.cos() - b.cos())
}

#[test]
fn a_linear_head_is_reproduced_by_both() {
    let region = block([9, 6]);
    let head = values(&region, |x| 3.0 + 0.7 * x[0] - 1.9 * x[1]);
    let along = |region: &Region, head: &[f64]| {
        for operator in BOTH {
            let found = region.solve(operator, head, None).expect("a head");
            let worst = found.iter().zip(head).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-12, "{operator:?}: {worst}");
            assert!(region.index(&found) < 1e-13);
        }
    };
    along(&region, &head);
    // And along a tight base, in a trapezium beside a fed side.
    let full = (0..14 * 7).map(|cell| cell % 14 + 2 * (cell / 14) < 11).collect();
    let region = Region::new([14, 7], full, true);
    assert!(region.known[0] && !region.known[1] && region.unknown() == 7 + 5 + 3 + 1);
    let head = values(&region, |x| 8.0 - 0.7 * x[0]);
    along(&region, &head);
}

#[test]
fn only_the_nodal_operator_leaves_a_checkerboard_alone() {
    // Of a mesh that is tight all around the even head is free under both; with its walls at rest the alternating one too, under
    // the nodal operator.
    let region = tight([8, 5], false);
    let (even, odd) = (values(&region, |_| 1.0), alternating(&region));
    let worst = |operator, head: &[f64]| region.outflow(operator, head).iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(worst(Operator::Face, &even) < 1e-14 && worst(Operator::Nodal, &even) < 1e-14);
    assert!(worst(Operator::Nodal, &odd) < 1e-14 && worst(Operator::Face, &odd) > 3.9);
    // Each colour by itself is free, so no two more than these: every cell is tied to its diagonal neighbours.
    let zeros = |operator| {
        let mut matrix = DMatrix::<f64>::zeros(40, 40);
        for (a, b, value) in region.entries(operator) {
            matrix[(a, b)] += value;
            matrix[(b, a)] += if a == b { 0.0 } else { value };
        }
        SymmetricEigen::new(matrix).eigenvalues.iter().filter(|v| v.abs() < 1e-12).count()
    };
    assert_eq!(BOTH.map(zeros), [1, 2]);
}

#[test]
fn walls_along_which_water_moves_tie_the_colours_as_theory_has_it() {
    // Four per face; two per node of a wall that is no corner.
    let region = tight([8, 5], true);
    let odd = alternating(&region);
    let faces = (7 * 5 + 8 * 4) as f64;
    let nodes = 2.0 * (7 + 4) as f64;
    assert!((energy(&region, Operator::Face, &odd) - 4.0 * faces).abs() < 1e-11);
    assert!((energy(&region, Operator::Nodal, &odd) - 2.0 * nodes).abs() < 1e-11);
}

#[test]
fn a_rim_with_given_heads_leaves_weak_modes_as_many_as_theory_has() {
    let inside = [11, 7];
    let found = block(inside).resistances().expect("few cells");
    let angle = |k: usize, n: usize| PI * k as f64 / (n as f64 + 1.0);
    let pairs = (1..=inside[0]).flat_map(|k| (1..=inside[1]).map(move |l| [k, l]));
    let mut theory: Vec<f64> = pairs.map(|[k, l]| ratio([angle(k, inside[0]), angle(l, inside[1])])).collect();
    theory.sort_by(f64::total_cmp);
    assert_eq!(found.len(), 77);
    assert!(found.iter().zip(&theory).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}, expected {theory:?}");
    // The weakest alternates from cell to cell under an arch; none is free, and none is stiffer than under the face operator.
    let arch = [angle(inside[0], inside[0]), angle(inside[1], inside[1])];
    assert!((found[0] - ratio(arch)).abs() < 1e-12 && found[0] > 0.0 && found[76] < 1.0 + 1e-12);
}

#[test]
fn a_point_source_stays_in_its_colour_under_the_nodal_operator() {
    let region = block([21, 21]);
    let source = region.innermost().expect("a cell");
    assert_eq!(region.middle(source), [12.5, 12.5]);
    let nothing = vec![0.0; region.full.len()];
    let [face, nodal] = BOTH.map(|o| region.solve(o, &nothing, Some((source, 1.0))).expect("a head"));
    let odd = |cell: usize| (cell % region.cells[0] + cell / region.cells[0]) % 2 == 1;
    assert!(region.all().filter(|cell| odd(*cell)).all(|cell| nodal[cell].abs() < 1e-14));
    // Half of the cells carry all of it: twice the head, so that the mean is the same a few cells away.
    let far = source + 6;
    assert!((nodal[far] / face[far] - 2.0).abs() < 0.03, "{} {}", nodal[far], face[far]);
    let [smooth, uneven] = [region.index(&face), region.index(&nodal)];
    assert!(smooth < 0.03 && (0.9..1.1).contains(&uneven), "{smooth} {uneven}");
}

#[test]
fn a_frame_has_its_rim_and_its_source_inside() {
    let shot = &made_up::shots(2, 0)[1];
    let compared = compare(shot, 9810.0).expect("cells inside");
    let (numbers, region) = (&compared.numbers, &compared.region);
    assert!(numbers.full_cells > numbers.unknown_cells && numbers.unknown_cells > 5, "{numbers:?}");
    assert!(region.all().all(|cell| !region.known[cell] || compared.response[0][cell] == 0.0));
    assert!((numbers.response_kpa[0] - 1.0).abs() < 1e-12 && numbers.response_kpa[1] > 1.0);
    assert!(numbers.index_of_response[1] > 3.0 * numbers.index_of_response[0], "{numbers:?}");
    // A frame without water has nothing to compare.
    let mut dry = shot.clone();
    dry.frame.cell.iter_mut().for_each(|c| c.saturation = 0.0);
    assert!(compare(&dry, 9810.0).is_none());
}
