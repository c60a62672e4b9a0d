//! The tables on the page of a night.

use super::collect::{SPEED, WANTED, cost_for};
use super::compiled;
use super::moved::Moved;
use super::report::{LISTED, Night, Part};
use super::work::GATES;
use crate::experiment::number::Number;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;

/// What moved, the first of it.
pub fn moved(night: &Night) -> Table {
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), shown);
    let row = |m: &Moved| {
        let (date, commit) = m.since.split_once(' ').unwrap_or((&m.since, ""));
        let mark = match m.direction.as_str() {
            "worse" | "gone" => "bad",
            "better" => "good",
            _ => "",
        };
        vec![
            Cell::new(m.case.clone()),
            Cell::new(m.quantity.clone()),
            Cell::new(m.direction.clone()).marked("", mark),
            Cell::new(number(m.was)),
            Cell::new(number(m.is)),
            Cell::new(format!("{:.1e}", m.tolerance)),
            Cell::new(date.replace('T', " ").trim_end_matches('Z')).marked(commit, ""),
        ]
    };
    let rows = night.moved.iter().take(LISTED).map(row).collect();
    table(String::new(), &["case", "quantity", "", "was", "is", "may move by", "since"], rows, "")
}

/// A number: a count without a point.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value:.0}") } else { short(value, 7) }
}

/// The parts of the night.
pub fn parts(night: &Night) -> Table {
    let row = |p: &Part| {
        vec![
            Cell::new(p.name.clone()),
            Cell::new(p.line.clone()),
            Cell::new(format!("{:.0}", p.cpu_s)),
            Cell::new(format!("{:.0}", p.wall_s)),
        ]
    };
    table(String::new(), &["part", "what came out", "CPU (s)", "clock (s)"], night.parts.iter().map(row).collect(), "")
}

/// Counts of the gates, if they were counted.
pub fn work(measures: &[Number]) -> Option<Table> {
    let gates: Vec<&str> = GATES.iter().map(|gate| gate.name).collect();
    let of = |gate: &str, wanted: &dyn Fn(&str) -> bool| {
        measures.iter().find(|m| m.case == gate && wanted(&m.quantity)).map_or_else(
            || "–".to_owned(),
            |m| {
                if m.value.abs() < 100.0 && m.value.fract() != 0.0 {
                    short(m.value, 3)
                } else {
                    format!("{:.0}", m.value)
                }
            },
        )
    };
    if !measures.iter().any(|m| gates.contains(&m.case.as_str())) {
        return None;
    }
    let row = |gate: &&str| {
        let counts = ["point_steps", "solves", "factorisations"];
        let mut cells = vec![Cell::new((*gate).to_owned())];
        cells.extend(counts.map(|name| Cell::new(of(gate, &|q| q == name))));
        let compiled = [compiled::ALLOCATIONS, compiled::INSTRUCTIONS];
        cells.extend(compiled.map(|name| Cell::new(of(gate, &|q| compiled::counted(q) == Some(name)))));
        cells.push(Cell::new(of(gate, &|q| q == "time_ratio")));
        cells
    };
    let head = ["gate", "point-steps", "solves", "factorisations", "allocations", "instructions", "time / kernel"];
    Some(table(String::new(), &head, gates.iter().map(row).collect(), ""))
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
