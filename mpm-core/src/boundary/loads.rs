//! Loads on faces of the soil: every piece of the outline belongs to the particle behind it.

use crate::dimension::in_two;
use crate::grid::Grid;
use crate::order::sort_by_number;
use crate::particles::{Layer, SolidPoint};
use crate::real::array_of;
use crate::scene::{Bearing, Course, FaceLoad, Fields, Piece, Side, Surcharge};
use crate::seeding::Beside;

/// A piece of the outline that bears a load, and the particle that carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPiece<const D: usize> {
    /// The particle, by the number it was seeded with.
    pub id: u32,
    /// From the particle to the middle of the piece at t = 0, m.
    pub offset: [f64; D],
    /// Volume of the particle at t = 0, m3.
    pub volume: f64,
    /// Force where the factor of the load is 1, N.
    pub force: [f64; D],
    /// Which load it bears.
    load: u16,
}

/// The loads on the faces of a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaceLoads<const D: usize> {
    /// What bears them, by the numbers of the particles, ascending.
    pub pieces: Vec<LoadedPiece<D>>,
    loads: Vec<FaceLoad>,
    /// Weight of the water, N/m3.
    unit_weight: f64,
}

impl<const D: usize> FaceLoads<D> {
    /// Those of a scene and its particles; `width` is that of a column, m.
    ///
    /// The surcharge is one of them on an outline; else the surface bears it.
    pub fn of(scene: &Fields, solid: &Layer<SolidPoint<D>, D>, width: f64) -> Self {
        let surcharge = scene.surcharge.filter(|_| scene.outline.is_some());
        if surcharge.is_none() && scene.loads.is_empty() {
            return Self::default();
        }
        let mut particles = vec![([0.0; D], 0.0); solid.points.len()];
        for (point, id) in solid.points.iter().zip(&solid.ids) {
            particles[*id as usize] = (point.x, point.volume);
        }
        let mut loads = scene.loads.clone();
        // The surcharge of an outline lies on faces that point upwards; how much of it, its pieces say.
        let level = |load: &Surcharge| FaceLoad {
            on: Some(Side::Top),
            x: None,
            y: None,
            bearing: Bearing::Traction { pressure: load.pressure, shear: 0.0, water: false },
            course: if load.ramp_time > 0.0 { Course::Ramp(load.ramp_time) } else { Course::Constant },
        };
        loads.extend(surcharge.iter().map(level));
        let unit_weight = scene.water.map_or(0.0, |w| w.density) * scene.gravity.unwrap_or(0.0);
        let mut found = Self { pieces: Vec::new(), loads, unit_weight };
        if D == 1 {
            // The ends of a column.
            for (which, load) in scene.loads.iter().enumerate() {
                let upper = load.on != Some(Side::Bottom);
                let outward = [0.0, if upper { width } else { -width }];
                let piece = Piece { middle: [0.0, if upper { scene.height } else { 0.0 }], outward };
                let number = if upper { particles.len() - 1 } else { 0 };
                found.add((number, &particles[number]), &piece, (which, load.force(&piece)));
            }
        } else {
            let beside = Beside::new(particles.iter().map(|(x, _)| in_two(x)).collect(), scene.spacing());
            for which in 0..found.loads.len() {
                let load = &found.loads[which];
                let of_surcharge = surcharge.filter(|_| which == scene.loads.len());
                let force = |piece: &Piece| of_surcharge.map_or_else(|| load.force(piece), |s| s.force(piece));
                let force = |piece: &Piece| force(piece).map(|f| f * scene.thickness(piece.middle[0]));
                let borne: Vec<_> = scene.pieces_under(load).into_iter().map(|piece| (piece, force(&piece))).collect();
                for (piece, force) in borne {
                    if let Some(number) = beside.find(&piece.middle).filter(|_| force != [0.0; 2]) {
                        found.add((number, &particles[number]), &piece, (which, force));
                    }
                }
            }
        }
        sort_by_number(&mut found.pieces, |piece| piece.id.into());
        found
    }

    fn add(
        &mut self,
        (number, (x, volume)): (usize, &([f64; D], f64)),
        piece: &Piece,
        (load, force): (usize, [f64; 2]),
    ) {
        let from = in_two(x);
        self.pieces.push(LoadedPiece {
            id: number as u32,
            offset: array_of(|d| piece.middle[d + 2 - D] - from[d + 2 - D]),
            volume: *volume,
            force: array_of(|d| force[d + 2 - D]),
            load: load as u16,
        });
    }

    /// The factor on the force of a piece whose particle is at a place (m), at a time, s.
    pub fn factor(&self, piece: &LoadedPiece<D>, place: &[f64; D], time: f64) -> f64 {
        let [x, y] = in_two(place);
        let [dx, dy] = in_two(&piece.offset);
        self.loads[usize::from(piece.load)].factor(&[x + dx, y + dy], time, self.unit_weight)
    }
}

impl<const D: usize> LoadedPiece<D> {
    /// Where its load acts: place of the cell of its particle, which stands at `x` (m) and has a volume (m3), and cell coordinates of
    /// the point. The piece keeps its distance from the particle, times the stretch of that.
    pub fn place(&self, grid: &Grid<D>, (x, volume): ([f64; D], f64)) -> ([usize; D], [f64; D]) {
        let (mut position, mut xi) = ([0; D], [0.0; D]);
        for d in 0..D {
            let scaled = x[d] * grid.inverse_size;
            position[d] = (scaled.max(0.0) as usize).min(grid.cells[d] - 1);
            let stretch = if d == D - 1 { volume / self.volume } else { 1.0 };
            xi[d] = scaled - position[d] as f64 + self.offset[d] * stretch * grid.inverse_size;
        }
        (position, xi)
    }
}
