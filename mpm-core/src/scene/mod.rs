//! What to simulate. A scene file is read in two types: `raw` holds what the user wrote and where, [`Scene`]
//! what was understood and found possible. Every default, unit and bound of the program is in this module.

pub mod capabilities;
mod check;
mod decode;
mod failure;
mod flags;
mod free_surface;
mod ground;
mod initial;
mod loads;
mod moving;
mod patch;
mod raw;
mod renames;
mod soils;
mod written;

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Deref;
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize, Serializer};

pub use check::{INTEGRATORS, SHAPES};
pub use failure::Failure;
pub use flags::Flags;
pub use free_surface::{Coupling, Feed, FreeSurfaceWater};
pub use ground::{Base, NormalStress, SeedingChoice};
pub use initial::Initial;
pub use loads::{AlongX, Bearing, Course, FaceLoad, MovedPlate, Piece, Well};
pub(crate) use moving::PASSAGES;
pub(crate) use moving::THROUGH_CELLS;
pub use moving::{Estimate, UnfitLoad};
pub use patch::Change;
pub use soils::{Biot, Fabric, Ground, Region, Soil, SoilLayer, Zones};

use crate::error::{LoadError, SceneError, Warning};
use crate::stability::{intended_step, stable_limit};
use patch::Source;

/// One spatial dimension or two. The same scene runs in both and gives the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dimension {
    /// One dimension, vertical; the width only scales areas.
    Column,
    /// Two dimensions, plane strain, 1 m thick.
    PlaneStrain,
    /// Two dimensions, a section of soil that is the same all around a vertical axis: x is the radius, and all amounts are
    /// those of one radian.
    Axisymmetric,
}

/// The state at t = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// No stress, no pore pressure: the load is applied in the first stage (the paper).
    Unloaded,
    /// Load and weight carried without drainage: of the total stress s the water has `p_0 = s Q/(M + Q)`, the soil the rest.
    UndrainedEquilibrium,
    /// At rest under gravity: hydrostatic pore pressure, effective stress from the buoyant weight.
    Geostatic,
    /// As [`Fields::initial`] says.
    Given,
}

/// How time is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// The paper's Figure 1: everything from the state at the start of the step.
    Explicit,
    /// Explicit skeleton, implicit pore pressure.
    SemiImplicit,
    /// Implicit displacement and pressure, no inertia; the step follows from a tolerance.
    QuasiStatic,
    /// The same with the inertia of soil and water.
    Implicit,
    /// Water with a free surface in soil at rest, in steps of its own, and explicit soil under the pressures it leaves.
    Staggered,
    /// The same water and soil in steps of the soil, with the pressures of their end.
    Coupled,
}

impl Integrator {
    /// Whether displacements are unknowns, on a mesh that is built over the soil, in steps that follow from a tolerance.
    pub fn solves_displacements(self) -> bool {
        matches!(self, Self::QuasiStatic | Self::Implicit)
    }
}

/// Shape functions, and where they are evaluated for stress, pore pressure and strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeChoice {
    /// Linear, gradients at the centre of the cell: the paper's stabilisation, section 2.2.
    Centre,
    /// Linear, gradients at the centroid of the soil in the cell: the centre where the cell is full.
    Centroid,
    /// Linear, gradients at the particle: the standard linear MPM.
    Linear,
    /// Linear, what changes volumes at the centre of the cell, the rest at the particle (B-bar).
    BBar,
    /// uGIMP: linear functions averaged over the first size of the particle.
    Gimp,
    /// Quadratic B-splines on knots that are open at the boundary.
    Bspline2,
    /// Cubic ones, quasi-static.
    Bspline3,
}

impl ShapeChoice {
    /// Degree of B-splines, of which there are this many more along an axis than cells.
    pub fn spline_degree(self) -> Option<usize> {
        match self {
            Self::Bspline2 => Some(2),
            Self::Bspline3 => Some(3),
            Self::Centre | Self::Centroid | Self::Linear | Self::BBar | Self::Gimp => None,
        }
    }

    /// Its word in a scene file.
    pub fn word(self) -> &'static str {
        SHAPES.iter().find(|(_, shape)| *shape == self).map_or("", |(word, _)| *word)
    }

    /// Whether functions reach beyond the cells beside a node, and their gradients do not jump at faces.
    pub fn is_wide(self) -> bool {
        self == Self::Gimp || self.spline_degree().is_some()
    }
}

/// Whether the geometry follows the deformation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StrainChoice {
    /// Particles move, logarithmic strain, porosity and cell volumes follow.
    Large,
    /// Everything on the first geometry; with an elastic law the scene is linear.
    Small,
}

/// How quasi-static time steps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeMethod {
    /// [`TimeMethod::Krylov`] where the scene is linear, else [`TimeMethod::Sdirk`].
    Auto,
    /// Shift-invert rational Krylov: one factorisation for all times of a stage. Linear scenes only.
    Krylov,
    /// SDIRK4(3) with an embedded error estimate.
    Sdirk,
}

/// What the implicit integrator does with waves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Waves {
    /// [`Waves::Resolved`] where a time is asked for before a wave of the drained soil has passed the height ten times.
    Auto,
    /// Steps are as short as the error of every wave asks.
    Resolved,
    /// The error of waves counts for nothing: those faster than the steps are damped.
    Damped,
}

/// Volumes that particles stand for in integrals over a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quadrature {
    /// Weights that fill the soil: quasi-static B-splines have products of their slopes integrated exactly, explicit and
    /// semi-implicit particles share the soil of their cell ([`crate::boundary::Filled`]).
    Fitted,
    /// The particles' own volumes.
    Volumes,
}

/// Particles moved from their even places at t = 0, in spacings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Displaced {
    /// Amplitude of a smooth wave, sin(2 pi x/length) along each axis.
    pub smooth: f64,
    /// Half width of a uniform random displacement along each axis.
    pub jitter: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A part of the top under the surcharge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoadedStrip {
    /// First x under the full load, m.
    pub from: f64,
    /// Last x under the full load, m.
    pub to: f64,
    /// Width over which the load falls to zero outside, as cos^2, m.
    pub taper: f64,
}

impl LoadedStrip {
    /// Share of the load at a place x (m).
    pub fn share(&self, x: f64) -> f64 {
        let outside = (self.from - x).max(x - self.to);
        if outside <= 0.0 {
            1.0
        } else if outside < self.taper {
            (std::f64::consts::FRAC_PI_2 * outside / self.taper).cos().powi(2)
        } else {
            0.0
        }
    }
}

/// How the Darcy flow between cells is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DarcyChoice {
    /// Two-point flux on cell faces.
    Face,
    /// Nodal relative velocity, the paper's Eq. (1).
    Nodal,
}

/// What a particle gives to a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TransferChoice {
    /// Its velocity.
    Plain,
    /// Its velocity at the place of the node, by its velocity gradient.
    Affine,
}

impl TransferChoice {
    /// The usual choice stays out of the record of a scene.
    pub fn is_default(&self) -> bool {
        *self == Self::Plain
    }
}

/// Which velocities strain the soil.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpdateChoice {
    /// Those of the nodes at the end of the step (update stress last).
    Usl,
    /// Those that the particles of the end of the step give back to the nodes (modified update stress last).
    Musl,
}

impl UpdateChoice {
    /// The usual choice stays out of the record of a scene.
    pub fn is_default(&self) -> bool {
        *self == Self::Usl
    }
}

/// What of a particle is strained and stressed, where that is taken at one place of a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DomainChoice {
    /// A point: with the cell that it lies in.
    #[default]
    Point,
    /// A box that stretches with the soil: with each cell as far as it lies in it.
    Contiguous,
}

impl DomainChoice {
    /// The usual choice stays out of the record of a scene.
    pub fn is_default(&self) -> bool {
        *self == Self::Point
    }
}

/// Where the surcharge acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoadOn {
    /// The true surface above the top row of particles.
    Surface,
    /// The top row of particles itself (the paper).
    Particles,
    /// A rigid plate without friction on the surface: the whole top settles uniformly.
    Plate,
}

/// How the solid is supported on one side of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolidSide {
    /// No constraint.
    Free,
    /// Normal velocity zero.
    Roller,
    /// All velocity components zero.
    Fixed,
}

/// The four sides of the domain, in the order used by every array over sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// x smallest.
    Left,
    /// x largest.
    Right,
    /// y smallest.
    Bottom,
    /// y largest.
    Top,
}

impl Side {
    /// Left, right, bottom, top.
    pub const ALL: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];
    /// The word used in scene files.
    pub fn word(self) -> &'static str {
        ["left", "right", "bottom", "top"][self as usize]
    }
}

/// Isotropic linear elasticity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Elastic {
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio nu.
    pub poisson_ratio: f64,
}

impl Elastic {
    /// First Lamé constant, Pa.
    pub fn lame(&self) -> f64 {
        let (e, nu) = (self.youngs_modulus, self.poisson_ratio);
        e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    }
    /// Shear modulus G, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))
    }
    /// Oedometer (constrained) modulus M = E(1-nu)/((1+nu)(1-2nu)), Pa.
    pub fn oedometer_modulus(&self) -> f64 {
        let (e, nu) = (self.youngs_modulus, self.poisson_ratio);
        e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    }
}

/// Strength of a Mohr-Coulomb soil.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Strength {
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Angle of friction phi, degrees.
    pub friction_angle: f64,
    /// Angle of dilation psi, degrees.
    pub dilation_angle: f64,
    /// Largest principal stress sigma_t, Pa; `None` leaves the apex.
    pub tension_cutoff: Option<f64>,
    /// Plastic shear strain over which the flow goes from associated to that dilation, at a constant strength in simple shear:
    /// that of Davis. `None` flows with the dilation from the start.
    pub dilation_fades_over: Option<f64>,
}

impl Strength {
    /// The isotropic tension at the apex, c/tan(phi), Pa.
    pub fn apex(&self) -> f64 {
        self.cohesion / self.friction_angle.to_radians().tan()
    }

    /// The strength divided by a factor F: c/F, tan(phi)/F, and a dilation by the rule of the reduction. The cut-off stays.
    #[must_use]
    pub fn reduced(&self, factor: f64, by: Reduction) -> Self {
        let over = |angle: f64| (angle.to_radians().tan() / factor).atan();
        let (friction, dilation) = (over(self.friction_angle), over(self.dilation_angle));
        let dilation_fades_over = self.dilation_fades_over.filter(|_| by == Reduction::AsGiven);
        let of = |share: f64, friction: f64, dilation: f64| Self {
            dilation_fades_over,
            cohesion: share * self.cohesion / factor,
            friction_angle: friction.to_degrees(),
            dilation_angle: dilation.to_degrees(),
            tension_cutoff: self.tension_cutoff,
        };
        match by {
            Reduction::AsGiven => of(1.0, friction, dilation),
            Reduction::Associated => of(1.0, friction, friction),
            Reduction::Davis => {
                let share = dilation.cos() * friction.cos() / (1.0 - dilation.sin() * friction.sin());
                let friction = (share * friction.tan()).atan();
                of(share, friction, friction)
            }
        }
    }
}

/// Which flow rule goes with a strength that is divided by a factor of safety F.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// That of the scene, tan(psi)/F. Where it is not associated the mesh selects a strength between the other two.
    #[default]
    AsGiven,
    /// psi = phi: what limit analysis and limit equilibrium assume; the upper end.
    Associated,
    /// Davis B: an associated flow with the strength that a soil with this dilation has in simple shear, c* = beta c/F and
    /// tan(phi*) = beta tan(phi)/F with beta = cos(psi_F) cos(phi_F)/(1 - sin(psi_F) sin(phi_F)) of the reduced angles (Davis 1968;
    /// Tschuchnigg, Schweiger & Sloan 2015, doi:10.1016/j.compgeo.2015.06.003); the lower end.
    Davis,
}

/// A modified Cam-Clay soil ([`crate::constitutive::ModifiedCamClay`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CamClay {
    /// Slope lambda of isotropic compression, logarithmic strain over ln p.
    pub lambda: f64,
    /// Slope kappa of swelling.
    pub kappa: f64,
    /// Poisson's ratio nu.
    pub poisson_ratio: f64,
    /// Bulk modulus, where it is constant, Pa; else p/kappa.
    pub bulk_modulus: Option<f64>,
    /// q/p at critical state, M.
    pub critical_slope: f64,
    /// Preconsolidation pressure p_c at t = 0, at least, Pa.
    pub preconsolidation: f64,
    /// p_c over the one that the stress at t = 0 needs.
    pub overconsolidation: f64,
    /// Isotropic tension that cementation bears, Pa.
    pub attraction: f64,
}

/// Pore water.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WaterProperties {
    /// Hydraulic conductivity k, m/s, the vertical one where there are two.
    pub hydraulic_conductivity: f64,
    /// Hydraulic conductivity along the bedding over that across it, which is k.
    #[serde(skip_serializing_if = "soils::is_one")]
    pub anisotropy: f64,
    /// What else that depends on.
    #[serde(flatten)]
    pub fabric: Fabric,
    /// Bulk modulus K_w, Pa; infinite for incompressible water (implicit integrators only).
    pub bulk_modulus: f64,
    /// Unit weight gamma_w, N/m3.
    pub unit_weight: f64,
    /// Density rho_w, kg/m3.
    pub density: f64,
}

impl WaterProperties {
    /// Mobility k / gamma_w, m4/(N s).
    pub fn mobility(&self) -> f64 {
        self.hydraulic_conductivity / self.unit_weight
    }

    /// The larger one of those along the axes, m4/(N s).
    pub fn largest_mobility(&self) -> f64 {
        self.anisotropy.max(1.0) * self.mobility()
    }
}

/// How the time step is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepChoice {
    /// The stability limit of the operators in use, times the safety factor.
    Auto,
    /// A given step, s.
    Fixed(f64),
    /// The paper's 1.0e-7 s.
    Paper,
}

/// gamma of the jump penalty, and that of columns observed when pressures are smooth.
const JUMP_PENALTY: f64 = 1e-3;
const JUMP_PENALTY_LATE: f64 = 1e-4;
/// Time as `c_v t/L^2` before which a drained end is a jump to the mesh. At 0.05 a column with the smaller factor swings by
/// 0.3 %.
const EARLY: f64 = 0.05;

/// The paper's time increment (Table 1), s.
pub const PAPER_STEP: f64 = 1.0e-7;

/// When a stage ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// A time since the start of the stage, s.
    Time(f64),
    /// The pore pressure stays within a relative tolerance of its undrained mean, [`Fields::undrained_mean_pressure`],
    /// for a period of the undrained wave, 4 H/c_u.
    PorePressure {
        /// Relative tolerance.
        within: f64,
        /// In every cell, instead of on average over the column.
        everywhere: bool,
        /// Give up after this time, s.
        at_most: f64,
    },
    /// No node has moved faster than this for some time.
    Rest {
        /// Largest speed of a node, m/s.
        speed: f64,
        /// Give up after this time, s.
        at_most: f64,
    },
}

/// A part of the run with its own drainage and damping.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// A name for reports.
    pub name: String,
    /// Which sides let water out at zero pressure: left, right, bottom, top.
    pub drained: [bool; 4],
    /// Supports of the solid on each side during it, left, right, bottom, top; `None` for as [`Fields::solid_sides`] say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid_sides: Option<[SolidSide; 4]>,
    /// Mass-proportional damping rate, 1/s. Zero for none.
    pub damping: f64,
    /// What the stage moves where water has a free surface.
    #[serde(skip_serializing_if = "Coupling::is_default")]
    pub coupling: Coupling,
    /// When it ends.
    pub until: Until,
}

/// A load on the top of the column.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Surcharge {
    /// Final pressure q, Pa, positive downwards.
    pub pressure: f64,
    /// What carries it.
    pub on: LoadOn,
    /// Time over which it grows linearly from zero, s. Zero for a step load.
    pub ramp_time: f64,
    /// The part of the top that carries it; `None` for all of it.
    pub strip: Option<LoadedStrip>,
}

impl Surcharge {
    /// The load at a time (s), Pa.
    #[inline(always)]
    pub fn at(&self, time: f64) -> f64 {
        if time < self.ramp_time { self.pressure * time / self.ramp_time } else { self.pressure }
    }
}

/// A scene that was checked: every number is finite, in range and consistent with the others. [`Fields`] say what it is; the
/// checker alone makes them a scene, and [`Scene::patched`] and [`Scene::edited`] change one through it.
#[derive(Clone)]
pub struct Scene {
    fields: Fields,
    /// What it was made from.
    source: Arc<Source>,
    warnings: Vec<Warning>,
}

impl Deref for Scene {
    type Target = Fields;

    fn deref(&self) -> &Fields {
        &self.fields
    }
}

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        self.fields == other.fields
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fields.fmt(f)
    }
}

impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.fields.serialize(serializer)
    }
}

/// What a scene says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fields {
    /// A name for reports.
    pub name: String,
    /// One dimension or two.
    pub dimension: Dimension,
    /// State at t = 0.
    pub start: Start,
    /// Velocity of the soil at t = 0, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_velocity: Option<[f64; 2]>,
    /// Lateral over vertical effective stress of a geostatic start; `None` for that of no lateral strain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_k0: Option<f64>,
    /// Pore pressure and stress at t = 0 that the scene gives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial: Option<Initial>,
    /// Gravity, m/s2, downwards; `None` switches the term off.
    pub gravity: Option<f64>,
    /// Angle of the base to the horizontal, degrees: gravity then points towards (sin, -cos), x downslope.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_angle: Option<f64>,
    /// Horizontal acceleration of an earthquake, as a share of gravity: a force on the soil towards +x; `None` for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seismic_coefficient: Option<f64>,
    /// Height of the column, m; that of the outline's highest point.
    pub height: f64,
    /// Width of the column, m; x of the outline's last point.
    pub width: f64,
    /// Distance of x = 0 from the axis of an axisymmetric scene, m.
    #[serde(skip_serializing_if = "f64_is_zero")]
    pub inner_radius: f64,
    /// Corners of the soil, m, anticlockwise; `None` for a column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outline: Option<Vec<[f64; 2]>>,
    /// How particles are cut by the outline.
    #[serde(skip_serializing_if = "SeedingChoice::is_default")]
    pub seeding: SeedingChoice,
    /// Edge of the square cells L, m.
    pub cell: f64,
    /// Cells over the height and over the width of the soil.
    pub cells: [usize; 2],
    /// Rows of empty cells above the soil.
    pub empty_cells_above: usize,
    /// Columns of empty cells right of the soil.
    #[serde(skip_serializing_if = "none")]
    pub empty_cells_beside: usize,
    /// Particles per cell and layer in plane strain: 1, 4, 9, ...; the column uses the square root.
    pub particles_per_cell: usize,
    /// The mesh starts this share of a cell below and left of the soil, 0 <= s < 1.
    pub shift: f64,
    /// Particles that do not stand evenly.
    pub displaced: Option<Displaced>,
    /// Whether the geometry follows the deformation.
    pub strain: StrainChoice,
    /// Elasticity of the skeleton; layers may have their own.
    pub elastic: Elastic,
    /// Layers from the base up, the last one up to the height; empty where the soil is the same all over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<SoilLayer>,
    /// Parts with a soil of their own, the last one over those before it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<Region>,
    /// Its strength, where the law is Mohr-Coulomb; an elastic skeleton has no limit.
    pub strength: Option<Strength>,
    /// Its hardening, where the law is modified Cam-Clay; [`Self::elastic`] is then that of the largest pressure expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cam_clay: Option<CamClay>,
    /// Volumetric strain beyond which soil has a tension gap and no stress until the gap has closed; `None` without gaps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separation: Option<f64>,
    /// Density of the grains, kg/m3.
    pub grain_density: f64,
    /// Porosity n.
    pub porosity: f64,
    /// Grains that compress; `None` for those that do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub biot: Option<Biot>,
    /// Pore water, or `None` for a dry scene.
    pub water: Option<WaterProperties>,
    /// Where the water is, if it has a free surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_surface: Option<FreeSurfaceWater>,
    /// How a stage in which water may make the soil fail is followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<Failure>,
    /// Constraint of the solid on each side: left, right, bottom, top.
    pub solid_sides: [SolidSide; 4],
    /// What leaves the mesh at one side comes in at the other.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub periodic: bool,
    /// Friction on the base; `None` where the bottom is fixed as `solid_sides` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
    /// Load on the top.
    pub surcharge: Option<Surcharge>,
    /// Loads on other faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<FaceLoad>,
    /// Plates that are moved as given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plates: Vec<MovedPlate>,
    /// Wells.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wells: Vec<Well>,
    /// How time is integrated.
    pub integrator: Integrator,
    /// How quasi-static time steps are made.
    pub method: TimeMethod,
    /// What the implicit integrator does with waves.
    pub waves: Waves,
    /// Largest error in time of settlement and pressure, relative; of integrators that solve for displacements.
    pub tolerance: f64,
    /// Volumes that particles stand for in integrals over a cell.
    pub quadrature: Quadrature,
    /// gamma of the jump penalty on dp/dt, B-splines of integrators that solve for displacements; `None` for [`Fields::usual_jump_penalty`].
    pub jump_penalty: Option<f64>,
    /// Where shape functions are evaluated.
    pub shape: ShapeChoice,
    /// Darcy operator.
    pub darcy: DarcyChoice,
    /// Keep `rho_w a_s` in Darcy's law, as the paper's Eq. (1) does.
    pub darcy_inertia: bool,
    /// Keep the acceleration of the water relative to the soil (the full u-w model); `implicit` only.
    pub relative_acceleration: bool,
    /// FLIP share of the velocity update: 1 is FLIP, 0 is PIC.
    pub flip: f64,
    /// What a particle gives to a node.
    #[serde(skip_serializing_if = "TransferChoice::is_default")]
    pub transfer: TransferChoice,
    /// Strain over which the null-space filter takes differences between the stresses of the particles of a cell to 1/e, -.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub null_space_strain: Option<f64>,
    /// What of a particle is strained and stressed.
    #[serde(skip_serializing_if = "DomainChoice::is_default")]
    pub particle_domain: DomainChoice,
    /// Which velocities strain the soil.
    #[serde(skip_serializing_if = "UpdateChoice::is_default")]
    pub update: UpdateChoice,
    /// Nodes with less than this share of a full node's mass move with a heavier neighbour; 0 for none.
    #[serde(skip_serializing_if = "f64_is_zero")]
    pub light_nodes: f64,
    /// Time step.
    pub step: StepChoice,
    /// Factor on the stability limit for [`StepChoice::Auto`].
    pub safety: f64,
    /// Run even above the stability limit.
    pub force: bool,
    /// Stages in order; there is at least one.
    pub stages: Vec<Stage>,
    /// Times since the start of the last stage at which to observe, s, ascending; always hit exactly.
    pub observe_times: Vec<f64>,
    /// Number of further, logarithmically spaced observations of the last stage.
    pub history: usize,
    /// Keep profiles over the height at the observed times.
    pub profiles: bool,
    /// Keys of the file that the integrator of the command line has no use for.
    pub left_out: Vec<String>,
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`LoadError`] with file, line, what was expected and what was found.
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        Self::load_with(path, &Flags::default())
    }

    /// Reads and checks a scene file with some of its keys replaced, as if they stood in the file.
    ///
    /// # Errors
    /// As [`Scene::load`]; a refused flag is named in place of file, line and key.
    pub fn load_with(path: &Path, flags: &Flags) -> Result<Self, LoadError> {
        let text = read_text(path, LARGEST_FILE)
            .map_err(|source| LoadError::Unreadable { path: path.to_path_buf(), source })?;
        Ok(Self::parse_with(&text, &path.display().to_string(), flags)?)
    }

    /// Checks the text of a scene file; `file` is only used in messages.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line.
    pub fn parse(text: &str, file: &str) -> Result<Self, SceneError> {
        Self::parse_with(text, file, &Flags::default())
    }

    /// Checks the text of a scene file with some of its keys replaced.
    ///
    /// # Errors
    /// As [`Scene::parse`]; a refused flag is named in place of file, line and key.
    pub fn parse_with(text: &str, file: &str, flags: &Flags) -> Result<Self, SceneError> {
        let mut source = Source { text: text.into(), file: Some(file.into()), edits: Vec::new() };
        let (edits, left_out) = source.flagged(flags)?;
        source.edits = edits;
        let mut scene = Self::checked(&Arc::new(source))?;
        scene.fields.left_out = left_out;
        Ok(scene)
    }

    /// What the author of the file should see, in the order of its lines: names of an earlier version.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// The scene of a file and what was changed of it. Values at the edge of what a number can hold make steps of no length or runs
    /// without end, which only the limit of the step tells.
    fn checked(source: &Arc<Source>) -> Result<Self, SceneError> {
        let (scene, stages) = check::check(source)?;
        let (time, step) = (scene.longest_time(), intended_step(&scene, stable_limit(&scene)));
        let steps = time / step;
        if steps.is_finite() && steps <= STEP_LIMIT {
            return Ok(scene);
        }
        let found = format!("{time:.3e} s in steps of {step:.3e} s");
        check::refused(source, &stages, "stages.until", &format!("a run of at most {STEP_LIMIT:.0e} steps"), found)
    }
}

impl Fields {
    /// Time that all stages take at most, s.
    fn longest_time(&self) -> f64 {
        let longest = |stage: &Stage| match stage.until {
            Until::Time(time) => time,
            Until::PorePressure { at_most, .. } | Until::Rest { at_most, .. } => at_most,
        };
        self.stages.iter().map(longest).sum()
    }

    /// Supports of the solid on each side, in every stage.
    pub fn supports(&self) -> impl Iterator<Item = [SolidSide; 4]> {
        let own = self.stages.iter().map(|stage| stage.solid_sides.unwrap_or(self.solid_sides));
        std::iter::once(self.solid_sides).chain(own)
    }

    /// Whether a side has this support in every stage.
    pub fn always(&self, side: Side, held: SolidSide) -> bool {
        self.supports().all(|sides| sides[side as usize] == held)
    }

    /// Density of the dry skeleton, (1 - n) rho_s, kg/m3.
    pub fn dry_density(&self) -> f64 {
        (1.0 - self.porosity) * self.grain_density
    }

    /// Whether the soil is linear elastic: it neither yields nor remembers.
    pub fn is_elastic(&self) -> bool {
        let elastic = |soil: &Soil| soil.strength.is_none() && soil.cam_clay.is_none();
        elastic(&self.soil()) && self.each_soil().all(|soil| elastic(&soil))
    }

    /// Density of the mixture, kg/m3: (1 - n) rho_s + n rho_w, or the dry density without water.
    pub fn mixture_density(&self) -> f64 {
        self.mixture_density_of(&self.soil())
    }

    /// That of a soil, kg/m3.
    pub fn mixture_density_of(&self, soil: &Soil) -> f64 {
        soil.dry_density() + self.water.map_or(0.0, |w| soil.porosity * w.density)
    }

    /// Oedometer modulus M of the soil of the scene, Pa.
    pub fn oedometer_modulus(&self) -> f64 {
        self.elastic.oedometer_modulus()
    }

    /// What undrained water adds to the stiffness against a change of volume, alpha^2 Q with Q = K_w/n where grains do not compress,
    /// Pa; zero without water.
    pub fn pore_stiffness(&self) -> f64 {
        self.pore_stiffness_of(&self.soil())
    }

    /// That of a soil, Pa.
    pub fn pore_stiffness_of(&self, soil: &Soil) -> f64 {
        let Some(water) = self.water else { return 0.0 };
        match soil.biot {
            None => water.bulk_modulus / soil.porosity,
            Some(_) => soil.alpha().powi(2) / (soil.porosity / water.bulk_modulus + soil.grain_storage()),
        }
    }

    /// Share of a vertical load that the water carries undrained in the soil of the scene, Q/(M + Q): alpha p_0.
    pub fn undrained_share(&self) -> f64 {
        self.undrained_share_in(&self.soil())
    }

    /// The same in a soil.
    fn undrained_share_in(&self, soil: &Soil) -> f64 {
        let (m, q) = (soil.elastic.oedometer_modulus(), self.pore_stiffness_of(soil));
        if q.is_finite() { q / (m + q) } else { 1.0 }
    }

    /// Whether `rho_w a_s` in Darcy's law makes every wave grow by itself: where the water carries a smaller share of a load,
    /// Q/(M + Q), than of the weight, rho_w/rho.
    ///
    /// With D = k Q/gamma_w a wave of the u-p model has `s^3 + D k^2 (1 - rho_w/rho) s^2 + k^2 (M + Q)/rho s + M D k^4/rho`; by
    /// Routh's criterion it decays if `(1 - rho_w/rho) (M + Q) > M`. It is the model that grows, on any mesh and with any step.
    pub fn inertia_feeds_waves(&self) -> bool {
        let share = self.water.map_or(0.0, |w| w.density / self.mixture_density());
        let closed = self.water.is_some() && self.free_surface.is_none();
        closed && !self.relative_acceleration && self.undrained_share() < share
    }

    /// Undrained pore pressure under the surcharge in the soil of the scene, p_0 = q Q/(M + Q)/alpha, Pa.
    pub fn undrained_pressure(&self) -> f64 {
        self.surcharge.map_or(0.0, |s| s.pressure * self.undrained_share() / self.soil().alpha())
    }

    /// gamma of the jump penalty where the scene does not say it, -.
    ///
    /// With 1e-3 the undrained limit is stable on any mesh, and Mandel's problem loses nothing. A closed column needs a tenth
    /// of that for the one pressure that no displacement feels; more would cost 4e-6 of the settlement at Tv = 0.01 and L =
    /// 0.05 m instead of 3e-7. A column that is observed before its pressure has gone far into the first cell swings like
    /// any other undrained soil: by 26 % of p_0 with 1e-4 and by 3 % with 1e-3. Cubic B-splines need a tenth: under an undrained
    /// strip load pressures are nearest to the sum of cosines with 1e-4, on 14 to 40 cells, and Mandel's problem has order 4.
    pub fn usual_jump_penalty(&self) -> f64 {
        let first = self.observe_times.first().copied().unwrap_or(f64::INFINITY);
        let diffusivity = self.water.map_or(0.0, |w| w.mobility()) * self.oedometer_modulus();
        let early = diffusivity * first < EARLY * self.cell * self.cell;
        let quadratic = if self.dimension == Dimension::Column && !early { JUMP_PENALTY_LATE } else { JUMP_PENALTY };
        quadratic * 0.1_f64.powi(self.shape.spline_degree().map_or(0, |degree| degree as i32 - 2))
    }

    /// Undrained pore pressure averaged over the column, Pa.
    ///
    /// A load on the top row of particles misses the soil above them: half a spacing, L/(2 m) of the height H with m
    /// particles per direction.
    pub fn undrained_mean_pressure(&self) -> f64 {
        let missed = match self.surcharge {
            Some(Surcharge { on: LoadOn::Particles, .. }) => 0.5 * self.cell / self.particles_per_direction() as f64,
            _ => 0.0,
        };
        self.undrained_pressure() * (1.0 - missed / self.height)
    }

    /// Drainage path H_d of the last stage, m: the height, or half of it with both ends drained; the width or half of
    /// it if left and right drain; the shorter one if both directions do.
    pub fn drainage_path(&self) -> f64 {
        let drained = self.stages[self.stages.len() - 1].drained;
        let along = |length: f64, ends: [Side; 2]| match ends.map(|side| drained[side as usize]) {
            [true, true] => 0.5 * length,
            [false, false] => f64::INFINITY,
            _ => length,
        };
        let path = along(self.height, [Side::Bottom, Side::Top]).min(along(self.width, [Side::Left, Side::Right]));
        if path.is_finite() { path } else { self.height }
    }

    /// Whether water fills the pores of soil whose left and right are the same place.
    pub fn has_periodic_pores(&self) -> bool {
        self.periodic && self.water.is_some() && self.free_surface.is_none()
    }

    /// Whether soil and water move vertically only: nothing free sideways, one load all over, no drained side wall.
    pub fn is_one_dimensional(&self) -> bool {
        let walls = [Side::Left as usize, Side::Right as usize];
        let on_rollers = [Side::Left, Side::Right].iter().all(|side| self.always(*side, SolidSide::Roller));
        let smooth = on_rollers && self.is_level_column();
        let uniform = self.regions.is_empty() || self.dimension == Dimension::Column;
        let tight = !self.stages.iter().any(|stage| walls.iter().any(|i| stage.drained[*i]));
        let even = self.loads.is_empty() && self.plates.is_empty() && self.wells.is_empty();
        let even = even || self.dimension == Dimension::Column;
        smooth && uniform && even && tight && self.surcharge.is_none_or(|s| s.strip.is_none())
    }

    /// Whether it is such a column of one soil or of layers, under a surcharge or its weight alone.
    pub fn is_plain_column(&self) -> bool {
        self.is_one_dimensional() && self.has_plain_ground()
    }

    /// Whether there are no regions, no wells, no loads or plates beside the surcharge, no given state, and a conductivity that stays and has
    /// its axes upright.
    pub fn has_plain_ground(&self) -> bool {
        let plain = self.initial.is_none() && self.soils().iter().all(|soil| soil.fabric == Fabric::default());
        plain && self.regions.is_empty() && self.loads.is_empty() && self.plates.is_empty() && self.wells.is_empty()
    }

    /// Seconds per unit of the time factor Tv = c_v t / H_d^2 with c_v = k M / gamma_w (incompressible water) of the
    /// soil and the water of the scene, whatever its layers are.
    pub fn time_per_factor(&self) -> Option<f64> {
        let water = self.water?;
        let c_v = water.mobility() * self.oedometer_modulus();
        Some(self.drainage_path().powi(2) / c_v)
    }

    /// As [`Grid::axis`](crate::grid::Grid::axis).
    pub fn axis(&self) -> Option<f64> {
        (self.dimension == Dimension::Axisymmetric).then_some(self.inner_radius)
    }

    /// As [`Grid::thickness`](crate::grid::Grid::thickness).
    pub fn thickness(&self, x: f64) -> f64 {
        self.axis().map_or(1.0, |axis| axis + x)
    }

    /// Particles per cell along one direction.
    pub fn particles_per_direction(&self) -> usize {
        (self.particles_per_cell as f64).sqrt().round() as usize
    }

    /// Number of solid particles (equal to that of water particles in a saturated scene); about that with an outline.
    pub fn solid_particles(&self) -> usize {
        if let Some(outline) = &self.outline {
            let spacing = self.cell / self.particles_per_direction() as f64;
            return (crate::seeding::area(outline) / (spacing * spacing)).ceil() as usize;
        }
        let across = match self.dimension {
            Dimension::Column => 1,
            _ => self.cells[0] * self.particles_per_direction(),
        };
        across * self.cells[1] * self.particles_per_direction()
    }

    /// Whether the scene, on a mesh that need not be that of its file, fits into the memory that a run may take.
    ///
    /// # Errors
    /// What was expected, and what was found.
    pub fn fits_in_memory(&self) -> Result<(), [String; 2]> {
        let across = if self.dimension == Dimension::Column { 1.0 } else { self.cells[0] as f64 };
        let (rows, direction) = (self.cells[1] as f64, self.particles_per_direction() as f64);
        let points = rows * direction * if self.dimension == Dimension::Column { 1.0 } else { across * direction };
        let cells = (rows + self.empty_cells_above as f64) * (across + self.empty_cells_beside as f64);
        check::fits_in_memory(points, cells, self.integrator.solves_displacements(), self.dimension)
    }
}

/// Keys that most scenes do not have stay out of the record of a scene.
fn none(count: &usize) -> bool {
    *count == 0
}

fn f64_is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// More steps than this are a mistake in the scene: a century of computing.
const STEP_LIMIT: f64 = 1e14;
/// No scene file is larger, bytes.
pub const LARGEST_FILE: u64 = 4 << 20;

/// The text of a file of at most `largest` bytes. A device, a socket or a pipe may never end, or never begin: none is opened.
///
/// # Errors
/// What is there in its place.
pub fn read_text(path: &Path, largest: u64) -> io::Result<String> {
    if !path.metadata()?.is_file() {
        return Err(io::Error::other("no regular file"));
    }
    let mut text = String::new();
    File::open(path)?.take(largest + 1).read_to_string(&mut text)?;
    if text.len() as u64 > largest {
        return Err(io::Error::other(format!("more than {largest} bytes")));
    }
    Ok(text)
}
