//! A chapter from Markdown to the sections of a page.

use std::path::Path;

use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};
use pulldown_latex::config::DisplayMode;

use super::{Error, formula, links};
use crate::page::{Block, Section, escaped};

/// A cell with more characters than these has sentences, which need a broad column.
const SENTENCES: usize = 80;
/// A cell with more characters than these is text, not a number.
const LONG_CELL: usize = 24;

/// A table of more rows than these scrolls in its box.
const LONG_TABLE: usize = 30;
/// Sections of a chapter with more of them than these are folded up at first.
const MANY_SECTIONS: usize = 20;

/// The sections of a chapter; what stands before the first one is a section without a title.
pub fn sections(markdown: &str, reports: &Path) -> Result<Vec<Section>, Error> {
    let mut parser = Parser::new_ext(markdown, Options::ENABLE_TABLES | Options::ENABLE_MATH);
    let mut sections = vec![(Section::new("introduction", ""), Vec::new())];
    // Open links, and whether they lead nowhere on the pages.
    let mut dropped = Vec::new();
    while let Some(event) = parser.next() {
        let shown = match event {
            Event::Start(Tag::Heading { level, .. }) => {
                let inside = until(&mut parser, TagEnd::Heading(level));
                let title = text(&inside);
                match level {
                    HeadingLevel::H1 => continue,
                    HeadingLevel::H2 => {
                        sections.push((Section::new(&links::anchor(&title), &title), Vec::new()));
                        continue;
                    }
                    _ => {}
                }
                let heading = pushed(inside);
                Event::Html(format!("<{level} id=\"{}\">{heading}</{level}>\n", links::anchor(&title)).into())
            }
            Event::DisplayMath(tex) => Event::InlineHtml(formula::mathml(&tex, DisplayMode::Block)?.into()),
            Event::Start(Tag::CodeBlock(_)) => {
                let code = text(&until(&mut parser, TagEnd::CodeBlock));
                Event::Html(
                    format!("<pre class=\"command\" tabindex=\"0\"><code>{}</code></pre>\n", escaped(&code)).into(),
                )
            }
            // Tables look and scroll as those of the reports do.
            Event::Start(Tag::Table(alignment)) => {
                let inside = until(&mut parser, TagEnd::Table);
                let title = sections.last().map_or("", |(section, _)| section.title.as_str());
                let title = if title.is_empty() { "Introduction" } else { title };
                let mut rows = vec![Event::Start(Tag::Table(alignment))];
                for event in inside {
                    rows.push(in_line(event, reports, &mut dropped)?);
                }
                let words = cells(&rows).any(|cell| cell.chars().count() > LONG_CELL);
                rows.push(Event::End(TagEnd::Table));
                let table =
                    pushed(rows).replacen("<table>", if words { "<table class=\"words\">" } else { "<table>" }, 1);
                let table = with_long_cells(&table);
                let table = table.replace("<th>", "<th scope=\"col\">").replace("<th scope=\"col\"></th>", "<td></td>");
                let class = if table.matches("<tr>").count() > LONG_TABLE { "box long" } else { "box" };
                let label = format!("Table: {}, scrollable", escaped(title));
                let open = format!(
                    "<div class=\"table\"><div class=\"{class}\" role=\"group\" tabindex=\"0\" aria-label=\"{label}\">"
                );
                Event::Html(format!("{open}{table}</div></div>\n").into())
            }
            Event::Start(Tag::Image { dest_url, .. }) => {
                let alt = escaped(&text(&until(&mut parser, TagEnd::Image)));
                let image = links::on_pages(&dest_url, reports).map_or_else(
                    || format!("<em>[{alt}]</em>"),
                    |url| format!("<img src=\"{}\" alt=\"{alt}\" loading=\"lazy\">", escaped(&url)),
                );
                Event::InlineHtml(image.into())
            }
            other => in_line(other, reports, &mut dropped)?,
        };
        if let Some((_, events)) = sections.last_mut() {
            events.push(shown);
        }
    }
    let many = sections.len() > MANY_SECTIONS;
    let made = |(section, events): (Section, Vec<Event<'_>>)| {
        let folded = many && !section.title.is_empty();
        Section { folded, ..section }.with(Block::Html(pushed(events)))
    };
    Ok(sections.into_iter().map(made).collect())
}

/// What may stand in a line of text: formulas, and links that lead to the pages.
fn in_line<'a>(event: Event<'a>, reports: &Path, dropped: &mut Vec<bool>) -> Result<Event<'a>, Error> {
    Ok(match event {
        Event::InlineMath(tex) => Event::InlineHtml(formula::mathml(&tex, DisplayMode::Inline)?.into()),
        Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
            let target = links::on_pages(&dest_url, reports);
            dropped.push(target.is_none());
            match target {
                Some(url) => Event::Start(Tag::Link { link_type, dest_url: url.into(), title, id }),
                // A file of the repository: its path from the top.
                None => Event::InlineHtml(
                    format!("<span title=\"{}\">", escaped(dest_url.trim_start_matches("../"))).into(),
                ),
            }
        }
        Event::End(TagEnd::Link) if dropped.pop() == Some(true) => Event::InlineHtml("</span>".into()),
        other => other,
    })
}

/// The events up to an end.
fn until<'a>(parser: &mut Parser<'a>, end: TagEnd) -> Vec<Event<'a>> {
    parser.take_while(|event| *event != Event::End(end)).collect()
}

fn pushed(events: Vec<Event<'_>>) -> String {
    let mut html = String::new();
    html::push_html(&mut html, events.into_iter());
    html
}

/// A table whose cells of sentences are marked, as those of the reports are.
fn with_long_cells(table: &str) -> String {
    let mut parts = table.split("<td>");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |table, part| {
        let cell = part.split("</td>").next().unwrap_or_default();
        let words: usize =
            cell.split('<').map(|text| text.rsplit('>').next().unwrap_or_default().chars().count()).sum();
        table + if words > SENTENCES { "<td class=\"text\">" } else { "<td>" } + part
    })
}

/// The texts of the cells of a table.
fn cells<'e>(events: &'e [Event<'_>]) -> impl Iterator<Item = String> + 'e {
    events.split(|event| *event == Event::End(TagEnd::TableCell)).map(text)
}

/// The words of some events.
fn text(events: &[Event<'_>]) -> String {
    let word = |event: &Event<'_>| match event {
        Event::Text(text) | Event::Code(text) | Event::InlineMath(text) => text.to_string(),
        Event::SoftBreak => " ".to_owned(),
        _ => String::new(),
    };
    events.iter().map(word).collect()
}
