//! Verdicts follow the numbers.
