//! Tests of the solver through its public interface, one module per subject. They are one program because each program costs a link and
//! its own copies of generic code: `cargo test -p mpm-core --test all resume::` runs the tests of one module.

#[path = "../common/mod.rs"]
mod common;

mod allocation;
mod balances;
mod by_hand;
mod capabilities;
mod combinations;
mod domains;
mod failure;
mod implicit;
mod initial;
mod large_strain;
mod layers;
mod moving;
mod null_space;
mod patches;
mod physics;
mod quasi_static;
mod refusal;
mod renames;
mod rest;
mod resume;
mod run_out;
mod sameness;
mod scene_errors;
mod scene_hints;
mod scene_layers;
mod scene_methods;
mod scene_pages;
mod seeding;
mod sparse;
mod stability;
mod staggered;
mod transfer;
mod wells;
