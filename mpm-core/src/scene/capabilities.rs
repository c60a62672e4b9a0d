//! What goes together: the one table from which the checker refuses, the program lists, and the page of scene keys is made.
//!
//! Most of what a scene may have goes with everything else. A [`Rule`] says what does not, and what to do about it. What depends
//! on numbers, or on three things at once, is said by the room that knows it.

use Feature::*;

macro_rules! features {
    ($($feature:ident: $key:literal $word:literal,)*) => {
        /// Something that a scene has, and that not everything goes with.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[allow(missing_docs, reason = "`Feature::key` and `Feature::word` are what a scene file says")]
        pub enum Feature {
            $($feature,)*
        }

        /// Every feature with the key that asks for it and what a scene file says there.
        pub const FEATURES: &[(Feature, &str, &str)] = &[$(($feature, $key, $word),)*];
    };
}

features! {
    Column: "dimension" "\"column\"",
    Axisymmetric: "dimension" "\"axisymmetric\"",
    Outline: "geometry.outline" "[geometry.outline]",
    Explicit: "time.integrator" "\"explicit\"",
    SemiImplicit: "time.integrator" "\"semi-implicit\"",
    QuasiStatic: "time.integrator" "\"quasi-static\"",
    Staggered: "time.integrator" "\"staggered\"",
    Coupled: "time.integrator" "\"coupled\"",
    Centroid: "scheme.shape" "\"centroid\"",
    BBar: "scheme.shape" "\"b-bar\"",
    Gimp: "scheme.shape" "\"gimp\"",
    Bspline2: "scheme.shape" "\"bspline2\"",
    Bspline3: "scheme.shape" "\"bspline3\"",
    AnyShape: "scheme.shape" "a shape without penalty",
    Dry: "water" "a dry scene",
    Saturated: "water" "soil full of water",
    FreeSurface: "water.free_surface" "[water.free_surface]",
    Incompressible: "water.bulk_modulus" "inf",
    KozenyCarman: "water.kozeny_carman" "true",
    Bedding: "water.bedding_angle" "an inclined bedding",
    LinearElastic: "soil.law" "linear_elastic",
    MohrCoulomb: "soil.law" "mohr_coulomb",
    CamClay: "soil.law" "modified_cam_clay",
    Layers: "layers" "[[layers]]",
    Regions: "regions" "[[regions]]",
    Separation: "soil.separation" "soil.separation",
    LargeStrain: "soil.strain" "\"large\"",
    SmallStrain: "soil.strain" "\"small\"",
    NoGravity: "gravity" "no gravity",
    Gravity: "gravity" "gravity",
    SlopeAngle: "slope_angle" "slope_angle",
    Unloaded: "start" "\"unloaded\"",
    UndrainedStart: "start" "\"undrained-equilibrium\"",
    Geostatic: "start" "\"geostatic\"",
    GivenStart: "start" "\"given\"",
    Initial: "initial" "[initial]",
    StartK0: "start_k0" "start_k0",
    StartVelocity: "start_velocity" "start_velocity",
    Shift: "mesh.shift" "mesh.shift",
    Displaced: "mesh.displaced" "mesh.displaced",
    EmptyBeside: "mesh.empty_cells_beside" "mesh.empty_cells_beside",
    Periodic: "boundaries.left" "\"periodic\"",
    FixedSide: "boundaries.left" "a \"fixed\" side",
    HeldTop: "boundaries.top" "a held top",
    CoulombBase: "base" "[base]",
    Load: "surcharge" "[surcharge]",
    Plate: "surcharge.on" "\"plate\"",
    Strip: "surcharge.strip" "surcharge.strip",
    Loads: "loads" "[[loads]] or [[reservoirs]]",
    MovedPlates: "plates" "[[plates]]",
    Wells: "wells" "[[wells]]",
    DarcyOperator: "scheme.darcy" "scheme.darcy",
    Nodal: "scheme.darcy" "\"nodal\"",
    DarcyInertia: "scheme.darcy_inertia" "scheme.darcy_inertia",
    InertiaKept: "scheme.darcy_inertia" "true",
    Flip: "scheme.flip" "scheme.flip",
    Affine: "scheme.transfer" "\"affine\"",
    Musl: "scheme.update" "\"musl\"",
    LightNodes: "scheme.light_nodes" "scheme.light_nodes",
    JumpPenalty: "scheme.jump_penalty" "scheme.jump_penalty",
    TimeMethod: "time.method" "time.method",
    Krylov: "time.method" "\"krylov\"",
    Tolerance: "time.tolerance" "time.tolerance",
    Safety: "time.safety" "time.safety",
    GivenStep: "time.step" "a given step",
    PaperStep: "time.step" "\"paper\"",
    Drained: "stages.drained" "stages.drained",
    StageSides: "stages.boundaries" "stages.boundaries",
    Damping: "stages.damping" "stages.damping",
    Fails: "stages.coupling" "\"full\"",
    RestEnd: "stages.until.rest" "stages.until.rest",
    PressureEnd: "stages.until" "pore_pressure_within",
}

impl Feature {
    /// The key of a scene file that asks for it.
    pub fn key(self) -> &'static str {
        self.entry().1
    }

    /// What a scene file says there, or a word for what it leaves out.
    pub fn word(self) -> &'static str {
        self.entry().2
    }

    /// Key and word as a scene file has them, `scheme.shape = "gimp"`; one of them where it says all.
    pub fn name(self) -> String {
        let (_, key, word) = self.entry();
        if word.starts_with('"') || *word == "inf" || *word == "true" {
            format!("{key} = {word}")
        } else {
            (*word).to_owned()
        }
    }

    fn entry(self) -> &'static (Feature, &'static str, &'static str) {
        &FEATURES[self as usize]
    }
}

/// A feature that does not go with some others.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// What is refused.
    pub of: Feature,
    /// Beside any of these.
    pub beside: &'static [Feature],
    /// What is expected in its place, and why.
    pub expected: &'static str,
}

const fn rule(of: Feature, beside: &'static [Feature], expected: &'static str) -> Rule {
    Rule { of, beside, expected }
}

/// Integrators but the quasi-static one.
const STEPPED: &[Feature] = &[Explicit, SemiImplicit, Staggered, Coupled];
/// Integrators whose pressures or displacements are implicit: no accelerations of single nodes are at hand.
const IMPLICIT: &[Feature] = &[SemiImplicit, QuasiStatic];
/// Those, and functions that reach beyond a cell.
const NOT_CORNERS: &[Feature] = &[SemiImplicit, QuasiStatic, Gimp, Bspline2, Bspline3];
/// Soil that is not the same all over.
const SEVERAL: &[Feature] = &[Layers, Regions];
const NOT_PLAIN: &[Feature] = &[SemiImplicit, QuasiStatic, Staggered, Coupled, FreeSurface];

const PLANE: &str = "dimension = \"plane-strain\" beside it";
const BY_QUASI_STATIC: &str = "integrator = \"quasi-static\" beside it";
const BY_EXPLICIT: &str = "integrator = \"explicit\" beside it";
const BY_CORNERS: &str =
    "integrator = \"explicit\" and shape = \"centre\", \"centroid\", \"linear\" or \"b-bar\" beside it";
const BY_PLAIN: &str = "integrator = \"explicit\" beside it, in a scene without a free surface of water";
const BY_TENSOR: &str = "integrator = \"quasi-static\" and shape = \"bspline2\" or \"bspline3\" beside it: two-point faces carry only \
                         fluxes along their normals";
const AUTO_STEP: &str = "step = \"auto\" beside it";

const NO_SUPPORT: &[Feature] = &[Fails, Periodic, CoulombBase, Plate, MovedPlates];

/// The table, in the order in which a scene is held against it.
pub const RULES: &[Rule] = &[
    rule(Outline, &[Column], "dimension = \"plane-strain\" beside it: an outline is an area"),
    rule(EmptyBeside, &[Column], "dimension = \"plane-strain\" beside it: a column cannot move sideways"),
    rule(SlopeAngle, &[Column], PLANE),
    rule(SlopeAngle, &[Axisymmetric], "no tilt about a vertical axis: gravity points along it"),
    rule(Periodic, &[Axisymmetric], "dimension = \"plane-strain\" beside it: two radii are not the same place"),
    rule(FreeSurface, &[Axisymmetric], "soil full of water about an axis: free water is in cells of equal volume"),
    rule(Nodal, &[Axisymmetric], "\"face\" about an axis: the nodal flow takes cells for equal"),
    rule(StartVelocity, &[Column], PLANE),
    rule(Periodic, &[Column], PLANE),
    rule(CoulombBase, &[Column], PLANE),
    rule(Strip, &[Column], "dimension = \"plane-strain\" beside it: a column is loaded all over"),
    rule(FixedSide, &[Column], "\"roller\" in a column, which cannot move sideways (or dimension = \"plane-strain\")"),
    rule(
        Fails,
        &[Column, NoGravity, SlopeAngle, HeldTop],
        "plane strain under gravity, with a level base and a free top, beside coupling = \"full\"",
    ),
    rule(
        Fails,
        &[Dry, Saturated],
        "[water.free_surface] beside coupling = \"full\": which soil is wet, and what feeds it",
    ),
    rule(
        StageSides,
        NO_SUPPORT,
        "the supports of [boundaries] in every stage: what is periodic, rubs or moves is none",
    ),
    rule(Fails, &[RestEnd, PressureEnd], "a time (s) beside coupling = \"full\""),
    rule(SlopeAngle, &[NoGravity], "the key gravity beside it, which it turns"),
    rule(Geostatic, &[NoGravity], "the key gravity beside a geostatic start"),
    rule(StartK0, &[Unloaded, UndrainedStart, GivenStart], "start = \"geostatic\" beside it"),
    rule(Initial, &[Unloaded, UndrainedStart], "start = \"given\" beside it, or \"geostatic\", to which it is added"),
    rule(UndrainedStart, &[Dry], "[water] to carry the load undrained"),
    rule(UndrainedStart, &[FreeSurface], "\"geostatic\" or \"unloaded\" beside it: its soil is not full of water"),
    rule(
        UndrainedStart,
        &[Outline],
        "\"geostatic\" or \"unloaded\" beside an outline: undrained equilibrium is that of level soil",
    ),
    rule(UndrainedStart, &[Strip], "\"unloaded\" under a strip: undrained equilibrium is that of a load all over"),
    rule(Load, &[HeldTop], "boundaries.top = \"free\" under a surcharge (a held surface carries no load)"),
    rule(
        Plate,
        &[FixedSide],
        "\"surface\" beside it, or \"roller\" or \"free\" sides: soil that is held at the edge of a plate cannot follow it, \
         and its stress grows with every refinement",
    ),
    rule(
        Plate,
        &[EmptyBeside],
        "\"surface\" or \"particles\" in a mesh with room to move: the plate is its top row of nodes",
    ),
    rule(Plate, &[Outline], "\"surface\" on an outline, whose top is no row of nodes"),
    rule(Strip, &[Plate], "on = \"surface\" or \"particles\" beside it: a plate spreads its load itself"),
    // Water.
    rule(DarcyOperator, &[Dry], "no Darcy operator in a dry scene"),
    rule(DarcyInertia, &[Dry], "no inertia in Darcy's law in a dry scene"),
    rule(JumpPenalty, &[Dry], "no jump penalty in a dry scene: it acts on the pore pressure"),
    rule(Drained, &[Dry], "no drained side in a dry scene"),
    rule(PressureEnd, &[Dry], "[surcharge] and [water]"),
    rule(
        PressureEnd,
        &[Gravity],
        "time or time_factor under gravity: the pressure waited for is that of the load alone",
    ),
    rule(
        PressureEnd,
        &[Loads, MovedPlates, Wells],
        "time or time_factor beside them: the pressure waited for is that of [surcharge] alone",
    ),
    rule(SemiImplicit, &[Dry], "a [water] table beside it: a dry scene has no pressure to solve for"),
    rule(Incompressible, &[Explicit], "a finite bulk modulus (Pa): the explicit step follows its pressure wave"),
    rule(Incompressible, &[PressureEnd], "a finite bulk modulus (Pa): the pressure must hold for a period of its wave"),
    rule(
        FreeSurface,
        IMPLICIT,
        "integrator = \"staggered\" beside it, or \"coupled\" or \"explicit\" with coupling = \"full\": the others know \
         saturated soil",
    ),
    rule(Staggered, &[Dry, Saturated], "[water.free_surface] beside it, or integrator = \"explicit\""),
    rule(
        Coupled,
        &[Dry, Saturated],
        "[water.free_surface] and coupling = \"full\" beside it, or integrator = \"explicit\"",
    ),
    rule(
        FreeSurface,
        &[BBar, Gimp, Bspline2, Bspline3],
        "shape = \"centre\", \"centroid\" or \"linear\" beside it: its forces are those of whole cells",
    ),
    rule(PaperStep, &[FreeSurface], "\"auto\" or a step (s): the paper's 1e-7 s is that of its consolidation column"),
    rule(Nodal, &[Periodic, Outline], "\"face\" beside it: the nodal flow takes every cell for full of soil"),
    rule(Wells, &[Dry], "[water] beside it: a dry scene has none to take"),
    rule(Wells, &[FreeSurface], "soil full of water beside it: free water comes and goes by feeds and [[reservoirs]]"),
    rule(Wells, &[EmptyBeside], "no room to run out beside it: soil that does gives its water away with its particles"),
    rule(Wells, &[Nodal], "\"face\" beside wells: the balance of a cell is that of its faces"),
    rule(KozenyCarman, &[Dry], "[water] beside it: a dry scene conducts none"),
    rule(KozenyCarman, &[SmallStrain], "\"large\" beside it: pores keep their size at small strain"),
    rule(KozenyCarman, &[FreeSurface], "false beside it: water with a free surface flows as in soil at rest"),
    rule(KozenyCarman, &[Nodal], "\"face\" beside it: velocities at nodes take one conductivity for all cells"),
    rule(Bedding, &[Dry], "[water] beside it: a dry scene conducts none"),
    rule(Bedding, &[Column], "dimension = \"plane-strain\" beside it: water in inclined layers flows sideways too"),
    rule(Bedding, STEPPED, BY_TENSOR),
    rule(Bedding, &[AnyShape], BY_TENSOR),
    // Functions.
    rule(
        Bspline3,
        STEPPED,
        "integrator = \"quasi-static\" beside it, which fits weights: particles of equal volumes do not balance a uniform \
         stress at the ends of cubic B-splines, and \"bspline2\" is nearer",
    ),
    rule(Centroid, IMPLICIT, BY_EXPLICIT),
    rule(JumpPenalty, &[AnyShape], "shape = \"bspline2\" or \"bspline3\" beside it: other shapes have no jump penalty"),
    rule(JumpPenalty, STEPPED, BY_QUASI_STATIC),
    rule(
        Nodal,
        &[SemiImplicit, Gimp, Bspline2, Bspline3],
        "\"face\", or integrator = \"explicit\" and shape = \"centre\" or \"linear\" beside it",
    ),
    rule(Nodal, &[QuasiStatic], "\"face\" beside quasi-static: the nodal flow is a velocity of an explicit step"),
    rule(
        Nodal,
        SEVERAL,
        "\"face\" beside several soils: a velocity at the nodes of an interface has no one conductivity",
    ),
    rule(LightNodes, NOT_CORNERS, BY_CORNERS),
    // Explicit steps alone.
    rule(Outline, &[QuasiStatic], BY_EXPLICIT),
    rule(Outline, &[Gimp, Bspline2, Bspline3], BY_CORNERS),
    rule(EmptyBeside, IMPLICIT, BY_EXPLICIT),
    rule(EmptyBeside, &[Gimp, Bspline2, Bspline3], BY_CORNERS),
    rule(StartVelocity, IMPLICIT, BY_EXPLICIT),
    rule(Periodic, NOT_CORNERS, BY_CORNERS),
    rule(
        Periodic,
        &[Outline, EmptyBeside],
        "[geometry.column] without empty_cells_beside where \"periodic\" stands: the soil fills the width",
    ),
    rule(CoulombBase, NOT_CORNERS, BY_CORNERS),
    rule(Separation, &[LinearElastic, CamClay], "mohr_coulomb without dilation beside it"),
    rule(Separation, NOT_CORNERS, BY_CORNERS),
    rule(RestEnd, NOT_CORNERS, BY_CORNERS),
    rule(Affine, NOT_PLAIN, BY_PLAIN),
    rule(Musl, NOT_PLAIN, BY_PLAIN),
    rule(Musl, &[CoulombBase], "\"usl\" beside [base]: friction is with the nodes"),
    // Quasi-static alone, and what it has no use for.
    rule(Shift, STEPPED, BY_QUASI_STATIC),
    rule(Displaced, STEPPED, BY_QUASI_STATIC),
    rule(SmallStrain, STEPPED, "\"large\", or integrator = \"quasi-static\": the others move their particles"),
    rule(TimeMethod, STEPPED, BY_QUASI_STATIC),
    rule(Tolerance, STEPPED, BY_QUASI_STATIC),
    rule(Krylov, &[LargeStrain], "soil.strain = \"small\" beside it: the Krylov method is for linear scenes"),
    rule(Krylov, &[MohrCoulomb, CamClay], "linear_elastic soil beside it: the Krylov method is for linear scenes"),
    rule(Krylov, &[Gravity], "no gravity beside it: the Krylov method is for linear scenes"),
    rule(Krylov, &[Dry], "[water] beside it: the Krylov method follows what drains"),
    rule(
        Krylov,
        &[MovedPlates],
        "method = \"sdirk\" beside plates that are moved: the Krylov method is for constant loads",
    ),
    rule(Krylov, &[Wells], "method = \"sdirk\" beside wells: the Krylov method is for constant loads"),
    rule(Krylov, &[GivenStep, PaperStep], "step = \"auto\": the Krylov method has no steps"),
    rule(InertiaKept, &[QuasiStatic], "false, or no such key: quasi-static has no inertia"),
    rule(Flip, &[QuasiStatic], "no such key beside quasi-static, which carries no velocities"),
    rule(Damping, &[QuasiStatic], "no damping beside quasi-static, which has no inertia"),
    rule(PressureEnd, &[QuasiStatic], "time or time_factor: quasi-static carries a load undrained at once"),
    rule(Safety, &[QuasiStatic], "no safety factor beside quasi-static, whose steps have no stability limit"),
    rule(PaperStep, &[QuasiStatic], "\"auto\" or a step above 0 (s)"),
    rule(Safety, &[GivenStep, PaperStep], AUTO_STEP),
    rule(Tolerance, &[GivenStep, PaperStep], AUTO_STEP),
    // Layers.
    rule(Shift, &[Layers], "0 beside [[layers]], which end at faces of the mesh"),
    rule(
        PressureEnd,
        &[FreeSurface, Outline],
        "a box of soil that is full of water beside it, where the pressure waited for is that of the load",
    ),
    rule(PressureEnd, SEVERAL, "time or time_factor: soils have an undrained pressure each, not one to wait for"),
    rule(Separation, SEVERAL, "one soil all over beside it: a gap is told from the density of the soil"),
];

/// The rule by which two features do not go together, if there is one.
pub fn conflict(a: Feature, b: Feature) -> Option<&'static Rule> {
    RULES.iter().find(|rule| (rule.of == a && rule.beside.contains(&b)) || (rule.of == b && rule.beside.contains(&a)))
}

/// The table as a page shows it: a line of Markdown for each rule.
pub fn table() -> String {
    let names =
        |list: &[Feature]| list.iter().map(|other| format!("`{}`", other.name())).collect::<Vec<_>>().join(", ");
    let row = |rule: &Rule| format!("| `{}` | {} | {} |\n", rule.of.name(), names(rule.beside), rule.expected);
    let rows: String = RULES.iter().map(row).collect();
    format!("| what | not beside | expected in its place |\n|---|---|---|\n{rows}")
}
