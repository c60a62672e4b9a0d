//! What particles off their even places and a mesh that starts elsewhere do to the error.

use mpm_core::scene::{Displaced, Integrator, Quadrature, Scene, ShapeChoice};
use serde::{Deserialize, Serialize};

use super::{MESHES, PARTICLES, REQUIRED, column, errors, run_all};
use crate::error::Error;
use crate::study::{Runner, or_nan, word};

/// Amplitudes of smooth displacements, in particle spacings.
pub const SMOOTH: [f64; 5] = [0.0, 0.125, 0.25, 0.375, 0.5];
/// Half widths of random displacements, in particle spacings.
pub const JITTER: [f64; 5] = [0.05, 0.10, 0.15, 0.20, 0.25];
/// Random displacements of one width.
pub const SEEDS: u64 = 5;
/// Starts of the mesh below the soil, in cells; the odd ones leave slivers of cells.
pub const SHIFTS: [f64; 14] = [0.0, 0.01, 0.1, 0.2, 0.3, 0.4, 0.49, 0.5, 0.51, 0.6, 0.7, 0.8, 0.9, 0.99];

/// Shape functions with the volumes that particles stand for.
const SCHEMES: [(ShapeChoice, Quadrature); 4] = [
    (ShapeChoice::Bspline2, Quadrature::Fitted),
    (ShapeChoice::Bspline2, Quadrature::Volumes),
    (ShapeChoice::Linear, Quadrature::Volumes),
    (ShapeChoice::Gimp, Quadrature::Volumes),
];

/// A row of `displaced.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Displacement {
    /// `smooth`, `jitter` or `both`.
    pub kind: String,
    /// Amplitude of the smooth wave, spacings.
    pub smooth: f64,
    /// Half width of the random part, spacings.
    pub jitter: f64,
    /// Seed of the random part.
    pub seed: u64,
    /// Shape functions.
    pub scheme: String,
    /// `fitted` weights or the particles' `volumes`.
    pub quadrature: String,
    /// Cell edge, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Largest error against compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_compressible: f64,
    /// RMS error of the pore pressure at Tv = 0.1, over p_0.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_compressible: f64,
    /// Largest error allowed, where one is.
    pub required: Option<f64>,
    /// Whether it holds, where one is; not if the run failed.
    pub held: Option<bool>,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
}

/// A row of `grid_shift.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// The mesh starts this share of a cell below the soil.
    pub shift: f64,
    /// Shape functions.
    pub scheme: String,
    /// `fitted` weights or the particles' `volumes`.
    pub quadrature: String,
    /// Cell edge, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Largest error against compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_compressible: f64,
    /// RMS error of the pore pressure at Tv = 0.1, over p_0.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_compressible: f64,
    /// Largest error allowed, where one is.
    pub required: Option<f64>,
    /// Whether it holds, where one is; not if the run failed.
    pub held: Option<bool>,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
}

/// All displacements: smooth ones, random ones with several seeds, and both at their largest.
fn displacements() -> Vec<(&'static str, Displaced)> {
    let smooth = SMOOTH.map(|smooth| ("smooth", Displaced { smooth, jitter: 0.0, seed: 1 }));
    let random = |kind: &'static str, smooth: f64, jitter: f64| {
        (1..=SEEDS).map(move |seed| (kind, Displaced { smooth, jitter, seed }))
    };
    let jitter = JITTER.into_iter().flat_map(|jitter| random("jitter", 0.0, jitter));
    smooth.into_iter().chain(jitter).chain(random("both", 0.5, 0.25)).collect()
}

/// The error that a row must not exceed.
fn required(shape: ShapeChoice, quadrature: Quadrature, mesh: f64) -> Option<f64> {
    ((shape, quadrature, mesh) == (ShapeChoice::Bspline2, Quadrature::Fitted, MESHES[0])).then_some(REQUIRED)
}

/// Whether a row holds: one that could not be run fails whatever is required of it.
fn passed(required: Option<f64>, error: f64, failed: bool) -> Option<bool> {
    if failed { Some(false) } else { required.map(|limit| error <= limit) }
}

/// Runs every displacement with every scheme on both meshes.
///
/// # Errors
/// No threads.
pub fn displaced(base: &Scene, runner: &mut Runner, cpu_s: &mut f64) -> Result<Vec<Displacement>, Error> {
    let mut cases = Vec::new();
    for mesh in MESHES {
        for (shape, quadrature) in SCHEMES {
            cases.extend(displacements().into_iter().map(|(kind, d)| (mesh, shape, quadrature, kind, d)));
        }
    }
    let scene = |case: &(f64, ShapeChoice, Quadrature, &str, Displaced)| {
        let &(mesh, shape, quadrature, _, displaced) = case;
        let scene = column(base, Integrator::QuasiStatic, shape, mesh)?;
        let even = displaced.smooth == 0.0 && displaced.jitter == 0.0;
        // Other functions than B-splines have no weights but the volumes.
        let splines = shape == ShapeChoice::Bspline2;
        Ok(scene.edited(|scene| {
            scene.quadrature = if splines { quadrature } else { scene.quadrature };
            scene.displaced = (!even).then_some(displaced);
        })?)
    };
    let scenes: Vec<Result<Scene, Error>> = cases.iter().map(scene).collect();
    let results = run_all(&scenes, ("displaced", false), runner)?;
    *cpu_s += results.iter().flatten().map(|r| r.cpu_s).sum::<f64>();
    let row = |((case, scene), result): ((&(f64, _, _, &str, Displaced), _), &Option<_>)| {
        let (mesh, shape, quadrature, kind, d) = case;
        let (max, late, profile, failure) = errors(scene, result.as_ref());
        let required = required(*shape, *quadrature, *mesh);
        Displacement {
            kind: (*kind).to_owned(),
            smooth: d.smooth,
            jitter: d.jitter,
            seed: d.seed,
            scheme: word(shape),
            quadrature: word(quadrature),
            mesh_m: *mesh,
            ppc: PARTICLES,
            max_error_compressible: max,
            late_error_compressible: late,
            profile_error_compressible: profile,
            held: passed(required, max, failure.is_some()),
            required,
            failure,
        }
    };
    Ok(cases.iter().zip(&scenes).zip(&results).map(row).collect())
}

/// Runs every offset of the mesh with `bspline2`, fitted weights, on both meshes.
///
/// # Errors
/// No threads.
pub fn shifted(base: &Scene, runner: &mut Runner, cpu_s: &mut f64) -> Result<Vec<Shift>, Error> {
    let (shape, quadrature) = SCHEMES[0];
    let cases: Vec<(f64, f64)> = MESHES.iter().flat_map(|mesh| SHIFTS.map(|shift| (*mesh, shift))).collect();
    let scene = |(mesh, shift): &(f64, f64)| {
        Ok(column(base, Integrator::QuasiStatic, shape, *mesh)?
            .edited(|scene| (scene.quadrature, scene.shift) = (quadrature, *shift))?)
    };
    let scenes: Vec<Result<Scene, Error>> = cases.iter().map(scene).collect();
    let results = run_all(&scenes, ("shifted", false), runner)?;
    *cpu_s += results.iter().flatten().map(|r| r.cpu_s).sum::<f64>();
    let row = |(((mesh, shift), scene), result): ((&(f64, f64), _), &Option<_>)| {
        let (max, late, profile, failure) = errors(scene, result.as_ref());
        let required = required(shape, quadrature, *mesh);
        Shift {
            shift: *shift,
            scheme: word(shape),
            quadrature: word(quadrature),
            mesh_m: *mesh,
            ppc: PARTICLES,
            max_error_compressible: max,
            late_error_compressible: late,
            profile_error_compressible: profile,
            held: passed(required, max, failure.is_some()),
            required,
            failure,
        }
    };
    Ok(cases.iter().zip(&scenes).zip(&results).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_displacement_is_there_once() {
        let all = displacements();
        assert_eq!(all.len(), SMOOTH.len() + (JITTER.len() + 1) * SEEDS as usize);
        assert_eq!(all.iter().filter(|(kind, _)| *kind == "both").count(), SEEDS as usize);
        for (place, one) in all.iter().enumerate() {
            assert!(!all[..place].contains(one), "{one:?} twice");
        }
    }

    #[test]
    fn a_row_that_could_not_be_run_falls_short() {
        let found = [
            passed(None, f64::NAN, true),
            passed(None, 0.5, false),
            passed(Some(0.1), 0.05, false),
            passed(Some(0.1), 0.5, false),
        ];
        assert_eq!(found, [Some(false), None, Some(true), Some(false)]);
    }

    #[test]
    fn only_fitted_splines_on_the_coarse_mesh_have_a_limit() {
        assert_eq!(required(ShapeChoice::Bspline2, Quadrature::Fitted, 0.10), Some(REQUIRED));
        assert_eq!(required(ShapeChoice::Bspline2, Quadrature::Volumes, 0.10), None);
        assert_eq!(required(ShapeChoice::Bspline2, Quadrature::Fitted, 0.05), None);
        assert_eq!(required(ShapeChoice::Linear, Quadrature::Volumes, 0.10), None);
    }
}
