//! What lengths, times and speeds of a slope are measured by. Whatever decides whether soil rests, moves or has failed is a
//! share of one of these: the same slope in other units, of another size or stiffness is judged alike.

use crate::scene::Fields;

/// Elastic settlement of the stiffened soil under its own weight, as a share of its height ([`Scales::stiffening`]).
const STIFF: f64 = 1e-5;
/// Height that does not count as deep, and that of the crest below the highest point, as shares of the height.
const DEEP: f64 = 0.1;
/// Displacements beyond the elastic one at which soil ravels, has failed, has collapsed, as shares of the height.
const EVENTS: [f64; 3] = [1.0 / 300.0, 1.0 / 60.0, 1.0 / 6.0];
/// Water is at the toe when it is no further from it than this share of the height.
const AT_TOE: f64 = 1.0 / 60.0;
/// Less water than this share of all pores is no outflow.
const DROPS: f64 = 2e-5;
/// Soil that rests under damping is slower than the damped slide of soil that lacks this share of its strength.
const CALM: f64 = 3e-4;
/// Soil without damping rests when it is slower than this, in sqrt(g H), for so long, in sqrt(H/g).
const REST: (f64, f64) = (4e-4, 1.0);
/// Looks at soil that moves, and the longest failure, in sqrt(H/g).
const LOOK: f64 = 0.1;
const LONGEST: f64 = 1600.0;
/// Shortest, first and longest time of seepage between two samples of the soil, in the time of the water.
const SEEPAGE: [f64; 3] = [1e-3, 3e-3, 3e-2];

/// Scales of a scene whose soil may fail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Height H of the soil, m.
    pub height: f64,
    /// Gravity g, m/s2.
    pub gravity: f64,
    /// Period of the first swing in shear, `4 H / sqrt(G/rho)`, s.
    pub period: f64,
    /// Elastic settlement under the own weight, `rho g H^2/M`, m.
    pub settlement: f64,
    /// Elastic displacement under what the water can add, `gamma_w H^2/M`, m.
    pub elastic: f64,
    /// Time in which water would cross the soil at a gradient of one, `n H/k`, s.
    pub crossing: f64,
    /// Pores of the section, m2.
    pub pores: f64,
}

impl Scales {
    /// Those of a scene.
    pub fn of(scene: &Fields) -> Self {
        let (height, density, modulus) = (scene.height, scene.mixture_density(), scene.oedometer_modulus());
        let gravity = scene.gravity.unwrap_or(0.0);
        let [weight, conductivity] =
            scene.water.map_or([0.0, f64::INFINITY], |w| [w.unit_weight, w.hydraulic_conductivity]);
        Self {
            height,
            gravity,
            period: 4.0 * height / (scene.elastic.shear_modulus() / density).sqrt(),
            settlement: density * gravity * height * height / modulus,
            elastic: weight * height * height / modulus,
            crossing: scene.porosity * height / conductivity,
            pores: scene.porosity * crate::seeding::area(&scene.outline_or_box()).abs(),
        }
    }

    /// The same of soil that is so many times as stiff.
    pub fn stiffened(&self, times: f64) -> Self {
        Self {
            period: self.period / times.sqrt(),
            settlement: self.settlement / times,
            elastic: self.elastic / times,
            ..*self
        }
    }

    /// How many times as stiff soil must be for its own weight to press it down by a hundred-thousandth of its height. Gravity and
    /// strength reduction then leave the shape as it was drawn, and what they find does not depend on the stiffness.
    pub fn stiffening(&self) -> f64 {
        self.settlement / (STIFF * self.height)
    }

    /// Damping that is half critical for the first swing, 1/s.
    pub fn damping(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.period
    }

    /// Speed below which damped soil rests, m/s: at `g/damping` it would slide without any strength.
    pub fn calm(&self) -> f64 {
        CALM * self.gravity / self.damping()
    }

    /// Displacements of E1, E2 and E3, m: what the soil may do elastically, and a share of its height beyond.
    pub fn events(&self) -> [f64; 3] {
        EVENTS.map(|share| self.elastic + share * self.height)
    }

    /// Depth from which on soil is deep, and that of the crest, m.
    pub fn depth(&self) -> f64 {
        DEEP * self.height
    }

    /// How near the toe water is at it, m.
    pub fn at_toe(&self) -> f64 {
        AT_TOE * self.height
    }

    /// Least outflow, m3 per m.
    pub fn drops(&self) -> f64 {
        DROPS * self.pores
    }

    fn fall(&self) -> f64 {
        (self.height / self.gravity).sqrt()
    }

    /// Speed below which soil without damping rests, m/s, and for how long, s.
    pub fn rest(&self) -> (f64, f64) {
        (REST.0 * (self.gravity * self.height).sqrt(), REST.1 * self.fall())
    }

    /// Time between two samples of soil that moves, s.
    pub fn look(&self) -> f64 {
        LOOK * self.fall()
    }

    /// A failure that goes on for longer is left to the next seepage, s.
    pub fn longest(&self) -> f64 {
        LONGEST * self.fall()
    }

    /// Shortest, first and longest time of seepage between two samples of the soil, s.
    pub fn seepage(&self) -> [f64; 3] {
        SEEPAGE.map(|share| share * self.crossing)
    }
}
