//! What solvers are asked for: quantities with their units and signs, and where each stands in a run of ours.

use mpm_core::drive::Sample;
use mpm_core::observe::{FieldPoint, ProfileRow, Push, WaterState};

/// Something that a solver is asked for.
#[derive(Debug)]
pub struct Quantity {
    /// Its name in `results.csv`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is, with its sign.
    pub meaning: &'static str,
    /// Where it stands.
    pub at: At,
}

/// Where a quantity stands in a sample of a run.
#[derive(Debug)]
pub enum At {
    /// One number at a time.
    Whole {
        /// Reads it; the first sample of the run comes first.
        get: fn(&Sample, &Sample) -> f64,
        /// Writes it.
        set: fn(&mut Sample, f64),
    },
    /// At heights of a column.
    Height {
        /// Reads it.
        get: fn(&ProfileRow) -> f64,
        /// Writes it.
        set: fn(&mut ProfileRow, f64),
    },
    /// At places of a section.
    Place {
        /// Reads it.
        get: fn(&FieldPoint) -> f64,
        /// Writes it.
        set: fn(&mut FieldPoint, f64),
    },
    /// At places of the soil at the end.
    Soil,
}

fn water(sample: &mut Sample) -> &mut WaterState {
    sample.state.water.get_or_insert_default()
}

fn read(sample: &Sample, of: fn(&WaterState) -> f64) -> f64 {
    sample.state.water.as_ref().map_or(f64::NAN, of)
}

/// One number of the water.
macro_rules! of_water {
    ($field:ident) => {
        At::Whole { get: |_, s| read(s, |water| water.$field), set: |s, v| water(s).$field = v }
    };
}

/// One number of the state.
macro_rules! of_state {
    ($field:ident) => {
        At::Whole { get: |_, s| s.state.$field, set: |s, v| s.state.$field = v }
    };
}

const PORE_PRESSURE: &str = "pore pressure, above zero where water is compressed";

/// Settlement of the loaded surface.
pub static SETTLEMENT: Quantity = Quantity {
    name: "settlement",
    unit: "m",
    meaning: "how far the loaded surface is below its place in the unloaded state, downwards; of an axisymmetric or plane section the mean over its top",
    at: of_state!(settlement),
};
/// Pressure along a column.
pub static PRESSURE_ALONG: Quantity = Quantity {
    name: "pore_pressure",
    unit: "Pa",
    meaning: PORE_PRESSURE,
    at: At::Height { get: |row| row.pressure_pa, set: |row, v| row.pressure_pa = v },
};
/// Pressure in a section.
pub static PRESSURE: Quantity = Quantity {
    name: "pore_pressure",
    unit: "Pa",
    meaning: PORE_PRESSURE,
    at: At::Place { get: |point| point.pressure_pa, set: |point, v| point.pressure_pa = v },
};
/// Pressure at the base of a column.
pub static BASE_PRESSURE: Quantity = Quantity {
    name: "base_pressure",
    unit: "Pa",
    meaning: "pore pressure at the base, above zero where water is compressed",
    at: of_state!(base_pressure),
};
/// Saturation in a section.
pub static SATURATION: Quantity = Quantity {
    name: "effective_saturation",
    unit: "-",
    meaning: "share of the pores between residual and full saturation that water fills",
    at: At::Place { get: |point| point.saturation, set: |point, v| point.saturation = v },
};
/// Mobile water.
pub static WATER: Quantity = Quantity {
    name: "water_volume",
    unit: "m3",
    meaning: "mobile water in the soil, of a slice 1 m thick",
    at: of_water!(mobile_m3),
};
/// Water that came in.
pub static WATER_IN: Quantity = Quantity {
    name: "water_that_entered",
    unit: "m3",
    meaning: "water that has entered since the start, of a slice 1 m thick",
    at: of_water!(in_m3),
};
/// Water that left.
pub static WATER_OUT: Quantity = Quantity {
    name: "water_that_left",
    unit: "m3",
    meaning: "water that has left through the soil since the start, of a slice 1 m thick",
    at: of_water!(out_m3),
};
/// Rain that did not enter.
pub static RUN_OFF: Quantity = Quantity {
    name: "run_off",
    unit: "m3",
    meaning: "rain that has run off soil that was full, since the start, of a slice 1 m thick",
    at: of_water!(ran_off_m3),
};
/// Inflow.
pub static INFLOW: Quantity = Quantity {
    name: "inflow",
    unit: "m3/s",
    meaning: "water that enters the soil now, of a slice 1 m thick",
    at: of_water!(inflow_m3_s),
};
/// Outflow.
pub static OUTFLOW: Quantity = Quantity {
    name: "outflow",
    unit: "m3/s",
    meaning: "water that leaves the soil now, of a slice 1 m thick",
    at: of_water!(outflow_m3_s),
};
/// Largest speed.
pub static SPEED: Quantity =
    Quantity { name: "largest_speed", unit: "m/s", meaning: "largest speed of the soil", at: of_state!(max_speed) };
/// Way of the centre of mass.
pub static WAY: Quantity = Quantity {
    name: "way",
    unit: "m",
    meaning: "how far the centre of mass has moved along the base since the start, towards +x",
    at: At::Whole { get: |first, s| s.state.centre[0] - first.state.centre[0], set: |s, v| s.state.centre[0] = v },
};
/// Kinetic energy.
pub static KINETIC_ENERGY: Quantity = Quantity {
    name: "kinetic_energy",
    unit: "J",
    meaning: "kinetic energy of soil and pore water, of a slice 1 m thick",
    at: At::Whole { get: |_, s| s.balance.kinetic_j, set: |s, v| s.balance.kinetic_j = v },
};
/// Strain energy.
pub static STRAIN_ENERGY: Quantity = Quantity {
    name: "strain_energy",
    unit: "J",
    meaning: "elastic energy of the soil, of a slice 1 m thick (about an axis: of one radian)",
    at: At::Whole { get: |_, s| s.balance.strain_j, set: |s, v| s.balance.strain_j = v },
};
/// Force of a plate.
pub static PLATE_FORCE: Quantity = Quantity {
    name: "plate_force",
    unit: "N",
    meaning: "vertical force of the plate on the soil, upwards, of a slice 1 m thick",
    at: At::Whole {
        get: |_, s| s.state.plates.first().and_then(|push| push.force).map_or(f64::NAN, |force| force[1]),
        // Our measure looks at impulses: that of a force that does not change has this difference between any two times.
        set: |s, v| s.state.plates = vec![Push { impulse: [0.0, v * s.state.time], force: Some([0.0, v]) }],
    },
};
/// Mean stress in a section.
pub static MEAN_STRESS: Quantity = Quantity {
    name: "mean_stress",
    unit: "Pa",
    meaning: "mean of the three normal effective stresses, tension positive",
    at: At::Soil,
};

/// What has to be known of a run for each thing that is measured. A measure that is not named here reads what only a code of our kind has.
const OF_MEASURES: &[(&str, &[&Quantity])] = &[
    ("settlement", &[&SETTLEMENT]),
    ("settlement-in-stages", &[&SETTLEMENT]),
    ("profile-error", &[&PRESSURE_ALONG]),
    ("pressure-in-layers", &[&PRESSURE_ALONG]),
    ("pressure-beside-wells", &[&PRESSURE_ALONG]),
    ("pressure-steady-well", &[&PRESSURE_ALONG]),
    ("pressure-narrowed-pores", &[&PRESSURE_ALONG]),
    ("pressure-undrained", &[&PRESSURE_ALONG]),
    ("pressure-at-mid-height", &[&PRESSURE_ALONG]),
    ("arrival-at-mid-height", &[&PRESSURE_ALONG]),
    ("pressure-at-base", &[&BASE_PRESSURE]),
    ("pressure-mandel", &[&PRESSURE]),
    ("pressure-radial", &[&PRESSURE]),
    ("pressure-seabed", &[&PRESSURE]),
    ("pressure-around-well", &[&PRESSURE]),
    ("pressure-sealed-disc", &[&PRESSURE]),
    ("pressure-under-strip", &[&PRESSURE]),
    ("pressure-along-slope", &[&PRESSURE]),
    ("heads-in-series", &[&PRESSURE]),
    ("heads-along-layers", &[&PRESSURE]),
    ("infiltration", &[&SATURATION]),
    ("steady-suction", &[&SATURATION]),
    ("wetted-box", &[&SATURATION]),
    ("front", &[&WATER]),
    ("column-drains", &[&WATER, &WATER_IN]),
    ("filled-by-rain", &[&WATER, &WATER_OUT, &RUN_OFF]),
    ("discharge-of-dam", &[&INFLOW, &OUTFLOW]),
    ("discharge-of-zones", &[&INFLOW, &OUTFLOW]),
    ("discharge-of-capillary-dam", &[&INFLOW, &OUTFLOW]),
    ("speed", &[&SPEED]),
    ("way-of-block", &[&WAY]),
    ("velocity-of-slab", &[&KINETIC_ENERGY]),
    ("mean-settlement", &[&STRAIN_ENERGY]),
    ("plate-force", &[&PLATE_FORCE]),
    ("stress-under-strip", &[&MEAN_STRESS]),
];

/// What a solver is asked for where this is measured; `None` where only a code of our kind can answer.
pub fn of_measure(measure: &str) -> Option<&'static [&'static Quantity]> {
    OF_MEASURES.iter().find(|(name, _)| *name == measure).map(|(_, quantities)| *quantities)
}

/// Measures and references whose exact solutions have inertia.
const MOVING: &[&str] = &[
    "dynamic",
    "dry-wave",
    "damped",
    "pressure-at-mid-height",
    "arrival-at-mid-height",
    "pressure-at-base",
    "way-of-block",
    "velocity-of-slab",
    "speed",
];

/// Whether the exact solution has inertia.
pub fn moves(measure: &str, reference: &str) -> bool {
    MOVING.contains(&measure) || MOVING.contains(&reference)
}

/// References of large strain.
const LARGE: &[&str] = &["large-strain", "self-weight-drained", "oedometer", "cam-clay", "cam-clay-oedometer"];

/// Whether the exact solution is one of large strain.
pub fn is_large(measure: &str, reference: &str) -> bool {
    LARGE.contains(&reference) || measure == "pressure-narrowed-pores"
}
