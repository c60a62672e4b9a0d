//! Tests of the program as a user runs it, and of the library's public interface: one module per subject, in one program.
//! `cargo test -p mpm-verify --test all levee::` runs the tests of one module.

mod command_line;
mod crawl;
mod error_table;
mod fuzz;
mod guides;
mod housekeeping;
mod kills;
mod levee;
mod levee_snapshots;
mod nights;
mod pages;
mod program;
mod reference_data;
mod shares;
mod words;
