//! What the fuzzer found worth keeping, once more, without the fuzzer.

use std::fs;
use std::path::Path;

use crate::holds::{one_file, whole_model};
use crate::memory::ALONE;

#[test]
fn the_corpus_of_the_fuzzer_holds() {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    for (target, check) in [("one_file", one_file as fn(&[u8])), ("whole_model", whole_model)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
        let mut count = 0;
        for entry in fs::read_dir(&folder).expect("a corpus") {
            let file = entry.expect("an entry").path();
            let checked = std::panic::catch_unwind(|| check(&fs::read(&file).expect("a file")));
            assert!(checked.is_ok(), "{}", file.display());
            count += 1;
        }
        assert!(count >= 100, "only {count} inputs in {}", folder.display());
    }
}
