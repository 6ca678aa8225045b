//! The format of a checkpoint: one that an earlier program wrote is stored.

use std::fs;
use std::path::{Path, PathBuf};

use clastic::components::observation::RuptureCount;
use clastic::output::{Checkpoint, OutputPlugin, directory};
use clastic::run::Simulation;

use crate::resumed::{COULOMB, bytes, parse, run};

/// A checkpoint of this version of the format, as some earlier program wrote it.
fn stored() -> PathBuf {
    let name = format!("tests/data/checkpoint_{}.bin", clastic::output::checkpoint::VERSION);
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Writes it, after a change of the format:
/// `CLASTIC_STORE_CHECKPOINT=1 cargo test --release --test checkpoint -- --ignored`. Without the
/// variable `--ignored` does not write it.
#[test]
#[ignore = "writes the stored checkpoint, with CLASTIC_STORE_CHECKPOINT=1"]
fn write_the_stored_checkpoint() {
    if std::env::var_os("CLASTIC_STORE_CHECKPOINT").is_none() {
        eprintln!("skipped: CLASTIC_STORE_CHECKPOINT is not set");
        return;
    }
    let parent = tempfile::tempdir().unwrap();
    run(&parse(COULOMB), parent.path(), 1, |o| {
        if o.increment == 15 {
            fs::copy(parent.path().join(directory::CHECKPOINT), stored()).unwrap();
        }
    });
}

/// Fails when what a checkpoint holds has changed: then run the test above as it says, after a
/// release with a new `checkpoint::VERSION`.
#[test]
fn the_format_is_that_of_its_version() {
    let parent = tempfile::tempdir().unwrap();
    fs::copy(stored(), parent.path().join(directory::CHECKPOINT)).unwrap();
    fs::write(parent.path().join(directory::SCENE), COULOMB).unwrap();
    let checkpoint = Checkpoint::read(parent.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(checkpoint.increment, 15);
    let ruptures: RuptureCount = checkpoint.world.get("rupture_count").unwrap();
    assert!(ruptures.0.iter().sum::<usize>() > 0);
    // A world restored from it has the same state, to the bit.
    let scene = parse(COULOMB).scene;
    let mut simulation =
        Simulation::resume_in(clastic::run::app(OutputPlugin), &scene, &checkpoint.world).unwrap();
    assert!(bytes(&simulation.state().unwrap()) == bytes(&checkpoint.world));
    // It is written again to the same bytes: every entry was read.
    checkpoint.write(parent.path(), directory::CHECKPOINT).unwrap();
    let again = fs::read(parent.path().join(directory::CHECKPOINT)).unwrap();
    assert!(again == fs::read(stored()).unwrap());
}
