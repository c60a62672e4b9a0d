//! `[[loads]]`: what bears them, and how they go on in time.

use std::ops::Range;

use toml::Spanned;

use super::super::raw::{RawCourse, RawLoad, RawScene};
use super::super::{Course, Dimension, FaceLoad, Fields, Side, SolidSide};
use super::{Checked, Reader};

/// What a course is said by.
const ONE_COURSE: &str = "at most one of ramp_time, times, sine, wave";

impl Reader<'_> {
    /// The checked `[[loads]]`, of a scene that has all else.
    pub(super) fn loads(&self, raw: &RawScene, scene: &Fields) -> Checked<Vec<FaceLoad>> {
        let Some(list) = &raw.loads else { return Ok(Vec::new()) };
        list.get_ref().iter().map(|load| self.load(load, scene)).collect()
    }

    fn load(&self, load: &Spanned<RawLoad>, scene: &Fields) -> Checked<FaceLoad> {
        let (raw, span) = (load.get_ref(), load.span());
        let words = Side::ALL.map(|side| (side.word(), side));
        let on = self.word(raw.on.as_ref(), "loads.on", &words, Side::Top)?;
        let on_span = raw.on.as_ref().map_or(span.clone(), Spanned::span);
        let column = scene.dimension == Dimension::Column;
        if column && matches!(on, Side::Left | Side::Right) {
            let expected = "\"top\" or \"bottom\": a column is loaded along its axis";
            return self.refuse(&on_span, "loads.on", expected, format!("\"{on}\""));
        }
        if scene.outline.is_none() && scene.solid_sides[on as usize] != SolidSide::Free {
            let expected = format!("boundaries.{on} = \"free\" beside it: a held face carries no load");
            return self.refuse(&on_span, "loads.on", &expected, format!("\"{on}\""));
        }
        let finite = |value: &Option<Spanned<f64>>, key: &str| match value {
            Some(value) => self.within(value, key, "a finite number (Pa)", |_| true),
            None => Ok(0.0),
        };
        let (pressure, shear) = (finite(&raw.pressure, "loads.pressure")?, finite(&raw.shear, "loads.shear")?);
        if pressure == 0.0 && shear == 0.0 {
            return self.refuse(&span, "loads", "a pressure or a shear other than 0 (Pa)", "neither");
        }
        let one_way =
            [(raw.shear.as_ref().map(Spanned::span), "loads.shear"), (raw.x.as_ref().map(Spanned::span), "loads.x")];
        for (place, key) in one_way.into_iter().chain([(raw.y.as_ref().map(Spanned::span), "loads.y")]) {
            if let (Some(place), true) = (place, column) {
                let expected = "dimension = \"plane-strain\" beside it: a column is pressed along its axis, all over";
                return self.refuse(&place, key, expected, "\"column\"");
            }
        }
        let between = |value: &Option<Spanned<[f64; 2]>>, key: &str| match value {
            Some(value) if !matches!(*value.get_ref(), [low, high] if low < high) => {
                let [low, high] = value.get_ref();
                self.refuse(&value.span(), key, "two places [low, high], low < high (m)", format!("[{low}, {high}]"))
            }
            value => Ok(value.as_ref().map(|value| *value.get_ref())),
        };
        let (x, y) = (between(&raw.x, "loads.x")?, between(&raw.y, "loads.y")?);
        let course = RawCourse { ramp_time: &raw.ramp_time, times: &raw.times, sine: &raw.sine, wave: &raw.wave };
        let checked = FaceLoad { on, x, y, pressure, shear, course: self.course("loads", &span, &course)? };
        if crate::seeding::pieces(&scene.outline_or_box(), scene.spacing())
            .all(|piece| checked.part_of(&piece).is_none())
        {
            let expected = "faces of the soil that look there, between x and y";
            return self.refuse(&span, "loads", expected, "none");
        }
        Ok(checked)
    }

    /// How something goes on in time.
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
                let points: Vec<[f64; 2]> = list.get_ref().iter().map(|point| *point.get_ref()).collect();
                let expected = "pairs [time (s), factor], times that ascend";
                let wrong = points.iter().position(|point| !point.iter().all(|x| x.is_finite()));
                let falls = points.windows(2).position(|pair| pair[0][0] > pair[1][0]).map(|i| i + 1);
                if let Some(i) = wrong.or(falls) {
                    let [time, factor] = points[i];
                    return self.refuse(
                        &list.get_ref()[i].span(),
                        &key("times"),
                        expected,
                        format!("[{time}, {factor}]"),
                    );
                }
                if points.is_empty() {
                    return self.refuse(&list.span(), &key("times"), expected, "none");
                }
                Ok(Course::Times(points))
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
                length: self.positive(&wave.get_ref().length, &key("wave.length"), "m")?,
                period: self.positive(&wave.get_ref().period, &key("wave.period"), "s")?,
            }),
            _ => self.refuse(span, table, ONE_COURSE, "several"),
        }
    }
}
