//! Particles that have left their cells, put where they belong now.
//!
//! The order of the particles in a cell is that of a stable sort, as in [`crate::particles::Layer::sort`]: who comes from
//! a cell before stands before those who stayed, who comes from a cell after stands behind them.

use super::blocks::{Blocks, Mover, Movers};
use super::frame::Frame;
use super::strip::Strip;

/// One layer of a strip.
pub type LayerOf<const D: usize> = fn(&mut Strip<D>) -> &mut Blocks;

/// Finds the particles of a layer that have left their cells.
pub fn find<const D: usize>(strips: &mut [Strip<D>], frame: &Frame<D>, layer: LayerOf<D>, movers: &mut Movers) {
    movers.clear();
    for strip in strips.iter_mut().filter(|strip| !strip.sums.stays) {
        let first = strip.first;
        layer(strip).leaving(frame, first, movers);
    }
}

/// Whether the cells with soil stay the same ones, and those with particles of this layer: none goes where no soil is
/// (unless it `may_leave` the soil and is somewhere), none is the last of its cell.
pub fn keeps_outline<const D: usize>(
    strips: &mut [Strip<D>],
    frame: &Frame<D>,
    layer: LayerOf<D>,
    movers: &Movers,
    may_leave: bool,
) -> bool {
    let somewhere = |mover: &Mover| movers.record(mover)[..D].iter().all(|x| x.is_finite());
    let sound = |mover: &Mover| on_soil(strips, frame, mover).is_some() || (may_leave && somewhere(mover));
    movers.list.iter().all(sound)
        && movers.list.chunk_by(|a, b| a.from == b.from).all(|leaving| {
            let cell = leaving[0].from;
            layer(&mut strips[cell / frame.strip]).count(cell % frame.strip) > leaving.len()
        })
}

/// The cell that a particle enters, if there is soil.
fn on_soil<const D: usize>(strips: &[Strip<D>], frame: &Frame<D>, mover: &Mover) -> Option<usize> {
    mover.to.filter(|to| strips[to / frame.strip].solid.count(to % frame.strip) > 0)
}

/// Carries them over. Those that leave the soil are taken out where they must stay `within` it, and their numbers passed to `gone`.
pub fn carry<const D: usize>(
    strips: &mut [Strip<D>],
    frame: &Frame<D>,
    layer: LayerOf<D>,
    (movers, within): (&mut Movers, bool),
    mut gone: impl FnMut(&[f64]),
) {
    // The last of a cell first, so that the places of the others still hold.
    for mover in movers.list.iter().rev() {
        let strip = &mut strips[mover.from / frame.strip];
        let first = strip.first;
        layer(strip).remove(frame, first, mover.from - first, mover.slot);
    }
    for i in 0..movers.list.len() {
        let mover = movers.list[i];
        let to = if within { on_soil(strips, frame, &mover) } else { mover.to };
        movers.list[i].to = to;
        if to.is_none() {
            gone(movers.record(&movers.list[i]));
        }
    }
    movers.list.sort_unstable_by_key(|mover| (mover.to, mover.from, mover.slot));
    for coming in movers.list.chunk_by(|a, b| a.to == b.to) {
        let Some(to) = coming[0].to else { continue };
        let strip = &mut strips[to / frame.strip];
        let first = strip.first;
        let blocks = layer(strip);
        for (i, mover) in coming.iter().enumerate() {
            let slot = if mover.from < to { i } else { blocks.count(to - first) };
            blocks.insert(frame, first, (to - first, slot), (mover, movers.record(mover)));
        }
    }
}
