//! `[water.free_surface]`: what is wet, what is fed, and what it does not go together with.

use toml::Spanned;

use super::super::raw::{
    Pairs, RawBrooksCorey, RawFeed, RawFeeds, RawFreeSurface, RawGardner, RawRetention, RawScene, RawStage,
    RawVanGenuchten,
};
use super::super::{Coupling, Course, Dimension, Feed, Fields, FreeSurfaceWater, Integrator, Side, Until};
use super::{Checked, Reader, quoted, written};
use crate::real::array_of;
use crate::seeding;
use crate::water::free_surface::LEAST_OPEN;
use crate::water::retention::Retention;

/// Courses along or for the sides of a scene.
type Courses = [Course; 4];

impl Reader<'_> {
    pub(super) fn coupling(&self, stage: &RawStage) -> Checked<Coupling> {
        let words = [
            ("seepage", Coupling::Seepage),
            ("soil", Coupling::Soil),
            ("full", Coupling::Full),
            ("staggered", Coupling::Full),
        ];
        self.word(stage.coupling.as_ref(), "stages.coupling", &words, Coupling::Seepage)
    }

    /// The checked table of a scene whose geometry is known.
    pub(super) fn free_surface(&self, raw: &RawScene, scene: &Fields) -> Checked<Option<FreeSurfaceWater>> {
        let Some(table) = raw.water.as_ref().and_then(|water| water.get_ref().free_surface.as_ref()) else {
            return Ok(None);
        };
        let raw = table.get_ref();
        let saturation = match &raw.saturation {
            Some(value) => {
                let expected = "0 <= saturation < 1 (share of the pores)";
                self.within(value, "water.free_surface.saturation", expected, |s| (0.0..1.0).contains(&s))?
            }
            None => 0.0,
        };
        let mobile = scene.porosity * (1.0 - saturation);
        if mobile < LEAST_OPEN {
            let expected = format!("n (1 - saturation) >= {LEAST_OPEN}: mobile water needs open pores");
            let (span, key) = match &raw.saturation {
                Some(value) => (value.span(), "water.free_surface.saturation"),
                None => (table.span(), "water.free_surface"),
            };
            return self.refuse(&span, key, &expected, written(mobile));
        }
        if let (Some(wet), Some(_)) = (&raw.wet, &raw.level) {
            let expected = "either level or wet, not both";
            return self.refuse(&wet.span(), "water.free_surface.wet", expected, "both");
        }
        let retention = raw.retention.as_ref().map(|law| self.retention(law.get_ref())).transpose()?;
        let suction = match &raw.suction {
            Some(value) if retention.is_none() => {
                let expected = "[water.free_surface.retention] with it: without one soil is full or empty";
                return self.refuse(&value.span(), "water.free_surface.suction", expected, "none");
            }
            Some(value) => Some(self.positive(value, "water.free_surface.suction", "m of suction head")?),
            None => None,
        };
        let level = match &raw.level {
            Some(value) if retention.is_some() => {
                let expected = "at most the top of the soil (m); below 0 is a level below the base";
                let level = self.within(value, "water.free_surface.level", expected, |l| l <= scene.height);
                Some(level.map_err(|fault| fault.with(format!("top {} m", scene.height)))?)
            }
            Some(value) => {
                let expected = "0 < level <= the top of the soil (m)";
                let level = self.within(value, "water.free_surface.level", expected, |l| l > 0.0 && l <= scene.height);
                Some(level.map_err(|fault| fault.with(format!("top {} m", scene.height)))?)
            }
            None => None,
        };
        if let (Some(law), None, None) = (&raw.retention, level, suction) {
            let expected = "level or suction (m) in [water.free_surface] with it: what the soil holds at t = 0";
            return self.refuse(&law.span(), "water.free_surface.retention", expected, "neither");
        }
        if let (Some(suction), Some(_)) = (&raw.suction, level) {
            let expected = "either level, above which the suction is that of water at rest, or suction";
            return self.refuse(&suction.span(), "water.free_surface.suction", expected, "both");
        }
        let wet = self.wet(raw, scene)?;
        let unsaturated = retention.is_some();
        let (feeds, courses, heads) = match &raw.feed {
            Some(feeds) => self.feeds(feeds.get_ref(), scene, unsaturated)?,
            None => ([None; 4], Default::default(), Default::default()),
        };
        Ok(Some(FreeSurfaceWater { saturation, level, wet, suction, retention, heads, feeds, courses }))
    }

    fn retention(&self, raw: &RawRetention) -> Checked<Retention> {
        let key = |name| format!("water.free_surface.retention.{name}");
        Ok(match raw {
            RawRetention::VanGenuchten(RawVanGenuchten { alpha, n, entry }) => Retention::VanGenuchten {
                alpha: self.positive(alpha, &key("van_genuchten.alpha"), "1/m")?,
                n: self.within(n, &key("van_genuchten.n"), "above 1 and at most 20", |n| n > 1.0 && n <= 20.0)?,
                entry: match entry {
                    Some(entry) => self.within(entry, &key("van_genuchten.entry"), "0 or more (m)", |e| e >= 0.0)?,
                    None => 0.0,
                },
            },
            RawRetention::Gardner(RawGardner { alpha }) => {
                Retention::Gardner { alpha: self.positive(alpha, &key("gardner.alpha"), "1/m")? }
            }
            RawRetention::BrooksCorey(RawBrooksCorey { entry, index }) => Retention::BrooksCorey {
                entry: self.positive(entry, &key("brooks_corey.entry"), "m of suction head")?,
                index: self
                    .within(index, &key("brooks_corey.index"), "above 0 and at most 20", |x| x > 0.0 && x <= 20.0)?,
            },
        })
    }

    /// The corners of the soil that is full of water at t = 0; all of it must be soil.
    fn wet(&self, raw: &RawFreeSurface, scene: &Fields) -> Checked<Option<Vec<[f64; 2]>>> {
        let Some(list) = &raw.wet else { return Ok(None) };
        let key = "water.free_surface.wet";
        if scene.dimension == Dimension::Column {
            let expected = "level, in a column: a polygon is an area";
            return self.refuse(&list.span(), key, expected, "\"column\"");
        }
        let points = self.polygon(list, key, 0.0)?;
        // Corners suffice for a convex soil; for others the middles of the edges are checked too.
        let soil = scene.outline_or_box();
        let reach = 1e-9 * (scene.width + scene.height);
        let count = points.len();
        for i in 0..count {
            let (a, b) = (points[i], points[(i + 1) % count]);
            for share in [0.0, 0.25, 0.5, 0.75] {
                let x = array_of::<_, 2, _>(|d| a[d] + share * (b[d] - a[d]));
                if !seeding::near(&soil, &x, reach) {
                    let expected = "water inside the soil";
                    let found = format!("[{}, {}], outside its outline", x[0], x[1]);
                    return self.refuse(&list.get_ref()[i.min(count - 1)].span(), key, expected, found);
                }
            }
        }
        Ok(Some(points))
    }

    fn feeds(
        &self,
        feeds: &RawFeeds,
        scene: &Fields,
        unsaturated: bool,
    ) -> Checked<([Option<Feed>; 4], Courses, Courses)> {
        let (mut checked, mut courses, mut heads) = ([None; 4], Courses::default(), Courses::default());
        let raw = [&feeds.left, &feeds.right, &feeds.bottom, &feeds.top];
        for (side, raw) in Side::ALL.into_iter().zip(raw) {
            if let Some(raw) = raw {
                checked[side as usize] = Some(match &raw.get_ref().heads {
                    Some(list) => {
                        heads[side as usize] = self.heads(list, side, raw.get_ref(), unsaturated)?;
                        Feed::Head(
                            list.get_ref().iter().map(|pair| pair.get_ref()[1]).fold(f64::NEG_INFINITY, f64::max),
                        )
                    }
                    None => self.feed(raw, side, scene, unsaturated)?,
                });
                if let Some(list) = &raw.get_ref().times {
                    courses[side as usize] = self.feed_in_time(list, side, raw.get_ref().head.is_some())?;
                }
            }
        }
        Ok((checked, courses, heads))
    }

    /// Heads along the bottom or the top.
    fn heads(&self, list: &Pairs, side: Side, raw: &RawFeed, unsaturated: bool) -> Checked<Course> {
        let key = format!("water.free_surface.feed.{side}.heads");
        if raw.head.is_some() || raw.velocity.is_some() || raw.height.is_some() || raw.times.is_some() {
            return self.refuse(&list.span(), &key, "heads alone, or head, or velocity", "several");
        }
        if !unsaturated || matches!(side, Side::Left | Side::Right) {
            let expected = "heads along the bottom or the top of soil with a [water.free_surface.retention]";
            return self.refuse(&list.span(), &key, expected, side);
        }
        self.times(&key, "pairs [x (m), head (m)], places that ascend", list)
    }

    /// Course of a velocity in time.
    fn feed_in_time(&self, list: &Pairs, side: Side, is_head: bool) -> Checked<Course> {
        let key = format!("water.free_surface.feed.{side}.times");
        if is_head {
            let expected = "times with a velocity; a level that rises and falls is that of [[reservoirs]]";
            return self.refuse(&list.span(), &key, expected, "a head");
        }
        let expected = "pairs [time (s), factor of 0 or more], times that ascend";
        if let Some(pair) = list.get_ref().iter().find(|pair| pair.get_ref()[1] < 0.0) {
            return self.refuse(&pair.span(), &key, expected, pair.get_ref()[1]);
        }
        self.times(&key, expected, list)
    }

    fn feed(&self, raw: &Spanned<RawFeed>, side: Side, scene: &Fields, unsaturated: bool) -> Checked<Feed> {
        let (span, feed) = (raw.span(), raw.get_ref());
        let key = format!("water.free_surface.feed.{side}");
        if scene.dimension == Dimension::Column && matches!(side, Side::Left | Side::Right) {
            return self.refuse(&span, &key, "a feed at the bottom or the top of a column", side);
        }
        if let (Side::Top, Some(value), None) = (side, &feed.velocity, &feed.head) {
            // Rain, which falls on all soil under the sky.
            let speed = self.positive(value, &format!("{key}.velocity"), "m/s into the soil")?;
            if let Some(height) = &feed.height {
                let expected =
                    "no height with a velocity at the top: it is rain, which falls on every surface that faces upwards";
                return self.refuse(&height.span(), &format!("{key}.height"), expected, height.get_ref());
            }
            return Ok(Feed::Velocity { speed, height: scene.height });
        }
        // Where the soil touches the side, from its lowest to its highest point, m.
        let Some([low, high]) = touching(&scene.outline_or_box(), side, scene) else {
            return self.refuse(&span, &key, "soil along the side of the feed", "a wall with no soil");
        };
        let (is_head, value) =
            self.either(&span, &key, ("head", feed.head.as_ref()), ("velocity", feed.velocity.as_ref()))?;
        if !is_head {
            let speed = self.positive(value, &format!("{key}.velocity"), "m/s into the soil")?;
            let height = match &feed.height {
                Some(value) => {
                    let expected = "above the lowest soil at the side (m)";
                    self.within(value, &format!("{key}.height"), expected, |h| h > low)
                        .map_err(|fault| fault.with(format!("lowest soil at {low} m")))?
                }
                None => high,
            };
            return Ok(Feed::Velocity { speed, height });
        }
        if let Some(height) = &feed.height {
            let expected = "no height with a head, which is one";
            return self.refuse(&height.span(), &format!("{key}.height"), expected, height.get_ref());
        }
        // Unsaturated soil takes water from a level below it, and gives it.
        let hangs = unsaturated && scene.gravity.is_some() && matches!(side, Side::Bottom | Side::Top);
        let least = match (scene.gravity, side) {
            _ if hangs => f64::NEG_INFINITY,
            (None, _) => 0.0,
            (Some(_), Side::Left | Side::Right | Side::Bottom) => low,
            (Some(_), Side::Top) => high,
        };
        let expected = match side {
            _ if hangs => "a level above the base (m)",
            _ if scene.gravity.is_none() => "a pressure head above 0 (m)",
            Side::Top => "a level above the top of the soil (m)",
            _ => "a head above the lowest soil at the side (m)",
        };
        let head = self.within(value, &format!("{key}.head"), expected, |h| h > least);
        let head =
            head.map_err(|fault| if least.is_finite() { fault.with(format!("above {least} m")) } else { fault })?;
        let walled = scene.outline.is_some() && scene.gravity.is_some() && matches!(side, Side::Left | Side::Right);
        if walled && head > high * (1.0 + 1e-9) {
            let expected = "at most the top of the soil at this side (m): more would flow over it";
            return self
                .refuse(&value.span(), &format!("{key}.head"), expected, head)
                .map_err(|fault| fault.with(format!("top {high} m")));
        }
        Ok(Feed::Head(head))
    }

    /// Which stages move what, and by which step.
    pub(super) fn free_water(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let integrator = raw.time.as_ref().and_then(|time| time.get_ref().integrator.as_ref());
        if let (Some(word), Integrator::Coupled, false) = (integrator, scene.integrator, scene.may_fail()) {
            let expected = "a stage with coupling = \"full\" with it";
            return self.refuse(&word.span(), "time.integrator", expected, quoted(word.get_ref()));
        }
        // Soil that may fail runs staggered, or in one step with its water.
        let two = scene.integrator != Integrator::Explicit || scene.may_fail();
        let table = raw.water.as_ref().and_then(|water| water.get_ref().free_surface.as_ref());
        let two = match table {
            Some(table) if !two => {
                let expected = "integrator = \"staggered\" with it: the others need saturated soil";
                return self.refuse(&table.span(), "water.free_surface", expected, "\"explicit\"");
            }
            table => table.is_some(),
        };
        for (raw, stage) in raw.stages.get_ref().iter().map(Spanned::get_ref).zip(&scene.stages) {
            if let (Some(word), false) = (&raw.coupling, two) {
                let expected = "integrator = \"staggered\" with it";
                return self.refuse(&word.span(), "stages.coupling", expected, quoted(word.get_ref()));
            }
            if two && stage.coupling == Coupling::Seepage && !matches!(stage.until, Until::Time(_)) {
                let expected = "a time, or coupling = \"soil\": while water seeps the soil rests";
                return self.refuse(&raw.until.span(), "stages.until", expected, "another end");
            }
        }
        Ok(())
    }
}

/// From where to where the soil touches a side of the mesh, m above the base (left, right) or along it; `None` if it does not.
pub(super) fn touching(soil: &[[f64; 2]], side: Side, scene: &Fields) -> Option<[f64; 2]> {
    let (axis, at) = match side {
        Side::Left => (0, 0.0),
        Side::Right => (0, scene.width),
        Side::Bottom => (1, 0.0),
        Side::Top => (1, scene.height),
    };
    // Beyond the soil there may be empty cells.
    if (side == Side::Right && scene.empty_cells_beside > 0) || (side == Side::Top && scene.empty_cells_above > 0) {
        return None;
    }
    let near = 1e-9 * (scene.width + scene.height);
    let count = soil.len();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..count {
        let ends = [soil[i], soil[(i + 1) % count]];
        if ends.iter().all(|x| (x[axis] - at).abs() <= near) {
            for x in ends {
                low = low.min(x[1]);
                high = high.max(x[1]);
            }
        }
    }
    (low <= high).then_some([low, high])
}
