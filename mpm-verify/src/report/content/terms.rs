//! What each term of the report means.

/// Terms and their meaning, in the order in which the page uses them.
pub const TERMS: [(&str, &str); 25] = [
    ("Tv", "Time factor c_v t/H² with c_v = k M/γ_w and the drainage path H; t counts from the opening of the drain."),
    (
        "U",
        "Degree of consolidation S/(q H/M): settlement of the loaded surface over its final value, counted from \
         the unloaded state.",
    ),
    (
        "p₀",
        "Undrained pore pressure under the load q: q itself for incompressible water, a little less for finite K_w.",
    ),
    (
        "Terzaghi",
        "Exact solution of one-dimensional consolidation at small strain, without inertia, with incompressible \
         water.",
    ),
    (
        "finite K_w",
        "The exact solution with finite bulk modulus of the pore water: part of the settlement occurs at once. The program \
         solves this problem.",
    ),
    (
        "error",
        "|U/U_exact \u{2212} 1|. The largest one is taken over Tv = 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7 and 1.",
    ),
    ("late error", "The same over Tv \u{2265} 0.1 only."),
    ("profile error", "Root mean square of p \u{2212} p_exact over the height at Tv = 0.1, over p₀."),
    (
        "L, per cell",
        "Edge of a cell of the background mesh; particles of each layer per square cell (a column of one dimension \
         has the root of that number).",
    ),
    (
        "traction on boundary particles",
        "The traction acts on the top row of particles, as in the paper: half a particle spacing below the surface.",
    ),
    ("traction on the free surface", "The traction acts on the free surface above the top row of particles."),
    (
        "order",
        "p in error ~ L^p: slope of a fit through all meshes, with the half width of its 95 % confidence interval.",
    ),
    (
        "established",
        "Said of an order of four meshes or more whose 95 % interval is at most 0.3 to either side. It passes if it then lies \
         within 0.5 of theory. Otherwise the fitted order is only a description.",
    ),
    (
        "Richardson value, GCI",
        "Value on an infinitely fine mesh extrapolated from the three finest, and Roache's grid convergence index \
         of the finest with factor 1.25.",
    ),
    (
        "parts of the error",
        "Each found by changing one thing: load placement (particles or surface), space (cells of finite size), time \
         (half the step), inertia (exact dynamic column), compressibility (the two exact solutions), large strain \
         (a hundredth of the load). The remainder is the total less the parts.",
    ),
    (
        "balance residual",
        "Work of the load less all energies and dissipation: energy that the scheme creates or destroys.",
    ),
    (
        "cell crossings",
        "How often a particle of either layer moved into another cell: the paper's explanation of noise.",
    ),
    ("explicit", "The paper's Figure 1: every step from the state at its start."),
    (
        "semi-implicit",
        "Explicit skeleton, implicit pore pressure: the step is limited by the wave in the skeleton only.",
    ),
    (
        "quasi-static",
        "Displacement and pressure implicit, no inertia, small strain: what the exact solutions assume. The steps \
         follow from a tolerance.",
    ),
    (
        "centre, linear, gimp, bspline2",
        "Shape functions: linear with values at the cell centre (the paper), linear, linear averaged over the \
         particle, quadratic B-splines.",
    ),
    (
        "fitted weights, particle volumes",
        "What particles stand for in the integrals of bspline2: weights near the volumes that integrate piecewise \
         quadratics exactly, or the volumes as they are.",
    ),
    (
        "Krylov, SDIRK",
        "Quasi-static time: one factorisation for all times of a linear scene, or error-controlled steps.",
    ),
    ("forced", "Run with a time step above the stability limit because the user asked for it."),
    (
        "failed",
        "Ended early, by a value that is not a number or a particle that left the mesh. It has no error, and \
         pictures leave it out.",
    ),
];
