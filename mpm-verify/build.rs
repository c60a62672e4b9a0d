//! Notes the commit and the compiler for the manifest of reports.

use std::path::Path;
use std::process::Command;

fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.lines().next().unwrap_or("").to_owned())
}

fn main() {
    let commit = first_line("git", &["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    let changed = first_line("git", &["status", "--porcelain", "--untracked-files=no"]).is_some_and(|s| !s.is_empty());
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let compiler = first_line(&rustc, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=MPM_COMMIT={commit}{}", if changed { "-dirty" } else { "" });
    println!("cargo::rustc-env=MPM_COMPILER={compiler}");
    // Where cargo builds for a profile: target/PROFILE/build/PACKAGE/out.
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let profile =
        Path::new(&out).ancestors().nth(3).and_then(|folder| folder.file_name()?.to_str()).unwrap_or("unknown");
    println!("cargo::rustc-env=MPM_PROFILE={profile}");
    println!("cargo::rustc-env=MPM_TARGET={}", std::env::var("TARGET").unwrap_or_default());
    println!("cargo::rerun-if-changed=../.git/HEAD");
    println!("cargo::rerun-if-changed=../.git/index");
}
