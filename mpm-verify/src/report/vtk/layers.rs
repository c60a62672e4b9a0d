//! Which numbers of a particle or a cell are in the files. Every name carries its unit, as columns do.

use mpm_core::observe::Frame;
use vtkio::Vtk;

use super::data::{Array, cloud, squares};
use crate::frames::mean_stress;

/// Particles of the solid layer. Stress is effective, tension positive; its mean is compression positive.
pub fn solid(frame: &Frame) -> Vtk {
    let all = &frame.solid;
    let arrays = vec![
        Array::scalar("deviator_strain", all, |p| p.deviator_strain),
        Array::scalar("pore_pressure_pa", all, |p| p.pore_pressure),
        Array::scalar("mean_effective_stress_pa", all, mean_stress),
        Array::scalar("stress_xx_pa", all, |p| p.stress[0]),
        Array::scalar("stress_yy_pa", all, |p| p.stress[1]),
        Array::scalar("stress_zz_pa", all, |p| p.stress[2]),
        Array::scalar("stress_xy_pa", all, |p| p.stress[3]),
        Array::scalar("volume_m3", all, |p| p.volume),
        Array::scalar("mass_kg", all, |p| p.mass),
        Array::vector("displacement_m", all, |p| p.displacement),
        Array::vector("velocity_m_per_s", all, |p| p.velocity),
    ];
    cloud(all, |p| p.x, Some(all.iter().map(|p| p.id).collect()), arrays)
}

/// Particles of the water layer.
pub fn water(frame: &Frame) -> Vtk {
    let all = &frame.water;
    let arrays = vec![
        Array::scalar("pore_pressure_pa", all, |p| p.pressure),
        Array::scalar("volume_m3", all, |p| p.volume),
        Array::vector("velocity_m_per_s", all, |p| p.velocity),
    ];
    cloud(all, |p| p.x, None, arrays)
}

/// The cells of the mesh.
pub fn cells(frame: &Frame) -> Vtk {
    let all = &frame.cell;
    let arrays = vec![
        Array::scalar("soil", all, |c| c.soil),
        Array::scalar("saturation", all, |c| c.saturation),
        Array::scalar("pore_pressure_pa", all, |c| c.pressure),
    ];
    squares(frame.cells, frame.size, arrays)
}
