//! Messages of runs that cannot continue.

use super::QuasiStatic;
use super::tangent::Stuck;
use crate::constitutive::Law;
use crate::particles::SolidPoint;
use crate::sparse::Unsolved;
use crate::step::Fault;

impl<L: Law, const D: usize> QuasiStatic<L, D> {
    pub(super) fn fault(&self, stuck: &Stuck<D>, step: Option<f64>) -> Fault {
        let mut what = describe(stuck, &self.points);
        if let Some(h) = step {
            what = format!("{what}; step {h:.3e} s");
        }
        if matches!(stuck, Stuck::Unsolved(_)) {
            what += &self.singular_hint();
        }
        what += self.limit_hint();
        Fault { place: "the whole soil".to_owned(), what }
    }

    pub(super) fn singular_hint(&self) -> String {
        let incompressible = self.scene.water.is_some_and(|w| w.bulk_modulus.is_infinite());
        match (incompressible, self.drained.contains(&true)) {
            (true, false) => "; the water is incompressible and no side is drained".to_owned(),
            _ => "; is the soil supported, and are there enough particles in every cell?".to_owned(),
        }
    }

    pub(super) fn too_small(&self, step: f64) -> Fault {
        let mut what = format!(
            "the step cannot be reduced further: {step:.3e} s in a stage of {:.3e} s; {}",
            self.stage_end,
            self.trouble.as_deref().unwrap_or("every step was accepted")
        );
        what += self.limit_hint();
        Fault { place: "the whole soil".to_owned(), what }
    }

    /// What strength may have to do with it.
    fn limit_hint(&self) -> &'static str {
        if self.seeding.law.are_linear() { "" } else { "; the load may exceed the bearing capacity of the soil" }
    }
}

pub(super) fn nothing() -> Fault {
    Fault { place: "the run".to_owned(), what: "no stage was entered".to_owned() }
}

pub(super) fn unsolved(e: &Unsolved) -> Fault {
    Fault { place: "the whole soil".to_owned(), what: e.to_string() }
}

pub(super) fn inverted<const D: usize>(points: &[SolidPoint<D>], point: usize) -> Fault {
    let x = points.get(point).map_or([f64::NAN; D], |p| p.x);
    Fault { place: format!("point {point} near {x:?} m"), what: "an element is inverted, det F <= 0".to_owned() }
}

pub(super) fn describe<const D: usize>(stuck: &Stuck<D>, points: &[SolidPoint<D>]) -> String {
    match stuck {
        Stuck::InsideOut(e) => {
            let fault = inverted(points, e.point);
            format!("{}: {}", fault.place, fault.what)
        }
        Stuck::Unsolved(e) => e.to_string(),
        Stuck::NotConverged(history) => {
            let list: Vec<String> = history.iter().map(|r| format!("{r:.1e}")).collect();
            format!("Newton's iteration did not converge; residuals {}", list.join(", "))
        }
    }
}
