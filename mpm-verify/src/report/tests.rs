//! Tests of the report on small made-up studies.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use super::*;
use crate::budget::budgets;
use crate::claims::{judge, judge_others};
use crate::exact::terzaghi::Terzaghi;
use crate::study::tests::result;
use crate::study::{Degree, HistoryPoint, Profile, ProfilePoint, Variant};
use crate::sweeps::places::{Displacement, Shift};
use crate::sweeps::time::TimeError;

/// The columns of `errors.csv` that others parse, in order.
const CONTRACT: &str = "case,integrator,scheme,load,mesh_m,ppc,particles,dt_s,steps,max_error_terzaghi,\
late_error_terzaghi,max_error_compressible,late_error_compressible,profile_error_compressible,settlement_final_m,\
cell_crossings,cpu_s,ns_per_point_step";

/// Integrators of scenes that do not fail.
pub const INTEGRATORS: [&str; 5] = ["explicit", "semi-implicit", "quasi-static", "implicit", "staggered"];

/// A scene file: a soft block under its weight and a strip load, or a step of soil with an outline under its weight.
pub fn block(integrator: &str, shape: &str, outline: bool) -> String {
    let (free, wet) = (integrator == "staggered", matches!(integrator, "semi-implicit" | "staggered"));
    let stepped = "geometry.outline.points = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]]";
    let strip = "surcharge = { pressure = 5e3, on = \"surface\", strip = { from = 0.0, to = 0.5 } }";
    let water = "[water]\nhydraulic_conductivity = 1e-3\nbulk_modulus = 2e6\nunit_weight = 9810.0\n";
    format!(
        "name = \"block\"\ndimension = \"plane-strain\"\nstart = \"unloaded\"\ngravity = 9.81\n{}\n{}\n\
         mesh = {{ cell = 0.25, particles_per_cell = 4 }}\n\
         boundaries = {{ left = \"roller\", right = \"roller\", bottom = \"fixed\" }}\n\
         scheme.shape = \"{shape}\"\ntime.integrator = \"{integrator}\"\n\
         [soil]\ngrain_density = 1800.0\nporosity = 0.3\n\
         law.linear_elastic = {{ youngs_modulus = 2.5e5, poisson_ratio = 0.3 }}\n{}{}[[stages]]\n{}until.time = 0.1\n",
        if outline { stepped } else { "geometry.column = { height = 1.0, width = 1.0 }" },
        if free || outline { "" } else { strip },
        if wet { water } else { "" },
        if free { "free_surface.level = 0.4\n" } else { "" },
        if wet { "drained = [\"top\"]\n" } else { "" },
    )
}

/// A run whose U is too small by a share of L.
fn run(mesh: f64, ppc: usize, load: &str, variant: Variant) -> CaseResult {
    let scene = crate::scenes::terzaghi();
    let exact =
        [Terzaghi::incompressible(&scene), Terzaghi::compressible(&scene)].map(|e| e.expect("water and a load"));
    let mut run = result(mesh, ppc, load);
    run.variant = variant;
    let unit = 1.0 / exact[0].time_factor(1.0);
    let degree = |d: &Degree| {
        let [terzaghi, compressible] = exact.map(|e| e.relative_settlement(d.tv * unit));
        let u = compressible * (1.0 - mesh / d.tv.sqrt());
        let (u_dynamic, u_mesh) = (compressible, u);
        Degree { time_s: d.tv * unit, u, u_terzaghi: terzaghi, u_compressible: compressible, u_dynamic, u_mesh, ..*d }
    };
    run.degrees = run.degrees.iter().map(degree).collect();
    run.max_error_terzaghi = 2.0 * mesh;
    run.max_error_compressible = 10.0 * mesh;
    (run.late_error_terzaghi, run.late_error_compressible) = (mesh, 3.0 * mesh);
    (run.profile_error_terzaghi, run.profile_error_compressible) = (0.1 * mesh, 0.2 * mesh * mesh);
    let row = |tv: f64, height_m: f64| {
        let [terzaghi_pa, compressible_pa] = exact.map(|e| e.pressure(height_m, tv * unit));
        ProfilePoint { height_m, pressure_pa: 0.99 * compressible_pa, terzaghi_pa, compressible_pa }
    };
    let profile = |tv: f64| Profile { tv, rows: [0.1, 0.5, 0.9].map(|height| row(tv, height)).to_vec() };
    run.profiles = crate::norms::SAMPLE_TV.map(profile).to_vec();
    let point = |tv: f64| HistoryPoint {
        time_s: tv * unit,
        tv,
        u: tv.sqrt(),
        kinetic_j: 1e-5,
        strain_j: 0.1 * tv,
        water_j: 1e-4,
        external_work_j: 0.3 * tv,
        darcy_dissipation_j: 0.2 * tv,
        flow_body_work_j: 1e-5,
        energy_residual_j: 1e-6,
        water_residual_kg: 0.0,
        water_out_kg: tv,
    };
    run.history = [0.002, 0.02, 0.2, 1.0].map(point).to_vec();
    run
}

fn study(results: Vec<CaseResult>) -> Study {
    Study {
        manifest: Manifest::new(&crate::scenes::terzaghi(), 1),
        budgets: budgets(&results),
        claims: judge(&results),
        other_claims: judge_others(&results),
        sweeps: sweeps(),
        costs: vec![cost()],
        notes: vec!["a note with <angle brackets> & an ampersand".to_owned()],
        results,
    }
}

/// Made-up sweeps: every picture and table has something to show.
fn sweeps() -> Sweeps {
    let displaced = |kind: &str, smooth: f64, jitter: f64, seed: u64, mesh_m: f64| Displacement {
        kind: kind.to_owned(),
        smooth,
        jitter,
        seed,
        scheme: "bspline2".to_owned(),
        quadrature: "fitted".to_owned(),
        mesh_m,
        ppc: 9,
        max_error_compressible: mesh_m * mesh_m * 1e-3 * (1.0 + smooth + jitter),
        late_error_compressible: 1e-7,
        profile_error_compressible: 1e-7,
        required: (mesh_m == 0.1).then_some(1e-4),
        held: (mesh_m == 0.1).then_some(true),
        failure: None,
    };
    let of_mesh = |mesh: f64| {
        let even = displaced("smooth", 0.0, 0.0, 1, mesh);
        [even, displaced("smooth", 0.5, 0.0, 1, mesh), displaced("jitter", 0.0, 0.1, 2, mesh)].into_iter()
    };
    let shift = |shift: f64| Shift {
        shift,
        scheme: "bspline2".to_owned(),
        quadrature: "fitted".to_owned(),
        mesh_m: 0.1,
        ppc: 9,
        max_error_compressible: 2e-4 * shift,
        late_error_compressible: 1e-7,
        profile_error_compressible: 1e-7,
        required: Some(1e-4),
        held: Some(shift <= 0.5),
        failure: None,
    };
    let time = |accepted_steps: u64, tolerance: f64| TimeError {
        integrator: "quasi-static".to_owned(),
        scheme: "bspline2".to_owned(),
        method: "sdirk".to_owned(),
        mesh_m: 0.05,
        ppc: 9,
        tolerance: Some(tolerance),
        step_share: None,
        accepted_steps,
        rejected_steps: 1,
        factorisations: 3,
        solves: 5 * accepted_steps,
        cpu_s: 1e-3,
        time_error: 0.1 * tolerance,
        max_error_compressible: tolerance,
        failure: None,
    };
    Sweeps {
        displaced: [0.1, 0.05].into_iter().flat_map(of_mesh).collect(),
        shifted: [0.0, 0.5, 0.9].map(shift).to_vec(),
        time: vec![time(10, 1e-3), time(20, 1e-5)],
        cpu_s: 1.0,
    }
}

fn cost() -> Cost {
    let (path, spread_ns) = ("a made-up path".to_owned(), [90.0, 110.0]);
    Cost { path, points: 1000, steps: 100, ns_per_point_step: 100.0, spread_ns, bytes_per_point: 200, ratio: 1.0 }
}

/// Two meshes, 1 and 4 particles per cell, both loads, with the further runs of the budget.
fn two_meshes() -> Vec<CaseResult> {
    let mut results = Vec::new();
    for (mesh, ppc) in [(0.1, 1), (0.1, 4), (0.05, 1), (0.05, 4)] {
        for load in ["particles", "surface"] {
            results.push(run(mesh, ppc, load, Variant::Base));
        }
        results.push(run(mesh, ppc, "surface", Variant::HalfStep));
        results.push(run(mesh, ppc, "surface", Variant::SmallLoad));
    }
    results
}

/// The same with quasi-static runs of B-splines and of values at the cell centre.
fn with_other_integrators() -> Vec<CaseResult> {
    let mut results = Vec::new();
    for (scheme, mesh, ppc) in [("bspline2", 0.1, 4), ("bspline2", 0.05, 9), ("bspline2", 0.1, 9), ("centre", 0.1, 4)] {
        let run = run(mesh, ppc, "surface", Variant::Base);
        let (case, share) = (format!("quasi-static-{scheme}-surface-L{mesh}-ppc{ppc}"), 1e-4);
        let (integrator, scheme) = ("quasi-static".to_owned(), scheme.to_owned());
        let (max_error_compressible, dt_s) = (share * run.max_error_compressible, f64::NAN);
        let (tolerance, limit_s) = (Some(1e-5), f64::NAN);
        results.push(CaseResult { case, integrator, scheme, max_error_compressible, dt_s, tolerance, limit_s, ..run });
    }
    // First in the list, and yet headlines and pictures are about the paper's scheme.
    results.extend(two_meshes());
    results
}

/// Pages of a study.
const PAGES: [&str; 5] = ["index.html", "paper.html", "convergence.html", "curves.html", "cases.html"];

/// Writes a small study into a folder.
pub fn write_small(folder: &Path) {
    write(&study(with_other_integrators()), folder).expect("a report");
}

/// The text of all pages of a study.
fn pages(folder: &Path) -> String {
    PAGES.map(|name| fs::read_to_string(folder.join(name)).expect(name)).concat()
}

/// Writes a study into a fresh folder; returns the folder and the text of its pages.
fn written(results: Vec<CaseResult>) -> (tempfile::TempDir, String) {
    let place = tempfile::tempdir().expect("a folder for a test");
    let folder = place.path().join("accuracy");
    write(&study(results), &folder).expect("a report");
    let pages = pages(&folder);
    (place, pages)
}

fn text(place: &tempfile::TempDir, name: &str) -> String {
    fs::read_to_string(place.path().join("accuracy").join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn check_pictures(folder: &Path) {
    for name in plots::NAMES {
        let file = |ending: &str| fs::read(folder.join(format!("{name}.{ending}"))).expect("a picture");
        assert!(file("svg").starts_with(b"<svg ") && file("svg").ends_with(b"</svg>\n"), "{name}");
        assert!(file("png").starts_with(b"\x89PNG") && file("png").len() > 4000, "{name}");
        assert!(file("csv").starts_with(b"panel,series,"), "{name}");
    }
}

/// The small study with other integrators, written once.
static SMALL: LazyLock<(tempfile::TempDir, String)> = LazyLock::new(|| written(with_other_integrators()));

#[test]
fn a_small_study_is_written_whole() {
    let (place, page) = &*SMALL;
    check_pictures(&place.path().join("accuracy/plots"));
    for name in plots::NAMES {
        assert!(page.contains(&format!("id=\"fig-{name}\"")), "the page lacks {name}");
        assert!(text(place, &format!("plots/{name}.csv")).lines().count() > 1, "{name} has no numbers");
    }
    let parts = text(place, "plots/error-budget.csv");
    assert!(parts.starts_with("panel,series,mesh_m,share_percent\ntraction on boundary particles,load placement,0.1,"));
    for name in
        ["study.json", "manifest.json", "report.md", "consolidation.csv", "budget.csv", "claims.csv", "cost.csv"]
    {
        assert!(text(place, name).len() > 100, "{name}");
    }
    assert!(page.contains("a made-up path") && text(place, "report.md").contains("a made-up path"));
    assert!(page.contains("a note with &lt;angle brackets&gt; &amp; an ampersand"));
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org/").count());
}

#[test]
fn the_columns_of_the_error_table_are_the_contract() {
    let (place, _) = &*SMALL;
    let table = text(place, "errors.csv");
    let header = table.lines().next().expect("a header");
    assert_eq!(
        header,
        format!(
            "{CONTRACT},profile_error_terzaghi,limit_s,forced,dimension,scene_hash,failure,\
        accepted_steps,rejected_steps,factorisations,solves,tolerance,strain"
        )
    );
    assert_eq!(table.lines().count(), 1 + 12, "base cases only");
    assert!(
        table.contains("explicit-centre-surface-L0.05-ppc4,explicit,centre,surface,0.05,4,100,1e-6,1000,0.1,0.05,0.5,")
    );
    let consolidation = text(place, "consolidation.csv");
    assert!(consolidation.starts_with("case,integrator,scheme,load,mesh_m,ppc,tv,u,u_terzaghi,u_compressible,"));
    assert_eq!(consolidation.lines().count(), 1 + 12 * 9);
}

#[test]
fn other_integrators_stand_beside_the_paper_and_not_in_its_place() {
    let (place, page) = &*SMALL;
    assert!(page.contains("Pictures and tables of one scheme show explicit-centre."));
    assert!(!page.contains("Largest error of U (quasi-static"));
    assert!(page.contains("The same claims with other integrators") && page.contains("failed"));
    let largest = text(place, "plots/max-error-against-mesh-compressible.csv");
    assert_eq!(largest.lines().count(), 1 + 8, "{largest}");
    let schemes = text(place, "plots/error-of-all-schemes.csv");
    assert!(schemes.contains("\"quasi-static, 9 per cell\",bspline2,0.1,0.0001"), "{schemes}");
    assert!(!text(place, "budget.csv").contains("quasi-static"), "further runs of another integrator were used");
    let errors = text(place, "errors.csv");
    assert!(errors.contains("quasi-static-bspline2-surface-L0.1-ppc9,") && errors.contains(",1e-5,large"), "{errors}");
    for (name, header) in [
        ("displaced.csv", tables::DISPLACED),
        ("grid_shift.csv", tables::GRID_SHIFT),
        ("time_error.csv", tables::TIME_ERROR),
        ("claims_integrators.csv", tables::OTHER_CLAIMS),
    ] {
        let table = text(place, name);
        assert_eq!(table.lines().next(), Some(header));
        assert!(table.lines().count() > 2, "{name}");
    }
    let again: Study = serde_json::from_str(&text(place, "study.json")).expect("a stored study reads back");
    assert!(again.results[0].limit_s.is_nan());
    assert_eq!(again.sweeps.count(), sweeps().count());
}

#[test]
fn the_report_begins_with_the_study_at_a_glance() {
    let (place, page) = &*SMALL;
    let name = plots::at_a_glance::NAME;
    let first = |text: &str, begin: &str| text.split_once(begin).map(|(_, rest)| rest.starts_with(name));
    assert_eq!(first(page, "id=\"fig-"), Some(true));
    assert_eq!(first(&text(place, "report.md"), "](plots/"), Some(true));
    assert!(text(place, "report.json").contains(&format!("plots/{name}.svg")), "home shows it");
    // A narrow screen shows its panels one after the other.
    assert!(page.contains("class=\"picture wide\""));
    let numbers = text(place, &format!("plots/{name}.csv"));
    for row in [
        "degree of consolidation,exact,",
        "degree of consolidation,\"the paper's scheme, 4 per cell\",0.01,",
        "\"pore pressure at Tv = 0.05, 0.2, 0.5, 1\",\"ours, 9 per cell\",",
        "largest error of U,\"the paper's scheme, 1 per cell\",0.05,0.5",
        "largest error of U,\"ours, 9 per cell\",0.05,",
    ] {
        assert!(numbers.contains(row), "{row}: {numbers}");
    }
}

#[test]
fn the_paper_stands_beside_ours_in_words_and_what_is_not_compared_comes_last() {
    let (place, page) = &*SMALL;
    let paper = text(place, "paper.html");
    let claims = judge(&[]);
    for claim in claims.iter().filter(|claim| claim.id.contains('-')) {
        assert!(!page.contains(&claim.id), "{} is a name, no sentence", claim.id);
        assert!(paper.contains(&crate::page::escaped(&claim.said)), "{}", claim.said);
    }
    let [checked, not] = [">Figure 4b</h2>", ">Figure 1</h2>"].map(|part| paper.find(part));
    assert!(checked.is_some() && checked < not, "{checked:?} {not:?}");
    // Figures 1, 3 and 5 are diagrams of which only the text is known: ours are drawn.
    for (item, picture) in [("1", "plots/time-step.svg"), ("3", "plots/time-step.svg"), ("5", "class=\"sketch\"")] {
        let section = paper.split_once(&format!(">Figure {item}</h2>")).expect("a section").1;
        let section = section.split_once("</section>").expect("its end").0;
        assert!(section.contains(picture), "Figure {item}: {section}");
    }
}

#[test]
fn orders_are_those_of_the_errors() {
    let orders = orders::groups(&two_meshes());
    assert_eq!(orders.len(), 4);
    for group in &orders {
        let order = |name: &str| {
            let (_, fit) = group.fits.iter().find(|(norm, _)| *norm == name).expect("a norm");
            fit.fit.as_ref().expect("an order").order
        };
        assert!((order("max-compressible") - 1.0).abs() < 1e-9);
        assert!((order("profile-compressible") - 2.0).abs() < 1e-9);
    }
}

#[test]
fn failed_forced_and_missing_runs_are_said_and_read_back() {
    let mut results = two_meshes();
    results[0].failure = Some("NaN at step 17".to_owned());
    results[0].max_error_terzaghi = f64::NAN;
    results[0].degrees.truncate(2);
    results[0].degrees[1].u = f64::NAN;
    (results[1].forced, results[1].dt_s) = (true, 2.2e-6);
    let unknown = results.iter_mut().find(|r| r.load == "particles" && r.mesh_m == 0.05).expect("a run");
    (unknown.max_error_terzaghi, unknown.max_error_compressible) = (f64::NAN, f64::NAN);
    results[5].degrees[0].u_dynamic = f64::NAN;
    let (place, page) = written(results);
    check_pictures(&place.path().join("accuracy/plots"));
    for words in [
        "Failed: explicit-centre-particles-L0.1-ppc1: NaN at step 17",
        "Forced: 1 of 16 runs have a time step above the stability limit, up to 2.00 times",
        "1 failed runs are left out",
        "explicit-centre-particles-L0.05-ppc1: no largest error",
        "no run with L = 0.02 m",
        "no exact solution for inertia, remainder with the traction on the free surface",
    ] {
        assert!(page.contains(words), "the page does not say: {words}");
        assert!(text(&place, "report.md").contains(words), "report.md does not say: {words}");
    }
    assert!(text(&place, "errors.csv").contains("NaN at step 17"));
    // What is not a number is read back, and written as it was.
    let again: Study = serde_json::from_str(&text(&place, "study.json")).expect("a stored study reads back");
    assert!(again.results[0].max_error_terzaghi.is_nan() && again.results[5].degrees[0].u_dynamic.is_nan());
    let folder = place.path().join("again/accuracy");
    write(&again, &folder).expect("a report");
    assert_eq!(pages(&folder), page);
}

#[test]
fn a_study_without_runs_is_no_panic() {
    let (place, page) = written(Vec::new());
    check_pictures(&place.path().join("accuracy/plots"));
    assert!(page.contains("no run with the traction on the free surface"));
    let one = vec![run(0.1, 9, "surface", Variant::Base)];
    let (place, page) = written(one);
    check_pictures(&place.path().join("accuracy/plots"));
    assert!(page.contains("no further runs for a budget"));
    assert!(!plots::at_a_glance::figure(&[]).caption.contains("paper"), "a scheme that is not drawn");
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let place = tempfile::tempdir().expect("a folder for a test");
    let blocked = place.path().join("file");
    fs::write(&blocked, "no folder").expect("a file");
    let error = write(&study(Vec::new()), &blocked.join("accuracy")).expect_err("a file is no folder");
    assert!(error.to_string().contains("accuracy/plots: cannot be written"), "{error}");
}
