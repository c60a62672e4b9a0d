//! The report as one HTML file: pictures and styles inside it, nothing fetched.

use minijinja::{Environment, context};
use serde::Serialize;
use serde_json::Value as Json;

use super::content::Picture;
use super::plots::draw;
use super::plots::figure::Figure;
use crate::page::value;

/// What every page begins with: styles, and how tables and pictures are shown.
const HEAD: &str = include_str!("head.html");

/// A picture as the template shows it.
#[derive(Debug, Serialize)]
struct Drawn<'a> {
    name: &'a str,
    number: usize,
    title: &'a str,
    caption: &'a str,
    svg: String,
    /// The viewBox of small copies.
    view: String,
}

/// A page of any content: `body` is its template from the header on, and finds `page`, `pictures`, `folder` and the
/// macros `tables` and `picture`; `page` needs a `title`.
///
/// # Errors
/// The template does not fit the content.
pub fn render(
    body: &str,
    page: Json,
    words: &[Picture],
    (figures, drawn): (&[Figure], &[String]),
    folder: &str,
) -> Result<String, minijinja::Error> {
    let pictures: Vec<Drawn> = words.iter().zip(figures).zip(drawn).map(picture).collect();
    let mut environment = Environment::new();
    let template = HEAD.to_owned() + body;
    environment.add_template("index.html", &template)?;
    environment.get_template("index.html")?.render(context! {
        page => value(page),
        pictures => value(serde_json::json!(pictures)),
        folder,
    })
}

fn picture<'a>(((words, figure), svg): ((&'a Picture, &'a Figure), &String)) -> Drawn<'a> {
    // A name by which small copies are made, and a description for those who cannot see it.
    let head = format!("<svg id=\"svg-{}\" role=\"img\" aria-label=\"{}\"", figure.name, escaped(&figure.title));
    let view = format!("0 0 {} {}", draw::WIDTH, draw::height(figure).ceil());
    let svg = svg.replacen("<svg", &head, 1);
    Drawn { name: figure.name, number: words.number, title: &words.title, caption: &words.caption, svg, view }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}
