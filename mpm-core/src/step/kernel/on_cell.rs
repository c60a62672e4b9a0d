//! Functions of one cell: linear ones, with gradients at the particles, at the centre of the cell, at the centroid of its soil, or
//! selectively at both. Mass, momentum and velocity always use N_i at the particle. A field is held by its coefficients in
//! (1, xi, eta, xi eta).

use pulp::Simd;

use super::{Closing, Contribution, Fields, FromAxis, Functions, Given, MOST_REACHED, Moves, radius};
use crate::dimension::{
    PRESSURE, basis, coefficients, gradient, internal_force, mean_stress, shares, to_corners, trace, value,
};
use crate::real::{Real, SimdReal, array};
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, force};

/// A vector field in a cell, as coefficients.
pub type Field<V, const D: usize> = [[SimdReal<V>; D]; 4];

/// Motion in a cell.
#[derive(Clone, Copy)]
pub struct CellMotion<V: Simd, const D: usize> {
    /// What strains the soil.
    strains: Field<V, D>,
    velocity: Field<V, D>,
    change: Field<V, D>,
    /// Where all particles have their strain, unless each has its own.
    at: [SimdReal<V>; D],
}

/// What the particles of a cell give.
#[derive(Clone, Copy)]
pub struct CellSums<V: Simd, const D: usize> {
    solid_mass: [SimdReal<V>; 4],
    momentum: Field<V, D>,
    mean: [SimdReal<V>; 4],
    first: [[SimdReal<V>; 4]; D],
    water_mass: [SimdReal<V>; 4],
    /// First moments of the volume of the soil.
    moment: [SimdReal<V>; D],
    /// Moments of V p.
    weighted: [[SimdReal<V>; 1]; 4],
    /// Volume of the water.
    of_water: SimdReal<V>,
    /// About an axis: hoop stress over the radius, the same of water, and one over the radius, times volumes, N.
    hoop: [SimdReal<V>; 4],
    hoop_of_water: [SimdReal<V>; 4],
    hoop_of_one: [SimdReal<V>; 4],
    /// Mean stress times volumes, where it acts at the centroid.
    spherical: SimdReal<V>,
}

/// Linear functions with gradients at the particles, at one place of the cell, or selectively at both.
#[derive(Debug, Clone, Copy)]
pub struct OnCell<const PLACE: u8> {
    /// Whether the place of the cell is the centroid of its soil, not its centre.
    at_centroid: bool,
}

/// Gradients at the centre of the cell (the paper, section 2.2): G_i(x_p) is replaced by G_i(x_c).
pub const CENTRE: OnCell<AT_CELL> = OnCell { at_centroid: false };
/// Gradients at the centroid of the soil in the cell: the same where a cell is full. Along a slope, where cells are filled in
/// part, they are then those of the soil that is there, and the force of a uniform stress on it is exact.
pub const CENTROID: OnCell<AT_CELL> = OnCell { at_centroid: true };
/// The standard linear scheme: G_i at the particle.
pub const LINEAR: OnCell<AT_PARTICLE> = OnCell { at_centroid: false };
/// Selective integration, B-bar (Hughes 1980, doi:10.1002/nme.1620150914): the mean stress and the change of volume at the
/// centre of the cell, the rest at the particle. `sigma : grad N_i` becomes `s : G_i(x_p) + sigma_m div N_i(x_c)`.
///
/// Cells keep their volume without locking, as at the centre alone, and their hourglass modes, which the centre does not
/// see, are held by the shear of the particles. Fields that are linear over the mesh are the same at all four.
pub const B_BAR: OnCell<AT_BOTH> = OnCell { at_centroid: false };

const AT_CELL: u8 = 0;
const AT_PARTICLE: u8 = 1;
const AT_BOTH: u8 = 2;

/// A field at the nodes, as coefficients.
#[inline(always)]
fn in_cell<V: Simd, const D: usize>(fields: &Fields<V, D>, field: &[Vec<f64>; 2]) -> Field<V, D> {
    let mut nodal = [[SimdReal::splat(fields.simd, 0.0); D]; 4];
    for d in 0..D {
        let corners = fields.corners(&field[d]);
        for a in 0..1 << D {
            nodal[a][d] = corners[a];
        }
    }
    coefficients::<D, D, _>(&nodal)
}

/// The centre of a cell.
#[inline(always)]
fn centre<V: Simd, const D: usize>(like: [SimdReal<V>; D]) -> [SimdReal<V>; D] {
    [like[0].like(0.5); D]
}

/// Adds an amount at a place to the corners.
#[inline(always)]
fn add_shares<V: Simd, const D: usize>(sums: &mut [SimdReal<V>; 4], amount: SimdReal<V>, xi: &[SimdReal<V>; D]) {
    let share = shares(amount, xi);
    for a in 0..1 << D {
        sums[a] += share[a];
    }
}

impl<const PLACE: u8> OnCell<PLACE> {
    /// Radial forces of the hoop stress and of the pressure on the corners of cells about an axis, N, inwards.
    #[inline(always)]
    fn hoop_force<V: Simd, const D: usize>(
        &self,
        sums: &CellSums<V, D>,
        cell: &Closing<V, D>,
        from: SimdReal<V>,
        inverse_size: f64,
    ) -> [SimdReal<V>; 4] {
        let (mut force, at) = (sums.hoop, centre(cell.at));
        for a in 0..1 << D {
            force[a] = force[a] * cell.share;
        }
        if <Self as Functions<D>>::OF_CELL {
            // The mean has the pressure in it.
            return shares(sums.mean[2] / (from + at[0]) * inverse_size, &at);
        }
        let Some(pressure) = cell.pressure else { return force };
        if <Self as Functions<D>>::PRESSURE_AT_PARTICLES && !cell.of_cell {
            let share = cell.filled / cell.full_of_water * inverse_size;
            for a in 0..1 << D {
                force[a] -= sums.hoop_of_water[a] * share;
            }
        } else {
            add_shares(&mut force, -pressure * cell.filled / (from + at[0]) * inverse_size, &at);
        }
        force
    }
}

impl<const PLACE: u8, const D: usize> Functions<D> for OnCell<PLACE> {
    const REACH: usize = 2;
    const BEFORE: usize = 0;
    const EXTRA: usize = 1;
    const FUSED: bool = true;
    const SPLIT: bool = PLACE == AT_BOTH;
    const OF_CELL: bool = PLACE == AT_CELL;
    const PRESSURE_AT_PARTICLES: bool = PLACE == AT_PARTICLE;
    const NODAL: bool = true;
    type Edges<V: Simd> = ();
    type Motion<V: Simd> = CellMotion<V, D>;
    type Water<V: Simd> = Field<V, D>;
    type Sums<V: Simd> = CellSums<V, D>;

    #[inline(always)]
    fn at_centroid(&self) -> bool {
        PLACE == AT_CELL && self.at_centroid
    }

    #[inline(always)]
    fn edges<V: Simd>(&self, _: &[SimdReal<V>; D], _: &[usize; D]) {}

    #[inline(always)]
    fn at_rest<V: Simd>(&self, simd: V) -> CellMotion<V, D> {
        let none = [[SimdReal::splat(simd, 0.0); D]; 4];
        CellMotion { strains: none, velocity: none, change: none, at: none[0] }
    }

    #[inline(always)]
    fn find_motion<V: Simd>(
        &self,
        motion: &mut CellMotion<V, D>,
        fields: &Fields<V, D>,
        (): &(),
        centroid: &[SimdReal<V>; D],
    ) {
        let velocity = in_cell(fields, fields.velocity);
        let strains = match fields.mapped {
            Some(mapped) => in_cell(fields, mapped),
            None => velocity,
        };
        let is_found = <Self as Functions<D>>::at_centroid(self) || fields.found;
        let at = if is_found { *centroid } else { centre(velocity[0]) };
        *motion = CellMotion { strains, velocity, change: in_cell(fields, fields.change), at };
    }

    #[inline(always)]
    fn middle<V: Simd>(&self, motion: &CellMotion<V, D>, from_axis: FromAxis<V>, inverse_size: f64) -> SimdReal<V> {
        let plane = trace(&gradient(&motion.strains, &motion.at, inverse_size));
        let Some(from) = from_axis else { return plane };
        plane + <Self as Functions<D>>::hoop(self, motion, &(), &centre(motion.at), from, inverse_size)
    }

    #[inline(always)]
    fn hoop<V: Simd>(
        &self,
        motion: &CellMotion<V, D>,
        (): &(),
        xi: &[SimdReal<V>; D],
        from_axis: SimdReal<V>,
        inverse_size: f64,
    ) -> SimdReal<V> {
        let here = if <Self as Functions<D>>::OF_CELL { centre(*xi) } else { *xi };
        value::<D, D, _>(&motion.strains, &basis(&here))[0] / (from_axis + here[0]) * inverse_size
    }

    #[inline(always)]
    fn moves<V: Simd>(
        &self,
        motion: &CellMotion<V, D>,
        (): &(),
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> Moves<V, D> {
        let here = if <Self as Functions<D>>::OF_CELL { &motion.at } else { xi };
        let phi = basis(xi);
        Moves {
            gradient: gradient(&motion.strains, here, inverse_size),
            velocity: value::<D, D, _>(&motion.velocity, &phi),
            change: value::<D, D, _>(&motion.change, &phi),
        }
    }

    #[inline(always)]
    fn gradient_at<V: Simd>(
        &self,
        motion: &CellMotion<V, D>,
        (): &(),
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> [[SimdReal<V>; D]; D] {
        gradient(&motion.velocity, xi, inverse_size)
    }

    #[inline(always)]
    fn find_water<V: Simd>(&self, motion: &CellMotion<V, D>, relative: &Field<V, D>) -> Field<V, D> {
        let mut both = motion.strains;
        for k in 0..1 << D {
            for d in 0..D {
                both[k][d] += relative[k][d];
            }
        }
        both
    }

    #[inline(always)]
    fn with_water<V: Simd>(
        &self,
        motion: &CellMotion<V, D>,
        water: &Field<V, D>,
        (): &(),
        xi: &[SimdReal<V>; D],
        inverse_size: f64,
    ) -> ([SimdReal<V>; D], SimdReal<V>) {
        let rate = if <Self as Functions<D>>::PRESSURE_AT_PARTICLES {
            trace(&gradient(&motion.strains, xi, inverse_size))
        } else {
            xi[0].like(0.0)
        };
        (value::<D, D, _>(water, &basis(xi)), rate)
    }

    fn values(&self, position: &[usize; D], cells: &[usize; D], xi: &[f64; D]) -> [f64; MOST_REACHED] {
        self.at_surface(position, cells, xi, 1.0)
    }

    fn at_surface(&self, _: &[usize; D], _: &[usize; D], xi: &[f64; D], amount: f64) -> [f64; MOST_REACHED] {
        let mut all = [0.0; MOST_REACHED];
        all[..4].copy_from_slice(&shares(amount, xi));
        all
    }

    #[inline(always)]
    fn nothing<V: Simd>(&self, simd: V) -> CellSums<V, D> {
        let none = SimdReal::splat(simd, 0.0);
        CellSums {
            solid_mass: [none; 4],
            momentum: [[none; D]; 4],
            mean: [none; 4],
            first: [[none; 4]; D],
            water_mass: [none; 4],
            moment: [none; D],
            weighted: [[none; 1]; 4],
            of_water: none,
            hoop: [none; 4],
            hoop_of_water: [none; 4],
            hoop_of_one: [none; 4],
            spherical: none,
        }
    }

    #[inline(always)]
    fn clear<V: Simd>(&self, simd: V, sums: &mut CellSums<V, D>, (_, found): (bool, bool)) {
        let none = SimdReal::splat(simd, 0.0);
        (sums.mean, sums.of_water, sums.first, sums.moment) = ([none; 4], none, [[none; 4]; D], [none; D]);
        for a in 0..1 << D {
            (sums.solid_mass[a], sums.momentum[a]) = (none, [none; D]);
            (sums.water_mass[a], sums.weighted[a]) = (none, [none]);
        }
        if found {
            (sums.hoop, sums.hoop_of_water, sums.hoop_of_one, sums.spherical) = ([none; 4], [none; 4], [none; 4], none);
        }
    }

    #[inline(always)]
    fn add<V: Simd>(
        &self,
        sums: &mut CellSums<V, D>,
        (): &(),
        point: &Contribution<V, D>,
        (coupled, found, inverse_size): (bool, bool, f64),
    ) {
        let Contribution { xi, mass, volume, v, stress, affine, from_axis } = point;
        let share = shares(*mass, xi);
        for a in 0..1 << D {
            sums.solid_mass[a] += share[a];
        }
        if let Some(affine) = affine {
            for a in 0..1 << D {
                let away = array!([xi[0]; D], d => {
                    let corner = if (a >> d) & 1 == 1 { 1.0 } else { 0.0 };
                    (xi[d].like(corner) - xi[d]) * (1.0 / inverse_size)
                });
                let v = affine.seen_from(v, &away);
                for d in 0..D {
                    sums.momentum[a][d] += share[a] * v[d];
                }
            }
        } else {
            for a in 0..1 << D {
                for d in 0..D {
                    sums.momentum[a][d] += share[a] * v[d];
                }
            }
        }
        let is_asked = <Self as Functions<D>>::at_centroid(self) || found;
        if is_asked || (coupled && <Self as Functions<D>>::PRESSURE_AT_PARTICLES) {
            for d in 0..D {
                sums.moment[d] += *volume * xi[d];
            }
        }
        let mean = if <Self as Functions<D>>::SPLIT { mean_stress(stress) } else { stress[0] };
        if let (Some(r), false) = (radius(*from_axis, xi), <Self as Functions<D>>::OF_CELL) {
            let own = *volume / r * inverse_size;
            if <Self as Functions<D>>::SPLIT {
                let centre = centre(*xi);
                let at_centre = *volume * mean / (r - xi[0] + centre[0]) * inverse_size;
                add_shares(&mut sums.hoop, own * (stress[2] - mean), xi);
                add_shares(&mut sums.hoop, at_centre, &centre);
            } else {
                add_shares(&mut sums.hoop, own * stress[2], xi);
                if coupled {
                    add_shares(&mut sums.hoop_of_one, own, xi);
                }
            }
        }
        if <Self as Functions<D>>::SPLIT && found {
            sums.spherical += *volume * mean;
        }
        for s in 0..4 {
            let weighted = *volume * stress[s];
            sums.mean[s] += weighted;
            for d in 0..D {
                if <Self as Functions<D>>::SPLIT {
                    let mean = mean * -PRESSURE[s];
                    sums.first[d][s] += *volume * ((stress[s] - mean) * xi[d] + mean * 0.5);
                } else if !<Self as Functions<D>>::OF_CELL {
                    sums.first[d][s] += weighted * xi[d];
                }
            }
        }
    }

    #[inline(always)]
    fn add_water<V: Simd>(
        &self,
        sums: &mut CellSums<V, D>,
        (): &(),
        xi: &[SimdReal<V>; D],
        [mass, volume, pressure]: [SimdReal<V>; 3],
        from_axis: FromAxis<V>,
    ) {
        let share = shares(mass, xi);
        for a in 0..1 << D {
            sums.water_mass[a] += share[a];
        }
        let weighted = volume * pressure;
        sums.weighted[0][0] += weighted;
        sums.of_water += volume;
        if <Self as Functions<D>>::PRESSURE_AT_PARTICLES {
            let phi = basis(xi);
            for k in 1..1 << D {
                sums.weighted[k][0] += weighted * phi[k];
            }
            if let Some(r) = radius(from_axis, xi) {
                add_shares(&mut sums.hoop_of_water, weighted / r, xi);
            }
        }
    }

    #[inline(always)]
    fn water_of<V: Simd>(&self, sums: &CellSums<V, D>) -> [SimdReal<V>; 2] {
        [sums.weighted[0][0], sums.of_water]
    }

    #[inline(always)]
    fn centroid<V: Simd>(&self, sums: &CellSums<V, D>, full: SimdReal<V>, found: bool) -> Option<[SimdReal<V>; D]> {
        let of = |d| <Self as Functions<D>>::at_centroid(self) || (found && (d == 0 || <Self as Functions<D>>::SPLIT));
        of(0).then(|| array!([full; D], d => if of(d) { sums.moment[d] / full } else { full.like(0.5) }))
    }

    #[inline(always)]
    fn finish<'a, V: Simd>(
        &self,
        sums: &'a mut CellSums<V, D>,
        (): &(),
        cell: &Closing<V, D>,
        inverse_size: f64,
        given: &'a mut Given<V>,
    ) -> &'a Given<V> {
        let none = sums.solid_mass[0].like(0.0);
        for s in 0..4 {
            sums.mean[s] = sums.mean[s] * cell.share;
        }
        if <Self as Functions<D>>::OF_CELL {
            // Section 2.2: G_i(x_c) for every particle of the cell.
            for d in 0..D {
                for s in 0..4 {
                    sums.first[d][s] = sums.mean[s] * cell.at[d];
                }
            }
        } else {
            for d in 0..D {
                if <Self as Functions<D>>::SPLIT {
                    // None where centroids are not found.
                    let off = sums.spherical * (cell.at[d] - none.like(0.5));
                    (0..3).for_each(|s| sums.first[d][s] += off);
                }
                for s in 0..4 {
                    sums.first[d][s] = sums.first[d][s] * cell.share;
                }
            }
        }
        if let Some(ratio) = cell.water_ratio {
            for a in 0..1 << D {
                let of_particles = sums.water_mass[a];
                sums.water_mass[a] = (ratio * sums.solid_mass[a]).or(cell.moving_with, of_particles);
            }
        }
        if let Some((mass, at)) = cell.given_water {
            sums.water_mass = shares(mass, &at);
        }
        if let Some(pressure) = cell.pressure {
            // Where the pressure acts: at the centre (section 2.2), or where its particles are.
            let moments = if <Self as Functions<D>>::PRESSURE_AT_PARTICLES && !cell.of_cell {
                let share = cell.filled / cell.full_of_water;
                array!([none; 4], k => sums.weighted[k][0] * share)
            } else {
                let acting = pressure * cell.filled;
                let phi = basis(&cell.pressed_at);
                [acting, acting * phi[1], acting * phi[2], none]
            };
            for s in 0..3 {
                sums.mean[s] -= moments[0];
                for d in 0..D {
                    sums.first[d][s] -= moments[1 + d];
                }
            }
        }
        // div(sigma') - grad p, weak: f_i = - sum_p V sigma G_i
        let coefficients = internal_force(&sums.mean, &sums.first, inverse_size);
        let mut internal = to_corners::<D, D, _>(&coefficients);
        if let Some(from) = cell.from_axis {
            // About an axis also - sum_p V sigma_tt N_i/r, radially.
            let hoop = self.hoop_force(sums, cell, from, inverse_size);
            for a in 0..1 << D {
                internal[a][0] += hoop[a];
            }
        }
        for a in 0..1 << D {
            given[SOLID_MASS][a] = sums.solid_mass[a];
            given[MIXTURE_MASS][a] = sums.solid_mass[a] + sums.water_mass[a];
            for d in 0..D {
                given[MOMENTUM + d][a] = sums.momentum[a][d];
                given[force(D) + d][a] = -internal[a][d];
            }
        }
        given
    }

    #[inline(always)]
    fn coupling<V: Simd>(
        &self,
        sums: &CellSums<V, D>,
        (): &(),
        cell: &Closing<V, D>,
        inverse_size: f64,
    ) -> [[SimdReal<V>; D]; MOST_REACHED] {
        let none = sums.solid_mass[0].like(0.0);
        let mut isotropic = [none; 4];
        isotropic[..3].fill(cell.filled);
        let mut first = [[none; 4]; D];
        for d in 0..D {
            let moment = if !<Self as Functions<D>>::PRESSURE_AT_PARTICLES {
                cell.filled * cell.at[d]
            } else {
                sums.moment[d] * cell.share
            };
            first[d] = [moment, moment, moment, none];
        }
        let mut at_corners = to_corners::<D, D, _>(&internal_force(&isotropic, &first, inverse_size));
        if let Some(from) = cell.from_axis {
            let of_cell = shares(cell.filled / (from + none.like(0.5)) * inverse_size, &centre(cell.at));
            for a in 0..1 << D {
                let of_particles = <Self as Functions<D>>::PRESSURE_AT_PARTICLES;
                at_corners[a][0] += if of_particles { sums.hoop_of_one[a] * cell.share } else { of_cell[a] };
            }
        }
        let mut coupling = [[none; D]; MOST_REACHED];
        coupling[..1 << D].copy_from_slice(&at_corners[..1 << D]);
        coupling
    }
}
