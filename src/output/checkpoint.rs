//! `checkpoint.bin`: the complete state of a run between two increments, from which the run can
//! continue.
//!
//! One line of text, `clastic checkpoint, format N, sha256 <hash of what follows>`, then a
//! [`Checkpoint`] in postcard's encoding, which is documented, compact, and keeps the bits of every
//! f64, non-finite ones included. The file is written under another name, flushed to the disk and
//! renamed. A complete checkpoint, old or new, therefore exists at every moment.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::atomic::durably;
use super::directory;
use super::error::OutputError;
use super::run_directory::RunOptions;
use super::run_record::{RunFacts, sha256};
use crate::run::WorldState;

/// Version of the format. It increases when the stored types have changed since a release. These are
/// the types that derive their encoding in this file and where plugins register state.
pub const VERSION: u32 = 1;

/// Length of a table that is kept whole.
pub(super) const WHOLE: u64 = u64::MAX;

const MAGIC: &str = "clastic checkpoint, format ";

/// Content of a checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Version of the program that wrote it.
    pub clastic_version: String,
    /// The last committed increment.
    pub increment: u64,
    /// The scene as run.
    pub scene: String,
    /// The scene before its settings were changed, if this checkpoint changed them. A process that
    /// is killed between writing the two files leaves the old `scene.ron`.
    pub scene_before: Option<String>,
    /// Content of `run.json` apart from settings and results.
    pub facts: RunFacts,
    /// Options of the output: checkpoints and dumps.
    pub options: RunOptions,
    /// Lengths of the history, the events, the avalanches and the timings, bytes.
    pub lengths: [u64; 4],
    /// State of the simulation and of its output.
    pub world: WorldState,
}

impl Checkpoint {
    /// Writes the checkpoint to the file `name` of a run directory.
    ///
    /// # Errors
    /// If the file cannot be written. The file that was there is then unchanged.
    pub fn write(&self, directory: &Path, name: &str) -> Result<(), OutputError> {
        durably(&directory.join(name), |file| self.write_to(file))
    }

    fn write_to(&self, mut file: impl Write) -> io::Result<()> {
        let content = postcard::to_stdvec(self).map_err(io::Error::other)?;
        let line = format!("{MAGIC}{VERSION}, sha256 {}\n", sha256(&content));
        file.write_all(line.as_bytes())?;
        file.write_all(&content)
    }

    /// Reads the checkpoint of a run directory and verifies that it is complete and belongs to the
    /// scene of the directory.
    ///
    /// # Errors
    /// If there is no checkpoint, or it is incomplete or belongs to another scene.
    pub fn read(directory: &Path) -> Result<Self, OutputError> {
        Self::read_as(directory, directory::CHECKPOINT)
    }

    /// Reads the checkpoint in the file `name` of a run directory: [`directory::CHECKPOINT`], or
    /// [`directory::FINAL_CHECKPOINT`] of a run that has ended.
    ///
    /// # Errors
    /// As of [`read`](Self::read).
    pub fn read_as(directory: &Path, name: &str) -> Result<Self, OutputError> {
        let path = directory.join(name);
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                directory::record(directory)?;
                return Err(OutputError::NoCheckpoint(directory.to_owned()));
            }
            bytes => bytes.map_err(OutputError::at(&path))?,
        };
        let checkpoint = Self::decode(&bytes).map_err(OutputError::at(&path))?;
        let scene = directory.join(directory::SCENE);
        let text = fs::read_to_string(&scene).map_err(OutputError::at(&scene))?;
        if text != checkpoint.scene && Some(&text) != checkpoint.scene_before.as_ref() {
            return Err(OutputError::at(&path)(format!(
                "a checkpoint of another scene than {} beside it; put back the one that was run \
                 (sha256 {}), and change settings with --set",
                directory::SCENE,
                sha256(checkpoint.scene.as_bytes())
            )));
        }
        Ok(checkpoint)
    }

    /// The checkpoint of the content of a file, or what is wrong with it.
    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let damaged = |what: &str| format!("damaged ({what}); run the scene again, with --force");
        let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(|| damaged("cut short"))?;
        let line = std::str::from_utf8(&bytes[..end]).ok();
        let rest = line.and_then(|line| line.strip_prefix(MAGIC));
        let (version, hash) = rest
            .and_then(|rest| rest.split_once(", sha256 "))
            .ok_or_else(|| damaged("its first line does not belong to a checkpoint"))?;
        if version != VERSION.to_string() {
            return Err(format!(
                "a checkpoint of format {version}, and this clastic reads format {VERSION}; resume it \
                 with the clastic that wrote it, or run the scene again, with --force"
            ));
        }
        let content = &bytes[end + 1..];
        if sha256(content) != hash {
            return Err(damaged("its content does not match its hash"));
        }
        match postcard::take_from_bytes(content) {
            Ok((checkpoint, [])) => Ok(checkpoint),
            Ok(_) => Err(damaged("further bytes follow its end")),
            Err(error) => Err(damaged(&error.to_string())),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// Bytes of the state.
    const SIZE: usize = 1 << 19;

    /// A file on a disk with room for this number of bytes.
    struct Disk(Cursor<Vec<u8>>, usize);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0.position() as usize + bytes.len() > self.1 {
                return Err(io::Error::new(io::ErrorKind::StorageFull, "the disk is full"));
            }
            self.0.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn checkpoint() -> Checkpoint {
        let mut world = WorldState::default();
        world.set_bytes("numbers", (0..SIZE).map(|k| k as u8).collect());
        Checkpoint {
            clastic_version: "0".to_owned(),
            increment: 3,
            scene: "()".to_owned(),
            scene_before: None,
            facts: RunFacts {
                scene_file: "a.ron".to_owned(),
                specimen_sha256: None,
                overrides: Vec::new(),
                resumed: Vec::new(),
            },
            options: RunOptions {
                checkpoint_every: 1,
                dump_programs: vec![7],
                ..Default::default()
            },
            lengths: [1, 2, 3, WHOLE],
            world,
        }
    }

    #[test]
    fn the_file_is_its_encoding_after_a_line_with_its_hash() {
        let checkpoint = checkpoint();
        let mut file = Cursor::new(Vec::new());
        checkpoint.write_to(&mut file).unwrap();
        let content = postcard::to_stdvec(&checkpoint).unwrap();
        let mut expected = format!("{MAGIC}{VERSION}, sha256 {}\n", sha256(&content)).into_bytes();
        expected.extend(content);
        assert!(file.into_inner() == expected);
        assert_eq!(Checkpoint::decode(&expected).unwrap(), checkpoint);
    }

    #[test]
    fn the_error_of_a_full_disk_is_that_of_the_system() {
        for room in [0, 1000, SIZE / 2] {
            let disk = Disk(Cursor::new(Vec::new()), room);
            let error = checkpoint().write_to(disk).unwrap_err();
            assert_eq!(error.to_string(), "the disk is full");
        }
    }
}
