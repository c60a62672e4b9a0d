//! The report as one HTML file: pictures and styles inside it, nothing fetched.

use minijinja::{Environment, Value, context};
use serde::Serialize;
use serde_json::Value as Json;

use super::content::Content;
use super::plots::draw;
use super::plots::figure::Figure;

const TEMPLATE: &str = include_str!("template.html");

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

/// The page. `drawn` holds the SVG text of each figure; `folder` is the name of the folder with the files that the
/// page links to.
///
/// # Errors
/// The template does not fit the content.
pub fn page(content: &Content, figures: &[Figure], drawn: &[String], folder: &str) -> Result<String, minijinja::Error> {
    let pictures: Vec<Drawn> = content.pictures.iter().zip(figures).zip(drawn).map(picture).collect();
    let mut environment = Environment::new();
    environment.add_template("index.html", TEMPLATE)?;
    environment.get_template("index.html")?.render(context! {
        page => value(serde_json::json!(content)),
        pictures => value(serde_json::json!(pictures)),
        folder,
    })
}

fn picture<'a>(((words, figure), svg): ((&'a super::content::Picture, &'a Figure), &String)) -> Drawn<'a> {
    // A name by which small copies are made, and a description for those who cannot see it.
    let head = format!("<svg id=\"svg-{}\" role=\"img\" aria-label=\"{}\"", figure.name, escaped(&figure.title));
    let view = format!("0 0 {} {}", draw::WIDTH, draw::height(figure).ceil());
    let svg = svg.replacen("<svg", &head, 1);
    Drawn { name: figure.name, number: words.number, title: &words.title, caption: &words.caption, svg, view }
}

/// A value for the template.
fn value(json: Json) -> Value {
    match json {
        Json::Null => Value::from(()),
        Json::Bool(b) => Value::from(b),
        Json::Number(n) => n.as_u64().map_or_else(|| Value::from(n.as_f64()), Value::from),
        Json::String(text) => Value::from(text),
        Json::Array(items) => items.into_iter().map(value).collect(),
        Json::Object(fields) => Value::from_pairs(fields.into_iter().map(|(name, field)| (name, value(field)))),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}
