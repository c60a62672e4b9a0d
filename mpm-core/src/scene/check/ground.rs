//! Outlines, slopes, friction on the base, empty cells beside the soil: their bounds, and what they do not go together with.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::{Points, RawGeometry, RawMesh, RawRest, RawScene, RawUntil};
use super::super::{Base, Dimension, NormalStress, SeedingChoice, Side, SolidSide, Until};
use super::{Checked, Reader, quoted};
use crate::real::array_of;
use crate::seeding::{self, Fault};

/// Columns of empty cells that can be asked for.
const MOST_EMPTY_BESIDE: i64 = 1_000_000;

/// The checked geometry with its mesh.
pub(super) struct Geometry {
    pub outline: Option<Vec<[f64; 2]>>,
    pub width: f64,
    pub height: f64,
    pub inner_radius: f64,
    pub cell: f64,
    /// Over the width and the height.
    pub cells: [usize; 2],
    pub empty_cells_beside: usize,
}

/// Checked keys of the top level.
pub(super) struct Ground {
    pub start_velocity: Option<[f64; 2]>,
    pub start_k0: Option<f64>,
    pub slope_angle: Option<f64>,
    /// Its seismic coefficient.
    pub seismic_coefficient: Option<f64>,
}

/// Words that only some sides know; where the side then is not held otherwise.
pub(super) fn own_words(side: Side) -> &'static [(&'static str, SolidSide)] {
    match side {
        Side::Left | Side::Right => &[("periodic", SolidSide::Free)],
        Side::Bottom => &[("coulomb", SolidSide::Roller)],
        Side::Top => &[],
    }
}

impl Reader<'_> {
    pub(super) fn geometry(&self, raw: &RawScene, dimension: Dimension) -> Checked<Geometry> {
        let mesh = raw.mesh.get_ref();
        let empty_cells_beside = self.empty_cells_beside(mesh)?;
        let (radius, key) = match raw.geometry.get_ref() {
            RawGeometry::Column(column) => (&column.inner_radius, "geometry.column.inner_radius"),
            RawGeometry::Outline(outline) => (&outline.inner_radius, "geometry.outline.inner_radius"),
        };
        let fits = |r: f64| r >= 0.0 && dimension == Dimension::Axisymmetric;
        let expected = "a radius of 0 or more (m), with dimension = \"axisymmetric\"";
        let inner_radius = radius.as_ref().map_or(Ok(0.0), |value| self.within(value, key, expected, fits))?;
        let column = match raw.geometry.get_ref() {
            RawGeometry::Column(column) => column,
            RawGeometry::Outline(outline) => {
                let points = self.polygon(&outline.points, "geometry.outline.points", 0.0)?;
                let cell = self.positive(&mesh.cell, "mesh.cell", "m")?;
                let [width, height] = array_of::<_, 2, _>(|d| points.iter().map(|x| x[d]).fold(0.0, f64::max));
                let cells = [self.covers(mesh, cell, width)?, self.covers(mesh, cell, height)?];
                return Ok(Geometry {
                    outline: Some(points),
                    width,
                    height,
                    inner_radius,
                    cell,
                    cells,
                    empty_cells_beside,
                });
            }
        };
        if let Some(value) = &mesh.seeding {
            let expected = "[geometry.outline] with it: a column is seeded with whole squares";
            return self.refuse(&value.span(), "mesh.seeding", expected, "[geometry.column]");
        }
        let height = self.positive(&column.height, "geometry.column.height", "m")?;
        let width = self.positive(&column.width, "geometry.column.width", "m")?;
        let cell = self.positive(&mesh.cell, "mesh.cell", "m")?;
        let rows = self.divides(mesh, cell, height, "height")?;
        // A column ignores the cells across, so only plane strain asks the mesh to divide the width.
        let across = match dimension {
            Dimension::Column => 1,
            _ => self.divides(mesh, cell, width, "width")?,
        };
        Ok(Geometry { outline: None, width, height, inner_radius, cell, cells: [across, rows], empty_cells_beside })
    }

    /// The corners of a simple polygon whose coordinates are at `least` so large (m), anticlockwise.
    pub(super) fn polygon(&self, list: &Points, key: &str, least: f64) -> Checked<Vec<[f64; 2]>> {
        let (span, list) = (list.span(), list.get_ref());
        let mut points = Vec::with_capacity(list.len());
        for point in list {
            match point.get_ref().as_slice() {
                [x, y] => points.push([*x, *y]),
                other => return self.refuse(&point.span(), key, "two numbers [x, y] (m)", other.len()),
            }
        }
        match seeding::check(&points, least) {
            Ok(()) => {}
            Err(Fault::TooFew(count)) => {
                return self.refuse(&span, key, "at least 3 points [x, y] (m)", count);
            }
            Err(Fault::Outside(i)) => {
                let [x, y] = points[i];
                return self.refuse(&list[i].span(), key, "finite x >= 0 and y >= 0 (m)", format!("[{x}, {y}]"));
            }
            Err(Fault::Crossing(i, j)) => {
                let expected = "a simple polygon, whose edges neither cross nor touch";
                let found = format!("edges {} and {}, counted from 1, that do", i + 1, j + 1);
                return self.refuse(&list[j].span(), key, expected, found);
            }
        }
        if seeding::area(&points) < 0.0 {
            points.reverse();
        }
        Ok(points)
    }

    /// Cells that cover a length, which they need not divide.
    fn covers(&self, mesh: &RawMesh, cell: f64, length: f64) -> Checked<usize> {
        let count = (length / cell * (1.0 - 1e-9)).ceil();
        if (1.0..1e9).contains(&count) {
            return Ok(count as usize);
        }
        let expected = "fewer than 1e9 cells over the outline";
        self.refuse(&mesh.cell.span(), "mesh.cell", expected, format!("{cell} m, {count:.1e} cells over {length} m"))
    }

    fn empty_cells_beside(&self, mesh: &RawMesh) -> Checked<usize> {
        let Some(value) = &mesh.empty_cells_beside else { return Ok(0) };
        let key = "mesh.empty_cells_beside";
        match *value.get_ref() {
            columns @ 0..=MOST_EMPTY_BESIDE => Ok(columns as usize),
            columns => self.refuse(&value.span(), key, "between 0 and 1000000 columns of cells", columns),
        }
    }

    pub(super) fn seeding(&self, mesh: &RawMesh) -> Checked<SeedingChoice> {
        let words = [("clipped", SeedingChoice::Clipped), ("whole", SeedingChoice::Whole)];
        self.word(mesh.seeding.as_ref(), "mesh.seeding", &words, SeedingChoice::Clipped)
    }

    pub(super) fn ground(&self, raw: &RawScene) -> Checked<Ground> {
        let start_velocity = match &raw.start_velocity {
            Some(value) => match value.get_ref().as_slice() {
                [x, y] if x.is_finite() && y.is_finite() => Some([*x, *y]),
                other => {
                    let expected = "two finite numbers [x, y] (m/s)";
                    return self.refuse(&value.span(), "start_velocity", expected, format!("{other:?}"));
                }
            },
            None => None,
        };
        let start_k0 = match &raw.start_k0 {
            Some(value) => Some(self.within(value, "start_k0", "a ratio of 0 or more (-)", |k| k >= 0.0)?),
            None => None,
        };
        let slope_angle = match &raw.slope_angle {
            Some(value) => {
                let expected = "-90 < angle < 90 (degrees)";
                Some(self.within(value, "slope_angle", expected, |b| b.abs() < 90.0)?)
            }
            None => None,
        };
        let seismic_coefficient = match &raw.seismic_coefficient {
            Some(value) => {
                let expected = "-1 < coefficient < 1 (share of gravity, towards +x)";
                Some(self.within(value, "seismic_coefficient", expected, |k| k.abs() < 1.0)?)
            }
            None => None,
        };
        Ok(Ground { start_velocity, start_k0, slope_angle, seismic_coefficient })
    }

    /// What the scene says; `None` for the usual.
    pub(super) fn light_nodes(&self, raw: &RawScene) -> Checked<Option<f64>> {
        let written = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().light_nodes.as_ref());
        let expected = "0 <= share <= 0.5 (of a full node's mass)";
        let share = |value| self.within(value, "scheme.light_nodes", expected, |s| (0.0..=0.5).contains(&s));
        written.map(share).transpose()
    }

    /// Both sides or neither.
    pub(super) fn periodic(&self, raw: &RawScene) -> Checked<bool> {
        let Some(table) = &raw.boundaries else { return Ok(false) };
        let is = |value: &Option<Spanned<String>>| value.as_ref().is_some_and(|word| word.get_ref() == "periodic");
        let b = table.get_ref();
        let (side, value, other) = match (is(&b.left), is(&b.right)) {
            (left, right) if left == right => return Ok(left),
            (true, _) => (Side::Left, &b.left, &b.right),
            _ => (Side::Right, &b.right, &b.left),
        };
        let span = value.as_ref().map_or(table.span(), Spanned::span);
        let found = other.as_ref().map_or("none".to_owned(), |word| quoted(word.get_ref()));
        self.refuse(&span, &format!("boundaries.{side}"), "\"periodic\" on both sides, left and right", found)
    }

    /// Friction on the base; `period` (s) is that of the soil's first swing up and down.
    pub(super) fn base(&self, raw: &RawScene, period: f64) -> Checked<Option<Base>> {
        let bottom = raw.boundaries.as_ref().and_then(|table| table.get_ref().bottom.as_ref());
        let bottom = bottom.filter(|word| word.get_ref() == "coulomb");
        let (table, base) = match (bottom, &raw.base) {
            (None, None) => return Ok(None),
            (Some(word), None) => {
                let expected = "a [base] table with it, with its friction angle";
                return self.refuse(&word.span(), "boundaries.bottom", expected, "none");
            }
            (None, Some(table)) => {
                let expected = "boundaries.bottom = \"coulomb\" with it";
                return self.refuse(&table.span(), "base", expected, "another bottom");
            }
            (Some(_), Some(table)) => (table, table.get_ref()),
        };
        let angle = |value: &Spanned<f64>, key: &str| {
            self.within(value, key, "0 <= angle < 90 (degrees)", |a| (0.0..90.0).contains(&a))
        };
        let expected = "friction_angle alone, or peak_angle, residual_angle and slip_distance together";
        let (peak_angle, residual_angle, slip_distance) =
            match (&base.friction_angle, &base.peak_angle, &base.residual_angle, &base.slip_distance) {
                (Some(value), None, None, None) => {
                    let angle = angle(value, "base.friction_angle")?;
                    (angle, angle, None)
                }
                (None, Some(peak), Some(residual), Some(distance)) => {
                    let peak = angle(peak, "base.peak_angle")?;
                    let expected = "0 <= angle <= peak_angle (degrees)";
                    let fits = |a: f64| (0.0..=peak).contains(&a);
                    let residual = self.within(residual, "base.residual_angle", expected, fits);
                    let residual = residual.map_err(|fault| fault.with(format!("peak_angle = {peak}")))?;
                    (peak, residual, Some(self.positive(distance, "base.slip_distance", "m")?))
                }
                _ => return self.refuse(&table.span(), "base", expected, "a mixture of both or too few"),
            };
        let adhesion = match &base.adhesion {
            Some(value) => self.within(value, "base.adhesion", "0 or more (Pa)", |c| c >= 0.0)?,
            None => 0.0,
        };
        let words = [("effective", NormalStress::Effective), ("total", NormalStress::Total)];
        let normal_stress =
            self.word(base.normal_stress.as_ref(), "base.normal_stress", &words, NormalStress::Effective)?;
        let memory = match &base.memory {
            Some(value) => self.within(value, "base.memory", "a time of 0 or more (s)", |t| t >= 0.0)?,
            None => period,
        };
        Ok(Some(Base { peak_angle, residual_angle, slip_distance, adhesion, memory, normal_stress }))
    }

    /// The end of a stage by rest.
    pub(super) fn rest(&self, rest: &Spanned<RawRest>, until: &RawUntil, span: &Range<usize>) -> Checked<Until> {
        let others = [&until.time, &until.time_factor, &until.pore_pressure_within, &until.at_most];
        if others.into_iter().any(Option::is_some) || until.everywhere.is_some() {
            let expected = "exactly one of time, time_factor, pore_pressure_within, rest";
            return self.refuse(span, "stages.until", expected, "several");
        }
        let rest = rest.get_ref();
        Ok(Until::Rest {
            speed: self.positive(&rest.speed, "stages.until.rest.speed", "m/s")?,
            at_most: self.positive(&rest.at_most, "stages.until.rest.at_most", "s")?,
        })
    }
}
