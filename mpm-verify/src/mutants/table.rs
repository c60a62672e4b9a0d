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
        "mpm-core/src/water/face.rs",
        "lower_cells[i].pressure - upper_cells[i].pressure + body",
        "lower_cells[i].pressure - upper_cells[i].pressure - body",
    ),
    fault(
        "darcy-sign-nodal",
        "the same in the paper's nodal operator",
        "mpm-core/src/water/nodal.rs",
        "self.mobility * (self.gradient[node][d] + body * volume) / pores",
        "self.mobility * (self.gradient[node][d] - body * volume) / pores",
    ),
    fault(
        "drained-surface",
        "the drained surface lies a whole cell from the centre of the last one",
        "mpm-core/src/water/face.rs",
        "let mut flux = conducts * head * self.conductance;",
        "let mut flux = self.conductance * head;",
    ),
    fault(
        "lost-water-particle",
        "the last water particle is lost when a scene is seeded",
        "mpm-core/src/run.rs",
        "let layer = Layer::new(points, &self.grid).map_err(|e| outside(\"water\", e.index, &e.x))?;",
        "let layer = Layer::new({ let mut fewer: Vec<WaterPoint<D>> = points; fewer.pop(); fewer }, &self.grid)\
         .map_err(|e| outside(\"water\", e.index, &e.x))?;",
    ),
    fault(
        "load-on-wrong-node",
        "the load of a strip goes to the corners of its cell in the wrong order",
        "mpm-core/src/boundary/surcharge.rs",
        "give(corners[a], share[a]);",
        "give(corners[Grid::<D>::CORNERS - 1 - a], share[a]);",
    ),
    fault(
        "cv-without-water",
        "the exact c_v forgets that water is compressible",
        "mpm-verify/src/exact/terzaghi.rs",
        "1.0 / scene.oedometer_modulus() + 1.0 / scene.pore_stiffness()",
        "1.0 / scene.oedometer_modulus()",
    ),
    fault(
        "dropped-body-force",
        "a given body force is gathered and never applied",
        "mpm-core/src/boundary/body_force.rs",
        "sum.force[d] += force[d];",
        "let _ = (&mut sum.force[d], force[d]);",
    ),
    fault(
        "dropped-gravity",
        "the semi-implicit and the wide step forget gravity",
        "mpm-core/src/step/skeleton.rs",
        "node.force[d] += node.mixture_mass * gravity[d];",
        "let _ = (&mut node.force[d], gravity[d]);",
    ),
    fault(
        "unsorted-sum",
        "energies of strips are summed in the order in which threads finish",
        "mpm-core/src/step/lanes/sweep.rs",
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
        "mpm-core/src/step/explicit.rs",
        "point.volume *= 1.0 + dt * rate;",
        "point.volume *= 1.0 + 0.0 * dt * rate;",
    ),
    fault(
        "no-spin",
        "stresses are not turned with the soil",
        "mpm-core/src/dimension.rs",
        "let spin = (gradient[0][1] - gradient[1][0]) * 0.5 * dt;",
        "let spin = (gradient[0][1] - gradient[1][0]) * 0.0 * dt;",
    ),
    fault(
        "loose-rollers",
        "rollers hold the last but one node of their row in place of the last",
        "mpm-core/src/boundary/supports.rs",
        "let m = &mut motion[node as usize];",
        "let m = &mut motion[(node as usize).saturating_sub(1)];",
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
        "mpm-core/src/step/explicit.rs",
        "self.totals.water_out += dt * rates.outflow;",
        "self.totals.water_out += 0.999 * dt * rates.outflow;",
    ),
    fault(
        "splines-at-the-edge",
        "B-splines do not know the first knot",
        "mpm-core/src/stencil/bspline.rs",
        "if cell == 0 { 1.0 } else { 0.5 }",
        "0.5",
    ),
    fault(
        "gimp-half-size",
        "uGIMP particles are twice as large",
        "mpm-core/src/stencil/gimp.rs",
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
        "a checkpoint forgets the pressures of the water",
        "mpm-core/src/particles.rs",
        "keeper.f64(&mut self.pressure);",
        "let _ = (&mut *keeper, &mut self.pressure);",
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
        "what the last row of a strip gives to the next one is that of the step before",
        "mpm-core/src/step/lanes/sweep.rs",
        "self.tail[q].copy_from_slice(&self.strip.sums[q][length..=length + row]);",
        "if q != 2 { self.tail[q].copy_from_slice(&self.strip.sums[q][length..=length + row]); }",
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
        "mpm-core/src/boundary/coulomb.rs",
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
        "self.force || !self.is_level_column() || self.strength.is_some()",
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
        assert!(MUTANTS.len() >= 20);
    }
}
