//! The frames of a run as moving pictures: a player inside the page of the run, and a small image that loops.
//!
//! # Reading order
//! 1. [`mod@chosen`]: which frames. [`packed`]: frames as few bytes.
//! 2. [`Player`]: what the page holds; `player.html`, `player.css`, `player.js`: what draws it, with curves beside it whose cursor follows.
//! 3. [`looping`]: the image, `levee.png`.

pub mod chosen;
pub mod looping;
pub mod packed;

use serde_json::{Value, json};

use self::chosen::{PAGE, chosen};
use self::packed::Packed;
use crate::frames::Shot;
use crate::report::plots::colours;
use crate::report::plots::levee::map::Window;
use crate::report::plots::levee::{Site, clock, map};
use crate::report::quantity::{self, CLIPPED};

/// The part of a page that shows the player, with marks for what differs.
const PLAYER: &str = include_str!("player.html");
/// Its rules of style.
pub const STYLE: &str = include_str!("player.css");
const SCRIPT: &str = include_str!("player.js");
/// Bytes of text that the frames of a page may take; of more, fewer frames are shown.
const MOST: usize = 1_000_000;
/// Time before an event within which a frame counts as that of the event, s.
const NEAR: f64 = 0.05;
/// Width of the tank that is shown beside the soil, m.
pub(crate) const TANK: f64 = 0.7;

/// What the player of a page is made of.
#[derive(Debug, Clone)]
pub struct Player {
    /// Frames, events, curves and scales as JSON.
    pub model: String,
    /// The frames, packed.
    pub data: String,
    /// How many frames there are, and from when to when.
    pub summary: String,
}

impl Player {
    /// The frames of a run with its curves and events, as [`crate::levee::story`] lists them.
    ///
    /// # Errors
    /// None in memory; what the encoder says.
    pub fn new(site: &Site, shots: &[Shot], story: &Value) -> std::io::Result<Self> {
        Self::within(site, shots, story, MOST)
    }

    fn within(site: &Site, shots: &[Shot], story: &Value, bytes: usize) -> std::io::Result<Self> {
        let window = window(site, shots);
        let ranges: Vec<(f64, f64)> = quantity::ALL.iter().map(|q| q.range(shots)).collect();
        let mut most = PAGE;
        let (kept, data) = loop {
            let kept = chosen(shots, most);
            let data = Packed::new(&window, &ranges, &kept)?.text();
            if data.len() <= bytes || most[1] <= 4 {
                break (kept, data);
            }
            most = most.map(|count| count * 3 / 4);
        };
        let quantities = quantity::ALL.iter().zip(&ranges);
        let quantities: Vec<_> =
            quantities.map(|(q, range)| json!({"name": q.name, "label": q.label, "range": range})).collect();
        let colour = |k: u32| {
            let c = colours::at(f64::from(k) / 255.0);
            format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2)
        };
        let frames = kept.iter().map(|shot| {
            let centi = |y: f64| (100.0 * y).round() / 100.0;
            let level: Vec<_> = map::level(&shot.frame).into_iter().map(|(x, y)| [centi(x), centi(y)]).collect();
            json!({"time": shot.time_s, "clock": clock(shot.time_s), "phase": shot.phase, "level": level,
                "solid": shot.frame.solid.len(), "water": shot.frame.water.len()})
        });
        // At the moment of failure, or at the end where there is none.
        let opens =
            story["failure"].as_f64().and_then(|failure| kept.iter().position(|shot| shot.time_s >= failure - NEAR));
        let model = json!({
            "opens": opens.unwrap_or(kept.len().saturating_sub(1)),
            "window": window,
            "edge": map::edge(shots.first().map(|shot| &shot.frame)),
            "outline": site.outline,
            "tank": site.tank_m,
            "colours": (0..256).map(colour).collect::<Vec<_>>(),
            "quantities": quantities,
            "clipped": CLIPPED,
            "frames": frames.collect::<Vec<_>>(),
            "story": story,
        });
        Ok(Self {
            // No phase may end the script.
            model: model.to_string().replace('<', "\\u003c"),
            data,
            summary: summary(&kept, shots.len()),
        })
    }
}

impl Player {
    /// The part of the page.
    pub fn html(&self) -> String {
        let options = quantity::ALL.map(|q| format!("<option value=\"{}\">{}</option>", q.name, q.label)).concat();
        let parts =
            [("@OPTIONS@", options.as_str()), ("@MODEL@", &self.model), ("@DATA@", &self.data), ("@SCRIPT@", SCRIPT)];
        parts.iter().fold(PLAYER.to_owned(), |text, (mark, part)| text.replacen(mark, part, 1))
    }
}

/// Left, lower, right and upper end of what is shown, m: the soil at all times, and a part of the tank.
fn window(site: &Site, shots: &[Shot]) -> [f64; 4] {
    let [left, low, right, high] = Window::of(site, shots).ends();
    [if site.tank_m > 0.0 { left.min(-TANK) } else { left }, low, right, high]
}

fn summary(kept: &[&Shot], of: usize) -> String {
    let (Some(first), Some(last)) = (kept.first(), kept.last()) else { return "There are no frames.".to_owned() };
    let moving = kept.iter().filter(|shot| shot.phase.starts_with("failing")).count();
    let part = if of > kept.len() { format!(" of {of}") } else { String::new() };
    format!(
        "{} frames{part} from {} to {}, {moving} of them while the soil moves. Time does not run evenly: the frames are minutes \
         apart while water seeps and fractions of a second during failure.",
        kept.len(),
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
    fn the_frames_of_a_run_are_small() {
        let player = Player::new(&site(), &made_up::shots(60, 90), &json!({})).expect("a player");
        assert!(player.model.len() + player.data.len() < 1_200_000, "{}", player.data.len());
        for part in ["from 6 h 00 min 0 s", "minutes apart"] {
            assert!(player.summary.contains(part), "{}", player.summary);
        }
        assert!(player.model.contains("8 h 39 min 36 s"));
        // Nothing is fetched.
        for outside in ["http://", "https://", "src=", "<link", "@import", "fetch("] {
            assert!(!format!("{PLAYER}{SCRIPT}").replace("src=\"levee.png\"", "").contains(outside), "{outside}");
        }
    }

    #[test]
    fn more_frames_than_fit_are_thinned_and_it_is_said() {
        let shots = made_up::shots(30, 60);
        let few = Player::within(&site(), &shots, &json!({}), 40_000).expect("a player");
        assert!(few.data.len() <= 40_000 && few.summary.contains(" of 90 from"), "{}", few.summary);
        assert!(Player::new(&site(), &[], &json!({})).expect("a player").summary.contains("There are no frames."));
    }

    #[test]
    fn it_opens_at_the_moment_of_failure() {
        let shots = made_up::shots(20, 40);
        let opens = |story: Value| {
            let player = Player::new(&site(), &shots, &story).expect("a player");
            let model: Value = serde_json::from_str(&player.model.replace("\\u003c", "<")).expect("a model");
            let frame = model["opens"].as_u64().expect("a frame") as usize;
            model["frames"][frame]["time"].as_f64().expect("a time")
        };
        assert_eq!(opens(json!({})), shots[59].time_s);
        let failure = shots[33].time_s;
        assert!((opens(json!({ "failure": failure })) - failure).abs() < NEAR);
        assert!(SCRIPT.contains("let now = Math.min(last, model.opens);"));
    }

    #[test]
    fn a_phase_cannot_end_the_script() {
        let mut shots = made_up::shots(1, 0);
        shots[0].phase = "</script><b>".to_owned();
        let player = Player::new(&site(), &shots, &json!({})).expect("a player");
        assert!(!player.model.contains("</script><b>"));
    }
}
