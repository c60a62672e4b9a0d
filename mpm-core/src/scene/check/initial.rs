//! `[initial]`: the state at t = 0, from keys or a table.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use toml::{Spanned, Value};

use super::super::initial::{Initial, Row};
use super::super::raw::RawScene;
use super::super::{Dimension, Fields, Start, read_text};
use super::{Checked, Reader, clipped};
use crate::error::SceneError;
use crate::order::sort_by_number;

/// No table is larger, bytes.
const LARGEST_TABLE: u64 = 256 << 20;
/// What a state is given by.
const GIVEN_BY: &str = "either table, or any of pressure, stress_xx, stress_yy, stress_zz, stress_xy";
/// What is in a line of a table.
const LINE: &str =
    "a line of finite numbers y_m, x_m (or none) and some of pressure_pa, stress_xx_pa, _yy_, _zz_, _xy_";

impl Reader<'_> {
    /// The checked `[initial]`, of a scene that has its water and start.
    pub(super) fn initial(&self, raw: &RawScene, scene: &Fields) -> Checked<Option<Initial>> {
        let Some(given) = &raw.initial else {
            let span = raw.start.as_ref().map_or(0..0, Spanned::span);
            let refused = || self.refuse(&span, "start", "[initial] with it, which gives the state", "none");
            return if scene.start == Start::Given { refused() } else { Ok(None) };
        };
        let (keys, mut initial) = (given.get_ref(), Initial::default());
        for (key, value) in keys {
            match Initial::KEYS.iter().position(|known| known == key) {
                Some(i) => initial.lines[i] = self.line_of(value, &format!("initial.{key}"))?,
                None if key == "table" && keys.len() == 1 => initial = self.table(value)?,
                None => return self.refuse(&value.span(), "initial", GIVEN_BY, key),
            }
        }
        let refused = [
            (0, scene.water.is_none(), "no pore pressure in a dry scene"),
            (
                0,
                scene.free_surface.is_some(),
                "none with [water.free_surface], whose level or wet gives the saturated soil",
            ),
            (4, scene.dimension == Dimension::Column, "none in a column, which has no shear stress"),
        ];
        let has = |i: usize| initial.corners().any(|(_, values)| values[i] != 0.0);
        match refused.into_iter().find(|(i, refused, _)| *refused && has(*i)) {
            Some((i, _, expected)) => {
                self.refuse(&given.span(), &format!("initial.{}", Initial::KEYS[i]), expected, "some")
            }
            None if keys.is_empty() => self.refuse(&given.span(), "initial", GIVEN_BY, "none"),
            None => Ok(Some(initial)),
        }
    }

    /// A number, or pairs of a height and a number.
    fn line_of(&self, value: &Spanned<Value>, key: &str) -> Checked<Vec<[f64; 2]>> {
        let number =
            |value: &Value| value.as_float().or(value.as_integer().map(|i| i as f64)).filter(|x| x.is_finite());
        let pair = |value: &Value| match value.as_array()?.as_slice() {
            [height, value] => Some([number(height)?, number(value)?]),
            _ => None,
        };
        let line = match value.get_ref() {
            Value::Array(list) => list.iter().map(pair).collect::<Option<Vec<_>>>(),
            value => number(value).map(|value| vec![[0.0, value]]),
        };
        let expected = "a number (Pa), or pairs [height (m), value (Pa)], heights that ascend";
        let line = line.filter(|line| !line.is_empty() && line.is_sorted_by(|a, b| a[0] <= b[0]));
        line.map_or_else(|| self.refuse(&value.span(), key, expected, value.get_ref()), Ok)
    }

    /// Reads a table, or that of a folder of results; its path is from where the scene file is.
    fn table(&self, path: &Spanned<Value>) -> Checked<Initial> {
        let folder = self.source.file.as_ref().and_then(|file| Path::new(&**file).parent()).unwrap_or(Path::new(""));
        let mut file = folder.join(path.get_ref().as_str().unwrap_or_default());
        if file.is_dir() {
            file.push("state.csv");
        }
        let name = file.display().to_string();
        let text = read_text(&file, LARGEST_TABLE).or_else(|why| {
            let expected = "a table (CSV), or a folder of results with state.csv (solve --state)";
            self.refuse(&path.span(), "initial.table", expected, format!("{name}: {why}"))
        })?;
        let refuse = |line: u64, found: String| {
            let (file, line, found) = (name.clone(), line as usize, clipped(found));
            Err(SceneError::new((file, line), "initial.table", LINE, found))
        };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let (mut rows, mut in_plane): (Vec<Row>, bool) = (Vec::new(), false);
        for (line, numbers) in (2..).zip(reader.deserialize::<BTreeMap<String, f64>>()) {
            let mut numbers = match numbers {
                Ok(numbers) => numbers,
                Err(why) => return refuse(why.position().map_or(1, csv::Position::line), why.to_string()),
            };
            let (found, mut take) = (format!("{numbers:?}"), |key: &str| numbers.remove(key));
            let (x, y) = (take("x_m"), take("y_m").unwrap_or(f64::NAN));
            let values = Initial::KEYS.map(|key| take(&format!("{key}_pa")).unwrap_or(0.0));
            rows.push(([x.unwrap_or(0.0), y], values));
            in_plane |= x.is_some();
            if !numbers.is_empty() || !values.iter().chain(&rows[rows.len() - 1].0).all(|number| number.is_finite()) {
                return refuse(line, found);
            }
        }
        if rows.is_empty() {
            return refuse(1, "none".to_owned());
        }
        sort_by_number(&mut rows, |([_, y], _)| *y);
        let mut initial = Initial { table: Some(name), ..Initial::default() };
        if in_plane {
            initial.rows = Arc::new(rows);
        } else {
            initial.lines = std::array::from_fn(|i| rows.iter().map(|([_, y], values)| [*y, values[i]]).collect());
        }
        Ok(initial)
    }
}
