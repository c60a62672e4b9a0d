//! Under which conditions numbers were obtained: every report carries this.

use mpm_core::hash::{hex, sha256};
use mpm_core::scene::{Fields, Scene};
use serde::{Deserialize, Serialize};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::provenance::{self, Made};

/// The conditions of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from, with `-dirty` if its sources differed from it, or `unknown` ([`crate::provenance`]).
    pub commit: String,
    /// Compiler.
    pub compiler: String,
    /// Target triple.
    pub target: String,
    /// Debug or release.
    pub profile: String,
    /// Optional cargo features that were on.
    pub features: String,
    /// Processor.
    pub cpu: String,
    /// Vector instructions that the explicit step in plane strain uses.
    #[serde(default)]
    pub vectors: String,
    /// Threads that the job used.
    pub threads: usize,
    /// When, UTC.
    pub date: String,
    /// Hash of the base scene.
    pub scene_hash: String,
    /// How the program was called.
    pub command: String,
    /// Hash of the sources that the program was built from; empty in manifests of versions without it.
    #[serde(default)]
    pub sources: String,
}

impl Manifest {
    /// The conditions now.
    pub fn new(scene: &Scene, threads: usize) -> Self {
        let date = OffsetDateTime::now_utc();
        let date = date.replace_nanosecond(0).unwrap_or(date);
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: provenance::commit().to_owned(),
            compiler: env!("MPM_COMPILER").to_owned(),
            target: env!("MPM_TARGET").to_owned(),
            profile: provenance::PROFILE.to_owned(),
            features: "none (there are none)".to_owned(),
            cpu: cpu(),
            vectors: mpm_core::hardware::instructions().to_owned(),
            threads,
            date: date.format(&Rfc3339).unwrap_or_default(),
            scene_hash: scene_hash(scene),
            command: command(),
            sources: provenance::SOURCES.to_owned(),
        }
    }

    /// Commit, hash of the sources and profile of the program that made the run.
    pub fn made(&self) -> Made {
        Made { commit: self.commit.clone(), sources: self.sources.clone(), profile: self.profile.clone() }
    }

    /// The same without all that differs from run to run, and with a command that says as much.
    pub fn without_times(self, command: &str) -> Self {
        let left_out = || "left out".to_owned();
        let command = format!("mpm-verify {command}");
        Self { cpu: left_out(), vectors: left_out(), threads: 0, date: left_out(), command, ..self }
    }

    /// Names and values in a fixed order.
    pub fn entries(&self) -> [(&'static str, String); 13] {
        [
            ("version", self.version.clone()),
            ("commit", self.commit.clone()),
            ("compiler", self.compiler.clone()),
            ("target", self.target.clone()),
            ("profile", self.profile.clone()),
            ("features", self.features.clone()),
            ("cpu", self.cpu.clone()),
            ("vectors", self.vectors.clone()),
            ("threads", self.threads.to_string()),
            ("date", self.date.clone()),
            ("scene hash", self.scene_hash.clone()),
            ("command", self.command.clone()),
            ("sources", self.sources.clone()),
        ]
    }
}

/// The arguments as given, without the path of the program.
fn command() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("mpm-verify {}", arguments.join(" ")).trim().to_owned()
}

fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name"));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |n| n.trim_start_matches([' ', '\t', ':']).to_owned())
}

/// Hash of a scene as JSON: tells scenes apart, nothing more.
pub fn scene_hash(scene: &Fields) -> String {
    let text = serde_json::to_string(scene).unwrap_or_default();
    short_hash(text.as_bytes())
}

/// First 16 hexadecimal digits of a hash: enough to tell apart what one folder holds.
pub fn short_hash(bytes: &[u8]) -> String {
    hex(&sha256(bytes)[..8])
}
