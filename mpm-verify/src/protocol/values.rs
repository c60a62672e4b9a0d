//! Neutral cases that no scene of ours runs: elements of soil along a path, slopes, bodies in motion. Their exact or published numbers
//! stand in `reference-data/protocol`.

use serde::Deserialize;
use serde_json::Value as Json;

use super::units::{Scale, of_key};
use crate::error::Error::{self, Found, Lacks};
use crate::exact::oracle::Table;
use crate::experiment::comparison::{Compared, Comparison};

/// Names and texts of the files.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/protocol.rs"));

/// Tables of exact numbers that files name.
const TABLES: &[(&str, &str)] = &[
    ("10_mc_triaxial.csv", include_str!("../../../reference-data/exact/10_mc_triaxial.csv")),
    ("10_mc_plane_strain.csv", include_str!("../../../reference-data/exact/10_mc_plane_strain.csv")),
    ("13_cam_clay_oedometer.csv", include_str!("../../../reference-data/exact/13_cam_clay_oedometer.csv")),
];

/// A case of a file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Values {
    /// What it is called.
    pub title: String,
    /// The problem in words.
    pub problem: String,
    /// Its equations, in LaTeX.
    pub equations: Vec<String>,
    /// Where its numbers are from.
    pub sources: Vec<String>,
    /// What is refined.
    pub refined_by: String,
    /// Refinements, coarse to fine.
    pub refinements: Vec<f64>,
    /// Largest errors of schemes of first and of second order on the last of them.
    pub expected: [f64; 2],
    /// Whether a scheme without error is one that is right, and no sign that numbers were copied.
    #[serde(default)]
    pub exact_by_nature: bool,
    /// Whether the exact solution has inertia.
    #[serde(default)]
    pub inertia: bool,
    /// Whether strains are large.
    #[serde(default)]
    pub large_strain: bool,
    /// Name of a scene that says what is given.
    pub scene: Option<String>,
    /// What is given, where no scene says it.
    pub given: Option<Json>,
    /// Keys of what is given that stay as they are, whatever the scale.
    #[serde(default)]
    pub fixed: Vec<String>,
    /// What is asked.
    pub wanted: Vec<Asked>,
}

/// Numbers that are asked for.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// Name of the quantity.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// What it is, with its sign.
    pub meaning: String,
    /// The numbers.
    #[serde(default)]
    pub points: Vec<Point>,
    /// A table that has them, in place of `points`.
    pub table: Option<String>,
    /// Its column along the path, of which times are shares.
    pub along: Option<String>,
    /// Its column of numbers.
    pub column: Option<String>,
    /// A factor on that column.
    pub factor: Option<f64>,
}

/// A number at a time and a place.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// s, or the share of a path.
    #[serde(default)]
    pub time: f64,
    /// m, where there is a place.
    pub x: Option<f64>,
    /// m.
    pub y: Option<f64>,
    /// The exact or published number.
    pub exact: f64,
    /// Where published ones differ: the least and the largest.
    pub band: Option<[f64; 2]>,
}

impl Asked {
    fn filled(mut self) -> Result<Self, Error> {
        let Some(name) = &self.table else { return Ok(self) };
        let text = TABLES.iter().find(|(own, _)| own == name).map(|(_, text)| *text).ok_or(Lacks("table"))?;
        let (along, column) =
            (self.along.as_deref().ok_or(Lacks("along"))?, self.column.as_deref().ok_or(Lacks("column"))?);
        let rows = Table::parse(text).rows([along, column]);
        let last = rows.last().ok_or(Lacks("row"))?[0];
        // A dozen numbers along a path are enough, its end among them.
        let every = rows.len().div_ceil(12);
        let chosen = rows.iter().rev().step_by(every).filter(|row| row[0] != 0.0);
        let factor = self.factor.unwrap_or(1.0);
        let point =
            |row: &[f64; 2]| Point { time: row[0] / last, x: None, y: None, exact: factor * row[1], band: None };
        self.points = chosen.map(point).collect();
        self.points.reverse();
        Ok(self)
    }
}

/// The case of a text.
///
/// # Errors
/// A text that is none.
pub fn read(name: &str, text: &str) -> Result<Values, Error> {
    let mut values: Values = toml::from_str(text).map_err(|error| Found(error.to_string()).of(name))?;
    values.wanted = values.wanted.into_iter().map(Asked::filled).collect::<Result<_, _>>().map_err(|e| e.of(name))?;
    Ok(values)
}

/// All of them by their names.
///
/// # Errors
/// A file that cannot be read.
pub fn all() -> Result<Vec<(&'static str, Values)>, Error> {
    FILES.iter().map(|(name, text)| Ok((*name, read(name, text)?))).collect()
}

impl Values {
    /// The same on another scale. Numbers are scaled by the unit in the name of their key.
    ///
    /// # Errors
    /// A unit that is not known.
    pub fn scaled(&self, scale: Scale) -> Result<Self, Error> {
        let mut own = self.clone();
        if let Some(given) = &mut own.given {
            stretch(given, "", scale, &self.fixed)?;
        }
        for asked in &mut own.wanted {
            let unit = asked.unit.clone();
            let of = |unit: &str| scale.factor(unit).ok_or_else(|| Found(format!("{unit}: no known unit")));
            let (factor, length) = (of(&unit)?, scale.length);
            let time = if self.inertia { scale.time } else { 1.0 };
            for point in &mut asked.points {
                point.exact *= factor;
                point.band = point.band.map(|band| band.map(|end| end * factor));
                (point.x, point.y) = (point.x.map(|x| x * length), point.y.map(|y| y * length));
                point.time *= time;
            }
        }
        Ok(own)
    }

    /// Numbers beside the exact ones, each quantity over its largest exact number. `found` gives the number for a quantity and a point.
    pub(crate) fn compared(&self, mut found: impl FnMut(&Asked, &Point) -> f64) -> Comparison {
        let mut rows = Vec::new();
        for asked in &self.wanted {
            let size = asked.points.iter().map(|point| point.exact.abs()).fold(0.0, f64::max);
            for point in &asked.points {
                let value = found(asked, point);
                // Inside a band any number is as good as another.
                let exact = match point.band {
                    Some([low, high]) if value >= low && value <= high => value,
                    Some([low, high]) => {
                        if value < low {
                            low
                        } else if value > high {
                            high
                        } else {
                            point.exact
                        }
                    }
                    None => point.exact,
                };
                rows.push(Compared::one(point.time, value / size, exact / size));
            }
        }
        Comparison::worst("values over the largest exact one of their quantity", rows)
    }
}

fn stretch(value: &mut Json, key: &str, scale: Scale, fixed: &[String]) -> Result<(), Error> {
    match value {
        Json::Object(all) => all.iter_mut().try_for_each(|(key, value)| stretch(value, key, scale, fixed)),
        Json::Array(list) => list.iter_mut().try_for_each(|value| stretch(value, key, scale, fixed)),
        Json::Number(number) if !fixed.iter().any(|own| own == key) => {
            let unit = of_key(key);
            let factor = scale.factor(unit).ok_or_else(|| Found(format!("{key}: no known unit")))?;
            if factor != 1.0 {
                *value = Json::from(number.as_f64().unwrap_or(f64::NAN) * factor);
            }
            Ok(())
        }
        _ => Ok(()),
    }
}
