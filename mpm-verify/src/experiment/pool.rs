//! Several pieces of work at a time on threads of their own; the results in the order of the pieces.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::Error;
use crate::unpanicked::unpanicked;

/// Does some work for every item, `jobs` at a time (0: one per core), the first items first. `done` is told of each item that has been
/// finished, one at a time. A panic is the error of its item alone.
///
/// The threads are no pool that others share: a run that waits for threads of its own would begin another item meanwhile.
pub fn each<T: Sync, R: Send>(
    jobs: usize,
    items: &[T],
    work: impl Fn(usize, &T) -> R + Sync,
    mut done: impl FnMut(usize, &Result<R, Error>) + Send,
) -> Vec<Result<R, Error>> {
    let jobs = if jobs > 0 { jobs } else { std::thread::available_parallelism().map_or(1, usize::from) };
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<R, Error>>>> = items.iter().map(|_| Mutex::new(None)).collect();
    let told = Mutex::new(&mut done);
    let run = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(number) else { return };
            let result = unpanicked(|| work(number, item));
            if let Ok(mut done) = told.lock() {
                done(number, &result);
            }
            if let Ok(mut place) = results[number].lock() {
                *place = Some(result);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..jobs.min(items.len()) {
            scope.spawn(run);
        }
        run();
    });
    let result = |place: Mutex<Option<Result<R, Error>>>| {
        place.into_inner().ok().flatten().unwrap_or_else(|| Err(Error::Panicked("a thread".to_owned())))
    };
    results.into_iter().map(result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_and_a_panic_is_that_of_its_item() {
        let items: Vec<u32> = (0..20).collect();
        let mut count = 0;
        let work = |_: usize, n: &u32| if *n == 7 { panic!("seven") } else { 2 * n };
        let results = each(3, &items, work, |_, _| count += 1);
        assert_eq!(count, 20);
        for (n, result) in items.iter().zip(results) {
            match result {
                Ok(value) => assert_eq!(value, 2 * n),
                Err(error) => assert!(*n == 7 && error.to_string().contains("seven")),
            }
        }
    }
}
