//! Prefetches what comes next.
//!
//! A block is many lines of the cache, so the prefetch of the CPU comes too late: without this a step of a million
//! particles takes half as long again.

/// Bytes of a line of the cache.
const LINE: usize = 64;

/// Asks for an item of a slice; nothing where there is none.
#[inline(always)]
#[allow(unsafe_code)] // the instruction is a hint: it reads nothing and cannot fault
pub fn ask_for<T>(slice: &[T], index: usize) {
    if let Some(item) = slice.get(index) {
        #[cfg(target_arch = "x86_64")]
        for line in 0..size_of::<T>().div_ceil(LINE) {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            // SAFETY: the address is only a hint.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(item).cast::<i8>().wrapping_add(line * LINE)) }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (item, LINE);
    }
}
