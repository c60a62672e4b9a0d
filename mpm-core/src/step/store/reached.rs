//! Which nodes the soil reaches: beyond them nothing weighs and nothing moves, and a step need not look there.

use std::ops::Range;

use super::frame::Frame;
use super::strip::Strip;
use crate::real::MAX_LANES;

/// Nodes that the soil reaches, in parts of [`MAX_LANES`].
#[derive(Debug, Clone)]
pub struct Reached {
    /// Nodes of a strip.
    strip: usize,
    /// Whether a part is reached, and whether it was in a step that has yet to bring its nodes to rest.
    parts: Vec<[bool; 2]>,
    /// Runs of such nodes by strip, counted from its first.
    runs: Vec<Vec<Range<usize>>>,
    /// Whether the runs have parts that are no longer reached.
    lags: bool,
}

impl Reached {
    /// All nodes.
    pub fn all<const D: usize>(frame: &Frame<D>) -> Self {
        let parts = frame.strip / MAX_LANES;
        let mut runs = vec![Vec::with_capacity(parts.div_ceil(2)); frame.strips];
        runs.iter_mut().for_each(|runs| runs.push(0..frame.strip));
        Self { strip: frame.strip, parts: vec![[true, false]; parts * frame.strips], runs, lags: false }
    }

    /// Follows the soil. Nodes that it has left stay until [`Self::settle`].
    pub fn follow<const D: usize>(&mut self, frame: &Frame<D>, strips: &[Strip<D>]) {
        for part in &mut self.parts {
            *part = [false, part[0] || part[1]];
        }
        let (rows, across) = (if D == 1 { 1 } else { frame.reach }, strips[0].lanes() + frame.reach - 1);
        for strip in strips {
            let holds = |group: &usize| !strip.solid.range(*group).is_empty() || !strip.water.range(*group).is_empty();
            for group in (0..strip.groups()).filter(holds) {
                for row in 0..rows {
                    let first = strip.first + group * strip.lanes() + row * frame.stride[D - 1];
                    // Numbers that only pad lie beyond the last part.
                    let last = ((first + across - 1) / MAX_LANES).min(self.parts.len() - 1);
                    self.parts[first / MAX_LANES..=last].iter_mut().for_each(|part| part[0] = true);
                }
            }
        }
        self.lags = self.parts.iter().any(|[now, before]| *before && !now);
        self.find_runs();
    }

    /// Lets go of the nodes that the soil has left: they rest.
    pub fn settle(&mut self) {
        if std::mem::take(&mut self.lags) {
            self.parts.iter_mut().for_each(|part| part[1] = false);
            self.find_runs();
        }
    }

    fn find_runs(&mut self) {
        for (runs, parts) in self.runs.iter_mut().zip(self.parts.chunks(self.strip / MAX_LANES)) {
            runs.clear();
            for (i, _) in parts.iter().enumerate().filter(|(_, [now, before])| *now || *before) {
                let part = i * MAX_LANES..(i + 1) * MAX_LANES;
                match runs.last_mut() {
                    Some(run) if run.end == part.start => run.end = part.end,
                    _ => runs.push(part),
                }
            }
        }
    }

    /// Runs of them in each strip, counted from its first node: whole vectors.
    pub fn runs(&self) -> &[Vec<Range<usize>>] {
        &self.runs
    }

    /// The runs, counted from the first node of all.
    pub fn each_run(&self) -> impl Iterator<Item = Range<usize>> {
        let of = |(number, runs)| {
            let first = number * self.strip;
            <[Range<usize>]>::iter(runs).map(move |run| first + run.start..first + run.end)
        };
        self.runs.iter().map(Vec::as_slice).enumerate().flat_map(of)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let runs = self.runs.iter().map(Vec::capacity).sum::<usize>();
        self.parts.capacity() * size_of::<[bool; 2]>() + runs * size_of::<Range<usize>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::particles::{Layer, SolidPoint};

    #[test]
    fn nodes_that_the_soil_has_left_stay_for_one_step() {
        let grid = Grid::<2>::new([40, 9], 1.0);
        let frame = Frame::new(&grid, 2, 0, false);
        let mut strips: Vec<_> = (0..frame.strips).map(|i| Strip::<2>::new(&frame, i, 1)).collect();
        let mut reached = Reached::all(&frame);
        assert_eq!(reached.each_run().map(|run| run.len()).sum::<usize>(), frame.count());
        let mut around = |x: [f64; 2], reached: &mut Reached| {
            let point = SolidPoint { x, v: [0.0; 2], stress: [0.0; 4], mass: 1.0, volume: 1.0 };
            let layer = Layer::new(vec![point], &grid).unwrap();
            strips.iter_mut().for_each(|strip| strip.solid.fill(&frame, strip.first, &layer, (0, &[])));
            reached.follow(&frame, &strips);
            let cell = frame.number(&x.map(|x| x as usize));
            [0, 1, 2, 3].map(|corner| cell + frame.offset_of_corner(corner))
        };
        let holds = |reached: &Reached, nodes: [usize; 4]| {
            nodes.iter().all(|node| reached.each_run().any(|run| run.contains(node)))
        };
        let first = around([3.5, 2.5], &mut reached);
        reached.settle();
        assert!(holds(&reached, first) && reached.each_run().all(|run| run.len() <= 2 * MAX_LANES));
        let second = around([30.5, 7.5], &mut reached);
        assert!(holds(&reached, first) && holds(&reached, second));
        reached.settle();
        assert!(!holds(&reached, first) && holds(&reached, second));
        assert!(reached.each_run().is_sorted_by_key(|run| run.start));
    }
}
