//! A chapter from Markdown to HTML.

use std::path::Path;

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};
use pulldown_latex::config::DisplayMode;
use serde::Serialize;

use super::{Chapter, formula, links};
use crate::error::Error;

/// A heading of the second level, for the list of sections.
#[derive(Debug, Serialize)]
pub struct Section {
    /// Its name for links.
    anchor: String,
    /// Its text.
    title: String,
}

/// The HTML of a chapter without its title, and its sections.
pub fn html(chapter: &Chapter, reports: &Path) -> Result<(String, Vec<Section>), Error> {
    let (mut events, mut sections) = (Vec::new(), Vec::new());
    let options = Options::ENABLE_TABLES | Options::ENABLE_MATH;
    let mut parser = Parser::new_ext(chapter.text, options);
    // How many open links and pictures lead nowhere on the pages.
    let mut dropped = Vec::new();
    while let Some(event) = parser.next() {
        let shown = match event {
            Event::Start(Tag::Heading { level, .. }) => {
                let inside: Vec<Event<'_>> =
                    parser.by_ref().take_while(|e| !matches!(e, Event::End(TagEnd::Heading(_)))).collect();
                if level == HeadingLevel::H1 {
                    continue;
                }
                let (title, anchor) = (text(&inside), links::anchor(&text(&inside)));
                let open = format!("<{level} id=\"{anchor}\"><a class=\"anchor\" href=\"#{anchor}\">");
                events.push(Event::Html(open.into()));
                events.extend(inside);
                if level == HeadingLevel::H2 {
                    sections.push(Section { anchor, title });
                }
                Event::Html(format!("</a></{level}>").into())
            }
            Event::InlineMath(tex) => Event::InlineHtml(formula::mathml(&tex, DisplayMode::Inline)?.into()),
            Event::DisplayMath(tex) => {
                let math = formula::mathml(&tex, DisplayMode::Block)?;
                Event::InlineHtml(format!("<span class=\"formula\">{math}</span>").into())
            }
            // Wide tables scroll in a box of their own, which the keyboard reaches.
            Event::Start(Tag::Table(_)) => {
                events.push(Event::Html(
                    "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"table\">".into(),
                ));
                event
            }
            Event::End(TagEnd::Table) => {
                events.push(event);
                Event::Html("</div>".into())
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let target = links::on_pages(&dest_url, reports);
                dropped.push(target.is_none());
                match target {
                    Some(url) => Event::Start(Tag::Link { link_type, dest_url: url.into(), title, id }),
                    None => Event::InlineHtml(format!("<span title=\"{}\">", in_repository(&dest_url)).into()),
                }
            }
            Event::End(TagEnd::Link) if dropped.pop() == Some(true) => Event::InlineHtml("</span>".into()),
            Event::Start(Tag::Image { link_type, dest_url, title, id }) => match links::on_pages(&dest_url, reports) {
                Some(url) => Event::Start(Tag::Image { link_type, dest_url: url.into(), title, id }),
                None => {
                    let inside: Vec<Event<'_>> =
                        parser.by_ref().take_while(|e| !matches!(e, Event::End(TagEnd::Image))).collect();
                    Event::InlineHtml(format!("<em class=\"soft\">[{}]</em>", text(&inside)).into())
                }
            },
            other => other,
        };
        events.push(shown);
    }
    let mut page = String::new();
    html::push_html(&mut page, events.into_iter());
    Ok((page, sections))
}

/// A path of the repository as it is written from its top.
fn in_repository(link: &str) -> CowStr<'_> {
    link.trim_start_matches("../").into()
}

/// The words of some events.
fn text(events: &[Event<'_>]) -> String {
    let word = |event: &Event<'_>| match event {
        Event::Text(text) | Event::Code(text) | Event::InlineMath(text) => text.to_string(),
        _ => String::new(),
    };
    events.iter().map(word).collect()
}
