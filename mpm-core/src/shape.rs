//! Where the linear shape functions are evaluated for stress, pore pressure and strain.
//!
//! Mass, momentum and velocity always use N_i at the particle. The choice below is about gradients (and, in
//! Darcy's law, about N_i): the paper's stabilisation takes them at the centre of the cell.

/// An evaluation point for gradients.
pub trait Shape: Copy + Send + Sync + 'static {
    /// Whether all particles of a cell share the point.
    const AT_CENTRE: bool;
    /// Whether that point is the centroid of the soil in the cell, and not the centre of the cell.
    const AT_CENTROID: bool = false;
    /// Whether what changes volumes is taken at the centre of the cell all the same.
    const SPLIT: bool = false;
    /// Where the pore pressure acts, which changes volumes alone.
    type Pore: Shape;
}

/// Values at the centre of the cell (the paper, section 2.2): G_i(x_p) is replaced by G_i(x_c).
#[derive(Debug, Clone, Copy)]
pub struct Centre;

impl Shape for Centre {
    const AT_CENTRE: bool = true;
    type Pore = Self;
}

/// Values at the centroid of the soil in the cell: the same where a cell is full. Along a slope, where cells are filled in
/// part, the gradients are then those of the soil that is there, and the force of a uniform stress on it is exact.
#[derive(Debug, Clone, Copy)]
pub struct Centroid;

impl Shape for Centroid {
    const AT_CENTRE: bool = true;
    const AT_CENTROID: bool = true;
    type Pore = Self;
}

/// The standard linear scheme: G_i at the particle.
#[derive(Debug, Clone, Copy)]
pub struct Linear;

impl Shape for Linear {
    const AT_CENTRE: bool = false;
    type Pore = Self;
}

/// Selective integration, B-bar (Hughes 1980, doi:10.1002/nme.1620150914): the mean stress and the change of volume at the
/// centre of the cell, the rest at the particle. `sigma : grad N_i` becomes `s : G_i(x_p) + sigma_m div N_i(x_c)`.
///
/// Cells keep their volume without locking, as at the centre alone, and their hourglass modes, which the centre does not
/// see, are held by the shear of the particles. Fields that are linear over the mesh are the same under all three.
#[derive(Debug, Clone, Copy)]
pub struct BBar;

impl Shape for BBar {
    const AT_CENTRE: bool = false;
    const SPLIT: bool = true;
    type Pore = Centre;
}
