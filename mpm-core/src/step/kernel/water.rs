//! The water of a cell: Darcy flow through its faces (or with velocities at its nodes), and what that does to pressures, volumes
//! and places of its particles.

use pulp::Simd;

use super::{Cells, Closing, Common, FromAxis, Functions, InPores, Pass, Rare, Relative, Running};
use crate::dimension::{basis, coefficients, gradient, trace, value};
use crate::real::{MAX_LANES, Real, SimdReal, array};
use crate::step::store::strip::{FILL, FILLING, HOLDS, INVERSE_POROSITY, INVERSE_VOLUME, POROSITY};
use crate::step::store::{SimdCells, WaterLanes};
use crate::water::pores::LEAST_FULL;
use crate::water::{FLOW, LEAST_FILLING};

/// Motion of the soil and of the water in it, the cells, and what the soil gains: volume (m3) and its rate (m3/s).
type Driven<'a, V, F, const D: usize> =
    (&'a <F as Functions<D>>::Motion<V>, &'a Relative<V, D>, &'a SimdCells<V, D>, [SimdReal<V>; 2]);

impl<V: Simd, const D: usize> Cells<'_, V, D> {
    /// Eq. (1) on faces normal to an axis, from one on, between cells of two pressures (Pa) whose nodes accelerate (m/s2): flux
    /// (m/s), pressure drop and weight along it (Pa).
    #[inline(always)]
    fn face(
        &self,
        axis: usize,
        at: usize,
        [low, high]: [SimdReal<V>; 2],
        [a, b]: [SimdReal<V>; 2],
    ) -> [SimdReal<V>; 3] {
        let Common { flow, gravity, conducts, rare: Rare { ratio, .. }, .. } = self.common;
        let conducts = SimdReal::load(self.simd, &conducts[axis][at..]);
        let mean = if D == 1 { a } else { (a + b) * 0.5 };
        // Over the distance that the pressure drops along.
        let mut reach = conducts.or_one();
        if let Some(ratio) = ratio {
            let ratio = SimdReal::load(self.simd, &ratio[axis][at..]);
            reach = reach / ratio.or_one();
        }
        // Inside the soil that is one.
        let body = flow.body(gravity[axis], mean).over_where(reach.differs(mean.like(1.0)), reach);
        flow.through(conducts, low - high, body)
    }

    /// Eq. (1): relative velocity v* in the cells from `at` on, linear between their faces, as coefficients.
    #[inline(always)]
    pub(super) fn darcy_flow(
        &self,
        at: usize,
        cell: &SimdCells<V, D>,
        running: &mut Running<V>,
        group: usize,
    ) -> Relative<V, D> {
        let Common { frame, acceleration, pressure, water, .. } = self.common;
        let none = SimdReal::splat(self.simd, 0.0);
        let mut relative = [[none; D]; 4];
        let row = frame.stride[D - 1];
        if let InPores::Particles { relative: Some(at_nodes), .. } = water {
            for d in 0..D {
                for a in 0..1 << D {
                    relative[a][d] = self.load(&at_nodes[d], at + (a & 1) + (a >> 1) * row);
                }
            }
            return coefficients::<D, D, _>(&relative);
        }
        let inverse_porosity = cell.inverse_porosity;
        let part = group % (MAX_LANES / V::F64_LANES);
        // Pressures begin before the first cell, so that every face has a cell below.
        let here = self.load(pressure, at + frame.pad());
        for axis in 0..D {
            let stride = frame.stride[axis];
            let below = self.load(pressure, at + frame.pad() - stride);
            let above = self.load(pressure, at + frame.pad() + stride);
            // Nodes of the lower face, and of the upper one.
            let other = if D == 1 { 0 } else { frame.stride[D - 1 - axis] };
            let [a, b] = [self.load(&acceleration[axis], at), self.load(&acceleration[axis], at + other)];
            let [low, mut head, mut body] = self.face(axis, at, [below, here], [a, b]);
            let upper = at + stride;
            let [a, b] = [self.load(&acceleration[axis], upper), self.load(&acceleration[axis], upper + other)];
            let [high, ..] = self.face(axis, upper, [here, above], [a, b]);
            if let Some(from) = self.axis_of(cell.position[0]) {
                let r = (if axis == 0 { from } else { from + none.like(0.5) }) * (1.0 / frame.inverse_size);
                (head, body) = (head * r, body * r);
            }
            relative[0][axis] = low * inverse_porosity; // v* = q/n
            relative[1 + axis][axis] = (high - low) * inverse_porosity;
            running.rates[0][part] += low * head;
            running.rates[1][part] += low * body;
        }
        relative
    }

    /// Divergence of the flow in the cells, 1/s. About an axis v_r/r at the centre makes the areas of the faces right.
    #[inline(always)]
    fn divergence(&self, relative: &Relative<V, D>, xi: &[SimdReal<V>; D], from_axis: FromAxis<V>) -> SimdReal<V> {
        let (inverse, half) = (self.common.frame.inverse_size, xi[0].like(0.5));
        let plane = trace(&gradient(relative, xi, inverse));
        let Some(from) = from_axis else { return plane };
        plane + value::<D, D, _>(relative, &basis(&[half; D]))[0] * inverse / (from + half)
    }

    /// Rates of pressure (Pa/s) and of water volume (1/s) in cells whose soil gains volume at a rate (1/s), beside the divergence of
    /// the flow (1/s).
    #[inline(always)]
    fn rates(
        &self,
        group: usize,
        of_soil: SimdReal<V>,
        divergence: SimdReal<V>,
        cell: &SimdCells<V, D>,
    ) -> [SimdReal<V>; 2] {
        let Common { flow, dt, rare: Rare { outflow, softness, biot, .. }, .. } = self.common;
        let mut through = cell.filling * divergence; // Eq. (6a)
        if let Some(outflow) = outflow {
            let out = SimdReal::load(self.simd, &outflow[self.strip.first + group * V::F64_LANES..]);
            through += out * cell.inverse_volume * cell.inverse_porosity;
        }
        if let InPores::Particles { rise: Some(rise), .. } = self.common.water {
            let rise = SimdReal::load(self.simd, &rise[self.strip.first + group * V::F64_LANES..]);
            return [rise * (1.0 / dt), of_soil + through];
        }
        let (mut stiffness, mut of_soil, moved) =
            (cell.inverse_porosity * flow.bulk_modulus, of_soil, of_soil + through);
        if let Some([alpha, grains]) = biot {
            let at = self.strip.first + group * V::F64_LANES;
            // 1/Q = n/K_w + (alpha - n)/K_s
            let one = of_soil.like(1.0);
            stiffness = one / (cell.porosity * (1.0 / flow.bulk_modulus) + self.load(grains, at)).or_one();
            of_soil = of_soil * self.load(alpha, at);
        }
        let softer = match softness {
            Some(softness) => SimdReal::load(self.simd, &softness[self.strip.first + group * V::F64_LANES..]),
            None => softer(cell.fill, stiffness * *dt * flow.diffusion),
        };
        let stiffness = softer * stiffness;
        // Eq. (5), sign corrected: dp = -(K_w/n) [ tr(d eps_s) + n tr(d eps*_w) ]
        [-stiffness * (of_soil + cell.porosity * through), moved]
    }

    /// Notes the water of the cells for the next step.
    #[inline(always)]
    pub(super) fn close_water(
        &mut self,
        group: usize,
        [mass, volume]: [SimdReal<V>; 2],
        [weighted, of_water]: [SimdReal<V>; 2],
        closing: &mut Closing<V, D>,
    ) {
        let Common { flow, rare: Rare { grains, softness, .. }, coupled, .. } = *self.common;
        let none = mass.like(0.0);
        let one = none.like(1.0);
        // Cells without soil have no pressure; they must not turn into NaN beside cells that have.
        let by_faces = matches!(self.common.water, InPores::Particles { relative: None, .. });
        let mut pressure = weighted / of_water.or_one();
        let inverse_volume = one / closing.filled.or_one();
        let grain_inverse = match grains {
            Some(grains) => SimdReal::load(self.simd, &grains[self.strip.first + group * V::F64_LANES..]),
            None => one.like(flow.grain_inverse),
        };
        let porosity = one - mass * grain_inverse / volume.or_one();
        let mut over_fill = inverse_volume * flow.cell_volume;
        if let Some(from) = closing.from_axis {
            over_fill = over_fill * (from + one.like(0.5)) * (1.0 / self.common.frame.inverse_size);
        }
        let is_known = closing.moving_with;
        // An outline that is known needs no limit either.
        let limited = if softness.is_some() {
            over_fill
        } else if by_faces {
            over_fill.lesser(one.like(1.0 / LEAST_FILLING))
        } else {
            one
        };
        // A pressure that is solved for needs no limit.
        self.strip.note(group, FILLING, over_fill.or(is_known, if coupled { over_fill } else { limited }));
        let is_partly = self.simd.and_m64s(is_known, over_fill.differs(one));
        self.strip.note(group, FILL, one.over_where(is_partly, over_fill).or(is_known, one.like(super::NOT_KNOWN)));
        self.strip.note(group, INVERSE_VOLUME, inverse_volume);
        self.strip.note(group, POROSITY, porosity);
        self.strip.note(group, INVERSE_POROSITY, one / porosity);
        closing.full_of_water = of_water.or_one();
        if matches!(self.common.water, InPores::Particles { partly_drained: true, .. }) {
            // Cells whose water fills too little of their soil are open to the air, and coarse soil holds no suction.
            let full = self.simd.not_m64s(of_water.below(volume * LEAST_FULL));
            pressure = pressure.larger(none).or(full, none);
            let holds = one.or(full, none);
            // Nor does it push where pressures are its particles' own.
            closing.full_of_water = closing.full_of_water.or(none.below(pressure), none.like(f64::INFINITY));
            let held = self.strip.cell::<D>(group).holds;
            let differs = self.simd.or_m64s(held.below(holds), holds.below(held));
            self.strip.sums.changed |= !SimdReal::nowhere(self.simd, differs);
            self.strip.note(group, HOLDS, holds);
        }
        pressure.store(&mut self.pressure[group * V::F64_LANES..]);
        // Water in pores of known volume moves with its soil.
        closing.water_ratio = Some(porosity * volume * flow.density / mass.or_one());
        if let Some([alpha, _]) = self.common.rare.biot {
            let alpha = self.load(alpha, self.strip.first + group * V::F64_LANES);
            pressure = pressure * alpha;
            closing.full_of_water = closing.full_of_water / alpha;
        }
        closing.pressure = if coupled { None } else { Some(pressure) };
    }
}

impl<V: Simd, F: Functions<D>, const D: usize, const LEAN: bool> Pass<'_, V, F, D, LEAN> {
    /// Water particles: pressures, volumes and positions (Eqs. 5 to 7), then masses and pressures.
    #[inline(always)]
    pub(super) fn water(
        &mut self,
        group: usize,
        position: &[SimdReal<V>; D],
        motion: Option<Driven<V, F, D>>,
        (edges, sums): (&F::Edges<V>, &mut F::Sums<V>),
        running: &mut Running<V>,
    ) {
        let Common { frame, dt, .. } = *self.common;
        let functions = self.functions;
        let (simd, inverse) = (self.simd, frame.inverse_size);
        let none = SimdReal::splat(simd, 0.0);
        let partly_drained = matches!(self.common.water, InPores::Particles { partly_drained: true, .. });
        let from_axis = self.axis_of(position[0]);
        let (mut cellwise, mut flows, mut rests) = ([none; 2], None, None);
        if let Some((motion, relative, cell, [volume, gain])) = motion {
            flows = Some(functions.find_water(motion, relative));
            if self.common.rare.outflow.is_some() {
                rests = Some(functions.find_water(motion, &[[none; D]; 4]));
            }
            let of_soil = if self.common.coupled || !(F::OF_CELL || F::SPLIT) {
                gain / volume.or_one()
            } else {
                functions.middle(motion, from_axis, inverse)
            };
            cellwise = self.rates(group, of_soil, self.divergence(relative, &[none.like(0.5); D], from_axis), cell);
        }
        for index in self.strip.water.range(group) {
            self.strip.water.ask_for(index + super::BLOCKS_AHEAD, 2 * D + 3);
            let mut point = WaterLanes::<V, D>::read(simd, self.strip.water.block(index));
            let mut xi = array!([none; D], d => point.x[d] * inverse - position[d]);
            if let (Some((motion, relative, cell, _)), Some(flows)) = (motion, &flows) {
                let (v, mut rate) = functions.with_water(motion, flows, edges, &xi, inverse);
                let [pressure_rate, volume_rate] = if F::PRESSURE_AT_PARTICLES && !self.common.coupled {
                    if let Some(from) = from_axis {
                        rate += functions.hoop(motion, edges, &xi, from, inverse);
                    }
                    self.rates(group, rate, self.divergence(relative, &xi, from_axis), cell)
                } else {
                    cellwise
                };
                if partly_drained {
                    // Open to the air its water moves with the soil. Below zero a pressure counts on as a measure of the gap, -Q times the
                    // opening, and pushes again once that is closed.
                    let holds = none.below(cell.holds);
                    point.pressure = (point.pressure + pressure_rate * dt).or(holds, point.pressure.lesser(none));
                    point.volume = (point.volume * (none.like(1.0) + volume_rate * dt)).or(holds, point.volume);
                } else {
                    point.pressure += pressure_rate * dt;
                    point.volume = point.volume * (none.like(1.0) + volume_rate * dt);
                }
                point.v = v;
                // Water that passes an outline or wells for long would take the pressure of where it comes from along, and leave cells bare.
                let way = match &rests {
                    Some(rests) => functions.with_water(motion, rests, edges, &xi, inverse).0,
                    None => v,
                };
                for d in 0..D {
                    point.x[d] += way[d] * dt;
                    xi[d] = point.x[d] * inverse - position[d];
                    running.stays = simd.and_m64s(running.stays, xi[d].in_unit_interval());
                }
                point.write(self.strip.water.block_mut(index));
            }
            functions.add_water(sums, edges, &xi, [point.mass, point.volume, point.pressure], from_axis);
        }
    }

    /// The pressure that acts on each particle of the cells, where it is not added to their sums, Pa.
    #[inline(always)]
    pub(super) fn pressure_on_particles(&self, sums: &F::Sums<V>, at: usize) -> SimdReal<V> {
        let none = SimdReal::splat(self.simd, 0.0);
        if F::FUSED || self.common.coupled || !matches!(self.common.water, InPores::Particles { .. }) {
            return none;
        }
        let [weighted, volume] = self.functions.water_of(sums);
        let pressure = weighted / volume.or_one();
        match self.common.rare.biot {
            Some([alpha, _]) => pressure * self.load(alpha, at),
            None => pressure,
        }
    }
}

/// What is left of the stiffness of the water in a cell that is filled in part under a drained surface, so that an
/// explicit step is as stable there as in a full one: its flow to the surface and to the cell below, `2/f + 2/(1 + f)`, over what
/// it stores is at most that of a full cell, 2 + 1. Where a step is far from the limit of the flow, `diffusion` = `D_p dt/L^2`, as
/// much less is asked: water that hardly flows is as stiff as ever.
#[inline(always)]
fn softer<V: Simd>(fill: SimdReal<V>, diffusion: SimdReal<V>) -> SimdReal<V> {
    let one = fill.like(1.0);
    if SimdReal::nowhere(fill.simd, fill.below(one)) {
        return one;
    }
    let share = fill * 1.5 * fill * (one + fill) / (one + fill * 2.0);
    (share * (one.like(FLOW / 3.0) / diffusion).larger(one)).lesser(one)
}
