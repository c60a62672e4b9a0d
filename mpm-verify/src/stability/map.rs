//! The stability map: the largest stable step of every scheme over meshes, particles, conductivities and bulk moduli of
//! the water, measured and in theory.
//!
//! Columns are [`ROWS`] cells high on every mesh, and plane strain has [`PLANE`] cells: the limit belongs to the shortest
//! waves, and a column of ten cells is within 0.6 % of an endless one.

use mpm_core::scene::{DarcyChoice, Dimension, Integrator, Scene, ShapeChoice};
use mpm_core::stability::{limit_of_exact_numbers, stable_limit};
use serde::{Deserialize, Serialize};

use super::assembled::{self, Assembled};
use super::bisection::largest_stable;
use super::growth::{Growth, blocks_for, growth, stirred};
use crate::error::Error::{self, Unfit};
use crate::experiment::pool;
use crate::progress::Progress;
use crate::study::word;

/// Cells of a column.
pub const ROWS: usize = 12;
/// Cells across and up in plane strain.
pub const PLANE: [usize; 2] = [4, 5];
/// Cell edges of the study, m.
pub const MESHES: [f64; 4] = [0.1, 0.05, 0.02, 0.01];
/// Particles per cell.
pub const PARTICLES: [usize; 4] = [1, 4, 9, 16];
/// Hydraulic conductivities, m/s.
pub const CONDUCTIVITIES: [f64; 8] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
/// Bulk moduli of the water, Pa.
pub const BULK_MODULI: [f64; 5] = [2e7, 2e8, 2e9, 2e10, 2e11];
/// Shapes that have a limit of their own; `centroid` is `centre` in full cells.
pub const SHAPES: [ShapeChoice; 5] =
    [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::BBar, ShapeChoice::Gimp, ShapeChoice::Bspline2];
/// Integrators with a limit of their own.
pub const INTEGRATORS: [Integrator; 2] = [Integrator::Explicit, Integrator::SemiImplicit];

/// A measured limit is known to this share: that between the largest step seen to hold and the smallest seen to grow.
pub const WIDTH: f64 = 0.004;
/// The same of a limit in theory that is found by bisection.
const THEORY_WIDTH: f64 = 0.001;
/// Measured limits are within this share of the theory.
pub const AGREEMENT: f64 = 0.02;

/// One place of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// One dimension or plane strain.
    pub dimension: Dimension,
    /// How time is integrated.
    pub integrator: Integrator,
    /// Shape functions.
    pub shape: ShapeChoice,
    /// Darcy operator.
    pub darcy: DarcyChoice,
    /// Whether Darcy's law keeps `rho_w a_s`.
    pub inertia: bool,
    /// Cell edge L, m.
    pub mesh: f64,
    /// Particles per cell in plane strain; a column has the square root.
    pub ppc: usize,
    /// Hydraulic conductivity k, m/s.
    pub conductivity: f64,
    /// Bulk modulus of the water K_w, Pa.
    pub bulk_modulus: f64,
}

impl Setting {
    /// The column of Table 1 with these changes, or a piece of it in plane strain.
    pub fn scene(&self) -> Result<Scene, Error> {
        Ok(crate::scenes::terzaghi().edited(|scene| {
            (scene.dimension, scene.integrator, scene.shape) = (self.dimension, self.integrator, self.shape);
            (scene.darcy, scene.darcy_inertia) = (self.darcy, self.inertia);
            (scene.cell, scene.particles_per_cell) = (self.mesh, self.ppc);
            scene.cells = if self.dimension == Dimension::Column { [1, ROWS] } else { PLANE };
            (scene.width, scene.height) = (scene.cells[0] as f64 * self.mesh, scene.cells[1] as f64 * self.mesh);
            scene.water = scene.water.map(|water| mpm_core::scene::WaterProperties {
                hydraulic_conductivity: self.conductivity,
                bulk_modulus: self.bulk_modulus,
                ..water
            });
            (scene.step, scene.force, scene.history) = (mpm_core::scene::StepChoice::Auto, true, 0);
        })?)
    }

    /// Whether the limit of a plane wave in an endless mesh is that of the setting, to better than the agreement asked for.
    ///
    /// It is in a column of linear functions, and of their averages over particles. It is not for B-splines, whose
    /// stiffest state is that of a free end; in plane strain, where a few cells between rollers have fewer waves; and in
    /// semi-implicit steps with inertia in Darcy's law, which is that of the step before.
    fn has_formula(&self) -> bool {
        self.dimension == Dimension::Column
            && self.shape.spline_degree().is_none()
            && !(self.integrator == Integrator::SemiImplicit && self.inertia)
    }
}

/// One row of `stability_map.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Integrator and shape functions: `semi-implicit-bspline2`.
    pub scheme: String,
    /// Darcy operator.
    pub darcy: String,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell in plane strain; a column has the square root.
    pub ppc: usize,
    /// Hydraulic conductivity k, m/s.
    pub k: f64,
    /// Bulk modulus of the water K_w, Pa.
    pub k_w: f64,
    /// Largest step seen to be stable, s.
    pub dt_measured_s: f64,
    /// Limit in theory, s.
    pub dt_theory_s: f64,
    /// Measured over theory.
    pub ratio: f64,
    /// Integrator alone.
    pub integrator: String,
    /// Shape functions alone.
    pub shape: String,
    /// `column` or `plane-strain`.
    pub dimension: String,
    /// Whether Darcy's law keeps `rho_w a_s`.
    pub darcy_inertia: bool,
    /// Where the theory is from: `plane wave` or `step matrix`.
    pub theory: String,
    /// Smallest step seen to grow, s.
    pub dt_grows_s: f64,
    /// Growth per step at the largest stable step.
    pub growth_below: f64,
    /// Growth per step at the smallest step seen to grow.
    pub growth_above: f64,
    /// Step that `auto` takes, s.
    pub dt_auto_s: f64,
    /// That over the measured limit.
    pub auto_ratio: f64,
    /// Growth per step at the step of `auto`.
    pub auto_growth: f64,
    /// Whether that is unstable.
    pub auto_unstable: bool,
    /// Limit of which `auto` takes its share, s.
    pub dt_limit_s: f64,
    /// That over the measured limit.
    pub limit_ratio: f64,
    /// Why this limit is further from the measured one than the agreement asked for; else empty.
    pub gap: String,
}

/// Why the limit is far below the measured one in soil that hardly drains.
const ROUND_OFF: &str = "a longer step is stable but leaves more than 1e-7 of the drained strain to round-off";

/// Why the limit of which `auto` takes its share is not the measured one; empty where it is, to the agreement asked for.
fn gap(setting: &Setting, ratio: f64) -> &'static str {
    let splines = setting.shape.spline_degree().is_some();
    let semi = setting.integrator == Integrator::SemiImplicit;
    match setting.dimension {
        _ if (ratio - 1.0).abs() <= AGREEMENT => "",
        _ if semi && splines => "splines are held to the dry skeleton at a free end, whatever the water does",
        Dimension::Column if semi && ratio < 1.0 => {
            "late inertia raises the step of an eigenvalue -1, which is not counted on, and feeds waves by less per step \
             than counts as growth here"
        }
        _ if splines => "splines are held to linear functions and to a free end with c = 1",
        Dimension::PlaneStrain if semi => "bilinear cells are held to their stiffest deformation with c = 1",
        _ => {
            "the strain and the flow that bind, at a drained edge or in an endless mesh, do not fit into a few cells together"
        }
    }
}

impl Row {
    /// What is wrong with a row, if anything is.
    pub fn trouble(&self) -> Option<String> {
        let Self { scheme, dimension, darcy, mesh_m, ppc, k, k_w, .. } = self;
        let place = format!("{dimension} {scheme} {darcy} L = {mesh_m} m, {ppc} per cell, k = {k:e}, K_w = {k_w:e}");
        if self.auto_unstable || self.dt_auto_s > self.dt_measured_s {
            return Some(format!(
                "{place}: expected a step of auto that is stable, found {:.4e} s, which grows by {:.4} per step; \
                 stable is {:.4e} s",
                self.dt_auto_s, self.auto_growth, self.dt_measured_s
            ));
        }
        ((self.ratio - 1.0).abs() > AGREEMENT || self.ratio.is_nan()).then(|| {
            format!(
                "{place}: expected a measured limit within {AGREEMENT} of the theory, {:.4e} s, found {:.4e} s",
                self.dt_theory_s, self.dt_measured_s
            )
        })
    }
}

/// How much of the map is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// All of it.
    Whole,
    /// The ends and the middle of every range, for a look within a minute.
    Thin,
}

/// The places of the map: in the column all meshes, particles, conductivities and bulk moduli without inertia in Darcy's
/// law, fewer with it; fewer again in plane strain.
pub fn settings(extent: Extent) -> Vec<Setting> {
    let mut all = Vec::new();
    for (integrator, shape, darcy) in schemes() {
        let mut add = |dimension, inertia, ranges: Ranges| {
            ranges.each(extent, |mesh, ppc, conductivity, bulk_modulus| {
                let (mesh, ppc) = (*mesh, *ppc);
                all.push(Setting {
                    dimension,
                    integrator,
                    shape,
                    darcy,
                    inertia,
                    mesh,
                    ppc,
                    conductivity,
                    bulk_modulus,
                });
            });
        };
        let (column, plane) = (Dimension::Column, Dimension::PlaneStrain);
        let whole = Ranges {
            meshes: &MESHES,
            particles: &PARTICLES,
            conductivities: &CONDUCTIVITIES,
            bulk_moduli: &BULK_MODULI,
        };
        add(column, false, whole);
        add(column, true, Ranges { meshes: &[0.1, 0.02], particles: &[1, 4], bulk_moduli: &[2e7, 2e9, 2e11], ..whole });
        let few = Ranges { meshes: &[0.1], particles: &[1, 4, 9], conductivities: &[1e-3, 1e-5, 1e-8], ..whole };
        for inertia in [false, true] {
            add(plane, inertia, Ranges { bulk_moduli: &[2e7, 2e9, 2e11], ..few });
        }
    }
    all
}

/// Integrators, shapes and Darcy operators that go together: the nodal operator is that of the explicit step with linear
/// functions.
pub fn schemes() -> impl Iterator<Item = (Integrator, ShapeChoice, DarcyChoice)> {
    let all = INTEGRATORS.into_iter().flat_map(|integrator| SHAPES.into_iter().map(move |shape| (integrator, shape)));
    all.flat_map(|(integrator, shape)| {
        let corners = matches!(shape, ShapeChoice::Centre | ShapeChoice::Linear);
        let nodal = integrator == Integrator::Explicit && corners;
        let face = [(integrator, shape, DarcyChoice::Face)];
        face.into_iter().chain(nodal.then_some((integrator, shape, DarcyChoice::Nodal)))
    })
}

/// What a part of the map ranges over.
#[derive(Debug, Clone, Copy)]
struct Ranges<'a> {
    meshes: &'a [f64],
    particles: &'a [usize],
    conductivities: &'a [f64],
    bulk_moduli: &'a [f64],
}

impl Ranges<'_> {
    /// Calls for every mesh, number of particles, conductivity and bulk modulus.
    fn each(&self, extent: Extent, mut call: impl FnMut(&f64, &usize, f64, f64)) {
        for mesh in some(self.meshes, extent) {
            for ppc in some(self.particles, extent) {
                for conductivity in some(self.conductivities, extent) {
                    for bulk_modulus in some(self.bulk_moduli, extent) {
                        call(mesh, ppc, *conductivity, *bulk_modulus);
                    }
                }
            }
        }
    }
}

/// All of a range, or its ends and, where it has one, its middle.
fn some<T>(range: &[T], extent: Extent) -> impl Iterator<Item = &T> {
    let last = range.len() - 1;
    let keep = move |i: usize| extent == Extent::Whole || i == 0 || i == last || 2 * i == last;
    range.iter().enumerate().filter(move |(i, _)| keep(*i)).map(|(_, value)| value)
}

/// Measures some places with `jobs` threads; rows in the order of the settings.
///
/// # Errors
/// Particles that cannot be placed.
pub fn rows(settings: &[Setting], jobs: usize, progress: &Progress) -> Result<Vec<Row>, Error> {
    let mut count = 0;
    let told = |_, _: &Result<_, Error>| {
        count += 1;
        progress.set((count * 1_000_000 / settings.len()) as u64);
        if count.is_multiple_of(SPOKEN) {
            progress.piped_line(&format!("stability map: {count} of {} rows", settings.len()));
        }
    };
    pool::each(jobs, settings, |_, setting| row(setting), told).into_iter().map(Result::flatten).collect()
}

/// Rows between two lines of progress.
const SPOKEN: usize = 1000;

/// Measures one place.
///
/// # Errors
/// Particles that cannot be placed.
pub fn row(setting: &Setting) -> Result<Row, Error> {
    let scene = setting.scene()?;
    let limit = stable_limit(&scene);
    let auto = scene.safety * limit;
    let assembled = Assembled::of(&scene).ok_or(Unfit("a scene whose step is no matrix"))?;
    let (theory, from) = if setting.has_formula() {
        (limit_of_exact_numbers(&scene), "plane wave")
    } else {
        let grows = |dt: f64| assembled.growth(dt) > assembled::NEUTRAL;
        (largest_stable(limit_of_exact_numbers(&scene), THEORY_WIDTH, grows).stable, "step matrix")
    };
    let blocks = blocks_for(assembled.growth_above(theory));
    let stirred = stirred(&scene);
    let mut fault = None;
    let (mut below, mut above) = (f64::NAN, f64::NAN);
    let mut measure = |dt: f64| match growth(&stirred, dt, blocks) {
        Ok(found) => found,
        Err(e) => {
            fault = Some(e);
            Growth { per_step: f64::NAN, unstable: true }
        }
    };
    let at_auto = measure(auto);
    let measured = largest_stable(theory, WIDTH, |dt| {
        let found = measure(dt);
        *(if found.unstable { &mut above } else { &mut below }) = found.per_step;
        found.unstable
    });
    if let Some(fault) = fault {
        return Err(fault);
    }
    Ok(Row {
        scheme: format!("{}-{}", word(setting.integrator), word(setting.shape)),
        darcy: word(setting.darcy),
        mesh_m: setting.mesh,
        ppc: setting.ppc,
        k: setting.conductivity,
        k_w: setting.bulk_modulus,
        dt_measured_s: measured.stable,
        dt_theory_s: theory,
        ratio: measured.stable / theory,
        integrator: word(setting.integrator),
        shape: word(setting.shape),
        dimension: word(setting.dimension),
        darcy_inertia: setting.inertia,
        theory: from.to_owned(),
        dt_grows_s: measured.unstable,
        growth_below: below,
        growth_above: above,
        dt_auto_s: auto,
        auto_ratio: auto / measured.stable,
        auto_growth: at_auto.per_step,
        auto_unstable: at_auto.unstable,
        dt_limit_s: limit,
        limit_ratio: limit / measured.stable,
        gap: if limit < limit_of_exact_numbers(&scene) {
            ROUND_OFF.to_owned()
        } else {
            gap(setting, limit / measured.stable).to_owned()
        },
    })
}

/// What the rows of a scheme have in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Integrator and shape functions.
    pub scheme: String,
    /// `column` or `plane-strain`.
    pub dimension: String,
    /// Darcy operator.
    pub darcy: String,
    /// How many there are.
    pub rows: usize,
    /// Smallest and largest measured limit over theory.
    pub ratio: [f64; 2],
    /// Smallest and largest limit of `auto` over the measured one.
    pub auto: [f64; 2],
    /// Rows whose `gap` says why `auto` is that far below.
    pub explained: usize,
}

/// One summary per dimension, scheme and Darcy operator, in the order of the rows.
pub fn summaries(rows: &[Row]) -> Vec<Summary> {
    let mut all: Vec<Summary> = Vec::new();
    for row in rows {
        let same = |s: &Summary| s.scheme == row.scheme && s.dimension == row.dimension && s.darcy == row.darcy;
        let known = all.iter().position(same).unwrap_or_else(|| {
            let (scheme, dimension, darcy) = (row.scheme.clone(), row.dimension.clone(), row.darcy.clone());
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            all.push(Summary { scheme, dimension, darcy, rows: 0, ratio: none, auto: none, explained: 0 });
            all.len() - 1
        });
        let summary = &mut all[known];
        summary.rows += 1;
        summary.explained += usize::from(!row.gap.is_empty());
        for (range, value) in [(&mut summary.ratio, row.ratio), (&mut summary.auto, row.auto_ratio)] {
            *range = [range[0].min(value), range[1].max(value)];
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::stability::Medium;

    fn column(integrator: Integrator, shape: ShapeChoice) -> Setting {
        Setting {
            dimension: Dimension::Column,
            integrator,
            shape,
            darcy: DarcyChoice::Face,
            inertia: false,
            mesh: 0.02,
            ppc: 4,
            conductivity: 1e-4,
            bulk_modulus: 2e9,
        }
    }

    #[test]
    fn rows_agree_with_their_theory_on_any_number_of_threads() {
        let progress = Progress::new("", true);
        let settings: Vec<Setting> =
            schemes().filter(|s| s.2 == DarcyChoice::Face).map(|(i, shape, _)| column(i, shape)).collect();
        let rows = |jobs| rows(&settings, jobs, &progress).expect("rows");
        let found = rows(2);
        for row in &found {
            assert_eq!(row.trouble(), None);
            assert!(row.growth_below <= 1.0015 && row.growth_above > 1.0, "{row:?}");
        }
        assert_eq!(found, rows(1));
        assert_eq!(summaries(&found).len(), 10);
    }

    #[test]
    fn a_wrong_theory_and_an_unsafe_auto_are_found_out() {
        let row = row(&column(Integrator::Explicit, ShapeChoice::Centre)).expect("a row");
        assert_eq!(row.trouble(), None);
        let wrong = Row { dt_theory_s: 1.03 * row.dt_theory_s, ratio: row.ratio / 1.03, ..row.clone() };
        assert!(wrong.trouble().expect("trouble").contains("within 0.02 of the theory"));
        assert!(Row { ratio: f64::NAN, ..row.clone() }.trouble().is_some());
        let unsafe_ = Row { auto_unstable: true, ..row.clone() };
        assert!(unsafe_.trouble().expect("trouble").contains("a step of auto that is stable"));
        assert!(Row { dt_auto_s: 1.01 * row.dt_measured_s, ..row }.trouble().is_some());
    }

    #[test]
    fn the_step_matrix_of_a_column_has_the_limit_of_its_plane_waves() {
        for integrator in INTEGRATORS {
            for (ppc, conductivity) in [(1, 1e-9), (4, 1e-4), (16, 1e-2)] {
                let scene = Setting { ppc, conductivity, ..column(integrator, ShapeChoice::Linear) }
                    .scene()
                    .expect("a sound scene");
                let assembled = Assembled::of(&scene).expect("a column");
                let formula = limit_of_exact_numbers(&scene);
                let found = largest_stable(formula, 1e-3, |dt| assembled.growth(dt) > assembled::NEUTRAL).stable;
                assert!((found / formula - 1.0).abs() < 0.01, "{integrator:?}, {ppc}: {found:e}, {formula:e}");
            }
        }
        // Particles that took and gave all would have another one.
        let scene = column(Integrator::Explicit, ShapeChoice::Linear).scene().expect("a sound scene");
        let mesh = Medium { shortest_transfer: 1.0, ..Medium::of(&scene) }.limit_column();
        assert!((stable_limit(&scene) / mesh - 1.0).abs() > 0.01);
    }

    #[test]
    fn a_drained_edge_is_what_lowers_limits_in_plane_strain() {
        for inertia in [false, true] {
            let setting = Setting {
                dimension: Dimension::PlaneStrain,
                mesh: 0.1,
                conductivity: 1e-3,
                bulk_modulus: 2e7,
                inertia,
                ..column(Integrator::Explicit, ShapeChoice::Linear)
            };
            let mut scene = setting.scene().expect("a sound scene");
            let limit = stable_limit(&scene);
            let over = |scene: &Scene| {
                let assembled = Assembled::of(scene).expect("a block");
                largest_stable(limit, 0.003, |dt| assembled.growth(dt) > assembled::NEUTRAL).stable / limit
            };
            let drained = over(&scene);
            scene = scene
                .edited(|scene| {
                    scene.stages.iter_mut().for_each(|stage| stage.drained = [false; 4]);
                })
                .expect("a sound scene");
            let closed = over(&scene);
            // The limit takes strain and flow of the edge together, which no state of it has: it is safe, by up to an eighth.
            assert!((1.0..1.15).contains(&drained) && closed > drained + 0.015, "{inertia}: {drained}, {closed}");
        }
    }

    #[test]
    fn b_bar_has_a_limit_of_its_own_in_plane_strain() {
        let of = |shape| Setting {
            dimension: Dimension::PlaneStrain,
            mesh: 0.1,
            conductivity: 1e-5,
            ..column(Integrator::SemiImplicit, shape)
        };
        let b_bar = row(&of(ShapeChoice::BBar)).expect("a row");
        assert_eq!(b_bar.trouble(), None);
        // With the theory of another shape the row would be in trouble.
        for other in [ShapeChoice::Centre, ShapeChoice::Linear] {
            let dt_theory_s = row(&of(other)).expect("a row").dt_theory_s;
            let wrong = Row { dt_theory_s, ratio: b_bar.dt_measured_s / dt_theory_s, ..b_bar.clone() };
            assert!(wrong.trouble().is_some(), "{other:?}: {dt_theory_s:e} for {:e}", b_bar.dt_measured_s);
        }
    }

    #[test]
    fn limits_come_nearer_to_those_of_an_endless_mesh_on_more_cells() {
        let setting = Setting {
            dimension: Dimension::PlaneStrain,
            mesh: 0.1,
            ppc: 1,
            conductivity: 1e-3,
            ..column(Integrator::Explicit, ShapeChoice::Centre)
        };
        let mut scene = setting.scene().expect("a sound scene");
        let limit = stable_limit(&scene);
        let over = [PLANE, [6, 7]].map(|cells| {
            scene = scene
                .edited(|scene| {
                    scene.cells = cells;
                    (scene.width, scene.height) = (cells[0] as f64 * scene.cell, cells[1] as f64 * scene.cell);
                })
                .expect("a sound scene");
            let assembled = Assembled::of(&scene).expect("a block");
            largest_stable(limit, 0.003, |dt| assembled.growth(dt) > assembled::NEUTRAL).stable / limit
        });
        assert!(over[0] > 1.05 && over[1] > 1.0 && over[1] - 1.0 < 0.7 * (over[0] - 1.0), "{over:?}");
    }

    #[test]
    fn the_map_covers_what_it_says() {
        let whole = settings(Extent::Whole);
        let part = |s: &&Setting| s.dimension == Dimension::Column && !s.inertia;
        assert_eq!(whole.iter().filter(part).count(), 12 * 4 * 4 * 8 * 5);
        let thin = settings(Extent::Thin);
        assert!(5 * thin.len() < whole.len() && thin.iter().all(|s| whole.contains(s)));
    }
}
