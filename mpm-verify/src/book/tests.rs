use pulldown_latex::config::DisplayMode;

use super::{formula, links, reference};

#[test]
fn a_formula_becomes_mathml_and_what_is_no_tex_an_error() {
    let math =
        formula::mathml(r"\frac{n}{K_w}\,\dot p = -\nabla\cdot\mathbf v", DisplayMode::Block).expect("a formula");
    assert!(math.starts_with("<math") && math.contains("<mfrac>"), "{math}");
    let less = formula::mathml("a < b", DisplayMode::Inline).expect("a formula");
    assert!(less.contains("&lt;") && !less.contains("><<"), "{less}");
    assert!(formula::mathml(r"\frac{1}{", DisplayMode::Inline).is_err());
    assert!(formula::mathml(r"\nosuchcommand", DisplayMode::Inline).is_err());
}

#[test]
fn links_lead_to_pages_or_are_dropped() {
    let reports = tempfile::tempdir().expect("a folder");
    std::fs::write(reports.path().join("there.csv"), "").expect("a file");
    let on_pages = |link| links::on_pages(link, reports.path());
    assert_eq!(on_pages("theory.md#balance-laws").as_deref(), Some("theory.html#balance-laws"));
    assert_eq!(on_pages("#here").as_deref(), Some("#here"));
    assert_eq!(on_pages("../../reports/there.csv").as_deref(), Some("../there.csv"));
    assert_eq!(on_pages("../../reports/not.csv"), None);
    assert_eq!(on_pages("../../mpm-core/src/lib.rs"), None);
    assert_eq!(links::anchor("5. Verify it (2 minutes)"), "5-verify-it-2-minutes");
}

#[test]
fn the_checker_names_every_key_with_its_kind_and_bounds() {
    let keys = reference::keys();
    let of = |path: &str| keys.iter().find(|key| key.path == path).unwrap_or_else(|| panic!("{path}"));
    assert_eq!(of("soil.porosity").kind, "number");
    assert_eq!(of("mesh.particles_per_cell").kind, "whole number");
    assert_eq!(of("stages").kind, "a list of tables");
    assert!(of("soil.law.linear_elastic.poisson_ratio").bounds.as_deref().is_some_and(|b| b.contains("0.5")));
    assert!(of("water.free_surface.feed.*.head").row.is_some());
    assert!(keys.len() > 150, "{}", keys.len());
}
