//! What goes together: the one table from which the checker refuses, the program lists, and the page of scene keys is made.
//!
//! Most of what a scene may have goes with everything else. A [`Rule`] says what does not, and what to do about it. What depends
//! on numbers, or on three things at once, is checked by the module that knows it.

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
    Implicit: "time.integrator" "\"implicit\"",
    Staggered: "time.integrator" "\"staggered\"",
    Coupled: "time.integrator" "\"coupled\"",
    Centroid: "scheme.shape" "\"centroid\"",
    Linear: "scheme.shape" "\"linear\"",
    BBar: "scheme.shape" "\"b-bar\"",
    Gimp: "scheme.shape" "\"gimp\"",
    Bspline2: "scheme.shape" "\"bspline2\"",
    Bspline3: "scheme.shape" "\"bspline3\"",
    AnyShape: "scheme.shape" "a shape that is no B-spline",
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
    Seismic: "seismic_coefficient" "seismic_coefficient",
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
    HeldTop: "boundaries.top" "a constrained top",
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
    RelativeAcceleration: "scheme.relative_acceleration" "true",
    Flip: "scheme.flip" "scheme.flip",
    Affine: "scheme.transfer" "\"affine\"",
    NullSpace: "scheme.null_space_strain" "scheme.null_space_strain",
    Contiguous: "scheme.particle_domain" "\"contiguous\"",
    Musl: "scheme.update" "\"musl\"",
    LightNodes: "scheme.light_nodes" "scheme.light_nodes",
    JumpPenalty: "scheme.jump_penalty" "scheme.jump_penalty",
    TimeMethod: "time.method" "time.method",
    Waves: "time.waves" "time.waves",
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

/// Integrators with steps below a limit.
const STEPPED: &[Feature] = &[Explicit, SemiImplicit, Staggered, Coupled];
/// Integrators whose pressures or displacements are implicit: no accelerations of single nodes are at hand.
const IMPLICIT: &[Feature] = &[SemiImplicit, QuasiStatic, Implicit];
/// Those that solve for displacements.
const SOLVED: &[Feature] = &[QuasiStatic, Implicit];
/// Those, and functions that reach beyond a cell.
const NOT_CORNERS: &[Feature] = &[SemiImplicit, QuasiStatic, Implicit, Gimp, Bspline2, Bspline3];
/// Those, and functions whose forces see the stress of every particle by itself.
const NOT_SAME_PLACE: &[Feature] = &[QuasiStatic, Implicit, Linear, Gimp, Bspline2, Bspline3];
/// Those, and functions that take strains elsewhere than at the centre of the cell.
const NOT_AT_CENTRE: &[Feature] =
    &[QuasiStatic, Implicit, Staggered, Coupled, FreeSurface, Centroid, Linear, Gimp, Bspline2, Bspline3];
/// Soil that is not the same all over.
const SEVERAL: &[Feature] = &[Layers, Regions];
const NOT_PLAIN: &[Feature] = &[SemiImplicit, QuasiStatic, Implicit, Staggered, Coupled, FreeSurface];

const PLANE: &str = "dimension = \"plane-strain\" with it";
const BY_SOLVED: &str = "integrator = \"quasi-static\" or \"implicit\" with it";
const BY_EXPLICIT: &str = "integrator = \"explicit\" with it";
const BY_CORNERS: &str =
    "integrator = \"explicit\" and shape = \"centre\", \"centroid\", \"linear\" or \"b-bar\" with it";
const BY_SAME_PLACE: &str = "integrator = \"explicit\" or \"semi-implicit\" and shape = \"centre\", \"centroid\" or \"b-bar\" with it, \
                             where the stress of a cell is taken at one place";
const BY_CENTRE: &str = "integrator = \"explicit\" or \"semi-implicit\" and shape = \"centre\" or \"b-bar\" with it, without a free surface of water";
const BY_PLAIN: &str = "integrator = \"explicit\" with it, in a scene without a free surface of water";
const BY_TENSOR: &str = "integrator = \"quasi-static\" or \"implicit\" and shape = \"bspline2\" or \"bspline3\" with it: two-point fluxes act only \
                         along face normals";
const AUTO_STEP: &str = "step = \"auto\" with it";

const NO_SUPPORT: &[Feature] = &[Fails, Periodic, CoulombBase, Plate, MovedPlates];

/// The table, in the order in which a scene is checked against it.
pub const RULES: &[Rule] = &[
    rule(Outline, &[Column], "dimension = \"plane-strain\" with it: an outline is an area"),
    rule(EmptyBeside, &[Column], "dimension = \"plane-strain\" with it: a column cannot move sideways"),
    rule(SlopeAngle, &[Column], PLANE),
    rule(SlopeAngle, &[Axisymmetric], "no tilt about a vertical axis: gravity points along it"),
    rule(Periodic, &[Axisymmetric], "dimension = \"plane-strain\" with it: two radii are not the same place"),
    rule(
        FreeSurface,
        &[Axisymmetric],
        "saturated soil about an axis: water with a free surface needs cells of equal volume",
    ),
    rule(Nodal, &[Axisymmetric], "\"face\" about an axis: the nodal flow assumes cells of equal volume"),
    rule(StartVelocity, &[Column], PLANE),
    rule(Periodic, &[Column], PLANE),
    rule(CoulombBase, &[Column], PLANE),
    rule(Strip, &[Column], "dimension = \"plane-strain\" with it: a column carries a uniform load"),
    rule(FixedSide, &[Column], "\"roller\" in a column, which cannot move sideways (or dimension = \"plane-strain\")"),
    rule(
        Fails,
        &[Column, NoGravity, SlopeAngle, HeldTop],
        "plane strain under gravity, with a level base and a free top, and coupling = \"full\"",
    ),
    rule(
        Fails,
        &[Dry, Saturated],
        "[water.free_surface] with coupling = \"full\": which soil is saturated, and where water flows in",
    ),
    rule(
        StageSides,
        NO_SUPPORT,
        "the supports of [boundaries] in every stage: a periodic side, a base with friction or a moved plate is no support",
    ),
    rule(Fails, &[RestEnd, PressureEnd], "a time (s) with coupling = \"full\""),
    rule(SlopeAngle, &[NoGravity], "the key gravity with it, whose direction it turns"),
    rule(Seismic, &[Column, Axisymmetric], "dimension = \"plane-strain\" with it: the force is along x"),
    rule(Seismic, &[NoGravity], "the key gravity with it, of which it is a share"),
    rule(
        Seismic,
        &[Saturated],
        "dry soil, or [water.free_surface] with it: the force acts on soil whose water keeps its pressure",
    ),
    rule(Geostatic, &[NoGravity], "the key gravity with a geostatic start"),
    rule(StartK0, &[Unloaded, UndrainedStart, GivenStart], "start = \"geostatic\" with it"),
    rule(Initial, &[Unloaded, UndrainedStart], "start = \"given\" with it, or \"geostatic\", to which it is added"),
    rule(UndrainedStart, &[Dry], "[water] to carry the load undrained"),
    rule(UndrainedStart, &[FreeSurface], "\"geostatic\" or \"unloaded\" with it: its soil is not saturated"),
    rule(
        UndrainedStart,
        &[Outline],
        "\"geostatic\" or \"unloaded\" with an outline: undrained equilibrium is that of level soil",
    ),
    rule(UndrainedStart, &[Strip], "\"unloaded\" under a strip: undrained equilibrium assumes a uniform load"),
    rule(
        Load,
        &[HeldTop],
        "boundaries.top = \"free\" under a surcharge (a load on a constrained surface has no effect)",
    ),
    rule(
        Plate,
        &[FixedSide],
        "\"surface\" with it, or \"roller\" or \"free\" sides: soil that is fixed at the edge of a plate cannot follow it, \
         and its stress grows with every refinement",
    ),
    rule(
        Plate,
        &[EmptyBeside],
        "\"surface\" or \"particles\" in a mesh with empty cells: the plate is the top row of nodes of the mesh",
    ),
    rule(Plate, &[Outline], "\"surface\" on an outline, whose top is no row of nodes"),
    rule(Strip, &[Plate], "on = \"surface\" or \"particles\" with it: a plate distributes its load itself"),
    // Water.
    rule(DarcyOperator, &[Dry], "no Darcy operator in a dry scene"),
    rule(DarcyInertia, &[Dry], "no inertia term of Darcy's law in a dry scene"),
    rule(JumpPenalty, &[Dry], "no jump penalty in a dry scene: it acts on the pore pressure"),
    rule(Drained, &[Dry], "no drained side in a dry scene"),
    rule(PressureEnd, &[Dry], "[surcharge] and [water]"),
    rule(
        PressureEnd,
        &[Gravity],
        "time or time_factor under gravity: the stage would wait for the pressure of the load alone",
    ),
    rule(
        PressureEnd,
        &[Loads, MovedPlates, Wells],
        "time or time_factor with them: the stage would wait for the pressure of [surcharge] alone",
    ),
    rule(SemiImplicit, &[Dry], "a [water] table with it: a dry scene has no pressure to solve for"),
    rule(Incompressible, &[Explicit], "a finite bulk modulus (Pa): the explicit step resolves its pressure wave"),
    rule(
        Incompressible,
        &[StartVelocity],
        "a finite bulk modulus (Pa): water that does not compress is stopped by a pressure without bound",
    ),
    rule(Incompressible, &[PressureEnd], "a finite bulk modulus (Pa): the pressure must stay for a period of its wave"),
    rule(
        FreeSurface,
        IMPLICIT,
        "integrator = \"staggered\" with it, or \"coupled\" or \"explicit\" with coupling = \"full\": the others need \
         saturated soil",
    ),
    rule(Staggered, &[Dry, Saturated], "[water.free_surface] with it, or integrator = \"explicit\""),
    rule(
        Coupled,
        &[Dry, Saturated],
        "[water.free_surface] and coupling = \"full\" with it, or integrator = \"explicit\"",
    ),
    rule(
        FreeSurface,
        &[BBar, Gimp, Bspline2, Bspline3],
        "shape = \"centre\", \"centroid\" or \"linear\" with it: its forces are integrated over whole cells",
    ),
    rule(PaperStep, &[FreeSurface], "\"auto\" or a step (s): the paper's 1e-7 s is that of its consolidation column"),
    rule(Nodal, &[Periodic, Outline], "\"face\" with it: the nodal flow assumes that soil fills every cell"),
    rule(Wells, &[Dry], "[water] with it: a dry scene has no water to pump"),
    rule(
        Wells,
        &[FreeSurface],
        "saturated soil with it: water with a free surface enters and leaves by feeds and [[reservoirs]]",
    ),
    rule(Wells, &[EmptyBeside], "no empty cells beside the soil: soil that flows out takes its water particles along"),
    rule(Wells, &[Nodal], "\"face\" with wells: the balance of a cell is that of its faces"),
    rule(KozenyCarman, &[Dry], "[water] with it: a dry scene has no flow"),
    rule(KozenyCarman, &[SmallStrain], "\"large\" with it: porosity is constant at small strain"),
    rule(
        KozenyCarman,
        &[FreeSurface],
        "false with it: water with a free surface flows through soil of constant porosity",
    ),
    rule(KozenyCarman, &[Nodal], "\"face\" with it: velocities at nodes assume one conductivity for all cells"),
    rule(Bedding, &[Dry], "[water] with it: a dry scene has no flow"),
    rule(Bedding, &[Column], "dimension = \"plane-strain\" with it: water in inclined layers flows sideways too"),
    rule(Bedding, STEPPED, BY_TENSOR),
    rule(Bedding, &[AnyShape], BY_TENSOR),
    // Functions.
    rule(
        Bspline3,
        STEPPED,
        "integrator = \"quasi-static\" or \"implicit\" with it, which fit weights: particles of equal volumes do not balance a uniform \
         stress at the ends of cubic B-splines, and \"bspline2\" is more accurate",
    ),
    rule(Centroid, IMPLICIT, BY_EXPLICIT),
    rule(JumpPenalty, &[AnyShape], "shape = \"bspline2\" or \"bspline3\" with it: other shapes have no jump penalty"),
    rule(JumpPenalty, STEPPED, BY_SOLVED),
    rule(
        Nodal,
        &[SemiImplicit, Gimp, Bspline2, Bspline3],
        "\"face\", or integrator = \"explicit\" and shape = \"centre\" or \"linear\" with it",
    ),
    rule(Nodal, SOLVED, "\"face\" with it: the nodal flow is a velocity of an explicit step"),
    rule(
        Nodal,
        SEVERAL,
        "\"face\" with several soils: a velocity at the nodes of an interface has no one conductivity",
    ),
    rule(LightNodes, NOT_CORNERS, BY_CORNERS),
    // Explicit steps alone.
    rule(Outline, SOLVED, BY_EXPLICIT),
    rule(Outline, &[Gimp, Bspline2, Bspline3], BY_CORNERS),
    rule(EmptyBeside, IMPLICIT, BY_EXPLICIT),
    rule(EmptyBeside, &[Gimp, Bspline2, Bspline3], BY_CORNERS),
    rule(StartVelocity, &[SemiImplicit, QuasiStatic], "integrator = \"explicit\" or \"implicit\" with it"),
    rule(Periodic, NOT_CORNERS, BY_CORNERS),
    rule(
        Periodic,
        &[Outline, EmptyBeside],
        "[geometry.column] without empty_cells_beside where \"periodic\" stands: the soil fills the width",
    ),
    rule(CoulombBase, NOT_CORNERS, BY_CORNERS),
    rule(Separation, &[LinearElastic, CamClay], "mohr_coulomb with dilation_angle = 0"),
    rule(Separation, NOT_CORNERS, BY_CORNERS),
    rule(RestEnd, NOT_CORNERS, BY_CORNERS),
    rule(Affine, NOT_PLAIN, BY_PLAIN),
    rule(NullSpace, NOT_SAME_PLACE, BY_SAME_PLACE),
    rule(Contiguous, NOT_AT_CENTRE, BY_CENTRE),
    rule(Musl, NOT_PLAIN, BY_PLAIN),
    rule(Musl, &[CoulombBase], "\"usl\" with [base]: friction acts at the nodes"),
    // Solved displacements alone, and what they have no use for.
    rule(
        Implicit,
        &[AnyShape],
        "shape = \"bspline2\" or \"bspline3\" with it, whose pressures are as smooth as the motion of the soil",
    ),
    rule(
        RelativeAcceleration,
        &[Explicit, SemiImplicit, QuasiStatic, Staggered, Coupled],
        "integrator = \"implicit\" with it: the others leave out the acceleration of the water relative to the soil",
    ),
    rule(RelativeAcceleration, &[Dry], "[water] with it: a dry scene has no flow"),
    rule(Shift, STEPPED, BY_SOLVED),
    rule(Displaced, STEPPED, BY_SOLVED),
    rule(
        SmallStrain,
        STEPPED,
        "\"large\", or integrator = \"quasi-static\" or \"implicit\": the other integrators move their particles",
    ),
    rule(TimeMethod, STEPPED, "integrator = \"quasi-static\" with it"),
    rule(TimeMethod, &[Implicit], "no such key with it: soil with inertia is followed by steps of SDIRK4(3)"),
    rule(
        Waves,
        &[Explicit, SemiImplicit, QuasiStatic, Staggered, Coupled],
        "integrator = \"implicit\" with it: others resolve the waves that their steps can, or have none",
    ),
    rule(Tolerance, STEPPED, BY_SOLVED),
    rule(Krylov, &[LargeStrain], "soil.strain = \"small\" with it: the Krylov method needs a linear scene"),
    rule(Krylov, &[MohrCoulomb, CamClay], "linear_elastic soil with it: the Krylov method needs a linear scene"),
    rule(Krylov, &[Gravity], "no gravity with it: the Krylov method needs a linear scene"),
    rule(Krylov, &[Dry], "[water] with it: the Krylov method is for consolidation"),
    rule(
        Krylov,
        &[MovedPlates],
        "method = \"sdirk\" with plates that are moved: the Krylov method needs constant loads",
    ),
    rule(Krylov, &[Wells], "method = \"sdirk\" with wells: the Krylov method needs constant loads"),
    rule(Krylov, &[GivenStep, PaperStep], "step = \"auto\": the Krylov method has no steps"),
    rule(InertiaKept, &[QuasiStatic], "false, or no such key: quasi-static runs have no inertia"),
    rule(Flip, SOLVED, "no such key with it: no velocities go from particles to nodes in every step"),
    rule(Damping, &[QuasiStatic], "no damping with quasi-static, which has no inertia"),
    rule(PressureEnd, &[QuasiStatic], "time or time_factor: quasi-static runs apply a load undrained at once"),
    rule(PressureEnd, &[Implicit], "time or time_factor with implicit"),
    rule(Safety, SOLVED, "no safety factor with it: its steps have no stability limit"),
    rule(PaperStep, SOLVED, "\"auto\" or a step above 0 (s)"),
    rule(Safety, &[GivenStep, PaperStep], AUTO_STEP),
    rule(Tolerance, &[GivenStep, PaperStep], AUTO_STEP),
    // Layers.
    rule(Shift, &[Layers], "0 with [[layers]], which end at faces of the mesh"),
    rule(
        PressureEnd,
        &[FreeSurface, Outline],
        "a saturated column with it: the stage waits for the undrained pressure of the load",
    ),
    rule(PressureEnd, SEVERAL, "time or time_factor: each soil has its own undrained pressure"),
    rule(Separation, SEVERAL, "one uniform soil with it: a tension gap is detected from the density of the soil"),
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
    format!("| what | not with | expected in its place |\n|---|---|---|\n{rows}")
}
