//! Which features of [`capabilities`](super::super::capabilities) a raw scene has, and where it says so.

use std::ops::Range;

use toml::{Spanned, Value};

use super::super::capabilities::{FEATURES, Feature, RULES};
use super::super::raw::{RawGeometry, RawLaw, RawScene};
use super::super::{Dimension, Integrator};
use super::faults::Faults;
use super::{Checked, Reader, method};

/// Whether a word is written, and is this one.
fn is(word: Option<&Spanned<String>>, wanted: &str) -> bool {
    word.is_some_and(|word| word.get_ref() == wanted)
}

impl Reader<'_> {
    /// Checks a scene against the table of what goes together.
    pub(super) fn goes_together(&self, raw: &RawScene) -> Checked<()> {
        let has: Vec<Feature> = FEATURES.iter().map(|(feature, ..)| *feature).filter(|f| has(raw, *f)).collect();
        let mut faults = Faults::default();
        for rule in RULES.iter().filter(|rule| has.contains(&rule.of)) {
            if let Some(other) = rule.beside.iter().find(|other| has.contains(other)) {
                let said = [rule.of, *other].into_iter().find_map(|feature| Some((feature, place(raw, feature)?)));
                let (feature, span) = said.unwrap_or((rule.of, 0..0));
                let found = format!("{} with {}", rule.of.word(), other.word());
                faults.take::<()>(self.refuse(&span, feature.key(), rule.expected, found));
            }
        }
        faults.or(Some(()))
    }
}

/// Whether a scene has a feature.
fn has(raw: &RawScene, feature: Feature) -> bool {
    let time = raw.time.as_ref().map(Spanned::get_ref);
    let scheme = raw.scheme.as_ref().map(Spanned::get_ref);
    let boundaries = raw.boundaries.as_ref().map(Spanned::get_ref);
    let surcharge = raw.surcharge.as_ref().map(Spanned::get_ref);
    let (mesh, soil, law) = (raw.mesh.get_ref(), raw.soil.get_ref(), raw.soil.get_ref().law.get_ref());
    let zones = || raw.layers.iter().chain(&raw.regions).flat_map(|zones| zones.get_ref());
    let laws = || std::iter::once(law).chain(zones().filter_map(|zone| Some(zone.get_ref().law.as_ref()?.get_ref())));
    let stages = || raw.stages.get_ref().iter().map(Spanned::get_ref);
    let free = raw.water.as_ref().is_some_and(|water| water.get_ref().free_surface.is_some());
    let integrator = |wanted: &str| match time.and_then(|time| time.integrator.as_ref()) {
        Some(word) => word.get_ref() == wanted,
        None => wanted == "explicit",
    };
    let column = raw.dimension.as_ref().is_none_or(|word| word.get_ref() == "column");
    let dimension = if column { Dimension::Column } else { Dimension::PlaneStrain };
    let shape = |wanted: &str| match scheme.and_then(|scheme| scheme.shape.as_ref()) {
        Some(word) => word.get_ref() == wanted,
        None => {
            let of = |word: &str| method::INTEGRATORS.iter().find(|(w, _)| *w == word).map(|(_, choice)| *choice);
            let word = time.and_then(|time| time.integrator.as_ref()).map_or("explicit", |word| word.get_ref());
            method::usual_shape(raw, dimension, of(word).unwrap_or(Integrator::Explicit)).word() == wanted
        }
    };
    let start = |wanted: &str| match &raw.start {
        Some(word) => word.get_ref() == wanted,
        None => wanted == "unloaded",
    };
    let step = time.and_then(|time| time.step.as_ref()).map(Spanned::get_ref);
    let word = |value: Option<&Value>, wanted: &str| matches!(value, Some(Value::String(word)) if word == wanted);
    match feature {
        Feature::Column => dimension == Dimension::Column,
        Feature::Axisymmetric => is(raw.dimension.as_ref(), "axisymmetric"),
        Feature::Outline => matches!(raw.geometry.get_ref(), RawGeometry::Outline(_)),
        Feature::Explicit
        | Feature::SemiImplicit
        | Feature::QuasiStatic
        | Feature::Implicit
        | Feature::Staggered
        | Feature::Coupled => integrator(feature.word().trim_matches('"')),
        Feature::Centroid | Feature::Linear | Feature::BBar | Feature::Gimp | Feature::Bspline2 | Feature::Bspline3 => {
            shape(feature.word().trim_matches('"'))
        }
        Feature::AnyShape => !shape("bspline2") && !shape("bspline3"),
        Feature::Dry => raw.water.is_none(),
        Feature::Saturated => raw.water.is_some() && !free,
        Feature::FreeSurface => free,
        Feature::Incompressible => {
            raw.water.as_ref().is_some_and(|water| *water.get_ref().bulk_modulus.get_ref() == f64::INFINITY)
        }
        Feature::KozenyCarman => {
            let all = raw.water.iter().filter_map(|water| water.get_ref().kozeny_carman.as_ref());
            all.chain(zones().filter_map(|zone| zone.get_ref().kozeny_carman.as_ref())).any(|is| *is.get_ref())
        }
        Feature::Bedding => {
            let all = raw.water.iter().filter_map(|water| water.get_ref().bedding_angle.as_ref());
            all.chain(zones().filter_map(|zone| zone.get_ref().bedding_angle.as_ref())).any(|x| *x.get_ref() != 0.0)
        }
        Feature::LinearElastic => matches!(law, RawLaw::LinearElastic(_)),
        Feature::MohrCoulomb => laws().any(|law| matches!(law, RawLaw::MohrCoulomb(_))),
        Feature::CamClay => laws().any(|law| matches!(law, RawLaw::ModifiedCamClay(_))),
        Feature::Layers => raw.layers.is_some(),
        Feature::Regions => raw.regions.is_some(),
        Feature::Separation => soil.separation.is_some(),
        Feature::LargeStrain => !is(soil.strain.as_ref(), "small"),
        Feature::SmallStrain => is(soil.strain.as_ref(), "small"),
        Feature::NoGravity => raw.gravity.is_none(),
        Feature::Gravity => raw.gravity.is_some(),
        Feature::SlopeAngle => raw.slope_angle.is_some(),
        Feature::Seismic => raw.seismic_coefficient.is_some(),
        Feature::Unloaded => start("unloaded"),
        Feature::UndrainedStart => start("undrained-equilibrium"),
        Feature::Geostatic => start("geostatic"),
        Feature::GivenStart => start("given"),
        Feature::Initial => raw.initial.is_some(),
        Feature::StartK0 => raw.start_k0.is_some(),
        Feature::StartVelocity => raw.start_velocity.is_some(),
        Feature::Shift => mesh.shift.is_some(),
        Feature::Displaced => mesh.displaced.is_some(),
        Feature::EmptyBeside => mesh.empty_cells_beside.as_ref().is_some_and(|cells| *cells.get_ref() != 0),
        Feature::Periodic => boundaries.is_some_and(|b| is(b.left.as_ref(), "periodic")),
        Feature::FixedSide => boundaries.is_some_and(|b| is(b.left.as_ref(), "fixed") || is(b.right.as_ref(), "fixed")),
        Feature::HeldTop => boundaries.is_some_and(|b| is(b.top.as_ref(), "roller") || is(b.top.as_ref(), "fixed")),
        Feature::CoulombBase => raw.base.is_some(),
        Feature::Load => surcharge.is_some(),
        Feature::Plate => surcharge.is_some_and(|load| is(load.on.as_ref(), "plate")),
        Feature::Strip => surcharge.is_some_and(|load| load.strip.is_some()),
        Feature::Loads => raw.loads.is_some() || raw.reservoirs.is_some(),
        Feature::MovedPlates => raw.plates.is_some(),
        Feature::Wells => raw.wells.is_some(),
        Feature::DarcyOperator => scheme.is_some_and(|scheme| scheme.darcy.is_some()),
        Feature::Nodal => scheme.is_some_and(|scheme| is(scheme.darcy.as_ref(), "nodal")),
        Feature::RelativeAcceleration => {
            scheme.is_some_and(|scheme| scheme.relative_acceleration.as_ref().is_some_and(|kept| *kept.get_ref()))
        }
        Feature::DarcyInertia => scheme.is_some_and(|scheme| scheme.darcy_inertia.is_some()),
        Feature::InertiaKept => {
            scheme.is_some_and(|scheme| scheme.darcy_inertia.as_ref().is_some_and(|kept| *kept.get_ref()))
        }
        Feature::Flip => scheme.is_some_and(|scheme| scheme.flip.is_some()),
        Feature::Contiguous => scheme.is_some_and(|scheme| is(scheme.particle_domain.as_ref(), "contiguous")),
        Feature::NullSpace => scheme.is_some_and(|scheme| scheme.null_space_strain.is_some()),
        Feature::Affine => scheme.is_some_and(|scheme| is(scheme.transfer.as_ref(), "affine")),
        Feature::Musl => scheme.is_some_and(|scheme| is(scheme.update.as_ref(), "musl")),
        Feature::LightNodes => scheme.is_some_and(|scheme| scheme.light_nodes.is_some()),
        Feature::JumpPenalty => scheme.is_some_and(|scheme| scheme.jump_penalty.is_some()),
        Feature::Waves => time.is_some_and(|time| time.waves.is_some()),
        Feature::TimeMethod => time.is_some_and(|time| time.method.is_some()),
        Feature::Krylov => time.is_some_and(|time| is(time.method.as_ref(), "krylov")),
        Feature::Tolerance => time.is_some_and(|time| time.tolerance.is_some()),
        Feature::Safety => time.is_some_and(|time| time.safety.is_some()),
        Feature::GivenStep => matches!(step, Some(Value::Float(_) | Value::Integer(_))),
        Feature::PaperStep => word(step, "paper"),
        Feature::Drained => stages().any(|stage| stage.drained.is_some()),
        Feature::StageSides => stages().any(|stage| stage.boundaries.is_some()),
        Feature::Damping => {
            stages().any(|stage| stage.damping.as_ref().is_some_and(|damping| *damping.get_ref() > 0.0))
        }
        Feature::Fails => {
            stages().any(|stage| ["full", "staggered"].iter().any(|word| is(stage.coupling.as_ref(), word)))
        }
        Feature::RestEnd => stages().any(|stage| stage.until.get_ref().rest.is_some()),
        Feature::PressureEnd => stages().any(|stage| stage.until.get_ref().pore_pressure_within.is_some()),
    }
}

/// Where a scene says that it has a feature; `None` where it has it by saying nothing.
fn place(raw: &RawScene, feature: Feature) -> Option<Range<usize>> {
    fn of<T>(value: Option<&Spanned<T>>) -> Option<Range<usize>> {
        value.map(Spanned::span)
    }
    let time = raw.time.as_ref().map(Spanned::get_ref);
    let scheme = raw.scheme.as_ref().map(Spanned::get_ref);
    let boundaries = raw.boundaries.as_ref().map(Spanned::get_ref);
    let surcharge = raw.surcharge.as_ref().map(Spanned::get_ref);
    let water = raw.water.as_ref().map(Spanned::get_ref);
    let (mesh, soil) = (raw.mesh.get_ref(), raw.soil.get_ref());
    let stage = |place: &dyn Fn(&super::super::raw::RawStage) -> Option<Range<usize>>| {
        raw.stages.get_ref().iter().find_map(|stage| place(stage.get_ref()))
    };
    match feature.key() {
        "dimension" => of(raw.dimension.as_ref()),
        "geometry.outline" => Some(raw.geometry.span()),
        "time.integrator" => of(time?.integrator.as_ref()),
        "time.method" => of(time?.method.as_ref()),
        "time.waves" => of(time?.waves.as_ref()),
        "time.tolerance" => of(time?.tolerance.as_ref()),
        "time.safety" => of(time?.safety.as_ref()),
        "time.step" => of(time?.step.as_ref()),
        "scheme.shape" => of(scheme?.shape.as_ref()),
        "scheme.darcy" => of(scheme?.darcy.as_ref()),
        "scheme.darcy_inertia" => of(scheme?.darcy_inertia.as_ref()),
        "scheme.relative_acceleration" => of(scheme?.relative_acceleration.as_ref()),
        "scheme.flip" => of(scheme?.flip.as_ref()),
        "scheme.null_space_strain" => of(scheme?.null_space_strain.as_ref()),
        "scheme.particle_domain" => of(scheme?.particle_domain.as_ref()),
        "scheme.transfer" => of(scheme?.transfer.as_ref()),
        "scheme.update" => of(scheme?.update.as_ref()),
        "scheme.light_nodes" => of(scheme?.light_nodes.as_ref()),
        "scheme.jump_penalty" => of(scheme?.jump_penalty.as_ref()),
        "water" => of(raw.water.as_ref()),
        "water.free_surface" => of(water?.free_surface.as_ref()),
        "water.bulk_modulus" => Some(water?.bulk_modulus.span()),
        "water.kozeny_carman" => of(water?.kozeny_carman.as_ref()),
        "water.bedding_angle" => of(water?.bedding_angle.as_ref()),
        "soil.law" => Some(soil.law.span()),
        "soil.separation" => of(soil.separation.as_ref()),
        "soil.strain" => of(soil.strain.as_ref()),
        "layers" => of(raw.layers.as_ref()?.get_ref().first()),
        "regions" => of(raw.regions.as_ref()?.get_ref().first()),
        "gravity" => of(raw.gravity.as_ref()),
        "slope_angle" => of(raw.slope_angle.as_ref()),
        "seismic_coefficient" => of(raw.seismic_coefficient.as_ref()),
        "start" => of(raw.start.as_ref()),
        "stages.boundaries" => stage(&|stage| of(stage.boundaries.as_ref())),
        "start_k0" => of(raw.start_k0.as_ref()),
        "initial" => of(raw.initial.as_ref()),
        "start_velocity" => of(raw.start_velocity.as_ref()),
        "mesh.shift" => of(mesh.shift.as_ref()),
        "mesh.displaced" => of(mesh.displaced.as_ref()),
        "mesh.empty_cells_beside" => of(mesh.empty_cells_beside.as_ref()),
        "boundaries.left" => of(boundaries?.left.as_ref()).or_else(|| of(boundaries?.right.as_ref())),
        "boundaries.top" => of(boundaries?.top.as_ref()),
        "base" => of(raw.base.as_ref()),
        "surcharge" => of(raw.surcharge.as_ref()),
        "surcharge.on" => of(surcharge?.on.as_ref()),
        "surcharge.strip" => of(surcharge?.strip.as_ref()),
        "stages.drained" => stage(&|stage| of(stage.drained.as_ref())),
        "stages.damping" => stage(&|stage| of(stage.damping.as_ref())),
        "stages.coupling" => stage(&|stage| of(stage.coupling.as_ref())),
        "stages.until.rest" => stage(&|stage| of(stage.until.get_ref().rest.as_ref())),
        "stages.until" => {
            stage(&|stage| stage.until.get_ref().pore_pressure_within.is_some().then(|| stage.until.span()))
        }
        _ => None,
    }
}
