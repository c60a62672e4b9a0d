//! Which levee is followed, by which driver, from when to when.

use mpm_core::failure::Scales;
use mpm_core::hash::{Digest, sha256};
use mpm_core::scene::{Failure, Fields, Flags, Integrator, Scene};

use super::variants::{Change, Variant};
use crate::error::Error;
use crate::manifest::scene_hash;
use crate::scenes::BUILT_IN;

/// Where a scene is run many times, its cells are so many times as large.
pub const COARSER: f64 = 2.0;

/// What a run is made of; all of it decides on its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The scene; its integrator is the driver.
    pub scene: Scene,
    /// Staggered up to here, then the driver of the scene; time on the reader's clock, h.
    pub from_h: Option<f64>,
    /// Where to end before the scene does, h on the same clock.
    pub until_h: Option<f64>,
    /// Whether frames are kept.
    pub frames: bool,
}

/// A word of `--driver`: the same as of `time.integrator`.
pub fn driver_word(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Explicit => "explicit",
        Integrator::SemiImplicit => "semi-implicit",
        Integrator::QuasiStatic => "quasi-static",
        Integrator::Implicit => "implicit",
        Integrator::Staggered => "staggered",
        Integrator::Coupled => "coupled",
    }
}

/// Reads a scene, a file or a built-in name, with flags and the change of a variant.
///
/// # Errors
/// What was expected and found.
pub fn scene(source: &str, flags: &Flags, variant: Option<&Variant>) -> Result<Scene, Error> {
    let mut flags = flags.clone();
    match variant.map(|v| v.change) {
        Some(Change::Mesh(cell)) => flags.cell = Some(cell),
        Some(Change::Particles(count)) => flags.particles_per_cell = Some(count),
        _ => {}
    }
    let mut scene = crate::scenes::load(source, &flags)?;
    if let Some(Change::Edit(edit)) = variant.map(|v| v.change) {
        // The variants are other readings of that levee.
        let own = Plan { scene: scene.clone(), from_h: None, until_h: None, frames: false };
        if let Some(why) = own.not_papers() {
            return Err(Error::Found(why).of("--variant"));
        }
        scene = scene.edited(edit)?;
    }
    if scene.failure.is_none() {
        let expected = "a scene whose soil may fail, with a stage of coupling = \"full\"";
        return Err(Error::refused(source, expected, "none"));
    }
    Ok(scene)
}

impl Plan {
    /// A plan, if it is possible.
    ///
    /// # Errors
    /// What was expected and found.
    pub fn new(scene: Scene, from_h: Option<f64>, until_h: Option<f64>, frames: bool) -> Result<Self, Error> {
        let plan = Self { scene, from_h, until_h, frames };
        let (start, end) = (plan.starts_h(), plan.scene_ends_h());
        if from_h.is_some() && plan.scene.integrator == Integrator::Staggered {
            return Err(Error::refused("--from", "--driver coupled or explicit", "staggered all the time"));
        }
        for (flag, time) in [("--from", from_h), ("--until", until_h)] {
            if let Some(time) = time.filter(|t| !(*t > start && *t <= end)) {
                let expected = format!("hours on the clock of the scene, above {start} and up to {end}");
                return Err(Error::refused(flag, expected, time));
            }
        }
        Ok(plan)
    }

    /// Why what is said of the paper's levee alone says nothing of this scene; `None` if it is that levee, whatever is changed in it
    /// that the paper leaves open.
    pub fn not_papers(&self) -> Option<String> {
        let (name, text) = BUILT_IN.iter().find(|(name, _)| *name == "levee")?;
        let (own, papers) = (&self.scene, Scene::parse(text, name).ok()?);
        let strength = |scene: &Scene| scene.strength.map(|s| (s.cohesion, s.friction_angle));
        let other = if own.outline != papers.outline {
            "outline"
        } else if (own.grain_density, own.porosity, own.elastic)
            != (papers.grain_density, papers.porosity, papers.elastic)
        {
            "soil"
        } else if strength(own) != strength(&papers) {
            "strength"
        } else if own.gravity != papers.gravity || self.starts_h() != 6.0 {
            "gravity or start of the clock"
        } else {
            return None;
        };
        Some(format!("expected the levee of the paper's Table 3, found {}, with another {other}", own.name))
    }

    /// Whether it is the paper's levee.
    pub fn papers(&self) -> bool {
        self.not_papers().is_none()
    }

    /// Scales of the scene.
    pub fn scales(&self) -> Scales {
        Scales::of(&self.scene)
    }

    fn failure(&self) -> &Failure {
        // `scene` lets no other through.
        self.scene.failure.as_ref().expect("a scene whose soil may fail")
    }

    /// What the clock shows when water begins to seep, h.
    pub fn starts_h(&self) -> f64 {
        self.failure().starts_at / 3600.0
    }

    fn scene_ends_h(&self) -> f64 {
        use mpm_core::scene::Until;
        let time = match self.scene.stages[0].until {
            Until::Time(time) => time,
            Until::PorePressure { at_most, .. } | Until::Rest { at_most, .. } => at_most,
        };
        self.starts_h() + time / 3600.0
    }

    /// What it shows at the latest end of the run, h.
    pub fn ends_h(&self) -> f64 {
        self.until_h.unwrap_or_else(|| self.scene_ends_h())
    }

    /// Time since water began to seep (s) at a time on the clock (h).
    pub fn seconds(&self, hours: f64) -> f64 {
        hours * 3600.0 - self.failure().starts_at
    }

    /// Observed places, m.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.failure().points
    }

    /// Places x (m) whose level of water is recorded.
    pub fn levels(&self) -> &[f64] {
        &self.failure().levels
    }

    /// Tells scenes apart, whichever driver runs them.
    pub fn scene_word(&self) -> String {
        scene_hash(&Fields { integrator: Integrator::Staggered, ..Fields::clone(&self.scene) })
    }

    /// Tells plans apart whose states do not fit together. The end may be moved: a run can go on for longer.
    pub fn fingerprint(&self) -> Digest {
        let scene = serde_json::to_string(&self.scene).unwrap_or_default();
        sha256(format!("{scene}\nfrom {:?}\nframes {}", self.from_h, self.frames).as_bytes())
    }
}
