//! Sound models of every format, damaged at random: none may break the reader, take long, or take much memory, and what
//! is accepted comes back from its copies to the last bit.

use std::collections::{BTreeMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use calibstab::colmap::{Form, ModelFiles, find};

use crate::holds::{copies_hold, parse};
use crate::memory::{ALONE, peak_of};
use crate::mutation::MUTATIONS;
use crate::random::Random;

/// How many mutants, unless the environment variable `CALIBSTAB_MUTANTS` says otherwise.
const DEFAULT_COUNT: u64 = 20_000;

/// Reading may take so much time, many times what it does take: a busy machine is not to fail the test, a loop is.
const LONGEST: Duration = Duration::from_secs(2);
const LONGEST_PER_BYTE: Duration = Duration::from_micros(20);

/// Memory at the peak, in multiples of all files together, and what even an empty model may take.
const MOST_MEMORY: usize = 4;
const MOST_MEMORY_BESIDES: usize = 16 << 10;

struct Model {
    name: String,
    form: Form,
    files: Vec<Vec<u8>>,
}

/// What became of the mutants.
#[derive(Default)]
struct Fates {
    accepted: usize,
    refused: usize,
    /// Every kind of reason, without what it says of the place.
    reasons: HashSet<std::mem::Discriminant<calibstab::colmap::Why>>,
    /// How many of each format were accepted.
    accepted_of: BTreeMap<String, usize>,
}

#[test]
fn mutants_are_refused_or_come_back_to_the_last_bit() {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let count = match std::env::var("CALIBSTAB_MUTANTS") {
        Ok(count) => count.parse().expect("CALIBSTAB_MUTANTS is a number"),
        Err(_) => DEFAULT_COUNT,
    };
    let models = models();
    assert_eq!(models.len(), 10);
    let mut fates = Fates::default();
    for number in 0..count {
        let (mutant, story) = mutant(&models, number);
        let judged = catch_unwind(AssertUnwindSafe(|| judge(&mutant, &mut fates)));
        assert!(judged.is_ok(), "mutant {number} of {}: {story:?}", mutant.name);
    }
    // Were all refused, or all for the same few reasons, little would have been tested.
    assert_eq!(fates.accepted + fates.refused, usize::try_from(count).unwrap());
    assert!(fates.accepted * 10 > fates.refused, "{} accepted", fates.accepted);
    assert!(fates.refused * 3 > fates.accepted, "{} refused", fates.refused);
    assert_eq!(fates.accepted_of.len(), models.len(), "{:?}", fates.accepted_of);
    assert!(fates.reasons.len() >= 25, "only {} kinds of reasons", fates.reasons.len());
}

/// The sound models, one of every format.
fn models() -> Vec<Model> {
    let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats");
    let models = find(&formats).expect("fixtures");
    let model = |files: &ModelFiles| Model {
        name: files.run().file_name().expect("a name").to_string_lossy().into_owned(),
        form: files.form,
        files: files.paths().map(|path| std::fs::read(path).expect("a file")).collect(),
    };
    models.iter().map(model).collect()
}

/// The mutant of this number, and how it was made: some files of a model damaged in one way or a few.
fn mutant(models: &[Model], number: u64) -> (Model, Vec<(usize, &'static str)>) {
    let mut random = Random(number);
    let model = random.pick(models);
    let mut files = model.files.clone();
    let mut story = Vec::new();
    for _ in 0..*random.pick(&[1, 1, 1, 2, 4]) {
        let index = random.below(files.len());
        let (name, mutate) = random.pick(MUTATIONS);
        mutate(&mut files[index], &mut random);
        story.push((index, *name));
    }
    (Model { name: model.name.clone(), form: model.form, files }, story)
}

fn judge(mutant: &Model, fates: &mut Fates) {
    let files: Vec<&[u8]> = mutant.files.iter().map(Vec::as_slice).collect();
    let size: usize = files.iter().map(|file| file.len()).sum();
    let begun = Instant::now();
    let (read, peak) = peak_of(|| parse(mutant.form, &files));
    let time = begun.elapsed();
    let longest = LONGEST + LONGEST_PER_BYTE * u32::try_from(size).unwrap();
    assert!(time <= longest, "took {time:?} for {size} bytes");
    let most = MOST_MEMORY * size + MOST_MEMORY_BESIDES;
    assert!(peak <= most, "took {peak} bytes of memory for {size} bytes of files");
    match read {
        Ok(scene) => {
            copies_hold(&scene);
            fates.accepted += 1;
            *fates.accepted_of.entry(mutant.name.clone()).or_default() += 1;
        }
        Err(error) => {
            let shown = error.to_string();
            assert!(!shown.contains('\u{1b}') && shown.len() < 1000, "{shown}");
            fates.refused += 1;
            fates.reasons.extend(error.why().map(std::mem::discriminant));
        }
    }
}
