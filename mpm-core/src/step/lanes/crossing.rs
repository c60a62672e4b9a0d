//! Particles that have left their cells, put where they belong now.
//!
//! The order of the particles in a cell is that of a stable sort, as in [`crate::particles::Layer::sort`]: who comes from
//! a cell before stands before those who stayed, who comes from a cell after stands behind them.

use pulp::Simd;

use super::blocks::{Blocks, Mover};
use super::frame::Frame;
use super::strip::Strip;

/// One layer of a strip.
pub type LayerOf<V, const C: usize> = fn(&mut Strip<V>) -> &mut Blocks<V, C>;

/// Finds the particles of a layer that have left their cells.
pub fn find<V: Simd, const C: usize>(
    strips: &mut [Strip<V>],
    frame: &Frame,
    layer: LayerOf<V, C>,
    movers: &mut Vec<Mover<C>>,
) {
    movers.clear();
    for strip in strips.iter_mut().filter(|strip| !strip.stays) {
        let first = strip.first;
        layer(strip).leaving(frame, first, movers);
    }
}

/// Whether the cells with soil stay the same ones, and those with particles of this layer: none goes where no soil is
/// (unless it `may_leave` the soil and is somewhere), none is the last of its cell.
pub fn keeps_outline<V: Simd, const C: usize>(
    strips: &mut [Strip<V>],
    frame: &Frame,
    layer: LayerOf<V, C>,
    movers: &[Mover<C>],
    may_leave: bool,
) -> bool {
    let sound = |mover: &Mover<C>| on_soil(strips, frame, mover).is_some() || (may_leave && mover.is_somewhere());
    movers.iter().all(sound)
        && movers.chunk_by(|a, b| a.from == b.from).all(|leaving| {
            let cell = leaving[0].from;
            layer(&mut strips[cell / frame.strip]).count(cell % frame.strip) > leaving.len()
        })
}

/// The cell that a particle enters, if there is soil.
fn on_soil<V: Simd, const C: usize>(strips: &[Strip<V>], frame: &Frame, mover: &Mover<C>) -> Option<usize> {
    mover.to.filter(|to| strips[to / frame.strip].solid.count(to % frame.strip) > 0)
}

/// Carries them over; those that leave the soil are taken out and passed to `gone`.
pub fn carry<V: Simd, const C: usize>(
    strips: &mut [Strip<V>],
    frame: &Frame,
    layer: LayerOf<V, C>,
    movers: &mut [Mover<C>],
    mut gone: impl FnMut(&Mover<C>),
) {
    // The last of a cell first, so that the places of the others still hold.
    for mover in movers.iter().rev() {
        let strip = &mut strips[mover.from / frame.strip];
        let first = strip.first;
        layer(strip).remove(frame, first, mover.from - first, mover.slot);
    }
    for mover in movers.iter_mut() {
        mover.to = on_soil(strips, frame, mover);
        if mover.to.is_none() {
            gone(mover);
        }
    }
    movers.sort_unstable_by_key(|mover| (mover.to, mover.from, mover.slot));
    for coming in movers.chunk_by(|a, b| a.to == b.to) {
        let Some(to) = coming[0].to else { continue };
        let strip = &mut strips[to / frame.strip];
        let first = strip.first;
        let blocks = layer(strip);
        for (i, mover) in coming.iter().enumerate() {
            let slot = if mover.from < to { i } else { blocks.count(to - first) };
            blocks.insert(frame, first, to - first, slot, mover);
        }
    }
}
