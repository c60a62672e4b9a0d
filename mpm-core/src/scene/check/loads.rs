//! `[[loads]]`: what bears them, and their course in time.

use std::ops::Range;

use toml::{Spanned, Value};

use super::super::raw::{Pairs, RawCourse, RawLoad, RawPlate, RawReservoir, RawScene, RawWell};
use super::super::{Bearing, Course, Dimension, FaceLoad, Fields, MovedPlate, Side, SolidSide, TimeMethod, Well};
use super::{Checked, Reader};
use crate::seeding;

/// Most loads on faces.
const MOST_LOADS: usize = 64;
/// What a course is said by.
const ONE_COURSE: &str = "at most one of ramp_time, times, sine, wave";

impl Reader<'_> {
    /// The checked `[[loads]]` and `[[reservoirs]]`, of a scene that has all else.
    pub(super) fn loads(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<FaceLoad>> {
        let loads = raw.loads.iter().flat_map(|list| list.get_ref()).map(|load| self.load(load, scene));
        let reservoirs = raw.reservoirs.iter().flat_map(|list| list.get_ref());
        let of = |list: Option<usize>| list.unwrap_or(0);
        let count =
            of(raw.loads.as_ref().map(|l| l.get_ref().len())) + of(raw.reservoirs.as_ref().map(|l| l.get_ref().len()));
        if let (Some(list), true) = (&raw.loads, count > MOST_LOADS) {
            return self.refuse(&list.span(), "loads", &format!("at most {MOST_LOADS} loads and reservoirs"), count);
        }
        let all: Vec<FaceLoad> =
            loads.chain(reservoirs.map(|reservoir| self.reservoir(reservoir, scene))).collect::<Checked<_>>()?;
        let changes = |load: &FaceLoad| load.is_water() || load.course != Course::Constant;
        if let (TimeMethod::Krylov, Some(which)) = (scene.method, all.iter().position(changes)) {
            let expected = "constant loads with method = \"krylov\", and no water against the soil";
            let span = raw.loads.as_ref().and_then(|list| Some(list.get_ref().get(which)?.span())).unwrap_or_default();
            return self.refuse(&span, "loads", expected, "one that changes");
        }
        Ok(all)
    }

    fn load(&self, load: &Spanned<RawLoad>, scene: &Fields) -> Checked<FaceLoad> {
        let (raw, span) = (load.get_ref(), load.span());
        let number = |value: &Option<Spanned<f64>>, key: &str| match value {
            Some(value) => self.within(value, key, "a finite number (Pa)", |_| true),
            None => Ok(0.0),
        };
        let (pressure, shear) = (number(&raw.pressure, "loads.pressure")?, number(&raw.shear, "loads.shear")?);
        if pressure == 0.0 && shear == 0.0 {
            return self.refuse(&span, "loads", "a pressure or a shear other than 0 (Pa)", "neither");
        }
        if let (Some(value), Dimension::Column) = (&raw.shear, scene.dimension) {
            let expected = "dimension = \"plane-strain\" with it: a column is loaded along its axis";
            return self.refuse(&value.span(), "loads.shear", expected, "\"column\"");
        }
        let water = raw.water.unwrap_or(false);
        if water && scene.water.is_none() {
            return self.refuse(
                &span,
                "loads.water",
                "[water] with it: the pores of a dry scene hold no water",
                "a dry scene",
            );
        }
        let course = RawCourse { ramp_time: &raw.ramp_time, times: &raw.times, sine: &raw.sine, wave: &raw.wave };
        let load = FaceLoad {
            on: Some(self.side(&raw.on, "loads.on")?),
            x: self.range(&raw.x, "loads.x")?,
            y: self.range(&raw.y, "loads.y")?,
            bearing: Bearing::Traction { pressure, shear, water },
            course: self.course("loads", &span, &course)?,
        };
        self.bears("loads", (&span, &raw.on), load, scene)
    }

    fn reservoir(&self, reservoir: &Spanned<RawReservoir>, scene: &Fields) -> Checked<FaceLoad> {
        let (raw, span) = (reservoir.get_ref(), reservoir.span());
        if scene.water.is_none() || scene.gravity.is_none() {
            let expected = "[water] and gravity with it: a level needs water with weight";
            return self.refuse(&span, "reservoirs", expected, "a scene without them");
        }
        if scene.slope_angle.is_some() {
            let expected = "no slope_angle with it: the surface of its water would not be level along x";
            return self.refuse(&span, "reservoirs", expected, "a tilted scene");
        }
        let levels = match (&raw.level, &raw.levels) {
            (Some(level), None) => {
                Course::Times(vec![[0.0, self.within(level, "reservoirs.level", "a height (m)", |_| true)?]])
            }
            (None, Some(list)) => {
                self.times("reservoirs.levels", "pairs [time (s), level (m)], times that ascend", list)?
            }
            _ => return self.refuse(&span, "reservoirs", "exactly one of level or levels", "both or neither"),
        };
        let on = raw.on.is_some().then(|| self.side(&raw.on, "reservoirs.on")).transpose()?;
        if scene.integrator.solves_displacements() && on.is_none() {
            return self.refuse(
                &span,
                "reservoirs.on",
                "the side where it stands, where displacements are solved for",
                "none",
            );
        }
        let (x, y) = (self.range(&raw.x, "reservoirs.x")?, self.range(&raw.y, "reservoirs.y")?);
        let load = FaceLoad { on, x, y, bearing: Bearing::Reservoir, course: levels };
        self.bears("reservoirs", (&span, &raw.on), load, scene)
    }

    /// The checked `[[plates]]`, of a scene that has all else.
    pub(super) fn plates(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<MovedPlate>> {
        raw.plates.iter().flat_map(|list| list.get_ref()).map(|plate| self.plate(plate, scene)).collect()
    }

    fn plate(&self, plate: &Spanned<RawPlate>, scene: &Fields) -> Checked<MovedPlate> {
        let (raw, span) = (plate.get_ref(), plate.span());
        let on = self.side(&raw.on, "plates.on")?;
        let place = raw.on.as_ref().map_or(span.clone(), Spanned::span);
        let sideways = matches!(on, Side::Left | Side::Right);
        let room = match on {
            Side::Top => scene.empty_cells_above,
            Side::Right => scene.empty_cells_beside,
            Side::Left | Side::Bottom => 0,
        };
        if scene.solid_sides[on as usize] != SolidSide::Free
            || room > 0
            || (sideways && scene.dimension == Dimension::Column)
        {
            let expected =
                format!("boundaries.{on} = \"free\" and no empty cells beyond it: a plate is a side of the mesh");
            return self.refuse(&place, "plates.on", &expected, format!("\"{on}\""));
        }
        let number = |value: &Option<Spanned<f64>>, key: &str| match value {
            Some(value) => self.within(value, key, "a finite number, positive into the soil", |_| true),
            None => Ok(0.0),
        };
        let (displacement, velocity) =
            (number(&raw.displacement, "plates.displacement")?, number(&raw.velocity, "plates.velocity")?);
        let course = RawCourse { ramp_time: &raw.ramp_time, times: &raw.times, sine: &raw.sine, wave: &None };
        let course = self.course("plates", &span, &course)?;
        if displacement != 0.0 && course == Course::Constant {
            let expected = "ramp_time, times or sine with a displacement: soil cannot move in no time";
            return self.refuse(&span, "plates.displacement", expected, "none of them");
        }
        let (x, y) = (self.range(&raw.x, "plates.x")?, self.range(&raw.y, "plates.y")?);
        let along = if sideways { (&raw.x, "plates.x") } else { (&raw.y, "plates.y") };
        if let (Some(value), key) = along {
            return self.refuse(&value.span(), key, "the range along its side", "the one across");
        }
        Ok(MovedPlate { on, x, y, rough: raw.rough.unwrap_or(false), displacement, course, velocity })
    }

    fn side(&self, word: &Option<Spanned<String>>, key: &str) -> Checked<Side> {
        self.word(word.as_ref(), key, &Side::ALL.map(|side| (side.word(), side)), Side::Top)
    }

    /// The checked `[[wells]]`, of a scene that has all else.
    pub(super) fn wells(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<Well>> {
        raw.wells.iter().flat_map(|list| list.get_ref()).map(|well| self.well(well, scene)).collect()
    }

    fn well(&self, well: &Spanned<RawWell>, scene: &Fields) -> Checked<Well> {
        let (raw, span) = (well.get_ref(), well.span());
        let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        let at = match raw.at.get_ref() {
            Value::Array(list) if list.len() == 2 => number(&list[0]).zip(number(&list[1])),
            height => number(height).filter(|_| scene.dimension == Dimension::Column).map(|y| (0.5 * scene.width, y)),
        };
        let in_soil = |at: &[f64; 2]| seeding::near(&scene.outline_or_box(), at, 1e-9 * scene.cell);
        let Some(at) = at.map(|(x, y)| [x, y]).filter(in_soil) else {
            let expected = "a place in the soil: [x, y], or a height in a column (m)";
            return self.refuse(&raw.at.span(), "wells.at", expected, raw.at.get_ref());
        };
        let expected = "a finite number other than 0 (m3/s per metre), below 0 for water that is put in";
        let rate = self.within(&raw.rate, "wells.rate", expected, |rate| rate != 0.0)?;
        let course = RawCourse { ramp_time: &raw.ramp_time, times: &raw.times, sine: &raw.sine, wave: &None };
        Ok(Well { at, rate, course: self.course("wells", &span, &course)? })
    }

    fn range(&self, value: &Option<Spanned<[f64; 2]>>, key: &str) -> Checked<Option<[f64; 2]>> {
        match value {
            Some(value) if !matches!(*value.get_ref(), [low, high] if low < high) => {
                let [low, high] = value.get_ref();
                self.refuse(&value.span(), key, "two places [low, high], low < high (m)", format!("[{low}, {high}]"))
            }
            value => Ok(value.as_ref().map(|value| *value.get_ref())),
        }
    }

    /// A load that faces of the soil bear.
    fn bears(
        &self,
        table: &str,
        (span, on): (&Range<usize>, &Option<Spanned<String>>),
        load: FaceLoad,
        scene: &Fields,
    ) -> Checked<FaceLoad> {
        let (key, place) = (format!("{table}.on"), on.as_ref().map_or(span.clone(), Spanned::span));
        let side = load.on.map_or("all free faces".to_owned(), |side| format!("\"{side}\""));
        if scene.dimension == Dimension::Column {
            let along = matches!(load.on, None | Some(Side::Top | Side::Bottom));
            if !along || load.x.is_some() || load.y.is_some() {
                let expected = "\"top\" or \"bottom\", all over, in a column";
                return self.refuse(&place, &key, expected, side);
            }
        }
        // Water may stand before a wall that is fixed and lets it through.
        if let (Some(on), None, false) = (load.on, &scene.outline, load.is_water())
            && scene.solid_sides[on as usize] != SolidSide::Free
        {
            let expected = format!("boundaries.{on} = \"free\" with it: a load on a constrained face has no effect");
            return self.refuse(&place, &key, &expected, side);
        }
        if load.is_water() && scene.empty_cells_beside > 0 && scene.free_surface.is_none() {
            let expected = "no mesh.empty_cells_beside with water outside: soil that flows out takes its water particles along, \
                            and takes none in";
            return self.refuse(span, table, expected, format!("empty_cells_beside = {}", scene.empty_cells_beside));
        }
        if scene.pieces_under(&load).is_empty() {
            return self.refuse(span, table, "faces of the soil towards that side, between x and y", "none");
        }
        Ok(load)
    }

    /// A polyline in time.
    pub(super) fn times(&self, key: &str, expected: &str, list: &Pairs) -> Checked<Course> {
        let points: Vec<[f64; 2]> = list.get_ref().iter().map(|point| *point.get_ref()).collect();
        let wrong = points.iter().position(|point| !point.iter().all(|x| x.is_finite()));
        let falls = points.windows(2).position(|pair| pair[0][0] > pair[1][0]).map(|i| i + 1);
        if let Some(i) = wrong.or(falls) {
            let [time, factor] = points[i];
            return self.refuse(&list.get_ref()[i].span(), key, expected, format!("[{time}, {factor}]"));
        }
        if points.is_empty() { self.refuse(&list.span(), key, expected, "none") } else { Ok(Course::Times(points)) }
    }

    /// Course in time.
    fn course(&self, table: &str, span: &Range<usize>, raw: &RawCourse) -> Checked<Course> {
        let key = |name: &str| format!("{table}.{name}");
        match (raw.ramp_time, raw.times, raw.sine, raw.wave) {
            (None, None, None, None) => Ok(Course::Constant),
            (Some(value), None, None, None) => {
                match self.within(value, &key("ramp_time"), "0 or more (s)", |t| t >= 0.0)? {
                    0.0 => Ok(Course::Constant),
                    time => Ok(Course::Ramp(time)),
                }
            }
            (None, Some(list), None, None) => {
                self.times(&key("times"), "pairs [time (s), factor], times that ascend", list)
            }
            (None, None, Some(sine), None) => {
                let raw = sine.get_ref();
                let number = |value: &Option<Spanned<f64>>, name: &str, usual: f64| {
                    let finite = |value| self.within(value, &key(name), "a finite number", |_| true);
                    value.as_ref().map_or(Ok(usual), finite)
                };
                Ok(Course::Sine {
                    mean: number(&raw.mean, "sine.mean", 0.0)?,
                    amplitude: number(&raw.amplitude, "sine.amplitude", 1.0)?,
                    period: self.positive(&raw.period, &key("sine.period"), "s")?,
                    phase: number(&raw.phase, "sine.phase", 0.0)?,
                })
            }
            (None, None, None, Some(wave)) => Ok(Course::Wave {
                length: self.within(
                    &wave.get_ref().length,
                    &key("wave.length"),
                    "a length other than 0 (m); of a wave that runs to the left one below 0",
                    |length| length != 0.0,
                )?,
                period: self.positive(&wave.get_ref().period, &key("wave.period"), "s")?,
            }),
            _ => self.refuse(span, table, ONE_COURSE, "several"),
        }
    }
}
