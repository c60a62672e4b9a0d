//! What runs cost in counts: steps, point-steps, solves, factorisations, repeated steps, calls of the allocator, and, where
//! callgrind is installed, instructions. The same program counts the same on every machine of a kind, whatever else it does.

use allocation_counter::{AllocationInfo, measure, opt_out};
use cpu_time::ThreadTime;
use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::{Dimension, Fields, Flags, Integrator, Scene, ShapeChoice, TimeMethod, TransferChoice, Until};

use super::compiled::{self, ALLOCATIONS, COMPILED};
use super::{calibration, instructions};
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

/// What the gates have cost.
#[derive(Debug, Default)]
pub struct Counted {
    /// The counts, and the times over that of the kernel.
    pub measures: Vec<Number>,
    /// How instructions were counted, or why they were not.
    pub notes: Vec<String>,
    /// Gates that could not be run, and why.
    pub fell: Vec<String>,
}

/// Runs every gate and counts; with the program's own path also its instructions, if callgrind is installed. A gate that cannot be
/// run takes no other down.
pub fn counts(program: Option<&std::path::Path>) -> Counted {
    let mut all = Counted::default();
    let kernel = calibration::time();
    let counter = program.map(instructions::counter);
    for gate in &GATES {
        let counter = counter.as_ref().and_then(|counter| counter.as_ref().ok());
        let of_gate = || {
            let instructions = counter.map(|counter| counter.measure(gate.name)).transpose()?;
            Ok::<_, Error>((gate.counts(kernel)?, instructions))
        };
        match unpanicked(of_gate) {
            Ok(Ok((measures, instructions))) => {
                all.measures.extend(measures);
                if let Some(None) = instructions {
                    all.notes
                        .push(format!("Instructions of {} were not counted: valgrind does not know all.", gate.name));
                }
                all.measures.extend(instructions.flatten());
            }
            Ok(Err(why)) => all.fell.push(why.to_string()),
            Err(why) => all.fell.push(format!("{}: {why}", gate.name)),
        }
    }
    all.notes.extend(counter.map(|counter| match counter {
        Ok(counter) => format!("Instructions: {}, without those of a run of nothing.", counter.with),
        Err(why) => format!("Instructions were not counted: {why}."),
    }));
    all
}

impl Gate {
    /// What it costs, and its time over that of the kernel (s).
    fn counts(&self, kernel: f64) -> Result<Vec<Number>, Error> {
        let scene = self.scene()?;
        let mut outcome = Err(Lacks("run"));
        let info = measure(|| outcome = self.run());
        let mut measures = counted(self, &scene, &outcome?, &info);
        let mut times = [0.0; 3];
        for time in &mut times {
            let clock = ThreadTime::now();
            let mut ended = Ok(());
            opt_out(|| ended = self.run().map(drop));
            ended?;
            *time = clock.elapsed().as_secs_f64();
        }
        times.sort_by(f64::total_cmp);
        measures.push(Number::new(self.name, "time_ratio", Label::Time, times[1] / kernel, Tolerance::relative(0.0)));
        Ok(measures)
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
