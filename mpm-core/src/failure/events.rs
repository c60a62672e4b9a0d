//! Monitoring of a slope: how much of it has moved how far, and which of that is an event.
//!
//! Three events that do not depend on the mesh, by displaced area: E1, raveling at the toe; E2, failure; E3, collapse. How far soil has
//! to move for them is a matter of the scene ([`Scales::events`]): what it may do elastically, and a share of its height beyond.

use serde::Serialize;

use super::scales::Scales;
use crate::checkpoint::{Archive, RestoreError, archive};
use crate::observe::SolidState;
use crate::order::sort_by_number;
use crate::seeding;
use crate::step::Failing;

/// Shares of the section that have to move for E1, E2 (of it only what is deep) and E3.
const SHARES: [f64; 3] = [0.005, 0.01, 0.05];
/// Share of the section that may lie beyond the toe: what rolls ahead.
const AHEAD: f64 = 1e-3;

/// The soil as it was when counting began, by the numbers of its particles.
#[derive(Debug, Clone)]
pub struct First {
    /// Area that each particle stands for, m2.
    area: Vec<f64>,
    deep: Vec<bool>,
    crest: Vec<bool>,
    whole: f64,
    /// Displacements of E1, E2 and E3, m.
    events: [f64; 3],
    /// On which side the toe is: 1 towards +x, -1 towards -x.
    towards: f64,
    /// Particles nearest to the observed places.
    pub points: Vec<u32>,
}

/// What has moved.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Moved {
    /// Largest displacement of a particle, m.
    pub most_m: f64,
    /// x and y where that particle was, m.
    pub most_at_m: [f64; 2],
    /// Share of the section that has moved further than is allowed for E1.
    pub raveled: f64,
    /// Share of the section that lay deep and has moved further than is allowed for E2.
    pub failed: f64,
    /// Share of the section that has moved further than is allowed for E3.
    pub collapsed: f64,
    /// Mean x where the soil that has moved as far as for E2 was, m; not a number if there is none.
    pub failed_at_m: f64,
    /// Mean settlement of the crest, m.
    pub crest_settlement_m: f64,
    /// x beyond which, on the side of the toe, a thousandth of the soil lies, m.
    pub toe_x_m: f64,
    /// Largest deviator strain.
    pub deviator_strain: f64,
    /// Fastest particle, m/s.
    pub speed_m_s: f64,
}

impl Moved {
    /// Whether this is E1, E2, E3.
    pub fn events(&self) -> [bool; 3] {
        [self.raveled >= SHARES[0], self.failed >= SHARES[1], self.collapsed >= SHARES[2]]
    }
}

/// Which soil is monitored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// All of it: as much of it as for E1 has to move.
    All,
    /// What is deep: as much of it as for E2 has to move.
    Deep,
}

impl First {
    /// The soil of a model now, inside an `outline` (m); `points` (m) are to be observed.
    pub fn of(model: &dyn Failing, outline: &[[f64; 2]], points: &[[f64; 2]], scales: &Scales) -> Self {
        let top = outline.iter().map(|x| x[1]).fold(0.0, f64::max);
        let depth = scales.depth();
        let mut states: Vec<SolidState> = Vec::new();
        model.each(&mut |state| states.push(*state));
        sort_by_number(&mut states, |state| state.id.into());
        let nearest = |at: &[f64; 2]| {
            let distance = |s: &SolidState| (s.x[0] - at[0]).powi(2) + (s.x[1] - at[1]).powi(2);
            states.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(0, |state| state.id)
        };
        Self {
            points: points.iter().map(nearest).collect(),
            area: states.iter().map(|s| s.volume).collect(),
            deep: states.iter().map(|s| seeding::depth(outline, &s.x) > depth).collect(),
            crest: states.iter().map(|s| s.x[1] > top - depth).collect(),
            whole: states.iter().map(|s| s.volume).sum(),
            events: scales.events(),
            towards: towards(outline),
        }
    }

    /// Where the particles are, by their numbers, m.
    pub fn places(&self, model: &dyn Failing) -> Vec<[f64; 2]> {
        let mut places = vec![[0.0; 2]; self.area.len()];
        model.each(&mut |s| places[s.id as usize] = s.x);
        places
    }

    /// Way (m) from some places to others that enough of the soil has at least come.
    pub fn way(&self, which: Which, from: &[[f64; 2]], to: &[[f64; 2]]) -> f64 {
        let (share, looked_at): (f64, &dyn Fn(usize) -> bool) = match which {
            Which::All => (SHARES[0], &|_| true),
            Which::Deep => (SHARES[1], &|id| self.deep[id]),
        };
        let way = |id: usize| (to[id][0] - from[id][0]).hypot(to[id][1] - from[id][1]);
        let mut ways: Vec<(f64, f64)> =
            (0..self.area.len()).filter(|id| looked_at(*id)).map(|id| (way(id), self.area[id])).collect();
        sort_by_number(&mut ways, |(way, _)| -way);
        let mut moved = 0.0;
        let enough = |(_, area): &&(f64, f64)| {
            moved += area;
            moved >= share * self.whole
        };
        ways.iter().find(enough).map_or(0.0, |(way, _)| *way)
    }

    /// Saves or restores what is remembered.
    pub(crate) fn save_or_restore(&mut self, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.slice: self.area, self.deep, self.crest, self.points);
        archive!(archive.value: self.whole);
        Ok(())
    }

    /// What has moved since.
    pub fn moved(&self, model: &dyn Failing) -> Moved {
        let mut moved = Moved::default();
        let (mut crest, mut crest_area) = (0.0, 0.0);
        let (mut failed_x, mut failed_area) = (0.0, 0.0);
        let mut ahead: Vec<(f64, f64)> = Vec::with_capacity(self.area.len());
        model.each(&mut |s| {
            let id = s.id as usize;
            let (area, way) = (self.area[id], s.displacement[0].hypot(s.displacement[1]));
            if way > moved.most_m {
                moved.most_m = way;
                moved.most_at_m = [s.x[0] - s.displacement[0], s.x[1] - s.displacement[1]];
            }
            if way > self.events[0] {
                moved.raveled += area;
            }
            if way > self.events[1] {
                if self.deep[id] {
                    moved.failed += area;
                }
                failed_x += area * (s.x[0] - s.displacement[0]);
                failed_area += area;
            }
            if way > self.events[2] {
                moved.collapsed += area;
            }
            if self.crest[id] {
                crest -= area * s.displacement[1];
                crest_area += area;
            }
            moved.deviator_strain = moved.deviator_strain.max(s.deviator_strain);
            moved.speed_m_s = moved.speed_m_s.max(s.velocity[0].hypot(s.velocity[1]));
            ahead.push((self.towards * s.x[0] + 0.5 * s.volume.sqrt(), area));
        });
        for share in [&mut moved.raveled, &mut moved.failed, &mut moved.collapsed] {
            *share /= self.whole;
        }
        moved.failed_at_m = failed_x / failed_area;
        moved.crest_settlement_m = if crest_area > 0.0 { crest / crest_area } else { 0.0 };
        sort_by_number(&mut ahead, |(x, _)| -x);
        let mut beyond = 0.0;
        moved.toe_x_m = ahead
            .iter()
            .find(|(_, area)| {
                beyond += area;
                beyond > AHEAD * self.whole
            })
            .map_or(0.0, |(x, _)| self.towards * x);
        moved
    }
}

/// On which side the toe of an outline (m) is: where its ground ends lower. 1 towards +x, -1 towards -x.
pub fn towards(outline: &[[f64; 2]]) -> f64 {
    let ends = [-1.0, 1.0].map(|side| {
        let end = outline.iter().map(|x| side * x[0]).fold(f64::NEG_INFINITY, f64::max);
        outline.iter().filter(|x| side * x[0] == end).map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max)
    });
    if ends[0] < ends[1] { -1.0 } else { 1.0 }
}
