//! From which sources the program was built, and which commit these are.
//!
//! The build takes a hash of the sources and knows nothing of git. The commit is asked of git when a report is written: it is that of the
//! workspace in which the program was built, if that still holds the same sources.

use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use mpm_core::hash::{hex, sha256};
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::sources::{self, ROOTS};

/// Hash of the sources that the program was built from.
pub const SOURCES: &str = env!("MPM_SOURCES");
/// The profile that the program was built in.
pub const PROFILE: &str = if cfg!(debug_assertions) { "debug" } else { "release" };
/// In place of a commit: git or the workspace is missing, or the workspace holds other sources than the program was built from.
const UNKNOWN: &str = "unknown";
/// Behind a commit from which the sources of the program differ.
const DIRTY: &str = "-dirty";

/// The commit that the program was built from, with `-dirty` if its sources differ from that commit, or `unknown`. Git is asked once.
pub fn commit() -> &'static str {
    static COMMIT: OnceLock<String> = OnceLock::new();
    let workspace = || Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    COMMIT.get_or_init(|| workspace().and_then(|path| commit_of(path, SOURCES)).unwrap_or_else(|| UNKNOWN.to_owned()))
}

/// The program that made a report.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Made {
    /// Commit ([`commit`]).
    #[serde(default)]
    pub commit: String,
    /// Hash of its sources.
    #[serde(default)]
    pub sources: String,
    /// The profile that it was built in.
    #[serde(default)]
    pub profile: String,
}

impl Made {
    /// The program that runs.
    pub fn here() -> Self {
        Self { commit: commit().to_owned(), sources: SOURCES.to_owned(), profile: PROFILE.to_owned() }
    }

    /// Refuses what a program made that is not that of a commit, in release.
    ///
    /// # Errors
    /// The commit is unknown, the sources differ from it, or the profile is another.
    pub fn publishable(&self, what: &str) -> Result<(), Error> {
        require_clean(what, &self.commit)?;
        if self.profile == "release" && !self.sources.is_empty() {
            return Ok(());
        }
        let found = if self.profile.is_empty() { "unknown" } else { &self.profile };
        Err(Error::refused(
            what,
            "a program in release that says the hash of its sources",
            format!("the profile {found}"),
        ))
    }
}

/// Refuses numbers of a program that is not that of a commit: nobody could build it again. `what` was to be done with them.
///
/// # Errors
/// The commit is unknown, or the sources differ from it.
pub fn require_clean(what: &str, commit: &str) -> Result<(), Error> {
    if !commit.is_empty() && commit != UNKNOWN && !commit.ends_with(DIRTY) {
        return Ok(());
    }
    let expected = "numbers of a program whose sources are those of a commit (commit them, build, and run again)";
    let found = if commit.is_empty() { UNKNOWN } else { commit };
    Err(Error::refused(what, expected, format!("the commit {found}")))
}

/// The commit of a workspace whose sources have the hash `built`; `None` if they do not, or if it is not the root of a git checkout.
fn commit_of(workspace: &Path, built: &str) -> Option<String> {
    let head = git(workspace, &["rev-parse", "--show-prefix", "--short=12", "HEAD"])?;
    // In a checkout of something else the workspace has a prefix.
    let commit = head.strip_prefix('\n')?.trim_end();
    let differs = git(workspace, &[&["status", "--porcelain", "--untracked-files=normal", "--"], &ROOTS[..]].concat())?;
    let now = sources::hash(workspace, |bytes| hex(&sha256(bytes))).ok()?;
    (now == built).then(|| format!("{commit}{}", if differs.is_empty() { "" } else { DIRTY }))
}

/// What git prints about a workspace, without touching its index.
fn git(workspace: &Path, arguments: &[&str]) -> Option<String> {
    let mut git = Command::new("git");
    git.arg("--no-optional-locks").arg("-C").arg(workspace).args(arguments);
    // Within a hook of git these name another checkout.
    git.env_remove("GIT_DIR").env_remove("GIT_WORK_TREE").env_remove("GIT_INDEX_FILE");
    let output = git.output().ok()?;
    output.status.success().then(|| String::from_utf8(output.stdout).ok())?
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;
    use std::time::{Duration, SystemTime};

    use super::*;

    /// A checkout with a file for each root, all committed.
    struct Checkout(tempfile::TempDir);

    impl Checkout {
        fn new() -> Self {
            let own = Self(tempfile::tempdir().expect("a folder"));
            for root in ROOTS {
                let file =
                    if root.contains('.') || root == "Cargo.lock" { root.to_owned() } else { format!("{root}/a") };
                own.write(&file, &format!("{root}\n"));
            }
            own.write(".gitignore", "reports/*\n");
            own.git(&["init", "--quiet"]);
            own.git(&["add", "."]);
            own.git(&["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false", "commit", "-qm", "a"]);
            own
        }

        fn path(&self, file: &str) -> PathBuf {
            self.0.path().join(file)
        }

        fn write(&self, file: &str, text: &str) {
            let path = self.path(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("written");
        }

        fn git(&self, arguments: &[&str]) -> String {
            let output = Command::new("git").arg("-C").arg(self.0.path()).args(arguments).output().expect("git");
            assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8(output.stdout).expect("text").trim().to_owned()
        }

        fn sources(&self) -> String {
            sources::hash(self.0.path(), |bytes| hex(&sha256(bytes))).expect("a hash")
        }

        /// The commit of a program that was built just now.
        fn commit(&self) -> Option<String> {
            commit_of(self.0.path(), &self.sources())
        }
    }

    #[test]
    fn the_commit_is_that_of_the_sources_and_of_nothing_else() {
        let checkout = Checkout::new();
        let (head, built) = (checkout.git(&["rev-parse", "--short=12", "HEAD"]), checkout.sources());
        assert_eq!(checkout.commit().as_deref(), Some(head.as_str()));
        for other in [
            "reports/levee/summary.json",
            "reports/published/levee/summary.json",
            "mpm-bench/src/main.rs",
            "mpm-verify/tests/a.rs",
            "reference-data/baselines/accepted.csv",
            "README.md",
        ] {
            checkout.write(other, "changed");
            assert_eq!(
                (checkout.commit().as_deref(), checkout.sources()),
                (Some(head.as_str()), built.clone()),
                "{other}"
            );
        }
        let dirty = Some(format!("{head}-dirty"));
        for source in ["mpm-core/src/a", "Cargo.lock", "reference-data/cases/new.toml"] {
            let path = checkout.path(source);
            let before = fs::read_to_string(&path).ok();
            checkout.write(source, "changed");
            assert_ne!(checkout.sources(), built, "{source}");
            assert_eq!(checkout.commit(), dirty, "{source}");
            // A program that was built before is neither that of the commit nor that of the tree.
            assert_eq!(commit_of(checkout.0.path(), &built), None, "{source}");
            before.map_or_else(|| fs::remove_file(&path), |text| fs::write(&path, text)).expect("as before");
            assert_eq!(checkout.commit().as_deref(), Some(head.as_str()), "{source}");
        }
    }

    #[test]
    fn the_hash_is_of_names_and_contents_with_any_line_ends() {
        let checkout = Checkout::new();
        let built = checkout.sources();
        checkout.write("mpm-core/src/a", "mpm-core/src\r\n");
        checkout.write("mpm-core/src/.a.swp", "of an editor");
        assert_eq!(checkout.sources(), built);
        fs::rename(checkout.path("mpm-core/src/a"), checkout.path("mpm-core/src/b")).expect("renamed");
        assert_ne!(checkout.sources(), built);
        fs::remove_file(checkout.path("Cargo.toml")).expect("removed");
        assert!(sources::hash(checkout.0.path(), |bytes| hex(&sha256(bytes))).is_err());
    }

    #[test]
    fn asking_for_the_commit_leaves_the_index_as_it_is() {
        let checkout = Checkout::new();
        // Git would note the new time of a file whose content is the same.
        let older = SystemTime::now() - Duration::from_secs(3600);
        let touch = |file: &str| fs::File::options().append(true).open(checkout.path(file))?.set_modified(older);
        touch("Cargo.toml").expect("touched");
        let index = || {
            let path = checkout.path(".git/index");
            (fs::read(&path).expect("an index"), fs::metadata(&path).and_then(|file| file.modified()).expect("a time"))
        };
        let before = index();
        assert!(checkout.commit().is_some_and(|commit| !commit.ends_with(DIRTY)));
        assert!(index() == before, "the index was written");
        checkout.git(&["status"]);
        assert!(index() != before, "the test sees no writing of the index");
    }

    #[test]
    fn without_a_checkout_of_its_own_the_commit_is_unknown() {
        let checkout = Checkout::new();
        let inner = checkout.path("copy");
        for root in ROOTS {
            let from = checkout.path(root);
            let file = if from.is_dir() { format!("{root}/a") } else { root.to_owned() };
            checkout.write(&format!("copy/{file}"), &fs::read_to_string(checkout.path(&file)).expect("a file"));
        }
        assert_eq!(commit_of(&inner, &checkout.sources()), None, "the commit of another checkout");
        fs::remove_dir_all(checkout.path(".git")).expect("removed");
        assert_eq!(checkout.commit(), None);
        assert_eq!(commit_of(&checkout.path("gone"), ""), None);
    }

    #[test]
    fn only_numbers_of_a_commit_are_accepted_or_published() {
        assert!(require_clean("--accept", "0123456789ab").is_ok());
        for (commit, found) in [("0123456789ab-dirty", "0123456789ab-dirty"), (UNKNOWN, UNKNOWN), ("", UNKNOWN)] {
            let error = require_clean("--accept", commit).expect_err("refused").to_string();
            assert!(
                error.starts_with("--accept: expected ") && error.ends_with(&format!("the commit {found}")),
                "{error}"
            );
        }
    }

    /// A folder of reference data that is missing in the list would be changed without a trace.
    #[test]
    fn all_reference_data_of_the_program_is_listed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data");
        let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.retain(|name| !ROOTS.contains(&format!("reference-data/{name}").as_str()));
        names.sort();
        // Read by tests and by mpm-bench, or results of this program.
        assert_eq!(names, ["README.md", "SHA256SUMS", "baselines", "peers", "words.csv"]);
    }
}
