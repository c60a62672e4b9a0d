//! What to simulate. A scene file is read in two types: `raw` holds what the user wrote and where, [`Scene`]
//! what was understood and found possible. Every default, unit and bound of the program is in this room.

mod check;
mod raw;

use std::fmt;
use std::path::Path;

use serde::Serialize;

use crate::error::{LoadError, SceneError};

/// One spatial dimension or two. The same scene runs in both and gives the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dimension {
    /// One dimension, vertical; the width only scales areas.
    Column,
    /// Two dimensions, plane strain, 1 m thick.
    PlaneStrain,
}

/// The state at t = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// No stress, no pore pressure: the load is applied in the first stage (the paper).
    Unloaded,
    /// Load carried without drainage: `p_0 = q Q/(M + Q)`, effective stress `q - p_0`, at rest.
    UndrainedEquilibrium,
    /// At rest under gravity: hydrostatic pore pressure, effective stress from the buoyant weight.
    Geostatic,
}

/// Where shape functions are evaluated for stress, pore pressure and strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeChoice {
    /// At the centre of the cell: the paper's stabilisation, section 2.2.
    Centre,
    /// At the particle: the standard linear MPM.
    Linear,
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

/// What carries the surcharge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoadOn {
    /// The true surface above the top row of particles.
    Surface,
    /// The top row of particles itself (the paper).
    Particles,
}

/// How the velocity of the solid is held on one side of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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

/// Pore water.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WaterProperties {
    /// Hydraulic conductivity k, m/s.
    pub hydraulic_conductivity: f64,
    /// Bulk modulus K_w, Pa.
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

/// The paper's time increment (Table 1), s.
pub const PAPER_STEP: f64 = 1.0e-7;

/// When a stage ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// A time since the start of the stage, s.
    Time(f64),
    /// The pore pressure stays within a relative tolerance of its undrained mean, [`Scene::undrained_mean_pressure`],
    /// for a period of the undrained wave, 4 H/c_u.
    PorePressure {
        /// Relative tolerance.
        within: f64,
        /// In every cell, instead of on average over the column.
        everywhere: bool,
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
    /// Mass-proportional damping rate, 1/s. Zero for none.
    pub damping: f64,
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
}

/// A scene that was checked: every number is finite, in range and consistent with the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// A name for reports.
    pub name: String,
    /// One dimension or two.
    pub dimension: Dimension,
    /// State at t = 0.
    pub start: Start,
    /// Gravity, m/s2, downwards; `None` switches the term off.
    pub gravity: Option<f64>,
    /// Height of the column, m.
    pub height: f64,
    /// Width of the column, m.
    pub width: f64,
    /// Edge of the square cells L, m.
    pub cell: f64,
    /// Cells over the height and over the width of the soil.
    pub cells: [usize; 2],
    /// Rows of empty cells above the soil.
    pub headroom_cells: usize,
    /// Particles per cell and layer in plane strain: 1, 4, 9, ...; the column uses the square root.
    pub particles_per_cell: usize,
    /// Constitutive law of the skeleton.
    pub elastic: Elastic,
    /// Density of the grains, kg/m3.
    pub grain_density: f64,
    /// Porosity n.
    pub porosity: f64,
    /// Pore water, or `None` for a dry scene.
    pub water: Option<WaterProperties>,
    /// Constraint of the solid on each side: left, right, bottom, top.
    pub solid_sides: [SolidSide; 4],
    /// Load on the top.
    pub surcharge: Option<Surcharge>,
    /// Where shape functions are evaluated.
    pub shape: ShapeChoice,
    /// Darcy operator.
    pub darcy: DarcyChoice,
    /// Keep `rho_w a_s` in Darcy's law, as the paper's Eq. (1) does.
    pub darcy_inertia: bool,
    /// FLIP share of the velocity update: 1 is FLIP, 0 is PIC.
    pub flip: f64,
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
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// [`LoadError`] with file, line, what was expected and what was found.
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| LoadError::Unreadable { path: path.to_path_buf(), source })?;
        Ok(Self::parse(&text, &path.display().to_string())?)
    }

    /// Checks the text of a scene file; `file` is only used in messages.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line.
    pub fn parse(text: &str, file: &str) -> Result<Self, SceneError> {
        check::check(text, file)
    }

    /// Density of the dry skeleton, (1 - n) rho_s, kg/m3.
    pub fn dry_density(&self) -> f64 {
        (1.0 - self.porosity) * self.grain_density
    }

    /// Density of the mixture, kg/m3: (1 - n) rho_s + n rho_w, or the dry density without water.
    pub fn mixture_density(&self) -> f64 {
        self.dry_density() + self.water.map_or(0.0, |w| self.porosity * w.density)
    }

    /// Oedometer modulus M, Pa.
    pub fn oedometer_modulus(&self) -> f64 {
        self.elastic.oedometer_modulus()
    }

    /// Stiffness of the pore water Q = K_w / n, Pa; zero without water.
    pub fn pore_stiffness(&self) -> f64 {
        self.water.map_or(0.0, |w| w.bulk_modulus / self.porosity)
    }

    /// Undrained pore pressure under the surcharge, p_0 = q Q/(M + Q), Pa.
    pub fn undrained_pressure(&self) -> f64 {
        let (m, q) = (self.oedometer_modulus(), self.pore_stiffness());
        self.surcharge.map_or(0.0, |s| s.pressure * q / (m + q))
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

    /// Drainage path H_d of the last stage, m: the height, or half of it with both ends drained.
    pub fn drainage_path(&self) -> f64 {
        let drained = self.stages[self.stages.len() - 1].drained;
        if drained[Side::Bottom as usize] && drained[Side::Top as usize] { 0.5 * self.height } else { self.height }
    }

    /// Seconds per unit of the time factor Tv = c_v t / H_d^2 with c_v = k M / gamma_w (incompressible water).
    pub fn time_per_factor(&self) -> Option<f64> {
        let water = self.water?;
        let c_v = water.mobility() * self.oedometer_modulus();
        Some(self.drainage_path().powi(2) / c_v)
    }

    /// Particles per cell along one direction.
    pub fn particles_per_direction(&self) -> usize {
        (self.particles_per_cell as f64).sqrt().round() as usize
    }

    /// Number of solid particles (equal to that of water particles in a saturated scene).
    pub fn solid_particles(&self) -> usize {
        let across = match self.dimension {
            Dimension::Column => 1,
            Dimension::PlaneStrain => self.cells[0] * self.particles_per_direction(),
        };
        across * self.cells[1] * self.particles_per_direction()
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}
