//! Tables of a run: `history.csv`, `profiles.csv`, `field.csv`, `water.csv`, `state.csv`.

use std::path::Path;

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::SolidState;
use mpm_core::scene::{Dimension, Scene};
use mpm_verify::cases::own::compared::plates;
use serde::Serialize;

use crate::commands::{Failure, write_csv};

/// A row of history.csv.
#[derive(Debug, Serialize)]
struct Row {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    step: u64,
    settlement_m: f64,
    mean_pressure_pa: f64,
    base_pressure_pa: f64,
    max_speed_m_s: f64,
    checkerboard: f64,
    solid_crossings: u64,
    water_crossings: u64,
    solid_mass_kg: f64,
    solid_residual_kg: f64,
    water_stored_kg: f64,
    water_in_kg: f64,
    water_out_kg: f64,
    water_residual_kg: f64,
    momentum_n_s: f64,
    impulse_n_s: f64,
    momentum_residual_n_s: f64,
    kinetic_j: f64,
    strain_j: f64,
    water_j: f64,
    external_work_j: f64,
    gravity_work_j: f64,
    flow_body_work_j: f64,
    darcy_dissipation_j: f64,
    damping_loss_j: f64,
    energy_residual_j: f64,
    water_particles_removed_kg: f64,
    base_friction_j: f64,
    centre_x_m: f64,
    centre_y_m: f64,
    reach_x_m: f64,
    reach_y_m: f64,
    plastic_dissipation_j: f64,
    yield_residual_max: Option<f64>,
    cut_off_n_s: f64,
    transfer_loss_j: f64,
    momentum_carried_n_s: f64,
    soil_volume_m3: f64,
    /// Force of all moved plates on the soil, per metre; in a dynamic run its mean since the previous row.
    plates_x_n: Option<f64>,
    plates_y_n: Option<f64>,
}

/// A row of profiles.csv.
#[derive(Debug, Serialize)]
struct ProfileLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    height_m: f64,
    material_height_m: f64,
    pressure_pa: f64,
    effective_stress_pa: f64,
}

/// A row of field.csv: the pore pressure over the plane, of quasi-static runs in plane strain and staggered runs.
#[derive(Debug, Serialize)]
struct FieldLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    x_m: f64,
    y_m: f64,
    pressure_pa: f64,
    /// Degree of saturation by mobile water.
    saturation: f64,
    /// Volume fraction of soil in the cell.
    soil: f64,
}

/// A row of water.csv: water with a free surface.
#[derive(Debug, Serialize)]
struct WaterLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    mobile_m3: f64,
    particles_m3: f64,
    pending_m3: f64,
    inflow_m3_s: f64,
    outflow_m3_s: f64,
    in_m3: f64,
    out_m3: f64,
    front_x_m: f64,
    front_y_m: f64,
    particles: u64,
    spawned: u64,
    removed: u64,
    packing_mean: f64,
    packing_max: f64,
    unsettled: u64,
    pending_allowed_m3: f64,
    asked_m3: f64,
    ran_off_m3: f64,
}

/// Writes the files of a run.
pub fn write(scene: &Scene, run: &Run, folder: &Path) -> Result<(), Failure> {
    write_csv(&folder.join("history.csv"), &history(run))?;
    if scene.profiles {
        write_csv(&folder.join("profiles.csv"), &profiles(run))?;
    }
    let field = field(run);
    if !field.is_empty() {
        write_csv(&folder.join("field.csv"), &field)?;
    }
    let water = water(run);
    if !water.is_empty() {
        write_csv(&folder.join("water.csv"), &water)?;
    }
    Ok(())
}

/// Writes state.csv, whose columns are those of a table of `[initial]`: without x for a column.
pub fn write_state(scene: &Scene, end: &[SolidState], path: &Path) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_path(path).map_err(Failure::run_failed)?;
    let names = "x_m,y_m,pressure_pa,stress_xx_pa,stress_yy_pa,stress_zz_pa,stress_xy_pa".split(',');
    let from = usize::from(scene.dimension == Dimension::Column);
    writer.write_record(names.skip(from)).map_err(Failure::run_failed)?;
    for SolidState { x: [x, y], pore_pressure, stress: [xx, yy, zz, xy], .. } in end {
        let row = [x, y, if scene.water.is_some() { pore_pressure } else { &0.0 }, xx, yy, zz, xy];
        writer.write_record(row.iter().skip(from).map(|number| format!("{number:e}"))).map_err(Failure::run_failed)?;
    }
    writer.flush().map_err(Failure::run_failed)
}

fn history(run: &Run) -> Vec<Row> {
    let row = |(number, s): (usize, &Sample)| {
        let (o, l) = (&s.state, &s.balance);
        let plates = plates(s, number.checked_sub(1).map(|before| &run.samples[before]));
        Row {
            time_s: o.time,
            stage: s.stage,
            stage_time_s: s.stage_time,
            step: s.step,
            settlement_m: o.settlement,
            mean_pressure_pa: o.mean_pressure,
            base_pressure_pa: o.base_pressure,
            max_speed_m_s: o.max_speed,
            checkerboard: o.checkerboard,
            solid_crossings: o.solid_crossings,
            water_crossings: o.water_crossings,
            solid_mass_kg: l.solid_mass_kg,
            solid_residual_kg: l.solid_residual_kg,
            water_stored_kg: l.water_stored_kg,
            water_in_kg: l.water_in_kg,
            water_out_kg: l.water_out_kg,
            water_residual_kg: l.water_residual_kg,
            momentum_n_s: l.momentum_n_s,
            impulse_n_s: l.impulse_n_s,
            momentum_residual_n_s: l.momentum_residual_n_s,
            kinetic_j: l.kinetic_j,
            strain_j: l.strain_j,
            water_j: l.water_j,
            external_work_j: l.external_work_j,
            gravity_work_j: l.gravity_work_j,
            flow_body_work_j: l.flow_body_work_j,
            darcy_dissipation_j: l.darcy_dissipation_j,
            damping_loss_j: l.damping_loss_j,
            energy_residual_j: l.energy_residual_j,
            water_particles_removed_kg: l.water_particles_removed_kg,
            base_friction_j: l.base_friction_j,
            centre_x_m: o.centre[0],
            centre_y_m: o.centre[1],
            reach_x_m: o.reach[0],
            reach_y_m: o.reach[1],
            plastic_dissipation_j: l.plastic_dissipation_j,
            yield_residual_max: l.yield_residual_max,
            cut_off_n_s: l.cut_off_n_s,
            transfer_loss_j: l.transfer_loss_j,
            momentum_carried_n_s: l.momentum_carried_n_s,
            soil_volume_m3: o.soil_volume,
            plates_x_n: plates.map(|force| force[0]),
            plates_y_n: plates.map(|force| force[1]),
        }
    };
    run.samples.iter().enumerate().map(row).collect()
}

fn water(run: &Run) -> Vec<WaterLine> {
    let line = |s: &Sample| {
        let w = s.state.water?;
        Some(WaterLine {
            time_s: s.state.time,
            stage: s.stage,
            stage_time_s: s.stage_time,
            mobile_m3: w.mobile_m3,
            particles_m3: w.particles_m3,
            pending_m3: w.pending_m3,
            inflow_m3_s: w.inflow_m3_s,
            outflow_m3_s: w.outflow_m3_s,
            in_m3: w.in_m3,
            out_m3: w.out_m3,
            front_x_m: w.front_x_m,
            front_y_m: w.front_y_m,
            particles: w.particles,
            spawned: w.spawned,
            removed: w.removed,
            packing_mean: w.packing_mean,
            packing_max: w.packing_max,
            unsettled: w.unsettled,
            pending_allowed_m3: w.pending_allowed_m3,
            asked_m3: w.asked_m3,
            ran_off_m3: w.ran_off_m3,
        })
    };
    run.samples.iter().filter_map(line).collect()
}

fn field(run: &Run) -> Vec<FieldLine> {
    let lines = |s: &Sample| {
        let (time_s, stage, stage_time_s) = (s.state.time, s.stage, s.stage_time);
        let line = move |point: &mpm_core::observe::FieldPoint| FieldLine {
            time_s,
            stage,
            stage_time_s,
            x_m: point.x_m,
            y_m: point.y_m,
            pressure_pa: point.pressure_pa,
            saturation: point.saturation,
            soil: point.soil,
        };
        s.state.field.iter().map(line).collect::<Vec<_>>()
    };
    run.samples.iter().filter(|s| s.observed).flat_map(lines).collect()
}

fn profiles(run: &Run) -> Vec<ProfileLine> {
    let lines = |s: &Sample| {
        let (time_s, stage, stage_time_s) = (s.state.time, s.stage, s.stage_time);
        let line = move |row: &mpm_core::observe::ProfileRow| ProfileLine {
            time_s,
            stage,
            stage_time_s,
            height_m: row.height_m,
            material_height_m: row.material_height_m,
            pressure_pa: row.pressure_pa,
            effective_stress_pa: row.effective_stress_pa,
        };
        s.state.profile.iter().map(line).collect::<Vec<_>>()
    };
    run.samples.iter().filter(|s| s.observed).flat_map(lines).collect()
}
