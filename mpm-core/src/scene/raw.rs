//! The scene file as written: TOML with the place of every value, nothing checked yet.
//!
//! Each field is documented in `reference-data/scenes/README.md`, where the defaults stand beside the units.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::{Spanned, Value};

type Number = Spanned<f64>;
type Word = Spanned<String>;
pub(super) type Pairs = Spanned<Vec<Spanned<[f64; 2]>>>;
pub(super) type Points = Spanned<Vec<Spanned<Vec<f64>>>>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    pub name: Word,
    pub dimension: Option<Word>,
    pub start: Option<Word>,
    pub start_velocity: Option<Spanned<Vec<f64>>>,
    pub start_k0: Option<Number>,
    pub initial: Option<Spanned<BTreeMap<String, Spanned<Value>>>>,
    pub gravity: Option<Number>,
    pub slope_angle: Option<Number>,
    pub seismic_coefficient: Option<Number>,
    pub geometry: Spanned<RawGeometry>,
    pub mesh: Spanned<RawMesh>,
    pub soil: Spanned<RawSoil>,
    pub layers: Option<Spanned<Vec<Spanned<RawZone>>>>,
    pub regions: Option<Spanned<Vec<Spanned<RawZone>>>>,
    pub water: Option<Spanned<RawWater>>,
    pub boundaries: Option<Spanned<RawBoundaries>>,
    pub base: Option<Spanned<RawBase>>,
    pub surcharge: Option<Spanned<RawSurcharge>>,
    pub loads: Option<Spanned<Vec<Spanned<RawLoad>>>>,
    pub reservoirs: Option<Spanned<Vec<Spanned<RawReservoir>>>>,
    pub plates: Option<Spanned<Vec<Spanned<RawPlate>>>>,
    pub wells: Option<Spanned<Vec<Spanned<RawWell>>>>,
    pub scheme: Option<Spanned<RawScheme>>,
    pub time: Option<Spanned<RawTime>>,
    pub stages: Spanned<Vec<Spanned<RawStage>>>,
    pub failure: Option<Spanned<RawFailure>>,
    pub observe: Option<Spanned<RawObserve>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum RawGeometry {
    Column(RawColumn),
    Outline(RawOutline),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawColumn {
    pub height: Number,
    pub width: Number,
    pub inner_radius: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutline {
    pub points: Points,
    pub inner_radius: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMesh {
    pub cell: Number,
    pub particles_per_cell: Spanned<i64>,
    pub empty_cells_above: Option<Spanned<i64>>,
    pub empty_cells_beside: Option<Spanned<i64>>,
    pub seeding: Option<Word>,
    pub shift: Option<Number>,
    pub displaced: Option<Spanned<RawDisplaced>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDisplaced {
    pub smooth: Option<Number>,
    pub jitter: Option<Number>,
    pub seed: Option<Spanned<i64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSoil {
    pub law: Spanned<RawLaw>,
    pub grain_density: Option<Number>,
    pub bulk_density: Option<Number>,
    pub porosity: Number,
    pub biot_coefficient: Option<Number>,
    pub grain_bulk_modulus: Option<Number>,
    pub separation: Option<Number>,
    pub strain: Option<Word>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum RawLaw {
    LinearElastic(RawLinearElastic),
    MohrCoulomb(RawMohrCoulomb),
    ModifiedCamClay(RawCamClay),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLinearElastic {
    pub youngs_modulus: Number,
    pub poisson_ratio: Number,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMohrCoulomb {
    pub youngs_modulus: Number,
    pub poisson_ratio: Number,
    pub cohesion: Number,
    pub friction_angle: Number,
    pub dilation_angle: Option<Number>,
    pub dilation_fades_over: Option<Number>,
    pub tension_cutoff: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamClay {
    pub lambda: Number,
    pub kappa: Number,
    pub poisson_ratio: Number,
    pub bulk_modulus: Option<Number>,
    pub critical_slope: Number,
    pub preconsolidation: Option<Number>,
    pub overconsolidation: Option<Number>,
    pub attraction: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawZone {
    pub up_to: Option<Number>,
    pub polygon: Option<Points>,
    pub levels: Option<Spanned<[f64; 2]>>,
    pub law: Option<Spanned<RawLaw>>,
    pub youngs_modulus: Option<Number>,
    pub poisson_ratio: Option<Number>,
    pub grain_density: Option<Number>,
    pub bulk_density: Option<Number>,
    pub porosity: Option<Number>,
    pub biot_coefficient: Option<Number>,
    pub grain_bulk_modulus: Option<Number>,
    pub hydraulic_conductivity: Option<Number>,
    pub anisotropy: Option<Number>,
    pub bedding_angle: Option<Number>,
    pub kozeny_carman: Option<Spanned<bool>>,
    pub start_k0: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWater {
    pub hydraulic_conductivity: Option<Number>,
    pub anisotropy: Option<Number>,
    pub bedding_angle: Option<Number>,
    pub kozeny_carman: Option<Spanned<bool>>,
    pub intrinsic_permeability: Option<Number>,
    pub viscosity: Option<Number>,
    pub bulk_modulus: Number,
    pub unit_weight: Number,
    pub density: Option<Number>,
    pub free_surface: Option<Spanned<RawFreeSurface>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFreeSurface {
    pub saturation: Option<Number>,
    pub level: Option<Number>,
    pub wet: Option<Points>,
    pub suction: Option<Number>,
    pub retention: Option<Spanned<RawRetention>>,
    pub feed: Option<Spanned<RawFeeds>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum RawRetention {
    VanGenuchten { alpha: Number, n: Number, entry: Option<Number> },
    Gardner { alpha: Number },
    BrooksCorey { entry: Number, index: Number },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFeeds {
    pub left: Option<Spanned<RawFeed>>,
    pub right: Option<Spanned<RawFeed>>,
    pub bottom: Option<Spanned<RawFeed>>,
    pub top: Option<Spanned<RawFeed>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFeed {
    pub head: Option<Number>,
    pub heads: Option<Pairs>,
    pub velocity: Option<Number>,
    pub height: Option<Number>,
    pub times: Option<Pairs>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBoundaries {
    pub left: Option<Word>,
    pub right: Option<Word>,
    pub bottom: Option<Word>,
    pub top: Option<Word>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBase {
    pub friction_angle: Option<Number>,
    pub peak_angle: Option<Number>,
    pub residual_angle: Option<Number>,
    pub slip_distance: Option<Number>,
    pub adhesion: Option<Number>,
    pub memory: Option<Number>,
    pub normal_stress: Option<Word>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSurcharge {
    pub pressure: Number,
    pub on: Option<Word>,
    pub ramp_time: Option<Number>,
    pub strip: Option<Spanned<RawStrip>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStrip {
    pub from: Number,
    pub to: Number,
    pub taper: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLoad {
    pub on: Option<Word>,
    pub x: Option<Spanned<[f64; 2]>>,
    pub y: Option<Spanned<[f64; 2]>>,
    pub pressure: Option<Number>,
    pub shear: Option<Number>,
    pub water: Option<bool>,
    pub ramp_time: Option<Number>,
    pub times: Option<Pairs>,
    pub sine: Option<Spanned<RawSine>>,
    pub wave: Option<Spanned<RawWave>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPlate {
    pub on: Option<Word>,
    pub x: Option<Spanned<[f64; 2]>>,
    pub y: Option<Spanned<[f64; 2]>>,
    pub rough: Option<bool>,
    pub displacement: Option<Number>,
    pub velocity: Option<Number>,
    pub ramp_time: Option<Number>,
    pub times: Option<Pairs>,
    pub sine: Option<Spanned<RawSine>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawReservoir {
    pub on: Option<Word>,
    pub x: Option<Spanned<[f64; 2]>>,
    pub y: Option<Spanned<[f64; 2]>>,
    pub level: Option<Number>,
    pub levels: Option<Pairs>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWell {
    pub at: Spanned<Value>,
    pub rate: Number,
    pub ramp_time: Option<Number>,
    pub times: Option<Pairs>,
    pub sine: Option<Spanned<RawSine>>,
}

/// Course in time.
pub(super) struct RawCourse<'a> {
    pub ramp_time: &'a Option<Number>,
    pub times: &'a Option<Pairs>,
    pub sine: &'a Option<Spanned<RawSine>>,
    pub wave: &'a Option<Spanned<RawWave>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSine {
    pub mean: Option<Number>,
    pub amplitude: Option<Number>,
    pub period: Number,
    pub phase: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWave {
    pub length: Number,
    pub period: Number,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScheme {
    pub shape: Option<Word>,
    pub darcy: Option<Word>,
    pub darcy_inertia: Option<Spanned<bool>>,
    pub relative_acceleration: Option<Spanned<bool>>,
    pub flip: Option<Number>,
    pub light_nodes: Option<Number>,
    pub transfer: Option<Word>,
    pub update: Option<Word>,
    pub null_space_strain: Option<Number>,
    pub particle_domain: Option<Word>,
    pub quadrature: Option<Word>,
    pub jump_penalty: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTime {
    pub integrator: Option<Word>,
    pub step: Option<Spanned<Value>>,
    pub safety: Option<Number>,
    pub method: Option<Word>,
    pub waves: Option<Word>,
    pub tolerance: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStage {
    pub name: Option<Word>,
    pub drained: Option<Spanned<Value>>,
    pub boundaries: Option<Spanned<RawBoundaries>>,
    pub damping: Option<Number>,
    pub coupling: Option<Word>,
    pub until: Spanned<RawUntil>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawUntil {
    pub time: Option<Number>,
    pub time_factor: Option<Number>,
    pub pore_pressure_within: Option<Number>,
    pub rest: Option<Spanned<RawRest>>,
    pub everywhere: Option<bool>,
    pub at_most: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRest {
    pub speed: Number,
    pub at_most: Number,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFailure {
    pub starts_at: Option<Number>,
    pub continue_if_unstable: Option<bool>,
    pub continue_after_collapse: Option<bool>,
    pub levels: Option<Spanned<Vec<Number>>>,
    pub points: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawObserve {
    pub time_factors: Option<Spanned<Vec<Number>>>,
    pub times: Option<Spanned<Vec<Number>>>,
    pub history: Option<Spanned<i64>>,
    pub profiles: Option<bool>,
}
