//! What a run takes for granted, in words, from its scene.

use mpm_core::scene::{Feed, NormalStress, Scene};

use super::summary::Summary;
use crate::report::numbers::{brief, short};

/// What the paper does not say, or what is not as it says, in words.
pub fn of(scene: &Scene, s: &Summary) -> Vec<(&'static str, String)> {
    let mut all = vec![
        ("driver", s.driver.clone()),
        (
            "mesh",
            format!(
                "cells of {} m, {} particles per cell and layer: {} of soil, {} of water at the start",
                brief(scene.cell, 3),
                scene.particles_per_cell,
                s.solid_particles,
                s.water_particles
            ),
        ),
        ("step of the soil", format!("{} s", short(s.dt_s, 3))),
    ];
    if let Some(base) = scene.base {
        let stress = match base.normal_stress {
            NormalStress::Effective => "effective",
            NormalStress::Total => "total",
        };
        let law = match base.slip_distance {
            Some(distance) => format!(
                "{}° that falls to {}° over {} m of slip",
                brief(base.peak_angle, 3),
                brief(base.residual_angle, 3),
                brief(distance, 3)
            ),
            None => format!("{}° at any slip", brief(base.peak_angle, 3)),
        };
        all.push(("friction of the base", format!("{law}, on the {stress} stress")));
    }
    if let Some(water) = &scene.free_surface {
        all.push(("saturation ahead of the front", brief(water.saturation, 3)));
        if let Some(wet) = &water.wet {
            let corners: Vec<String> =
                wet.iter().map(|x| format!("({}, {})", brief(x[0], 3), brief(x[1], 3))).collect();
            let shown = if corners.len() > 5 { format!("{} corners", corners.len()) } else { corners.join(", ") };
            let area = mpm_core::seeding::area(wet);
            all.push(("water at the start", format!("{} m² of soil within {shown} m", short(area, 3))));
        }
        if let Some(feed) = water.feeds[0] {
            all.push((
                "feed",
                match feed {
                    Feed::Head(head) => format!("water at rest {} m high against the wall", brief(head, 3)),
                    Feed::Velocity { speed, height } => {
                        format!("a flux of {} m/s up to {} m", brief(speed, 2), brief(height, 3))
                    }
                },
            ));
        }
    }
    if let Some(water) = scene.water {
        all.push(("conductivity", format!("{} m/s", brief(water.hydraulic_conductivity, 3))));
    }
    if let Some(strength) = scene.strength {
        all.push((
            "strength",
            format!(
                "c = {} kPa, phi = {}°, psi = {}°",
                brief(1e-3 * strength.cohesion, 3),
                brief(strength.friction_angle, 3),
                brief(strength.dilation_angle, 3)
            ),
        ));
    }
    all
}
