//! Several things done side by side, each on threads of its own.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::failure::Failure;

/// So many pools that share the threads; with as many pools as threads each has one.
pub(super) fn pools(count: usize, threads: usize) -> Result<Vec<ThreadPool>, Failure> {
    let pool = |number: usize| {
        let share = threads / count + usize::from(number < threads % count);
        let pool = ThreadPoolBuilder::new().num_threads(share).build();
        pool.map_err(|error| Failure::Input(error.to_string()))
    };
    (0..count).map(pool).collect()
}

/// Does the work for every item, one at a time in each pool, in their order as pools become free; what comes of it is in no
/// order. A pool of its own keeps a work from starting another one while it waits for its threads.
pub(super) fn on_pools<Item: Sync, Done: Send>(
    pools: Vec<ThreadPool>,
    items: &[Item],
    work: impl Fn(&Item) -> Done + Sync,
) -> Vec<Done> {
    let next = AtomicUsize::new(0);
    let work_off = |pool: ThreadPool| {
        let mut done: Vec<Done> = Vec::new();
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push(pool.install(|| work(item)));
        }
        done
    };
    let work_off = &work_off;
    thread::scope(|scope| {
        let workers: Vec<_> =
            pools.into_iter().map(|pool| scope.spawn(move || work_off(pool))).collect();
        let finished = workers.into_iter().map(|worker| worker.join());
        finished.flat_map(|done| done.unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}
