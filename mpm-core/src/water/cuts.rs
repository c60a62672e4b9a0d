//! Cells that the outline of the soil cuts: how much of each face is soil, where the pressure of a cell stands, and the pieces of the
//! outline that water may pass.
//!
//! The pressure of a cell is that in its middle, though that may lie outside: with what is open of each face the flow that goes with a
//! linear pressure is then exact, whatever the outline cuts away, and that of other pressures of second order. To a piece of the
//! outline that water may pass it drops along the normal of that. Where the middle is outside or all but at such a piece, the
//! cell has the pressure just inside of it, and to its neighbours that drops over the distance to there along the line between both
//! middles (Gibou et al., J. Comput. Phys. 176 (2002) 205, doi:10.1006/jcph.2001.6977).

use serde::{Deserialize, Serialize};

use crate::dimension::in_two;
use crate::grid::Grid;
use crate::particles::{Layer, SolidPoint};
use crate::real::array_of;
use crate::scene::{FaceLoad, Fields, Piece, Side};
use crate::seeding::{Beside, between, numbered_pieces, of_square, passes, pieces};
use crate::soils::Soils;
use crate::water::DRAINED_SURFACE;

/// A middle nearer to the outline than this, in cells, has the pressure there.
const NEAREST: f64 = 0.2;
/// How far inside that is, in cells.
const NEXT_TO: f64 = 0.05;

/// A piece of the outline, and the cell behind it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Opening {
    /// The cell.
    pub cell: u32,
    /// The piece, m.
    pub piece: Piece,
    /// From where the water of the cell weighs to the piece, m.
    pub away: [f64; 2],
    /// Whether the pressure of the cell is that at the piece.
    pub held: bool,
    /// Its area over the distance along its normal, times the conductivity along that over that of the water; m for 1 m.
    pub conducts: f64,
    /// Which of the loads of the scene may put water before it, a bit each.
    pub water: u64,
}

/// A corner of the outline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Corner {
    place: [f64; 2],
    id: u32,
    start: [f64; 2],
    water: u64,
}

/// The cells of a scene as its outline cuts them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Cuts {
    /// Corners of the soil at t = 0 (m), the particle that each goes with, where that was, and the water before the piece that
    /// begins there.
    corners: Vec<Corner>,
    /// The water before the ends of a column, the lower one first.
    ends: Option<[u64; 2]>,
    /// Width of a periodic mesh, over whose seam the soil goes on, m.
    seam: Option<f64>,
    /// Share of each face that is soil, for each axis.
    open: [Vec<f64>; 2],
    /// Where the outline passes the lines through the middle of each cell that has its pressure there, from the middle, in cells.
    passed: Vec<Option<[f64; 2]>>,
    /// Which of these have it now, as water may pass the outline there.
    open_to: Vec<bool>,
    /// Share of each cell that is soil with particles there, and its centroid in cell coordinates, where the water weighs.
    share: Vec<f64>,
    at: Vec<[f64; 2]>,
    /// The outline, piece by piece.
    pub openings: Vec<Opening>,
}

impl Cuts {
    /// Those of a scene with an outline, or with water before its faces, whose particles stand where they were seeded.
    pub fn new<const D: usize>(scene: &Fields, solid: &Layer<SolidPoint<D>, D>) -> Self {
        if scene.outline.is_none() && !scene.has_water_outside() {
            return Self::default();
        }
        let water = |piece: &Piece| {
            let before = |load: &FaceLoad| load.is_water() && scene.bears(load, piece);
            scene.loads.iter().rev().fold(0, |bits, load| 2 * bits + u64::from(before(load)))
        };
        if D == 1 {
            let end = |y: f64, outward| water(&Piece { middle: [0.0, y], outward: [0.0, outward] });
            return Self { ends: Some([end(0.0, -1.0), end(scene.height, 1.0)]), ..Self::default() };
        }
        let mut places = vec![[0.0; 2]; solid.points.len()];
        solid.points.iter().zip(&solid.ids).for_each(|(point, id)| places[*id as usize] = in_two(&point.x));
        let beside = Beside::new(places.clone(), scene.spacing());
        let corner = |piece: Piece| {
            let [x, y] = piece.outward;
            let place = [piece.middle[0] + 0.5 * y, piece.middle[1] - 0.5 * x];
            let corner = |id: usize| Corner { place, id: id as u32, start: places[id], water: water(&piece) };
            beside.find(&piece.middle).map(corner)
        };
        let outline = scene.outline_or_box();
        let corners = pieces(&outline, scene.spacing()).filter_map(corner).collect();
        Self { corners, seam: scene.periodic.then_some(scene.width), ..Self::default() }
    }

    /// Whether the outline is followed piece by piece, and not by faces of cells.
    pub fn have_openings(&self) -> bool {
        self.are_known() || self.ends.is_some()
    }

    /// Whether there are any.
    pub fn are_known(&self) -> bool {
        !self.corners.is_empty()
    }

    /// Looks at the soil again: the outline goes with its particles.
    pub fn follow<const D: usize>(&mut self, grid: &Grid<D>, solid: &Layer<SolidPoint<D>, D>, soils: &Soils) {
        if let Some(ends) = self.ends {
            let cells = || (0..grid.cell_count()).filter(|cell| !solid.range(*cell).is_empty());
            self.openings.clear();
            for (cell, (water, sign)) in
                cells().next().into_iter().chain(cells().next_back()).zip(ends.into_iter().zip([-1.0, 1.0]))
            {
                let away = [0.0, 0.5 * sign * grid.size];
                let [_, y, _] = soils.kind_of(solid.ids[solid.range(cell).start]).conductivity;
                let middle = [0.0, (cell as f64 + 0.5) * grid.size + away[1]];
                let piece = Piece { middle, outward: [0.0, sign] };
                let conducts = DRAINED_SURFACE * y;
                self.openings.push(Opening { cell: cell as u32, piece, away, held: false, conducts, water });
            }
        }
        if !self.are_known() {
            return;
        }
        let mut moved = vec![[0.0; 2]; solid.points.len()];
        solid.points.iter().zip(&solid.ids).for_each(|(point, id)| moved[*id as usize] = in_two(&point.x));
        let place = |corner: &Corner| {
            let now = moved[corner.id as usize];
            // Along a periodic mesh its soil may go round as often as it will, and leave the outline the same.
            let goes = |d: usize| d == 1 || self.seam.is_none();
            array_of::<_, 2, _>(|d| corner.place[d] + if goes(d) { now[d] - corner.start[d] } else { 0.0 })
        };
        let polygon: Vec<[f64; 2]> = self.corners.iter().map(place).collect();
        let (size, cells) = (grid.size, [grid.cells[0], grid.cells[D - 1]]);
        (self.share, self.at) = (vec![0.0; grid.cell_count()], vec![[0.5; 2]; grid.cell_count()]);
        for row in 0..cells[1] {
            let strip = between(&polygon, 1, row as f64 * size, (row + 1) as f64 * size);
            for column in (0..cells[0]).filter(|_| !strip.is_empty()) {
                if let Some(part) = of_square(&strip, [column, row], size) {
                    let cell = column + row * cells[0];
                    let volume: f64 = solid.points[solid.range(cell)].iter().map(|point| point.volume).sum();
                    self.share[cell] = part.area.min(volume / grid.thickness(part.centroid[0])) / (size * size);
                    self.at[cell] = array_of::<_, 2, _>(|d| part.centroid[d] / size - [column, row][d] as f64);
                }
            }
        }
        let (mut passed, mut outside) = (vec![[f64::INFINITY; 2]; grid.cell_count()], vec![false; grid.cell_count()]);
        for axis in 0..2 {
            self.open[axis] = vec![0.0; grid.face_count(axis.min(D - 1))];
            // Seen along the other axis the polygon is turned over.
            let turned: Vec<[f64; 2]> = polygon.iter().map(|x| if axis == 0 { *x } else { [x[1], x[0]] }).collect();
            for line in 0..=cells[axis] {
                let place = line as f64 * size;
                let sides = match self.seam {
                    Some(width) if axis == 0 && (line == 0 || line == cells[0]) => [width.next_down(), 0.0],
                    _ => [place.next_down(), place],
                };
                let soil = inside_on_both_sides(&turned, sides);
                for across in 0..cells[1 - axis] {
                    let [low, high] = [across, across + 1].map(|i| i as f64 * size);
                    let share: f64 = soil.iter().map(|[a, b]| (b.min(high) - a.max(low)).max(0.0)).sum();
                    let mut position = [0; D];
                    (position[axis.min(D - 1)], position[(1 - axis).min(D - 1)]) = (line, across);
                    self.open[axis][grid.face(axis.min(D - 1), &position)] = share / size;
                }
            }
            for line in 0..cells[axis] {
                let heights: Vec<f64> = passes(&turned, (line as f64 + 0.5) * size).map(|y| y / size).collect();
                for across in 0..cells[1 - axis] {
                    let cell = if axis == 0 { line + across * cells[0] } else { across + line * cells[0] };
                    let away = || heights.iter().map(|y| y - across as f64 - 0.5);
                    let nearest = away().reduce(|a, b| if a.abs() <= b.abs() { a } else { b });
                    passed[cell][1 - axis] = nearest.unwrap_or(f64::INFINITY);
                    outside[cell] = away().filter(|y| *y > 0.0).count() % 2 == 0;
                }
            }
        }
        let of = |(cell, share): (usize, &f64)| {
            let beside = outside[cell] || passed[cell].iter().any(|away| away.abs() < NEAREST);
            let [x, y] = passed[cell].map(|away| away.abs().max(1e-9));
            let inwards = if outside[cell] { NEXT_TO } else { -NEXT_TO } * (1.0 / x).hypot(1.0 / y);
            let within = passed[cell].map(|away| if away.abs() < 1.0 { away * (1.0 + inwards) } else { 0.0 });
            (*share > 0.0 && beside).then_some(within)
        };
        self.passed = self.share.iter().enumerate().map(of).collect();
        self.find_openings(grid, solid, soils, &polygon);
    }

    fn find_openings<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        solid: &Layer<SolidPoint<D>, D>,
        soils: &Soils,
        polygon: &[[f64; 2]],
    ) {
        let (size, across) = (grid.size, grid.cells[0]);
        // Cells with particles have a pressure; a piece of the outline in another one is that of the nearest.
        let owners: Vec<usize> = (0..grid.cell_count()).filter(|cell| !solid.range(*cell).is_empty()).collect();
        let place = |cell: usize, at: [f64; 2]| {
            array_of::<_, 2, _>(|d| ([cell % across, cell / across][d] as f64 + at[d]) * size)
        };
        let beside = Beside::new(owners.iter().map(|cell| place(*cell, [0.5; 2])).collect(), size);
        self.openings.clear();
        let on_seam = |piece: &Piece| {
            let ends = self.seam.map(|width| [0.0, width]);
            let on = |end: f64| piece.outward[1] == 0.0 && (piece.middle[0] - end).abs() < 1e-9 * size;
            ends.is_some_and(|ends| ends.into_iter().any(on))
        };
        for (edge, piece) in numbered_pieces(polygon, size).filter(|(_, piece)| !on_seam(piece)) {
            let water = self.corners[edge].water;
            let length = piece.outward[0].hypot(piece.outward[1]);
            let normal = piece.outward.map(|n| n / length);
            let inwards = array_of::<_, 2, _>(|d| piece.middle[d] - 1e-6 * size * normal[d]);
            let own = inwards.map(|x| (x / size).floor().max(0.0) as usize);
            let own = own[0] + own[1] * across;
            let own = Some(own).filter(|own| owners.binary_search(own).is_ok());
            let Some(cell) = own.or_else(|| beside.find(&piece.middle).map(|i| owners[i])) else { continue };
            let from = |at| array_of::<_, 2, _>(|d| piece.middle[d] - place(cell, at)[d]);
            let (away, middle) = (from(self.at[cell]), from([0.5; 2]));
            let held = self.passed[cell].is_some();
            let along = (middle[0] * normal[0] + middle[1] * normal[1]).max(0.5 * NEAREST * size);
            let distance = if held { NEXT_TO * size } else { along };
            let first = solid.range(cell).start;
            let [x, y, xy] = soils.kind_of(solid.ids[first]).conductivity;
            let along = x * normal[0].powi(2) + y * normal[1].powi(2) + 2.0 * xy * normal[0] * normal[1];
            let conducts = along * length / distance;
            self.openings.push(Opening { cell: cell as u32, piece, away, held, conducts, water });
        }
    }

    /// Notes where water may pass the outline, with these sides drained.
    pub fn open(&mut self, drained: &[bool; 4]) {
        self.open_to = vec![false; self.share.len()];
        for opening in self.openings.iter().filter(|_| !self.share.is_empty()) {
            self.open_to[opening.cell as usize] |= opening.water != 0 || opening.looks_to(drained);
        }
    }

    /// Share of a face that is soil, times the edge of a cell over the distance of the pressures beside it, and that edge over how
    /// far apart the water on both sides weighs; of a face of the mesh between two cells.
    pub fn face<const D: usize>(&self, grid: &Grid<D>, axis: usize, face: &[usize; D], cells: [usize; 2]) -> [f64; 2] {
        if !self.are_known() {
            return [1.0, 1.0];
        }
        let apart = 1.0 + self.at[cells[1]][axis] - self.at[cells[0]][axis];
        let [low, high] = cells.map(|cell| self.passed[cell].filter(|_| self.open_to[cell]).map_or(0.0, |at| at[axis]));
        [self.open[axis][grid.face(axis, face)] / (1.0 + high - low).max(NEAREST), 1.0 / apart]
    }

    /// What is left of the stiffness of the water in a cell so that an explicit step is as stable there as in a full one inside, by
    /// Gershgorin's circles: its neighbours conduct to both sides of the diagonal, openings to one. `faces` are the sums of both over
    /// those of a full face.
    pub fn softness(&self, cell: usize, [inner, outer]: [f64; 2]) -> f64 {
        /// Twice the four faces of a full cell.
        const FULL: f64 = 8.0;
        (FULL * self.share.get(cell).copied().unwrap_or(1.0) / (2.0 * inner + outer).max(f64::MIN_POSITIVE)).min(1.0)
    }
}

impl Opening {
    /// Whether it faces one of the sides for which `open` holds.
    pub fn looks_to(&self, open: &[bool; 4]) -> bool {
        Side::ALL.iter().any(|side| open[*side as usize] && self.piece.looks_to(*side))
    }
}

/// Where a face lies in a polygon on both of its sides x (m), from where to where, m.
fn inside_on_both_sides(polygon: &[[f64; 2]], sides: [f64; 2]) -> Vec<[f64; 2]> {
    let spans = |x: f64| {
        let mut heights: Vec<f64> = passes(polygon, x).collect();
        heights.sort_by(f64::total_cmp);
        heights.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
    };
    let [left, right] = sides.map(spans);
    let both = |a: &[f64; 2]| {
        let a = *a;
        left.iter().map(move |b| [a[0].max(b[0]), a[1].min(b[1])]).filter(|[low, high]| low < high).collect::<Vec<_>>()
    };
    right.iter().flat_map(both).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_along_a_wall_is_soil_where_both_sides_are() {
        // A wall stands on the right half of a floor.
        let wall = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [1.0, 0.5], [0.0, 0.5]];
        let at = |x: f64| [x.next_down(), x];
        assert_eq!(inside_on_both_sides(&wall, at(1.0)), [[0.0, 0.5]]);
        assert_eq!(inside_on_both_sides(&wall, at(1.5)), [[0.0, 2.0]]);
        assert!(inside_on_both_sides(&wall, at(2.0)).is_empty());
    }
}
