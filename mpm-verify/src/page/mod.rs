//! The pages: one layout, one style, one script and one navigation for everything that this program writes to be read in a browser.
//!
//! A page is data: a verdict, then sections made of pictures, tables and text, then the conditions of the run. `layout.html` renders it, with
//! `style.css` and `script.js` inside; nothing is fetched. `page.md` renders the same content as Markdown.
//!
//! # Reading order
//! 1. [`verdict`]: the badge and the sentence at the top. [`table`]: tables. [`picture`], [`svg`]: figures drawn into a page.
//! 2. [`Page`], [`Section`], [`Block`]: what a page is made of.
//! 3. [`site`]: `report.json` beside every report, and the home page that lists all reports.

pub mod picture;
pub mod site;
pub mod sketch;
pub mod svg;
pub mod table;
#[cfg(test)]
mod tests;
pub mod verdict;

use std::path::Path;

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, Value, context};
use serde_json::Value as Json;

use self::picture::Picture;
use self::site::Report;
use self::table::Table;
use self::verdict::Verdict;
use crate::files;
use crate::manifest::Manifest;
use crate::report::plots::figure::Figure;
use crate::report::{ReportError, unwritable};

const LAYOUT: &str = include_str!("layout.html");
const MARKDOWN: &str = include_str!("page.md");
const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// A link with its text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Link {
    /// Its text.
    pub text: String,
    /// Its target, relative to the page.
    pub href: String,
}

impl Link {
    /// A link.
    pub fn new(text: impl Into<String>, href: impl Into<String>) -> Self {
        Self { text: text.into(), href: href.into() }
    }
}

/// A picture from a file beside the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// The file, relative to the page.
    pub src: String,
    /// What is seen in it, for those who cannot see it.
    pub alt: String,
    /// Text below it.
    pub caption: String,
    /// Where a click on it leads; empty for nowhere.
    pub href: String,
}

/// A part of a section. Texts may hold `code` between backticks and links as `[text](target)`.
#[derive(Debug, Clone)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A paragraph in small letters.
    Note(String),
    /// A warning.
    Warning(String),
    /// A heading below that of the section.
    Heading(String),
    /// A list.
    List(Vec<String>),
    /// Terms with their meanings.
    Terms(Vec<(String, String)>),
    /// A command line.
    Command(String),
    /// Files beside the page.
    Files(Vec<String>),
    /// A table; with `true` its rows can be filtered.
    Table(Table, bool),
    /// A figure, the folder of its files, and the endings that they have.
    Figure(Box<Figure>, String, &'static [&'static str]),
    /// Images side by side.
    Images(Vec<Image>),
    /// Anything else, as HTML.
    Html(String),
}

/// A section with its heading.
#[derive(Debug, Clone, Default)]
pub struct Section {
    /// Its anchor.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// Whether it is folded up at first.
    pub folded: bool,
    /// Its parts in their order.
    pub blocks: Vec<Block>,
}

/// Endings of the files of a figure: numbers, image, drawing.
pub const ALL_FILES: &[&str] = &["csv", "png", "svg"];

impl Section {
    /// An empty section.
    pub fn new(id: &str, title: &str) -> Self {
        Self { id: id.to_owned(), title: title.to_owned(), ..Self::default() }
    }

    /// Folded up at first.
    pub fn folded(self) -> Self {
        Self { folded: true, ..self }
    }

    /// With a further part.
    pub fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// With a paragraph, unless it is empty.
    pub fn text(self, text: impl Into<String>) -> Self {
        let text = text.into();
        if text.is_empty() { self } else { self.with(Block::Text(text)) }
    }

    /// With a paragraph in small letters.
    pub fn note(self, text: impl Into<String>) -> Self {
        self.with(Block::Note(text.into()))
    }

    /// With a list, unless it is empty.
    pub fn list(self, items: Vec<String>) -> Self {
        if items.is_empty() { self } else { self.with(Block::List(items)) }
    }

    /// With tables.
    pub fn tables(mut self, tables: impl IntoIterator<Item = Table>) -> Self {
        self.blocks.extend(tables.into_iter().map(|table| Block::Table(table, false)));
        self
    }

    /// With a table whose rows can be filtered.
    pub fn index(self, table: Table) -> Self {
        self.with(Block::Table(table, true))
    }

    /// With a figure whose files, of all endings, are in `plots`.
    pub fn figure(self, figure: &Figure) -> Self {
        self.figure_in(figure, "plots", ALL_FILES)
    }

    /// With a figure whose files are in a folder beside the page (`.` for the folder of the page) and have some endings.
    pub fn figure_in(self, figure: &Figure, folder: &str, files: &'static [&'static str]) -> Self {
        self.with(Block::Figure(Box::new(figure.clone()), folder.to_owned(), files))
    }

    /// With links to files beside the page.
    pub fn files<T: Into<String>>(self, files: impl IntoIterator<Item = T>) -> Self {
        self.with(Block::Files(files.into_iter().map(Into::into).collect()))
    }
}

/// A page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// Its verdict, where something is judged.
    pub verdict: Option<Verdict>,
    /// A sentence or two below the verdict.
    pub lead: String,
    /// Warnings below that.
    pub warnings: Vec<String>,
    /// Its sections: pictures first, then tables.
    pub sections: Vec<Section>,
    /// Conditions of the run: name and value. They come last.
    pub conditions: Vec<(String, String)>,
    /// Pages above it in the same report, from the top.
    pub above: Vec<Link>,
    /// Other pages of the same report.
    pub beside: Vec<Link>,
    /// What the home page says about the report; written as `report.json` beside the page.
    pub report: Option<Report>,
    /// Rules of style that it alone needs.
    pub style: String,
    /// Whether it is the home page.
    pub home: bool,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// With its verdict.
    pub fn verdict(self, verdict: Verdict) -> Self {
        Self { verdict: Some(verdict), ..self }
    }

    /// With a sentence or two below the verdict.
    pub fn lead(self, lead: impl Into<String>) -> Self {
        Self { lead: lead.into(), ..self }
    }

    /// With warnings.
    pub fn warnings(self, warnings: impl IntoIterator<Item = String>) -> Self {
        Self { warnings: warnings.into_iter().collect(), ..self }
    }

    /// With a further section, unless there is nothing in it.
    pub fn section(mut self, section: Section) -> Self {
        if !section.blocks.is_empty() {
            self.sections.push(section);
        }
        self
    }

    /// With the conditions of a run.
    pub fn conditions(self, manifest: &Manifest) -> Self {
        let owned = |(name, value): (&'static str, String)| (name.to_owned(), value);
        Self { conditions: manifest.entries().into_iter().map(owned).collect(), ..self }
    }

    /// Below another page of the same report.
    pub fn below(mut self, text: &str, href: &str) -> Self {
        self.above.push(Link::new(text, href));
        self
    }

    /// With rules of style of its own.
    pub fn style(self, rules: impl Into<String>) -> Self {
        Self { style: rules.into(), ..self }
    }

    /// With other pages of the same report.
    pub fn beside(self, links: Vec<Link>) -> Self {
        Self { beside: links, ..self }
    }

    /// As the first page of a report, which the home page lists.
    pub fn report(self, report: Report) -> Self {
        Self { report: Some(report), ..self }
    }

    /// Writes the page, and `report.json` beside it if it is the first page of a report.
    ///
    /// # Errors
    /// A figure that cannot be drawn, a template that does not fit, or a file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ReportError> {
        let html = self.html(path)?;
        files::write(path, html.as_bytes()).map_err(|e| unwritable(path, e))?;
        if let (Some(report), Some(folder)) = (&self.report, path.parent()) {
            report.write(self, folder)?;
        }
        Ok(())
    }

    /// The page as HTML for a place; links to the home page lead from there.
    ///
    /// # Errors
    /// A figure that cannot be drawn, or a template that does not fit.
    pub fn html(&self, path: &Path) -> Result<String, ReportError> {
        self.rendered(LAYOUT, "page.html", path)
    }

    /// The same content as Markdown.
    ///
    /// # Errors
    /// As [`Page::html`].
    pub fn markdown(&self, path: &Path) -> Result<String, ReportError> {
        self.rendered(MARKDOWN, "page.md", path)
    }

    fn rendered(&self, template: &str, name: &str, path: &Path) -> Result<String, ReportError> {
        let lost = |cause| ReportError::Page { path: path.to_owned(), cause };
        let drawn = |cause| ReportError::Draw { path: path.to_owned(), cause };
        let mut number = 0;
        let sections: Vec<Value> =
            self.sections.iter().map(|s| section(s, &mut number)).collect::<Result<_, _>>().map_err(drawn)?;
        let links = |links: &[Link]| -> Vec<Value> {
            links.iter().map(|link| context! { text => &link.text, href => &link.href }).collect()
        };
        let verdict = self.verdict.as_ref().map(|v| {
            context! { word => v.state.word(), mark => v.state.mark(), sentence => &v.sentence }
        });
        let page = context! {
            title => &self.title,
            verdict,
            lead => &self.lead,
            warnings => &self.warnings,
            sections,
            conditions => &self.conditions,
            above => links(&self.above),
            beside => links(&self.beside),
            home => (!self.home).then(|| site::home_link(path)),
        };
        let mut environment = Environment::new();
        environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).build().map_err(lost)?);
        // Texts of a page are escaped, but not the slashes of links.
        let is_html = name.ends_with("html");
        environment.set_formatter(move |out, _, value| {
            let text = value.to_string();
            let text = if is_html && !value.is_safe() { escaped(&text) } else { text };
            out.write_str(&text).map_err(minijinja::Error::from)
        });
        environment.add_filter("prose", prose);
        environment.add_filter("cell", |text: String| text.replace('|', "\\|").replace('\n', " "));
        environment.add_template(name, template).map_err(lost)?;
        let template = environment.get_template(name).map_err(lost)?;
        template
            .render(context! { page, style => format!("{STYLE}{}{}", sketch::STYLE, self.style), script => SCRIPT })
            .map_err(lost)
    }
}

/// A section as the templates take it; figures are numbered on.
fn section(section: &Section, number: &mut usize) -> Result<Value, crate::report::plots::canvas::DrawError> {
    let blocks = section.blocks.iter().map(|one| block(one, number)).collect::<Result<Vec<_>, _>>()?;
    Ok(context! { id => &section.id, title => &section.title, folded => section.folded, blocks })
}

fn block(block: &Block, number: &mut usize) -> Result<Value, crate::report::plots::canvas::DrawError> {
    Ok(match block {
        Block::Text(text) => context! { kind => "text", text },
        Block::Note(text) => context! { kind => "note", text },
        Block::Warning(text) => context! { kind => "warning", text },
        Block::Heading(text) => context! { kind => "heading", text },
        Block::List(items) => context! { kind => "list", items },
        Block::Terms(terms) => context! { kind => "terms", terms },
        Block::Command(text) => context! { kind => "command", text },
        Block::Files(files) => context! { kind => "files", files },
        Block::Table(table, filter) => {
            context! { kind => "table", table => value(serde_json::json!(table)), filter, long => table.rows.len() > 30 }
        }
        Block::Figure(figure, folder, files) => {
            *number += 1;
            let picture = Picture::of(figure)?;
            let folder = if folder == "." { String::new() } else { format!("{folder}/") };
            context! {
                kind => "figure",
                wide => figure.is_wide(),
                number => *number,
                name => figure.name,
                title => &figure.title,
                caption => &figure.caption,
                svg => Value::from_safe_string(picture.svg),
                points => Value::from_safe_string(picture.points),
                folder,
                files => files.to_vec(),
            }
        }
        Block::Images(images) => {
            let image = |i: &Image| context! { src => &i.src, alt => &i.alt, caption => &i.caption, href => &i.href };
            context! { kind => "images", images => images.iter().map(image).collect::<Vec<_>>() }
        }
        Block::Html(html) => context! { kind => "html", html => Value::from_safe_string(html.clone()) },
    })
}

/// A value for the templates.
pub(crate) fn value(json: Json) -> Value {
    match json {
        Json::Null => Value::from(()),
        Json::Bool(b) => Value::from(b),
        Json::Number(n) => n.as_u64().map_or_else(|| Value::from(n.as_f64()), Value::from),
        Json::String(text) => Value::from(text),
        Json::Array(items) => items.into_iter().map(value).collect(),
        Json::Object(fields) => Value::from_pairs(fields.into_iter().map(|(name, field)| (name, value(field)))),
    }
}

/// Text as HTML: `code` between backticks, `[text](target)` as a link, all else escaped.
fn prose(text: &str) -> Value {
    let mut html = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(['`', '[']) {
        html += &escaped(&rest[..at]);
        rest = &rest[at..];
        let code = rest.strip_prefix('`').and_then(|inner| inner.split_once('`'));
        let link = rest.strip_prefix('[').and_then(|inner| inner.split_once("](")).and_then(|(words, inner)| {
            let (target, after) = inner.split_once(')')?;
            (!words.contains(['[', ']']) && !target.contains(' ')).then_some((words, target, after))
        });
        match (code, link) {
            (Some((inner, after)), _) => {
                html += &format!("<code>{}</code>", escaped(inner));
                rest = after;
            }
            (_, Some((words, target, after))) => {
                html += &format!("<a href=\"{}\">{}</a>", escaped(target), escaped(words));
                rest = after;
            }
            _ => {
                let (mark, after) = rest.split_at(1);
                html += mark;
                rest = after;
            }
        }
    }
    html += &escaped(rest);
    Value::from_safe_string(html)
}

/// Text with the characters escaped that mean something in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;").replace('>', "&gt;")
}
