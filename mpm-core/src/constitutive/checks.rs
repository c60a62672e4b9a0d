//! Checks that every law has to pass.

/// Checks the tangent of a law at the end of a strain increment from a stress against central differences of its stress,
/// along the strains that are not zero; differences in parts of the modulus `$scale` (Pa).
macro_rules! check_tangent {
    ($law:expr, $stress:expr, $strain:expr, $scale:expr) => {
        let (law, stress, strain): (_, [f64; 4], [f64; 4]) = ($law, $stress, $strain);
        let state = law.first_state(&stress);
        let tangent = law.tangent(&stress, &strain, &state);
        for j in (0..4).filter(|j| strain[*j] != 0.0) {
            let h = 1e-6 * strain.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
            let [above, below] = [h, -h].map(|h| {
                let (mut moved, mut to) = (stress, strain);
                to[j] += h;
                law.update(&mut moved, &to, &mut state.clone());
                moved
            });
            for i in 0..4 {
                let difference = (above[i] - below[i]) / (2.0 * h);
                let off = (difference - tangent[(i, j)]).abs();
                assert!(off < 1e-6 * $scale, "{i}{j}: {difference:e} by differences, {:e}", tangent[(i, j)]);
            }
        }
    };
}

/// Checks the tangent of a law from a state of rest, and the energy against the work done along a straight strain path.
macro_rules! check_law {
    ($law:expr, $strain:expr) => {
        let law = $law;
        let strain: [f64; 4] = $strain;
        let mut at = [0.0; 4];
        let mut state = law.first_state(&at);
        law.update(&mut at, &strain, &mut state);
        check_tangent!(law, [0.0; 4], strain, law.tangent(&at, &strain, &law.first_state(&at))[(0, 0)]);
        let work: f64 = (0..4).map(|i| 0.5 * at[i] * strain[i]).sum();
        assert!((law.energy(&at) - work).abs() < 1e-12 * work, "{} {work}", law.energy(&at));
    };
}
