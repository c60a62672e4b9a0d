//! Catches panics: a case that panics is an error of that case, and all other cases still run.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::Error;

/// Runs some work that nothing else depends on.
///
/// # Errors
/// [`Error::Panicked`] with the message of the panic.
pub fn unpanicked<T>(work: impl FnOnce() -> T) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Error::Panicked(text.unwrap_or("without a message").to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_of_a_panic_is_kept() {
        assert_eq!(unpanicked(|| 7).ok(), Some(7));
        let said = |work: fn()| unpanicked(work).unwrap_err().to_string();
        assert_eq!(said(|| panic!("lost")), "the program panicked: lost");
        assert_eq!(said(|| panic!("lost {}", 2)), "the program panicked: lost 2");
        assert_eq!(said(|| std::panic::panic_any(2)), "the program panicked: without a message");
    }
}
