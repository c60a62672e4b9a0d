//! Verdicts follow the numbers: a run that agrees with everything said, and one changed number for each kind of rule.

use mpm_core::failure::Phase;
use mpm_core::observe::{Frame, SolidState};

use super::*;

fn row(time_h: f64, moved: f64) -> Row {
    Row {
        time_h,
        phase: Phase::Seepage,
        front_x_m: 9.0,
        toe_x_m: 9.0,
        max_displacement_m: moved,
        water_m3: 2.9,
        water_particles: 540,
        steps: 1,
        ..Row::default()
    }
}

/// What a run left, to be changed.
struct Run {
    ended: Ended,
    rows: Vec<Row>,
    paths: Vec<PathPoint>,
    events: Events,
    shots: Vec<Shot>,
}

impl Run {
    /// As the paper says.
    fn papers() -> Self {
        let soil = |x: f64, moved: f64, strain: f64| SolidState {
            id: 0,
            velocity: [0.0; 2],
            stress: [0.0; 4],
            volume: 0.0,
            x: [x + moved, 0.1],
            displacement: [moved, 0.0],
            pore_pressure: 500.0,
            deviator_strain: strain,
            mass: 1.0,
        };
        let shot = |hours: f64, moved: f64| {
            let mut toe = soil(8.8, moved, moved);
            // Water is not there at the start.
            toe.pore_pressure *= f64::from(u8::from(hours > 8.0));
            Shot {
                phase: String::new(),
                time_s: 3600.0 * hours,
                frame: Frame { solid: vec![toe, soil(1.0, 0.0, 0.0)], ..Frame::default() },
            }
        };
        let point = |time_h: f64, x_m: f64, shear_pa: f64| PathPoint {
            time_h,
            point: 1,
            x_m,
            y_m: 0.5,
            mean_pa: 10e3,
            shear_pa,
            pore_pa: 0.0,
        };
        // c cos(30) + s' sin(30) = 5.433 kPa.
        let paths = vec![point(6.0, 7.0, 3e3), point(8.66, 7.0, 5.43e3), point(8.68, 7.5, 4e3)];
        let events = Events {
            front_at_toe_h: Some(8.5),
            first_outflow_h: Some(8.5),
            unsettled_h: Some(8.6),
            raveling_h: Some(8.6),
            failure_h: Some(8.66),
            collapse_h: Some(8.67),
            failure_at_m: Some(8.0),
            displacement_before_toe_m: 1e-4,
            displacement_before_failure_m: 1e-2,
        };
        let rows = vec![row(6.0, 0.0), row(8.4, 1e-4), row(8.66, 0.1), row(8.68, 1.5)];
        let shots = vec![shot(6.0, 0.0), shot(8.66, 0.1), shot(8.68, 1.5)];
        Self { ended: Ended::Collapsed, rows, paths, events, shots }
    }

    /// As the experiment went.
    fn experiments() -> Self {
        let mut run = Self::papers();
        let (failure, collapse) = (13.0, 13.0 + 10.0 / 60.0);
        run.events.raveling_h = Some(12.5);
        (run.events.failure_h, run.events.collapse_h) = (Some(failure), Some(collapse));
        run.rows.push(row(collapse + 30.0 / 3600.0, 1.5));
        run
    }

    fn verdict(&self, name: &str) -> Verdict {
        let strength = Some(Strength { cohesion_kpa: 0.5, friction_deg: 30.0 });
        let Self { ended, rows, paths, events, shots } = self;
        let all = judge(&Evidence { ended, rows, paths, events, shots, strength, toe_m: 9.0 });
        all.into_iter().find(|c| c.claim == name).expect(name).verdict
    }
}

const OF_PAPER: [&str; 9] = [
    "stands",
    "unchanged-until-8.4-h",
    "failure-time",
    "final-shape-time",
    "failure-lasts",
    "pressure-at-toe",
    "starts-at-toe",
    "large-strain",
    "stress-paths",
];
const OF_EXPERIMENT: [&str; 4] = ["experiment-toe", "experiment-failure", "experiment-progressive", "experiment-rapid"];

#[test]
fn a_run_like_the_paper_s_or_the_experiment_s_is_reproduced() {
    for name in OF_PAPER {
        assert_eq!(Run::papers().verdict(name), Verdict::Reproduced, "{name}");
    }
    for name in OF_EXPERIMENT {
        assert_eq!(Run::experiments().verdict(name), Verdict::Reproduced, "{name}");
    }
    assert_eq!(rules::RULES.len(), OF_PAPER.len() + OF_EXPERIMENT.len());
}

#[test]
fn one_number_turns_every_verdict() {
    type Change = fn(&mut Run);
    let changes: [(&str, Change); 17] = [
        ("stands", |r| r.rows[0].phase = Phase::Failing),
        ("stands", |r| r.ended = Ended::DoesNotStand("it slides".to_owned())),
        ("unchanged-until-8.4-h", |r| r.rows[1].max_displacement_m = 0.011),
        ("unchanged-until-8.4-h", |r| r.rows[1].toe_x_m = 9.02),
        ("failure-time", |r| r.events.failure_h = Some(8.77)),
        ("final-shape-time", |r| r.rows[3].time_h = 8.79),
        ("failure-lasts", |r| r.rows[3].time_h = 8.66 + 35.0 / 3600.0),
        ("pressure-at-toe", |r| {
            r.events.front_at_toe_h = Some(8.67);
            r.shots.iter_mut().take(2).for_each(|s| s.frame.solid[0].pore_pressure = 50.0);
        }),
        ("pressure-at-toe", |r| r.shots[1].frame.solid[0].pore_pressure = 0.0),
        ("pressure-at-toe", |r| r.events.front_at_toe_h = Some(8.1)),
        ("pressure-at-toe", |r| r.shots[0].frame.solid[0].pore_pressure = 150.0),
        ("starts-at-toe", |r| r.events.failure_at_m = Some(5.9)),
        ("large-strain", |r| r.shots[2].frame.solid[0].deviator_strain = 0.04),
        // Only from the start of failure on.
        ("stress-paths", |r| r.paths[1].time_h = 8.65),
        ("experiment-toe", |r| r.events.raveling_h = Some(13.01)),
        ("experiment-failure", |r| r.events.failure_h = Some(13.51)),
        ("experiment-progressive", |r| r.events.failure_h = Some(12.99)),
    ];
    for (name, change) in changes {
        let mut run = if OF_PAPER.contains(&name) { Run::papers() } else { Run::experiments() };
        change(&mut run);
        assert_eq!(run.verdict(name), Verdict::NotReproduced, "{name}");
    }
    let mut run = Run::experiments();
    run.rows.push(row(13.0 + 10.0 / 60.0 + 61.0 / 3600.0, 1.5));
    assert_eq!(run.verdict("experiment-rapid"), Verdict::NotReproduced);
}

#[test]
fn a_run_that_does_not_fail_is_compared_where_it_can_be() {
    let mut run = Run::papers();
    run.ended = Ended::TimeOver;
    run.events = Events::default();
    for name in OF_PAPER.into_iter().chain(OF_EXPERIMENT) {
        let expected = if OF_PAPER[..2].contains(&name) { Verdict::Reproduced } else { Verdict::NotComparable };
        assert_eq!(run.verdict(name), expected, "{name}");
    }
    // A run that ends before 8.4 h says nothing about it.
    run.rows.truncate(1);
    assert_eq!(run.verdict("unchanged-until-8.4-h"), Verdict::NotComparable);
}

#[test]
fn the_table_has_its_fixed_columns_first() {
    let run = Run::papers();
    let Run { ended, rows, paths, events, shots } = &run;
    let claims = judge(&Evidence { ended, rows, paths, events, shots, strength: None, toe_m: 9.0 });
    let folder = tempfile::tempdir().expect("a folder");
    write(&claims, folder.path()).expect("written");
    let text = std::fs::read_to_string(folder.path().join("claims.csv")).expect("a table");
    assert!(text.starts_with("claim,paper,value,verdict,rule\nstands,"));
    assert_eq!(text.lines().count(), 1 + rules::RULES.len());
    assert!(text.contains(",not comparable,") && text.contains(",reproduced,"));
}
