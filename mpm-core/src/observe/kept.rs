//! What was read from a run, to be kept with its state.

use super::{FieldPoint, Ledger, Observation, ProfileRow, WaterState};
use crate::keep::Keeper;

impl Observation {
    /// Of nothing.
    pub(crate) const NONE: Self = Self {
        time: 0.0,
        settlement: 0.0,
        mean_pressure: 0.0,
        base_pressure: 0.0,
        max_speed: 0.0,
        centre: [0.0; 2],
        reach: [0.0; 2],
        least_volume: 0.0,
        checkerboard: 0.0,
        solid_crossings: 0,
        water_crossings: 0,
        profile: Vec::new(),
        field: Vec::new(),
        water: None,
    };

    /// Writes or reads it.
    pub(crate) fn keep(&mut self, keeper: &mut Keeper) {
        let Self {
            time,
            settlement,
            mean_pressure,
            base_pressure,
            max_speed,
            centre: [centre_x, centre_y],
            reach: [reach_x, reach_y],
            least_volume,
            checkerboard,
            solid_crossings,
            water_crossings,
            profile,
            field,
            water,
        } = self;
        for value in [
            time,
            settlement,
            mean_pressure,
            base_pressure,
            max_speed,
            centre_x,
            centre_y,
            reach_x,
            reach_y,
            least_volume,
            checkerboard,
        ] {
            keeper.f64(value);
        }
        keeper.u64(solid_crossings);
        keeper.u64(water_crossings);
        let row = ProfileRow { height_m: 0.0, material_height_m: 0.0, pressure_pa: 0.0, effective_stress_pa: 0.0 };
        keeper.list(profile, &row, |row, keeper| {
            let ProfileRow { height_m, material_height_m, pressure_pa, effective_stress_pa } = row;
            for value in [height_m, material_height_m, pressure_pa, effective_stress_pa] {
                keeper.f64(value);
            }
        });
        let point = FieldPoint { x_m: 0.0, y_m: 0.0, pressure_pa: 0.0, saturation: 0.0, soil: 0.0 };
        keeper.list(field, &point, |point, keeper| {
            let FieldPoint { x_m, y_m, pressure_pa, saturation, soil } = point;
            for value in [x_m, y_m, pressure_pa, saturation, soil] {
                keeper.f64(value);
            }
        });
        keeper.maybe(water, &WaterState::default(), WaterState::keep);
    }
}

impl WaterState {
    fn keep(&mut self, keeper: &mut Keeper) {
        let Self {
            mobile_m3,
            mobile_porosity,
            particles_m3,
            pending_m3,
            inflow_m3_s,
            outflow_m3_s,
            in_m3,
            out_m3,
            front_x_m,
            front_y_m,
            particles,
            spawned,
            removed,
            packing_mean,
            packing_max,
            unsettled,
        } = self;
        for value in [
            mobile_m3,
            mobile_porosity,
            particles_m3,
            pending_m3,
            inflow_m3_s,
            outflow_m3_s,
            in_m3,
            out_m3,
            front_x_m,
            front_y_m,
            packing_mean,
            packing_max,
        ] {
            keeper.f64(value);
        }
        for count in [particles, spawned, removed, unsettled] {
            keeper.u64(count);
        }
    }
}

impl Ledger {
    /// Of nothing.
    pub(crate) const NONE: Self = Self {
        solid_mass_kg: 0.0,
        solid_closing_kg: 0.0,
        water_stored_kg: 0.0,
        water_in_kg: 0.0,
        water_out_kg: 0.0,
        water_closing_kg: 0.0,
        momentum_n_s: 0.0,
        impulse_n_s: 0.0,
        cut_off_n_s: 0.0,
        momentum_closing_n_s: 0.0,
        kinetic_j: 0.0,
        strain_j: 0.0,
        water_j: 0.0,
        external_work_j: 0.0,
        gravity_work_j: 0.0,
        flow_body_work_j: 0.0,
        darcy_dissipation_j: 0.0,
        damping_loss_j: 0.0,
        energy_closing_j: 0.0,
        water_particles_removed_kg: 0.0,
        base_friction_j: 0.0,
        plastic_dissipation_j: 0.0,
        yield_residual_max: None,
        pressure_work_j: 0.0,
    };

    /// Writes or reads it.
    pub(crate) fn keep(&mut self, keeper: &mut Keeper) {
        let Self {
            solid_mass_kg,
            solid_closing_kg,
            water_stored_kg,
            water_in_kg,
            water_out_kg,
            water_closing_kg,
            momentum_n_s,
            impulse_n_s,
            cut_off_n_s,
            momentum_closing_n_s,
            kinetic_j,
            strain_j,
            water_j,
            external_work_j,
            gravity_work_j,
            flow_body_work_j,
            darcy_dissipation_j,
            damping_loss_j,
            energy_closing_j,
            water_particles_removed_kg,
            base_friction_j,
            plastic_dissipation_j,
            yield_residual_max,
            pressure_work_j,
        } = self;
        for value in [
            solid_mass_kg,
            solid_closing_kg,
            water_stored_kg,
            water_in_kg,
            water_out_kg,
            water_closing_kg,
            momentum_n_s,
            impulse_n_s,
            cut_off_n_s,
            momentum_closing_n_s,
            kinetic_j,
            strain_j,
            water_j,
            external_work_j,
            gravity_work_j,
            flow_body_work_j,
            darcy_dissipation_j,
            damping_loss_j,
            energy_closing_j,
            water_particles_removed_kg,
            base_friction_j,
            plastic_dissipation_j,
            pressure_work_j,
        ] {
            keeper.f64(value);
        }
        keeper.maybe(yield_residual_max, &0.0, |value, keeper| keeper.f64(value));
    }
}
