//! The largest stable time steps: von Neumann analysis with lumped masses. First the explicit scheme.
//!
//! One step of a plane wave with squared gradient symbol `K_u` (solid) and `K_p` (pressure Laplacian) has an
//! eigenvalue -1, the first to leave the unit circle, when
//!
//! `(2 rho - c M K_u dt^2) (2 - D_p K_p dt) = 2 K_u dt (c Q dt - chi rho_w D_p)`
//!
//! with Q = K_w/n, D_p = k Q/gamma_w, and chi = 1 if Darcy's law keeps `rho_w a_s`. `c` comes from the transfer:
//! particles give back only the part S of an acceleration (S = M_lumped^-1 M_consistent, the mass matrices that
//! the particles make), so the velocity that strains the mesh is `W + dt a` while `W` grows by `S dt a` alone:
//! `c = 1 - S/(1 + flip + (1 - flip) S)`. A mesh without particles has S = 1, c = 1/2; with K_u = K_p = 4/L^2 and
//! chi = 0 that is `(1 - dt^2 M/(rho L^2)) (1 - 2 dt D_p/L^2) = dt^2 Q/(rho L^2)`. One particle per cell has S = 0
//! for the shortest wave: its Courant limit is lower by the square root of two.
//!
//! Affine velocities give a node the share 1 - S that the transfer left out, and soil that is strained by velocities mapped
//! back is strained by as much as it moves: both make c smaller (1/2, and S/2). The limit of the step without them holds.
//!
//! The semi-implicit scheme takes the pressure of the end of the step, and an eigenvalue -1 needs
//! `rho = c K_u dt^2 (M/2 - Q/(2 + D_p K_p dt))`: the water only helps. But it helps against changes of volume of whole
//! cells alone. Shear waves, and strains that vary over a cell about a mean of zero, have the limit of the dry skeleton.
//!
//! With `rho_w a_s` of the step before in Darcy's law it has a further limit. In soil that lets its water through, the
//! pressure is what that inertia asks for: a force `rho_w a_s`, a step late. A force that is late by dt feeds a wave with
//! `omega^2 dt/2` per second while the drag of the water, `gamma_w/k`, takes a share that does not depend on dt. So waves
//! grow, slowly and with an eigenvalue far from -1, above a step that falls with k: [`Medium::lagged_inertia_column`].

use crate::scene::{
    DarcyChoice, Dimension, Fields, Integrator, PAPER_STEP, ShapeChoice, SolidSide, StepChoice, THROUGH_CELLS,
};

/// What the limit depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Oedometer modulus M, Pa.
    pub modulus: f64,
    /// Density of the mixture, kg/m3.
    pub density: f64,
    /// Q = K_w/n, Pa; zero without water.
    pub pore_stiffness: f64,
    /// k/gamma_w, m4/(N s); zero without water.
    pub mobility: f64,
    /// D_p = k Q/gamma_w, m2/s; zero without water.
    pub diffusivity: f64,
    /// chi rho_w, kg/m3: the water density where Darcy's law keeps inertia, else zero.
    pub flow_inertia: f64,
    /// Edge of a cell L, m.
    pub cell: f64,
    /// S of the shortest wave along one axis: 1 for a mesh without particles.
    pub shortest_transfer: f64,
    /// FLIP share of the velocity update.
    pub flip: f64,
}

/// S of the shortest wave for evenly spaced particles: 0 for one per direction, 1/4 for two, 1/3 for many.
///
/// With N = (1 - xi, xi) the lumped mass is `sum N` and the consistent one `sum N N^t`; for a wave that changes its
/// sign from node to node `S = sum (1 - 2 xi)^2 / count`.
pub fn shortest_transfer(per_direction: usize) -> f64 {
    let count = per_direction as f64;
    (0..per_direction).map(|i| (1.0 - 2.0 * (i as f64 + 0.5) / count).powi(2)).sum::<f64>() / count
}

impl Medium {
    /// The medium of a scene.
    pub fn of(scene: &Fields) -> Self {
        let (pore_stiffness, alpha) = (scene.pore_stiffness(), scene.soil().alpha());
        let mobility = scene.water.map_or(0.0, |w| w.largest_mobility());
        let with_inertia = scene.darcy_inertia && !flow_passes_held_soil(scene) && !scene.moves_through_cells();
        let flow_inertia = scene.water.filter(|_| with_inertia).map_or(0.0, |w| w.density);
        Self {
            modulus: scene.oedometer_modulus(),
            density: scene.mixture_density(),
            pore_stiffness,
            // Of alpha p, which pushes the skeleton as p does where grains do not compress.
            mobility: mobility / alpha.powi(2),
            diffusivity: mobility * pore_stiffness / alpha.powi(2),
            flow_inertia: alpha * flow_inertia,
            cell: scene.cell,
            shortest_transfer: shortest_transfer(scene.particles_per_direction()),
            flip: scene.flip,
        }
    }

    /// One direction's S for a wave with `sin^2(theta/2) = s`.
    fn transfer(&self, s: f64) -> f64 {
        1.0 - (1.0 - self.shortest_transfer) * s
    }

    /// `c` for a transfer S.
    fn memory(&self, transfer: f64) -> f64 {
        1.0 - transfer / (1.0 + self.flip + (1.0 - self.flip) * transfer)
    }

    /// The cubic above; positive at dt = 0, the limit is its first root.
    fn residual(&self, dt: f64, k_u: f64, k_p: f64, c: f64) -> f64 {
        (2.0 * self.density - c * self.modulus * k_u * dt * dt) * (2.0 - self.diffusivity * k_p * dt)
            - 2.0 * k_u * dt * (c * self.pore_stiffness * dt - self.flow_inertia * self.diffusivity)
    }

    /// Smallest positive root of the cubic for one wave, s.
    fn limit_of(&self, k_u: f64, k_p: f64, c: f64) -> f64 {
        // At the drained Courant limit the first factor vanishes; a pure pressure wave ends at 2/(D_p K_p).
        let far = if k_u > 0.0 {
            (2.0 * self.density / (c * self.modulus * k_u)).sqrt()
        } else {
            2.0 / (self.diffusivity * k_p)
        };
        // Limits range over decades below that: scan geometrically for the first change of sign, then bisect.
        let (steps, first) = (2000, far * 1e-6);
        let ratio = (far * 1.001 / first).powf(1.0 / f64::from(steps));
        let (mut low, mut high) = (0.0, first);
        for _ in 0..=steps {
            if self.residual(high, k_u, k_p, c) < 0.0 {
                break;
            }
            low = high;
            high *= ratio;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.residual(middle, k_u, k_p, c) < 0.0 { high = middle } else { low = middle }
        }
        low
    }

    /// Largest semi-implicit step for one wave, s: with the pressure of the end of the step in the equation of motion
    /// an eigenvalue -1 needs `rho = c K_u dt^2 (M/2 - Q/(2 + D_p K_p dt))`.
    fn semi_implicit_of(&self, k_u: f64, k_p: f64, c: f64) -> f64 {
        let beyond = |dt: f64| {
            let relief = if self.pore_stiffness > 0.0 {
                1.0 / (2.0 / self.pore_stiffness + self.mobility * k_p * dt)
            } else {
                0.0
            };
            c * k_u * dt * dt * (0.5 * self.modulus - relief) - self.density
        };
        // The left side grows from the drained Courant limit on: double, then bisect.
        let mut low = (2.0 * self.density / (c * self.modulus * k_u)).sqrt();
        let mut high = low;
        while beyond(high) < 0.0 {
            (low, high) = (high, 2.0 * high);
            if high > 1e30 {
                return f64::INFINITY;
            }
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if beyond(middle) < 0.0 { low = middle } else { high = middle }
        }
        low
    }

    /// Whether a semi-implicit step with the inertia of the step before lets a wave of `[K_u, K_p, S]` grow.
    ///
    /// With z the eigenvalue, `a = (f + P)/rho` the acceleration, f and P the forces of skeleton and water, and r = flip +
    /// (1 - flip) S what a velocity keeps of itself, the step is `w = dt a (z - r + S)/(z - r)`, `(z - 1) f = -dt M K_u w`
    /// and `P [(1 - 1/z)/Q + dt k/gamma_w K_p] = -dt K_u (w - k/gamma_w chi rho_w a/z)`. Without w, f and P that is a
    /// cubic in s = z - 1. Its roots lie in the unit circle of z if, as a cubic in y with s = 2y/(1 - y), it meets the
    /// conditions of Routh and Hurwitz.
    fn inertia_grows(&self, dt: f64, [k_u, k_p, transfer]: [f64; 3]) -> bool {
        let rho = self.density;
        let lost = (1.0 - self.flip) * (1.0 - transfer); // 1 - r
        let gain = lost + transfer;
        let flow = dt * self.mobility * k_p;
        let held = 1.0 / self.pore_stiffness + flow;
        let (skeleton, water) = (dt * dt * self.modulus * k_u, dt * dt * k_u);
        let late = dt * self.mobility * k_u * self.flow_inertia;
        let a0 = skeleton * gain * flow;
        let a1 = rho * lost * flow + skeleton * (flow + held * gain) + water * gain - late * lost;
        let a2 = rho * (flow + held * lost) + skeleton * held + water * (1.0 + gain) - late;
        let a3 = rho * held + water;
        let (b1, b2) = (2.0 * a1 - 3.0 * a0, 4.0 * a2 - 4.0 * a1 + 3.0 * a0);
        let b3 = 8.0 * a3 - 4.0 * a2 + 2.0 * a1 - a0;
        !(b1 > 0.0 && b2 > 0.0 && b3 > 0.0 && b1 * b2 > b3 * a0)
    }

    /// Smallest semi-implicit step (s) below `limit` (s) from which a wave of `[K_u, K_p, S]` grows by its late inertia, or
    /// the limit.
    fn lagged_inertia_of(&self, limit: f64, wave: [f64; 3]) -> f64 {
        if self.flow_inertia == 0.0 || self.pore_stiffness == 0.0 || !limit.is_finite() {
            return limit;
        }
        let (steps, decades) = (300, 12.0);
        let step = 10.0_f64.powf(decades / f64::from(steps));
        let mut low = limit * 10.0_f64.powf(-decades);
        let Some(mut high) = (0..=steps).find_map(|_| {
            let high = low * step;
            let grows = self.inertia_grows(high, wave);
            low = if grows { low } else { high };
            grows.then_some(high)
        }) else {
            return limit;
        };
        for _ in 0..50 {
            let middle = (low * high).sqrt();
            if self.inertia_grows(middle, wave) { high = middle } else { low = middle }
        }
        low.min(limit)
    }

    /// The part of a semi-implicit `limit` (s) in one dimension that inertia of the step before in Darcy's law leaves, s.
    pub fn lagged_inertia_column(&self, limit: f64) -> f64 {
        let scale = 4.0 / (self.cell * self.cell);
        (1..=WAVES)
            .map(wave)
            .fold(limit, |limit, s| self.lagged_inertia_of(limit, [scale * s, scale * s, self.transfer(s)]))
    }

    /// The same in plane strain, over plane waves of all directions and lengths.
    pub fn lagged_inertia_plane_strain(&self, limit: f64) -> f64 {
        let scale = 4.0 / (self.cell * self.cell);
        let all = (1..=WAVES).flat_map(|i| (0..=i).map(move |j| (wave(i), wave(j))));
        all.fold(limit, |limit, (sx, sy)| {
            let k_u = sx * (1.0 - sy) + sy * (1.0 - sx);
            let symbols = [scale * k_u, scale * (sx + sy), self.transfer(sx) * self.transfer(sy)];
            if k_u > 1e-9 { self.lagged_inertia_of(limit, symbols) } else { limit }
        })
    }

    /// Largest explicit step of quadratic B-splines with one particle per cell, s: `limit_column` at the stiffest wave of
    /// a free end with c = 1, and the Laplacian of an endless mesh.
    ///
    /// A cell's one particle feels all of its strain, so that the water is as stiff there as the skeleton: the end is
    /// that of `dry_splines` with M + Q. With more particles a pressure per cell feels a mean and is softer.
    pub fn lone_splines(&self, dimension: Dimension) -> f64 {
        let (scale, axes) = (1.0 / (self.cell * self.cell), if dimension == Dimension::Column { 1.0 } else { 2.0 });
        self.limit_of(axes * LONE_SPLINE * scale, axes * 4.0 * scale, 1.0)
    }

    /// Largest semi-implicit step that round-off leaves sound, s.
    ///
    /// Before its pressure is known a node moves as if there was none, by `dt F/m`; pressures take nearly all of that back,
    /// but for the last digit. In soil that hardly drains steps may be so long that the digit counts: the strain that is
    /// left is `eps M K_u dt^2/rho` of what the load would cause drained. Measured with steps of 1e7/omega: no run.
    pub fn round_off(&self) -> f64 {
        let frequency = 2.0 * (self.modulus / self.density).sqrt() / self.cell;
        (SOUND / f64::EPSILON).sqrt() / frequency
    }

    /// Largest stable semi-implicit step in one dimension, s.
    pub fn semi_implicit_column(&self) -> f64 {
        let scale = 4.0 / (self.cell * self.cell);
        let limit = |s: f64| self.semi_implicit_of(scale * s, scale * s, self.memory(self.transfer(s)));
        (1..=WAVES).map(|i| limit(wave(i))).fold(f64::INFINITY, f64::min)
    }

    /// Plane waves of all directions and lengths: squared gradient symbols of solid and pressure (1/m2), and c.
    ///
    /// The solid and the nodal Darcy operator see the gradient at the cell centre; the two-point flux sees the
    /// sum over the axes, up to twice as much for a checkerboard, which has no gradient at the centre at all.
    fn plane_waves(&self, darcy: DarcyChoice) -> impl Iterator<Item = [f64; 3]> {
        let scale = 4.0 / (self.cell * self.cell);
        (0..=WAVES).flat_map(move |i| {
            (0..=i).map(move |j| {
                let (sx, sy) = (wave(i), wave(j));
                let k_u = sx * (1.0 - sy) + sy * (1.0 - sx);
                let k_p = match darcy {
                    DarcyChoice::Nodal => k_u,
                    DarcyChoice::Face => sx + sy,
                };
                let k_u = if k_u > 1e-9 { scale * k_u } else { 0.0 };
                [k_u, scale * k_p, self.memory(self.transfer(sx) * self.transfer(sy))]
            })
        })
    }

    /// Largest stable semi-implicit step in plane strain, s.
    pub fn semi_implicit_plane_strain(&self, darcy: DarcyChoice) -> f64 {
        let moving = self.plane_waves(darcy).filter(|[k_u, ..]| *k_u > 0.0);
        moving.map(|[k_u, k_p, c]| self.semi_implicit_of(k_u, k_p, c)).fold(f64::INFINITY, f64::min)
    }

    /// Largest step for waves of shear in plane strain, s. They do not change volumes, so that an implicit pressure
    /// does not help: `rho = c K_u dt^2 G/2` with the shear modulus G (Pa).
    pub fn shear_waves(&self, shear: f64) -> f64 {
        let sheared = Self { modulus: shear, pore_stiffness: 0.0, diffusivity: 0.0, ..*self };
        sheared.semi_implicit_plane_strain(DarcyChoice::Nodal)
    }

    /// Largest step for the deformations of a bilinear cell that keep its volume, s.
    ///
    /// No eigenvalue of a mesh is larger than the largest one of its cells (Fried 1972, *SIAM J. Numer. Anal.* 9). With a
    /// quarter of the mass at each corner those are `8 G/(rho L^2)` for shear, and `4 S (M + G)/(rho L^2)` for the two
    /// hourglasses, whose strain varies over the cell about a mean of zero. c = 1 is safe for both.
    pub fn linear_element(&self, shear: f64) -> f64 {
        let hourglass = 4.0 * self.shortest_transfer * (self.modulus + shear);
        self.cell * (2.0 * self.density / f64::max(8.0 * shear, hourglass)).sqrt()
    }

    /// Largest step of quadratic B-splines without any help of the water, s: `omega dt = sqrt(2)` with c = 1.
    ///
    /// A pressure per cell does not see a strain that varies over the cell about a mean of zero, and B-splines have such
    /// a field on every mesh, so an implicit pressure does not raise the limit as it does for linear functions.
    /// In plane strain the energy is at most M |grad v|^2: both axes add.
    pub fn dry_splines(&self, dimension: Dimension) -> f64 {
        let axes = if dimension == Dimension::Column { 1.0 } else { 2.0 };
        self.cell * (2.0 * self.density / (axes * STIFFEST_SPLINE * self.modulus)).sqrt()
    }

    /// Largest stable step in one dimension, s, over all wave lengths.
    pub fn limit_column(&self) -> f64 {
        let scale = 4.0 / (self.cell * self.cell);
        let limit = |s: f64| self.limit_of(scale * s, scale * s, self.memory(self.transfer(s)));
        (1..=WAVES).map(|i| limit(wave(i))).fold(f64::INFINITY, f64::min)
    }

    /// The part of an explicit `limit` (s) in plane strain that a drained edge leaves, s: a wave along it strains cells by
    /// `K_u = 4/L^2`, while their water flows to both neighbours and out, `K_p = (4 + 3)/L^2`. No plane wave has both.
    pub fn drained_edge(&self, limit: f64) -> f64 {
        let scale = 1.0 / (self.cell * self.cell);
        limit.min(self.limit_of(4.0 * scale, 7.0 * scale, self.memory(self.transfer(1.0))))
    }

    /// Largest stable step in plane strain, s, over all directions and lengths of a plane wave.
    pub fn limit_plane_strain(&self, darcy: DarcyChoice) -> f64 {
        let scale = 4.0 / (self.cell * self.cell);
        let felt = |k_u: f64, k_p: f64| k_u > 0.0 || k_p / scale * self.diffusivity > 1e-9;
        let waves = self.plane_waves(darcy).filter(|[k_u, k_p, _]| felt(*k_u, *k_p));
        waves.map(|[k_u, k_p, c]| self.limit_of(k_u, k_p, c)).fold(f64::INFINITY, f64::min)
    }
}

/// Largest eigenvalue of `M_lumped^-1 K` of quadratic B-splines on open knots, over M/(rho L^2): that of a free end. With
/// one particle per cell it is 4.63, with 4, 9 and 16 in plane strain 5.12, 5.26 and 5.31, with very many 5.38; inside
/// the mesh it is 1.5.
const STIFFEST_SPLINE: f64 = 5.4;

/// The same with one particle per cell.
const LONE_SPLINE: f64 = 4.64;

/// What cells that are filled in part leave of the square of a step.
///
/// A node with a quarter of the mass of the one particle in its cell makes `4/3` of the usual omega^2. A drained cell three
/// quarters full has the flow of (1 + 2)/0.75 = 4 neighbours, but beside full cells a mode of its own: with `p_j = z^j` it is
/// `(3 - z)/0.75 = 2 - z - 1/z`, z = -0.464, 4.62 in place of 4, which is `4/sqrt(3/4)`.
const PARTLY_FILLED: f64 = 0.75;

/// The usual share of the limit: a surface that takes no more than that is left to it.
const MOST_SAFETY: f64 = 0.9;

/// Round-off that a semi-implicit step may leave, of the drained strain.
const SOUND: f64 = 1e-7;

/// Wave lengths considered along each axis.
const WAVES: u32 = 16;

/// `sin^2(theta/2)` of a wave, theta from 0 (i = 0) to pi.
fn wave(i: u32) -> f64 {
    (f64::from(i) / f64::from(WAVES) * std::f64::consts::FRAC_PI_2).sin().powi(2)
}

/// Whether water can flow along a direction in which nodes of the soil are fixed.
///
/// There a_s = 0 whatever the pressure, so `rho_w a_s` cannot relieve Darcy's law and the lower limit holds: at a
/// drained side on rollers, and along a fixed side in plane strain.
fn flow_passes_held_soil(scene: &Fields) -> bool {
    let held = |i: usize| scene.supports().any(|sides| sides[i] != SolidSide::Free);
    let drained = |i: usize| scene.stages.iter().any(|stage| stage.drained[i]);
    let along = scene.dimension != Dimension::Column && scene.supports().any(|sides| sides.contains(&SolidSide::Fixed));
    along || (0..4).any(|i| held(i) && drained(i))
}

/// Largest stable explicit step of a scene, s.
///
/// uGIMP has the limit of the linear functions: their gradients are averages of the linear ones. Measured in columns
/// (L = 0.1 and 0.02, 1, 4 and 9 particles per cell) runs hold up to 1.001 to 1.007 times that. B-splines are softer
/// but at a free end, and are held to the limit without inertia in Darcy's law (they run up to 1.010 to 1.177 times it
/// with inertia): the lumped mass of their last coefficient is smaller than that which the relief counts on.
pub fn explicit_limit(scene: &Fields) -> f64 {
    if !scene.moves_through_cells() {
        return worst_soil(scene, explicit_limit_of);
    }
    worst_soil(scene, |soil| {
        // Water is stiffer, K_w/n, in the pores that a load leaves; soil is denser, and if much denser its limit is lowest at first.
        let left = soil.estimate().porosity;
        let porosity = if left > 0.0 { left } else { soil.porosity };
        let compressed = PARTLY_FILLED.sqrt() * explicit_limit_of(&Fields { porosity, ..soil.clone() });
        let much = PARTLY_FILLED * (1.0 - porosity) > 1.0 - soil.porosity;
        if much { compressed.min(explicit_limit_of(soil)) } else { compressed }
    })
}

fn explicit_limit_of(scene: &Fields) -> f64 {
    let medium = Medium::of(scene);
    if scene.shape == ShapeChoice::Bspline2 {
        let medium = Medium { flow_inertia: 0.0, ..medium };
        let limit = match scene.dimension {
            Dimension::Column => medium.limit_column(),
            _ => medium.limit_plane_strain(scene.darcy),
        };
        let limit = limit.min(medium.dry_splines(scene.dimension));
        let alone = scene.particles_per_direction() == 1 && scene.water.is_some();
        return if alone { limit.min(medium.lone_splines(scene.dimension)) } else { limit };
    }
    match scene.dimension {
        Dimension::Column => medium.limit_column(),
        _ => {
            let limit = medium.limit_plane_strain(scene.darcy);
            let drains = scene.stages.iter().any(|stage| stage.drained.contains(&true));
            if drains && scene.darcy == DarcyChoice::Face { medium.drained_edge(limit) } else { limit }
        }
    }
}

/// Largest stable semi-implicit step of a scene, s.
///
/// `rho_w a_s` in Darcy's law is that of the step before. It raises the step at which an eigenvalue is -1, which is not
/// counted on, and makes waves grow slowly above a step of its own. B-splines are softer inside the mesh than linear
/// functions and held to the same.
pub fn semi_implicit_limit(scene: &Fields) -> f64 {
    worst_soil(scene, |soil| semi_implicit_limit_of(soil).min(Medium::of(soil).round_off()))
}

/// [`stable_limit`] without what round-off takes: that of exact numbers, s.
pub fn limit_of_exact_numbers(scene: &Fields) -> f64 {
    match scene.integrator {
        Integrator::SemiImplicit => worst_soil(scene, semi_implicit_limit_of),
        _ => stable_limit(scene),
    }
}

fn semi_implicit_limit_of(scene: &Fields) -> f64 {
    let medium = Medium { flow_inertia: 0.0, ..Medium::of(scene) };
    let mut limit = semi_implicit_without_inertia(scene, &medium);
    if scene.moves_through_cells() {
        // A cell that is filled in part has less water to lean on.
        let drained = Medium { pore_stiffness: 0.0, diffusivity: 0.0, ..medium };
        limit = limit.min(PARTLY_FILLED.sqrt() * semi_implicit_without_inertia(scene, &drained));
    }
    limit *= (left_by_surface(scene) / MOST_SAFETY).min(1.0);
    // Inertia is in the flow between cells even where the soil at a drained side is fixed.
    let flow_inertia = scene.water.filter(|_| scene.darcy_inertia).map_or(0.0, |w| w.density);
    let medium = Medium { flow_inertia, ..medium };
    match scene.dimension {
        Dimension::Column => medium.lagged_inertia_column(limit),
        _ => medium.lagged_inertia_plane_strain(limit),
    }
}

/// What a surface that comes down within its cell leaves of a semi-implicit step. The step is as long as the water makes the soil
/// stiff enough by its flow, `Q_dt = C^2/(H dt)` beside M: a cell of which a part f is soil has `f^2/(2/f + 2/(1 + f))` of the one
/// and f of the other.
fn left_by_surface(scene: &Fields) -> f64 {
    let f = 1.0 - (scene.estimate().settlement_m / scene.cell).clamp(0.0, THROUGH_CELLS);
    3.0 * f * f * (1.0 + f) / (2.0 + 4.0 * f)
}

/// The same of a medium with Darcy's law free of inertia.
fn semi_implicit_without_inertia(scene: &Fields, medium: &Medium) -> f64 {
    let shear = scene.elastic.shear_modulus();
    match (scene.shape, scene.dimension) {
        (ShapeChoice::Bspline2, dimension) => medium.dry_splines(dimension),
        (_, Dimension::Column) => medium.semi_implicit_column(),
        (ShapeChoice::Centre, _) => medium.semi_implicit_plane_strain(scene.darcy).min(medium.shear_waves(shear)),
        _ => medium.semi_implicit_plane_strain(scene.darcy).min(medium.linear_element(shear)),
    }
}

/// The smallest limit of the soils of a scene, each as if it were all there is.
///
/// No eigenvalue of a mesh is larger than the largest one of its cells, and the flow between two cells of different
/// conductivity, the harmonic mean, is at most that between two of the better one.
fn worst_soil(scene: &Fields, limit: impl Fn(&Fields) -> f64) -> f64 {
    // Radial waves about an axis: the largest eigenvalue of the lumped mesh is up to 1.0025 times that in plane strain.
    scene.axis().map_or(1.0, |_| 0.998) * scene.by_soil().iter().map(|scene| limit(scene)).fold(f64::INFINITY, f64::min)
}

/// Largest stable step of a scene with its own integrator, s; infinite where there is none.
pub fn stable_limit(scene: &Fields) -> f64 {
    match scene.integrator {
        Integrator::Explicit => explicit_limit(scene),
        Integrator::SemiImplicit => semi_implicit_limit(scene),
        Integrator::QuasiStatic | Integrator::Implicit => f64::INFINITY,
        // The water keeps its pressures while the soil moves: the skeleton is alone, and lightest where it is dry.
        Integrator::Staggered | Integrator::Coupled => {
            worst_soil(&Fields { water: None, ..scene.clone() }, explicit_limit_of)
        }
    }
}

/// A step above the limit was asked for.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "time.step: expected at most {limit:.6e} s, the stability limit of this scene, found {step:.6e} s; --force runs it anyway"
)]
pub struct StepTooLarge {
    /// Step asked for, s.
    pub step: f64,
    /// Limit, s.
    pub limit: f64,
}

/// The time step that a scene with a limit (s) asks for, s, stable or not.
pub fn intended_step(scene: &Fields, limit: f64) -> f64 {
    match scene.step {
        StepChoice::Auto => scene.safety * limit,
        StepChoice::Fixed(step) => step,
        StepChoice::Paper => PAPER_STEP,
    }
}

/// The time step of a scene, s; infinite for integrators that divide the time themselves.
///
/// # Errors
/// A fixed step above the limit, unless the scene is forced.
pub fn choose_step(scene: &Fields) -> Result<f64, StepTooLarge> {
    let limit = stable_limit(scene);
    if scene.integrator.solves_displacements() {
        return Ok(limit);
    }
    let step = intended_step(scene, limit);
    if step > limit && !scene.force { Err(StepTooLarge { step, limit }) } else { Ok(step) }
}
