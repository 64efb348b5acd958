//! Blocks of one file read by several threads, what comes of them taken in the file's order.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::block::{Block, Blocks};

/// Reads every block and takes what came of it, in order; none as soon as a block cannot be read.
///
/// What is taken, and in which order, does not depend on the number of threads.
pub fn read_in_order<Part: Send>(
    blocks: Blocks,
    read: impl Fn(&Block) -> Option<Part> + Sync,
    take: impl FnMut(Part) + Send,
) -> Option<()> {
    let thread_count = if blocks.are_many() { rayon::current_num_threads() } else { 1 };
    let queue = Mutex::new(Queue { blocks, given: 0, is_stopped: false });
    let parts = Mutex::new(Parts { early: BTreeMap::new(), taken: 0, take });
    let work = || {
        let mut block = Block::default();
        loop {
            // The lock ends with this statement: others take their blocks while this one is read.
            let given = lock(&queue).give(&mut block);
            let Some(index) = given else { return };
            match read(&block) {
                Some(part) => lock(&parts).receive(index, part),
                None => lock(&queue).is_stopped = true,
            }
        }
    };
    rayon::scope(|scope| {
        (1..thread_count).for_each(|_| scope.spawn(|_| work()));
        work();
    });
    (!lock(&queue).is_stopped).then_some(())
}

/// A panic of another thread goes on when its scope ends, and needs no second one here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Queue {
    blocks: Blocks,
    given: usize,
    is_stopped: bool,
}

impl Queue {
    /// The next block, and its place in the file's order.
    fn give(&mut self, block: &mut Block) -> Option<usize> {
        if self.is_stopped {
            return None;
        }
        match self.blocks.next_into(block) {
            Ok(true) => {
                self.given += 1;
                Some(self.given - 1)
            }
            Ok(false) => None,
            Err(_) => {
                self.is_stopped = true;
                None
            }
        }
    }
}

struct Parts<Part, Take> {
    /// Parts that came before one that precedes them.
    early: BTreeMap<usize, Part>,
    taken: usize,
    take: Take,
}

impl<Part, Take: FnMut(Part)> Parts<Part, Take> {
    fn receive(&mut self, index: usize, part: Part) {
        self.early.insert(index, part);
        while let Some(part) = self.early.remove(&self.taken) {
            (self.take)(part);
            self.taken += 1;
        }
    }
}
