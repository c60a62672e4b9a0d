//! The scene file as written: TOML with the place of every value, nothing checked yet.
//!
//! Each field is documented in `reference-data/scenes/README.md`, where the defaults stand beside the units.

use std::collections::BTreeMap;

use toml::{Spanned, Value};

use super::decode::{kinds, tables};

type Number = Spanned<f64>;
type Word = Spanned<String>;
pub(super) type Pairs = Spanned<Vec<Spanned<[f64; 2]>>>;
pub(super) type Points = Spanned<Vec<Spanned<Vec<f64>>>>;

/// Course in time.
pub(super) struct RawCourse<'a> {
    pub ramp_time: &'a Option<Number>,
    pub times: &'a Option<Pairs>,
    pub sine: &'a Option<Spanned<RawSine>>,
    pub wave: &'a Option<Spanned<RawWave>>,
}

kinds! {
    RawGeometry {
        "column" => Column(RawColumn),
        "outline" => Outline(RawOutline),
    }

    RawLaw {
        "linear_elastic" => LinearElastic(RawLinearElastic),
        "mohr_coulomb" => MohrCoulomb(RawMohrCoulomb),
        "modified_cam_clay" => ModifiedCamClay(RawCamClay),
    }

    RawRetention {
        "van_genuchten" => VanGenuchten(RawVanGenuchten),
        "gardner" => Gardner(RawGardner),
        "brooks_corey" => BrooksCorey(RawBrooksCorey),
    }
}

tables! {
    RawScene {
        name: Word,
        dimension: Option<Word>,
        start: Option<Word>,
        start_velocity: Option<Spanned<Vec<f64>>>,
        start_k0: Option<Number>,
        initial: Option<Spanned<BTreeMap<String, Spanned<Value>>>>,
        gravity: Option<Number>,
        slope_angle: Option<Number>,
        seismic_coefficient: Option<Number>,
        geometry: Spanned<RawGeometry>,
        mesh: Spanned<RawMesh>,
        soil: Spanned<RawSoil>,
        layers: Option<Spanned<Vec<Spanned<RawZone>>>>,
        regions: Option<Spanned<Vec<Spanned<RawZone>>>>,
        water: Option<Spanned<RawWater>>,
        boundaries: Option<Spanned<RawBoundaries>>,
        base: Option<Spanned<RawBase>>,
        surcharge: Option<Spanned<RawSurcharge>>,
        loads: Option<Spanned<Vec<Spanned<RawLoad>>>>,
        reservoirs: Option<Spanned<Vec<Spanned<RawReservoir>>>>,
        plates: Option<Spanned<Vec<Spanned<RawPlate>>>>,
        wells: Option<Spanned<Vec<Spanned<RawWell>>>>,
        scheme: Option<Spanned<RawScheme>>,
        time: Option<Spanned<RawTime>>,
        stages: Spanned<Vec<Spanned<RawStage>>>,
        failure: Option<Spanned<RawFailure>>,
        observe: Option<Spanned<RawObserve>>,
    }

    RawColumn {
        height: Number,
        width: Number,
        inner_radius: Option<Number>,
    }

    RawOutline {
        points: Points,
        inner_radius: Option<Number>,
    }

    RawMesh {
        cell: Number,
        particles_per_cell: Spanned<i64>,
        empty_cells_above: Option<Spanned<i64>>,
        empty_cells_beside: Option<Spanned<i64>>,
        seeding: Option<Word>,
        shift: Option<Number>,
        displaced: Option<Spanned<RawDisplaced>>,
    }

    RawDisplaced {
        smooth: Option<Number>,
        jitter: Option<Number>,
        seed: Option<Spanned<i64>>,
    }

    RawSoil {
        law: Spanned<RawLaw>,
        grain_density: Option<Number>,
        bulk_density: Option<Number>,
        porosity: Number,
        biot_coefficient: Option<Number>,
        grain_bulk_modulus: Option<Number>,
        separation: Option<Number>,
        strain: Option<Word>,
    }

    RawLinearElastic {
        youngs_modulus: Number,
        poisson_ratio: Number,
    }

    RawMohrCoulomb {
        youngs_modulus: Number,
        poisson_ratio: Number,
        cohesion: Number,
        friction_angle: Number,
        dilation_angle: Option<Number>,
        dilation_fades_over: Option<Number>,
        tension_cutoff: Option<Number>,
    }

    RawCamClay {
        lambda: Number,
        kappa: Number,
        poisson_ratio: Number,
        bulk_modulus: Option<Number>,
        critical_slope: Number,
        preconsolidation: Option<Number>,
        overconsolidation: Option<Number>,
        attraction: Option<Number>,
    }

    RawZone {
        up_to: Option<Number>,
        polygon: Option<Points>,
        levels: Option<Spanned<[f64; 2]>>,
        law: Option<Spanned<RawLaw>>,
        youngs_modulus: Option<Number>,
        poisson_ratio: Option<Number>,
        grain_density: Option<Number>,
        bulk_density: Option<Number>,
        porosity: Option<Number>,
        biot_coefficient: Option<Number>,
        grain_bulk_modulus: Option<Number>,
        hydraulic_conductivity: Option<Number>,
        anisotropy: Option<Number>,
        bedding_angle: Option<Number>,
        kozeny_carman: Option<Spanned<bool>>,
        start_k0: Option<Number>,
    }

    RawWater {
        hydraulic_conductivity: Option<Number>,
        anisotropy: Option<Number>,
        bedding_angle: Option<Number>,
        kozeny_carman: Option<Spanned<bool>>,
        intrinsic_permeability: Option<Number>,
        viscosity: Option<Number>,
        bulk_modulus: Number,
        unit_weight: Number,
        density: Option<Number>,
        free_surface: Option<Spanned<RawFreeSurface>>,
    }

    RawFreeSurface {
        saturation: Option<Number>,
        level: Option<Number>,
        wet: Option<Points>,
        suction: Option<Number>,
        retention: Option<Spanned<RawRetention>>,
        feed: Option<Spanned<RawFeeds>>,
    }

    RawVanGenuchten {
        alpha: Number,
        n: Number,
        entry: Option<Number>,
    }

    RawGardner {
        alpha: Number,
    }

    RawBrooksCorey {
        entry: Number,
        index: Number,
    }

    RawFeeds {
        left: Option<Spanned<RawFeed>>,
        right: Option<Spanned<RawFeed>>,
        bottom: Option<Spanned<RawFeed>>,
        top: Option<Spanned<RawFeed>>,
    }

    RawFeed {
        head: Option<Number>,
        heads: Option<Pairs>,
        velocity: Option<Number>,
        height: Option<Number>,
        times: Option<Pairs>,
    }

    RawBoundaries {
        left: Option<Word>,
        right: Option<Word>,
        bottom: Option<Word>,
        top: Option<Word>,
    }

    RawBase {
        friction_angle: Option<Number>,
        peak_angle: Option<Number>,
        residual_angle: Option<Number>,
        slip_distance: Option<Number>,
        adhesion: Option<Number>,
        memory: Option<Number>,
        normal_stress: Option<Word>,
    }

    RawSurcharge {
        pressure: Number,
        on: Option<Word>,
        ramp_time: Option<Number>,
        strip: Option<Spanned<RawStrip>>,
    }

    RawStrip {
        from: Number,
        to: Number,
        taper: Option<Number>,
    }

    RawLoad {
        on: Option<Word>,
        x: Option<Spanned<[f64; 2]>>,
        y: Option<Spanned<[f64; 2]>>,
        pressure: Option<Number>,
        shear: Option<Number>,
        water: Option<bool>,
        ramp_time: Option<Number>,
        times: Option<Pairs>,
        sine: Option<Spanned<RawSine>>,
        wave: Option<Spanned<RawWave>>,
    }

    RawPlate {
        on: Option<Word>,
        x: Option<Spanned<[f64; 2]>>,
        y: Option<Spanned<[f64; 2]>>,
        rough: Option<bool>,
        displacement: Option<Number>,
        velocity: Option<Number>,
        ramp_time: Option<Number>,
        times: Option<Pairs>,
        sine: Option<Spanned<RawSine>>,
    }

    RawReservoir {
        on: Option<Word>,
        x: Option<Spanned<[f64; 2]>>,
        y: Option<Spanned<[f64; 2]>>,
        level: Option<Number>,
        levels: Option<Pairs>,
    }

    RawWell {
        at: Spanned<Value>,
        rate: Number,
        ramp_time: Option<Number>,
        times: Option<Pairs>,
        sine: Option<Spanned<RawSine>>,
    }

    RawSine {
        mean: Option<Number>,
        amplitude: Option<Number>,
        period: Number,
        phase: Option<Number>,
    }

    RawWave {
        length: Number,
        period: Number,
    }

    #[derive(Default)]
    RawScheme {
        shape: Option<Word>,
        darcy: Option<Word>,
        darcy_inertia: Option<Spanned<bool>>,
        relative_acceleration: Option<Spanned<bool>>,
        flip: Option<Number>,
        light_nodes: Option<Number>,
        transfer: Option<Word>,
        update: Option<Word>,
        null_space_strain: Option<Number>,
        particle_domain: Option<Word>,
        quadrature: Option<Word>,
        jump_penalty: Option<Number>,
    }

    #[derive(Default)]
    RawTime {
        integrator: Option<Word>,
        step: Option<Spanned<Value>>,
        safety: Option<Number>,
        method: Option<Word>,
        waves: Option<Word>,
        tolerance: Option<Number>,
    }

    RawStage {
        name: Option<Word>,
        drained: Option<Spanned<Value>>,
        boundaries: Option<Spanned<RawBoundaries>>,
        damping: Option<Number>,
        coupling: Option<Word>,
        until: Spanned<RawUntil>,
    }

    RawUntil {
        time: Option<Number>,
        time_factor: Option<Number>,
        pore_pressure_within: Option<Number>,
        rest: Option<Spanned<RawRest>>,
        everywhere: Option<bool>,
        at_most: Option<Number>,
    }

    RawRest {
        speed: Number,
        at_most: Number,
    }

    RawFailure {
        starts_at: Option<Number>,
        continue_if_unstable: Option<bool>,
        continue_after_collapse: Option<bool>,
        levels: Option<Spanned<Vec<Number>>>,
        points: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
    }

    RawObserve {
        time_factors: Option<Spanned<Vec<Number>>>,
        times: Option<Spanned<Vec<Number>>>,
        history: Option<Spanned<i64>>,
        profiles: Option<bool>,
    }
}
