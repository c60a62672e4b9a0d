//! Particles of a strip of cells, so many cells side by side: a block holds one particle of each.
//!
//! A particle is a row of numbers, the first of them its position ([`Point`]). What only some scenes keep at their particles (the state of a
//! material, a velocity gradient, strains that are followed) stands behind the numbers that all have.

use std::ops::Range;

use pulp::Simd;

use super::aligned::Aligned;
use super::ask_for;
use super::frame::Frame;
use crate::particles::{Layer, Point};
use crate::real::{MAX_LANES, SimdReal, array, array_of, vectors_mut};

/// One block in so many is kept in reserve.
const SPARE: usize = 8;
/// A lane without a particle.
const EMPTY: u32 = u32::MAX;

/// Solid particles of so many cells, one of each.
#[derive(Clone, Copy)]
pub struct SolidLanes<V: Simd, const D: usize> {
    /// Position, m.
    pub x: [SimdReal<V>; D],
    /// Velocity, m/s.
    pub v: [SimdReal<V>; D],
    /// Effective stress xx, yy, zz, xy, Pa.
    pub stress: [SimdReal<V>; 4],
    /// Dry mass, kg.
    pub mass: SimdReal<V>,
    /// Volume of soil, m3.
    pub volume: SimdReal<V>,
}

impl<V: Simd, const D: usize> SolidLanes<V, D> {
    /// Reads a block.
    #[inline(always)]
    pub fn read(simd: V, block: &[V::f64s]) -> Self {
        let block = &block[..2 * D + 6];
        let none = SimdReal::splat(simd, 0.0);
        Self {
            x: array!([none; D], d => SimdReal { simd, value: block[d] }),
            v: array!([none; D], d => SimdReal { simd, value: block[D + d] }),
            stress: array!([none; 4], s => SimdReal { simd, value: block[2 * D + s] }),
            mass: SimdReal { simd, value: block[2 * D + 4] },
            volume: SimdReal { simd, value: block[2 * D + 5] },
        }
    }

    /// Writes what a step changes.
    #[inline(always)]
    pub fn write(&self, block: &mut [V::f64s]) {
        let block = &mut block[..2 * D + 6];
        for d in 0..D {
            (block[d], block[D + d]) = (self.x[d].value, self.v[d].value);
        }
        for s in 0..4 {
            block[2 * D + s] = self.stress[s].value;
        }
        block[2 * D + 5] = self.volume.value;
    }
}

/// Water particles of so many cells, one of each.
#[derive(Clone, Copy)]
pub struct WaterLanes<V: Simd, const D: usize> {
    /// Position, m.
    pub x: [SimdReal<V>; D],
    /// Velocity, m/s.
    pub v: [SimdReal<V>; D],
    /// Mass, kg.
    pub mass: SimdReal<V>,
    /// Volume of soil that it fills, m3.
    pub volume: SimdReal<V>,
    /// Pore pressure, Pa.
    pub pressure: SimdReal<V>,
}

impl<V: Simd, const D: usize> WaterLanes<V, D> {
    /// Reads a block.
    #[inline(always)]
    pub fn read(simd: V, block: &[V::f64s]) -> Self {
        let block = &block[..2 * D + 3];
        let none = SimdReal::splat(simd, 0.0);
        Self {
            x: array!([none; D], d => SimdReal { simd, value: block[d] }),
            v: array!([none; D], d => SimdReal { simd, value: block[D + d] }),
            mass: SimdReal { simd, value: block[2 * D] },
            volume: SimdReal { simd, value: block[2 * D + 1] },
            pressure: SimdReal { simd, value: block[2 * D + 2] },
        }
    }

    /// Writes what a step changes.
    #[inline(always)]
    pub fn write(&self, block: &mut [V::f64s]) {
        let block = &mut block[..2 * D + 3];
        for d in 0..D {
            (block[d], block[D + d]) = (self.x[d].value, self.v[d].value);
        }
        (block[2 * D + 1], block[2 * D + 2]) = (self.volume.value, self.pressure.value);
    }
}

/// The particles of one layer in a strip. How many cells are side by side is known when a run starts, not when this is compiled.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// Numbers of a particle.
    pub columns: usize,
    /// Cells side by side, a power of two: the lanes of a SIMD vector.
    lanes: usize,
    /// Block after block, `columns` vectors each; nothing weighs what an empty lane holds.
    numbers: Aligned,
    /// First block of each group of cells, and the total at the end.
    start: Vec<u32>,
    /// Number that each particle was seeded with, lane by lane.
    ids: Vec<u32>,
}

/// The particles of a layer as the kernel sees them: vectors of one number of so many cells.
pub struct BlockVectors<'a, V: Simd> {
    columns: usize,
    vectors: &'a mut [V::f64s],
    start: &'a [u32],
    /// Number that each particle was seeded with, lane by lane.
    pub ids: &'a [u32],
}

impl<V: Simd> BlockVectors<'_, V> {
    /// Blocks of a group of cells.
    #[inline(always)]
    pub fn range(&self, group: usize) -> Range<usize> {
        self.start[group] as usize..self.start[group + 1] as usize
    }

    /// One block.
    #[inline(always)]
    pub fn block(&self, index: usize) -> &[V::f64s] {
        &self.vectors[index * self.columns..][..self.columns]
    }

    /// One block, to be changed.
    #[inline(always)]
    pub fn block_mut(&mut self, index: usize) -> &mut [V::f64s] {
        &mut self.vectors[index * self.columns..][..self.columns]
    }

    /// Asks the memory for the first `count` numbers of a block.
    #[inline(always)]
    pub fn ask_for(&self, index: usize, count: usize) {
        if let Some(block) = self.vectors.get(index * self.columns..).and_then(|rest| rest.get(..count)) {
            for i in (0..count).step_by((MAX_LANES / V::F64_LANES).max(1)) {
                ask_for(block, i);
            }
        }
    }
}

/// A particle on its way to another cell.
#[derive(Debug, Clone, Copy)]
pub struct Mover {
    /// Cell it leaves.
    pub from: usize,
    /// Its place among the particles of that cell.
    pub slot: usize,
    /// Cell it enters; none outside the mesh.
    pub to: Option<usize>,
    /// Where its numbers start among those of all movers.
    record: usize,
    id: u32,
}

/// Particles on their way to other cells, with their numbers.
#[derive(Debug, Clone, Default)]
pub struct Movers {
    /// Who.
    pub list: Vec<Mover>,
    numbers: Vec<f64>,
    columns: usize,
}

impl Movers {
    /// Room for so many with so many numbers each.
    pub fn new(count: usize, columns: usize) -> Self {
        Self { list: Vec::with_capacity(count), numbers: Vec::with_capacity(count * columns), columns }
    }

    /// Nobody.
    pub fn clear(&mut self) {
        self.list.clear();
        self.numbers.clear();
    }

    /// The numbers of one.
    pub fn record(&self, mover: &Mover) -> &[f64] {
        &self.numbers[mover.record..][..self.columns]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.list.capacity() * size_of::<Mover>() + self.numbers.capacity() * size_of::<f64>()
    }
}

impl Blocks {
    /// No particles in so many groups of so many cells side by side.
    pub fn new(groups: usize, lanes: usize) -> Self {
        Self { columns: 0, lanes, numbers: Aligned::default(), start: vec![0; groups + 1], ids: Vec::new() }
    }

    /// As the kernel sees them; V has as many lanes as cells are side by side.
    #[inline(always)]
    pub fn vectors<V: Simd>(&mut self) -> BlockVectors<'_, V> {
        let Self { columns, numbers, start, ids, .. } = self;
        BlockVectors { columns: *columns, vectors: vectors_mut(numbers), start, ids }
    }

    /// Blocks of a group of cells.
    pub fn range(&self, group: usize) -> Range<usize> {
        self.start[group] as usize..self.start[group + 1] as usize
    }

    /// The numbers of one block.
    fn block(&self, index: usize) -> &[f64] {
        let length = self.columns * self.lanes;
        &self.numbers[index * length..][..length]
    }

    fn block_mut(&mut self, index: usize) -> &mut [f64] {
        let length = self.columns * self.lanes;
        &mut self.numbers[index * length..][..length]
    }

    /// Takes the particles of the strip from `first` on out of a layer, in its order, with what is kept beside them: `more`
    /// numbers of each particle by its number.
    pub fn fill<P: Point<D>, const D: usize>(
        &mut self,
        frame: &Frame<D>,
        first: usize,
        layer: &Layer<P, D>,
        (more, kept): (usize, &[f64]),
    ) {
        let lanes = self.lanes;
        let groups = self.start.len() - 1;
        let range = |group: usize, lane: usize| range(frame, first + group * lanes + lane, layer);
        let slots = |group: usize| (0..lanes).map(|lane| range(group, lane).len()).max().unwrap_or(0);
        let count = (0..groups).map(slots).sum::<usize>();
        self.columns = P::COUNT + more;
        // Some more for particles that come from other cells.
        let room = (count + count / SPARE) * lanes;
        self.numbers.clear_for(room * self.columns);
        self.ids.clear();
        self.ids.reserve_exact(room);
        let mut record = vec![0.0; self.columns];
        for group in 0..groups {
            self.start[group] = self.count_blocks() as u32;
            for slot in 0..slots(group) {
                let block = self.count_blocks();
                self.insert_block(frame, first + group * lanes, block);
                for lane in 0..lanes {
                    if let Some(index) = range(group, lane).nth(slot) {
                        let id = layer.ids[index];
                        layer.points[index].pack(&mut record);
                        record[P::COUNT..].copy_from_slice(&kept[more * id as usize..][..more]);
                        self.write(block, lane, &record);
                        self.ids[block * lanes + lane] = id;
                    }
                }
            }
        }
        self.start[groups] = self.count_blocks() as u32;
    }

    /// Appends the particles of a cell, given by its number in the strip.
    pub fn append<P: Point<D>, const D: usize>(&self, cell: usize, points: &mut Vec<P>, ids: &mut Vec<u32>) {
        for slot in 0..self.count(cell) {
            points.push(self.particle(cell, slot));
            ids.push(self.id(cell, slot));
        }
    }

    fn count_blocks(&self) -> usize {
        self.ids.len() / self.lanes
    }

    /// Particles of a cell: they fill its lane without gaps.
    pub fn count(&self, cell: usize) -> usize {
        (0..self.slots(cell)).take_while(|slot| self.id(cell, *slot) != EMPTY).count()
    }

    /// One number of a particle.
    #[inline]
    pub fn number(&self, cell: usize, slot: usize, number: usize) -> f64 {
        let (block, lane) = self.place(cell, slot);
        self.block(block)[number * self.lanes + lane]
    }

    /// A particle.
    pub fn particle<P: Point<D>, const D: usize>(&self, cell: usize, slot: usize) -> P {
        let (block, lane) = self.place(cell, slot);
        let numbers = self.block(block);
        let mut record = [0.0; 16];
        for (i, number) in record[..P::COUNT].iter_mut().enumerate() {
            *number = numbers[i * self.lanes + lane];
        }
        P::unpack(&record)
    }

    /// Number that a particle was seeded with.
    pub fn id(&self, cell: usize, slot: usize) -> u32 {
        let (block, lane) = self.place(cell, slot);
        self.ids[block * self.lanes + lane]
    }

    /// Particles of the strip that have left their cells, in the order of cells and places, after those in `movers`. Empty lanes,
    /// which move with the mesh as if they held a particle, go back to the middle: away from their cell functions grow without
    /// bound, and no weight of zero makes anything of infinity.
    pub fn leaving<const D: usize>(&mut self, frame: &Frame<D>, first: usize, movers: &mut Movers) {
        movers.columns = self.columns;
        for group in 0..self.start.len() - 1 {
            // Few groups have a particle that leaves.
            if self.all_stay(frame, first, group) {
                continue;
            }
            for cell in group * self.lanes..(group + 1) * self.lanes {
                let count = self.count(cell);
                for slot in 0..self.slots(cell) {
                    let x: [f64; D] = array_of(|d| self.number(cell, slot, d));
                    let to = frame.at(&x);
                    if to == Some(first + cell) {
                        continue;
                    }
                    if slot >= count {
                        let (block, lane) = self.place(cell, slot);
                        self.clear(frame, first + cell, block, lane);
                    } else {
                        let (record, id) = (movers.numbers.len(), self.id(cell, slot));
                        movers.list.push(Mover { from: first + cell, slot, to, record, id });
                        movers.numbers.extend((0..self.columns).map(|i| self.number(cell, slot, i)));
                    }
                }
            }
        }
    }

    /// Whether all lanes of a group are in their cells.
    fn all_stay<const D: usize>(&self, frame: &Frame<D>, first: usize, group: usize) -> bool {
        let lanes = self.lanes;
        let at: [[usize; D]; MAX_LANES] =
            array!([[0; D]; MAX_LANES], lane => frame.position(first + group * lanes + lane));
        self.range(group).all(|block| {
            let x = &self.block(block)[..D * lanes];
            (0..lanes).all(|lane| {
                (0..D).all(|d| {
                    let (place, x) = (at[lane][d] as f64, x[d * lanes + lane] * frame.inverse_size);
                    x >= place && x < place + 1.0
                })
            })
        })
    }

    /// Sets numbers of all particles.
    pub fn fill_numbers(&mut self, which: Range<usize>, value: f64) {
        let lanes = self.lanes;
        for block in 0..self.count_blocks() {
            self.block_mut(block)[which.start * lanes..which.end * lanes].fill(value);
        }
    }

    /// Takes particles beyond one side of a mesh that is periodic (m) to its other one.
    pub fn wrap(&mut self, period: f64) {
        let lanes = self.lanes;
        for block in 0..self.count_blocks() {
            for x in &mut self.block_mut(block)[..lanes] {
                if *x < 0.0 {
                    // A hair left of zero would round to the period itself, which is outside.
                    *x = (*x + period).min(period.next_down());
                } else if *x >= period {
                    *x -= period;
                }
            }
        }
    }

    /// Takes a particle out of a cell; those above it move down, and a block that is then empty is dropped.
    pub fn remove<const D: usize>(&mut self, frame: &Frame<D>, first: usize, cell: usize, slot: usize) {
        let count = self.count(cell);
        for above in slot + 1..count {
            self.copy(cell, above, above - 1);
        }
        let (block, lane) = self.place(cell, count - 1);
        self.clear(frame, first + cell, block, lane);
        let (group, lanes) = (self.group_and_lane(cell).0, self.lanes);
        let last = self.start[group + 1] as usize - 1;
        if self.ids[last * lanes..][..lanes].iter().all(|id| *id == EMPTY) {
            self.numbers.remove(last * self.columns * lanes..(last + 1) * self.columns * lanes);
            self.ids.drain(last * lanes..(last + 1) * lanes);
            self.start[group + 1..].iter_mut().for_each(|start| *start -= 1);
        }
    }

    /// Puts a particle into a cell before the one at `slot`; those from there on move up.
    pub fn insert<const D: usize>(
        &mut self,
        frame: &Frame<D>,
        first: usize,
        (cell, slot): (usize, usize),
        (mover, record): (&Mover, &[f64]),
    ) {
        let count = self.count(cell);
        if count == self.slots(cell) {
            let (group, lanes) = (self.group_and_lane(cell).0, self.lanes);
            let end = self.start[group + 1] as usize;
            self.insert_block(frame, first + group * lanes, end);
            self.start[group + 1..].iter_mut().for_each(|start| *start += 1);
        }
        for above in (slot..count).rev() {
            self.copy(cell, above, above + 1);
        }
        let (block, lane) = self.place(cell, slot);
        self.write(block, lane, record);
        self.ids[block * self.lanes + lane] = mover.id;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.numbers.bytes() + (self.start.capacity() + self.ids.capacity()) * size_of::<u32>()
    }

    fn slots(&self, cell: usize) -> usize {
        self.range(self.group_and_lane(cell).0).len()
    }

    /// Where a cell is: its group, and its place in that.
    #[inline]
    fn group_and_lane(&self, cell: usize) -> (usize, usize) {
        (cell >> self.lanes.trailing_zeros(), cell & (self.lanes - 1))
    }

    /// Block and lane of a particle.
    #[inline]
    fn place(&self, cell: usize, slot: usize) -> (usize, usize) {
        let (group, lane) = self.group_and_lane(cell);
        (self.start[group] as usize + slot, lane)
    }

    fn copy(&mut self, cell: usize, from: usize, to: usize) {
        let ((from, lane), (to, _)) = (self.place(cell, from), self.place(cell, to));
        for i in 0..self.columns {
            let number = i * self.lanes + lane;
            self.block_mut(to)[number] = self.block(from)[number];
        }
        self.ids[to * self.lanes + lane] = self.ids[from * self.lanes + lane];
    }

    fn write(&mut self, block: usize, lane: usize, record: &[f64]) {
        let lanes = self.lanes;
        let numbers = self.block_mut(block);
        for (i, number) in record.iter().enumerate() {
            numbers[i * lanes + lane] = *number;
        }
    }

    /// Makes room for a block without particles, of the cells from `number` on. Without an allocation as long as there is room.
    fn insert_block<const D: usize>(&mut self, frame: &Frame<D>, number: usize, at: usize) {
        let (blocks, lanes, length) = (self.count_blocks(), self.lanes, self.columns * self.lanes);
        self.numbers.insert_zeros(at * length, length);
        self.ids.resize((blocks + 1) * lanes, EMPTY);
        self.ids.copy_within(at * lanes..blocks * lanes, (at + 1) * lanes);
        for lane in 0..lanes {
            self.clear(frame, number + lane, at, lane);
        }
    }

    /// Empties a lane: it holds nothing, in the middle of its cell.
    fn clear<const D: usize>(&mut self, frame: &Frame<D>, number: usize, block: usize, lane: usize) {
        let place = frame.position(number);
        let lanes = self.lanes;
        let numbers = self.block_mut(block);
        for i in 0..numbers.len() / lanes {
            numbers[i * lanes + lane] = match place.get(i) {
                Some(place) => (*place as f64 + 0.5) / frame.inverse_size,
                None => 0.0,
            };
        }
        self.ids[block * self.lanes + lane] = EMPTY;
    }
}

/// Particles of a numbered cell in a layer; none in the empty cells that only pad the rows.
fn range<P, const D: usize>(frame: &Frame<D>, number: usize, layer: &Layer<P, D>) -> Range<usize> {
    let place = frame.position(number);
    if !frame.is_cell(&place) {
        return 0..0;
    }
    let cell = (0..D).rev().fold(0, |cell, d| cell * frame.cells[d] + place[d]);
    layer.cell_start[cell] as usize..layer.cell_start[cell + 1] as usize
}
