//! What a user can choose: integrator, shape functions, Darcy operator, what carries velocities.

use mpm_core::scene::{
    DarcyChoice, Dimension, DomainChoice, Fields, Integrator, Scene, ShapeChoice, Side, SolidSide, StrainChoice,
    TransferChoice, UpdateChoice,
};

use crate::error::Error;
use crate::study::word;

/// A way to compute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scheme {
    /// How time is integrated.
    pub integrator: Integrator,
    /// Shape functions.
    pub shape: ShapeChoice,
    /// Darcy operator.
    pub darcy: DarcyChoice,
    /// What a particle gives to a node.
    pub transfer: TransferChoice,
    /// Which velocities strain the soil.
    pub update: UpdateChoice,
    /// What of a particle is strained and stressed.
    pub domain: DomainChoice,
}

impl Scheme {
    /// A scheme without options.
    pub const fn new(integrator: Integrator, shape: ShapeChoice) -> Self {
        Self {
            integrator,
            shape,
            darcy: DarcyChoice::Face,
            transfer: TransferChoice::Plain,
            update: UpdateChoice::Usl,
            domain: DomainChoice::Point,
        }
    }

    /// With the paper's Darcy operator.
    pub const fn nodal(self) -> Self {
        Self { darcy: DarcyChoice::Nodal, ..self }
    }

    /// With affine velocities.
    pub const fn affine(self) -> Self {
        Self { transfer: TransferChoice::Affine, ..self }
    }

    /// With strains by velocities mapped back.
    pub const fn musl(self) -> Self {
        Self { update: UpdateChoice::Musl, ..self }
    }

    /// With particles that are boxes.
    pub const fn contiguous(self) -> Self {
        Self { domain: DomainChoice::Contiguous, ..self }
    }

    /// Whether it is what an integrator takes where a scene says nothing else.
    pub fn is_default(&self, dimension: Dimension) -> bool {
        let splits = dimension == Dimension::PlaneStrain && self.integrator != Integrator::QuasiStatic;
        *self == Self::new(self.integrator, if splits { ShapeChoice::BBar } else { ShapeChoice::Centre })
    }

    /// Whether it carries velocities in a way that is not the usual one.
    pub fn has_option(&self) -> bool {
        let carries = self.transfer != TransferChoice::Plain || self.update != UpdateChoice::Usl;
        carries || self.domain != DomainChoice::Point
    }

    /// Its name: shape functions and options, `centre nodal`, `linear musl`.
    pub fn name(&self) -> String {
        let mut name = word(self.shape);
        if self.darcy == DarcyChoice::Nodal {
            name += " nodal";
        }
        if self.transfer == TransferChoice::Affine {
            name += " affine";
        }
        if self.update == UpdateChoice::Musl {
            name += " musl";
        }
        if self.domain == DomainChoice::Contiguous {
            name += " contiguous";
        }
        name
    }

    /// A scene with this scheme.
    ///
    /// # Errors
    /// The scheme is not for such a scene.
    pub fn on(&self, scene: &Scene) -> Result<Scene, Error> {
        Ok(scene.edited(|scene| self.put_on(scene))?)
    }

    /// Only what has no inertia takes the first geometry for all times.
    pub fn put_on(&self, scene: &mut Fields) {
        let quasi_static = self.integrator == Integrator::QuasiStatic;
        (scene.integrator, scene.shape, scene.darcy) = (self.integrator, self.shape, self.darcy);
        (scene.transfer, scene.update, scene.particle_domain) = (self.transfer, self.update, self.domain);
        scene.strain = if quasi_static { StrainChoice::Small } else { StrainChoice::Large };
        if scene.water.is_some() {
            // Where nothing holds the base, nodes at both ends carry next to nothing and their acceleration would drive the water.
            let held = scene.solid_sides[Side::Bottom as usize] != SolidSide::Free;
            scene.darcy_inertia = !quasi_static && held && !scene.inertia_feeds_waves();
        }
        scene.particles_per_cell = if quasi_static { 9 } else { 4 };
        scene.light_nodes = scene.usual_light_nodes();
    }
}

const fn explicit(shape: ShapeChoice) -> Scheme {
    Scheme::new(Integrator::Explicit, shape)
}

const fn semi_implicit(shape: ShapeChoice) -> Scheme {
    Scheme::new(Integrator::SemiImplicit, shape)
}

const fn quasi_static(shape: ShapeChoice) -> Scheme {
    Scheme::new(Integrator::QuasiStatic, shape)
}

/// Explicit schemes for soil without water, remedies last.
pub const DRY: [Scheme; 10] = [
    explicit(ShapeChoice::Centre),
    explicit(ShapeChoice::Linear),
    explicit(ShapeChoice::BBar),
    explicit(ShapeChoice::Gimp),
    explicit(ShapeChoice::Bspline2),
    explicit(ShapeChoice::Centre).musl(),
    explicit(ShapeChoice::Linear).musl(),
    explicit(ShapeChoice::BBar).musl(),
    explicit(ShapeChoice::Gimp).affine(),
    explicit(ShapeChoice::Bspline2).affine(),
];

/// Schemes for saturated soil with inertia.
pub const MOVING: [Scheme; 16] = [
    explicit(ShapeChoice::Centre),
    explicit(ShapeChoice::Centre).nodal(),
    explicit(ShapeChoice::Linear),
    explicit(ShapeChoice::BBar),
    explicit(ShapeChoice::Gimp),
    explicit(ShapeChoice::Bspline2),
    explicit(ShapeChoice::Centre).musl(),
    explicit(ShapeChoice::BBar).musl(),
    explicit(ShapeChoice::Centre).contiguous(),
    semi_implicit(ShapeChoice::Centre),
    semi_implicit(ShapeChoice::Linear),
    semi_implicit(ShapeChoice::BBar),
    semi_implicit(ShapeChoice::Gimp),
    semi_implicit(ShapeChoice::Bspline2),
    semi_implicit(ShapeChoice::Centre).contiguous(),
    semi_implicit(ShapeChoice::BBar).contiguous(),
];

/// Schemes for saturated soil that stays in place.
pub const STANDING: [Scheme; 15] = [
    explicit(ShapeChoice::Centre),
    explicit(ShapeChoice::Centre).nodal(),
    explicit(ShapeChoice::Linear),
    explicit(ShapeChoice::BBar),
    explicit(ShapeChoice::Gimp),
    explicit(ShapeChoice::Bspline2),
    semi_implicit(ShapeChoice::Centre),
    semi_implicit(ShapeChoice::Linear),
    semi_implicit(ShapeChoice::BBar),
    semi_implicit(ShapeChoice::Gimp),
    semi_implicit(ShapeChoice::Bspline2),
    quasi_static(ShapeChoice::Centre),
    quasi_static(ShapeChoice::Linear),
    quasi_static(ShapeChoice::Gimp),
    quasi_static(ShapeChoice::Bspline2),
];
