//! Guards the table of what goes together: every pair that it allows has a scene that runs, every pair that it forbids is
//! refused with the table's words.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use mpm_core::failure::Driver;
use mpm_core::scene::Scene;
use mpm_core::scene::capabilities::{FEATURES, Feature, RULES, Rule, conflict};

/// Features, one bit each.
type Set = u128;

const fn bit(feature: Feature) -> Set {
    1 << feature as u32
}

/// Features of which a scene has one at most; the first is that of a scene that says nothing. An empty place is one that has no
/// name because everything goes with it.
const GROUPS: [&[Option<Feature>]; 13] = {
    use Feature::*;
    [
        &[None, Some(Column), Some(Axisymmetric)],
        &[Some(Explicit), Some(SemiImplicit), Some(QuasiStatic), Some(Implicit), Some(Staggered), Some(Coupled)],
        &[None, Some(Centroid), Some(Linear), Some(BBar), Some(Gimp), Some(Bspline2), Some(Bspline3)],
        &[Some(Dry), Some(Saturated), Some(FreeSurface)],
        &[Some(LinearElastic), Some(MohrCoulomb), Some(CamClay)],
        &[Some(LargeStrain), Some(SmallStrain)],
        &[Some(NoGravity), Some(Gravity)],
        &[Some(Unloaded), Some(Geostatic), Some(UndrainedStart), Some(GivenStart)],
        &[None, Some(Fails)],
        &[None, Some(Load)],
        &[None, Some(RestEnd), Some(PressureEnd)],
        &[None, Some(GivenStep), Some(PaperStep)],
        &[None, Some(Periodic), Some(FixedSide)],
    ]
};

/// What a scene has as well when it has a feature.
const IMPLIED: [(Feature, Feature); 11] = {
    use Feature::*;
    [
        (Plate, Load),
        (GivenStart, Initial),
        (Strip, Load),
        (PressureEnd, Load),
        (Nodal, DarcyOperator),
        (InertiaKept, DarcyInertia),
        (Krylov, TimeMethod),
        (Separation, MohrCoulomb),
        (Coupled, Fails),
        (Fails, FreeSurface),
        (Incompressible, Drained),
    ]
};

/// Water below a level, with a sharp front above it, or held there by suction.
const SHARP: &str = "free_surface = { level = 0.5 }";
const HELD: &str = "free_surface = { level = 0.5, retention.gardner.alpha = 2.0 }";

/// A scene file with these features and no others.
fn written(has: Set) -> String {
    use Feature::*;
    let is = |feature: Feature| has & bit(feature) != 0;
    let word = |group: usize, usual: &'static str| {
        let named = GROUPS[group].iter().flatten().find(|feature| is(**feature));
        named.map_or(usual, |feature| feature.word())
    };
    let mut text = String::from("name = \"pair\"\n");
    let mut line = |on: bool, what: &str| {
        if on {
            text.push_str(what);
            text.push('\n');
        }
    };
    line(!is(Column) && !is(Axisymmetric), "dimension = \"plane-strain\"");
    line(is(Axisymmetric), "dimension = \"axisymmetric\"");
    line(true, &format!("start = {}", word(7, "")));
    line(!is(NoGravity), "gravity = 9.81");
    line(is(SlopeAngle), "slope_angle = 5.0");
    line(is(Seismic), "seismic_coefficient = 0.1");
    line(is(StartK0), "start_k0 = 0.6");
    line(is(StartVelocity), "start_velocity = [0.0, 1e-4]");
    line(is(Outline), "geometry.outline = { points = [[0, 0], [2, 0], [2, 0.5], [1, 1], [0, 1]] }");
    line(!is(Outline), "geometry.column = { height = 1.0, width = 1.0 }");
    line(is(Initial), "initial.stress_yy = [[0.0, -1e3], [1.0, -1e2]]");
    line(true, "[mesh]\ncell = 0.25\nparticles_per_cell = 4");
    line(is(Shift), "shift = 0.3");
    line(is(Displaced), "displaced = { jitter = 0.1 }");
    line(is(EmptyBeside), "empty_cells_beside = 2");
    line(true, "[soil]\ngrain_density = 2650\nporosity = 0.4");
    line(is(SmallStrain), "strain = \"small\"");
    line(is(Separation), "separation = 0.01");
    let elastic = "youngs_modulus = 1e7, poisson_ratio = 0.3";
    line(is(LinearElastic), &format!("law.linear_elastic = {{ {elastic} }}"));
    line(is(MohrCoulomb), &format!("law.mohr_coulomb = {{ {elastic}, cohesion = 1e5, friction_angle = 30 }}"));
    line(
        is(CamClay),
        "law.modified_cam_clay = { lambda = 0.1, kappa = 0.02, bulk_modulus = 1e7, poisson_ratio = 0.3, critical_slope = 1.0, attraction = 1e5 }",
    );
    line(
        is(Layers),
        "[[layers]]\nup_to = 0.5\n[[layers]]\nup_to = 1.0\nlaw.linear_elastic = { youngs_modulus = 2e7, poisson_ratio = 0.3 }",
    );
    // Where there is no water a soil may still ask for it.
    line(is(Dry) && is(KozenyCarman), "[[regions]]\nlevels = [0.5, 0.75]\nkozeny_carman = true");
    line(is(Dry) && is(Bedding), "[[regions]]\nlevels = [0.5, 0.75]\nbedding_angle = 30.0");
    line(is(Regions), "[[regions]]\nlevels = [0.25, 0.5]\nporosity = 0.3");
    let stiffness = if is(Incompressible) { "inf" } else { "2e8" };
    line(!is(Dry), &format!("[water]\nhydraulic_conductivity = 1e-3\nbulk_modulus = {stiffness}\nunit_weight = 9810"));
    line(!is(Dry) && is(KozenyCarman), "kozeny_carman = true");
    line(!is(Dry) && is(Bedding), "bedding_angle = 30.0");
    line(is(FreeSurface), SHARP);
    line(true, "[boundaries]");
    line(is(Periodic), "left = \"periodic\"\nright = \"periodic\"");
    line(is(FixedSide), "right = \"fixed\"");
    line(is(HeldTop), "top = \"roller\"");
    // What a constrained top cannot bear a free side can.
    let face = if is(HeldTop) { "right" } else { "top" };
    line(is(HeldTop) && (is(Loads) || is(MovedPlates)), "right = \"free\"");
    line(is(CoulombBase), "bottom = \"coulomb\"\n[base]\nfriction_angle = 40");
    line(is(Load), "[surcharge]\npressure = 1e3");
    line(is(Plate), "on = \"plate\"");
    line(is(Strip), "strip = { from = 0.0, to = 0.5 }");
    line(is(Loads), &format!("[[loads]]\non = \"{face}\"\npressure = 1e3"));
    line(is(MovedPlates), &format!("[[plates]]\non = \"{face}\"\nvelocity = 1e-6"));
    line(is(Wells), "[[wells]]\nat = [0.5, 0.5]\nrate = 1e-6");
    line(true, "[scheme]");
    line(true, &format!("shape = {}", word(2, "\"centre\"")));
    line(is(Nodal), "darcy = \"nodal\"");
    line(is(DarcyOperator) && !is(Nodal), "darcy = \"face\"");
    line(
        is(DarcyInertia),
        if is(InertiaKept) || is(RelativeAcceleration) { "darcy_inertia = true" } else { "darcy_inertia = false" },
    );
    line(is(RelativeAcceleration), "relative_acceleration = true");
    line(is(Flip), "flip = 1.0");
    line(is(Affine), "transfer = \"affine\"");
    line(is(NullSpace), "null_space_strain = 0.01");
    line(is(Contiguous), "particle_domain = \"contiguous\"");
    line(is(Musl), "update = \"musl\"");
    line(is(LightNodes), "light_nodes = 0.1");
    line(is(JumpPenalty), "jump_penalty = 1e-3");
    line(true, &format!("[time]\nintegrator = {}", word(1, "")));
    line(is(Krylov), "method = \"krylov\"");
    line(is(TimeMethod) && !is(Krylov), "method = \"sdirk\"");
    line(is(Waves), "waves = \"resolved\"");
    line(is(Tolerance), "tolerance = 1e-3");
    line(is(Safety), "safety = 0.5");
    line(is(GivenStep), "step = 1e-5");
    line(is(PaperStep), "step = \"paper\"");
    line(true, "[[stages]]");
    line(is(Drained), "drained = [\"top\"]");
    line(!is(Dry) && !is(Drained), "drained = \"none\"");
    line(is(StageSides), "boundaries.left = \"roller\"");
    line(is(Damping), "damping = 1.0");
    line(is(Fails), "coupling = \"full\"");
    let seeps = is(FreeSurface) && !is(Fails);
    line(seeps && (is(RestEnd) || is(PressureEnd)), "coupling = \"soil\"");
    line(is(RestEnd), "until.rest = { speed = 1e3, at_most = 10.0 }");
    line(is(PressureEnd), "until = { pore_pressure_within = 0.9, at_most = 1.0 }");
    line(!is(RestEnd) && !is(PressureEnd), "until.time = 1e-4");
    text
}

/// Two features of which a scene is made, whatever else it has.
#[derive(Clone, Copy)]
struct Pair(Feature, Feature);

impl Pair {
    /// What a feature does not go with, but for the two themselves.
    fn apart(self, feature: Feature) -> Set {
        static APART: OnceLock<Vec<Set>> = OnceLock::new();
        // Water that is not there has no stiffness.
        let stiff = |a, b| [(a, b), (b, a)].contains(&(Feature::Incompressible, Feature::Dry));
        let of = |a| FEATURES.iter().filter(|b| stiff(a, b.0) || conflict(a, b.0).is_some()).map(|b| bit(b.0)).sum();
        let apart = APART.get_or_init(|| FEATURES.iter().map(|a| of(a.0)).collect())[feature as usize];
        let partner = match feature {
            _ if feature == self.0 => bit(self.1),
            _ if feature == self.1 => bit(self.0),
            _ => 0,
        };
        apart & !partner
    }

    /// The two, and what each of them implies.
    fn first(self) -> Set {
        IMPLIED.iter().fold(bit(self.0) | bit(self.1), |set, (feature, implied)| {
            let group = GROUPS.iter().find(|group| group.contains(&Some(*implied)));
            let is_chosen = group.is_some_and(|group| set & members(group) != 0);
            if set & bit(*feature) != 0 && !is_chosen { set | bit(*implied) } else { set }
        })
    }

    /// Shows `visit` sets with the two and whatever else makes a scene of them, the most usual first, in which no other pair is
    /// forbidden, until it finds something.
    fn find<T>(self, mut visit: impl FnMut(Set) -> Option<T>) -> Option<T> {
        self.search(self.first(), &GROUPS, &mut visit)
    }

    fn search<T>(self, set: Set, groups: &[&[Option<Feature>]], visit: &mut dyn FnMut(Set) -> Option<T>) -> Option<T> {
        let Some((group, rest)) = groups.split_first() else {
            return if self.is_sound(set) { visit(set) } else { None };
        };
        match (set & members(group)).count_ones() {
            0 => group.iter().find_map(|choice| match choice {
                Some(new) if self.apart(*new) & set != 0 => None,
                Some(new) => self.search(set | bit(*new), rest, visit),
                None => self.search(set, rest, visit),
            }),
            1 => self.search(set, rest, visit),
            _ => None,
        }
    }

    fn is_sound(self, set: Set) -> bool {
        let plain = set & (bit(Feature::Bspline2) | bit(Feature::Bspline3)) == 0;
        let any_shape = [self.0, self.1].contains(&Feature::AnyShape);
        let sound = FEATURES.iter().all(|(x, ..)| set & bit(*x) == 0 || self.apart(*x) & set == 0);
        sound && if plain { self.apart(Feature::AnyShape) & set == 0 } else { !any_shape }
    }
}

fn members(group: &[Option<Feature>]) -> Set {
    group.iter().flatten().fold(0, |set, feature| set | bit(*feature))
}

/// Two features, and of every group that neither is of the most usual.
fn usual(a: Feature, b: Feature) -> Set {
    let add = |set, group: &&[Option<Feature>]| match group[0] {
        Some(first) if set & members(group) == 0 => set | bit(first),
        _ => set,
    };
    GROUPS.iter().fold(bit(a) | bit(b), add)
}

/// Pairs of features that are not of one group.
fn pairs() -> impl Iterator<Item = (Feature, Feature)> {
    let one_group =
        |a: Feature, b: Feature| GROUPS.iter().any(|group| group.contains(&Some(a)) && group.contains(&Some(b)));
    let name = |i: usize| FEATURES[i].0;
    (0..FEATURES.len())
        .flat_map(move |i| (i + 1..FEATURES.len()).map(move |j| (name(i), name(j))))
        .filter(move |(a, b)| !one_group(*a, *b))
}

/// Runs a scene to its end; what went wrong.
fn trouble(scene: &Scene) -> Option<String> {
    if scene.may_fail() {
        let advanced = Driver::new(scene).map_err(|e| e.to_string());
        return advanced.and_then(|mut run| run.advance(1e-4).map_err(|e| e.to_string())).err();
    }
    match mpm_core::run::run(scene, &mut |_| {}) {
        Ok(run) => run.failure.map(|failure| failure.to_string()),
        Err(e) => Some(e.to_string()),
    }
}

#[test]
fn every_pair_that_the_table_allows_runs() {
    let (mut wrong, mut ran) = (Vec::new(), 0);
    for (a, b) in pairs().filter(|(a, b)| conflict(*a, *b).is_none()) {
        // Some pairs are forbidden by what each of them needs: one is explicit, the other quasi-static.
        let mut last = None;
        Pair(a, b).find(|set| {
            let text = last.insert(written(set));
            Scene::parse(text, "pair.toml").ok()
        });
        let Some(text) = last else { continue };
        // What goes with a sharp front goes with unsaturated soil.
        for text in [Some(text.replace(SHARP, HELD)).filter(|held| *held != text), Some(text)].into_iter().flatten() {
            let trouble = match Scene::parse(&text, "pair.toml") {
                Ok(scene) if is_run(a, b) => trouble(&scene),
                Ok(_) => None,
                Err(e) => Some(e.to_string()),
            };
            ran += usize::from(is_run(a, b));
            wrong.extend(trouble.map(|trouble| format!("{a:?} {b:?}: {trouble}\n{text}")));
        }
    }
    assert!(wrong.is_empty(), "{} pairs:\n{}", wrong.len(), wrong.join("\n"));
    assert!(ran > 500, "{ran} pairs ran");
}

/// Whether the scene of a pair is run, not only read: every feature with half of the others.
fn is_run(a: Feature, b: Feature) -> bool {
    (a as usize + b as usize).is_multiple_of(2)
}

#[test]
fn every_pair_that_the_table_forbids_is_refused_in_its_words() {
    let mut wrong = Vec::new();
    let is_reason = |expected: &str| RULES.iter().any(|rule| rule.expected == expected);
    for rule in RULES {
        for other in rule.beside {
            // Where each of the two forbids what the other needs, the scene is refused for that.
            let alone = Pair(rule.of, *other).find(Some);
            let own = alone.is_some();
            let set = alone.unwrap_or_else(|| usual(rule.of, *other));
            match Scene::parse(&written(set), "pair.toml") {
                Err(e) if e.expected == rule.expected || (!own && is_reason(&e.expected)) => {}
                Err(e) => wrong.push(format!("{:?} {other:?}: {e}", rule.of)),
                Ok(_) => wrong.push(format!("{:?} {other:?} is accepted:\n{}", rule.of, written(set))),
            }
        }
    }
    assert!(wrong.is_empty(), "{} pairs:\n{}", wrong.len(), wrong.join("\n"));
}

/// What goes with every feature that leaves a free top (and, of water, holds some): lines that are put behind a key or at the end.
const WITH_ALL: [(&str, &str, &str); 9] = [
    ("load in time", "", "[[loads]]\non = \"top\"\npressure = 1e3\ntimes = [[0.0, 0.0], [1e-4, 1.0]]\n"),
    ("wave", "", "[[loads]]\non = \"top\"\npressure = 1e3\nwater = true\nwave = { length = 2.0, period = 1.0 }\n"),
    ("reservoir", "", "[[reservoirs]]\non = \"right\"\nlevel = 0.8\n"),
    ("plate", "", "[[plates]]\non = \"top\"\nvelocity = 1e-6\n"),
    ("well", "", "[[wells]]\nat = [0.5, 0.25]\nrate = 1e-6\ntimes = [[0.0, 0.0], [1e-4, -1.0]]\n"),
    ("Biot", "porosity = 0.4\n", "biot_coefficient = 0.8\n"),
    ("grains", "porosity = 0.4\n", "grain_bulk_modulus = 1e9\n"),
    ("excess", "start = \"geostatic\"\n", "initial.pressure = 1e3\n"),
    ("anisotropy", "hydraulic_conductivity = 1e-3\n", "anisotropy = 4.0\n"),
];

#[test]
fn loads_water_outside_and_grains_go_with_all_that_leaves_them_a_place() {
    let (mut refused, mut wrong, mut ran) = (BTreeSet::new(), Vec::new(), 0);
    for (name, behind, lines) in WITH_ALL {
        for &(feature, ..) in FEATURES {
            let with = |text: String| match text.find(behind) {
                Some(at) if !behind.is_empty() => {
                    let (before, after) = text.split_at(at + behind.len());
                    Some(format!("{before}{lines}{after}"))
                }
                Some(_) => Some(format!("{text}{lines}")),
                None => None,
            };
            let mut has_place = false;
            let scene = Pair(feature, feature).find(|set| {
                let text = with(written(set))?;
                has_place = true;
                Scene::parse(&text, "extra.toml").ok()
            });
            match scene {
                Some(scene) => {
                    ran += 1;
                    wrong.extend(trouble(&scene).map(|trouble| format!("{name} {feature:?}: {trouble}")));
                }
                None if has_place => drop(refused.insert(format!("{name} {feature:?}"))),
                None => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{} pairs:\n{}", wrong.len(), wrong.join("\n"));
    assert!(ran > 400, "{ran} pairs ran");
    // What has a level needs no excess, a plate no support, a constrained top bears none, wells are in pores that are full and stay so, a dry scene has no water, a level needs weight, a column ends in its top and base.
    let reasons = [
        "excess Coupled",
        "excess Dry",
        "excess Fails",
        "excess FreeSurface",
        "excess Seismic",
        "excess Staggered",
        "load in time HeldTop",
        "load in time Krylov",
        "load in time PressureEnd",
        "plate HeldTop",
        "plate Krylov",
        "plate PressureEnd",
        "plate StageSides",
        "reservoir Column",
        "reservoir Dry",
        "reservoir Krylov",
        "reservoir NoGravity",
        "reservoir PressureEnd",
        "reservoir SlopeAngle",
        "wave Dry",
        "wave Krylov",
        "wave PressureEnd",
        "well Coupled",
        "well Dry",
        "well Fails",
        "well FreeSurface",
        "well Krylov",
        "well Nodal",
        "well PressureEnd",
        "well EmptyBeside",
        "well Seismic",
        "well Staggered",
    ];
    assert_eq!(refused, reasons.map(String::from).into());
}

#[test]
fn a_feature_is_found_in_a_scene_that_has_it() {
    // Each is part of a rule, so that a feature that was never found would leave its rules without effect.
    for &(feature, ..) in FEATURES {
        let of = |rule: &&Rule| rule.of == feature || rule.beside.contains(&feature);
        assert!(RULES.iter().any(|rule| of(&rule)), "{feature:?} is in no rule");
    }
}

#[test]
fn no_rule_is_said_twice() {
    let mut all = Vec::new();
    for Rule { of, beside, .. } in RULES {
        all.extend(beside.iter().map(|other| (*of.min(other), *of.max(other))));
    }
    let count = all.len();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), count);
}
