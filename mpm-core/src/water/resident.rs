//! Water whose particles live elsewhere: what the step over lanes needs of it.

use super::{Dry, Exposed, Face, Saturated, Water};
use crate::dimension::PlaneStrain;
use crate::particles::{Layer, WaterPoint};

/// Darcy's law on a face between two cells, and the water it moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct FaceFlow {
    /// k/(gamma_w L): flux per pressure drop, m/(s Pa).
    pub conductance: f64,
    /// rho_w L: pressure drop per m/s2.
    pub weight: f64,
    /// 1 keeps `rho_w a_s` in Darcy's law, 0 leaves it out.
    pub inertia: f64,
    /// Area of a face, m2.
    pub area: f64,
    /// Volume of a cell full of soil, m3.
    pub cell_volume: f64,
    /// k/(gamma_w L^2), 1/(Pa s).
    pub diffusion: f64,
    /// K_w, Pa.
    pub bulk_modulus: f64,
    /// Volume of the grains per mass, m3/kg.
    pub grain_inverse: f64,
    /// rho_w, kg/m3.
    pub density: f64,
}

/// Water that lends its particles to a step that keeps them in its own order.
pub trait Resident: Water<PlaneStrain, 2, 4> + Clone + 'static {
    /// Gives its particles away; none when dry.
    fn lend(&mut self) -> Option<Layer<WaterPoint<2>, 2>>;
    /// Takes particles back.
    fn take(&mut self, layer: Option<Layer<WaterPoint<2>, 2>>);
    /// Books particles that have changed their cells, and the mass of those taken out of the soil, kg.
    fn book(&mut self, crossings: u64, removed_mass: f64);
    /// Its law of flow.
    fn face_flow(&self) -> FaceFlow;
    /// Faces that touch no other soil, and which sides of it are drained.
    fn outline(&self) -> (&[super::ExposedFace], [bool; 4]);
}

impl Resident for Dry {
    fn lend(&mut self) -> Option<Layer<WaterPoint<2>, 2>> {
        None
    }

    fn take(&mut self, _: Option<Layer<WaterPoint<2>, 2>>) {}

    fn book(&mut self, _: u64, _: f64) {}

    fn face_flow(&self) -> FaceFlow {
        FaceFlow::default()
    }

    fn outline(&self) -> (&[super::ExposedFace], [bool; 4]) {
        (&[], [false; 4])
    }
}

impl Resident for Saturated<Face<2>, 2> {
    fn lend(&mut self) -> Option<Layer<WaterPoint<2>, 2>> {
        Some(std::mem::take(&mut self.points))
    }

    fn take(&mut self, layer: Option<Layer<WaterPoint<2>, 2>>) {
        self.points = layer.unwrap_or_default();
        // Whoever had them moved them.
        self.moved = true;
    }

    fn book(&mut self, crossings: u64, removed_mass: f64) {
        self.points.crossings += crossings;
        self.removed_mass += removed_mass;
    }

    fn face_flow(&self) -> FaceFlow {
        self.operator.flow_law(&self.properties, self.grain_inverse)
    }

    fn outline(&self) -> (&[super::ExposedFace], [bool; 4]) {
        let Exposed { faces } = &self.exposed;
        (faces, self.drained)
    }
}
