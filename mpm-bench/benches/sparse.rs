//! Sparse symmetric systems: finding the pattern of the factors, refilling and factorising, solving.
//!
//! Two families with the patterns of the quasi-static integrator: a column, where a displacement and a pressure per node
//! couple with the next, and a square of plane strain, where two displacements and a pressure couple with eight neighbours.
//! Displacements form a positive block, pressures a negative one. criterion prints time per unknown.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mpm_core::sparse::{Factor, Ordering, Signs, Sparse};

/// A consolidation-like system on a lattice, refilled by [`System::fill`].
struct System {
    matrix: Sparse,
    /// Pairs of neighbouring nodes, each once.
    pairs: Vec<(usize, usize)>,
    /// Displacements per node; a node's unknowns follow each other, the pressure last.
    displacements: usize,
    nodes: usize,
}

impl System {
    /// `across` by `up` nodes, one across for a column.
    fn new(across: usize, up: usize) -> Self {
        let displacements = if across == 1 { 1 } else { 2 };
        let node = |i: usize, j: usize| j * across + i;
        let mut pairs = Vec::new();
        for (i, j) in (0..up).flat_map(|j| (0..across).map(move |i| (i, j))) {
            let after = [(i + 1, j), (i, j + 1), (i + 1, j + 1), (i.wrapping_sub(1), j + 1)];
            let inside = after.into_iter().filter(|(i, j)| *i < across && *j < up);
            pairs.extend(inside.map(|(a, b)| (node(i, j), node(a, b))));
        }
        let (per, nodes) = (displacements + 1, across * up);
        let block = |a: usize, b: usize| (0..per * per).map(move |k| (per * a + k / per, per * b + k % per));
        let own = (0..nodes).flat_map(|a| block(a, a));
        let coupled = pairs.iter().flat_map(|(a, b)| block(*a, *b));
        let matrix = Sparse::symmetric(per * nodes, own.chain(coupled));
        Self { matrix, pairs, displacements, nodes }
    }

    /// Values as a step of length 1/`rate` has them: springs, flow, and the coupling of both, all held weakly in place.
    fn fill(&mut self, rate: f64) {
        let (matrix, per) = (&mut self.matrix, self.displacements + 1);
        matrix.values.fill(0.0);
        for node in 0..self.nodes {
            for d in 0..self.displacements {
                matrix.add(per * node + d, per * node + d, 0.1);
            }
            matrix.add(per * node + per - 1, per * node + per - 1, -0.1);
        }
        for (a, b) in &self.pairs {
            let (a, b) = (per * a, per * b);
            for d in 0..per {
                let stiffness = if d < self.displacements { 1.0 } else { -rate };
                matrix.add(a + d, a + d, stiffness);
                matrix.add(b + d, b + d, stiffness);
                matrix.add(a + d, b + d, -stiffness);
            }
            for d in 0..self.displacements {
                matrix.add(a + d, b + per - 1, 0.3);
                matrix.add(b + d, a + per - 1, -0.3);
            }
        }
    }
}

fn system(c: &mut Criterion, name: &str, mut system: System, ordering: Ordering) {
    system.fill(1.0);
    let size = system.matrix.size();
    let b: Vec<f64> = (0..size).map(|i| (i as f64 + 1.0).sin()).collect();
    let mut x = vec![0.0; size];
    let mut factor = Factor::new(&system.matrix, Signs::QuasiDefinite, ordering).expect("a pattern");
    factor.refresh(&system.matrix).expect("factors");
    factor.solve(&system.matrix, &b, &mut x).expect("a solution");

    let mut group = c.benchmark_group(name);
    group.sample_size(10);
    group.throughput(Throughput::Elements(size as u64));
    let id = |what: &str| BenchmarkId::new(what, size);
    group.bench_function(id("analysis"), |bench| {
        bench.iter(|| Factor::new(&system.matrix, Signs::QuasiDefinite, ordering).expect("a pattern").fill());
    });
    let mut rate = 1.0;
    group.bench_function(id("refill"), |bench| {
        bench.iter(|| {
            rate = if rate > 2.0 { 1.0 } else { 1.001 * rate };
            system.fill(rate);
        });
    });
    group.bench_function(id("factor"), |bench| bench.iter(|| factor.refresh(&system.matrix).expect("factors")));
    group.bench_function(id("solve"), |bench| {
        bench.iter(|| factor.solve(&system.matrix, &b, &mut x).expect("a solution"));
    });
    group.finish();
}

fn sparse(c: &mut Criterion) {
    for up in [11, 101, 1001] {
        system(c, "column", System::new(1, up), Ordering::AsNumbered);
    }
    for side in [9, 33, 65] {
        system(c, "plane strain", System::new(side, side), Ordering::MinimumDegree);
    }
}

criterion_group!(benches, sparse);
criterion_main!(benches);
