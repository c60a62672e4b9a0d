//! A failure made small: what can be left out, halved or rounded while the same relation still fails.

use super::scenes::digits;
use super::written::Written;

/// Changes tried at most.
const TRIES: usize = 150;
/// Share of the time of a run that is left at least.
const SHORTEST: f64 = 0.02;

/// A way to make a scene smaller, or more usual.
type Smaller = fn(&mut Written);

/// In the order in which they are tried: first what leaves most out.
const WAYS: [Smaller; 38] = [
    |w| w.layers.clear(),
    |w| w.water = None,
    |w| w.gravity = None,
    |w| w.load = None,
    |w| w.soil.strength = None,
    |w| w.start = "unloaded",
    |w| w.shape = None,
    |w| w.shape = Some("centre"),
    |w| w.darcy = None,
    |w| w.darcy_inertia = None,
    |w| w.flip = None,
    |w| w.transfer = None,
    |w| w.update = None,
    |w| w.quadrature = None,
    |w| w.tolerance = None,
    |w| w.waves = None,
    |w| w.sides[0] = "roller",
    |w| w.sides[1] = "roller",
    |w| w.sides[2] = "fixed",
    |w| w.empty_above = 0,
    |w| w.empty_above = w.empty_above.min(1),
    |w| w.per_direction = 1,
    |w| w.per_direction = w.per_direction.min(2),
    |w| w.stages.truncate(1),
    |w| w.stages.iter_mut().for_each(|stage| stage.damping = 0.0),
    |w| w.load.iter_mut().for_each(|load| load.ramp = 0.0),
    |w| w.load.iter_mut().for_each(|load| load.strip = None),
    |w| w.load.iter_mut().for_each(|load| load.on = "surface"),
    |w| w.load.iter_mut().for_each(|load| load.pressure = load.pressure.abs()),
    |w| w.plane = false,
    halve_rows,
    |w| w.cells[0] = (w.cells[0] / 2).max(2),
    |w| w.shorten(0.5),
    |w| w.soil.poisson_ratio = 0.0,
    |w| w.soil.porosity = 0.5,
    |w| w.cell = one_digit(w.cell),
    |w| w.soil.youngs_modulus = one_digit(w.soil.youngs_modulus),
    |w| w.water.iter_mut().for_each(|water| water.conductivity = one_digit(water.conductivity)),
];

fn halve_rows(w: &mut Written) {
    if w.layers.is_empty() {
        w.cells[1] = (w.cells[1] / 2).max(2);
    } else {
        w.layers.iter_mut().for_each(|layer| layer.rows = (layer.rows / 2).max(1));
        w.cells[1] = w.layers.iter().map(|layer| layer.rows).sum();
    }
}

fn one_digit(x: f64) -> f64 {
    format!("{:.0e}", digits(x)).parse().unwrap_or(x)
}

/// The smallest scene found that still fails.
pub fn shrunk(written: &Written, fails: impl Fn(&Written) -> bool) -> Written {
    let (mut small, mut tries) = (written.clone(), 0);
    loop {
        let before = small.clone();
        for smaller in WAYS {
            let mut candidate = small.clone();
            smaller(&mut candidate);
            let length = |w: &Written| w.stages.iter().map(|stage| stage.time).sum::<f64>();
            let shorter = length(&candidate) < SHORTEST * length(written);
            // The cells of an outline cover it, and with others it would not lie in them.
            let other_mesh = |w: &Written| w.outline.is_some() && (w.cell != small.cell || w.cells != small.cells);
            if candidate != small && !shorter && !other_mesh(&candidate) && tries < TRIES {
                tries += 1;
                if fails(&candidate) {
                    small = candidate;
                }
            }
        }
        if small == before || tries >= TRIES {
            return small;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::scene;
    use super::*;

    #[test]
    fn what_a_failure_does_not_need_is_left_out() {
        let large = (0..).map(|i| scene(1, i)).find(|w| w.gravity.is_some() && w.cells[1] > 8).expect("a scene");
        let small = shrunk(&large, |w| w.gravity.is_some());
        assert!(small.gravity.is_some() && small.cells[1] == 2 && small.load.is_none() && small.water.is_none());
    }
}
