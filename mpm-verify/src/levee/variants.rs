//! The scene with one input changed: what is assumed where the paper is silent, and how much it matters.

use mpm_core::scene::{Base, Bearing, Course, FaceLoad, Feed, Fields, FreeSurfaceWater, NormalStress, Side};
use mpm_core::water::retention::Retention;

/// How an input is changed.
#[derive(Debug, Clone, Copy)]
pub enum Change {
    /// Another cell, m.
    Mesh(f64),
    /// Other particles per cell.
    Particles(i64),
    /// Something else of the scene.
    Edit(fn(&mut Fields)),
}

/// A scene with one input changed.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Its name, for `--variant`.
    pub name: &'static str,
    /// What is changed.
    pub what: &'static str,
    /// The changed value with its unit.
    pub label: &'static str,
    /// How.
    pub change: Change,
    /// Whether it takes long and is left out unless asked for.
    pub long: bool,
}

const fn variant(name: &'static str, what: &'static str, label: &'static str, change: Change) -> Variant {
    Variant { name, what, label, change, long: false }
}

const PROFILE: &str = "water at 6 h";
const FEED: &str = "feed";
const BASE: &str = "base friction, constant";
const SLIP: &str = "slip distance of the base";
const NORMAL: &str = "stress on the base";
const K: &str = "conductivity";
const MOISTURE: &str = "saturation at the start";
const DILATION: &str = "constant angle of dilation";
const FADES: &str = "strain over which dilation fades";
const SUCTION: &str = "water above the front";
const TANK_LEVEL: &str = "water in the tank";
const MESH: &str = "edge of a cell";
const PPC: &str = "particles per cell";

/// All of them. Two and two with the same `what` are the bars of one input, the smaller value first.
pub const VARIANTS: [Variant; 34] = [
    variant("profile-line", PROFILE, "line", Change::Edit(|s| wet(s, &line()))),
    variant("profile-parabola", PROFILE, "parabola", Change::Edit(|s| wet(s, &parabola()))),
    variant("feed-6e-6", FEED, "6e-6 m/s", Change::Edit(|s| velocity(s, 6.0e-6))),
    variant("feed-2e-5", FEED, "2e-5 m/s", Change::Edit(|s| velocity(s, 2.0e-5))),
    variant("feed-head", FEED, "2.3 m head", Change::Edit(head)),
    variant("base-8.5", BASE, "8.5°", Change::Edit(|s| constant(s, 8.5))),
    variant("base-12", BASE, "12°", Change::Edit(|s| constant(s, 12.0))),
    variant("base-14", BASE, "14°", Change::Edit(|s| constant(s, 14.0))),
    variant("base-30", BASE, "30°", Change::Edit(|s| constant(s, 30.0))),
    variant("slip-0.01", SLIP, "0.01 m", Change::Edit(|s| weakens(s, 0.01))),
    variant("slip-0.05", SLIP, "0.05 m", Change::Edit(|s| weakens(s, 0.05))),
    variant("slip-0.1", SLIP, "0.1 m", Change::Edit(|s| weakens(s, 0.1))),
    variant("normal-effective", NORMAL, "effective", Change::Edit(|s| pressed(s, NormalStress::Effective))),
    variant("normal-total", NORMAL, "total", Change::Edit(|s| pressed(s, NormalStress::Total))),
    variant("k-3.0e-5", K, "3e-5 m/s", Change::Edit(|s| conducts(s, 3.0e-5))),
    variant("k-1.5e-4", K, "1.5e-4 m/s", Change::Edit(|s| conducts(s, 1.5e-4))),
    variant("saturation-0", MOISTURE, "0", Change::Edit(|s| moist(s, 0.0))),
    variant("saturation-0.15", MOISTURE, "0.15", Change::Edit(|s| moist(s, 0.15))),
    variant("saturation-0.3", MOISTURE, "0.3", Change::Edit(|s| moist(s, 0.3))),
    variant("saturation-0.5", MOISTURE, "0.5", Change::Edit(|s| moist(s, 0.5))),
    variant("saturation-0.7", MOISTURE, "0.7", Change::Edit(|s| moist(s, 0.7))),
    variant("dilation-0", DILATION, "0°", Change::Edit(|s| dilates(s, 0.0))),
    variant("dilation-15", DILATION, "15°", Change::Edit(|s| dilates(s, 15.0))),
    variant("dilation-30", DILATION, "30°", Change::Edit(|s| dilates(s, 30.0))),
    variant("fades-0.025", FADES, "0.025", Change::Edit(|s| fades(s, 0.025))),
    variant("fades-0.1", FADES, "0.1", Change::Edit(|s| fades(s, 0.1))),
    variant("suction", SUCTION, "with suction", Change::Edit(|s| holds(s, 0.5))),
    variant("rain", SUCTION, "with rain, 20 mm/h", Change::Edit(rains)),
    variant("drawdown", TANK_LEVEL, "falls from 8 to 9 h", Change::Edit(drawn_down)),
    Variant { long: true, ..variant("mesh-0.1", MESH, "0.1 m", Change::Mesh(0.1)) },
    variant("mesh-0.2", MESH, "0.2 m", Change::Mesh(0.2)),
    variant("mesh-0.4", MESH, "0.4 m", Change::Mesh(0.4)),
    variant("ppc-4", PPC, "4", Change::Particles(4)),
    variant("ppc-9", PPC, "9", Change::Particles(9)),
];

fn dilates(scene: &mut Fields, angle: f64) {
    if let Some(strength) = &mut scene.strength {
        (strength.dilation_angle, strength.dilation_fades_over) = (angle, None);
    }
}

fn fades(scene: &mut Fields, over: f64) {
    if let Some(strength) = &mut scene.strength {
        strength.dilation_fades_over = Some(over);
    }
}

/// Whether a variant changes what it is computed on, not what is assumed.
pub fn is_of_mesh(what: &str) -> bool {
    what == MESH || what == PPC
}

/// A variant by name.
pub fn named(name: &str) -> Option<&'static Variant> {
    VARIANTS.iter().find(|v| v.name == name)
}

/// Head of the tank, m, and how far the line of water reaches, m: 9.6 m2 of soil are below it.
const TANK: f64 = 2.3;
const REACH: f64 = 8.35;
/// How far a parabola reaches below which there is as much, m.
const PARABOLA: f64 = 6.26;

fn line() -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [REACH, 0.0], [0.0, TANK]]
}

/// Level falling as 1 - (x/6.26)^2, by corners on the curve.
fn parabola() -> Vec<[f64; 2]> {
    const PARTS: i32 = 24;
    let level = |x: f64| TANK * (1.0 - (x / PARABOLA).powi(2));
    let curve = (1..PARTS).rev().map(|k| PARABOLA * f64::from(k) / f64::from(PARTS)).map(|x| [x, level(x)]);
    [[0.0, 0.0], [PARABOLA, 0.0]].into_iter().chain(curve).chain([[0.0, TANK]]).collect()
}

fn water(scene: &mut Fields, edit: impl FnOnce(&mut FreeSurfaceWater)) {
    if let Some(water) = &mut scene.free_surface {
        edit(water);
    }
}

fn wet(scene: &mut Fields, corners: &[[f64; 2]]) {
    water(scene, |w| w.wet = Some(corners.to_vec()));
}

fn velocity(scene: &mut Fields, speed: f64) {
    water(scene, |w| w.feeds[0] = Some(Feed::Velocity { speed, height: TANK }));
}

fn head(scene: &mut Fields) {
    water(scene, |w| w.feeds[0] = Some(Feed::Head(TANK)));
}

fn moist(scene: &mut Fields, saturation: f64) {
    water(scene, |w| w.saturation = saturation);
}

/// Soil that holds a share of its pores by suction above the front, as a silty sand does (Carsel & Parrish 1988,
/// doi:10.1029/WR024i005p00755, loamy sand): a tenth of them stays whatever the suction.
fn holds(scene: &mut Fields, saturation: f64) {
    /// alpha (1/m), n, residual saturation.
    const LOAMY_SAND: (f64, f64, f64) = (12.4, 2.28, 0.14);
    let (alpha, n, residual) = LOAMY_SAND;
    let law = Retention::VanGenuchten { alpha, n, entry: 0.0 };
    water(scene, |w| {
        w.saturation = residual;
        w.retention = Some(law);
        // A head: water of unit weight 1.
        w.suction = Some(-law.pressure((saturation - residual) / (1.0 - residual), 1.0));
    });
}

fn rains(scene: &mut Fields) {
    holds(scene, 0.5);
    let (speed, height) = (0.020 / 3600.0, scene.height);
    water(scene, |w| w.feeds[3] = Some(Feed::Velocity { speed, height }));
}

/// The tank is emptied within an hour: its wall lets out what stands higher in the levee.
fn drawn_down(scene: &mut Fields) {
    let first = scene.failure.as_ref().map_or(0.0, |failure| failure.starts_at);
    let hours = |h: f64| h * 3600.0 - first;
    let levels = vec![[0.0, TANK], [hours(8.0), TANK], [hours(9.0), 0.0]];
    let (on, bearing, course) = (Some(Side::Left), Bearing::Reservoir, Course::Times(levels));
    water(scene, |w| w.feeds[0] = None);
    scene.stages.iter_mut().for_each(|stage| stage.drained[Side::Left as usize] = true);
    scene.loads.push(FaceLoad { on, x: None, y: None, bearing, course });
}

fn base(scene: &mut Fields, edit: impl FnOnce(&mut Base)) {
    if let Some(base) = &mut scene.base {
        edit(base);
    }
}

fn constant(scene: &mut Fields, angle: f64) {
    base(scene, |b| (b.peak_angle, b.residual_angle, b.slip_distance) = (angle, angle, None));
}

fn weakens(scene: &mut Fields, distance: f64) {
    base(scene, |b| b.slip_distance = Some(distance));
}

fn pressed(scene: &mut Fields, stress: NormalStress) {
    base(scene, |b| b.normal_stress = stress);
}

fn conducts(scene: &mut Fields, conductivity: f64) {
    if let Some(water) = &mut scene.water {
        water.hydraulic_conductivity = conductivity;
    }
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::Flags;
    use mpm_core::seeding;

    use super::super::plan::scene;
    use super::*;

    #[test]
    fn every_variant_has_its_own_name_and_changes_its_input_alone() {
        let base = scene("levee", &Flags::default(), None).expect("the levee");
        let unchanged = ["profile-line", "feed-head", "normal-effective", "saturation-0.5", "mesh-0.2", "ppc-4"];
        for (place, variant) in VARIANTS.iter().enumerate() {
            assert!(named(variant.name).is_some() && VARIANTS[..place].iter().all(|v| v.name != variant.name));
            let changed = scene("levee", &Flags::default(), Some(variant)).expect(variant.name);
            assert_eq!(changed == base, unchanged.contains(&variant.name), "{}", variant.name);
        }
    }

    #[test]
    fn both_profiles_hold_the_same_water() {
        for corners in [line(), parabola()] {
            assert!((seeding::area(&corners) - 9.6).abs() < 0.03, "{}", seeding::area(&corners));
        }
        assert!(parabola().iter().all(|x| x[1] <= (4.5 - 0.5 * x[0]).min(3.0)));
    }
}
