//! A sudden load on soil that cannot drain, in plane strain: where pressures swing from cell to cell, and where equal order
//! and reduced integration leave patterns free.
//!
//! The load is `q (1 + cos(pi x/W))/2` on a square between smooth walls on a smooth base. Undrained soil is elastic with
//! nu_u; with Airy's function `cos(k x) (A cosh k y + B k y sinh k y)`, k = pi/W, free of shear at base and top, the pressure is
//! `p = q/2 Q/(M + Q) + q B_s (1 + nu_u)/3 cosh(k y)/(cosh k H + k H/sinh k H) cos(k x)` (Timoshenko & Goodier 1970, section
//! 24; Skempton's B_s and nu_u as in Mandel's problem).

use std::f64::consts::PI;

use mpm_core::observe::FieldPoint;
use mpm_core::run::run;
use mpm_core::scene::{
    DarcyChoice, Dimension, Integrator, LoadedStrip, Scene, ShapeChoice, SolidSide, Start, Surcharge, Until,
    WaterProperties,
};

use super::case::{Case, Point};
use super::scheme::{STANDING, Scheme};
use crate::error::Error::{self, Lacks};

/// The case.
pub const CASE: Case = Case {
    name: "sudden-load",
    about: "a load that varies along an undrained square, K_w from 2e7 to 2e11 Pa, 16 cells along a side: pressure beside the \
            exact elastic solution, and the share of the difference that alternates from cell to cell",
    why: "A pressure at every particle (explicit, linear) is one constraint too many per cell: the soil locks as the \
          water stiffens. One pressure per cell does not, whatever carries the displacement.",
    parameter: "K_w (Pa)",
    column: "k_w_pa",
    dimension: Dimension::PlaneStrain,
    measures: "RMS or checkerboard of p - p_exact, share of the mean pressure",
    holds: 0.01,
    breaks: 0.2,
    schemes: &STANDING,
    run: |scheme| {
        BULK_MODULI
            .iter()
            .map(|k| Point { at: *k, found: square(scheme, *k).and_then(|scene| error(&scene)) })
            .collect()
    },
};

const BULK_MODULI: [f64; 5] = [2e7, 2e8, 2e9, 2e10, 2e11];
/// Cells along a side.
const SIDE: usize = 16;
/// Periods of the slowest shear wave until a critically damped square is at rest: what is left is e^-25.
const PERIODS: f64 = 4.0;

/// Undrained soil under the load, until it rests.
fn square(scheme: &Scheme, bulk_modulus: f64) -> Result<Scene, Error> {
    let mut scene = crate::scenes::terzaghi().edited(|scene| {
        scene.dimension = Dimension::PlaneStrain;
        scene.water = scene.water.map(|w| WaterProperties { bulk_modulus, hydraulic_conductivity: 1e-12, ..w });
        scene.solid_sides = [SolidSide::Roller, SolidSide::Roller, SolidSide::Roller, SolidSide::Free];
        (scene.width, scene.height, scene.start) = (1.0, 1.0, Start::Unloaded);
        (scene.cell, scene.cells, scene.history) = (1.0 / SIDE as f64, [SIDE; 2], 0);
    })?;
    // A hundredth of the usual load: the exact solution has small strains. It falls from the corner on, a strip of no width,
    // which no file has.
    let strip = Some(LoadedStrip { from: 0.0, to: f64::MIN_POSITIVE, taper: 1.0 });
    let speed = (scene.elastic.shear_modulus() / scene.mixture_density()).sqrt();
    let end = PERIODS * 4.0 * scene.height / speed;
    scene = scene.edited(|scene| {
        scene.surcharge = scene.surcharge.map(|s| Surcharge { pressure: 0.01 * s.pressure, strip, ..s });
        scene.stages[0].drained = [false; 4];
        scene.stages[0].until = Until::Time(end);
        scene.observe_times = vec![end];
    })?;
    Ok(scene.edited(|scene| {
        scheme.put_on(scene);
        match scene.integrator {
            Integrator::QuasiStatic => scene.tolerance = 1e-6,
            _ => scene.stages[0].damping = PI * speed / scene.height,
        }
        if scene.darcy == DarcyChoice::Nodal && scene.shape == ShapeChoice::Linear {
            scene.darcy_inertia = false;
        }
    })?)
}

/// The exact pressure at a place (m), Pa.
fn pressure(scene: &Scene, x: f64, y: f64) -> f64 {
    let load = scene.surcharge.map_or(0.0, |s| s.pressure);
    let (nu, k) = (scene.elastic.poisson_ratio, PI / scene.width);
    let bulk = scene.oedometer_modulus() - 4.0 / 3.0 * scene.elastic.shear_modulus();
    let skempton = 1.0 / (1.0 + bulk / scene.pore_stiffness());
    let undrained = (3.0 * nu + skempton * (1.0 - 2.0 * nu)) / (3.0 - skempton * (1.0 - 2.0 * nu));
    let height = k * scene.height;
    let along = (k * y).cosh() / (height.cosh() + height / height.sinh()) * (k * x).cos();
    0.5 * load * scene.undrained_share() + load * skempton * (1.0 + undrained) / 3.0 * along
}

/// The larger of the RMS of `p - p_exact` and its alternating share, of the mean pressure.
///
/// # Errors
/// A run that could not be finished.
fn error(scene: &Scene) -> Result<f64, Error> {
    let run = run(scene, &mut |_| {})?.whole()?;
    let field = &run.samples.last().ok_or(Lacks("sample"))?.state.field;
    let off = |f: &FieldPoint| f.pressure_pa - pressure(scene, f.x_m, f.y_m);
    let count = field.len() as f64;
    let mean = field.iter().map(|f| pressure(scene, f.x_m, f.y_m)).sum::<f64>() / count;
    let rms = (field.iter().map(|f| off(f).powi(2)).sum::<f64>() / count).sqrt();
    let sign = |f: &FieldPoint| {
        let place = |x: f64| (x / scene.cell) as i64;
        if (place(f.x_m) + place(f.y_m)) % 2 == 0 { 1.0 } else { -1.0 }
    };
    let board = field.iter().map(|f| sign(f) * off(f)).sum::<f64>().abs() / count;
    Ok(rms.max(board) / mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_pressure_is_that_of_an_elastic_square() {
        // Harmonic, free of flow through walls and base, and of the mean that the load makes without strain sideways.
        let scene = square(&Scheme::new(Integrator::QuasiStatic, ShapeChoice::Linear), 2e9).expect("a sound scene");
        let (h, at) = (1e-3, |x: f64, y: f64| pressure(&scene, x, y));
        let laplacian = |x: f64, y: f64| at(x + h, y) + at(x - h, y) + at(x, y + h) + at(x, y - h) - 4.0 * at(x, y);
        assert!(laplacian(0.3, 0.4).abs() / h / h < 1e-3 * at(0.3, 0.4).abs());
        assert!((at(h, 0.4) - at(-h, 0.4)).abs() < 1e-9 && (at(0.3, h) - at(0.3, -h)).abs() < 1e-9);
        let load = scene.surcharge.expect("a load").pressure;
        let mean: f64 = (0..100).map(|i| at((f64::from(i) + 0.5) / 100.0, 0.7)).sum::<f64>() / 100.0;
        assert!((mean - 0.5 * load * scene.undrained_share()).abs() < 1e-9 * load);
    }

    #[test]
    fn drained_soil_is_seen() {
        let scheme = Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre);
        let mut scene = square(&scheme, 2e9)
            .expect("a sound scene")
            .edited(|scene| {
                (scene.cell, scene.cells) = (0.125, [8; 2]);
            })
            .expect("a sound scene");
        assert!(error(&scene).expect("a run") < CASE.holds);
        scene = scene.edited(|scene| scene.stages[0].drained[3] = true).expect("a sound scene");
        let leaks = |w: WaterProperties| WaterProperties { hydraulic_conductivity: 1e-6, ..w };
        scene = scene.edited(|scene| scene.water = scene.water.map(leaks)).expect("a sound scene");
        assert!(error(&scene).expect("a run") > CASE.holds);
    }
}
