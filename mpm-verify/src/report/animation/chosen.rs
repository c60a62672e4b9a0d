//! Which frames a moving picture shows: enough of the hours of seepage, of the onset, of the failure and of the soil at rest.

use crate::frames::Shot;

/// Frames of the seepage and of moving soil that a page shows at most.
pub const PAGE: [usize; 2] = [44, 84];
/// The same of the small moving image.
pub const IMAGE: [usize; 2] = [22, 36];

/// At most so many frames of seepage and of moving soil, evenly in time; always the first, the last and those at events.
pub fn chosen(shots: &[Shot], most: [usize; 2]) -> Vec<&Shot> {
    let seeps = seeping(shots);
    let last = shots.len().saturating_sub(1);
    let mut keep = vec![false; shots.len()];
    for (kind, most) in most.into_iter().enumerate() {
        let own: Vec<usize> = (0..shots.len()).filter(|k| seeps[*k] == (kind == 0)).collect();
        for k in even(&own, most, |k| shots[k].time_s) {
            keep[k] = true;
        }
    }
    let special = |k: usize| k == 0 || k == last || shots[k].phase.contains(", ");
    shots.iter().enumerate().filter(|(k, _)| keep[*k] || special(*k)).map(|(_, shot)| shot).collect()
}

/// Which frames are of seepage. Soil and water that run together have one phase: their soil moves from the first event on.
fn seeping(shots: &[Shot]) -> Vec<bool> {
    let mut happened = false;
    let seeps = |shot: &Shot| {
        happened |= ["E1", "E2", "E3"].iter().any(|event| shot.phase.contains(event));
        let moving = ["failing", "at rest"].iter().any(|phase| shot.phase.starts_with(phase));
        !(moving || happened && shot.phase.starts_with("soil and water together"))
    };
    shots.iter().map(seeps).collect()
}

/// Of some places in the order of time at most so many, the nearest to times that are evenly apart.
fn even(all: &[usize], most: usize, time: impl Fn(usize) -> f64) -> Vec<usize> {
    if all.len() <= most || most < 2 {
        return all[..all.len().min(most)].to_vec();
    }
    let (start, end) = (time(all[0]), time(all[all.len() - 1]));
    let wanted = (0..most).map(|k| start + (end - start) * k as f64 / (most - 1) as f64);
    let nearest = |wanted: f64| {
        all.iter().copied().min_by(|a, b| (time(*a) - wanted).abs().total_cmp(&(time(*b) - wanted).abs()))
    };
    let mut kept: Vec<usize> = wanted.filter_map(nearest).collect();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_of_seepage_and_seconds_of_failure_have_their_frames() {
        let shot = |phase: &str, time_s: f64| Shot { phase: phase.to_owned(), time_s, ..Shot::default() };
        let mut shots: Vec<Shot> = (0..300).map(|k| shot("seepage", 60.0 * f64::from(k))).collect();
        shots[200].phase = "seepage, outflow".to_owned();
        shots.extend((0..150).map(|k| shot("failing", 18_000.0 + 0.1 * f64::from(k))));
        shots.push(shot("at rest", 18_016.0));
        let kept = chosen(&shots, [40, 60]);
        let seeping = kept.iter().filter(|s| s.phase.starts_with("seepage")).count();
        assert!(
            (40..=41).contains(&seeping) && (55..=61).contains(&(kept.len() - seeping)),
            "{seeping} {}",
            kept.len()
        );
        assert!(kept.iter().any(|s| s.phase == "seepage, outflow"));
        assert_eq!((kept[0].time_s, kept[kept.len() - 1].time_s), (0.0, 18_016.0));
        assert_eq!(chosen(&shots[..5], [40, 60]).len(), 5);
        assert!(chosen(&[], [40, 60]).is_empty());
    }
}
