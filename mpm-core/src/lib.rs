//! The solver: a two-phase (solid + water) double-point material point method. The paper calls it two-layer.
//!
//! Effective stress is tension positive, pore pressure compression positive, gravity a vector. All quantities are
//! SI; a scene is 1 m thick in the direction that is not modelled, and a column carries its width as an area.
//!
//! # Reading order
//! 1. [`scene`]: what to simulate, from TOML to a checked [`scene::Scene`].
//! 2. [`grid`], [`particles`], [`seeding`]: the mesh and the two layers, also in an outline.
//! 3. [`real`], [`dimension`]: one number or many at once; one dimension and plane strain.
//! 4. [`sparse`], [`envelope`]: symmetric systems. [`constitutive`], [`water`], [`boundary`]: the physics; `water/free_surface` is
//!    water that wets dry soil. In soil that moves, `water/advected.rs` is the interaction of both in a step,
//!    `water/free_surface/moving.rs` the pressures that follow, `water/free_surface/advect.rs` the advection of water with its soil.
//! 5. [`space`]: function spaces and particle weights of the quasi-static integrator.
//! 6. [`step`]: one time step. `step/explicit.rs` is the paper's Figure 1: `step/kernel` what a cell does in it, many cells at once,
//!    on several threads, `step/store` what that reads and writes, `step/conditions` what acts on the nodes, `step/faces.rs` and `step/nodal.rs`
//!    Darcy's law, `step/pressure.rs` the pressures of the semi-implicit step; [`step::quasi_static`] solves for displacements, without inertia or with;
//!    `step/staggered.rs` lets water seep for hours and soil move for seconds.
//! 7. [`stability`], [`drive`]: how long a step may be; stages and times. [`failure`]: soil that water makes fail, from gravity
//!    to the final shape, with its events and factors of safety. [`checkpoint`]: state that is
//!    restored to the last bit.
//! 8. [`observe`]: the results of a run, and its balances.
//! 9. [`hardware`], [`run`]: threads and SIMD width of a run; the one place that turns the words of a scene into types. [`hash`], [`random`], `order`: the one hash, the one
//!    generator of random numbers, the one sort by a number.
//!
//! # Symbols
//! | symbol | meaning | unit |
//! |---|---|---|
//! | H, L | height of the column, edge of a cell | m |
//! | q | surcharge | Pa |
//! | E, nu, M | Young's modulus, Poisson's ratio, oedometer modulus | Pa, -, Pa |
//! | n | porosity | - |
//! | k, gamma_w | hydraulic conductivity, unit weight of water | m/s, N/m3 |
//! | K_w, Q = K_w/n | bulk modulus of water, stiffness of the pore water | Pa |
//! | D_p = k Q/gamma_w | diffusivity of pressure in a rigid skeleton | m2/s |
//! | c_v = k M/gamma_w | coefficient of consolidation | m2/s |
//! | Tv = c_v t/H^2 | time factor | - |
//! | rho, rho_s, rho_w | density of mixture, grains, water | kg/m3 |
//! | v_s, v_w, v* | velocity of solid, of water, v_w - v_s | m/s |
//! | p, sigma' | pore pressure, effective stress | Pa |

pub mod boundary;
pub mod checkpoint;
pub mod constitutive;
pub mod dimension;
pub mod drive;
pub mod envelope;
pub mod error;
pub mod failure;
pub mod grid;
pub mod hardware;
pub mod hash;
pub mod observe;
mod order;
pub mod particles;
pub mod random;
pub mod real;
pub mod run;
pub mod scene;
pub mod seeding;
pub mod soils;
pub mod space;
pub mod sparse;
pub mod stability;
pub mod step;
pub mod water;
