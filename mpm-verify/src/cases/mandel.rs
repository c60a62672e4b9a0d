//! Mandel's problem: pore pressure over the half width at T = 0.1, where it first rises above its undrained value.

use mpm_core::drive::Sample;
use mpm_core::scene::{Scene, ShapeChoice};

use super::{FASTER, Mutant, Outcome, Rung, faster, finished, integrator, scheme, sound};
use crate::exact::mandel::Mandel;
use crate::norms::largest;

/// Quadratic B-splines, eight cells per side on the finest mesh.
pub const SPLINES: Rung = Rung {
    name: "mandel",
    about: "Mandel's problem, B-splines: p at T = 0.1 with 8 cells per side",
    climb: || splines(sound),
    mutant: Some(Mutant { what: FASTER, climb: || splines(faster) }),
};

/// The paper's scheme.
pub const CENTRE: Rung = Rung {
    name: "mandel-centre",
    about: "the same with centre values and pressures constant in a cell",
    climb: || centre(sound),
    mutant: Some(Mutant { what: FASTER, climb: || centre(faster) }),
};

/// The times T = c t/a^2 looked at.
const TIME_FACTOR: f64 = 0.1;

fn splines(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Bspline2, &[2, 4, 8], 1e-4, [3.0, 6.0], fault)
}

fn centre(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    climb(ShapeChoice::Centre, &[8, 16, 32], 1e-3, [1.7, 2.3], fault)
}

fn climb(
    shape: ShapeChoice,
    sides: &[usize],
    required_error: f64,
    order: [f64; 2],
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base = crate::scenes::built_in("mandel").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    (base.shape, base.history, base.tolerance) = (shape, 0, 1e-7);
    let exact = Mandel::new(&base).ok_or("not Mandel's problem")?;
    let error = |s: &Sample| {
        if (exact.time_factor(s.stage_time) / TIME_FACTOR - 1.0).abs() > 1e-6 {
            return 0.0;
        }
        largest(s.state.field.iter().map(|f| (f.pressure_pa - exact.pressure(f.x_m, s.stage_time)) / exact.undrained))
    };
    fault(&mut base);
    let on = |side: &usize| {
        let cell = base.width / *side as f64;
        let scene = Scene { cell, cells: [*side; 2], ..base.clone() };
        Ok((cell, largest(finished(&scene)?.observed().map(error))))
    };
    let errors = sides.iter().map(on).collect::<Result<_, String>>()?;
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    Ok(Outcome { integrator, scheme, errors, required_error, required_order: Some(order), ..Outcome::default() })
}
