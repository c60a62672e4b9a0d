//! Mandel's problem: a block between two rigid plates without friction, drained at its sides, in plane strain.
//!
//! Assumptions: small strain, linear elastic skeleton, incompressible grains, Darcy's law, no inertia, no gravity; a
//! force 2 a q on the plates at t = 0, p = 0 at x = a and x = -a, no flow through the plates. Pressure and stress
//! depend on x and t alone. Planes of symmetry stand in for the left and lower half.
//!
//! With T = c t/a^2, r = (1 - nu)/(nu_u - nu), the roots A of `tan A = r A` and `w = exp(-A^2 T)/(A - sin A cos A)`:
//! `p = 2 p_0 sum w sin A (cos(A x/a) - cos A)`, p_0 = q B (1 + nu_u)/3,
//! `u_x = [q nu/2G - q nu_u/G sum w sin A cos A] x + q a/G sum w cos A sin(A x/a)`,
//! `u_y = [-q (1 - nu)/2G + q (1 - nu_u)/G sum w sin A cos A] y`,
//! `sigma_yy = -q - 2 q/r sum w sin A cos(A x/a) + 2 q sum w sin A cos A`.
//! Skempton's B = 1/(1 + n K/K_w), undrained nu_u = (3 nu + B (1 - 2 nu))/(3 - B (1 - 2 nu)), both 1 and 1/2 for water
//! that does not compress; c = (k/gamma_w)/(1/M + n/K_w).
//!
//! Sources: Mandel 1953, Geotechnique 3(7); Cheng & Detournay 1988, Int. J. Numer. Anal. Methods Geomech. 12(5);
//! Abousleiman, Cheng, Cui, Detournay & Roegiers 1996, Geotechnique 46(2).

use std::f64::consts::{FRAC_PI_2, PI};

use mpm_core::scene::{LoadOn, Scene, SolidSide, Start};

/// Roots kept: terms fall as exp(-(j pi)^2 T), to 1e-17 of the first at T = 1e-6.
const ROOTS: usize = 2000;
/// Terms that have decayed by more than this no longer count.
const SPENT: f64 = 1e-18;

/// A consolidating block.
#[derive(Debug, Clone, PartialEq)]
pub struct Mandel {
    /// Half width a, m.
    pub half_width: f64,
    /// Half height b, m.
    pub half_height: f64,
    /// Mean vertical stress q under the plate, Pa.
    pub load: f64,
    /// Shear modulus G, Pa.
    pub shear: f64,
    /// Drained Poisson's ratio nu.
    pub poisson: f64,
    /// Undrained Poisson's ratio nu_u.
    pub undrained_poisson: f64,
    /// Coefficient of consolidation c, m2/s.
    pub coefficient: f64,
    /// Pore pressure p_0 at t = 0+, everywhere, Pa.
    pub undrained: f64,
    roots: Vec<Root>,
}

/// A root A of `tan A = r A` with its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Root {
    a: f64,
    sin: f64,
    cos: f64,
}

impl Root {
    /// The root in (j pi, j pi + pi/2), as A = j pi + pi/2 - d with `A tan d = 1/r`.
    ///
    /// `A tan d` grows with d, from 0 to more than 1 > 1/r: there is one root, and halving finds it to the last
    /// digit of d, which the sine and cosine then keep however large A is.
    fn number(j: usize, r: f64) -> Self {
        let end = j as f64 * PI + FRAC_PI_2;
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (end - middle) * middle.tan() * r < 1.0 { low = middle } else { high = middle }
        }
        let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self { a: end - low, sin: sign * low.cos(), cos: sign * low.sin() }
    }
}

impl Mandel {
    /// The block of a scene, a quarter of it: half width and half height are its width and height. `None` unless the
    /// scene is Mandel's: a plate with a step load from rest, rollers at the left and the bottom, the right side free
    /// and alone drained.
    pub fn new(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let sides = [SolidSide::Roller, SolidSide::Free, SolidSide::Roller, SolidSide::Free];
        let drained = |wanted: [bool; 4]| scene.stages.iter().all(|stage| stage.drained == wanted);
        let step = load.on == LoadOn::Plate && load.ramp_time == 0.0 && scene.start == Start::Unloaded;
        if !step || scene.gravity.is_some() || scene.solid_sides != sides || !drained([false, true, false, false]) {
            return None;
        }
        let (nu, shear) = (scene.elastic.poisson_ratio, scene.elastic.shear_modulus());
        let bulk = scene.elastic.lame() + 2.0 / 3.0 * shear;
        let skempton = 1.0 / (1.0 + bulk / scene.pore_stiffness());
        let share = skempton * (1.0 - 2.0 * nu);
        let undrained_poisson = (3.0 * nu + share) / (3.0 - share);
        let ratio = (1.0 - nu) / (undrained_poisson - nu);
        // Of alpha p: what undrained water adds to the stiffness is alpha^2 Q.
        let alpha = scene.soil().alpha();
        Some(Self {
            half_width: scene.width,
            half_height: scene.height,
            load: load.pressure,
            shear,
            poisson: nu,
            undrained_poisson,
            coefficient: water.mobility() / scene.storage(),
            undrained: load.pressure * skempton / alpha * (1.0 + undrained_poisson) / 3.0,
            roots: (0..ROOTS).map(|j| Root::number(j, ratio)).collect(),
        })
    }

    /// T = c t/a^2. The series holds to round-off from T = 1e-6 on.
    pub fn time_factor(&self, time: f64) -> f64 {
        self.coefficient * time / (self.half_width * self.half_width)
    }

    /// Sum of a term over the roots, each weighted by w, at a time (s).
    fn sum(&self, time: f64, term: impl Fn(&Root) -> f64) -> f64 {
        let t = self.time_factor(time);
        let decays = self.roots.iter().map(|root| (root, (-root.a * root.a * t).exp()));
        let counts = decays.take_while(|(_, decay)| *decay > SPENT);
        counts.map(|(root, decay)| term(root) * decay / (root.a - root.sin * root.cos)).sum()
    }

    /// Pore pressure at a distance x from the middle (m) and a time (s), Pa.
    pub fn pressure(&self, x: f64, time: f64) -> f64 {
        let share = x / self.half_width;
        2.0 * self.undrained * self.sum(time, |root| root.sin * ((root.a * share).cos() - root.cos))
    }

    /// Displacement away from the middle at a distance x (m) and a time (s), m.
    pub fn displacement_x(&self, x: f64, time: f64) -> f64 {
        let share = x / self.half_width;
        let uniform = 0.5 * self.poisson - self.undrained_poisson * self.sum(time, |root| root.sin * root.cos);
        let bulge = self.sum(time, |root| root.cos * (root.a * share).sin());
        self.load / self.shear * (uniform * x + self.half_width * bulge)
    }

    /// Upward displacement of the plate at a time (s), m; negative under a load.
    pub fn displacement_y(&self, time: f64) -> f64 {
        let late = (1.0 - self.undrained_poisson) * self.sum(time, |root| root.sin * root.cos);
        self.load / self.shear * (late - 0.5 * (1.0 - self.poisson)) * self.half_height
    }

    /// Settlement of the plate at a time (s), m.
    pub fn settlement(&self, time: f64) -> f64 {
        -self.displacement_y(time)
    }

    /// Vertical total stress at a distance x from the middle (m) and a time (s), Pa, tension positive.
    pub fn vertical_stress(&self, x: f64, time: f64) -> f64 {
        let share = x / self.half_width;
        let inverse_ratio = (self.undrained_poisson - self.poisson) / (1.0 - self.poisson);
        let term = |root: &Root| root.sin * (root.cos - inverse_ratio * (root.a * share).cos());
        self.load * (2.0 * self.sum(time, term) - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    /// The block of the tables.
    fn block(compressible: bool) -> Mandel {
        let scene = crate::scenes::built_in("mandel").expect("the built-in scene");
        let scene = scene.edited(|scene| {
            if let (Some(water), false) = (&mut scene.water, compressible) {
                water.bulk_modulus = f64::INFINITY;
            }
        });
        let scene = scene.expect("a sound scene");
        Mandel::new(&scene).expect("Mandel's scene")
    }

    fn worst(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    const TABLES: [(bool, &str); 2] = [(true, "compressible"), (false, "incompressible")];

    /// Largest differences of pressure and stress over p_0 and of the displacements over the plate's first one, for
    /// every row: T = 1e-4 to 5.
    fn history(exact: &Mandel, name: &str) -> [f64; 4] {
        let table = Table::read(&format!("02_mandel_history_{name}.csv"));
        let columns = ["t_s", "p_centre_Pa", "ux_at_a_m", "uy_at_b_m", "syy_centre_Pa", "syy_side_Pa"];
        let rows = table.rows(columns);
        assert!(rows.len() > 200);
        let a = exact.half_width;
        let first = exact.load * (1.0 - exact.undrained_poisson) / (2.0 * exact.shear) * exact.half_height;
        let stress = rows
            .iter()
            .flat_map(|r| [(exact.vertical_stress(0.0, r[0]), r[4]), (exact.vertical_stress(a, r[0]), r[5])]);
        [
            worst(rows.iter().map(|r| (exact.pressure(0.0, r[0]), r[1]))) / exact.undrained,
            worst(rows.iter().map(|r| (exact.displacement_x(a, r[0]), r[2]))) / first,
            worst(rows.iter().map(|r| (exact.displacement_y(r[0]), r[3]))) / first,
            worst(stress) / exact.undrained,
        ]
    }

    #[test]
    fn histories_match_the_tables() {
        for (compressible, name) in TABLES {
            let errors = history(&block(compressible), name);
            println!("{name}: {errors:?}");
            assert!(errors.iter().all(|e| *e < 1e-12), "{name}: {errors:?}");
        }
    }

    #[test]
    fn profiles_match_the_tables() {
        // Every row: 101 places at eleven times from T = 1e-3 to 2.
        for (compressible, name) in TABLES {
            let exact = block(compressible);
            let table = Table::read(&format!("02_mandel_profiles_{name}.csv"));
            let rows = table.rows(["t_s", "x_m", "p_Pa", "ux_m", "syy_Pa"]);
            assert!(rows.len() > 1000);
            let scale = exact.load / exact.shear;
            let errors = [
                worst(rows.iter().map(|r| (exact.pressure(r[1], r[0]), r[2]))) / exact.undrained,
                worst(rows.iter().map(|r| (exact.displacement_x(r[1], r[0]), r[3]))) / scale,
                worst(rows.iter().map(|r| (exact.vertical_stress(r[1], r[0]), r[4]))) / exact.undrained,
            ];
            println!("{name}: {errors:?}");
            assert!(errors.iter().all(|e| *e < 1e-12), "{name}: {errors:?}");
        }
    }

    #[test]
    fn the_plate_carries_its_load_and_the_start_is_undrained() {
        let exact = block(true);
        // Simpson's rule over the half width; at T = 0.01 the layer at the side is resolved.
        for t in [0.01, 0.1, 1.0] {
            let (time, n) = (t / exact.coefficient, 400);
            let weight = |i: usize| if i == 0 || i == n { 1.0 } else { [2.0, 4.0][i % 2] };
            let stress = |i: usize| exact.vertical_stress(i as f64 / n as f64 * exact.half_width, time);
            let mean = (0..=n).map(|i| weight(i) * stress(i)).sum::<f64>() / (3 * n) as f64;
            assert!((mean / exact.load + 1.0).abs() < 1e-9, "T = {t}: {mean}");
        }
        let time = 1e-6 / exact.coefficient;
        // The pressure in the middle rises by a share of sqrt(T).
        let rise = exact.pressure(0.0, time) / exact.undrained - 1.0;
        assert!((0.0..1e-3).contains(&rise), "{rise}");
    }

    #[test]
    fn roots_solve_their_equation_for_any_soil() {
        for r in [1.34, 2.0, 3.5, 1e3, 1e6] {
            for j in [0, 1, 2, 10, 199, 200, 1999] {
                let root = Root::number(j, r);
                assert!((j as f64 * PI..=j as f64 * PI + FRAC_PI_2).contains(&root.a), "{r} {j}: {root:?}");
                // tan A = r A, and the sine and cosine are those of A as far as A has digits.
                assert!((root.sin - r * root.a * root.cos).abs() < 1e-14, "{r} {j}: {root:?}");
                let apart = (root.a.sin() - root.sin).abs() + (root.a.cos() - root.cos).abs();
                assert!(apart < 1e-15 * (2.0 + root.a), "{r} {j}: {root:?} {apart}");
            }
        }
    }

    #[test]
    fn other_scenes_are_not_mandels() {
        assert_eq!(Mandel::new(&crate::scenes::terzaghi()), None);
        let scene = crate::scenes::built_in("mandel")
            .expect("the built-in scene")
            .edited(|scene| scene.stages[0].drained[3] = true)
            .expect("a sound scene");
        assert_eq!(Mandel::new(&scene), None);
    }

    #[test]
    fn the_check_can_fail() {
        let mut wrong = block(true);
        wrong.coefficient *= 1.0 + 1e-9;
        assert!(history(&wrong, "compressible").iter().all(|e| *e > 1e-12));
    }
}
