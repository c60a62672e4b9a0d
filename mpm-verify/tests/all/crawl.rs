//! Every link and picture of pages: what it leads to, and whether that is there.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// What a crawl has met.
#[derive(Debug, Default)]
pub struct Crawl {
    pub pages: BTreeSet<PathBuf>,
    pub links: usize,
    pub images: usize,
    /// Page and target of what leads nowhere.
    pub dead: Vec<String>,
}

/// Follows all that the pages below a folder refer to within it: files, and anchors of pages.
pub fn crawl(root: &Path) -> Crawl {
    let mut crawl = Crawl::default();
    find(root, &mut crawl.pages);
    let texts: BTreeMap<&PathBuf, String> =
        crawl.pages.iter().map(|page| (page, fs::read_to_string(page).expect("a page"))).collect();
    for (page, text) in &texts {
        for (is_image, target) in references(text) {
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            crawl.links += usize::from(!is_image);
            crawl.images += usize::from(is_image);
            let path = if file.is_empty() { (*page).clone() } else { plain(&page.with_file_name(file)) };
            let has = |text: &String| text.contains(&format!("id=\"{anchor}\""));
            if !path.exists() || !(anchor.is_empty() || texts.get(&path).is_some_and(has)) {
                crawl.dead.push(format!("{} -> {target}", page.strip_prefix(root).unwrap_or(page).display()));
            }
        }
    }
    crawl
}

fn find(folder: &Path, pages: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            find(&path, pages);
        } else if path.extension().is_some_and(|e| e == "html") {
            pages.insert(path);
        }
    }
}

/// A path without `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        if part == std::path::Component::ParentDir {
            plain.pop();
        } else {
            plain.push(part);
        }
        plain
    })
}

/// Targets in a page's own files: whether each is an image, and where it is. Scripts make theirs from what the page has.
fn references(text: &str) -> Vec<(bool, String)> {
    let outside_scripts =
        text.split("<script").map(|part| part.split_once("</script>").map_or(part, |(_, after)| after));
    let mut found = Vec::new();
    // The first part ends where the first script begins.
    for part in outside_scripts {
        for (attribute, is_image) in [(" href=\"", false), (" src=\"", true)] {
            let targets = part.split(attribute).skip(1).filter_map(|rest| rest.split_once('"'));
            found.extend(targets.map(|(target, _)| (is_image, target.replace("&amp;", "&").replace("%20", " "))));
        }
    }
    // Addresses elsewhere are not asked for; one with a space leads nowhere.
    found.retain(|(_, target)| target.contains(' ') || !target.contains(':') && !target.is_empty());
    found
}

#[test]
fn what_leads_nowhere_is_found() {
    let own = tempfile::tempdir().expect("a folder");
    let folder = own.path().join("below");
    fs::create_dir(&folder).expect("a folder");
    let page = "<h2 id=\"here\"></h2><a href=\"#here\"></a><a href=\"#gone\"></a><a href=\"../index.html#top\"></a>\
                <script>x = ' href=\"none\"'</script><img src=\"lost.png\"><a href=\"https://far\"></a><a href=\"https://far; near\"></a><a href=\"../lost.csv\"></a>";
    fs::write(folder.join("page.html"), page).expect("written");
    fs::write(own.path().join("index.html"), "<h1 id=\"top\"></h1>").expect("written");
    let found = crawl(own.path());
    assert_eq!((found.pages.len(), found.links, found.images), (2, 5, 1));
    assert_eq!(
        found.dead,
        ["#gone", "https://far; near", "../lost.csv", "lost.png"].map(|target| format!("below/page.html -> {target}"))
    );
}
