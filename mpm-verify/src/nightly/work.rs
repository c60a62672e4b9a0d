//! What runs cost in counts: steps, point-steps, solves, factorisations, repeated steps, calls of the allocator. The same program
//! counts the same on every machine of a kind, whatever else it does. Beside them stands what they cost in time.

use allocation_counter::{AllocationInfo, measure, opt_out};
use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::{Dimension, Fields, Flags, Integrator, Scene, ShapeChoice, TimeMethod, TransferChoice, Until};

use super::calibration;
use super::compiled::{self, ALLOCATIONS, COMPILED};
use super::part::Measured;
use crate::error::Error::{self, Lacks};
use crate::experiment::number::{Label, Number, Tolerance};
use crate::unpanicked::unpanicked;

/// A run whose cost is counted.
#[derive(Debug, Clone, Copy)]
pub struct Gate {
    /// Its name.
    pub name: &'static str,
    /// Built-in scene, integrator and shape functions, as `solve` takes them.
    scene: (&'static str, Option<&'static str>, Option<&'static str>),
    /// Change of the scene.
    change: fn(&mut Fields),
}

fn as_it_is(_: &mut Fields) {}

fn in_plane(scene: &mut Fields) {
    (scene.dimension, scene.shape) = (Dimension::PlaneStrain, ShapeChoice::Centre);
}

/// One of each path through the solver.
pub const GATES: [Gate; 18] = [
    Gate { name: "work-explicit-column", scene: ("terzaghi", None, None), change: as_it_is },
    Gate { name: "work-explicit-linear", scene: ("terzaghi", None, Some("linear")), change: as_it_is },
    Gate { name: "work-explicit-gimp", scene: ("terzaghi", None, Some("gimp")), change: as_it_is },
    Gate { name: "work-explicit-bspline2", scene: ("terzaghi", None, Some("bspline2")), change: as_it_is },
    Gate { name: "work-explicit-plane", scene: ("terzaghi", None, None), change: in_plane },
    Gate { name: "work-explicit-layers", scene: ("layers", Some("explicit"), None), change: as_it_is },
    Gate {
        name: "work-explicit-affine",
        scene: ("terzaghi", None, None),
        change: |scene| scene.transfer = TransferChoice::Affine,
    },
    Gate { name: "work-dry-bar", scene: ("dry-bar", None, None), change: as_it_is },
    Gate { name: "work-plastic-block", scene: ("oedometer-plastic", None, None), change: as_it_is },
    Gate { name: "work-collapse", scene: ("collapse-dry", None, None), change: as_it_is },
    Gate { name: "work-semi-implicit-centre", scene: ("terzaghi-semi-implicit", None, None), change: as_it_is },
    Gate {
        name: "work-semi-implicit-bspline2",
        scene: ("terzaghi-semi-implicit", None, Some("bspline2")),
        change: as_it_is,
    },
    Gate { name: "work-krylov", scene: ("terzaghi-quasi-static", None, None), change: as_it_is },
    Gate { name: "work-krylov-centre", scene: ("terzaghi-quasi-static", None, Some("centre")), change: as_it_is },
    Gate {
        name: "work-sdirk-linear",
        scene: ("terzaghi-quasi-static", None, None),
        change: |scene| scene.method = TimeMethod::Sdirk,
    },
    Gate { name: "work-sdirk", scene: ("terzaghi-large-strain", None, None), change: as_it_is },
    Gate { name: "work-mandel", scene: ("mandel", None, None), change: as_it_is },
    Gate { name: "work-dam", scene: ("dam", None, None), change: as_it_is },
];

/// Name of the CPU time of a gate over that of the calibration kernel.
pub const TIME: &str = "time_ratio";
/// Point-steps after which an explicit run has shown what it costs.
const ENOUGH: f64 = 2e5;
/// Part of the steps of other runs that is enough.
const STEPS: f64 = 400.0;

impl Gate {
    /// Its scene, no longer than it has to be.
    ///
    /// # Errors
    /// A built-in scene that does not hold with its flags: a fault of this table.
    pub fn scene(&self) -> Result<Scene, Error> {
        let (name, integrator, scheme) = self.scene;
        let text = crate::scenes::BUILT_IN.iter().find(|(n, _)| *n == name).map(|(_, text)| *text);
        let text = text.ok_or_else(|| Lacks("such scene").of(self.name))?;
        // Steps that move their particles know large strain only.
        let moves = integrator.is_some_and(|word| word != "quasi-static");
        let text = if moves { text.replace("strain = \"small\"", "strain = \"large\"") } else { text.to_owned() };
        let flags =
            Flags { integrator: integrator.map(str::to_owned), scheme: scheme.map(str::to_owned), ..Flags::default() };
        let mut scene = Scene::parse_with(&text, name, &flags)?;
        scene = scene.edited(self.change)?;
        let dt = mpm_core::stability::choose_step(&scene)?;
        let steps = if scene.integrator == Integrator::Explicit {
            (ENOUGH / scene.solid_particles() as f64).max(50.0)
        } else {
            STEPS
        };
        let last = scene.stages.len() - 1;
        if let (Until::Time(end), true) = (scene.stages[last].until, dt.is_finite()) {
            let end = end.min(steps * dt);
            scene = scene.edited(|scene| {
                scene.stages[last].until = Until::Time(end);
                scene.observe_times = vec![end];
            })?;
        }
        Ok(scene.edited(|scene| (scene.history, scene.profiles) = (0, false))?)
    }

    /// Runs it once.
    ///
    /// # Errors
    /// A scene that cannot be run, or a run that fails.
    pub fn run(&self) -> Result<Run, Error> {
        let run = run(&self.scene()?, &mut |_| {}).map_err(|e| Error::from(e).of(self.name))?;
        run.whole().map_err(|e| Error::from(e).of(self.name))
    }
}

/// The gate of a name.
pub fn named(name: &str) -> Option<&'static Gate> {
    GATES.iter().find(|gate| gate.name == name)
}

/// Runs every gate and counts.
pub fn counts() -> Measured {
    let (measured, failed) = each(Gate::counts);
    found(measured, failed)
}

/// The counts of the gates that were run, and why others were not.
pub fn found(measured: Vec<Vec<Number>>, failed: Vec<String>) -> Measured {
    Measured::of([(measured.len(), "runs")]).with(measured.concat()).failed(failed)
}

/// Does something with every gate; one that fails takes no other down. Results, and what failed.
pub fn each<T>(work: impl Fn(&Gate) -> Result<T, Error>) -> (Vec<T>, Vec<String>) {
    let (mut results, mut failed) = (Vec::new(), Vec::new());
    for gate in &GATES {
        match unpanicked(|| work(gate)) {
            Ok(Ok(result)) => results.push(result),
            Ok(Err(why)) => failed.push(why.to_string()),
            Err(why) => failed.push(format!("{}: {why}", gate.name)),
        }
    }
    (results, failed)
}

impl Gate {
    /// Counts of the run, and its time over that of the kernel.
    fn counts(&self) -> Result<Vec<Number>, Error> {
        let scene = self.scene()?;
        let mut outcome = Err(Lacks("run"));
        let info = measure(|| outcome = self.run());
        let mut measures = counted(self, &scene, &outcome?, &info);
        let time = calibration::ratio(|| {
            let mut ended = Ok(());
            opt_out(|| ended = self.run().map(drop));
            ended
        })?;
        measures.push(Number::new(self.name, TIME, Label::Time, time, Tolerance::relative(0.0)));
        let page = format!("#{}", self.name);
        Ok(measures.into_iter().map(|number| number.at(&page)).collect())
    }
}

fn counted(gate: &Gate, scene: &Scene, run: &Run, info: &AllocationInfo) -> Vec<Number> {
    // Steps of an explicit run follow from its limit, to the last one; how others divide the time hangs on the last bits.
    let tolerance = Tolerance::relative(if scene.integrator == Integrator::Explicit { 0.0 } else { 0.02 });
    let count = |quantity: &str, value: u64| Number::new(gate.name, quantity, Label::Count, value as f64, tolerance);
    let work = run.work;
    let steps = run.steps.max(work.accepted);
    let mut all = vec![
        count("steps", steps),
        count("point_steps", steps * run.solid_particles as u64),
        count("factorisations", work.factorisations),
        count("solves", work.solves),
        count("rejected", work.rejected),
    ];
    // What the standard library asks for differs a little from one version to the next.
    let calls = Tolerance { relative: 0.02, absolute: 8.0 };
    let allocations = compiled::quantity(ALLOCATIONS, COMPILED);
    all.push(Number::new(gate.name, &allocations, Label::Count, info.count_total as f64, calls));
    all.push(Number::new(gate.name, "peak_bytes", Label::Count, info.bytes_max as f64, Tolerance::relative(0.05)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gates_are_quick_and_count_the_same_twice() {
        for gate in &GATES {
            let scene = gate.scene().expect("a scene");
            let counts = || {
                let mut run = Err(Lacks("run"));
                let info = measure(|| run = gate.run());
                counted(gate, &scene, &run.expect("a run"), &info)
            };
            let (first, second) = (counts(), counts());
            assert_eq!(first, second, "{}", gate.name);
            let steps = first[1].value;
            assert!(steps > 0.0 && steps < 2e6, "{}: {steps} point-steps", gate.name);
        }
    }

    #[test]
    fn a_step_more_and_an_allocation_in_every_step_are_seen() {
        let gate = named("work-explicit-column").expect("a gate");
        let scene = gate.scene().expect("a scene");
        let mut run = gate.run().expect("a run");
        let info = measure(|| drop(gate.run()));
        let before = counted(gate, &scene, &run, &info);
        run.steps += 1;
        let more = AllocationInfo { count_total: info.count_total + run.steps, ..info };
        let after = counted(gate, &scene, &run, &more);
        let moved: Vec<&str> = before
            .iter()
            .zip(&after)
            .filter(|(was, is)| !was.tolerance.holds(was.value, is.value))
            .map(|(was, _)| was.quantity.as_str())
            .collect();
        assert_eq!(moved, ["steps", "point_steps", &compiled::quantity(ALLOCATIONS, COMPILED)]);
    }
}
