//! Runs cases: all of them or one share, several at a time, those that are done taken over from the disk.
//!
//! A case that fails is a result with a reason, and takes no other down. A stop lets no new case begin, breaks off those under
//! way, and says what is missing.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use super::plan::{PAPERS, work};
use super::store::Store;
use super::{Case, CaseResult, REPETITIONS, Watched, word};
use crate::error::Error;
use crate::experiment::pool;
use crate::progress::Progress;
use crate::unpanicked::unpanicked;

/// A case, and how it is run.
#[derive(Debug, Clone)]
pub struct Task {
    /// Its name among all tasks: that of a file as well.
    pub key: String,
    /// The case.
    pub case: Case,
    /// Whether a quick one is run again for its time.
    pub again: bool,
}

/// Which tasks are run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    /// All.
    All,
    /// None: what is not stored is missing.
    Stored,
    /// Every `of`-th, from number `which` (1 to `of`) on. Long ones come first, so that shares are alike.
    Part {
        /// Number of the share, from 1.
        which: usize,
        /// Shares.
        of: usize,
    },
}

impl Share {
    /// Whether it has the task of a number, from 0.
    pub fn has(self, number: usize) -> bool {
        match self {
            Self::All => true,
            Self::Stored => false,
            Self::Part { which, of } => number % of == which - 1,
        }
    }
}

/// A line of the list of tasks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Listed {
    /// Number, from 0.
    pub number: usize,
    /// Name of the task.
    pub case: String,
    /// Time integrator.
    pub integrator: String,
    /// Shape functions.
    pub scheme: String,
    /// What carries the load.
    pub load: String,
    /// Cell edge, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Predicted work, in explicit point-steps.
    pub work: f64,
}

impl Listed {
    fn new(number: usize, task: &Task) -> Self {
        let scene = &task.case.scene;
        Self {
            number,
            case: task.key.clone(),
            integrator: word(scene.integrator),
            scheme: word(scene.shape),
            load: word(scene.surcharge.map(|s| s.on)),
            mesh_m: scene.cell,
            ppc: scene.particles_per_cell,
            work: work(scene),
        }
    }
}

/// Runs tasks.
#[derive(Debug)]
pub struct Runner<'a> {
    /// Which.
    pub share: Share,
    /// Threads.
    pub jobs: usize,
    /// Told of every case that is done.
    pub progress: &'a Progress,
    /// What is done already, and keeps what is done.
    pub store: Option<Store>,
    /// Set when it is to stop.
    pub stop: Arc<AtomicBool>,
    /// Whether times are kept: without them a result depends on program and case alone.
    pub times: bool,
    /// Whether tasks are only listed.
    pub lists: bool,
    /// All tasks that were asked for.
    pub listed: Vec<Listed>,
    /// Names of those that were not run.
    pub missing: Vec<String>,
    /// Names of those whose results could not be kept, and why.
    pub unkept: Vec<String>,
    /// Tasks that were done already.
    pub taken_over: usize,
}

impl<'a> Runner<'a> {
    /// Runs everything here and now.
    pub fn whole(jobs: usize, progress: &'a Progress) -> Self {
        Self {
            share: Share::All,
            jobs,
            progress,
            store: None,
            stop: Arc::default(),
            times: true,
            lists: false,
            listed: Vec::new(),
            missing: Vec::new(),
            unkept: Vec::new(),
            taken_over: 0,
        }
    }

    /// Runs tasks, one at a time per thread in the given order; `None` for those that are missing.
    ///
    /// # Errors
    /// A fault of the program beside the cases.
    pub fn run(&mut self, tasks: &[Task]) -> Result<Vec<Option<CaseResult>>, Error> {
        let first = self.listed.len();
        self.listed.extend(tasks.iter().enumerate().map(|(i, task)| Listed::new(first + i, task)));
        if self.lists {
            return Ok(vec![None; tasks.len()]);
        }
        let taken = |task: &Task| self.store.as_ref().and_then(|store| store.get(&task.key, &task.case.scene));
        let known: Vec<Option<CaseResult>> = tasks.iter().map(taken).collect();
        self.taken_over += known.iter().flatten().count();
        let wanted = |i: usize| known[i].is_none() && self.share.has(first + i);
        let sum = |of: &dyn Fn(usize) -> bool| -> f64 {
            (0..tasks.len()).filter(|i| of(*i)).map(|i| work(&tasks[i].case.scene)).sum()
        };
        self.progress.begin(sum(&|_| true), sum(&wanted));
        let (store, progress, stop, times) = (self.store.as_ref(), self.progress, &self.stop, self.times);
        let one = |i: usize, task: &Task| {
            if !wanted(i) || stop.load(Ordering::Relaxed) {
                return (None, None);
            }
            let (own, mut before) = (work(&task.case.scene), 0.0);
            let mut told = |share: f64| {
                progress.add((share - before).max(0.0) * own);
                before = before.max(share);
            };
            let Some(mut result) = task.result(&mut told, stop) else { return (None, None) };
            told(1.0);
            if !times {
                (result.cpu_s, result.ns_per_point_step) = (f64::NAN, f64::NAN);
            }
            progress.line(&result.line());
            let kept = store.map_or(Ok(()), |store| store.keep(&task.key, &task.case.scene, &result));
            (Some(result), kept.err().map(|e| format!("{}: {e}", task.key)))
        };
        // The paper's own setting is run alone, so that the first result comes soon.
        let alone = usize::from(tasks.first().is_some_and(|task| task.key == PAPERS));
        let (first_task, others) = tasks.split_at(alone);
        let mut ran: Vec<(Option<CaseResult>, Option<String>)> = first_task.iter().map(|task| one(0, task)).collect();
        let rest = pool::each(self.jobs, others, |i, task| one(alone + i, task), |_, _| {});
        ran.extend(rest.into_iter().collect::<Result<Vec<_>, _>>()?);
        let mut results = Vec::with_capacity(tasks.len());
        for ((task, known), (ran, unkept)) in tasks.iter().zip(known).zip(ran) {
            self.unkept.extend(unkept);
            let result = known.or(ran);
            if result.is_none() {
                self.missing.push(task.key.clone());
            }
            results.push(result);
        }
        Ok(results)
    }
}

impl Task {
    /// The result of the case, whatever happens to it; `None` if it was stopped.
    fn result(&self, told: &mut dyn FnMut(f64), stop: &AtomicBool) -> Option<CaseResult> {
        let again = if self.again { REPETITIONS } else { 1 };
        let mut watched = Watched { told, stop };
        let ran = unpanicked(|| self.case.watched(again, &mut watched)).flatten();
        ran.unwrap_or_else(|why| Some(CaseResult::failed(&self.case, why.to_string())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Family, Plan, TOLERANCE, Variant};
    use mpm_core::scene::{Integrator, LoadOn, ShapeChoice};

    fn tasks() -> Vec<Task> {
        let plan = Plan {
            base: crate::scenes::terzaghi(),
            families: vec![Family::whole(Integrator::QuasiStatic, ShapeChoice::Centre)],
            meshes: vec![0.1, 0.05],
            particles_per_cell: vec![1, 4, 9],
            loads: vec![LoadOn::Surface],
            tolerance: TOLERANCE,
            budget: false,
            jobs: 1,
        };
        plan.tasks().expect("a plan")
    }

    #[test]
    fn shares_make_up_the_whole() {
        let (quiet, tasks) = (Progress::new("", true), tasks());
        let with = |share, stored: Option<Store>| {
            let mut runner = Runner { share, store: stored, times: false, ..Runner::whole(1, &quiet) };
            let results = runner.run(&tasks).expect("a pool");
            (results, runner)
        };
        let (whole, _) = with(Share::All, None);
        let folder = tempfile::tempdir().expect("a folder");
        for which in 1..=3 {
            let store = Store::open(&[folder.path()]).expect("a store");
            let (part, runner) = with(Share::Part { which, of: 3 }, Some(store));
            assert_eq!(part.iter().flatten().count(), 2 * which, "its own two, and those of the shares before");
            assert_eq!((runner.missing.len(), runner.taken_over), (6 - 2 * which, 2 * which - 2));
        }
        let (stored, runner) = with(Share::Stored, Some(Store::open(&[folder.path()]).expect("a store")));
        assert!(runner.missing.is_empty());
        // Written out: what is no number is the same as itself.
        assert_eq!(format!("{stored:?}"), format!("{whole:?}"));
        std::fs::remove_file(folder.path().join(format!("{}.json", tasks[4].key))).expect("removed");
        let (_, runner) = with(Share::Stored, Some(Store::open(&[folder.path()]).expect("a store")));
        assert_eq!(runner.missing, [tasks[4].key.clone()]);
    }

    #[test]
    fn a_case_that_panics_is_a_result_and_the_others_are_run() {
        let (quiet, mut tasks) = (Progress::new("", true), tasks());
        // No plan makes such a scene: the mesh has no cells where the particles are.
        tasks[2].case.scene = tasks[2].case.scene.clone().altered_unchecked(|scene| scene.cells = [0, 0]);
        let results = Runner::whole(2, &quiet).run(&tasks).expect("a pool");
        let failed: Vec<usize> = (0..6).filter(|i| results[*i].as_ref().is_none_or(|r| r.failure.is_some())).collect();
        assert_eq!(failed, [2]);
        let failure = results[2].as_ref().and_then(|r| r.failure.clone()).expect("a reason");
        assert!(failure.contains("panicked"), "{failure}");
    }

    #[test]
    fn after_a_stop_nothing_begins_and_all_is_missing() {
        let (quiet, tasks) = (Progress::new("", true), tasks());
        let mut runner = Runner::whole(2, &quiet);
        runner.stop.store(true, Ordering::Relaxed);
        assert!(runner.run(&tasks).expect("a pool").iter().all(Option::is_none));
        assert_eq!(runner.missing.len(), 6);
        assert_eq!(tasks[0].case.variant, Variant::Base);
    }
}
