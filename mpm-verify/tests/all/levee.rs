//! A levee from its first moment to its end: stopped runs go on to the same bits; what cannot be run is refused.

use std::fs;
use std::path::Path;
use std::time::Duration;

use mpm_core::failure::Driver;
use mpm_core::scene::Flags;
use mpm_verify::levee::checkpoint::Checkpoint;
use mpm_verify::levee::plan::{self, Plan};
use mpm_verify::levee::run::{Ended, Followed, Hooks, follow};
use mpm_verify::levee::{tables, variants};

/// Moist soil fails early.
fn plan(frames: bool) -> Plan {
    let variant = variants::named("saturation-0.7");
    let flags = Flags { cell: Some(0.4), ..Flags::default() };
    let scene = plan::scene("levee", &flags, variant).expect("a scene");
    Plan::new(scene, None, None, frames).expect("a plan")
}

/// Follows until `stop` says so.
fn until(plan: &Plan, folder: &Path, resume: bool, stop: &mut dyn FnMut(&Driver) -> bool) -> Followed {
    let kept = if resume {
        Some(Checkpoint::read(&plan.fingerprint(), folder).expect("a whole file").expect("a checkpoint"))
    } else {
        None
    };
    let mut hooks = Hooks {
        progress: &mut |_| (),
        stop,
        folder: Some(folder.to_owned()),
        every: Duration::MAX,
        trouble: &mut |e| panic!("{e}"),
    };
    follow(plan, &mut hooks, kept).expect("a run")
}

fn history(plan: &Plan, run: &Followed) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    tables::write(&run.rows, &run.paths, &run.events, plan.levels(), folder.path()).expect("tables");
    fs::read(folder.path().join("history.csv")).expect("a history")
}

#[test]
fn a_run_that_was_stopped_twice_ends_in_the_same_bits() {
    let plan = plan(true);
    let folder = tempfile::tempdir().expect("a folder");
    let whole = until(&plan, folder.path(), false, &mut |_| false);
    assert_eq!(whole.ended, Ended::Collapsed);
    // Once while water seeps, once while soil fails.
    let first = until(&plan, folder.path(), false, &mut |driver| driver.hours() > 6.5);
    assert_eq!((first.ended, first.events.unsettled_h), (Ended::Stopped, None));
    let failing = whole.events.failure_h.expect("a failure");
    let second = until(&plan, folder.path(), true, &mut |driver| driver.hours() > failing);
    assert_eq!(second.ended, Ended::Stopped);
    let last = until(&plan, folder.path(), true, &mut |_| false);
    assert!(history(&plan, &last) == history(&plan, &whole), "other histories");
    assert!(last.shots == whole.shots && last.paths == whole.paths && last.steps == whole.steps);
    assert_eq!(last.ended, Ended::Collapsed);
    let text = String::from_utf8(history(&plan, &whole)).expect("a text");
    assert!(text.starts_with("time_h,phase,") && text.lines().next().is_some_and(|l| l.ends_with(",level_x8_m")));
    // Frames at the start, at every hour, at the events and while it fails.
    let times: Vec<f64> = whole.shots.iter().map(|s| s.hours()).collect();
    assert!(times[0] == 6.0 && times.contains(&7.0) && times.contains(&failing));
    assert!(whole.shots.iter().filter(|s| s.phase == "failing").count() > 5);
}

#[test]
fn a_checkpoint_of_another_plan_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    until(&plan(false), folder.path(), false, &mut |_| true);
    let other = plan(true).fingerprint();
    let error = Checkpoint::read(&other, folder.path()).expect_err("refused").to_string();
    assert!(error.contains("one of others"), "{error}");
}

#[test]
fn frames_change_nothing_and_a_run_may_end_before_its_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut plans = [plan(true), plan(false)];
    for plan in &mut plans {
        plan.until_h = Some(6.6);
    }
    let runs = plans.each_ref().map(|plan| until(plan, folder.path(), false, &mut |_| false));
    assert_eq!(runs[0].rows, runs[1].rows);
    assert!(runs[1].shots.is_empty() && runs[0].ended == Ended::TimeOver);
    assert_eq!(runs[0].rows.last().map(|r| r.time_h), Some(6.6));
}

#[test]
fn the_driver_of_the_scene_takes_over() {
    let flags = Flags { driver: Some("coupled".to_owned()), cell: Some(0.4), ..Flags::default() };
    let scene = plan::scene("levee", &flags, None).expect("a scene");
    let plan = Plan::new(scene.clone(), Some(6.1), Some(6.1001), true).expect("a plan");
    let folder = tempfile::tempdir().expect("a folder");
    let whole = until(&plan, folder.path(), false, &mut |_| false);
    assert!(whole.steps.moving > 100 && whole.steps.seepage > 0);
    until(&plan, folder.path(), false, &mut |driver| driver.hours() > 6.10003);
    let last = until(&plan, folder.path(), true, &mut |_| false);
    assert!(history(&plan, &last) == history(&plan, &whole) && last.shots == whole.shots);
    assert!(
        Plan::new(scene, None, Some(5.0), true).is_err_and(|e| e.to_string().starts_with("--until: expected hours"))
    );
}

#[test]
fn a_scene_without_failure_and_a_levee_that_does_not_stand_are_told_apart() {
    let refused = plan::scene("terzaghi", &Flags::default(), None).expect_err("refused").to_string();
    assert!(refused.contains("coupling = \"full\""), "{refused}");
    let scene = plan::scene("levee", &Flags::default(), variants::named("base-8.5")).expect("a scene");
    let plan = Plan::new(scene, None, None, true).expect("a plan");
    let folder = tempfile::tempdir().expect("a folder");
    let run = until(&plan, folder.path(), false, &mut |_| false);
    let Ended::DoesNotStand(what) = run.ended else { panic!("{:?}", run.ended) };
    assert!(
        what.contains("slides without slowing down, most at (") && run.rows.is_empty() && run.shots.len() == 1,
        "{what}"
    );
}
