//! The tables on the page of a night.

use std::path::Path;

use super::collect::{SPEED, WANTED, cost_for};
use super::compiled;
use super::moved::Moved;
use super::report::{LISTED, Night, PartRow, Shown};
use super::thresholds::{FalseAlarms, LEAST};
use super::work::{GATES, TIME};
use crate::experiment::number::Number;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;

/// Numbers that moved, the first of them, each with a link to its case.
pub fn moved(moved: &[&Moved], folder: &Path) -> Table {
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), shown);
    let row = |m: &&Moved| {
        let (date, commit) = m.since.split_once(' ').unwrap_or((&m.since, ""));
        vec![
            Cell::new(m.case.clone()).linked(&existing(&m.page, folder)),
            Cell::new(percent(m.share())).marked(m.direction.word(), m.direction.mark()),
            Cell::new(m.quantity.clone()),
            Cell::new(number(m.was)),
            Cell::new(number(m.is)),
            Cell::new(format!("{:.1e}", m.tolerance)),
            Cell::new(self::date(date)).small(commit),
        ]
    };
    let rows = moved.iter().take(LISTED).map(row).collect();
    let head = ["case", "change", "quantity", "accepted", "tonight", "may move by", "since"];
    let note = if moved.len() > LISTED { format!("And {} more.", moved.len() - LISTED) } else { String::new() };
    table(String::new(), &head, rows, &note)
}

/// A date of a record, to the minute.
pub fn date(record: &str) -> String {
    record.get(..16).unwrap_or(record).replace('T', " ")
}

/// The link to a page in a folder, without the anchor if the page does not have it; empty if there is no such page.
fn existing(page: &str, folder: &Path) -> String {
    let (file, anchor) = page.split_once('#').unwrap_or((page, ""));
    if file.is_empty() {
        return page.to_owned();
    }
    match std::fs::read_to_string(folder.join(file)) {
        Ok(text) if text.contains(&format!("id=\"{anchor}\"")) => page.to_owned(),
        Ok(_) => file.to_owned(),
        Err(_) => String::new(),
    }
}

/// A number: a count without a point.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value:.0}") } else { short(value, 7) }
}

/// A change in per cent with its sign.
pub fn percent(share: Option<f64>) -> String {
    match share.map(|share| 100.0 * share) {
        None => "–".to_owned(),
        Some(0.0) => "0 %".to_owned(),
        Some(percent) if percent.abs() >= 100.0 => format!("{percent:+.0} %"),
        Some(percent) => format!("{percent:+.2} %"),
    }
}

/// The parts of the night.
pub fn parts(night: &Night) -> Table {
    let row = |p: &PartRow| {
        vec![
            Cell::new(p.name.name()),
            Cell::badge(p.finish.word(), p.finish.mark()),
            Cell::new(p.line.clone()),
            Cell::new(format!("{:.0}", p.cpu_s)),
            Cell::new(format!("{:.0}", p.wall_s)),
        ]
    };
    let head = ["part", "", "what came out", "CPU (s)", "clock (s)"];
    table(String::new(), &head, night.parts.iter().map(row).collect(), "").words()
}

/// Whether a quantity is of a kind.
type IsOfKind<'a> = &'a dyn Fn(&str) -> bool;

/// Costs of single runs, against what is accepted or was usual, if they were made.
pub fn cost(night: &Night, shown: &Shown) -> Option<Table> {
    let counted = |wanted: &'static str| move |quantity: &str| compiled::counted(quantity) == Some(wanted);
    let (instructions, allocations) = (counted(compiled::INSTRUCTIONS), counted(compiled::ALLOCATIONS));
    let kinds: [(&str, IsOfKind); 3] =
        [("instructions", &instructions), ("allocations", &allocations), ("CPU time", &|quantity| quantity == TIME)];
    let measured = |gate: &str, is: IsOfKind| {
        shown.measures.iter().find(|m| m.case == gate && is(&m.quantity) && m.value.is_finite())
    };
    let cells = |gate: &str, is: IsOfKind| {
        let Some(m) = measured(gate, is) else { return ["–", "–"].map(Cell::new) };
        let value = match m.value {
            v if v.fract() == 0.0 && v < 1e6 => format!("{v:.0}"),
            v => short(v, 4),
        };
        let row = shown.known.iter().find(|row| m.is_of(&row.case, &row.quantity));
        let moved = night.moved.iter().find(|moved| m.is_of(&moved.case, &moved.quantity));
        let mark = moved.map_or("", |moved| moved.direction.mark());
        let change = percent(row.map(|row| m.value / row.value - 1.0));
        [Cell::new(value), Cell::new(change).marked("", mark)]
    };
    // What was not counted has no columns.
    let gates = || GATES.iter().map(|gate| gate.name);
    let kinds = kinds.into_iter().filter(|(_, is)| gates().any(|gate| measured(gate, is).is_some()));
    let kinds: Vec<_> = kinds.collect();
    let head: Vec<&str> = std::iter::once("run").chain(kinds.iter().flat_map(|(name, _)| [*name, "change"])).collect();
    let row = |gate: &str| {
        let own = kinds.iter().flat_map(|(_, is)| cells(gate, is));
        std::iter::once(Cell::new(gate).anchored(gate)).chain(own).collect()
    };
    let rows = gates().map(row).collect();
    (!kinds.is_empty()).then(|| table(String::new(), &head, rows, ""))
}

/// Thresholds of the costs, and how often times would be reported without a cause.
pub fn about_cost(shown: &Shown) -> String {
    let alarms = FalseAlarms::of(shown.measures, shown.history).map_or_else(
        || format!("Times are compared after {LEAST} nights."),
        |found| {
            let FalseAlarms { numbers, nights, beyond, all } = found;
            format!(
                "Expected false alarms in 30 nights: {}. In the last {nights} nights {beyond} of {all} times were beyond their \
                 threshold; a time is reported on the second night in a row, and there are {numbers} of them.",
                short(found.in_thirty_nights(), 1)
            )
        },
    );
    format!(
        "Instructions and allocations are compared with the accepted ones of the same compiler, or with their median over the \
         nights. CPU time is a ratio to that of a fixed kernel timed in turns with the run, compared with its median over the nights. \
         Counts of the program itself repeat exactly, whatever the load. {alarms}"
    )
}

/// Speed against error, if the study was run: the least work by which each sweep reaches an error.
pub fn speed(measures: &[Number]) -> Option<Table> {
    let mut families: Vec<&str> = measures.iter().filter_map(|m| m.case.strip_prefix(SPEED)).collect();
    families.dedup();
    if families.is_empty() {
        return None;
    }
    let row = |family: &&str| {
        let cost = |wanted: f64| {
            let of = measures.iter().find(|m| m.is_of(&format!("{SPEED}{family}"), &cost_for(wanted)));
            Cell::new(of.map_or_else(|| "–".to_owned(), |m| short(m.value, 3)))
        };
        std::iter::once(Cell::new((*family).to_owned())).chain(WANTED.map(cost)).collect()
    };
    let head: Vec<String> = WANTED.iter().map(|wanted| format!("error ≤ {}", short(*wanted, 1))).collect();
    let head: Vec<&str> = std::iter::once("sweep").chain(head.iter().map(String::as_str)).collect();
    Some(table(String::new(), &head, families.iter().map(row).collect(), ""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::number::{Label, Tolerance};

    #[test]
    fn speed_is_shown_against_the_error_it_was_reached_with() {
        let cost = |family: &str, wanted: f64, value: f64| {
            let case = format!("{SPEED}{family}");
            Number::new(&case, &cost_for(wanted), Label::Count, value, Tolerance::relative(0.02))
        };
        let measures = [cost("quick", 1e-2, 880.0), cost("quick", 1e-3, 2160.0), cost("slow", 1e-2, 2.2e8)];
        let table = speed(&measures).expect("a table");
        let texts: Vec<Vec<&str>> = table.rows.iter().map(|r| r.iter().map(|c| c.text.as_str()).collect()).collect();
        assert_eq!(table.head, ["sweep", "error ≤ 0.01", "error ≤ 0.003", "error ≤ 0.001", "error ≤ 0.0002"]);
        assert_eq!(texts, [["quick", "880", "–", "2160", "–"], ["slow", "2.20e8", "–", "–", "–"]]);
        assert!(speed(&[]).is_none());
    }
}
