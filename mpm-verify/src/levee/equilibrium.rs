//! Limit equilibrium of a scene's slopes with the water of a run.
//!
//! Both ways that its ground falls are looked at, the left one mirrored; the lower factor counts. What the method of
//! slices does not know is said in words in place of a number.

use mpm_core::failure::{Row, Scales, towards};
use mpm_core::scene::{NormalStress, Scene, SolidSide};

use crate::error::Error::{self, Unfit};
use crate::exact::infinite_slope::Strength;
use crate::exact::slip_circle::FirmBase;
use crate::exact::slip_circle::factor::Method;
use crate::exact::slip_circle::levee::Levee;
use crate::exact::slip_circle::water::Equipotentials;

/// Lengths below this share of the height are none.
const ROUND_OFF: f64 = 1e-9;
/// A face whose run is a smaller share of its height is vertical: 85 degrees.
const VERTICAL: f64 = 0.087;

/// Factors of safety with one strength of the soil.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Factors {
    /// Of the infinite slope at the toe, from when water is there.
    pub infinite_slope: Option<f64>,
    /// Of the critical slide by Bishop's method.
    pub bishop: Option<f64>,
    /// By Spencer's method.
    pub spencer: Option<f64>,
}

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

/// The scene's slope towards +x, or what falls towards -x in a mirror; `None` if nothing falls that way.
///
/// # Errors
/// Why the method of slices does not know the scene.
pub fn slope(scene: &Scene, way: f64) -> Result<Option<Levee>, Error> {
    let (Some(strength), Some(gravity)) = (scene.strength, scene.gravity) else {
        return Err(Unfit("the soil has no strength to divide"));
    };
    if !scene.layers.is_empty() || scene.surcharge.is_some() {
        return Err(Unfit("the slices know one soil without a load on it"));
    }
    let height = scene.height;
    let outline = scene.outline_or_box();
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
    let [x, y] = ground[ground.len() - 1];
    let beyond = if way > 0.0 { 1 } else { 0 };
    // Soil ends at the side of its mesh on the left always, on the right where there is no room beside it.
    let at_side =
        if way > 0.0 { scene.empty_cells_beside == 0 } else { outline.iter().any(|x| x[0] <= ROUND_OFF * height) };
    let wall = at_side && scene.solid_sides[beyond] != SolidSide::Free;
    if !wall {
        if y > ROUND_OFF * height {
            return vertical(x);
        }
        let top = ground.iter().map(|x| x[1]).fold(0.0, f64::max);
        let crest = ground.iter().rfind(|x| x[1] >= top * (1.0 - ROUND_OFF)).map_or(x, |x| x[0]);
        ground.push([x + (x - crest).max(height), 0.0]);
    }
    let unit = |cohesion: f64, friction: f64| Strength { cohesion, friction };
    let own = unit(strength.cohesion, strength.friction_angle.to_radians());
    let (contact, normal_stress) = match (scene.base, scene.solid_sides[2]) {
        (Some(base), _) => (unit(base.adhesion, base.peak_angle.to_radians()), base.normal_stress),
        // Soil that is held slides right above, by its own strength; on rollers nothing holds it.
        (None, SolidSide::Fixed) => (own, NormalStress::Effective),
        (None, SolidSide::Roller) => (unit(0.0, 0.0), NormalStress::Effective),
        (None, SolidSide::Free) => return Err(Unfit("the soil has no base")),
    };
    let [moist, water_weight] = scene.water.map_or([0.0; 2], |water| {
        let saturation = scene.free_surface.as_ref().map_or(0.0, |free| free.saturation);
        [saturation * scene.porosity * water.density, water.density * gravity]
    });
    let levee = Levee {
        ground,
        end: x,
        strength: own,
        dilation: strength.dilation_angle.to_radians(),
        dry_weight: (scene.dry_density() + moist) * gravity,
        saturated_weight: scene.mixture_density() * gravity,
        water_weight,
        base: FirmBase { height: 0.0, strength: contact, normal_stress },
    };
    Ok(levee.lowest_face().is_some().then_some(levee))
}

/// Factors with the strength of the soil and with Davis' reduced one, below the water surface of a run (x, y in m, x increasing).
///
/// # Errors
/// Why there are none.
pub fn factors(scene: &Scene, row: &Row, line: &[[f64; 2]]) -> Result<[Factors; 2], Error> {
    let scales = Scales::of(scene);
    let (depth, side) = (scales.depth(), towards(&scene.outline_or_box()));
    let toe = if side > 0.0 {
        scene.width
    } else {
        scene.outline_or_box().iter().map(|x| x[0]).fold(f64::INFINITY, f64::min)
    };
    // Water that leaves the slope does so from the toe up.
    let at_toe = side * row.front_x_m >= side * toe - scales.at_toe() || row.water_out_m3 > scales.drops();
    let mut least: Option<[Factors; 2]> = None;
    for way in WAYS {
        let Some(levee) = slope(scene, way)? else { continue };
        let line = seen(line, way, scene.width);
        let of = |strength: Strength| {
            let critical = |method| {
                let limits = levee.limits(depth, method);
                levee.critical(strength, &line, Equipotentials::Vertical, &limits).map(|c| c.factor)
            };
            let toe = levee.toe(strength).filter(|_| at_toe && way == side);
            Factors {
                infinite_slope: toe.and_then(|toe| toe.factor(depth)),
                bishop: critical(Method::Bishop),
                spencer: critical(Method::Spencer),
            }
        };
        let found = [of(levee.strength), of(levee.strength.reduced(levee.dilation))];
        least = Some(least.map_or(found, |least| [0, 1].map(|k| lower(least[k], found[k]))));
    }
    let found = least.ok_or(Unfit("the surface falls nowhere: there is no slope"))?;
    if found.iter().any(|f| f.bishop.is_none() && f.spencer.is_none()) {
        return Err(Error::Found(format!("no slip circle at least {depth} m deep has a factor of safety")));
    }
    Ok(found)
}

fn lower(a: Factors, b: Factors) -> Factors {
    let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
    Factors {
        infinite_slope: least(a.infinite_slope, b.infinite_slope),
        bishop: least(a.bishop, b.bishop),
        spencer: least(a.spencer, b.spencer),
    }
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::{Fields, Flags};

    use super::super::plan::scene;
    use super::*;

    const LINE: [[f64; 2]; 6] = [[0.0, 2.3], [2.0, 1.94], [4.0, 1.52], [6.0, 1.05], [7.0, 0.79], [8.0, 0.48]];

    fn levee() -> Scene {
        scene("levee", &Flags::default(), super::super::variants::named("saturation-0")).expect("a scene")
    }

    #[test]
    fn the_scene_s_levee_is_the_paper_s() {
        let found = slope(&levee(), 1.0).expect("a slope").expect("a levee");
        let strength = Strength { cohesion: 0.0, friction: 30.0_f64.to_radians() };
        let base = FirmBase { height: 0.0, strength, normal_stress: NormalStress::Effective };
        let paper = Levee::paper(base);
        assert_eq!((&found.ground, found.end, found.base), (&paper.ground, paper.end, paper.base));
        for (a, b) in [
            (found.dry_weight, paper.dry_weight),
            (found.saturated_weight, paper.saturated_weight),
            (found.water_weight, paper.water_weight),
        ] {
            assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
        }
        assert_eq!(slope(&levee(), -1.0).ok(), Some(None), "nothing falls towards the wall");
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
        slope(scene, way).expect("a slope").expect("a fall").ground
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
        assert_eq!((ground(&mirrored, -1.0), slope(&mirrored, 1.0).ok()), (usual.to_vec(), Some(None)));
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
        let of = |scene: &Scene, line: &[[f64; 2]]| {
            let row = Row { front_x_m: if scene.empty_cells_beside > 0 { 0.0 } else { 1e3 }, ..Row::default() };
            factors(scene, &row, line).expect("factors")[0]
        };
        let usual = of(&shaped(&HALF, |_| ()), &LINE);
        assert!((usual.spencer.expect("a factor") - 0.9619).abs() < 2e-3, "{usual:?}");
        assert_eq!(of(&shaped(&mirror(&HALF), walled), &mirror(&LINE)), usual);
    }

    #[test]
    fn a_base_that_is_fixed_holds_by_the_strength_of_the_soil() {
        let contact = |side: SolidSide| {
            let scene = shaped(&HALF, |scene| (scene.base, scene.solid_sides[2]) = (None, side));
            slope(&scene, 1.0).map(|slope| slope.expect("a fall").base.strength)
        };
        let own = Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() };
        assert_eq!(contact(SolidSide::Fixed).ok(), Some(own));
        assert_eq!(contact(SolidSide::Roller).ok(), Some(Strength { cohesion: 0.0, friction: 0.0 }));
        assert!(contact(SolidSide::Free).is_err_and(|why| why.to_string().contains("no base")));
    }

    #[test]
    fn what_the_slices_do_not_know_is_said() {
        let why = |outline: &[[f64; 2]], edit: fn(&mut Fields)| {
            factors(&shaped(outline, edit), &Row::default(), &[]).expect_err("refused").to_string()
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
