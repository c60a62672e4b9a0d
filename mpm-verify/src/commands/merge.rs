//! `merge`: the report of a study that was run in shares.

use std::path::{Path, PathBuf};

use mpm_core::scene::read_text;
use mpm_verify::checkpoint::BUILD;
use mpm_verify::progress::Progress;
use mpm_verify::study::{Runner, Share, Store};

use super::Failure;
use super::study::{CASES, FOLDER, NAMES, Options, SHARD, Shard, complete, told, write};
use crate::Common;

/// Merges the shares in some folders, and writes the report that the study would have made in one piece.
pub fn run(folders: &[PathBuf], common: &Common) -> Result<(), Failure> {
    let shards: Vec<Shard> = folders.iter().map(|folder| read(folder)).collect::<Result<_, _>>()?;
    let Some(first) = shards.first() else {
        return Err(Failure::BadInput("merge: expected folders of shares, found none".to_owned()));
    };
    for (shard, folder) in shards.iter().zip(folders) {
        if shard.recipe != first.recipe || shard.of != first.of {
            let (one, other) = (folders[0].display(), folder.display());
            return Err(Failure::BadInput(format!("{other}: expected a share of the study in {one}, found another")));
        }
    }
    super::home_is_free(&common.folder(FOLDER))?;
    let study = common.publish(FOLDER, &NAMES, |folder| {
        let options = Options::of(&first.recipe)?;
        let cases: Vec<PathBuf> = folders.iter().map(|folder| folder.join(CASES)).collect();
        let paths: Vec<&Path> = cases.iter().map(PathBuf::as_path).collect();
        let store = Store::open(&paths).map_err(Failure::bad_input)?;
        let progress = Progress::new("merge", true);
        let mut runner = Runner {
            share: Share::Stored,
            store: Some(store),
            times: !options.no_times,
            ..Runner::whole(common.jobs(), &progress)
        };
        let absent: Vec<String> = (1..=first.of)
            .filter(|which| shards.iter().all(|shard| shard.shard != *which))
            .map(|which| format!("--shard {which}/{}", first.of))
            .collect();
        let on = || match absent.as_slice() {
            [] => "run the shares again with --resume".to_owned(),
            absent => format!("run the study with {}, and merge again", absent.join(", ")),
        };
        let study = complete(&options, common, &mut runner, &on)?;
        write(&study, folder)?;
        Ok(study)
    })?;
    told(&study, common)
}

/// Largest file of a share, bytes.
const LARGEST: u64 = 64 << 20;

fn read(folder: &Path) -> Result<Shard, Failure> {
    let path = folder.join(SHARD);
    let refused = |found: String| {
        Failure::BadInput(format!(
            "{}: expected a share that `study --shard` has finished, found: {found}",
            path.display()
        ))
    };
    let text = read_text(&path, LARGEST).map_err(|e| refused(e.to_string()))?;
    let shard: Shard = serde_json::from_str(&text).map_err(|e| refused(e.to_string()))?;
    if shard.recipe.build != BUILD {
        return Err(refused(format!("a share of another build, {}; this is {BUILD}", shard.recipe.build)));
    }
    Ok(shard)
}
