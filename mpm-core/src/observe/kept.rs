//! What was read from a run, to be kept with its state.

use super::{FieldPoint, Ledger, Observation, ProfileRow, WaterState};
use crate::keep::Keeper;

/// Keeps the numbers of a structure and gives names to what it holds beside them. The compiler sees to it that none is left out.
macro_rules! keep_numbers {
    ($keeper:ident, $of:expr => $Type:ident { $($number:ident),* $(; $($other:ident),*)? }) => {
        let $Type { $($number,)* $($($other,)*)? } = $of;
        $($keeper.f64($number);)*
    };
}

impl Observation {
    /// Writes or reads it.
    pub(crate) fn keep(&mut self, keeper: &mut Keeper) {
        keep_numbers!(keeper, self => Observation {
            time, settlement, mean_pressure, base_pressure, max_speed, least_volume, soil_volume, checkerboard;
            centre, reach, solid_crossings, water_crossings, profile, field, water
        });
        keeper.f64s(centre);
        keeper.f64s(reach);
        keeper.u64(solid_crossings);
        keeper.u64(water_crossings);
        keeper.list(profile, &ProfileRow::default(), |row, keeper| {
            keep_numbers!(keeper, row => ProfileRow { height_m, material_height_m, pressure_pa, effective_stress_pa });
        });
        keeper.list(field, &FieldPoint::default(), |point, keeper| {
            keep_numbers!(keeper, point => FieldPoint { x_m, y_m, pressure_pa, saturation, soil });
        });
        keeper.maybe(water, &WaterState::default(), WaterState::keep);
    }
}

impl WaterState {
    fn keep(&mut self, keeper: &mut Keeper) {
        keep_numbers!(keeper, self => WaterState {
            mobile_m3, mobile_porosity, particles_m3, pending_m3, inflow_m3_s, outflow_m3_s, in_m3, out_m3,
            front_x_m, front_y_m, packing_mean, packing_max, pending_allowed_m3, asked_m3, ran_off_m3;
            particles, spawned, removed, unsettled
        });
        for count in [particles, spawned, removed, unsettled] {
            keeper.u64(count);
        }
    }
}

impl Ledger {
    /// Writes or reads it.
    pub(crate) fn keep(&mut self, keeper: &mut Keeper) {
        keep_numbers!(keeper, self => Ledger {
            solid_mass_kg, solid_closing_kg, water_stored_kg, water_in_kg, water_out_kg, water_closing_kg,
            momentum_n_s, impulse_n_s, cut_off_n_s, momentum_closing_n_s, kinetic_j, strain_j, water_j,
            external_work_j, gravity_work_j, flow_body_work_j, darcy_dissipation_j, damping_loss_j, energy_closing_j,
            water_particles_removed_kg, base_friction_j, plastic_dissipation_j, pressure_work_j, transfer_loss_j, momentum_carried_n_s;
            yield_residual_max
        });
        keeper.maybe(yield_residual_max, &0.0, |value, keeper| keeper.f64(value));
    }
}
