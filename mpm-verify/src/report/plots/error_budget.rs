//! The parts of the error relative to Terzaghi, stacked.

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{BLACK, BLUE, GREEN, GREY, Hatch, Look, Marker, ORANGE, PURPLE, RED, SKY};
use crate::budget::Budget;
use crate::report::Study;
use crate::report::select::{Cases, LOADS};

/// Comparison in the order of [`Budget::parts`].
const LOOKS: [Look; 7] = [
    Look::new(BLUE, Marker::Square),
    Look::new(ORANGE, Marker::Square).hatch(Hatch::Rising),
    Look::new(GREEN, Marker::Square).hatch(Hatch::Falling),
    Look::new(PURPLE, Marker::Square).hatch(Hatch::Level),
    Look::new(SKY, Marker::Square).hatch(Hatch::Crossed),
    Look::new(RED, Marker::Square).hatch(Hatch::Upright),
    Look::new(GREY, Marker::Square).hatch(Hatch::Grid),
];

/// Bars per mesh at one time factor: parts that raise U upwards, parts that lower it downwards.
pub fn figure(name: &'static str, study: &Study, cases: &Cases, tv: f64) -> Figure {
    let ppc = cases.usual_particles().unwrap_or(0);
    let mut missing = Vec::new();
    let mut panels = Vec::new();
    for (load, words) in LOADS {
        let budgets = cases.budgets(study, load, tv);
        if budgets.is_empty() {
            missing.push(format!("{name}: no further runs for a budget with the {words}"));
        }
        let unknown = |b: &&&Budget| b.parts().iter().any(|(_, share)| !share.is_finite());
        if let Some(budget) = budgets.iter().find(unknown) {
            let parts = budget.parts().into_iter().filter(|(_, share)| !share.is_finite());
            let parts: Vec<&str> = parts.map(|(name, _)| name).collect();
            missing.push(format!("{name}: no exact solution for {} with the {words}", parts.join(", ")));
        }
        panels.push(panel(words, &budgets));
    }
    Figure {
        name,
        title: format!("Parts of the error relative to Terzaghi at Tv = {tv}, {ppc} particles per cell"),
        caption: "Upwards: settles more than Terzaghi says; downwards: less. The marker is the sum of all parts, the \
                  error itself. The remainder says how far the parts are from adding up. The panels have axes of their \
                  own."
            .to_owned(),
        height: 370.0,
        panels,
        missing,
    }
}

fn panel(words: &str, budgets: &[&Budget]) -> Panel {
    let count = budgets.len().max(1) as f64;
    let ticks = budgets.iter().enumerate().map(|(k, b)| (k as f64, b.mesh_m.to_string())).collect();
    let x = Axis::linear("cell edge L (m)", "mesh_m").range(-0.6, count - 0.4).named(ticks);
    let mut panel = Panel::new(words, x, Axis::linear("share of U of Terzaghi (%)", "share_percent"));
    let (mut up, mut down) = (vec![0.0; budgets.len()], vec![0.0; budgets.len()]);
    for (part, look) in LOOKS.into_iter().enumerate() {
        let mut points = Vec::new();
        for (place, budget) in budgets.iter().enumerate() {
            let value = 100.0 * budget.parts()[part].1;
            if !value.is_finite() {
                continue;
            }
            let side = if value > 0.0 { &mut up } else { &mut down };
            points.push(Point::new(place as f64, side[place] + value).from(side[place]));
            side[place] += value;
        }
        let name = budgets.first().map_or("", |b| b.parts()[part].0);
        panel.add(Series::new(name, look, Mark::Bars, points));
    }
    panel.add(
        Series::line("", Look::new(BLACK, Marker::Dot).width(1.0), [(-0.6, 0.0), (count - 0.4, 0.0)])
            .unlisted()
            .guide(),
    );
    let totals = budgets.iter().enumerate().map(|(place, b)| Point::new(place as f64, 100.0 * b.total).open(true));
    panel.add(Series::new("total", Look::new(BLACK, Marker::Diamond).radius(4.5), Mark::Points, totals));
    panel
}
