//! How a scene is computed: scheme, integrator and its steps, strain, the place of mesh and particles.

use toml::{Spanned, Value};

use super::super::raw::{RawMesh, RawScene, RawScheme, RawSoil, RawTime};
use super::super::{
    DarcyChoice, Dimension, Displaced, DomainChoice, Fields, Integrator, Quadrature, ShapeChoice, StepChoice,
    StrainChoice, TimeMethod, TransferChoice, UpdateChoice, Waves,
};
use super::faults::Faults;
use super::{Checked, Reader};

/// The checked `[scheme]`.
pub(super) struct Scheme {
    pub shape: Option<ShapeChoice>,
    pub darcy: DarcyChoice,
    pub darcy_inertia: bool,
    pub relative_acceleration: Option<bool>,
    pub flip: f64,
    pub transfer: TransferChoice,
    pub null_space_strain: Option<f64>,
    pub particle_domain: DomainChoice,
    pub update: UpdateChoice,
    pub quadrature: Quadrature,
    pub jump_penalty: Option<f64>,
}

/// The checked `[time]`.
pub(super) struct Time {
    pub integrator: Integrator,
    pub step: StepChoice,
    pub safety: f64,
    pub method: TimeMethod,
    pub waves: Waves,
    pub tolerance: f64,
}

/// Words of `scheme.shape`.
pub const SHAPES: [(&str, ShapeChoice); 7] = [
    ("centre", ShapeChoice::Centre),
    ("centroid", ShapeChoice::Centroid),
    ("linear", ShapeChoice::Linear),
    ("b-bar", ShapeChoice::BBar),
    ("gimp", ShapeChoice::Gimp),
    ("bspline2", ShapeChoice::Bspline2),
    ("bspline3", ShapeChoice::Bspline3),
];
/// Words of `time.integrator`.
pub const INTEGRATORS: [(&str, Integrator); 6] = [
    ("explicit", Integrator::Explicit),
    ("semi-implicit", Integrator::SemiImplicit),
    ("quasi-static", Integrator::QuasiStatic),
    ("implicit", Integrator::Implicit),
    ("staggered", Integrator::Staggered),
    ("coupled", Integrator::Coupled),
];
/// Default factor on the stability limit.
pub(in super::super) const SAFETY: f64 = 0.9;
/// Default tolerance of error-controlled time.
pub(in super::super) const TOLERANCE: f64 = 1e-4;
/// Tolerances that can be asked for: below, round-off of the linear solves decides.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-10..=0.1;

/// Shape functions of a scene that does not name any: gradients at the centre of the cell, the paper's, where no hourglass can
/// be; in plane strain B-bar, which is as soft to changes of volume and stiff to hourglasses. Water with a free surface and
/// the quasi-static integrator know only the former; steps with inertia that solve for displacements take quadratic B-splines.
pub(super) fn usual_shape(raw: &RawScene, dimension: Dimension, integrator: Integrator) -> ShapeChoice {
    let steps = matches!(integrator, Integrator::Explicit | Integrator::SemiImplicit);
    let free = raw.water.as_ref().is_some_and(|water| water.get_ref().free_surface.is_some());
    if integrator == Integrator::Implicit {
        return ShapeChoice::Bspline2;
    }
    if dimension != Dimension::Column && steps && !free { ShapeChoice::BBar } else { ShapeChoice::Centre }
}

impl Reader<'_> {
    pub(super) fn scheme(&self, raw: Option<&RawScheme>) -> Checked<Scheme> {
        let operators = [("face", DarcyChoice::Face), ("nodal", DarcyChoice::Nodal)];
        let quadratures = [("fitted", Quadrature::Fitted), ("volumes", Quadrature::Volumes)];
        let mut scheme = Scheme {
            shape: None,
            darcy: DarcyChoice::Face,
            darcy_inertia: true,
            relative_acceleration: None,
            flip: 1.0,
            transfer: TransferChoice::Plain,
            null_space_strain: None,
            particle_domain: DomainChoice::Point,
            update: UpdateChoice::Usl,
            quadrature: Quadrature::Fitted,
            jump_penalty: None,
        };
        let Some(raw) = raw else { return Ok(scheme) };
        let mut faults = Faults::default();
        if let Some(value) = &raw.flip {
            let flip = self.within(value, "scheme.flip", "0 <= flip <= 1", |f| (0.0..=1.0).contains(&f));
            scheme.flip = faults.take(flip).unwrap_or(scheme.flip);
        }
        let transfers = [("plain", TransferChoice::Plain), ("affine", TransferChoice::Affine)];
        let updates = [("usl", UpdateChoice::Usl), ("musl", UpdateChoice::Musl)];
        faults.or_keep(&mut scheme.transfer, |usual| {
            self.word(raw.transfer.as_ref(), "scheme.transfer", &transfers, usual)
        });
        faults.or_keep(&mut scheme.update, |usual| self.word(raw.update.as_ref(), "scheme.update", &updates, usual));
        let words = [("point", DomainChoice::Point), ("contiguous", DomainChoice::Contiguous)];
        faults.or_keep(&mut scheme.particle_domain, |usual| {
            self.word(raw.particle_domain.as_ref(), "scheme.particle_domain", &words, usual)
        });
        if raw.shape.is_some() {
            scheme.shape = faults.take(self.word(raw.shape.as_ref(), "scheme.shape", &SHAPES, ShapeChoice::Centre));
        }
        let words = &quadratures;
        faults.or_keep(&mut scheme.quadrature, |usual| {
            self.word(raw.quadrature.as_ref(), "scheme.quadrature", words, usual)
        });
        if let Some(value) = &raw.null_space_strain {
            let strain = self.within(value, "scheme.null_space_strain", "a strain above 0 (-)", |e| e > 0.0);
            scheme.null_space_strain = faults.take(strain);
        }
        if let Some(value) = &raw.jump_penalty {
            let expected = "a factor from 0 to 1 (-)";
            let factor = self.within(value, "scheme.jump_penalty", expected, |g| (0.0..=1.0).contains(&g));
            scheme.jump_penalty = faults.take(factor);
        }
        faults.or_keep(&mut scheme.darcy, |usual| self.word(raw.darcy.as_ref(), "scheme.darcy", &operators, usual));
        scheme.darcy_inertia = raw.darcy_inertia.as_ref().is_none_or(|inertia| *inertia.get_ref());
        scheme.relative_acceleration = raw.relative_acceleration.as_ref().map(|kept| *kept.get_ref());
        faults.or(Some(scheme))
    }

    /// Whether Darcy's law keeps `rho_w a_s`: not where the model would then be unstable, unless the scene insists.
    pub(super) fn soft_water(&self, raw: &RawScene, scene: &Fields) -> Checked<bool> {
        let relative = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().relative_acceleration.as_ref());
        if let (Some(value), true, false) = (relative, scene.relative_acceleration, scene.darcy_inertia) {
            let expected = "false with darcy_inertia = false: water without inertia has no acceleration of its own";
            return self.refuse(&value.span(), "scheme.relative_acceleration", expected, value.get_ref());
        }
        if !(scene.darcy_inertia && scene.inertia_feeds_waves()) {
            return Ok(scene.darcy_inertia);
        }
        let written = raw.scheme.as_ref().and_then(|scheme| scheme.get_ref().darcy_inertia.as_ref());
        let Some(value) = written else { return Ok(false) };
        let (carried, weight) = (scene.undrained_share(), scene.water.map_or(0.0, |w| w.density));
        let expected = "false where the water carries a smaller share of a load, Q/(M + Q), than of the weight, rho_w/rho: \
                        every wave then grows by itself";
        let here = format!("Q/(M + Q) = {carried:.3}, rho_w/rho = {:.3}", weight / scene.mixture_density());
        self.refuse(&value.span(), "scheme.darcy_inertia", expected, value.get_ref()).map_err(|fault| fault.with(here))
    }

    pub(super) fn time(&self, raw: Option<&RawTime>) -> Checked<Time> {
        let mut checked = Time {
            integrator: Integrator::Explicit,
            step: StepChoice::Auto,
            safety: SAFETY,
            method: TimeMethod::Auto,
            waves: Waves::Auto,
            tolerance: TOLERANCE,
        };
        let Some(time) = raw else { return Ok(checked) };
        let mut faults = Faults::default();
        let word = time.integrator.as_ref();
        faults.or_keep(&mut checked.integrator, |usual| self.word(word, "time.integrator", &INTEGRATORS, usual));
        if checked.integrator.solves_displacements() {
            faults.take(self.own_steps(time, &mut checked));
        } else {
            faults.take(self.limited_steps(time, &mut checked));
        }
        faults.or_keep(&mut checked.step, |_| self.step(time));
        faults.or(Some(checked))
    }

    /// Steps that follow from a tolerance.
    fn own_steps(&self, time: &RawTime, checked: &mut Time) -> Checked<()> {
        let methods = [("auto", TimeMethod::Auto), ("krylov", TimeMethod::Krylov), ("sdirk", TimeMethod::Sdirk)];
        let waves = [("auto", Waves::Auto), ("resolved", Waves::Resolved), ("damped", Waves::Damped)];
        checked.waves = self.word(time.waves.as_ref(), "time.waves", &waves, Waves::Auto)?;
        checked.method = self.word(time.method.as_ref(), "time.method", &methods, TimeMethod::Auto)?;
        if let Some(value) = &time.tolerance {
            let range = format!("{:e} <= tolerance <= {} (-)", TOLERANCES.start(), TOLERANCES.end());
            checked.tolerance = self.within(value, "time.tolerance", &range, |t| TOLERANCES.contains(&t))?;
        }
        Ok(())
    }

    /// Steps that are a share of the stability limit.
    fn limited_steps(&self, time: &RawTime, checked: &mut Time) -> Checked<()> {
        if let Some(value) = &time.safety {
            checked.safety = self.within(value, "time.safety", "0 < safety <= 1", |s| s > 0.0 && s <= 1.0)?;
        }
        Ok(())
    }

    fn step(&self, time: &RawTime) -> Checked<StepChoice> {
        let expected = "\"auto\", \"paper\" or a step above 0 (s)";
        let Some(value) = &time.step else { return Ok(StepChoice::Auto) };
        match value.get_ref() {
            Value::String(word) if word == "auto" => Ok(StepChoice::Auto),
            Value::String(word) if word == "paper" => Ok(StepChoice::Paper),
            Value::Float(step) if step.is_finite() && *step > 0.0 => Ok(StepChoice::Fixed(*step)),
            Value::Integer(step) if *step > 0 => Ok(StepChoice::Fixed(*step as f64)),
            other => self.refuse(&value.span(), "time.step", expected, other),
        }
    }

    pub(super) fn strain(&self, soil: &RawSoil) -> Checked<StrainChoice> {
        let words = [("large", StrainChoice::Large), ("small", StrainChoice::Small)];
        self.word(soil.strain.as_ref(), "soil.strain", &words, StrainChoice::Large)
    }

    /// Where the mesh starts and how the particles stand.
    pub(super) fn places(&self, mesh: &RawMesh) -> Checked<(f64, Option<Displaced>)> {
        let shift = match &mesh.shift {
            Some(value) => self.within(value, "mesh.shift", "0 <= shift < 1 (cells)", |s| (0.0..1.0).contains(&s))?,
            None => 0.0,
        };
        let Some(table) = &mesh.displaced else { return Ok((shift, None)) };
        let raw = table.get_ref();
        let amount = |value: Option<&Spanned<f64>>, key: &str| match value {
            Some(value) => self.within(value, key, "0 to 0.5 (particle spacings)", |a| (0.0..=0.5).contains(&a)),
            None => Ok(0.0),
        };
        let smooth = amount(raw.smooth.as_ref(), "mesh.displaced.smooth")?;
        let jitter = amount(raw.jitter.as_ref(), "mesh.displaced.jitter")?;
        let seed = match &raw.seed {
            Some(value) if *value.get_ref() < 0 => {
                return self.refuse(&value.span(), "mesh.displaced.seed", "0 or more", value.get_ref());
            }
            Some(value) => *value.get_ref() as u64,
            None => 1,
        };
        Ok((shift, Some(Displaced { smooth, jitter, seed })))
    }
}
