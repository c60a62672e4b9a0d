//! The faults: what a tired programmer, or a careless merge, would leave behind.

/// A fault: a piece of a source file, and what stands there in its place.
#[derive(Debug, Clone, Copy)]
pub struct Mutant {
    /// Its name.
    pub name: &'static str,
    /// What is wrong, in words.
    pub what: &'static str,
    /// The file, from the root of the workspace.
    pub file: &'static str,
    /// What stands there, exactly once: an expression, or a statement with its semicolon.
    pub find: &'static str,
    /// What stands there instead.
    pub replace: &'static str,
}

const fn fault(
    name: &'static str,
    what: &'static str,
    file: &'static str,
    find: &'static str,
    replace: &'static str,
) -> Mutant {
    Mutant { name, what, file, find, replace }
}

/// All faults.
pub const MUTANTS: &[Mutant] = &[
    fault(
        "darcy-sign",
        "the body force in Darcy's law has the wrong sign",
        "mpm-core/src/water/darcy.rs",
        "let head = drop + body;",
        "let head = drop - body;",
    ),
    fault(
        "darcy-sign-nodal",
        "the same in the paper's nodal operator",
        "mpm-core/src/step/nodal.rs",
        "self.gradient[node][d] + body(node, d) * volume",
        "self.gradient[node][d] - body(node, d) * volume",
    ),
    fault(
        "drained-surface",
        "the drained surface lies a whole cell from the centre of the last one",
        "mpm-core/src/water/darcy.rs",
        "DRAINED_SURFACE: f64 = 2.0;",
        "DRAINED_SURFACE: f64 = 1.0;",
    ),
    fault(
        "lost-water-particle",
        "the last water particle is lost when a scene is seeded",
        "mpm-core/src/run.rs",
        "Layer::new(points, &self.grid).map_err(|e| outside(\"water\", e.index, &e.x))",
        "Layer::new({ let mut fewer: Vec<WaterPoint<D>> = points; fewer.pop(); fewer }, &self.grid)\
         .map_err(|e| outside(\"water\", e.index, &e.x))",
    ),
    fault(
        "load-on-wrong-node",
        "the load of a strip goes to the corners of its cell in the wrong order",
        "mpm-core/src/step/surface.rs",
        "forces[row * F::REACH + i]",
        "forces[F::REACH.pow(D as u32) - 1 - row * F::REACH - i]",
    ),
    fault(
        "cv-without-water",
        "the exact c_v forgets that water is compressible",
        "mpm-verify/src/exact/terzaghi.rs",
        "(water.mobility() / scene.storage(), scene.soil().alpha())",
        "(water.mobility() * scene.oedometer_modulus(), scene.soil().alpha())",
    ),
    fault(
        "dropped-body-force",
        "a given body force is gathered and never applied",
        "mpm-core/src/step/conditions/force.rs",
        "nodes.push(node, d, newton[d]);",
        "nodes.push(node, d, 0.0 * newton[d]);",
    ),
    fault(
        "unsorted-sum",
        "energies of strips are summed in the order in which threads finish",
        "mpm-core/src/step/kernel/mod.rs",
        "*rate = 0.0;\n                for part in 0..MOST_LANES {\n                    *rate += lanes[part / V::F64_LANES].lane(part % V::F64_LANES);\n                }",
        "static SUM: std::sync::Mutex<f64> = std::sync::Mutex::new(0.0);\n                *rate = (0..MOST_LANES).map(|part| lanes[part / V::F64_LANES].lane(part % V::F64_LANES)).sum();\n                let mut sum = SUM.lock().unwrap_or_else(|e| e.into_inner());\n                if self.strip.first == 0 { *sum = 0.0; }\n                let before = *sum;\n                *sum += *rate;\n                *rate = *sum - before;",
    ),
    fault(
        "skipped-step",
        "one step in a thousand is counted, but not made",
        "mpm-core/src/step/explicit.rs",
        "self.step(dt)?;",
        "if *done % 1000 != 999 { self.step(dt)?; }",
    ),
    fault(
        "stale-factorisation",
        "factors of another step are used again",
        "mpm-core/src/step/quasi_static/march.rs",
        "*factored == h && soil.linear()",
        "factored.is_finite() && soil.linear()",
    ),
    fault(
        "wasted-factorisation",
        "factors that are at hand are made again",
        "mpm-core/src/step/quasi_static/march.rs",
        "linear && STEADY.contains(&factor)",
        "linear && STEADY.contains(&factor) && h < 0.0",
    ),
    fault(
        "frozen-volume",
        "particles keep their volume whatever the strain",
        "mpm-core/src/step/kernel/mod.rs",
        "point.volume * (none.like(1.0) + rate * dt)",
        "point.volume * (none.like(1.0) + rate * (0.0 * dt))",
    ),
    fault(
        "no-spin",
        "stresses are not turned with the soil",
        "mpm-core/src/dimension.rs",
        "let spin = (gradient[0][D - 1] - gradient[D - 1][0]) * 0.5 * dt;",
        "let spin = (gradient[0][D - 1] - gradient[D - 1][0]) * 0.0 * dt;",
    ),
    fault(
        "loose-rollers",
        "rollers hold the last but one node of their row in place of the last",
        "mpm-core/src/step/conditions/held.rs",
        "for node in self.nodes[d].iter().map(|node| *node as usize) {",
        "for node in self.nodes[d].iter().map(|node| (*node as usize).saturating_sub(1)) {",
    ),
    fault(
        "wrong-edge",
        "plastic returns to the edge of triaxial compression use the face's multiplier",
        "mpm-core/src/constitutive/mohr_coulomb/returns.rs",
        "(over + self.over(s2, s3)) * self.of_edge[0]",
        "(over + self.over(s2, s3)) * self.of_face",
    ),
    fault(
        "leaky-ledger",
        "a thousandth of the water that leaves is not booked",
        "mpm-core/src/step/faces.rs",
        "totals.water_out += through.max(0.0);",
        "totals.water_out += 0.999 * through.max(0.0);",
    ),
    fault(
        "splines-at-the-edge",
        "B-splines do not know the first knot",
        "mpm-core/src/step/kernel/bases.rs",
        "along.larger(none).lesser(none.like(cells as f64)) - position",
        "along.lesser(none.like(cells as f64)) - position",
    ),
    fault(
        "gimp-half-size",
        "uGIMP particles are twice as large",
        "mpm-core/src/step/kernel/bases.rs",
        "Self { half: 0.5 / per_direction as f64 }",
        "Self { half: (1.0 / per_direction as f64).min(0.5) }",
    ),
    fault(
        "runge-kutta-coefficient",
        "a coefficient of SDIRK4(3) is off by one part in a thousand",
        "mpm-core/src/step/quasi_static/sdirk.rs",
        "*target -= h * A[i][j] * flow;",
        "*target -= h * A[i][j] * flow * if (i, j) == (4, 3) { 1.001 } else { 1.0 };",
    ),
    fault(
        "krylov-start",
        "the load is taken to act before the stage",
        "mpm-core/src/step/quasi_static/krylov.rs",
        "-f64::exp_m1(-tau * s / mu - f64::ln(mu)) / s",
        "-f64::exp_m1(-tau * s / mu) / s",
    ),
    fault(
        "lost-pressure",
        "water particles that are taken out of their blocks, as for a checkpoint, lose their pressures",
        "mpm-core/src/particles.rs",
        "numbers[2 * D + 2]",
        "0.0 * numbers[2 * D + 2]",
    ),
    fault(
        "unswapped-numbers",
        "sorting carries particles to their cells, but not their numbers",
        "mpm-core/src/particles.rs",
        "self.ids.swap(start, to);",
        "let _ = &mut self.ids;",
    ),
    fault(
        "late-tail",
        "what the last row of a strip gives to the next one goes to the node before",
        "mpm-core/src/step/store/nodes.rs",
        "zip(&from[strip..strip + tail])",
        "zip(&from[strip + 1..strip + tail])",
    ),
    fault(
        "wet-integral",
        "the pressure on a partly wet face is that of a full one",
        "mpm-core/src/water/free_surface/flow.rs",
        "0.5 * bottom * bottom / g",
        "bottom * bottom / g",
    ),
    fault(
        "seepage-lets-in",
        "suction draws water in through the surface of the soil",
        "mpm-core/src/water/free_surface/edges.rs",
        "kind == Kind::Full && p > top",
        "kind.unknown()",
    ),
    fault(
        "forgotten-outflow",
        "particles stay when their water leaves through a side that is fed",
        "mpm-core/src/water/free_surface/layer.rs",
        "*pending -= dt * out;",
        "*pending -= if edge.outside == super::Outside::Air { dt * out } else { dt * out.min(0.0) };",
    ),
    fault(
        "rain-on-boxes",
        "rain falls on the boxes of the particles, not on the outline",
        "mpm-core/src/water/free_surface/edges.rs",
        "*width = right;",
        "*width += 0.0 * right;",
    ),
    fault(
        "forgotten-slip",
        "friction on the base does not fall with slip",
        "mpm-core/src/step/conditions/friction.rs",
        "sums.slip += share * point.mass * slip;",
        "sums.slip += 0.0 * share * point.mass * slip;",
    ),
    fault(
        "double-path",
        "the exact solution of two drained ends keeps the path of one",
        "mpm-verify/src/exact/terzaghi.rs",
        "scene.drainage_path()",
        "scene.height",
    ),
    fault(
        "clipped-area",
        "particles of an outline keep what lies outside of it",
        "mpm-core/src/seeding/clip.rs",
        "let share = from / (from - to);",
        "let share = 0.5 + 0.0 * (from / (from - to));",
    ),
    fault(
        "ignored-adhesion",
        "the base has no strength without normal stress",
        "mpm-core/src/step/conditions/friction.rs",
        "self.tangent(slip) * normal.max(0.0) + self.adhesion * soil.area * dt",
        "self.tangent(slip) * normal.max(0.0)",
    ),
    fault(
        "double-memory",
        "friction lags behind the normal stress by twice its memory",
        "mpm-core/src/step/conditions/friction.rs",
        "(-dt / self.base.memory).exp()",
        "(-0.5 * dt / self.base.memory).exp()",
    ),
    fault(
        "unkept-slip",
        "a checkpoint forgets the slip on the base",
        "mpm-core/src/step/conditions/friction.rs",
        "archive.slice(&mut self.slip)?;",
        "let _ = &mut self.slip;",
    ),
    fault(
        "unkept-memory",
        "a checkpoint forgets the normal stress that the base remembers",
        "mpm-core/src/step/conditions/friction.rs",
        "archive.slice(&mut self.remembered)?;",
        "let _ = &mut self.remembered;",
    ),
    fault(
        "unreduced-adhesion",
        "strength reduction leaves the adhesion on the base as it is",
        "mpm-core/src/step/conditions/friction.rs",
        "self.adhesion = self.base.adhesion / factor;",
        "self.adhesion = self.base.adhesion;",
    ),
    fault(
        "unreduced-residual-angle",
        "strength reduction leaves the residual friction of the base as it is",
        "mpm-core/src/step/conditions/friction.rs",
        "tangent(self.base.residual_angle)",
        "factor * tangent(self.base.residual_angle)",
    ),
    fault(
        "unreduced-dilation",
        "strength reduction leaves the dilation of the soil as it is",
        "mpm-core/src/constitutive/mohr_coulomb/surface.rs",
        "reduced(self.along[0] - 1.0)",
        "(self.along[0] - 1.0).asin().to_degrees()",
    ),
    fault(
        "ramp-at-the-end",
        "all stages of a quasi-static step take the load of its end",
        "mpm-core/src/step/quasi_static/sdirk.rs",
        "bear(soil, C[i]);",
        "bear(soil, 1.0);",
    ),
    fault(
        "light-water-on-faces",
        "water between quasi-static cells weighs 1 % less",
        "mpm-core/src/step/quasi_static/soil.rs",
        "self.fluid.density * gravity * along * reach",
        "0.99 * self.fluid.density * gravity * along * reach",
    ),
    fault(
        "base-pressure-at-the-centre",
        "the pressure on the base is that of the cell's centre",
        "mpm-core/src/step/explicit/grains.rs",
        "{ mean + 0.5 * rise }",
        "{ mean }",
    ),
    fault(
        "free-base-pressure-at-the-centre",
        "the same below water with a free surface",
        "mpm-core/src/water/carried.rs",
        "(water.pressure[cell] + half).max(0.0)",
        "(water.pressure[cell] + 0.0 * half).max(0.0)",
    ),
    fault(
        "damping-impulse-sign",
        "the impulse of damping is booked with the wrong sign",
        "mpm-core/src/step/conditions/damping.rs",
        "totals.damping_impulse[d] -= lost;",
        "totals.damping_impulse[d] += lost;",
    ),
    fault(
        "undamped-response",
        "damping is left out of what the pressures of the end of a step do to the velocities",
        "mpm-core/src/step/pressure.rs",
        "let dt = by.keeps * by.dt;",
        "let dt = by.dt;",
    ),
    fault(
        "long-automatic-step",
        "the automatic step is 8 % too long",
        "mpm-core/src/stability.rs",
        "scene.safety * limit",
        "1.08 * (scene.safety * limit)",
    ),
    fault(
        "friction-booked-twice",
        "work of friction on the base is booked twice",
        "mpm-core/src/step/conditions/friction.rs",
        "totals.base_friction -= impulse",
        "totals.base_friction -= 2.0 * impulse",
    ),
    fault(
        "plate-by-number",
        "a rigid plate shares its force by the number of nodes, not by mass",
        "mpm-core/src/step/conditions/plate.rs",
        "(nodes.sum(of, node) / whole)",
        "(whole / whole / self.0.len() as f64)",
    ),
    fault(
        "periodic-lost-force",
        "forces and momenta at the right side of a periodic mesh are lost",
        "mpm-core/src/step/conditions/joined.rs",
        "+= sum;",
        "+= 0.0 * sum;",
    ),
    fault(
        "unkept-gradients",
        "a checkpoint forgets the velocity gradients of the particles",
        "mpm-core/src/step/explicit/model.rs",
        "archive.slice(&mut kept)?;",
        "let _ = &mut kept;",
    ),
    fault(
        "unkept-inertia",
        "a checkpoint forgets the motion of the nodes, which the next semi-implicit flow feels",
        "mpm-core/src/step/explicit/model.rs",
        "archive.slice(list)?;",
        "let _ = list;",
    ),
    fault(
        "low-apex",
        "stresses beyond the apex return to nine tenths of it",
        "mpm-core/src/constitutive/mohr_coulomb/returns.rs",
        "(Region::Apex, [self.apex; 3])",
        "(Region::Apex, [0.9 * self.apex; 3])",
    ),
    fault(
        "cohesion-without-cosine",
        "the strength is 2 c in place of 2 c cos(phi)",
        "mpm-core/src/constitutive/mohr_coulomb/surface.rs",
        "let k = 2.0 * strength.cohesion * cos;",
        "let k = 2.0 * strength.cohesion * (cos / cos);",
    ),
    fault(
        "half-shear-strain",
        "the shear strain is the tensor's, the stiffness the engineer's",
        "mpm-core/src/dimension.rs",
        "(gradient[x][y] + gradient[y][x]) * dt",
        "(gradient[x][y] + gradient[y][x]) * (0.5 * dt)",
    ),
    fault(
        "flow-without-porosity",
        "the rate of pressure counts the flow through the pores without the porosity",
        "mpm-core/src/step/kernel/water.rs",
        "of_soil + self.of(cell.porosity) * through",
        "of_soil + through",
    ),
    fault(
        "light-water",
        "water weighs 1 % less in Darcy's law on faces",
        "mpm-core/src/water/pores.rs",
        "properties.density * grid.size",
        "0.99 * properties.density * grid.size",
    ),
    fault(
        "arithmetic-mean",
        "two layers conduct as the arithmetic mean of both",
        "mpm-core/src/water/halves.rs",
        "2.0 * a * b / (a + b)",
        "0.5 * (a + b)",
    ),
    fault(
        "double-strain-energy",
        "strain energy without its half",
        "mpm-core/src/constitutive/linear_elastic.rs",
        "0.5 * (self.compliance * sigma).dot(&sigma)",
        "(self.compliance * sigma).dot(&sigma)",
    ),
    fault(
        "forgotten-load-impulse",
        "the impulse of the load is not booked",
        "mpm-core/src/step/explicit/grid.rs",
        "totals.load_impulse -= dt * pressure * body.surface.loaded_area();",
        "let _ = (dt, pressure);",
    ),
    fault(
        "weight-booked-dry",
        "gains and weight of the nodes are booked without the water",
        "mpm-core/src/observe/ledger.rs",
        "strip.0[MIXTURE_MASS][..nodes.frame.strip].as_chunks",
        "strip.0[SOLID_MASS][..nodes.frame.strip].as_chunks",
    ),
    fault(
        "support-impulse-dry",
        "the impulse of supports is booked without the water",
        "mpm-core/src/step/conditions/held.rs",
        "nodes.mixture_mass(node) * nodes.motion.change[d][node]",
        "nodes.sum(crate::step::store::nodes::SOLID_MASS, node) * nodes.motion.change[d][node]",
    ),
    fault(
        "near-front",
        "a front that comes down stands half a cell further from the water above",
        "mpm-core/src/water/free_surface/flow.rs",
        "t / (now.wet[low] + 0.5)",
        "t / (now.wet[low] + 1.0)",
    ),
    fault(
        "krylov-integral",
        "what has flowed through a Krylov stage is integrated wrongly",
        "mpm-core/src/step/quasi_static/krylov.rs",
        "(tau + f64::exp_m1(-tau * s / mu) / s) / s",
        "(tau + f64::exp_m1(-tau * s / mu)) / s",
    ),
    fault(
        "unturned-weight",
        "the weight of water in Darcy's law does not follow the deformation",
        "mpm-core/src/step/quasi_static/soil.rs",
        "let turn = if self.small { 0.0 } else { 1.0 };",
        "let turn = if self.small { 0.0 } else { 0.0 };",
    ),
    fault(
        "first-conductivity",
        "the conductivity does not know that soil is compressed",
        "mpm-core/src/step/quasi_static/soil.rs",
        "let inverse = 1.0 / (1.0 + change);",
        "let inverse = 1.0;",
    ),
    fault(
        "flow-left-out",
        "the semi-implicit pressure does not know what weight and inertia drive",
        "mpm-core/src/step/pressure.rs",
        "dt * (gained + flow.area * leaving)",
        "dt * (gained + 0.0 * flow.area * leaving)",
    ),
    fault(
        "rigid-plate-response",
        "the plate's part of the pressure system is put in without its own response",
        "mpm-core/src/step/pressure.rs",
        "(1.0 + *share * dot(w, solution))",
        "(1.0 + 0.0 * *share * dot(w, solution))",
    ),
    fault(
        "surface-unstrained",
        "the settlement does not know that the soil above the top row is strained",
        "mpm-core/src/boundary/surcharge.rs",
        "point.x[D - 1] + strip.offset * point.volume / strip.volume",
        "point.x[D - 1] + strip.offset",
    ),
    fault(
        "lanes-without-gravity",
        "the vectorised step gives the soil its dry weight",
        "mpm-core/src/step/kernel/equation.rs",
        "force += mixture * gravity[d];",
        "force += solid * gravity[d];",
    ),
    fault(
        "heavy-self-weight",
        "the exact self-weight forgets buoyancy",
        "mpm-verify/src/exact/self_weight.rs",
        "(density - water.density) * gravity",
        "density * gravity",
    ),
    fault(
        "mandel-drained-ratio",
        "Mandel's plate settles with the drained Poisson's ratio",
        "mpm-verify/src/exact/mandel.rs",
        "(1.0 - self.undrained_poisson) * self.sum(time, |root| root.sin * root.cos)",
        "(1.0 - self.poisson) * self.sum(time, |root| root.sin * root.cos)",
    ),
    fault(
        "bishop-without-friction",
        "Bishop's m forgets the friction",
        "mpm-verify/src/exact/slip_circle/factor.rs",
        "(self.weight - held * sin / factor) / (cos + sin * tan / factor)",
        "(self.weight - held * sin / factor) / (cos + 0.0 * sin * tan / factor)",
    ),
    fault(
        "spencer-without-water",
        "Spencer's forces forget the pore pressure",
        "mpm-verify/src/exact/slip_circle/factor.rs",
        "(self.weight * cos - self.pore * length) * tan",
        "(self.weight * cos - 0.0 * self.pore * length) * tan",
    ),
    fault(
        "balances-always-close",
        "every balance of a run closes, whatever is missing",
        "mpm-core/src/observe/trust.rs",
        "self.gap.abs() <= self.allowed",
        "self.gap.abs() <= self.allowed + f64::INFINITY",
    ),
    fault(
        "estimate-off",
        "no load is refused, whatever the scheme",
        "mpm-core/src/scene/moving.rs",
        "self.force || !self.is_level_column() || !self.is_elastic()",
        "self.force || self.height > 0.0",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_fits_its_file_once() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        for one in MUTANTS {
            let text = std::fs::read_to_string(format!("{root}/{}", one.file)).expect("a source file");
            assert_eq!(text.matches(one.find).count(), 1, "{}: {}", one.name, one.find);
            assert_ne!(one.find, one.replace, "{}", one.name);
            assert_eq!(MUTANTS.iter().filter(|other| other.name == one.name).count(), 1, "{}", one.name);
        }
        assert!(MUTANTS.len() >= 60);
    }
}
