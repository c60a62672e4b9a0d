//! What is done stays done: every finished case is a file of its own, written whole when it ends.
//!
//! A file belongs to a build and to the scene of its case: one of another build or scene is not taken over.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mpm_core::scene::Scene;
use serde::{Deserialize, Serialize};

use super::CaseResult;
use crate::checkpoint::BUILD;
use crate::files;
use crate::manifest::scene_hash;

/// A finished case.
#[derive(Debug, Serialize, Deserialize)]
struct Kept<'a> {
    build: std::borrow::Cow<'a, str>,
    input: String,
    result: std::borrow::Cow<'a, CaseResult>,
}

/// Folders of finished cases. New ones go into the first.
#[derive(Debug, Clone)]
pub struct Store {
    folders: Vec<PathBuf>,
    /// Whether nothing is taken over. What is there stays until it is replaced.
    anew: bool,
}

impl Store {
    /// Opens folders, and makes the first.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn open(folders: &[&Path]) -> io::Result<Self> {
        if let Some(first) = folders.first() {
            fs::create_dir_all(first)?;
        }
        Ok(Self { folders: folders.iter().map(|folder| (*folder).to_owned()).collect(), anew: false })
    }

    /// The same for a study that begins anew.
    pub fn anew(self) -> Self {
        Self { anew: true, ..self }
    }

    /// The result of a case, if it is done. A file that cannot be read is no result.
    pub fn get(&self, key: &str, scene: &Scene) -> Option<CaseResult> {
        let input = scene_hash(scene);
        let known = if self.anew { &[] } else { self.folders.as_slice() };
        known.iter().find_map(|folder| {
            let text = fs::read(folder.join(format!("{key}.json"))).ok()?;
            let kept: Kept = serde_json::from_slice(&text).ok()?;
            (kept.build == BUILD && kept.input == input).then(|| kept.result.into_owned())
        })
    }

    /// Keeps a result.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, key: &str, scene: &Scene, result: &CaseResult) -> io::Result<()> {
        let Some(folder) = self.folders.first() else { return Ok(()) };
        let kept = Kept { build: BUILD.into(), input: scene_hash(scene), result: std::borrow::Cow::Borrowed(result) };
        files::write(&folder.join(format!("{key}.json")), &serde_json::to_vec(&kept)?)
    }
}

/// How every file of a finished case begins.
const BEGINNING: &[u8] = b"{\"build\":";

impl Store {
    /// Removes the finished cases of the first folder, and the folder if nothing else is in it.
    pub fn remove(&self) {
        let Some(folder) = self.folders.first() else { return };
        for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            // What cannot be removed is replaced by the next study.
            if path.extension().is_some_and(|e| e == "json") && begins(&path).is_ok_and(|start| start == BEGINNING) {
                let _ = fs::remove_file(&path);
            }
        }
        let _ = fs::remove_dir(folder);
    }
}

/// The first bytes of a regular file.
fn begins(path: &Path) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    if fs::symlink_metadata(path)?.is_file() {
        fs::File::open(path)?.take(BEGINNING.len() as u64).read_to_end(&mut start)?;
    }
    Ok(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::result;

    #[test]
    fn a_result_comes_back_for_its_own_scene_and_build_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(&[folder.path()]).expect("a store");
        let scene = crate::scenes::terzaghi();
        let mut one = result(0.1, 4, "surface");
        one.max_error_terzaghi = f64::NAN;
        one.cpu_s = 0.1 + 0.2;
        store.keep("one", &scene, &one).expect("kept");
        let back = store.get("one", &scene).expect("a result");
        assert_eq!(format!("{back:?}"), format!("{one:?}"), "to the last bit");
        assert!(store.get("two", &scene).is_none());
        let anew = store.clone().anew();
        assert!(anew.get("one", &scene).is_none(), "a study that begins anew takes nothing over");
        assert!(store.get("one", &scene).is_some(), "and takes nothing away");
        let other = scene.edited(|s| s.porosity = 0.31).expect("a sound scene");
        assert!(store.get("one", &other).is_none());
        let path = folder.path().join("one.json");
        let text = fs::read_to_string(&path).expect("a file");
        fs::write(&path, text.replace(BUILD, "another build")).expect("written");
        assert!(store.get("one", &scene).is_none());
        fs::write(&path, &text[..text.len() / 2]).expect("written");
        assert!(store.get("one", &scene).is_none(), "half a file");
    }
}
