//! `check`: the verification ladder.

use std::path::PathBuf;

use mpm_verify::cases::{LADDER, Rung, Step};
use rayon::prelude::*;

use super::{Failure, jobs, print_json, say, writable, write_csv};
use crate::Common;

/// Runs the named rungs, or all.
pub fn run(names: &[String], common: &Common) -> Result<(), Failure> {
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/ladder"));
    let steps = climb(names, common, &folder)?;
    if common.json {
        print_json(&steps);
    }
    let fallen: Vec<&str> = steps.iter().filter(|s| !s.held()).map(|s| s.rung.as_str()).collect();
    if fallen.is_empty() { Ok(()) } else { Err(Failure::FellShort(format!("fell short: {}", fallen.join(", ")))) }
}

/// Climbs the ladder and writes `ladder.csv`.
pub fn climb(names: &[String], common: &Common, folder: &std::path::Path) -> Result<Vec<Step>, Failure> {
    let known = || LADDER.iter().map(|rung| rung.name).collect::<Vec<_>>().join(", ");
    if let Some(name) = names.iter().find(|name| LADDER.iter().all(|rung| rung.name != name.as_str())) {
        return Err(Failure::BadInput(format!("check: expected one of {}, found {name}", known())));
    }
    writable(folder)?;
    let chosen = |rung: &&Rung| names.is_empty() || names.iter().any(|name| name == rung.name);
    let rungs: Vec<&Rung> = LADDER.iter().filter(chosen).collect();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(jobs(common.jobs))
        .build()
        .map_err(|e| Failure::BadInput(e.to_string()))?;
    let quiet = common.quiet || common.json;
    say(quiet, &format!("{:<22} {:>10} {:>10}  {:<26} verdict", "rung", "error", "required", "order"));
    let steps: Result<Vec<Step>, String> = pool.install(|| {
        rungs
            .par_iter()
            .with_max_len(1)
            .map(|rung| {
                let step = rung.climb()?;
                say(quiet, &line(&step));
                Ok(step)
            })
            .collect()
    });
    let steps = steps.map_err(Failure::RunFailed)?;
    write_csv(&folder.join("ladder.csv"), &steps)?;
    Ok(steps)
}

fn line(step: &Step) -> String {
    let order = match (step.order, step.order_high) {
        (Some(order), Some(high)) => {
            format!("{order:.2} +- {:.2} ({})", high - order, step.required_order)
        }
        _ => String::new(),
    };
    format!("{:<22} {:>10.2e} {:>10.1e}  {order:<26} {}", step.rung, step.error, step.required_error, step.verdict)
}
