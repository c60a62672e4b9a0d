//! Which numbers of a particle or a cell are in the files. Every name carries its unit and, of a stress, its sign. The first
//! scalar of a file is what ParaView colours it by.

use mpm_core::observe::Frame;
use vtkio::Vtk;

use super::data::{Array, cloud, squares};
use crate::frames::mean_stress;

/// Deviator strain of the soil.
pub const STRAIN: &str = "deviator_strain";
/// Effective stress of the soil as a tensor.
pub const STRESS: &str = "effective_stress_tension_positive_pa";
/// Pore pressure of all files.
pub const PRESSURE: &str = "pore_pressure_compression_positive_pa";
/// Mean effective stress.
pub const MEAN: &str = "mean_effective_stress_compression_positive_pa";

/// Particles of the solid layer.
pub fn solid(frame: &Frame) -> Vtk {
    let all = &frame.solid;
    let arrays = vec![
        Array::scalar(STRAIN, all, |p| p.deviator_strain),
        Array::scalar(PRESSURE, all, |p| p.pore_pressure),
        Array::scalar(MEAN, all, mean_stress),
        Array::tensor(STRESS, all, |p| p.stress),
        Array::vector("displacement_m", all, |p| p.displacement),
        Array::vector("velocity_m_per_s", all, |p| p.velocity),
        Array::scalar("volume_m3", all, |p| p.volume),
        Array::scalar("mass_kg", all, |p| p.mass),
    ];
    cloud(all, |p| p.x, Some(all.iter().map(|p| p.id).collect()), arrays)
}

/// Particles of the water layer.
pub fn water(frame: &Frame) -> Vtk {
    let all = &frame.water;
    let arrays = vec![
        Array::scalar(PRESSURE, all, |p| p.pressure),
        Array::scalar("volume_m3", all, |p| p.volume),
        Array::vector("velocity_m_per_s", all, |p| p.velocity),
    ];
    cloud(all, |p| p.x, None, arrays)
}

/// The cells of the mesh.
pub fn cells(frame: &Frame) -> Vtk {
    let all = &frame.cell;
    let arrays = vec![
        Array::scalar(PRESSURE, all, |c| c.pressure),
        Array::scalar("saturation", all, |c| c.saturation),
        Array::scalar("soil_share", all, |c| c.soil),
    ];
    squares(frame.cells, frame.size, arrays)
}
