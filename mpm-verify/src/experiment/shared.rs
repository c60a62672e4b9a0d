//! Runs that several cases look at, each for something else: a scene is run once.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::{Fields, Scene};

use super::run::{finished, note_momentum, whole};
use crate::error::Error;

/// Numbers in all runs that are kept: some 200 MiB. Beyond that all are let go.
const MOST: usize = 24 << 20;

/// A run, once it is there; nothing where it failed.
type Kept = Arc<OnceLock<Option<Arc<Run>>>>;

/// Runs by what their scenes say, but for the name.
static RUNS: LazyLock<Mutex<HashMap<String, Kept>>> = LazyLock::new(Mutex::default);

/// Runs a scene to its end, or takes the run of one that says the same.
pub(crate) fn shared(scene: &Scene) -> Result<Arc<Run>, Error> {
    let key = format!("{:?}", Fields { name: String::new(), ..Fields::clone(scene) });
    let kept = Arc::clone(RUNS.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default());
    let mut own = None;
    let found = kept.get_or_init(|| match whole(run(scene, &mut |_| {})) {
        Ok(run) => Some(Arc::new(run)),
        Err(why) => {
            own = Some(why);
            None
        }
    });
    match (found, own) {
        (_, Some(why)) => Err(why),
        (Some(run), None) => {
            note_momentum(scene, run);
            forget_if_many();
            Ok(Arc::clone(run))
        }
        // It has failed for another case, which does not tell this one why.
        (None, None) => finished(scene).map(Arc::new),
    }
}

/// Lets all runs go that have ended, once they are many; who has one keeps it.
fn forget_if_many() {
    let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
    let numbers = |kept: &Kept| kept.get().and_then(Option::as_ref).map_or(0, |run| numbers(run));
    if runs.values().map(numbers).sum::<usize>() > MOST {
        runs.retain(|_, kept| kept.get().is_none());
    }
}

/// Numbers in a run.
fn numbers(run: &Run) -> usize {
    run.samples.iter().map(|sample| 100 + 5 * (sample.state.field.len() + sample.state.profile.len())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_of_another_name_is_not_run_again_and_another_scene_is() {
        let scene = crate::scenes::built_in("terzaghi-quasi-static").expect("a scene");
        let named = scene.edited(|scene| scene.name = "another".to_owned()).expect("a scene");
        let loaded = scene.edited(|scene| scene.tolerance *= 2.0).expect("a scene");
        let [first, again, other] = [&scene, &named, &loaded].map(|scene| shared(scene).expect("a run"));
        assert!(Arc::ptr_eq(&first, &again) && !Arc::ptr_eq(&first, &other));
    }
}
