//! Guards the symmetric and general solvers: solutions in every order, and singular systems that are refused.

use mpm_core::sparse::*;

/// A chain of springs, fixed at one end if asked.
fn chain(size: usize, held: bool) -> Sparse {
    let mut a = Sparse::symmetric(size, (1..size).map(|i| (i, i - 1)));
    for i in 1..size {
        a.add(i, i, 1.0);
        a.add(i - 1, i - 1, 1.0);
        a.add(i - 1, i, -1.0);
    }
    if held {
        a.add(0, 0, 1.0);
    }
    a
}

fn solved(a: &Sparse, signs: Signs, ordering: Ordering) -> Result<f64, Unsolved> {
    let b: Vec<f64> = (0..a.size()).map(|i| (i as f64 + 1.0).sin()).collect();
    let mut x = vec![0.0; a.size()];
    let mut factor = Factor::new(a, signs, ordering)?;
    factor.refresh(a)?;
    factor.solve(a, &b, &mut x)?;
    let mut back = vec![0.0; a.size()];
    a.multiply(&x, &mut back);
    Ok(back.iter().zip(&b).map(|(l, r)| (l - r).abs()).fold(0.0, f64::max))
}

#[test]
fn sound_systems_are_solved_in_either_order() {
    for ordering in [Ordering::AsNumbered, Ordering::MinimumDegree] {
        assert!(solved(&chain(50, true), Signs::Definite, ordering).expect("a solution") < 1e-10);
        // A saddle: springs beside a negative block, coupled crosswise.
        let mut saddle = Sparse::symmetric(40, (0..20).flat_map(|i| [(i, 20 + i), (i, (i + 1) % 20)]));
        for i in 0..20 {
            saddle.add(i, i, 3.0);
            saddle.add(i, (i + 1) % 20, -1.0);
            saddle.add(20 + i, 20 + i, -0.1);
            saddle.add(i, 20 + i, 2.0);
        }
        assert!(solved(&saddle, Signs::QuasiDefinite, ordering).expect("a solution") < 1e-12);
    }
}

#[test]
fn systems_that_are_not_symmetric_are_solved() {
    let mut a = Sparse::general(60, (0..60).flat_map(|i| [(i, (i + 1) % 60), (i, (7 * i) % 60)]));
    for i in 0..60 {
        a.add(i, (i + 1) % 60, 2.0);
        a.add(i, (7 * i) % 60, -0.5);
        a.add_both(i, (i + 1) % 60, 0.1);
    }
    assert!(solved(&a, Signs::Unknown, Ordering::MinimumDegree).expect("a solution") < 1e-11);
    let nothing = Sparse::general(4, [(0, 1), (1, 2)].into_iter());
    assert!(solved(&nothing, Signs::Unknown, Ordering::MinimumDegree).is_err());
}

#[test]
fn singular_systems_are_refused() {
    for signs in [Signs::Definite, Signs::QuasiDefinite] {
        for ordering in [Ordering::AsNumbered, Ordering::MinimumDegree] {
            let refused = solved(&chain(50, false), signs, ordering);
            assert!(refused.is_err(), "{refused:?}");
        }
    }
    // Also one that the run asks nothing of.
    let a = chain(50, false);
    let mut factor = Factor::new(&a, Signs::Definite, Ordering::AsNumbered).expect("a pattern");
    assert!(factor.refresh(&a).is_err());
}

#[test]
fn factors_of_another_matrix_are_noticed() {
    let (right, mut wrong) = (chain(20, true), chain(20, true));
    wrong.add(7, 7, 0.5);
    let mut factor = Factor::new(&right, Signs::Definite, Ordering::AsNumbered).expect("a pattern");
    factor.refresh(&wrong).expect("factors");
    let (b, mut x) = (vec![1.0; 20], vec![0.0; 20]);
    assert!(matches!(factor.solve(&right, &b, &mut x), Err(Unsolved::Residual { .. })));
}
