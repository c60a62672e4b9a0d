//! Where water meets the outside: sides that are fed, and the outline of the soil where it seeps out.

use super::flow::{Kind, Linear, Medium, Now};
use super::soil::SoilMap;
use super::{Standing, Surroundings};
use crate::dimension::in_two;
use crate::grid::Grid;
use crate::order::sort_by_number;
use crate::scene::{Course, Feed};

/// What is outside a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outside {
    /// Air at zero pressure: water leaves and none enters.
    Air,
    /// Water at rest; its pressure at the bottom of the face (sideways) or on the face (up and down), Pa.
    Pond(f64),
    /// A given inflow, m3/s.
    Inflow(f64),
}

/// A face of the soil to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The cell of soil.
    pub cell: u32,
    /// Axis that the face is normal to.
    pub axis: u8,
    /// Whether the outside lies in the positive direction.
    pub upper: bool,
    /// Share of a whole face.
    pub open: f64,
    /// Its conductivity over that of the medium.
    pub ratio: f64,
    /// Where a face to the side begins, above the bottom of the cell, in cells.
    pub from: f64,
    /// Distance from the centre of the cell to the outside, in cells.
    pub distance: f64,
    /// What is there.
    pub outside: Outside,
}

/// Less of a face than this is round-off: a level at the very edge of its cell.
const LEAST_FED: f64 = 1e-9;

/// A face that rain falls on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rained {
    /// Number of the edge through which water comes out there.
    pub way_out: u32,
    /// Number of the edge through which rain comes in.
    pub way_in: u32,
    /// What runs off whatever the soil holds, m3/s: water that nothing presses enters at k at most.
    pub excess: f64,
}

/// A number for each side (left, right, bottom, top) and each cell along it; no list for a side that has none.
pub type Along = [Vec<f64>; 4];

impl Edge {
    /// The side of the mesh that its outside lies towards: left, right, bottom, top.
    pub fn side(&self, dimensions: usize) -> usize {
        2 * (self.axis as usize + 2 - dimensions) + usize::from(self.upper)
    }

    /// Of a flow that would pass it outwards, what does: a seepage face lets none in, whatever draws it.
    #[inline]
    pub fn lets_out(&self, flow: f64) -> f64 {
        if self.outside == Outside::Air { flow.max(0.0) } else { flow }
    }
}

/// The place of an edge along its side of the mesh.
pub fn along_side<const D: usize>(grid: &Grid<D>, edge: &Edge) -> usize {
    let position = grid.cell_position(edge.cell as usize);
    (0..D).filter(|d| *d != edge.axis as usize).map(|d| position[d]).sum()
}

/// What to add to lengths that were found, so that they are the exact ones; where nothing was found, its neighbour has it.
pub fn beyond(found: &[f64], exact: &[f64]) -> Vec<f64> {
    /// A length below this is round-off, in cells.
    const NOTHING: f64 = 1e-12;
    let mut beyond = vec![0.0; found.len()];
    for (i, (f, e)) in found.iter().zip(exact).enumerate() {
        let nearest = (0..found.len()).filter(|j| found[*j] > 0.0).min_by_key(|j| i.abs_diff(*j));
        if let Some(j) = nearest.filter(|_| (e - f).abs() > NOTHING) {
            beyond[j] += e - f;
        }
    }
    beyond
}

/// Distance from the centre of a cell to the outline, in cells: half a cell from a full one to a void, less where the
/// cells beside the outline are filled in part.
fn to_outline(share: f64, beyond: f64) -> f64 {
    (share + beyond - 0.5).clamp(0.25, 1.0)
}

/// Share of a face below which an opening is round-off of what the soil covers: a wall with one would let air in, and no water
/// would stand on it.
const LEAST_OPENING: f64 = 1e-9;

/// All edges of the soil, of which the best conduct as the `largest`, and which of them rain falls on. `face_area` in m2;
/// `beyond` is what feeds with a velocity meet beyond what the map shows, in cells.
pub fn edges<const D: usize>(
    grid: &Grid<D>,
    (soil, largest): (&SoilMap<D>, f64),
    medium: &Medium<D>,
    around: &Surroundings,
    face_area: f64,
    beyond: &Along,
) -> (Vec<Edge>, Vec<Rained>) {
    let Surroundings { open: sides, mut feeds, ref heads, periodic, ref standing } = *around;
    // Rain falls on all faces that point upwards; so does no other feed.
    let rain = match feeds[3] {
        Some(Feed::Velocity { speed, .. }) => feeds[3].take().map(|_| speed),
        _ => None,
    };
    let more = |side: usize, along: usize| beyond[side].get(along).copied().unwrap_or(0.0);
    let mut list = Vec::new();
    for (cell, position) in grid.walk() {
        if !soil.is_soil(cell) {
            continue;
        }
        let mut stride = 1;
        for axis in 0..D {
            let cover = |upper: bool| {
                let mut at = position;
                at[axis] += usize::from(upper);
                soil.cover[axis][grid.face(axis, &at)]
            };
            let own = [cover(false)[1], cover(true)[0]];
            for upper in [false, true] {
                let at_side = if upper { position[axis] + 1 == grid.cells[axis] } else { position[axis] == 0 };
                let here = own[usize::from(upper)];
                let other = own[usize::from(!upper)];
                let side = 2 * (axis + 2 - D) + usize::from(upper);
                let vertical = axis == D - 1;
                // The middle of the face, and the level of the water that stands there, if any.
                let mut middle = position.map(|i| (i as f64 + 0.5) * medium.size);
                middle[axis] += if upper { 0.5 } else { -0.5 } * medium.size;
                let before = |water: &&Standing| water.is_before(side, at_side, &in_two(&middle));
                let level = standing.iter().filter(before).map(|water| Feed::Head(water.level)).next();
                let edge = |open, from: f64, distance, outside| Edge {
                    cell: cell as u32,
                    axis: axis as u8,
                    upper,
                    open,
                    ratio: soil.halves.at(cell, axis, upper) / largest,
                    // Soil lies at the bottom of its cell: what is open to the side lies above what is not.
                    from: if vertical { 0.0 } else { from },
                    distance,
                    outside,
                };
                // The outline runs through the cell where the soil ends before the face.
                let slope = (other - here).max(0.0);
                if at_side {
                    if periodic && axis == 0 && D == 2 {
                        continue;
                    }
                    let along: usize = (0..D).filter(|d| *d != axis).map(|d| position[d]).sum();
                    let opens = here > 0.0 && (sides[side] || (side == 3 && rain.is_some()));
                    let feed = match (feeds[side], &heads[side]) {
                        (Some(Feed::Head(_)), Course::Times(_)) => {
                            Some(Feed::Head(heads[side].at(in_two(&middle)[0], 0.0)))
                        }
                        (feed, _) => feed,
                    };
                    let fed = feed.or(level).filter(|_| here > 0.0).and_then(|feed| {
                        fed(medium, &feed, (axis, upper), &position, (here, more(side, along)), face_area)
                    });
                    if let Some((outside, open)) = fed {
                        list.push(edge(open, 0.0, 0.5, outside));
                        // Water at rest stands against the lower part of its last face.
                        if opens && here - open > LEAST_FED && matches!(outside, Outside::Pond(_)) {
                            list.push(edge(here - open, open, 0.5, Outside::Air));
                        }
                        continue;
                    }
                    if opens {
                        list.push(edge(here, 0.0, 0.5, Outside::Air));
                    }
                    if slope > LEAST_OPENING {
                        list.push(edge(slope, here, to_outline(soil.share[cell], 0.0), Outside::Air));
                    }
                    continue;
                }
                let next = if upper { cell + stride } else { cell - stride };
                let beyond = cover(upper)[usize::from(upper)];
                let through = if soil.is_soil(next) { here.min(beyond) } else { 0.0 };
                let open = here - through + slope;
                if open > LEAST_OPENING {
                    let distance = to_outline(soil.share[cell], soil.share[next]);
                    let wet =
                        level.and_then(|feed| fed(medium, &feed, (axis, upper), &position, (open, 0.0), face_area));
                    if let Some((outside, below)) = wet {
                        list.push(edge(below, through, distance, outside));
                    }
                    let dry = open - wet.map_or(0.0, |(_, below)| below);
                    if dry > LEAST_OPENING {
                        list.push(edge(dry, through + open - dry, distance, Outside::Air));
                    }
                }
            }
            stride *= grid.cells[axis];
        }
    }
    let rained = rain.map_or(Vec::new(), |speed| {
        // Without gravity nothing draws it in: it is pressed in.
        // What draws rain into unsaturated soil is found with its suction.
        let falls = medium.rise() > 0.0 && medium.retention.is_none();
        let most = if falls { medium.conductance * medium.rise() * medium.size } else { f64::INFINITY };
        rain_on(grid, &mut list, (speed * face_area, most), |x| more(3, x))
    });
    (list, rained)
}

/// Lets rain fall on the faces that point upwards: `whole` (m3/s) on a whole face, of which `most` may enter the soil that conducts best. `more` is what the width
/// of a column of cells is beyond what the faces show, in cells.
fn rain_on<const D: usize>(
    grid: &Grid<D>,
    list: &mut Vec<Edge>,
    (whole, most): (f64, f64),
    more: impl Fn(usize) -> f64,
) -> Vec<Rained> {
    let columns = grid.cell_count() / grid.cells[D - 1];
    let column = |edge: &Edge| edge.cell as usize % columns;
    let looks_up = |edge: &Edge| edge.axis as usize == D - 1 && edge.upper && edge.outside == Outside::Air;
    let mut faces: Vec<u32> = (0..list.len() as u32).filter(|i| looks_up(&list[*i as usize])).collect();
    let from_above = |face: &u32| {
        let edge = &list[*face as usize];
        (column(edge) * grid.cell_count()) as f64 - f64::from(edge.cell)
    };
    sort_by_number(&mut faces, from_above);
    let mut rained = Vec::new();
    let mut feeds = Vec::new();
    for faces in faces.chunk_by(|a, b| column(&list[*a as usize]) == column(&list[*b as usize])) {
        // From the top down: soil that hangs over other soil keeps the rain off it.
        let mut room: f64 = 1.0;
        let mut widths: Vec<f64> = Vec::new();
        for face in faces {
            widths.push(list[*face as usize].open.min(room));
            room -= widths[widths.len() - 1];
        }
        // What the boxes of the particles have wrong is put right at the foot of the column.
        let mut rest = more(column(&list[faces[0] as usize]));
        for width in widths.iter_mut().rev() {
            let right = (*width + rest).max(0.0);
            rest -= right - *width;
            *width = right;
        }
        for (face, open) in faces.iter().zip(widths).filter(|(_, open)| *open > 0.0) {
            let way_in = (list.len() + feeds.len()) as u32;
            let most = most * list[*face as usize].ratio;
            rained.push(Rained { way_out: *face, way_in, excess: (whole - most).max(0.0) * open });
            feeds.push(Edge { outside: Outside::Inflow(whole.min(most) * open), open, ..list[*face as usize] });
        }
    }
    list.extend(feeds);
    rained
}

/// What a feed puts outside a face of which `here` is soil, and `more` beyond what the map shows, and the share of the face
/// that it meets; nothing above its level.
fn fed<const D: usize>(
    medium: &Medium<D>,
    feed: &Feed,
    (axis, upper): (usize, bool),
    position: &[usize; D],
    (here, more): (f64, f64),
    face_area: f64,
) -> Option<(Outside, f64)> {
    let vertical = axis == D - 1;
    let lattice = position[D - 1] + usize::from(vertical && upper);
    let height = lattice as f64 * medium.size;
    let below = |level: f64| if vertical { 1.0 } else { ((level - height) / medium.size).min(1.0) };
    match *feed {
        Feed::Head(head) => {
            let g = medium.rise();
            let pressure = if g > 0.0 { g * (head - height) } else { medium.unit_weight * head };
            let open = if g > 0.0 { below(head).min(here) } else { here };
            // A level below the soil draws water out of soil that holds some by suction.
            let wets = pressure > 0.0 || (vertical && medium.retention.is_some());
            (open > LEAST_FED).then_some((Outside::Pond(pressure), open)).filter(|_| wets)
        }
        Feed::Velocity { speed, height } => {
            let open = (below(height).min(here) + more).max(0.0);
            (open > LEAST_FED).then_some((Outside::Inflow(speed * face_area * open), open))
        }
    }
}

impl<const D: usize> Medium<D> {
    /// The flow out through an edge during a step of `dt` (s); the lower factor is that of the cell's pressure.
    ///
    /// `stands` says whether a full cell has its level at its own upper edge.
    pub fn leak(&self, edge: &Edge, now: Now, soil: &SoilMap<D>, stands: bool, start: f64, dt: f64) -> Linear {
        let cell = edge.cell as usize;
        let kind = now.kind[cell];
        let up = edge.axis as usize == D - 1 && self.rise() > 0.0;
        let conductance = self.conductance * edge.ratio;
        let t = conductance / edge.distance;
        let (half, p) = (0.5 * self.rise() * self.size, now.pressure[cell]);
        let outwards = if edge.upper { 1.0 } else { -1.0 };
        match edge.outside {
            Outside::Inflow(flow) => Linear { fixed: -flow, ..Linear::default() },
            Outside::Air if !kind.unknown() => {
                // Nothing but gravity moves water that runs through.
                let along = outwards * self.weight[edge.axis as usize] * self.size;
                let falls = if kind == Kind::Loose { along.max(0.0) } else { 0.0 };
                Linear { fixed: conductance * edge.open * falls * now.wet[cell], ..Linear::default() }
            }
            Outside::Air if up && edge.upper => {
                // Out through the surface of a full cell, once its pressure is above that of a level there.
                let top = if stands { self.standing_pressure(1.0, soil.share[cell]) } else { half };
                if kind == Kind::Full && p > top {
                    Linear { low: t * edge.open, fixed: -t * edge.open * top, high: 0.0 }
                } else {
                    Linear::default()
                }
            }
            Outside::Air if up => {
                if p + half > 0.0 {
                    Linear { low: t * edge.open, fixed: t * edge.open * half, high: 0.0 }
                } else {
                    Linear::default()
                }
            }
            Outside::Air => {
                // Pressure at the lower end of what is open.
                let foot = half - 2.0 * half * edge.from;
                let wet = if half > 0.0 { self.secant(p + foot, 0.0, edge.open) } else { edge.open };
                if p + foot > 0.0 {
                    Linear { low: t * wet, fixed: t * wet * foot, high: 0.0 }
                } else {
                    Linear::default()
                }
            }
            Outside::Pond(outside) if kind.unknown() => {
                if up {
                    let fixed = -t * edge.open * (outside + outwards * half);
                    Linear { low: t * edge.open, fixed, high: 0.0 }
                } else {
                    let wet = if half > 0.0 { self.secant(p + half, outside, edge.open) } else { edge.open };
                    Linear { low: t * wet, fixed: -t * wet * (outside - half), high: 0.0 }
                }
            }
            Outside::Pond(outside) => {
                // A front in its first cell, x^2 growing with k p/(gamma_w n): exact from any start.
                let mean = if up { outside } else { self.mean_pressure(outside, edge.open) };
                let pores = soil.pores[cell];
                let reach = 2.0 * conductance * edge.open * mean * dt / pores;
                let enters = ((start * start + reach).sqrt() - start) * pores / dt;
                let along = -outwards * self.weight[edge.axis as usize] * self.size;
                let falls = if up { conductance * edge.open * along.max(0.0) } else { 0.0 };
                Linear { fixed: -enters - falls, ..Linear::default() }
            }
        }
    }

    /// Mean pressure over a face of which `open` is soil, for one at its bottom, Pa.
    fn mean_pressure(&self, bottom: f64, open: f64) -> f64 {
        if self.rise() > 0.0 { self.wet_integral(bottom, open) / open } else { bottom }
    }
}

#[cfg(test)]
mod tests {
    use super::super::NO_HEADS;
    use super::*;
    use crate::particles::{Layer, SolidPoint, even_positions};
    use crate::soils::Soils;

    const H: f64 = 0.5;
    const G: f64 = 10.0;
    const MEDIUM: Medium<2> = Medium {
        conductance: 2.0,
        size: H,
        cell_volume: H * H,
        weight: [0.0, -G],
        unit_weight: G,
        porosity: 0.3,
        retention: None,
    };

    /// A quarter of a cell of soil around a place in cells.
    fn at(x: [f64; 2]) -> SolidPoint<2> {
        SolidPoint { x: x.map(|x| x * H), v: [0.0; 2], stress: [0.0; 4], mass: 1.0, volume: 0.25 * H * H }
    }

    /// Flow out of a cell that is soil all over, with its level so high above its bottom (cells), through an edge that is
    /// open from `from` (cells) up.
    fn seeps(from: f64, level: f64) -> f64 {
        let grid = Grid::new([2, 1], H);
        let solid = Layer::new(even_positions([1, 1], 2).map(at).collect(), &grid).unwrap();
        let soil = SoilMap::new(&grid, &solid, H, 2, &Soils::one(0.0));
        let (open, outside) = (1.0 - from, Outside::Air);
        let edge = Edge { cell: 0, axis: 0, upper: true, open, ratio: 1.0, from, distance: 0.5, outside };
        let wet = level.min(1.0);
        let kind = if level < 1.0 { Kind::Standing } else { Kind::Full };
        let pressure = [MEDIUM.standing_pressure(1.0, 1.0) + G * H * (level - 1.0), 0.0];
        let now = Now { kind: &[kind, Kind::Void], pressure: &pressure, wet: &[wet, 0.0] };
        MEDIUM.leak(&edge, now, &soil, true, wet, 1.0).at(pressure[0], 0.0)
    }

    #[test]
    fn an_opening_above_the_bottom_lets_out_what_stands_above_its_foot() {
        for from in [0.0, 0.25, 0.5, 0.75] {
            for level in [0.0, 0.2, 0.5, 0.7, 0.9, 1.0, 1.3] {
                let out = seeps(from, level);
                if level <= from {
                    assert_eq!(out, 0.0, "from {from}, level {level}");
                } else {
                    // Half a cell away: the pressure head above the foot, over the part of the opening that is wet.
                    let (above, open) = (level - from, 1.0 - from);
                    let integral = if above < open { 0.5 * above * above } else { open * (above - 0.5 * open) };
                    let flow = MEDIUM.conductance / 0.5 * G * H * integral;
                    assert!((out / flow - 1.0).abs() < 1e-12, "from {from}, level {level}: {out}, expected {flow}");
                }
            }
        }
    }

    #[test]
    fn a_step_of_the_soil_is_open_from_its_own_top_up() {
        // Two cells side by side, the right one half as high: the left one is open to the side from half its height on.
        let grid = Grid::new([3, 2], H);
        let points = even_positions([2, 1], 2).filter(|x| x[0] < 1.0 || x[1] < 0.5).map(at).collect();
        let solid = Layer::new(points, &grid).unwrap();
        let soil = SoilMap::new(&grid, &solid, H, 2, &Soils::one(0.0));
        let around =
            |feeds| Surroundings { open: [false; 4], feeds, heads: NO_HEADS, periodic: false, standing: Vec::new() };
        let (list, _) = edges(&grid, (&soil, 1.0), &MEDIUM, &around([None; 4]), H, &Along::default());
        let sideways: Vec<_> = list.iter().filter(|e| e.axis == 0).map(|e| (e.cell, e.upper, e.open, e.from)).collect();
        assert_eq!(sideways, [(0, true, 0.5, 0.5), (1, true, 0.5, 0.0)]);
        // A feed on the wall meets soil only, and nothing above its level.
        let fed = |head: f64| {
            let feeds = [Some(Feed::Head(head)), None, None, None];
            edges(&grid, (&soil, 1.0), &MEDIUM, &around(feeds), H, &Along::default())
                .0
                .iter()
                .filter(|e| e.outside != Outside::Air)
                .count()
        };
        assert_eq!([fed(0.3), fed(5.0), fed(-0.1)], [1, 1, 0]);
    }
}
