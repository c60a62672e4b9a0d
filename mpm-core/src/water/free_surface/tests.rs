//! Water alone in a block of soil, against exact solutions. The verification suite has the same with refinement.

use super::*;
use crate::particles::{Layer, SolidPoint, even_positions};

const N: f64 = 0.3;
const K: f64 = 5e-4;
const GAMMA: f64 = 9810.0;
const CLOSED: Surroundings =
    Surroundings { open: [false; 4], feeds: [None; 4], heads: NO_HEADS, periodic: false, standing: Vec::new() };

fn block(cells: [usize; 2], h: f64, weight: [f64; 2], around: &Surroundings) -> (Grid<2>, FreeSurface<2>) {
    let grid = Grid::new(cells, h);
    let at = |x: [f64; 2]| SolidPoint::<2> {
        x: x.map(|x| x * h),
        v: [0.0; 2],
        stress: [0.0; 4],
        mass: 1.0,
        volume: 0.25 * h * h,
    };
    let solid = Layer::new(even_positions(cells, 2).map(at).collect(), &grid).unwrap();
    let soils = Soils::one((1.0 - N) * 0.25 * h * h);
    let soil = SoilMap::new(&grid, &solid, h, 2, &soils);
    let (conductance, cell_volume) = (K / GAMMA, h * h);
    let medium = Medium { conductance, size: h, cell_volume, weight, unit_weight: GAMMA, porosity: N, retention: None };
    let water = FreeSurface::new(&grid, medium, (soil, soils), around).unwrap();
    (grid, water)
}

/// Runs to a time (s) and shows every step and its length.
fn run(water: &mut FreeSurface<2>, until: f64, mut look: impl FnMut(&FreeSurface<2>, f64, f64)) {
    let (mut time, mut dt) = (0.0, 0.1);
    while time < until * (1.0 - 1e-12) {
        let (done, next) = water.step(f64::min(dt, until - time)).unwrap();
        time += done;
        dt = next;
        look(water, time, done);
    }
    assert_eq!(water.unsettled, 0);
}

fn fed(side: usize, head: f64) -> Surroundings {
    let mut around = CLOSED;
    around.feeds[side] = Some(Feed::Head(head));
    around
}

/// Largest distance of a front from where it should be at its times, in cells.
fn front(cells: [usize; 2], weight: [f64; 2], around: &Surroundings, time_of: impl Fn(f64) -> f64) -> f64 {
    let h = 1.0 / cells[0].max(cells[1]) as f64;
    let (_, mut water) = block(cells, h, weight, around);
    let mut worst: f64 = 0.0;
    run(&mut water, time_of(0.9), |water, time, _| {
        let (mut low, mut high) = (0.0, 0.99);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if time_of(middle) < time { low = middle } else { high = middle }
        }
        worst = worst.max((water.stored() / (N * h) - low).abs());
    });
    worst / h
}

#[test]
fn sharp_fronts_stand_where_they_should() {
    let down = [0.0, -GAMMA];
    for cells in [10, 20] {
        let horizontal = front([cells, 1], [0.0; 2], &fed(0, 0.25), |x| x * x * N / (2.0 * K * 0.25));
        assert!(horizontal < 0.06, "{horizontal}");
        let falling = front([1, cells], down, &fed(3, 1.25), |x| N / K * (x - 0.25 * (1.0 + x / 0.25).ln()));
        assert!(falling < 0.06, "{falling}");
        let rising = front([1, cells], down, &fed(2, 1.2), |x| N / K * (-x - 1.2 * (1.0 - x / 1.2).ln()));
        assert!(rising < 0.3, "{rising}");
    }
}

#[test]
fn a_dam_discharges_by_charny_and_its_water_is_accounted_for() {
    let cells = 20;
    let h = 1.0 / cells as f64;
    let mut around = fed(0, 1.0);
    around.open[1] = true;
    let (grid, mut water) = block([cells, cells], h, [0.0, -GAMMA], &around);
    let mut layer = WaterLayer::new(&grid, &water, 2, 1000.0);
    let (mut closing, mut lost): (f64, f64) = (0.0, 0.0);
    run(&mut water, 6000.0, |water, _, dt| {
        layer.follow(&grid, water, dt, false);
        closing = closing.max((water.stored() - water.inflow + water.outflow).abs());
        let booked = layer.spawned as f64 - layer.removed as f64 - layer.points.len() as f64;
        let pending = layer.stored() + layer.pending() - water.inflow + water.outflow;
        lost = lost.max(booked.abs()).max(pending.abs());
    });
    assert!((water.rates[1] / (0.5 * K) - 1.0).abs() < 3e-3, "{}", water.rates[1] / K);
    assert!(closing < 1e-12 * water.inflow && lost < 1e-12 * water.inflow, "{closing:e} {lost:e}");
    // 0.76596 m2 of wet soil: the area under the free surface of the exact solution.
    assert!((water.stored() / N / 0.765_96 - 1.0).abs() < 2e-3, "{}", water.stored() / N);
    assert!((layer.stored() / water.stored() - 1.0).abs() < 1e-2, "{}", layer.stored() / water.stored());
    assert!(layer.mean_packing(&water) < 0.12, "{}", layer.mean_packing(&water));
}

#[test]
fn particles_leave_with_the_water_whatever_stands_outside() {
    let h = 0.1;
    // Tail water in a cell, at the edge of one, almost as high as the head, and a level that falls to that of both sides.
    for (left, right, bottom) in [
        (Some(1.0), Some(0.33), None),
        (Some(0.3), Some(1.0), None),
        (Some(1.0), Some(0.95), None),
        (Some(0.2), Some(0.2), None),
        (Some(1.0), None, Some(0.4)),
    ] {
        let mut around = CLOSED;
        around.feeds = [left, right, bottom, None].map(|head| head.map(Feed::Head));
        around.open[1] = true;
        let (grid, mut water) = block([10, 10], h, [0.0, -GAMMA], &around);
        let pores = water.pores(0);
        water.fill(&[0.8 * pores; 100]);
        let mut layer = WaterLayer::new(&grid, &water, 2, 1000.0);
        run(&mut water, 3000.0, |water, _, dt| {
            layer.follow(&grid, water, dt, false);
            let most = layer.rounding().pending * (1.0 + 1e-9);
            let off = layer.stored() + layer.pending() - water.stored();
            assert!(layer.pending().abs() <= most, "{left:?} {right:?}: {} of {most} m3 pending", layer.pending());
            assert!(off.abs() < 1e-12, "{left:?} {right:?}: {off:e} m3 was not booked");
        });
        let packed = layer.packing(&water);
        assert!(packed < 1.0, "{left:?} {right:?}: {packed} of a full cell too many or too few particles in one cell");
    }
}

#[test]
fn a_level_feeds_what_lies_below_it_and_no_more() {
    // 6 times 0.05 is more than 0.3 in floating point.
    let h = 0.05;
    for (head, faces) in [(0.3, 6.0), (0.33, 6.6), (6.0 * 0.05, 6.0), (0.3 * (1.0 + 1e-15), 6.0)] {
        let (_, water) = block([4, 20], h, [0.0, -GAMMA], &fed(1, head));
        let found: f64 = water.edges.iter().map(|edge| edge.open).sum();
        assert!((found - faces).abs() < 1e-9, "{head}: {found} faces, expected {faces}");
    }
}

#[test]
fn a_crest_that_is_open_draws_nothing_in() {
    // The free surface lies in the uppermost cells, a little below the crest.
    let stored = |open: bool| {
        let mut around = fed(0, 1.0);
        (around.feeds[1], around.open) = (Some(Feed::Head(0.9)), [false, true, false, open]);
        let (_, mut water) = block([10, 10], 0.1, [0.0, -GAMMA], &around);
        run(&mut water, 6000.0, |_, _, _| ());
        water.stored()
    };
    let (open, tight) = (stored(true), stored(false));
    assert!((open / tight - 1.0).abs() < 1e-6, "{open} m3 under an open crest, {tight} m3 under a tight one");
}

#[test]
fn a_full_column_drains_and_draws_nothing_in() {
    for rows in [10, 20] {
        let mut around = CLOSED;
        (around.open[2], around.open[3]) = (true, true);
        let (_, mut water) = block([1, rows], 1.0 / rows as f64, [0.0, -GAMMA], &around);
        let full: Vec<f64> = (0..rows).map(|cell| water.pores(cell)).collect();
        water.fill(&full);
        let first = water.stored();
        // The level is smeared as it falls; it has not yet come near the base.
        run(&mut water, 0.5 * N / K, |water, time, _| {
            assert_eq!(water.inflow, 0.0, "after {time} s");
            let off = water.stored() / first - (1.0 - K / N * time);
            assert!(off.abs() < 0.02, "after {time} s: {off}");
        });
    }
}

#[test]
fn a_flood_waits_until_there_is_room() {
    let cells = [8, 2];
    let (grid, mut water) = block(cells, 0.125, [0.0, -GAMMA], &fed(0, 0.5));
    let mut layer = WaterLayer::new(&grid, &water, 2, 1000.0);
    let (step, _) = water.step(1.0).unwrap();
    layer.follow(&grid, &water, step, false);
    let before = layer.stored() + layer.pending();
    // As much as never was: what is not yet a particle is pending, and none of it is lost.
    let ages = 1e15;
    layer.follow(&grid, &water, ages, false);
    let came: f64 = water.leaks().map(|(_, out)| -out * ages).sum();
    assert!(layer.points.len() <= 3 * 4 * cells[0] * cells[1], "{}", layer.points.len());
    let lost = layer.stored() + layer.pending() - before - came;
    assert!(came > 1e6 && lost.abs() < 1e-9 * came, "{lost:e} of {came:e}");
}

#[test]
fn still_water_stays() {
    let (_, mut water) = block([4, 8], 0.125, [0.0, -GAMMA], &CLOSED);
    // A level in the middle of the sixth row.
    let pores = water.pores(0);
    let content: Vec<f64> = (0..32).map(|c| pores * (5.5 - f64::from(c / 4)).clamp(0.0, 1.0)).collect();
    water.fill(&content);
    run(&mut water, 1e4, |_, _, _| ());
    for (cell, before) in content.iter().enumerate() {
        assert!((water.content[cell] - before).abs() < 1e-12 * pores);
        let still = GAMMA * 0.125 * (5.0 - f64::from(cell as u32 / 4));
        if cell / 4 < 5 {
            assert!((water.pressure[cell] - still).abs() < 1e-6 * GAMMA, "{cell}");
        }
    }
}

/// A block of unsaturated soil in equilibrium with a level, m.
fn unsaturated(cells: [usize; 2], around: &Surroundings, law: Retention, level: f64) -> FreeSurface<2> {
    let h = 1.0 / cells[1] as f64;
    let (grid, mut water) = block(cells, h, [0.0, -GAMMA], around);
    water.medium.retention = Some(law);
    water.surround(&grid, around);
    let rest: Vec<f64> = grid.walk().map(|(_, at)| GAMMA * (level - (at[1] as f64 + 0.5) * h)).collect();
    water.soak(&law, &rest);
    water
}

const LAWS: [Retention; 3] = [
    Retention::VanGenuchten { alpha: 3.5, n: 2.5, entry: 0.0 },
    Retention::Gardner { alpha: 5.0 },
    Retention::BrooksCorey { entry: 0.15, index: 2.0 },
];

#[test]
fn suction_above_a_level_holds_its_water() {
    for law in LAWS {
        let mut water = unsaturated([3, 20], &CLOSED, law, 0.43);
        let (first, pressure) = (water.content.clone(), water.pressure.clone());
        run(&mut water, 1e5, |_, _, _| {});
        for cell in 0..60 {
            let moved = (water.content[cell] - first[cell]).abs() / water.pores(cell);
            assert!(moved < 1e-9, "{law:?}: {moved:e}");
            assert!((water.pressure[cell] - pressure[cell]).abs() < 1e-3, "{law:?}");
        }
        // What the soil feels: suction of what is wet, and the whole pressure below the level.
        assert!(water.mean_pressure(0) > 0.0 && water.mean_pressure(59) < 0.0);
        assert!(water.mean_pressure(59) >= water.pressure[59]);
    }
}

#[test]
fn rain_enters_unsaturated_soil_or_runs_off_and_none_is_lost() {
    // Less than falls at k, and ten times as much on a column that drains at its base.
    for law in LAWS {
        for (share, runs_off) in [(0.5, false), (10.0, true)] {
            let mut around = CLOSED;
            around.open[2] = true;
            around.feeds[3] = Some(Feed::Velocity { speed: share * K, height: 1.0 });
            let mut water = unsaturated([2, 10], &around, law, -0.5);
            let first = water.stored();
            let mut closing: f64 = 0.0;
            run(&mut water, 3000.0, |water, _, _| {
                closing = closing.max((water.stored() - first - water.inflow + water.outflow).abs());
            });
            let width = 0.2;
            assert!(closing < 1e-13 * water.inflow, "{law:?}: {closing:e}");
            assert!((water.asked - share * K * width * 3000.0).abs() < 1e-12 * water.asked);
            assert!((water.asked - water.ran_off - water.inflow).abs() < 1e-12 * water.asked);
            assert_eq!(water.ran_off > 0.0, runs_off, "{law:?}: {}", water.ran_off);
            // In the end all that enters leaves at the base, at most as fast as full soil lets it fall.
            let flow = share.min(1.0) * K * width;
            assert!((water.rates[1] / flow - 1.0).abs() < 1e-2, "{law:?} {share}: {:e}", water.rates[1] / flow);
        }
    }
}

#[test]
fn a_stiff_retention_has_the_sharp_front_as_its_limit() {
    // Water 0.25 m above a dry column: Green and Ampt's front, without a fringe to speak of.
    let law = Retention::BrooksCorey { entry: 0.002, index: 8.0 };
    let around = fed(3, 1.25);
    let mut water = unsaturated([1, 20], &around, law, -1.0);
    let first = water.stored();
    let time_of = |x: f64| N / K * (x - 0.25 * (1.0 + x / 0.25).ln());
    run(&mut water, time_of(0.8), |_, _, _| {});
    let place = (water.stored() - first) / (N * 0.05);
    assert!((place - 0.8).abs() < 0.02, "{place}");
}
