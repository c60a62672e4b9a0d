//! Hard cases: what a scheme does where its assumptions are pushed, measured, one question per file.

pub mod contrast;
