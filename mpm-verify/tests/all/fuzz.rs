//! Inputs without sense: whatever stands in a scene, a checkpoint or a table, no reader panics, hangs, or asks for all memory.
//!
//! A test tries some hundred inputs of each kind; `BOLERO_RANDOM_ITERATIONS=3400000 cargo test -p mpm-verify --test all fuzz::` tries as
//! many as it is told, and `cargo bolero test` looks for them by the branches they take. What was found is tried every time.

use std::collections::BTreeMap;
use std::io::{Write, stderr};
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use mpm_core::checkpoint::{sealed, unsealed};
use mpm_core::drive::{Drive, Monitor, Wish};
use mpm_core::hardware::Hardware;
use mpm_core::run::{model, run_monitored};
use mpm_core::scene::{Flags, Scene, Until};
use mpm_core::stability::choose_step;
use mpm_verify::checkpoint::Kind;
use mpm_verify::experiment::accepted;
use mpm_verify::nightly::history::History;
use mpm_verify::{frames, scenes};

/// Inputs of each kind, if a test is not told how many.
const INPUTS: usize = 400;
/// CPU time that no input may take: what a reader does is bounded, whatever else the machine does.
const PATIENCE: Duration = Duration::from_secs(5);

/// Decisions, taken from the bytes of an input one after the other; zeros when there are no more.
struct Dice<'a>(&'a [u8]);

impl Dice<'_> {
    fn byte(&mut self) -> usize {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        usize::from(*first)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.byte() << 16 | self.byte() << 8 | self.byte()) % count.max(1)
    }
}

/// Numbers and words that break readers.
const HOSTILE: [&str; 34] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "1e-320",
    "1e308",
    "-1e308",
    "1e309",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "4294967296",
    "1e15",
    "0x7fffffff",
    "1_000",
    "1e-9",
    "0.1",
    "true",
    "\"\"",
    "\"../../etc/passwd\"",
    "\"\\u0000\"",
    "\"a\\nb\"",
    "[]",
    "[[]]",
    "[1, 2, 3]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "\"top\"",
    "'",
    "#",
];

/// A text with some changes: lines swapped, dropped and doubled, values replaced, bytes thrown in, brackets nested.
fn changed(text: &str, dice: &mut Dice) -> Vec<u8> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=dice.byte() % 6 {
        let at = dice.below(lines.len());
        match dice.byte() % 10 {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[dice.below(lines.len())].clone()),
            2 => {
                let other = dice.below(lines.len());
                lines.swap(at, other);
            }
            3..=6 => {
                let value = HOSTILE[dice.below(HOSTILE.len())];
                let key = lines[at].split(['=', ',']).next().unwrap_or("").to_owned();
                let separator = if lines[at].contains('=') { "=" } else { "," };
                lines[at] = format!("{key}{separator} {value}");
            }
            7 => lines[at] = "[".repeat(1 << (dice.byte() % 16)),
            8 => {
                lines[at] =
                    format!("{} = {}", "a.".repeat(1 << (dice.byte() % 12)) + "a", HOSTILE[dice.below(HOSTILE.len())])
            }
            _ => lines[at].push_str(&"9".repeat(1 << (dice.byte() % 14))),
        }
        if lines.is_empty() {
            break;
        }
    }
    let mut bytes = lines.join("\n").into_bytes();
    for _ in 0..dice.byte() % 4 {
        let at = dice.below(bytes.len());
        match dice.byte() % 3 {
            0 if !bytes.is_empty() => bytes[at] = dice.byte() as u8,
            1 => bytes.insert(at, dice.byte() as u8),
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// What is being tried, since when, and its input.
type Tried = (Instant, String, Vec<u8>);

/// By thread.
static TRIED: Mutex<BTreeMap<String, Tried>> = Mutex::new(BTreeMap::new());

/// Does something in time. What never ends is ended, by another thread, with the input that it was given.
fn in_time(what: &str, input: &[u8], work: impl FnOnce()) {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        std::thread::spawn(|| {
            loop {
                std::thread::sleep(PATIENCE);
                for (start, what, input) in TRIED.lock().expect("no panic in it").values() {
                    if start.elapsed() > 6 * PATIENCE {
                        let text = String::from_utf8_lossy(input);
                        // Not `eprintln!`: what a test prints is lost when its process ends here.
                        let _ = writeln!(stderr(), "{what}: no end for {} bytes:\n{text}", input.len());
                        std::process::abort();
                    }
                }
            }
        });
    });
    let thread = format!("{:?}", std::thread::current().id());
    let clock = ThreadTime::now();
    TRIED.lock().expect("no panic in it").insert(thread.clone(), (Instant::now(), what.to_owned(), input.to_vec()));
    work();
    let took = clock.elapsed();
    TRIED.lock().expect("no panic in it").remove(&thread);
    assert!(took < PATIENCE, "{what}: {took:?} for {} bytes: {:?}", input.len(), String::from_utf8_lossy(input));
}

/// So small that it can be run a little.
fn is_small(scene: &Scene) -> bool {
    let cells = (scene.cells[0] + scene.empty_cells_beside) * (scene.cells[1] + scene.empty_cells_above);
    cells <= 400 && scene.solid_particles() <= 1000 && !scene.may_fail()
}

/// Ends a run after some looks, and saves its state.
struct Short {
    looks: usize,
    state: Option<Vec<u8>>,
}

impl Monitor for Short {
    fn look(&mut self, _: f64) -> Wish {
        self.looks = self.looks.saturating_sub(1);
        if self.looks == 0 { Wish::Stop } else { Wish::GoOn }
    }

    fn save(&mut self, state: Vec<u8>) {
        self.state = Some(state);
    }
}

/// The first steps of a scene.
fn begin(scene: &Scene, state: Option<&[u8]>) -> Option<Vec<u8>> {
    let dt = choose_step(scene).ok()?;
    let shortened = scene.edited(|scene| {
        for stage in &mut scene.stages {
            if let (Until::Time(end), true) = (&mut stage.until, dt.is_finite()) {
                *end = end.min(20.0 * dt);
            }
        }
        if let Some(Until::Time(end)) = scene.stages.last().map(|stage| stage.until) {
            scene.observe_times = vec![0.5 * end, end];
        }
        scene.history = scene.history.min(3);
    });
    let scene = shortened.expect("a shorter run of a sound scene");
    let mut short = Short { looks: 3, state: None };
    let _ = run_monitored(&Hardware::default(), &scene, state, &mut short);
    short.state
}

#[test]
fn scenes_are_read_or_refused() {
    bolero::check!().with_iterations(INPUTS).with_max_len(96).for_each(|input: &[u8]| {
        let mut dice = Dice(input);
        let (name, text) = scenes::BUILT_IN[dice.below(scenes::BUILT_IN.len())];
        let bytes = changed(text, &mut dice);
        let text = String::from_utf8_lossy(&bytes);
        let words = ["explicit", "semi-implicit", "quasi-static", "staggered", "nonsense"];
        let flags = Flags {
            integrator: (dice.byte() % 4 == 1).then(|| words[dice.below(words.len())].to_owned()),
            cell: (dice.byte() % 8 == 1).then_some([0.0, -1.0, 1e-300, f64::NAN, 0.05][dice.below(5)]),
            ..Flags::default()
        };
        in_time(name, &bytes, || match Scene::parse_with(&text, name, &flags) {
            Err(refused) => assert!(!refused.to_string().is_empty()),
            Ok(scene) => {
                let _ = choose_step(&scene);
                // Building and running is dear: some of those that are small.
                if is_small(&scene) && dice.byte() % 8 == 0 {
                    begin(&scene, None);
                }
            }
        });
    });
}

/// Lines of scenes that were found to panic, to ask for all memory, or to have no end; and the integrator they were run with.
const FOUND: [(&str, &str, &str, Option<&str>); 6] = [
    ("rising-front", "hydraulic_conductivity", "4294967296", None),
    ("slope-seepage", "porosity", "1e-9", None),
    ("slope-seepage", "porosity", "1e-320", None),
    ("terzaghi-semi-implicit", "pressure", "1.0e49", Some("quasi-static")),
    ("collapse-dry", "width", "1e308", None),
    ("collapse-dry", "cell", "1e-320", None),
];

#[test]
fn what_was_found_before_is_read_or_refused_too() {
    for (name, key, value, integrator) in FOUND {
        let (_, text) = scenes::BUILT_IN.iter().find(|(built_in, _)| *built_in == name).expect("a scene");
        let start = format!("{key} = ");
        let changed = |line: &str| if line.starts_with(&start) { start.clone() + value } else { line.to_owned() };
        let lines: Vec<String> = text.lines().map(changed).collect();
        assert_eq!(lines.iter().filter(|line| **line == start.clone() + value).count(), 1, "{name} {key}");
        let flags = Flags { integrator: integrator.map(str::to_owned), ..Flags::default() };
        in_time(name, value.as_bytes(), || {
            if let Ok(scene) = Scene::parse_with(&lines.join("\n"), name, &flags) {
                begin(&scene, None);
            }
        });
    }
}

/// States of small scenes, one of each integrator and water.
fn states() -> Vec<(Scene, Vec<u8>)> {
    let names = [
        "terzaghi-semi-implicit",
        "mandel",
        "terzaghi-large-strain",
        "dam",
        "block-weakens",
        "dry-bar",
        "infiltration",
    ];
    let states = names.into_iter().map(|name| {
        let scene = scenes::built_in(name).expect("it holds").edited(|scene| scene.history = 4).expect("a sound scene");
        let mut short = Short { looks: 3, state: None };
        run_monitored(&Hardware::default(), &scene, None, &mut short).expect("a run");
        (scene, short.state.expect("a state"))
    });
    states.collect()
}

#[test]
fn states_are_restored_or_refused() {
    const KIND: Kind = Kind { magic: b"MPMSCENE", version: 1, of: "a scene" };
    let states = states();
    let plan = [7; 32];
    bolero::check!().with_iterations(INPUTS).with_max_len(64).for_each(|input: &[u8]| {
        let mut dice = Dice(input);
        let (scene, state) = &states[dice.below(states.len())];
        // What a file holds, damaged anywhere.
        let mut file = KIND.bytes(&plan, &[b"{}", &state[..state.len().min(200)]]);
        let at = dice.below(file.len());
        match dice.byte() % 3 {
            0 => file[at] ^= 1 << (dice.byte() % 8),
            1 => file.truncate(at),
            _ => drop(file.splice(at..at, input.iter().copied())),
        }
        in_time("a file", &file, || assert!(KIND.parts::<2>(&file, &plan).is_err() || input.is_empty()));
        // What a state holds, changed by someone who knows how to seal it.
        let of = state[8..40].try_into().expect("a hash");
        let mut inside = unsealed(state, &of).expect("a whole state").to_vec();
        for _ in 0..=dice.byte() % 3 {
            let at = dice.below(inside.len());
            match dice.byte() % 5 {
                0 => inside[at] ^= 1 << (dice.byte() % 8),
                1 => inside.truncate(at),
                2 => drop(inside.splice(at..at, input.iter().copied())),
                3 => inside[at] = 255,
                _ => {
                    let end = (at + 8).min(inside.len());
                    let number = [f64::NAN, f64::INFINITY, -1e300, 0.0][dice.below(4)].to_le_bytes();
                    inside[at..end].copy_from_slice(&number[..end - at]);
                }
            }
            if inside.is_empty() {
                break;
            }
        }
        let dt = choose_step(scene).expect("a step");
        in_time("a state", input, || {
            let mut model = model(scene).expect("a model");
            let _ = Drive::new(scene, model.as_mut(), dt).restore(&sealed(&inside, &of));
        });
    });
}

#[test]
fn a_run_with_nonsense_in_its_state_ends_with_a_word() {
    let mut random = mpm_core::random::Random(7);
    let mut dice = || random.bits() as usize;
    for (scene, state) in states() {
        let of = state[8..40].try_into().expect("a hash");
        for _ in 0..12 {
            let mut inside = unsealed(&state, &of).expect("a whole state").to_vec();
            // In the part of the model: numbers that are none, or far away.
            let at = inside.len() / 2 + dice() % (inside.len() / 2 - 8);
            let number = [f64::NAN, f64::INFINITY, -1e300, 1e9][dice() % 4].to_le_bytes();
            inside[at..at + 8].copy_from_slice(&number);
            let mut short = Short { looks: 1, state: None };
            in_time(&scene.name, &[], || {
                let _ = run_monitored(&Hardware::default(), &scene, Some(&sealed(&inside, &of)), &mut short);
            });
        }
    }
}

#[test]
fn tables_are_read_or_refused() {
    let baselines = include_str!("../../../reference-data/baselines/accepted.csv");
    let some: String = baselines.lines().take(40).map(|line| format!("{line}\n")).collect();
    let history = "date,commit,case,quantity,value\n2026-01-01,c,a,error,1.0\n2026-01-01,c,nightly,moved,0.0\n2026-01-02,d,a,error,\n";
    let frames = {
        let shot = frames::Shot::default();
        let mut bytes = Vec::new();
        frames::write_to(&[shot.clone(), shot], &mut bytes).expect("frames");
        bytes
    };
    bolero::check!().with_iterations(INPUTS).with_max_len(96).for_each(|input: &[u8]| {
        let mut dice = Dice(input);
        let which = dice.byte() % 3;
        let bytes = match which {
            0 => changed(&some, &mut dice),
            1 => changed(history, &mut dice),
            _ => changed(&String::from_utf8_lossy(&frames), &mut dice),
        };
        let text = String::from_utf8_lossy(&bytes);
        in_time("a table", &bytes, || match which {
            0 => drop(accepted::parse(&text, "accepted.csv")),
            1 => drop(History::parse(&text, "history.csv")),
            _ => drop(frames::read_from(&mut bytes.as_slice())),
        });
    });
}
