//! Counts that depend on the compiler: their names say which, so that counts of another are another number.

/// Compiler and profile of this program.
pub const COMPILED: &str = concat!(env!("MPM_COMPILER"), ", ", env!("MPM_PROFILE"));
/// Instructions.
pub const INSTRUCTIONS: &str = "instructions";
/// Calls of the allocator: an optimiser leaves out those whose memory it can do without.
pub const ALLOCATIONS: &str = "allocations";

/// Name of a count of something that was made with something.
pub fn quantity(what: &str, with: &str) -> String {
    format!("{what} ({with})")
}

/// What a quantity counts, if that depends on the compiler.
pub fn counted(quantity: &str) -> Option<&'static str> {
    let is = |what: &&str| quantity.strip_prefix(*what).is_some_and(|rest| rest.starts_with(" ("));
    [INSTRUCTIONS, ALLOCATIONS].into_iter().find(is)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_another_compiler_are_another_number() {
        let of = quantity(ALLOCATIONS, "rustc 1, release");
        assert_eq!(counted(&of), Some(ALLOCATIONS));
        assert_eq!(counted(&quantity(INSTRUCTIONS, "rustc 1")), Some(INSTRUCTIONS));
        assert_ne!(of, quantity(ALLOCATIONS, "rustc 2, release"));
        assert_eq!([counted("steps"), counted("allocations"), counted("allocations_per_step (x)")], [None; 3]);
    }
}
