//! Where links of a chapter lead on the pages, which are in the folder `guide` of the reports.

use std::path::Path;

use super::CHAPTERS;

/// The same link on the pages; `None` for what only the repository has.
pub fn on_pages(link: &str, reports: &Path) -> Option<String> {
    let (path, anchor) = link.split_once('#').map_or((link, String::new()), |(path, a)| (path, format!("#{a}")));
    if path.is_empty() || path.contains("://") {
        return Some(link.to_owned());
    }
    if let Some(name) = path.strip_suffix(".md").filter(|name| CHAPTERS.iter().any(|c| c.name == *name)) {
        return Some(format!("{name}.html{anchor}"));
    }
    let report = path.strip_prefix("../../reports/")?;
    reports.join(report).exists().then(|| format!("../{report}{anchor}"))
}

/// The name by which a heading is linked to, as GitHub makes it: small letters, hyphens for spaces, nothing else.
pub fn anchor(heading: &str) -> String {
    let letter = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        _ => None,
    };
    heading.chars().filter_map(letter).collect()
}
