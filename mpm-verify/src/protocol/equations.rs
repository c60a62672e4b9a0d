//! The equations that a neutral case solves, found from its scene: those of balance and of the soil, never a solution.

use mpm_core::scene::{Dimension, Scene};
use mpm_core::water::retention::Retention;

/// The equations of a scene, in LaTeX, with inertia and at large strain or not.
pub fn governing(scene: &Scene, inertia: bool, large: bool) -> Vec<String> {
    let mut all = vec![momentum(scene, inertia)];
    all.extend(water(scene, inertia));
    all.extend(soil(scene, large).iter().map(|equation| (*equation).to_owned()));
    all
}

/// Balance of momentum of the mixture.
fn momentum(scene: &Scene, inertia: bool) -> String {
    let pressure = match (scene.water, scene.biot) {
        (None, _) => "",
        (Some(_), None) => r" - p\,\mathbf{I}",
        (Some(_), Some(_)) => r" - \alpha p\,\mathbf{I}",
    };
    let weight = if scene.gravity.is_some() { r" + \rho\,\mathbf{g}" } else { "" };
    let right = if inertia { r"\rho\,\ddot{\mathbf{u}}" } else { r"\mathbf{0}" };
    format!(r"\nabla\cdot(\boldsymbol\sigma'{pressure}){weight} = {right}")
}

/// Balance of mass of the water, with Darcy's law.
fn water(scene: &Scene, inertia: bool) -> Option<String> {
    scene.water?;
    let weight = if scene.gravity.is_some() { r" - \rho_w\mathbf{g}" } else { "" };
    if let Some(free) = &scene.free_surface {
        let flow = format!(r"\frac{{k\,k_r}}{{\gamma_w}}(\nabla p{weight})");
        return Some(match free.retention {
            Some(Retention::Gardner { .. }) => format!(
                r"\frac{{\partial (n S)}}{{\partial t}} = \nabla\cdot\left[{flow}\right], \quad k_r = S_e = e^{{-\alpha s}}"
            ),
            Some(_) => format!(r"\frac{{\partial (n S)}}{{\partial t}} = \nabla\cdot\left[{flow}\right]"),
            None => format!(
                r"\mathbf{{w}} = -\frac{{k}}{{\gamma_w}}(\nabla p{weight}), \quad \nabla\cdot\mathbf{{w}} = 0 \ \text{{where soil is full}}, \quad p = 0 \ \text{{at the surface of the water}}"
            ),
        });
    }
    let moved = if inertia && scene.darcy_inertia { r" + \rho_w\ddot{\mathbf{u}}" } else { "" };
    let (alpha, storage) = match scene.biot {
        None => ("", r"\frac{n}{K_w}"),
        Some(_) => (r"\alpha\,", r"\left(\frac{n}{K_w} + \frac{\alpha - n}{K_s}\right)"),
    };
    Some(format!(
        r"\nabla\cdot\left[\frac{{k}}{{\gamma_w}}(\nabla p{weight}{moved})\right] = {alpha}\nabla\cdot\dot{{\mathbf{{u}}}} + {storage}\,\dot p"
    ))
}

/// The law of the soil, stress above zero in tension.
fn soil(scene: &Scene, large: bool) -> Vec<&'static str> {
    const HOOKE: &str =
        r"\boldsymbol\sigma' = \lambda\,(\nabla\cdot\mathbf{u})\,\mathbf{I} + 2G\,\boldsymbol\varepsilon";
    const COLUMN: &str = r"\sigma'_y = M\,\ln J, \quad M = \frac{E\,(1 - \nu)}{(1 + \nu)(1 - 2\nu)}, \quad J = \text{length over first length}";
    let elastic = if large && scene.dimension == Dimension::Column { COLUMN } else { HOOKE };
    match (scene.strength, scene.cam_clay) {
        (_, Some(_)) => vec![
            r"f = q^2 - M^2 p'\,(p_c - p'), \quad K = p'/\kappa, \quad \dot p_c/p_c = -\dot\varepsilon_v^p/(\lambda - \kappa)",
            r"p' \ \text{counts from the attraction}, \quad \boldsymbol\varepsilon \ \text{logarithmic}",
        ],
        (Some(_), None) => {
            vec![elastic, r"f = \sigma_1 - \sigma_3 + (\sigma_1 + \sigma_3)\sin\phi - 2c\cos\phi \le 0"]
        }
        (None, None) => vec![elastic],
    }
}
