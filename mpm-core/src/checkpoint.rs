//! Checkpoints: the state of a run as bytes, from which it is resumed to the last bit; and states that a run returns to.
//!
//! A part of a model names its state once, in a function that both saves and restores it, so that the two cannot differ. What
//! the model does not build anew is written by serde.

use postcard::ser_flavors::{Flavor, StdVec};
use postcard::{Deserializer, Serializer};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::hash::{Digest, sha256};

/// Bytes that are not a checkpoint of this state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a checkpoint that does not match: it is truncated, or belongs to another scene or version")]
pub struct RestoreError;

/// What a state is saved to or restored from.
pub enum Archive<'a> {
    /// Values are written behind those that were.
    Saving(Serializer<StdVec>),
    /// Values are read from these bytes, of which the rest is left.
    Restoring(&'a [u8]),
}

impl Archive<'_> {
    /// Whether values are read.
    pub fn restores(&self) -> bool {
        matches!(self, Self::Restoring(_))
    }

    /// Saves or restores a value.
    ///
    /// # Errors
    /// The bytes are not those of such a value.
    pub fn value<T: Serialize + DeserializeOwned>(&mut self, value: &mut T) -> Result<(), RestoreError> {
        match self {
            Self::Saving(to) => value.serialize(to).map_err(|_| RestoreError)?,
            Self::Restoring(rest) => {
                let mut from = Deserializer::from_bytes(rest);
                *value = T::deserialize(&mut from).map_err(|_| RestoreError)?;
                *rest = from.finalize().map_err(|_| RestoreError)?;
            }
        }
        Ok(())
    }

    /// Values whose number does not change during a run: they stay where they are in memory.
    ///
    /// # Errors
    /// The bytes are not those of so many values.
    pub fn slice<T: Serialize + DeserializeOwned>(&mut self, values: &mut [T]) -> Result<(), RestoreError> {
        let mut count = values.len();
        self.value(&mut count)?;
        if count != values.len() {
            return Err(RestoreError);
        }
        values.iter_mut().try_for_each(|value| self.value(value))
    }

    /// One of some choices that serde only writes.
    ///
    /// # Errors
    /// There are not so many choices.
    pub fn choice<T: Copy + PartialEq>(&mut self, value: &mut T, choices: &[T]) -> Result<(), RestoreError> {
        let mut place = choices.iter().position(|choice| choice == value).unwrap_or(choices.len());
        self.value(&mut place)?;
        *value = *choices.get(place).ok_or(RestoreError)?;
        Ok(())
    }
}

/// Saves or restores several values ([`Archive::value`]) or slices ([`Archive::slice`]), or returns the error.
macro_rules! archive {
    ($archive:ident.$kind:ident: $($place:expr),+ $(,)?) => { $($archive.$kind(&mut $place)?;)+ };
}
pub(crate) use archive;

/// The bytes of a state.
pub fn save(state: impl FnOnce(&mut Archive) -> Result<(), RestoreError>) -> Vec<u8> {
    let mut archive = Archive::Saving(Serializer { output: StdVec::new() });
    match (state(&mut archive), archive) {
        (Ok(()), Archive::Saving(to)) => to.output.finalize().unwrap_or_default(),
        // Nothing that a model holds has no bytes; no state would be restored from none.
        _ => Vec::new(),
    }
}

/// Restores a state from its bytes.
///
/// # Errors
/// They are not those of such a state, which may then be in pieces.
pub fn restore(bytes: &[u8], state: impl FnOnce(&mut Archive) -> Result<(), RestoreError>) -> Result<(), RestoreError> {
    let mut archive = Archive::Restoring(bytes);
    state(&mut archive)?;
    if matches!(archive, Archive::Restoring([])) { Ok(()) } else { Err(RestoreError) }
}

/// First bytes of a seal; the last one counts versions.
const MAGIC: [u8; 8] = *b"mpmstat2";

/// Bytes of a state with a head that says what they are `of` and that they are whole: that must be known before any of it is
/// restored.
pub fn sealed(state: &[u8], of: &Digest) -> Vec<u8> {
    [&head(state, of)[..], state].concat()
}

/// What [`sealed`] was given.
///
/// # Errors
/// The bytes are not whole, or not `of` this.
pub fn unsealed<'a>(all: &'a [u8], of: &Digest) -> Result<&'a [u8], RestoreError> {
    let (found, state) = all.split_at_checked(MAGIC.len() + 2 * of.len()).ok_or(RestoreError)?;
    if found == head(state, of) { Ok(state) } else { Err(RestoreError) }
}

fn head(state: &[u8], of: &Digest) -> Vec<u8> {
    [&MAGIC[..], of, &sha256(state)].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_is_broken_by_any_change() {
        let all = sealed(&[1, 2, 3], &[7; 32]);
        assert_eq!(unsealed(&all, &[7; 32]), Ok(&[1, 2, 3][..]));
        assert_eq!(unsealed(&all, &[8; 32]), Err(RestoreError));
        for at in 0..all.len() {
            let mut other = all.clone();
            other[at] ^= 16;
            assert_eq!(unsealed(&other, &[7; 32]), Err(RestoreError), "byte {at}");
            assert_eq!(unsealed(&all[..at], &[7; 32]), Err(RestoreError), "{at} bytes");
        }
    }

    type Fields = (f64, Vec<u32>, [f64; 3], &'static str, Vec<[f64; 2]>);

    fn fields((a, list, fixed, choice, points): &mut Fields, archive: &mut Archive) -> Result<(), RestoreError> {
        archive!(archive.value: *a, *list);
        archive!(archive.slice: *fixed, *points.as_flattened_mut());
        archive.choice(choice, &["one", "other"])
    }

    #[test]
    fn a_state_comes_back_to_the_last_bit_or_not_at_all() {
        let numbers = [f64::NAN.copysign(-1.0), f64::NEG_INFINITY, -0.0];
        let of = |state: &Fields| [state.0, state.2[0], state.2[1], state.2[2], state.4[0][1]].map(f64::to_bits);
        let mut state = (f64::from_bits(0x7ff4_0000_dead_beef), vec![3, 1, 4], numbers, "other", vec![[0.1, 1e-320]]);
        let bytes = save(|archive| fields(&mut state, archive));
        let blank = || (0.0, vec![], [0.0; 3], "one", vec![[0.0; 2]]);
        let mut other = blank();
        assert_eq!(restore(&bytes, |archive| fields(&mut other, archive)), Ok(()));
        assert_eq!((of(&other), &other.1, other.3), (of(&state), &state.1, state.3));
        for cut in 0..bytes.len() {
            assert_eq!(restore(&bytes[..cut], |archive| fields(&mut blank(), archive)), Err(RestoreError), "{cut}");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert_eq!(restore(&longer, |archive| fields(&mut blank(), archive)), Err(RestoreError));
        // A count without end asks for no memory.
        let endless = [&bytes[..8], &[0xff; 9], &[1]].concat();
        assert_eq!(restore(&endless, |archive| fields(&mut blank(), archive)), Err(RestoreError));
    }
}
