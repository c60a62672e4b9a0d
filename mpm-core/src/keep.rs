//! State that can be kept and taken up again to the last bit: checkpoints, and states that are gone back to.
//!
//! Every room names its fields once, in one function that both writes and reads, so that the two cannot differ.

/// Writes fields one after the other, or reads them back.
#[derive(Debug)]
pub struct Keeper {
    bytes: Vec<u8>,
    at: usize,
    reads: bool,
    broken: bool,
}

/// Kept bytes that are not those of this state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a kept state that does not fit: it is cut short, or that of another scene or version")]
pub struct Unfit;

impl Keeper {
    /// A keeper that writes.
    pub fn writes() -> Self {
        Self { bytes: Vec::new(), at: 0, reads: false, broken: false }
    }

    /// A keeper that reads what another has written.
    pub fn reads(bytes: Vec<u8>) -> Self {
        Self { bytes, at: 0, reads: true, broken: false }
    }

    /// What was written.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Whether all was read and fitted.
    ///
    /// # Errors
    /// The bytes ended too early or too late.
    pub fn finish(self) -> Result<(), Unfit> {
        if self.reads && (self.broken || self.at != self.bytes.len()) { Err(Unfit) } else { Ok(()) }
    }

    /// Whether it reads, and all has fitted so far: only then may anything be built from what was read.
    pub fn is_reading(&self) -> bool {
        self.reads && !self.broken
    }

    /// What was read cannot be: nothing more is read.
    pub fn refuse(&mut self) {
        self.broken = true;
    }

    fn raw<const N: usize>(&mut self, value: [u8; N]) -> [u8; N] {
        if !self.reads {
            self.bytes.extend_from_slice(&value);
            return value;
        }
        match self.bytes.get(self.at..self.at + N).and_then(|bytes| bytes.try_into().ok()) {
            Some(bytes) if !self.broken => {
                self.at += N;
                bytes
            }
            _ => {
                self.broken = true;
                value
            }
        }
    }

    /// A number.
    pub fn f64(&mut self, value: &mut f64) {
        *value = f64::from_le_bytes(self.raw(value.to_le_bytes()));
    }

    /// Some numbers.
    pub fn f64s(&mut self, values: &mut [f64]) {
        for value in values {
            self.f64(value);
        }
    }

    /// A count.
    pub fn u64(&mut self, value: &mut u64) {
        *value = u64::from_le_bytes(self.raw(value.to_le_bytes()));
    }

    /// A small count.
    pub fn u32(&mut self, value: &mut u32) {
        *value = u32::from_le_bytes(self.raw(value.to_le_bytes()));
    }

    /// Yes or no.
    pub fn bool(&mut self, value: &mut bool) {
        *value = self.raw([u8::from(*value)])[0] != 0;
    }

    /// A list of any length. `empty` is what new entries are made of.
    pub fn list<T: Clone>(&mut self, list: &mut Vec<T>, empty: &T, mut each: impl FnMut(&mut T, &mut Self)) {
        let mut count = list.len() as u64;
        self.u64(&mut count);
        // Every entry has a byte at least: a count beyond that is no count.
        if self.reads && count as usize > self.bytes.len() - self.at.min(self.bytes.len()) {
            self.broken = true;
            return;
        }
        list.resize(count as usize, empty.clone());
        for entry in list.iter_mut() {
            each(entry, self);
        }
    }

    /// A list of numbers.
    pub fn numbers(&mut self, list: &mut Vec<f64>) {
        self.list(list, &0.0, |x, keeper| keeper.f64(x));
    }

    /// Entries whose number does not change during a run.
    pub fn entries<T>(&mut self, entries: &mut [T], mut each: impl FnMut(&mut T, &mut Self)) {
        let mut count = entries.len() as u64;
        self.u64(&mut count);
        if self.reads && count as usize != entries.len() {
            self.broken = true;
            return;
        }
        for entry in entries {
            each(entry, self);
        }
    }

    /// Numbers whose count does not change during a run.
    pub fn all(&mut self, values: &mut [f64]) {
        self.entries(values, |x, keeper| keeper.f64(x));
    }

    /// Something that may not be there; `empty` is what it is made of.
    pub fn maybe<T: Clone>(&mut self, value: &mut Option<T>, empty: &T, each: impl FnOnce(&mut T, &mut Self)) {
        let mut is = value.is_some();
        self.bool(&mut is);
        if is {
            each(value.get_or_insert_with(|| empty.clone()), self);
        } else {
            *value = None;
        }
    }

    /// A text.
    pub fn text(&mut self, text: &mut String) {
        let mut bytes = std::mem::take(text).into_bytes();
        self.list(&mut bytes, &0, |byte, keeper| *byte = keeper.raw([*byte])[0]);
        match String::from_utf8(bytes) {
            Ok(read) => *text = read,
            Err(_) => self.broken = true,
        }
    }
}

/// First bytes of what is sealed; the last one counts versions.
const SEAL: [u8; 8] = *b"mpmkept1";
/// Seal, what it is of, check sum.
const AROUND: usize = 24;

/// Check sum of bytes: FNV-1a.
pub fn check_sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Kept bytes with what they are `of` and a check sum: what is not whole must be known before any of it is taken up, since lists
/// of wrong lengths would not stop at being wrong.
pub fn sealed(bytes: &[u8], of: u64) -> Vec<u8> {
    let mut all = Vec::with_capacity(bytes.len() + AROUND);
    all.extend_from_slice(&SEAL);
    all.extend_from_slice(&of.to_le_bytes());
    all.extend_from_slice(bytes);
    all.extend_from_slice(&check_sum(&all).to_le_bytes());
    all
}

/// What [`sealed`] was given.
///
/// # Errors
/// The bytes are not whole, or not `of` this.
pub fn unsealed(mut all: Vec<u8>, of: u64) -> Result<Vec<u8>, Unfit> {
    if all.len() < AROUND {
        return Err(Unfit);
    }
    let sum = all.split_off(all.len() - 8);
    if sum != check_sum(&all).to_le_bytes() || all[..8] != SEAL || all[8..16] != of.to_le_bytes() {
        return Err(Unfit);
    }
    all.drain(..16);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_is_broken_by_any_change() {
        let all = sealed(&[1, 2, 3], 7);
        assert_eq!(unsealed(all.clone(), 7), Ok(vec![1, 2, 3]));
        assert_eq!(unsealed(all.clone(), 8), Err(Unfit));
        for at in 0..all.len() {
            let mut other = all.clone();
            other[at] ^= 16;
            assert_eq!(unsealed(other, 7), Err(Unfit), "byte {at}");
            assert_eq!(unsealed(all[..at].to_vec(), 7), Err(Unfit), "{at} bytes");
        }
    }

    fn fields(keeper: &mut Keeper, a: &mut f64, list: &mut Vec<u32>, yes: &mut bool) {
        keeper.f64(a);
        keeper.list(list, &0, |x, keeper| keeper.u32(x));
        keeper.bool(yes);
    }

    #[test]
    fn what_was_kept_comes_back() {
        let mut keeper = Keeper::writes();
        fields(&mut keeper, &mut f64::NAN.copysign(-1.0), &mut vec![3, 1, 4], &mut true);
        let bytes = keeper.into_bytes();
        let (mut a, mut list, mut yes) = (0.0, vec![], false);
        let mut keeper = Keeper::reads(bytes.clone());
        fields(&mut keeper, &mut a, &mut list, &mut yes);
        assert_eq!(keeper.finish(), Ok(()));
        assert_eq!((a.to_bits(), list, yes), (f64::NAN.copysign(-1.0).to_bits(), vec![3, 1, 4], true));
        for cut in 0..bytes.len() {
            let mut keeper = Keeper::reads(bytes[..cut].to_vec());
            fields(&mut keeper, &mut 0.0, &mut vec![], &mut false);
            assert_eq!(keeper.finish(), Err(Unfit), "{cut} bytes");
        }
    }
}
