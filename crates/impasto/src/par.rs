//! Threads and SIMD level: the only module that knows either exists.
//!
//! Work is cut into pieces that own disjoint slices, results come back in the order of the pieces, and nothing else is
//! shared. So one thread and sixteen give the same bytes.

pub use fearless_simd::Level;
use rayon::prelude::*;
use std::sync::Mutex;

/// Who does the work: a number of threads and the SIMD level they use.
pub struct Workers {
    pool: Option<rayon::ThreadPool>,
    n_threads: usize,
    level: Level,
}

/// The SIMD levels a user may ask for by name.
pub const LEVEL_NAMES: [&str; 4] = ["scalar", "sse2", "avx2", "avx512"];

impl Workers {
    /// `n_threads` threads (0: one a core) at the best SIMD level of this machine.
    pub fn new(n_threads: usize) -> Self {
        Self::with_level(n_threads, Level::new())
    }

    /// The same at a given SIMD level.
    pub fn with_level(n_threads: usize, level: Level) -> Self {
        let n_threads = match n_threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        };
        // A system that refuses threads still gets its picture, from one.
        let pool = match n_threads {
            1 => None,
            n => rayon::ThreadPoolBuilder::new().num_threads(n).build().ok(),
        };
        Self { pool, n_threads, level }
    }

    /// How many threads.
    pub fn n_threads(&self) -> usize {
        self.n_threads
    }

    /// Which SIMD level kernels are dispatched to.
    pub fn level(&self) -> Level {
        self.level
    }

    /// Calls `work(index, item)` for every item, in any order, on all threads.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        match &self.pool {
            None => items.iter_mut().enumerate().for_each(|(i, item)| work(i, item)),
            Some(pool) => {
                pool.install(|| items.par_iter_mut().with_max_len(1).enumerate().for_each(|(i, item)| work(i, item)));
            }
        }
    }

    /// Like [`for_each`](Self::for_each), with a scratch value that each thread makes once.
    pub fn for_each_with<T: Send, S>(
        &self,
        items: &mut [T],
        scratch: impl Fn() -> S + Sync,
        work: impl Fn(&mut S, usize, &mut T) + Sync,
    ) {
        self.consume(items.iter_mut(), scratch, work);
    }

    /// The same for items that are only made when somebody is free to work on them.
    pub fn consume<T: Send, S>(
        &self,
        items: impl Iterator<Item = T> + Send,
        scratch: impl Fn() -> S + Sync,
        work: impl Fn(&mut S, usize, T) + Sync,
    ) {
        let items = items.enumerate();
        let Some(pool) = &self.pool else {
            let mut s = scratch();
            items.for_each(|(i, item)| work(&mut s, i, item));
            return;
        };
        // Whoever is free takes the next item; which thread works on it does not show.
        let queue = Mutex::new(items);
        pool.broadcast(|_| {
            let mut s = scratch();
            loop {
                let next = queue.lock().expect("no thread panics while it takes an item").next();
                let Some((i, item)) = next else { break };
                work(&mut s, i, item);
            }
        });
    }

    /// `work(index)` for 0..n on all threads; the answers in order.
    pub fn map<R: Send>(&self, n: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
        match &self.pool {
            None => (0..n).map(work).collect(),
            Some(pool) => pool.install(|| (0..n).into_par_iter().with_max_len(1).map(work).collect()),
        }
    }
}

/// The SIMD level of that name, if this machine has it.
pub fn level_by_name(name: &str) -> Option<Level> {
    let best = Level::new();
    match name {
        "scalar" => Some(Level::Fallback(fearless_simd::Fallback::new())),
        #[cfg(target_arch = "x86_64")]
        "sse2" => best.as_sse2().map(Level::Sse2),
        #[cfg(target_arch = "x86_64")]
        "avx2" => best.as_avx2().map(Level::Avx2),
        #[cfg(target_arch = "x86_64")]
        "avx512" => best.as_avx512().map(Level::Avx512),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_come_in_order_whatever_the_thread_count() {
        for n_threads in [1, 2, 5] {
            let workers = Workers::new(n_threads);
            assert_eq!(workers.map(1000, |i| i * i), (0..1000).map(|i| i * i).collect::<Vec<_>>());
            let mut items = vec![0usize; 777];
            workers.for_each(&mut items, |i, item| *item = i);
            assert!(items.iter().enumerate().all(|(i, item)| i == *item));
        }
    }

    #[test]
    fn every_item_is_made_and_consumed_once() {
        for n_threads in [1, 2, 5] {
            let seen = Mutex::new(Vec::new());
            let items = (0..777).map(|i| i * 3);
            Workers::new(n_threads).consume(items, || (), |_, index, item| seen.lock().unwrap().push((index, item)));
            let mut seen = seen.into_inner().unwrap();
            seen.sort_unstable();
            assert!(seen.into_iter().eq((0..777).map(|i| (i, i * 3))));
        }
    }
}
