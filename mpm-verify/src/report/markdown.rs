//! The report as Markdown, for terminals and code hosts.

use std::fmt::Write;

use super::content::Content;
use super::content::table::{Cell, Table};

/// `report.md`; pictures are taken from `plots/` beside it.
pub fn page(content: &Content) -> String {
    let mut page = format!("# {}\n\n{}\n\n", content.title, content.summary);
    for warning in &content.warnings {
        page += &format!("> **{warning}**\n>\n");
    }
    section(
        &mut page,
        content,
        "Errors",
        &content.errors,
        &["mesh", "max-error-against-mesh-terzaghi", "max-error-against-mesh-compressible"],
    );
    section(&mut page, content, "Orders of convergence", &content.orders, &["profile-error-against-mesh"]);
    section(
        &mut page,
        content,
        "Integrators and shape functions",
        &content.schemes,
        &["error-of-all-schemes", "profile-error-of-all-schemes", "isochrones-bspline2"],
    );
    section(&mut page, content, "Displaced particles, shifted mesh", &content.places, &["displaced", "grid-shift"]);
    let steps = ["error-against-steps", "error-against-factorisations"];
    section(&mut page, content, "Errors in time", &content.time, &steps);
    claims(&mut page, content);
    section(&mut page, content, "Other integrators", &content.other_claims, &[]);
    let pictures =
        ["isochrones", "consolidation", "error-against-time-particles", "error-against-time-surface", "crossings"];
    section(&mut page, content, "Pictures of the statements", &[], &pictures);
    section(&mut page, content, "Parts of the error", &content.budgets, &["error-budget", "error-budget-late"]);
    section(&mut page, content, "Energy", &[], &["energy"]);
    section(&mut page, content, "Speed", &content.speed, &[]);
    section(&mut page, content, "All cases", &content.cases, &[]);
    list(&mut page, "Terms", content.terms.iter().map(|(term, meaning)| format!("**{term}**: {meaning}")));
    list(&mut page, "What is missing", content.missing.iter().cloned());
    list(&mut page, "Notes", content.notes.iter().cloned());
    list(&mut page, "Conditions", content.manifest.iter().map(|(name, value)| format!("{name}: `{value}`")));
    page
}

fn section(page: &mut String, content: &Content, title: &str, tables: &[Table], pictures: &[&str]) {
    *page += &format!("\n## {title}\n\n");
    tables.iter().for_each(|table| with_note(page, table));
    for picture in content.pictures.iter().filter(|p| pictures.contains(&p.name)) {
        let (number, title, name, caption) = (picture.number, &picture.title, picture.name, &picture.caption);
        *page += &format!("![{title}](plots/{name}.png)\n\n**Figure {number}. {title}.** {caption} ");
        *page += &format!("([numbers](plots/{name}.csv), [vector](plots/{name}.svg))\n\n");
    }
}

/// A table with its title and its note.
pub fn with_note(page: &mut String, table: &Table) {
    *page += &format!("### {}\n\n", table.title);
    rows(page, table);
    page.push('\n');
    if !table.note.is_empty() {
        *page += &format!("{}\n\n", table.note);
    }
}

fn claims(page: &mut String, content: &Content) {
    *page +=
        "\n## The paper's statements\n\n| statement | verdict | evidence | rule | picture |\n|---|---|---|---|---|\n";
    for claim in &content.claims {
        let picture = if claim.number > 0 { format!("Figure {}", claim.number) } else { String::new() };
        let cells = [&claim.said, &format!("**{}**", claim.verdict), &claim.evidence, &claim.rule, &picture];
        line(page, cells.into_iter().map(String::as_str));
    }
}

fn rows(page: &mut String, table: &Table) {
    let names = table.groups.iter().flat_map(|(name, columns)| std::iter::repeat_n(name.as_str(), *columns));
    let heads: Vec<String> = match table.groups.is_empty() {
        true => table.head.clone(),
        false => names.zip(&table.head).map(|(name, head)| format!("{name} {head}").trim().to_owned()).collect(),
    };
    line(page, heads.iter().map(String::as_str));
    line(page, heads.iter().map(|_| "---"));
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(cell).collect();
        line(page, cells.iter().map(String::as_str));
    }
}

fn cell(cell: &Cell) -> String {
    let text = if matches!(cell.mark, "paper" | "bad") { format!("**{}**", cell.text) } else { cell.text.clone() };
    if cell.small.is_empty() { text } else { format!("{text} ({})", cell.small.replace('\n', "; ")) }
}

fn line<'a>(page: &mut String, cells: impl Iterator<Item = &'a str>) {
    for cell in cells {
        // Writing into a String cannot fail.
        let _ = write!(page, "| {} ", cell.replace('|', "\\|").replace('\n', " "));
    }
    *page += "|\n";
}

/// A section that is a list; nothing without items.
pub fn list(page: &mut String, title: &str, items: impl Iterator<Item = String>) {
    let items: Vec<String> = items.map(|item| format!("- {item}\n")).collect();
    if !items.is_empty() {
        *page += &format!("\n## {title}\n\n{}", items.concat());
    }
}
