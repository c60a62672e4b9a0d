//! A page that plays the frames of a run: one file, nothing fetched, small enough to send.
//!
//! # Reading order
//! 1. [`write()`]: the page. `packed`: frames as few bytes.
//! 2. `page.html`: its template; `player.js`: what draws the bytes and listens to keys.

mod packed;

use std::path::Path;

use serde_json::json;

use self::packed::Packed;
use crate::frames::Shot;
use crate::report::plots::colours;
use crate::report::plots::levee::changes::{self, Shown};
use crate::report::plots::levee::{Site, clock, map};
use crate::report::plots::svg_text;
use crate::report::quantity::{self, STRAIN};
use crate::report::{ReportError, html, save};

const TEMPLATE: &str = include_str!("page.html");
const PLAYER: &str = include_str!("player.js");
/// Bytes of data that a page may hold; of more frames than fit, every second, third, ... is shown.
const MOST: usize = 3_000_000;

/// Writes the page. Without scripts it shows the last frame.
///
/// # Errors
/// A file that cannot be written, with its path.
pub fn write(title: &str, site: &Site, shots: &[Shot], path: &Path) -> Result<(), ReportError> {
    save(path, page(title, site, shots, MOST).map_err(|cause| ReportError::Page { path: path.to_owned(), cause })?)
}

/// The text of the page, with at most so many bytes of data.
fn page(title: &str, site: &Site, shots: &[Shot], most: usize) -> Result<String, minijinja::Error> {
    let packed = Packed::new(site, shots, most);
    let last: Vec<&Shot> = shots.last().into_iter().collect();
    // A picture that cannot be drawn is no reason to have no page: it is only for those without scripts.
    let still = svg_text(&changes::figure(site, &last, Shown::Of(STRAIN))).unwrap_or_default();
    let colour = |k: u32| {
        let c = colours::at(f64::from(k) / 255.0);
        format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2)
    };
    let quantities = quantity::ALL.iter().zip(&packed.ranges);
    let quantities: Vec<_> = quantities.map(|(q, r)| json!({"name": q.name, "label": q.label, "range": r})).collect();
    let frames = packed.shots.iter().map(|shot| {
        let (solid, water) = (shot.frame.solid.len(), shot.frame.water.len());
        json!({"time": clock(shot.time_s), "phase": shot.phase, "solid": solid, "water": water})
    });
    let model = json!({
        "window": packed.window,
        "edge": map::edge(shots.first().map(|shot| &shot.frame)),
        "outline": site.outline,
        "tank": site.tank_m,
        "colours": (0..256).map(colour).collect::<Vec<_>>(),
        "quantities": quantities,
        "frames": frames.collect::<Vec<_>>(),
    });
    let content = json!({
        "title": title,
        "summary": summary(shots, packed.every),
        "quantities": quantity::ALL.map(|q| (q.name, q.label)),
        // No phase may end the script.
        "model": model.to_string().replace('<', "\\u003c"),
        "data": packed.text(),
        "player": PLAYER,
        "still": still,
    });
    html::render(TEMPLATE, content, &[], (&[], &[]), "")
}

fn summary(shots: &[Shot], every: usize) -> String {
    let (Some(first), Some(last)) = (shots.first(), shots.last()) else { return "There are no frames.".to_owned() };
    let part = if every > 1 { format!(", one of {every} shown,") } else { String::new() };
    format!(
        "{} frames{part} from {} to {}. They follow each other at a steady pace, whatever time lies between them: the \
         clock tells. The brightest colour also stands for what is larger than 99.5 % of all.",
        shots.len(),
        clock(first.time_s),
        clock(last.time_s)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::made_up;

    fn site() -> Site {
        Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 }
    }

    #[test]
    fn a_page_of_150_frames_is_one_small_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = std::env::var_os("MPM_KEEP_PICTURES").map_or(folder.path().to_owned(), Into::into);
        let path = folder.join("levee.html");
        write("A levee that fails", &site(), &made_up::shots(60, 90), &path).expect("a page");
        let text = std::fs::read_to_string(&path).expect("the page");
        assert!(text.len() < 3_500_000, "{}", text.len());
        // Nothing is fetched.
        for outside in ["http://", "https://", "src=", "<link", "@import", "fetch("] {
            assert!(!text.replace("http://www.w3.org", "").contains(outside), "{outside}");
        }
        for part in ["150 frames from 6 h 00 min 0 s", "<noscript>", "deviator strain", "8 h 39 min 36 s"] {
            assert!(text.contains(part), "{part}");
        }
    }

    #[test]
    fn more_frames_than_fit_are_thinned_and_it_is_said() {
        let shots = made_up::shots(4, 5);
        let text = page("x", &site(), &shots, 40_000).expect("a page");
        assert!(text.contains("9 frames, one of "));
        assert!(page("x", &site(), &[], 1000).expect("a page").contains("There are no frames."));
    }

    #[test]
    fn a_phase_cannot_end_the_script() {
        let mut shots = made_up::shots(1, 0);
        shots[0].phase = "</script><b>".to_owned();
        let text = page("<i>", &site(), &shots, MOST).expect("a page");
        assert!(!text.contains("</script><b>") && !text.contains("<i>"));
    }
}
