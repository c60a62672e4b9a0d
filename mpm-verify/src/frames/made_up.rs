//! A made-up levee that slides: not mechanics, but of the right shape and size for tests of what shows it.

use mpm_core::observe::{CellState, Frame, SolidState, WaterParticle};

use super::Shot;

/// Outline of the levee at the start, m.
pub const OUTLINE: [[f64; 2]; 4] = [[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
/// When it fails, s on the reader's clock.
pub const FAILURE_S: f64 = 8.66 * 3600.0;
const START_S: f64 = 6.0 * 3600.0;
/// Distance of particles, m: nine in a cell.
const SPACING: f64 = 0.4 / 3.0;
const CELLS: [usize; 2] = [36, 9];
const SIZE: f64 = 0.4;
/// Weight of water, N/m3.
const WATER: f64 = 9810.0;

/// Frames while water seeps, evenly over 2.66 h, then frames while it slides, evenly over 40 s.
pub fn shots(seeping: usize, sliding: usize) -> Vec<Shot> {
    let seepage = (0..seeping).map(|k| shot("seepage", START_S + share(k, seeping) * (FAILURE_S - START_S)));
    let slide = (0..sliding).map(|k| shot("failing", FAILURE_S + share(k + 1, sliding + 1) * 40.0));
    seepage.chain(slide).collect()
}

fn share(k: usize, of: usize) -> f64 {
    k as f64 / (of - 1).max(1) as f64
}

fn shot(phase: &str, time_s: f64) -> Shot {
    let run_s = time_s - START_S;
    let frame = Frame {
        time_s: run_s,
        step: (run_s * 1e4) as u64,
        cells: CELLS,
        size: SIZE,
        solid: seeds().enumerate().map(|(id, x)| soil(id as u32, x, time_s)).collect(),
        water: seeds().filter(|x| x[1] < level(x[0], time_s)).map(|x| water(x, time_s)).collect(),
        cell: (0..CELLS[0] * CELLS[1]).map(|k| cell(k, time_s)).collect(),
    };
    Shot { phase: phase.to_owned(), time_s, frame }
}

/// Height of the slope or the crest, m.
fn surface(x: f64) -> f64 {
    (4.5 - 0.5 * x).clamp(0.0, 3.0)
}

/// Height of the water at the start of sliding, m: a line from the tank to a front that moves to the toe.
fn level(x: f64, time_s: f64) -> f64 {
    let front = 6.3 + 2.7 * ((time_s - START_S) / (FAILURE_S - START_S)).min(1.0);
    (2.3 * (1.0 - x / front)).min(surface(x))
}

fn seeds() -> impl Iterator<Item = [f64; 2]> {
    let at = |k: usize| (k as f64 + 0.5) * SPACING;
    (0..23).flat_map(move |j| (0..68).map(move |i| [at(i), at(j)])).filter(|x| x[1] < surface(x[0]))
}

/// How far soil has slid that was at a place, m: most at the surface of the slope, nothing 1.5 m below it.
fn slid(x: [f64; 2], time_s: f64) -> [f64; 2] {
    let far = 2.0 * (1.0 - (-(time_s - FAILURE_S).max(0.0) / 10.0).exp());
    let depth = (surface(x[0]) - x[1]) / 1.5;
    let part = (1.0 - depth).clamp(0.0, 1.0) * ((x[0] - 1.8) / 2.0).clamp(0.0, 1.0);
    [far * part, (-0.5 * far * part).max(-0.85 * x[1])]
}

fn soil(id: u32, x: [f64; 2], time_s: f64) -> SolidState {
    let u = slid(x, time_s);
    let pore_pressure = (WATER * (level(x[0], time_s) - x[1])).max(0.0);
    let upright = 18.5e3 * (surface(x[0]) - x[1]).max(0.05) - pore_pressure.min(12e3 * (surface(x[0]) - x[1]));
    let moved = u[0].hypot(u[1]);
    SolidState {
        id,
        x: [x[0] + u[0], x[1] + u[1]],
        displacement: u,
        velocity: if moved > 0.0 { [0.05 * u[0], 0.05 * u[1]] } else { [0.0; 2] },
        stress: [-0.45 * upright, -upright, -0.4 * upright, 0.12 * upright * x[0] / 9.0],
        pore_pressure,
        deviator_strain: 0.02 * x[1] / 3.0 * 0.1 + 0.5 * moved,
        volume: SPACING * SPACING,
        mass: 2700.0 * 0.7 * SPACING * SPACING,
    }
}

fn water(x: [f64; 2], time_s: f64) -> WaterParticle {
    let u = slid(x, time_s);
    let pressure = WATER * (level(x[0], time_s) - x[1]);
    WaterParticle { x: [x[0] + u[0], x[1] + u[1]], velocity: [2e-5, -1e-6], pressure, volume: SPACING * SPACING }
}

fn cell(number: usize, time_s: f64) -> CellState {
    let (x, low) = ((number % CELLS[0]) as f64 * SIZE + 0.5 * SIZE, (number / CELLS[0]) as f64 * SIZE);
    let full = |top: f64| ((top - low) / SIZE).clamp(0.0, 1.0);
    let (soil, wet) = (full(surface(x)), full(level(x, time_s)));
    let pressure = WATER * 0.5 * (level(x, time_s) - low).max(0.0);
    CellState { soil, saturation: if soil > 0.0 { wet / soil } else { 0.0 }, pressure }
}
