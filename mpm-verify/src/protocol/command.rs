//! A foreign code as a command, under limits of time, memory and output, with what it and all that it starts have taken.
//!
//! Every process of a run carries a mark in its environment, which its children inherit; so do those that leave the group of the command
//! or outlive it. None is left running.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File};
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System, UpdateKind};

use super::results::Cost;
use crate::error::Error;

/// Name of the mark.
const MARK: &str = "MPM_VERIFY_SCORE";
/// Where what a command prints goes.
pub const LOG: &str = "log.txt";
/// First and longest time between two looks.
const LOOKS: [Duration; 2] = [Duration::from_millis(5), Duration::from_millis(100)];
/// How long processes that are ended may take to go.
const GOING: Duration = Duration::from_secs(5);
/// Bytes at the end of what was printed that are looked at for a reason.
const SHOWN: u64 = 4000;
/// Words of a line that says why a code does not answer a case.
const REFUSED: &str = "not answered";

/// What a command may take.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Time on the clock.
    pub time: Duration,
    /// Memory of all processes at once, MiB.
    pub memory_mib: f64,
    /// Size of what it writes into its folder, MiB.
    pub output_mib: f64,
}

/// How a command ended.
#[derive(Debug)]
pub struct Ended {
    /// What it took.
    pub cost: Cost,
    /// Why its results do not count; `None` where it ended well.
    pub failed: Option<String>,
    /// What else is to be told.
    pub note: Option<String>,
}

/// A command of a shell, with `{case}`, `{out}` and `{refinement}` replaced.
pub fn filled(template: &str, case: &Path, out: &Path, refinement: f64) -> String {
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', r"'\''"));
    let text = template.replace("{case}", &quoted(case)).replace("{out}", &quoted(out));
    text.replace("{refinement}", &refinement.to_string())
}

/// CPU time of all children that have ended, s.
fn children_cpu() -> f64 {
    #[cfg(unix)]
    if let Ok(usage) = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_CHILDREN) {
        let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64;
        return seconds(usage.user_time()) + seconds(usage.system_time());
    }
    0.0
}

/// The processes of a run.
struct Watched {
    system: System,
    mark: String,
    known: HashSet<Pid>,
    /// CPU time of each, s.
    cpu: HashMap<Pid, f64>,
    peak_mib: f64,
}

impl Watched {
    fn new(mark: String) -> Self {
        Self { system: System::new(), mark, known: HashSet::new(), cpu: HashMap::new(), peak_mib: 0.0 }
    }

    /// Looks at all processes; memory of those of the run, MiB.
    fn look(&mut self) -> f64 {
        let what = ProcessRefreshKind::nothing()
            .with_memory()
            .with_cpu()
            .with_environ(UpdateKind::OnlyIfNotSet)
            .without_tasks();
        self.system.refresh_processes_specifics(ProcessesToUpdate::All, true, what);
        let marked = format!("{MARK}={}", self.mark);
        self.known.retain(|pid| self.system.process(*pid).is_some());
        // A child that has lost its mark has a parent that is known; a second pass finds its children.
        for _ in 0..2 {
            for (pid, process) in self.system.processes() {
                let has_mark = process.environ().iter().any(|entry| entry.to_string_lossy() == marked);
                if has_mark || process.parent().is_some_and(|parent| self.known.contains(&parent)) {
                    self.known.insert(*pid);
                }
            }
        }
        let own = self.known.iter().filter_map(|pid| Some((*pid, self.system.process(*pid)?)));
        let mut memory = 0;
        for (pid, process) in own {
            memory += process.memory();
            self.cpu.insert(pid, 1e-3 * process.accumulated_cpu_time() as f64);
        }
        let memory = memory as f64 / f64::from(1 << 20);
        self.peak_mib = self.peak_mib.max(memory);
        memory
    }

    /// Ends all that are left; how many there were.
    fn end(&mut self, child: &mut Child) -> usize {
        let mut ended = HashSet::new();
        let until = Instant::now() + GOING;
        loop {
            self.look();
            let own = Pid::from_u32(child.id());
            let left: Vec<Pid> = self.known.iter().copied().filter(|pid| self.lives(*pid) && *pid != own).collect();
            let _ = child.kill();
            let _ = child.try_wait();
            for pid in &left {
                if let Some(process) = self.system.process(*pid) {
                    process.kill();
                    ended.insert(*pid);
                }
            }
            if left.is_empty() || Instant::now() > until {
                return ended.len();
            }
            std::thread::sleep(LOOKS[0]);
        }
    }

    /// Whether a process runs: one that nobody has waited for is none any more.
    fn lives(&self, pid: Pid) -> bool {
        let gone = |status| matches!(status, sysinfo::ProcessStatus::Zombie | sysinfo::ProcessStatus::Dead);
        self.system.process(pid).is_some_and(|process| !gone(process.status()))
    }
}

/// Size of a folder, MiB. Links are not followed.
fn size_mib(folder: &Path) -> f64 {
    let mut sum = 0.0;
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.metadata() {
            Ok(data) if data.is_dir() => sum += size_mib(&entry.path()),
            Ok(data) => sum += data.len() as f64 / f64::from(1 << 20),
            Err(_) => {}
        }
    }
    sum
}

/// Why a command did not end well: the last line that it has printed, or the last that says what is not answered.
fn printed(path: &Path) -> String {
    let read = || {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(SHOWN)))?;
        let mut bytes = Vec::new();
        file.take(SHOWN).read_to_end(&mut bytes)?;
        Ok::<_, std::io::Error>(String::from_utf8_lossy(&bytes).into_owned())
    };
    let text = read().unwrap_or_default();
    let mut lines = text.lines().rev().filter(|line| !line.trim().is_empty());
    // Libraries say good-bye after the reason.
    let refused = text.lines().rev().find(|line| line.contains(REFUSED));
    let line = refused.or_else(|| lines.next()).unwrap_or("nothing printed");
    line.trim().chars().filter(|c| !c.is_control()).collect()
}

/// Runs a command of the shell in a folder for results.
///
/// # Errors
/// The shell cannot be started, or the file for what is printed not be made. What goes wrong in the command is told in the result.
pub fn run(
    command: &str,
    out: &Path,
    limits: &Limits,
    refinement: f64,
    stop: &dyn Fn() -> bool,
) -> Result<Ended, Error> {
    let log = File::create(out.join(LOG)).map_err(Error::at(out.join(LOG)))?;
    let again = log.try_clone().map_err(Error::at(out))?;
    let began = Instant::now();
    let mark = format!("{}-{}", std::process::id(), out.display());
    let before = children_cpu();
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).env(MARK, &mark).stdin(Stdio::null()).stdout(log).stderr(again);
    let mut child = shell.spawn().map_err(Error::at("sh"))?;
    let mut watched = Watched::new(mark);
    watched.known.insert(Pid::from_u32(child.id()));
    let (mut pause, mut failed) = (LOOKS[0], None);
    let status = loop {
        let memory = watched.look();
        if let Ok(Some(status)) = child.try_wait() {
            break Some(status);
        }
        failed = if began.elapsed() > limits.time {
            Some(format!("took longer than {} s", limits.time.as_secs_f64()))
        } else if memory > limits.memory_mib {
            Some(format!("took {memory:.0} MiB of memory, more than {:.0} MiB", limits.memory_mib))
        } else if size_mib(out) > limits.output_mib {
            Some(format!("wrote more than {:.0} MiB", limits.output_mib))
        } else if stop() {
            Some("stopped".to_owned())
        } else {
            None
        };
        if failed.is_some() {
            break None;
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(LOOKS[1]);
    };
    let wall = began.elapsed().as_secs_f64();
    let left = watched.end(&mut child);
    // One that does not go is not waited for.
    let until = Instant::now() + GOING;
    while matches!(child.try_wait(), Ok(None)) && Instant::now() < until {
        std::thread::sleep(LOOKS[0]);
    }
    if failed.is_none() && size_mib(out) > limits.output_mib {
        failed = Some(format!("wrote more than {:.0} MiB", limits.output_mib));
    }
    // Children that were waited for, and what others had used when they were seen last.
    let counted = children_cpu() - before;
    let seen: f64 = watched.cpu.values().sum();
    let cpu = counted.max(seen);
    let bad = status
        .filter(|status| !status.success())
        .map(|status| format!("ended with {status}: {}", printed(&out.join(LOG))));
    let note = (left > 0 && failed.is_none()).then(|| format!("left {left} processes running, which were ended"));
    let cost = Cost {
        refinement,
        cpu_s: Some(cpu),
        wall_s: Some(wall),
        peak_mib: Some(watched.peak_mib).filter(|peak| *peak > 0.0),
    };
    Ok(Ended { cost, failed: failed.or(bad), note })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { time: Duration::from_secs(20), memory_mib: 4000.0, output_mib: 20.0 };

    fn ended(command: &str, limits: &Limits) -> Ended {
        let folder = tempfile::tempdir().expect("a folder");
        let command = filled(command, Path::new("case.json"), folder.path(), 10.0);
        run(&command, folder.path(), limits, 10.0, &|| false).expect("a shell")
    }

    #[test]
    fn what_goes_wrong_in_a_command_is_named_and_nothing_is_left_running() {
        let short = Limits { time: Duration::from_millis(300), ..LIMITS };
        let good = ended("echo hello; test {refinement} = 10", &LIMITS);
        assert_eq!((good.failed, good.note), (None, None));
        let code = ended("echo something went wrong; exit 3", &LIMITS).failed.expect("a failure");
        assert!(code.contains('3') && code.ends_with("something went wrong"), "{code}");
        let refused = ended("echo not answered: no inertia; echo good-bye; exit 1", &LIMITS).failed.expect("a failure");
        assert!(refused.ends_with("not answered: no inertia"), "{refused}");
        let endless = ended("sleep 60 & while :; do :; done", &short);
        assert!(endless.failed.as_ref().is_some_and(|why| why.contains("longer than 0.3 s")), "{endless:?}");
        assert!(endless.cost.cpu_s > Some(0.01), "{endless:?}");
        let large = ended("head -c 100000000 /dev/zero > {out}/results.csv; sleep 5", &LIMITS);
        assert!(large.failed.is_some_and(|why| why.contains("wrote more than 20 MiB")));
        let stays = ended("(sleep 61 &) ; exec 1>&- ; setsid sleep 62 >/dev/null 2>&1 & sleep 0.2; true", &LIMITS);
        assert!(stays.failed.is_none() && stays.note.is_some_and(|note| note.contains("processes running")));
        let mut system = System::new();
        let what = ProcessRefreshKind::nothing().with_cmd(UpdateKind::Always);
        system.refresh_processes_specifics(ProcessesToUpdate::All, true, what);
        let left = |process: &sysinfo::Process| {
            let words: Vec<_> = process.cmd().iter().map(|word| word.to_string_lossy().into_owned()).collect();
            words.len() == 2 && words[0] == "sleep" && ["60", "61", "62"].contains(&words[1].as_str())
        };
        assert!(!system.processes().values().any(left));
    }
}
