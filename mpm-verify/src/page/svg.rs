//! From the drawing of a figure to one that is part of a page: series and legend become groups, colours follow the theme of the page,
//! clouds of points become one path each. The files on disk stay plain.
//!
//! The drawing has texts between its elements that begin with [`MARK`] and say what follows; they become tags here.

use std::fmt::Write as _;

use super::escaped;
use super::picture::alternative;
use crate::report::plots::canvas::MARK;
use crate::report::plots::figure::Figure;
use crate::report::plots::legend;

/// Colours of drawings and the variables of the style that stand for them.
const COLOURS: [(&str, &str); 12] = [
    ("#000000", "var(--p-ink)"),
    ("#FFFFFF", "var(--p-back)"),
    ("#6E6E6E", "var(--p-grey)"),
    ("#DEDEDE", "var(--p-pale)"),
    ("#0072B2", "var(--p-blue)"),
    ("#D55E00", "var(--p-red)"),
    ("#009E73", "var(--p-green)"),
    ("#BE5A96", "var(--p-purple)"),
    ("#E69F00", "var(--p-orange)"),
    ("#56B4E9", "var(--p-sky)"),
    ("#DDC89E", "var(--p-sand)"),
    ("#C6E0F3", "var(--p-pool)"),
];

/// Left, upper, right and lower edge of the frame of a panel, in units of the drawing.
pub type Frame = [f64; 4];

/// The drawing for a page, and the frames of its panels by their numbers.
pub fn inline(figure: &Figure, marked: &str) -> (String, Vec<(usize, Frame)>) {
    let labels: Vec<String> = legend::entries(figure).into_iter().map(|entry| entry.label().to_owned()).collect();
    // `Terzaghi, Tv = 1` goes with `Tv = 1`.
    let number = |label: &str| {
        let label = unescaped(label);
        let same = labels.iter().position(|known| *known == label);
        same.or_else(|| labels.iter().position(|known| label.ends_with(&format!(", {known}"))))
    };
    let (mut svg, mut frames, mut in_legend) = (String::with_capacity(marked.len() / 2), Vec::new(), false);
    let mut lines = marked.lines();
    while let Some(line) = lines.next() {
        if let Some(rest) = line.strip_prefix("<svg ") {
            let alt = escaped(&alternative(figure));
            // Shown as large as there is room.
            let view = rest.find("viewBox").map_or(rest, |at| &rest[at..]);
            let view = view.split_once(" xmlns").map_or(view, |(view, _)| view);
            let _ = write!(svg, "<svg {view} role=\"group\" aria-label=\"{}\">", escaped(&figure.title));
            let _ = write!(svg, "<g role=\"img\" aria-label=\"{alt}\">");
        } else if line.starts_with("<text ") {
            let text = lines.next().unwrap_or_default();
            lines.next();
            match text.strip_prefix(MARK).map(|mark| mark.split_once(' ').unwrap_or((mark, ""))) {
                None => svg += &format!("{}{text}</text>", tidy(line)),
                Some(("panel", values)) => {
                    let values: Vec<f64> = values.split(' ').filter_map(|v| v.parse().ok()).collect();
                    if let [number, left, top, right, bottom] = values[..] {
                        frames.push((number as usize, [left, top, right, bottom]));
                    }
                }
                Some(("series", label)) => match number(label) {
                    Some(number) => drop(write!(svg, "<g data-s=\"{number}\">")),
                    None => svg += "<g>",
                },
                Some(("legend", _)) => {
                    svg += "</g>";
                    in_legend = true;
                }
                Some(("entry", label)) => {
                    let number = number(label).unwrap_or_default();
                    let head = "<g role=\"button\" tabindex=\"0\" aria-pressed=\"true\"";
                    let _ = write!(svg, "{head} aria-label=\"{label}\" data-l=\"{number}\">");
                }
                Some(("path", path)) => svg += &themed(&unescaped(path)),
                Some(_) => svg += "</g>",
            }
        } else if line == "</svg>" {
            svg += if in_legend { "</svg>" } else { "</g></svg>" };
        } else {
            svg += &tidy(line);
        }
    }
    (svg, frames)
}

/// An element without what its class or the default says anyway.
fn tidy(line: &str) -> String {
    let mut line =
        line.replace(" opacity=\"1\"", "").replace(" font-family=\"sans-serif\"", "").replace(" \"/>", "\"/>");
    if line.starts_with("<polyline fill=\"none\"") {
        line = line.replacen(" fill=\"none\"", "", 1);
    }
    line = line.replace(".00000000000001\"", "\"").replace(" stroke=\"none\"", "").replace(" font-size=\"50\"", "");
    themed(&line.replace(" text-anchor=\"start\"", ""))
}

fn themed(line: &str) -> String {
    COLOURS.iter().fold(
        line.to_owned(),
        |line, (colour, variable)| {
            if line.contains(colour) { line.replace(colour, variable) } else { line }
        },
    )
}

fn unescaped(text: &str) -> String {
    let pairs = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    pairs.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}
