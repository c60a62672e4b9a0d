//! Particles of a strip of cells, so many cells side by side: a block holds one particle of each.

use pulp::Simd;
use pulp::bytemuck::Zeroable;

use super::frame::Frame;
use crate::particles::{Layer, SolidPoint, WaterPoint};
use crate::real::{numbers, numbers_mut};

/// One block in so many is kept in reserve.
const SPARE: usize = 8;
/// A lane without a particle.
const EMPTY: u32 = u32::MAX;

/// A particle as C numbers, the first two of them its position.
pub trait Record<const C: usize>: Copy {
    /// Its numbers.
    fn pack(&self) -> [f64; C];
    /// From its numbers.
    fn unpack(numbers: &[f64; C]) -> Self;
}

/// Numbers of a solid particle.
pub const SOLID: usize = 10;
/// Numbers of a water particle.
pub const WATER: usize = 7;
/// Which of them is its mass, kg.
pub const WATER_MASS: usize = 4;

impl Record<SOLID> for SolidPoint<2, 4> {
    fn pack(&self) -> [f64; SOLID] {
        let ([x, y], [u, v], [xx, yy, zz, xy]) = (self.x, self.v, self.stress);
        [x, y, u, v, xx, yy, zz, xy, self.mass, self.volume]
    }

    fn unpack(&[x, y, u, v, xx, yy, zz, xy, mass, volume]: &[f64; SOLID]) -> Self {
        Self { x: [x, y], v: [u, v], stress: [xx, yy, zz, xy], mass, volume }
    }
}

impl Record<WATER> for WaterPoint<2> {
    fn pack(&self) -> [f64; WATER] {
        [self.x[0], self.x[1], self.v[0], self.v[1], self.mass, self.volume, self.pressure]
    }

    fn unpack(&[x, y, u, v, mass, volume, pressure]: &[f64; WATER]) -> Self {
        Self { x: [x, y], v: [u, v], mass, volume, pressure }
    }
}

/// One particle of each of so many cells side by side, as C vectors: whole lines of the cache, so that no vector lies
/// across two of them.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Block<V: Simd, const C: usize>(pub [V::f64s; C]);

/// The particles of one layer in a strip.
#[derive(Debug, Clone)]
pub struct Blocks<V: Simd, const C: usize> {
    /// Nothing weighs what an empty lane holds.
    pub blocks: Vec<Block<V, C>>,
    /// First block of each group of cells, and the total at the end.
    pub start: Vec<u32>,
    /// Number that each particle was seeded with, lane by lane.
    pub ids: Vec<u32>,
}

/// A particle on its way to another cell.
#[derive(Debug, Clone, Copy)]
pub struct Mover<const C: usize> {
    /// Cell it leaves.
    pub from: usize,
    /// Its place among the particles of that cell.
    pub slot: usize,
    /// Cell it enters; none outside the mesh.
    pub to: Option<usize>,
    record: [f64; C],
    id: u32,
}

impl<const C: usize> Mover<C> {
    /// Whether its position is a number.
    pub fn is_somewhere(&self) -> bool {
        self.record[..2].iter().all(|x| x.is_finite())
    }

    /// One of its numbers.
    pub fn number(&self, c: usize) -> f64 {
        self.record[c]
    }
}

impl<V: Simd, const C: usize> Blocks<V, C> {
    /// No particles in so many groups.
    pub fn new(groups: usize) -> Self {
        Self { blocks: Vec::new(), start: vec![0; groups + 1], ids: Vec::new() }
    }

    /// Takes the particles of the strip from `first` on out of a layer, in its order.
    pub fn fill<P: Record<C>>(&mut self, frame: &Frame, first: usize, layer: &Layer<P, 2>) {
        let lanes = V::F64_LANES;
        let groups = self.start.len() - 1;
        let range = |group: usize, lane: usize| range(frame, first + group * lanes + lane, layer);
        let slots = |group: usize| (0..lanes).map(|lane| range(group, lane).len()).max().unwrap_or(0);
        let count = (0..groups).map(slots).sum::<usize>();
        self.blocks.clear();
        self.ids.clear();
        // Some more for particles that come from other cells.
        self.blocks.reserve_exact(count + count / SPARE);
        self.ids.reserve_exact((count + count / SPARE) * lanes);
        for group in 0..groups {
            self.start[group] = self.blocks.len() as u32;
            for slot in 0..slots(group) {
                self.blocks.push(empty_block(frame, first + group * lanes));
                for lane in 0..lanes {
                    let index = range(group, lane).nth(slot);
                    self.ids.push(index.map_or(EMPTY, |i| layer.ids[i]));
                    if let Some(index) = index {
                        self.write(self.blocks.len() - 1, lane, &layer.points[index].pack());
                    }
                }
            }
        }
        self.start[groups] = self.blocks.len() as u32;
    }

    /// Appends the particles of a cell, given by its number in the strip.
    pub fn append<P: Record<C>>(&self, cell: usize, points: &mut Vec<P>, ids: &mut Vec<u32>) {
        for slot in 0..self.count(cell) {
            points.push(P::unpack(&self.record(cell, slot)));
            ids.push(self.id(cell, slot));
        }
    }

    /// Particles of a cell: they fill its lane without gaps.
    pub fn count(&self, cell: usize) -> usize {
        (0..self.slots(cell)).take_while(|slot| self.id(cell, *slot) != EMPTY).count()
    }

    /// The numbers of a particle.
    pub fn record(&self, cell: usize, slot: usize) -> [f64; C] {
        let (block, lane) = self.place(cell, slot);
        let numbers = numbers(&self.blocks[block].0);
        std::array::from_fn(|c| numbers[c * V::F64_LANES + lane])
    }

    /// Position (m) and volume (m3) of a particle: its first two numbers and its last.
    pub fn place_and_volume(&self, cell: usize, slot: usize) -> ([f64; 2], f64) {
        let (block, lane) = self.place(cell, slot);
        let numbers = numbers(&self.blocks[block].0);
        let number = |c: usize| numbers[c * V::F64_LANES + lane];
        ([number(0), number(1)], number(C - 1))
    }

    /// Number that a particle was seeded with.
    pub fn id(&self, cell: usize, slot: usize) -> u32 {
        let (block, lane) = self.place(cell, slot);
        self.ids[block * V::F64_LANES + lane]
    }

    /// Particles of the strip that have left their cells, in the order of cells and places, after those in `movers`.
    pub fn leaving(&self, frame: &Frame, first: usize, movers: &mut Vec<Mover<C>>) {
        for cell in 0..(self.start.len() - 1) * V::F64_LANES {
            for slot in 0..self.count(cell) {
                let record = self.record(cell, slot);
                let to = frame.at(&[record[0], record[1]]);
                if to != Some(first + cell) {
                    movers.push(Mover { from: first + cell, slot, to, record, id: self.id(cell, slot) });
                }
            }
        }
    }

    /// Takes a particle out of a cell; those above it move down, and a block that is then empty is dropped.
    pub fn remove(&mut self, frame: &Frame, first: usize, cell: usize, slot: usize) {
        let count = self.count(cell);
        for above in slot + 1..count {
            let (record, id) = (self.record(cell, above), self.id(cell, above));
            self.put(cell, above - 1, &record, id);
        }
        self.put(cell, count - 1, &nobody(frame, first + cell), EMPTY);
        let (group, lanes) = (cell / V::F64_LANES, V::F64_LANES);
        let last = self.start[group + 1] as usize - 1;
        if self.ids[last * lanes..][..lanes].iter().all(|id| *id == EMPTY) {
            self.blocks.remove(last);
            self.ids.drain(last * lanes..(last + 1) * lanes);
            self.start[group + 1..].iter_mut().for_each(|start| *start -= 1);
        }
    }

    /// Puts a particle into a cell before the one at `slot`; those from there on move up.
    pub fn insert(&mut self, frame: &Frame, first: usize, cell: usize, slot: usize, mover: &Mover<C>) {
        let count = self.count(cell);
        if count == self.slots(cell) {
            let (group, lanes) = (cell / V::F64_LANES, V::F64_LANES);
            let end = self.start[group + 1] as usize;
            self.blocks.insert(end, empty_block(frame, first + group * lanes));
            // `splice` would do, but allocates.
            self.ids.resize(self.ids.len() + lanes, EMPTY);
            self.ids.copy_within(end * lanes..(self.blocks.len() - 1) * lanes, (end + 1) * lanes);
            self.ids[end * lanes..(end + 1) * lanes].fill(EMPTY);
            self.start[group + 1..].iter_mut().for_each(|start| *start += 1);
        }
        for above in (slot..count).rev() {
            let (record, id) = (self.record(cell, above), self.id(cell, above));
            self.put(cell, above + 1, &record, id);
        }
        self.put(cell, slot, &mover.record, mover.id);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Block<V, C>>()
            + (self.start.capacity() + self.ids.capacity()) * size_of::<u32>()
    }

    fn slots(&self, cell: usize) -> usize {
        let group = cell / V::F64_LANES;
        (self.start[group + 1] - self.start[group]) as usize
    }

    fn place(&self, cell: usize, slot: usize) -> (usize, usize) {
        (self.start[cell / V::F64_LANES] as usize + slot, cell % V::F64_LANES)
    }

    fn put(&mut self, cell: usize, slot: usize, record: &[f64; C], id: u32) {
        let (block, lane) = self.place(cell, slot);
        self.write(block, lane, record);
        self.ids[block * V::F64_LANES + lane] = id;
    }

    fn write(&mut self, block: usize, lane: usize, record: &[f64; C]) {
        let numbers = numbers_mut(&mut self.blocks[block].0);
        for c in 0..C {
            numbers[c * V::F64_LANES + lane] = record[c];
        }
    }
}

/// A block without particles, for the cells from `number` on.
fn empty_block<V: Simd, const C: usize>(frame: &Frame, number: usize) -> Block<V, C> {
    let mut block = [V::f64s::zeroed(); C];
    let numbers = numbers_mut(&mut block);
    for lane in 0..V::F64_LANES {
        for (c, number) in nobody::<C>(frame, number + lane).into_iter().enumerate() {
            numbers[c * V::F64_LANES + lane] = number;
        }
    }
    Block(block)
}

/// Particles of a numbered cell in a layer; none in the empty cells that only pad the rows.
fn range<P>(frame: &Frame, number: usize, layer: &Layer<P, 2>) -> std::ops::Range<usize> {
    let [i, j] = frame.position(number);
    if i >= frame.cells[0] || j >= frame.cells[1] {
        return 0..0;
    }
    let cell = j * frame.cells[0] + i;
    layer.cell_start[cell] as usize..layer.cell_start[cell + 1] as usize
}

/// What an empty lane holds: nothing, in the middle of the cell.
fn nobody<const C: usize>(frame: &Frame, number: usize) -> [f64; C] {
    let mut record = [0.0; C];
    for (x, place) in record.iter_mut().zip(frame.position(number)) {
        *x = (place as f64 + 0.5) / frame.inverse_size;
    }
    record
}
