//! Limit equilibrium of the slopes of a scene: its soils, its water, and what loads its ground.
//!
//! Both ways that the ground falls are looked at, the left one mirrored; the lower factor counts. What the method of
//! slices does not know is said in words in place of a number.

use mpm_core::observe::Frame;
use mpm_core::scene::{Ground, NormalStress, Piece, Reduction, Scene, Side, SolidSide};

use crate::error::Error::{self, Unfit};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};
use crate::exact::limit_equilibrium::factor::Method;
use crate::exact::limit_equilibrium::water::Phreatic;
use crate::exact::limit_equilibrium::{Critical, FirmBase, Limits, Outside, Section, Soil};

/// Lengths below this share of the height are none.
const ROUND_OFF: f64 = 1e-9;
/// A face whose run is a smaller share of its height is vertical: 85 degrees.
const VERTICAL: f64 = 0.087;
/// Share of the section that slides deeper than the least depth: that of [`mpm_core::failure::Which::Deep`].
const DEEP: f64 = 0.01;
/// Slices of a slide.
const SLICES: usize = 120;
/// Ways that a slope falls: towards +x and, mirrored, towards -x.
const WAYS: [f64; 2] = [1.0, -1.0];

/// Points (m) as they are seen from in front (1), or in a mirror (-1) about the width (m) of the scene.
fn seen(points: &[[f64; 2]], way: f64, width: f64) -> Vec<[f64; 2]> {
    let mirrored = points.iter().rev().map(|[x, y]| [width - x, *y]);
    if way > 0.0 { points.to_vec() } else { mirrored.collect() }
}

/// The upper side of an outline (m, anticlockwise), from left to right.
///
/// # Errors
/// It overhangs, or the lower side is not the base.
fn surface(outline: &[[f64; 2]], height: f64) -> Result<Vec<[f64; 2]>, Error> {
    let near = ROUND_OFF * height;
    let [left, right] = [-1.0, 1.0].map(|side| {
        let end = outline.iter().map(|x| side * x[0]).fold(f64::NEG_INFINITY, f64::max);
        let at_end = (0..outline.len()).filter(|i| (side * outline[*i][0] - end).abs() <= near);
        at_end.max_by(|a, b| outline[*a][1].total_cmp(&outline[*b][1])).unwrap_or(0)
    });
    let count = outline.len();
    let walk = |from: usize, to: usize| (0..=(to + count - from) % count).map(move |k| outline[(from + k) % count]);
    let ground: Vec<[f64; 2]> = walk(right, left).collect::<Vec<_>>().into_iter().rev().collect();
    if let Some(pair) = ground.windows(2).find(|pair| pair[1][0] < pair[0][0] - near) {
        return Err(Error::Found(format!("the surface overhangs at ({}, {}) m", pair[0][0], pair[0][1])));
    }
    let ends = [ground[0], ground[ground.len() - 1]];
    let below = |x: &[f64; 2]| ends.iter().all(|end| (end[0] - x[0]).abs() > near);
    if let Some([x, y]) = walk(left, right).find(|x| x[1] > near && below(x)) {
        return Err(Error::Found(format!("the soil does not lie on the base at ({x}, {y}) m")));
    }
    for end in ends {
        if !outline.iter().any(|x| (x[0] - end[0]).abs() <= near && x[1] <= near) {
            return Err(Error::Found(format!("the soil does not lie on the base at ({}, {}) m", end[0], end[1])));
        }
    }
    Ok(ground)
}

/// Strengths of the soils of a scene by their numbers, divided by a factor with a flow rule.
fn strengths(scene: &Scene, factor: f64, by: Reduction) -> Vec<Option<Strength>> {
    let of = |strength: mpm_core::scene::Strength| {
        let reduced = strength.reduced(factor, by);
        Strength { cohesion: reduced.cohesion, friction: reduced.friction_angle.to_radians() }
    };
    scene.ground().soils.iter().map(|soil| soil.strength.map(of)).collect()
}

/// The water of a scene at some time.
#[derive(Debug, Clone, Copy)]
pub struct Water<'a> {
    /// Free surface in the soil (x, y), m, x increasing.
    pub level: &'a [[f64; 2]],
    /// Time, s: for what is loaded then.
    pub time: f64,
    /// Cells with the pore pressures of a run; without, pressures are hydrostatic below the free surface.
    pub cells: Option<&'a Frame>,
}

impl Water<'_> {
    /// Pore pressure (Pa) of the run at (x, y), m, where the soil around is full of water of a unit weight (N/m3): hydrostatic inside a cell,
    /// linear from column to column.
    fn pressure(&self, [x, y]: [f64; 2], unit_weight: f64) -> Option<f64> {
        let frame = self.cells?;
        let [columns, rows] = frame.cells;
        let row = ((y / frame.size).max(0.0) as usize).min(rows.checked_sub(1)?);
        let above = unit_weight * ((row as f64 + 0.5) * frame.size - y);
        let of = |column: usize| {
            let cell = frame.cell.get(row * columns + column).filter(|_| column < columns)?;
            (cell.soil > FULL && cell.saturation > FULL).then_some(cell.pressure + above)
        };
        let along = (x / frame.size - 0.5).max(0.0);
        let (left, share) = (along as usize, along.fract());
        match (of(left), of(left + 1)) {
            (Some(a), Some(b)) => Some(a + share * (b - a)),
            (a, b) => a.filter(|_| share < 0.5).or(b.filter(|_| share >= 0.5)),
        }
    }
}

/// Cells with less soil or water than this are cut by a surface.
const FULL: f64 = 0.999;

/// Factors of safety by the methods of slices, and where the slides are.
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    /// Bishop's, of the circle where it is least.
    pub bishop: Option<f64>,
    /// Spencer's, of the circle where it is least.
    pub spencer: Option<f64>,
    /// Morgenstern & Price's with half a sine, of the same circle.
    pub morgenstern_price: Option<f64>,
    /// Spencer's, of the surface of any shape where it is least.
    pub any_shape: Option<f64>,
    /// Spencer's circle and the surface of any shape (x, y), m.
    pub surfaces: [Vec<[f64; 2]>; 2],
}

/// A slope of a scene, seen so that it falls towards +x.
#[derive(Debug, Clone)]
pub struct Profile {
    /// Corners (x, y) of its surface, and of the base beyond a toe on it, m; x increases.
    pub ground: Vec<[f64; 2]>,
    /// Where the soil ends, x in m.
    pub end: f64,
    /// What it rests on.
    pub base: FirmBase,
    /// Whether its contact is as strong as the soil above it.
    on_soil: bool,
    /// Towards +x (1) or mirrored (-1), and the width of the scene, m.
    way: f64,
    width: f64,
    soils: Ground,
    /// Density of the moisture ahead of the water, and of water, kg/m3 of pores; gravity, m/s2.
    moist: f64,
    water: f64,
    gravity: f64,
    /// Strengths of the soils by their numbers, divided by what is asked for.
    strengths: Vec<Option<Strength>>,
    /// Area that a slide must have deeper than the least depth, m2: as strength reduction asks.
    least_deep: f64,
}

impl Soil for Profile {
    fn strength(&self, x: f64, y: f64) -> Strength {
        self.of(x, y).unwrap_or(Strength { cohesion: f64::INFINITY, friction: 0.0 })
    }

    fn weight(&self, x: f64, [low, high]: [f64; 2], level: f64) -> f64 {
        let parts = self.soils.between(self.place(x), low, high);
        let weight = parts.iter().map(|([low, high], soil)| {
            let wet = (level.min(*high) - low).max(0.0);
            let pores = soil.porosity * (self.water * wet + self.moist * (high - low - wet));
            soil.dry_density() * (high - low) + pores
        });
        self.gravity * weight.sum::<f64>()
    }
}

impl Profile {
    /// The scene's slope towards +x (1), or what falls towards -x in a mirror (-1); `None` if nothing falls that way.
    ///
    /// # Errors
    /// Why the method of slices does not know the scene.
    pub fn of_scene(scene: &Scene, way: f64) -> Result<Option<Self>, Error> {
        let Some(gravity) = scene.gravity else { return Err(Unfit("without gravity nothing slides")) };
        if scene.soils().iter().any(|soil| soil.strength.is_none()) {
            return Err(Unfit("a soil has no strength to divide"));
        }
        if scene.surcharge.is_some() {
            return Err(Unfit("the slices know no [surcharge]: [[loads]] in its place"));
        }
        let (height, outline) = (scene.height, scene.outline_or_box());
        let mut ground = seen(&surface(&outline, height)?, way, scene.width);
        let vertical = |x: f64| {
            let x = if way > 0.0 { x } else { scene.width - x };
            Err(Error::Found(format!("the slices know no vertical face, as at x = {x} m")))
        };
        if let Some(face) =
            ground.windows(2).find(|pair| pair[1][0] - pair[0][0] < VERTICAL * (pair[0][1] - pair[1][1]).abs())
        {
            return vertical(face[0][0]);
        }
        let [end, y] = ground[ground.len() - 1];
        let beyond = if way > 0.0 { 1 } else { 0 };
        // Soil ends at the side of its mesh on the left always, on the right where there is no room beside it.
        let at_side =
            if way > 0.0 { scene.empty_cells_beside == 0 } else { outline.iter().any(|x| x[0] <= ROUND_OFF * height) };
        let wall = at_side && scene.solid_sides[beyond] != SolidSide::Free;
        if !wall {
            if y > ROUND_OFF * height {
                return vertical(end);
            }
            let top = ground.iter().map(|x| x[1]).fold(0.0, f64::max);
            let crest = ground.iter().rfind(|x| x[1] >= top * (1.0 - ROUND_OFF)).map_or(end, |x| x[0]);
            ground.push([end + (end - crest).max(height), 0.0]);
        }
        let unit = |cohesion: f64, friction: f64| Strength { cohesion, friction };
        let (contact, normal_stress) = match (scene.base, scene.solid_sides[2]) {
            (Some(base), _) => (unit(base.adhesion, base.peak_angle.to_radians()), base.normal_stress),
            // On rollers nothing holds it.
            (None, SolidSide::Roller) => (unit(0.0, 0.0), NormalStress::Effective),
            // Soil that is held slides right above, by its own strength: `on_soil`.
            (None, SolidSide::Fixed) => (unit(0.0, 0.0), NormalStress::Effective),
            (None, SolidSide::Free) => return Err(Unfit("the soil has no base")),
        };
        let water = scene.water.map_or(0.0, |water| water.density);
        let profile = Self {
            ground,
            end,
            base: FirmBase { height: 0.0, strength: contact, normal_stress },
            on_soil: scene.base.is_none() && scene.solid_sides[2] == SolidSide::Fixed,
            way,
            width: scene.width,
            soils: scene.ground(),
            moist: scene.free_surface.as_ref().map_or(0.0, |free| free.saturation) * water,
            water,
            gravity,
            strengths: strengths(scene, 1.0, Reduction::AsGiven),
            least_deep: DEEP * mpm_core::seeding::area(&outline).abs(),
        };
        Ok(profile.lowest_face().is_some().then_some(profile))
    }

    /// The same with Davis' strength over a factor.
    pub fn with_davis(self, scene: &Scene, factor: f64) -> Self {
        let base = FirmBase { strength: self.base.strength.divided(factor), ..self.base };
        Self { base, strengths: strengths(scene, factor, Reduction::Davis), ..self }
    }

    /// x of the scene at x of the profile, m, and the other way round.
    fn place(&self, x: f64) -> f64 {
        if self.way > 0.0 { x } else { self.width - x }
    }

    fn of(&self, x: f64, y: f64) -> Option<Strength> {
        self.strengths[usize::from(self.soils.zones.at(&[self.place(x), y]))]
    }

    /// The lowest part of the surface that falls, from its top to its foot (x, y), m.
    fn lowest_face(&self) -> Option<[[f64; 2]; 2]> {
        self.ground.windows(2).map(|pair| [pair[0], pair[1]]).rfind(|[top, foot]| foot[1] < top[1])
    }

    /// Slides of at least a vertical depth (m) that start on the soil.
    fn limits(&self, least_depth: f64, method: Method) -> Limits {
        let [start, last] = [self.ground[0][0], self.ground[self.ground.len() - 1][0]];
        Limits {
            least_depth,
            least_area: 0.0,
            least_deep: self.least_deep,
            starts: [start, self.end],
            ends: [start, last],
            slices: SLICES,
            method,
        }
    }

    /// Looks at the slope with its water and loads; `line` is the free surface as the profile has it (x, y), m.
    fn with<R>(&self, scene: &Scene, (water, line): (&Water, &[[f64; 2]]), look: impl FnOnce(&Section) -> R) -> R {
        let time = water.time;
        let unit_weight = self.water * self.gravity;
        let phreatic = Phreatic { line, ground: &self.ground, water_weight: unit_weight };
        let rise = |x: f64| crate::exact::limit_equilibrium::water::slope(&self.ground, x);
        let top = |x: f64| crate::exact::limit_equilibrium::water::along(&self.ground, x);
        let loaded = |x: f64| {
            scene.loads.iter().filter(move |load| {
                let place = [self.place(x), top(x)];
                let within =
                    |range: &Option<[f64; 2]>, at: f64| range.is_none_or(|[low, high]| (low..=high).contains(&at));
                load.on.is_none_or(|side| side == Side::Top) && within(&load.x, place[0]) && within(&load.y, place[1])
            })
        };
        let traction = |x: f64| {
            let place = [self.place(x), top(x)];
            let piece = Piece { middle: place, outward: [-self.way * rise(x), 1.0] };
            loaded(x).fold([0.0; 2], |sum, load| {
                let (force, factor) = (load.force(&piece), load.factor(&place, time, unit_weight));
                [sum[0] + self.way * force[0] * factor, sum[1] - force[1] * factor]
            })
        };
        let standing = |x: f64| {
            let place = [self.place(x), top(x)];
            loaded(x).filter_map(|load| load.of_water(&place, time, unit_weight)).fold(0.0, f64::max)
        };
        let level = |x: f64| if standing(x) > 0.0 { top(x) } else { phreatic.level(x) };
        let pressure = |x: f64, y: f64| {
            let hydrostatic = || standing(x) + unit_weight * (level(x) - y).max(0.0);
            water.pressure([self.place(x), y], unit_weight).unwrap_or_else(hydrostatic)
        };
        let base = FirmBase {
            strength: if self.on_soil { self.strength(self.end, 0.0) } else { self.base.strength },
            ..self.base
        };
        look(&Section {
            ground: &self.ground,
            base: Some(base),
            soil: self,
            level: &level,
            pressure: &pressure,
            outside: Outside { traction: &traction, seismic: self.way * scene.seismic_coefficient.unwrap_or(0.0) },
        })
    }

    /// Heights (m) at x (m) of the lower edges of the regions, just inside them: what a weak layer cuts slides off at.
    fn floors(&self, scene: &Scene) -> Vec<Box<dyn Fn(f64) -> f64>> {
        let inside = 0.02 * scene.cell;
        let floor = |polygon: &Vec<[f64; 2]>| -> Box<dyn Fn(f64) -> f64> {
            let (polygon, way, width) = (polygon.clone(), self.way, self.width);
            Box::new(move |x| {
                let x = if way > 0.0 { x } else { width - x };
                mpm_core::seeding::passes(&polygon, x).reduce(f64::min).map_or(f64::NEG_INFINITY, |y| y + inside)
            })
        };
        scene.regions.iter().map(|region| floor(&region.polygon)).collect()
    }

    /// The slope without end that it is like at its toe, full of water that leaves it horizontally.
    pub fn toe(&self) -> Option<InfiniteSlope> {
        let [top, foot] = self.lowest_face()?;
        let at = [0.5 * (top[0] + foot[0]), 0.5 * (top[1] + foot[1])];
        let soil = self.soils.at(&[self.place(at[0]), at[1]]);
        let dry_weight = soil.dry_density() * self.gravity;
        let water_weight = self.water * self.gravity;
        let slope = InfiniteSlope {
            angle: ((top[1] - foot[1]) / (foot[0] - top[0])).atan(),
            dry_weight,
            saturated_weight: dry_weight + soil.porosity * water_weight,
            water_weight,
            strength: self.of(at[0], at[1])?,
            seepage: Seepage::Parallel { share: 1.0 },
        };
        Some(slope.horizontal())
    }
}

/// Factors of a scene's slopes with its water, of slides with a hundredth of the section at least so deep (m): with the strength of the soils, and with Davis'
/// reduced one.
///
/// # Errors
/// Why there are none.
pub fn factors(scene: &Scene, water: &Water, depth: f64) -> Result<[Factors; 2], Error> {
    let mut least: Option<[Factors; 2]> = None;
    for way in WAYS {
        let Some(profile) = Profile::of_scene(scene, way)? else { continue };
        let line = seen(water.level, way, scene.width);
        let full = profile.factors(scene, (water, &line), depth);
        // Davis' strength belongs to the factor that it leads to: a fixed point, by secants.
        let method = if full.spencer.is_some() { Method::Spencer } else { Method::Bishop };
        let reduced = |factor: f64| profile.clone().with_davis(scene, factor);
        let ratio = |factor: f64| Some(reduced(factor).critical(scene, (water, &line), depth, method)?.factor - 1.0);
        let first = full.spencer.or(full.bishop).unwrap_or(1.0);
        let mut before = [first, ratio(first).unwrap_or(0.0)];
        let mut factor = first * (1.0 + before[1]);
        for _ in 0..DAVIS {
            let Some(excess) = ratio(factor) else { break };
            if excess.abs() < 1e-3 {
                break;
            }
            let next = factor - excess * (factor - before[0]) / (excess - before[1]);
            before = [factor, excess];
            factor = if next > 0.2 * factor && next < 2.0 * factor { next } else { factor * (1.0 + excess) };
        }
        let davis = reduced(factor).factors(scene, (water, &line), depth).times(factor);
        let found = [full, davis].map(|factors| factors.seen(way, scene.width));
        least = Some(match least {
            Some(least) if least[0].least() <= found[0].least() => least,
            _ => found,
        });
    }
    let found = least.ok_or(Unfit("the surface falls nowhere: there is no slope"))?;
    if found.iter().any(|f| f.bishop.is_none() && f.spencer.is_none()) {
        return Err(Error::Found(format!("no slip circle at least {depth} m deep has a factor of safety")));
    }
    Ok(found)
}

/// Spencer's factor alone, of the circle where it is least, with the strength of the soils.
///
/// # Errors
/// Why there is none.
pub fn spencer(scene: &Scene, water: &Water, depth: f64) -> Result<f64, Error> {
    let mut least: Option<f64> = None;
    for way in WAYS {
        let Some(profile) = Profile::of_scene(scene, way)? else { continue };
        let line = seen(water.level, way, scene.width);
        let found = profile.critical(scene, (water, &line), depth, Method::Spencer).map(|critical| critical.factor);
        least = least.into_iter().chain(found).min_by(f64::total_cmp);
    }
    least.ok_or_else(|| Error::Found(format!("no slip circle at least {depth} m deep has a factor of safety")))
}

/// Most rounds in which Davis' strength and the factor are found.
const DAVIS: usize = 6;

impl Factors {
    fn least(&self) -> f64 {
        [self.bishop, self.spencer].into_iter().flatten().fold(f64::INFINITY, f64::min)
    }

    fn times(self, factor: f64) -> Self {
        let times = |found: Option<f64>| found.map(|found| found * factor);
        Self {
            bishop: times(self.bishop),
            spencer: times(self.spencer),
            morgenstern_price: times(self.morgenstern_price),
            any_shape: times(self.any_shape),
            surfaces: self.surfaces,
        }
    }

    fn seen(self, way: f64, width: f64) -> Self {
        Self { surfaces: self.surfaces.map(|points| seen(&points, way, width)), ..self }
    }
}

impl Profile {
    /// The circle where the factor is least.
    fn critical(&self, scene: &Scene, water: (&Water, &[[f64; 2]]), depth: f64, method: Method) -> Option<Critical> {
        self.with(scene, water, |section| section.critical(&self.limits(depth, method)))
    }

    fn factors(&self, scene: &Scene, water: (&Water, &[[f64; 2]]), depth: f64) -> Factors {
        self.with(scene, water, |section| {
            let floors = self.floors(scene);
            let floors: Vec<&dyn Fn(f64) -> f64> = floors.iter().map(|floor| &**floor as &dyn Fn(f64) -> f64).collect();
            let factor = |critical: &Option<Critical>| critical.as_ref().map(|critical| critical.factor);
            let bishop = section.critical(&self.limits(depth, Method::Bishop));
            let spencer = section.critical(&self.limits(depth, Method::Spencer));
            let line = section.critical_line(&self.limits(depth, Method::Spencer), spencer.as_ref(), &floors);
            let points = |critical: &Option<Critical>| critical.as_ref().map_or_else(Vec::new, |c| c.slide.points());
            Factors {
                bishop: factor(&bishop),
                spencer: factor(&spencer),
                morgenstern_price: spencer.as_ref().and_then(|c| c.slide.factor(Method::MorgensternPrice).ok()),
                any_shape: factor(&line),
                surfaces: [points(&spencer), points(&line)],
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::{Fields, Flags};

    use super::*;
    use crate::levee::plan::scene;
    use crate::levee::variants;

    const LINE: [[f64; 2]; 6] = [[0.0, 2.3], [2.0, 1.94], [4.0, 1.52], [6.0, 1.05], [7.0, 0.79], [8.0, 0.48]];

    const DRY: Water = Water { level: &[], time: 0.0, cells: None };

    fn levee() -> Scene {
        scene("levee", &Flags::default(), variants::named("saturation-0")).expect("a scene")
    }

    #[test]
    fn the_scene_s_levee_is_the_paper_s() {
        let found = Profile::of_scene(&levee(), 1.0).expect("a slope").expect("a fall");
        assert_eq!(found.ground, [[0.0, 3.0], [3.0, 3.0], [9.0, 0.0], [15.0, 0.0]]);
        assert_eq!((found.end, found.base.strength.friction), (9.0, 30.0_f64.to_radians()));
        let (dry, water) = (2700.0 * 0.7 * 9.81, 1000.0 * 9.81);
        for (heights, level, weight) in [([0.0, 2.0], -1.0, 2.0 * dry), ([0.0, 2.0], 1.0, 2.0 * dry + 0.3 * water)] {
            let found = found.weight(1.0, heights, level);
            assert!((found / weight - 1.0).abs() < 1e-3, "{found} {weight}");
        }
        assert!(Profile::of_scene(&levee(), -1.0).expect("a slope").is_none(), "nothing falls towards the wall");
    }

    /// The levee's soil in another outline.
    fn shaped(outline: &[[f64; 2]], edit: impl FnOnce(&mut Fields)) -> Scene {
        let corners = outline.iter().copied();
        let anticlockwise = mpm_core::seeding::area(outline) > 0.0;
        // Its water need not be inside.
        levee().altered_unchecked(|scene| {
            scene.outline = Some(if anticlockwise { corners.collect() } else { corners.rev().collect() });
            [scene.width, scene.height] = [0, 1].map(|d| outline.iter().map(|x| x[d]).fold(0.0, f64::max));
            edit(scene);
        })
    }

    /// Corners of the ground that falls one way.
    fn ground(scene: &Scene, way: f64) -> Vec<[f64; 2]> {
        Profile::of_scene(scene, way).expect("a slope").expect("a fall").ground
    }

    /// Room of two metres in front of the slope, and the wall on its right.
    fn mirror(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().rev().map(|[x, y]| [11.0 - x, *y]).collect()
    }

    fn walled(scene: &mut Fields) {
        (scene.solid_sides[0], scene.solid_sides[1], scene.empty_cells_beside) =
            (SolidSide::Free, SolidSide::Roller, 0);
    }

    const HALF: [[f64; 2]; 4] = [[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [0.0, 3.0]];

    #[test]
    fn the_ground_is_the_same_in_a_mirror_either_way_round_and_with_more_corners() {
        let usual = [[0.0, 3.0], [3.0, 3.0], [9.0, 0.0], [15.0, 0.0]];
        let around: Vec<[f64; 2]> = HALF.iter().rev().copied().collect();
        for scene in [shaped(&HALF, |_| ()), shaped(&around, |_| ())] {
            assert_eq!(ground(&scene, 1.0), usual);
        }
        let mirrored = shaped(&mirror(&HALF), walled);
        assert_eq!(
            (ground(&mirrored, -1.0), Profile::of_scene(&mirrored, 1.0).ok().flatten().is_none()),
            (usual.to_vec(), true)
        );
        let corners = shaped(&[[4.0, 0.0], [9.0, 0.0], [7.0, 1.0], [3.0, 3.0], [0.0, 3.0], [0.0, 0.0]], |_| ());
        assert_eq!(ground(&corners, 1.0), [[0.0, 3.0], [3.0, 3.0], [7.0, 1.0], [9.0, 0.0], [15.0, 0.0]]);
        // Both halves back to back fall either way.
        let free = |scene: &mut Fields| scene.solid_sides[0] = SolidSide::Free;
        let whole = shaped(&[[0.0, 0.0], [18.0, 0.0], [12.0, 3.0], [6.0, 3.0]], free);
        let dam = [[0.0, 0.0], [6.0, 3.0], [12.0, 3.0], [18.0, 0.0], [24.0, 0.0]];
        assert_eq!([1.0, -1.0].map(|way| ground(&whole, way)), [dam.to_vec(), dam.to_vec()]);
        // Soil below the toe, up to a wall: the slide comes out of level ground.
        let deep = shaped(&[[0.0, 0.0], [12.0, 0.0], [12.0, 1.0], [9.0, 1.0], [3.0, 4.0], [0.0, 4.0]], walled);
        assert_eq!(ground(&deep, 1.0), [[0.0, 4.0], [3.0, 4.0], [9.0, 1.0], [12.0, 1.0]]);
    }

    #[test]
    fn a_slope_in_a_mirror_is_as_safe() {
        let values = |found: Factors| {
            [found.bishop, found.spencer, found.morgenstern_price, found.any_shape]
                .map(|factor| factor.expect("a factor"))
        };
        let of = |scene: &Scene| {
            let water = Water { level: &LINE, time: 0.0, cells: None };
            let profile = Profile::of_scene(scene, 1.0).expect("a surface").expect("a fall to the right");
            values(profile.factors(scene, (&water, &LINE), 0.3))
        };
        let usual = of(&shaped(&HALF, |_| ()));
        // Regression: circles by Bishop and Spencer; surfaces of any shape are no safer.
        let smooth = |scene: &mut Fields| scene.base.as_mut().expect("a base").peak_angle = 8.5;
        let smooth = of(&shaped(&HALF, smooth));
        assert!((smooth[0] - 0.4837).abs() < 2e-3 && (smooth[1] - 0.5047).abs() < 2e-3, "{smooth:?}");
        assert!((usual[0] - 0.9539).abs() < 2e-3 && (usual[1] - 0.9934).abs() < 2e-3, "{usual:?}");
        assert!(
            usual[3] <= usual[1] && usual[3] > 0.9 * usual[1] && (usual[2] / usual[1] - 1.0).abs() < 0.02,
            "{usual:?}"
        );
        let line = mirror(&LINE);
        let water = Water { level: &line, time: 0.0, cells: None };
        let [mirrored, _] = factors(&shaped(&mirror(&HALF), walled), &water, 0.3).expect("factors");
        let mirrored = values(mirrored);
        assert!(mirrored.iter().zip(usual).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{mirrored:?} {usual:?}");
    }

    #[test]
    fn a_base_that_is_fixed_holds_by_the_strength_of_the_soil() {
        let contact = |side: SolidSide| {
            let scene = shaped(&HALF, |scene| (scene.base, scene.solid_sides[2]) = (None, side));
            let profile = Profile::of_scene(&scene, 1.0)?.expect("a fall");
            Ok::<Strength, Error>(profile.with(&scene, (&DRY, &[]), |section| section.base.expect("a base").strength))
        };
        let own = Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() };
        assert_eq!(contact(SolidSide::Fixed).ok(), Some(own));
        assert_eq!(contact(SolidSide::Roller).ok(), Some(Strength { cohesion: 0.0, friction: 0.0 }));
        assert!(contact(SolidSide::Free).is_err_and(|why| why.to_string().contains("no base")));
    }

    #[test]
    fn what_the_slices_do_not_know_is_said() {
        let why = |outline: &[[f64; 2]], edit: fn(&mut Fields)| {
            factors(&shaped(outline, edit), &DRY, 0.3).expect_err("refused").to_string()
        };
        let walls: fn(&mut Fields) = |scene| {
            walled(scene);
            scene.solid_sides[0] = SolidSide::Roller;
        };
        for (outline, expected) in [
            (&[[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [4.0, 2.0], [0.0, 3.0]][..], "overhangs at"),
            (&[[0.0, 0.0], [5.0, 0.0], [9.0, 1.0], [3.0, 3.0], [0.0, 3.0]], "does not lie on the base at (9, 1) m"),
            (&[[0.0, 0.0], [9.0, 0.0], [9.0, 3.0], [0.0, 3.0]], "falls nowhere"),
        ] {
            let why = why(outline, walls);
            assert!(why.contains(expected), "{why}");
        }
        // A wall that is not there: the mesh goes on.
        let free = why(&[[0.0, 0.0], [9.0, 0.0], [9.0, 3.0], [3.0, 3.0]], |_| ());
        assert!(free.contains("no vertical face, as at x = 9 m"), "{free}");
        let elastic = why(&HALF, |scene| scene.strength = None);
        assert!(elastic.contains("no strength"), "{elastic}");
    }
}
