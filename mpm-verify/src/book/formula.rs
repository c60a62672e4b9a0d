//! TeX to MathML.

use std::convert::Infallible;

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::mathml::push_mathml;
use pulldown_latex::{Parser, Storage};

use super::Error;

/// A formula as MathML, in a line of text or as a block of its own, which scrolls where the page is narrower.
///
/// # Errors
/// What is not TeX, or no command that is known.
pub fn mathml(tex: &str, display_mode: DisplayMode) -> Result<String, Error> {
    let storage = Storage::new();
    let events: Result<Vec<_>, _> = Parser::new(tex, &storage).collect();
    let wrong = |why: &dyn std::fmt::Display| Error::Formula { tex: tex.to_owned(), why: why.to_string() };
    let events = events.map_err(|why| wrong(&why))?;
    let mut html = String::new();
    let config = RenderConfig { display_mode, ..RenderConfig::default() };
    push_mathml(&mut html, events.into_iter().map(Ok::<_, Infallible>), config).map_err(|why| wrong(&why))?;
    // It leaves this one sign as it is, and writes a space without break as an entity whose sign is then escaped.
    let math = html.replace("><<", ">&lt;<").replace("&amp;nbsp;", "\u{a0}");
    let open = "<span class=\"formula\" role=\"group\" tabindex=\"0\" aria-label=\"Formula, scrollable\">";
    Ok(if matches!(display_mode, DisplayMode::Block) { format!("{open}{math}</span>") } else { math })
}
