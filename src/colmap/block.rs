//! A part of a file that holds whole records, and how files are cut into such parts.
//!
//! Knows nothing of what records hold but where one ends. A file larger than memory is read one block after the other.

use std::fs::File;
use std::io::{self, Cursor, Read, Take};
use std::path::{Path, PathBuf};

use super::binary::Binary;
use super::source::{Fault, Layout, Records, Source};
use super::text::Text;
use super::{Form, ReadError};

/// A file as it was opened: what it holds and how much.
pub struct Opened {
    content: Box<dyn Read + Send>,
    length: u64,
}

/// How the files of a model are opened; they need not lie on a disk.
pub type Open<'a> = &'a (dyn Fn(&Path) -> io::Result<Opened> + Sync);

impl Opened {
    /// A file on disk.
    pub fn file(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { content: Box::new(file), length })
    }
}

impl From<Vec<u8>> for Opened {
    fn from(content: Vec<u8>) -> Self {
        Self { length: content.len() as u64, content: Box::new(Cursor::new(content)) }
    }
}

/// Bytes of a block that holds more than one record. It fits in a processor's cache beside what is made of it, and two
/// threads with a block each take little beside the smallest model that is worth two threads.
pub const BLOCK_SIZE: usize = 128 << 10;

/// Whole records, as they stand in the file.
#[derive(Default)]
pub struct Block {
    /// The content.
    pub bytes: Vec<u8>,
    /// Where in the file it starts.
    pub offset: usize,
    /// How long the file is; its last block ends there.
    pub file_length: usize,
    /// In a binary file, how many records are still to come; none as long as that is itself to be read.
    pub records_left: Option<usize>,
}

impl Block {
    /// A block that is a whole file.
    pub fn of_whole_file(path: &Path, open: Open) -> Result<Self, ReadError> {
        let could_not_open = |source| ReadError::could_not_open(path, source);
        let mut bytes = Vec::new();
        open(path)
            .and_then(|mut opened| opened.content.read_to_end(&mut bytes))
            .map_err(could_not_open)?;
        Ok(Self { file_length: bytes.len(), bytes, offset: 0, records_left: None })
    }

    /// Whether the file ends with this block.
    pub fn is_last(&self) -> bool {
        self.offset + self.bytes.len() >= self.file_length
    }

    /// Reads the records.
    pub fn read<R: Records>(&self, form: Form, records: R) -> Result<R::Read, Fault> {
        match form {
            Form::Text => Text::new(self).and_then(|mut text| records.read(&mut text)),
            Form::Binary => records.read(&mut Binary::new(self)),
        }
    }
}

/// A file of a model that is read block by block.
pub struct Blocks {
    path: PathBuf,
    form: Form,
    layout: &'static Layout,
    size: usize,
    file: Take<Box<dyn Read + Send>>,
    file_length: usize,
    /// The start of the next block, already read.
    carried: Vec<u8>,
    offset: usize,
    records_left: Option<usize>,
    is_at_end: bool,
}

impl Blocks {
    /// The blocks of this file, of about this size; a record is never cut.
    pub fn of(
        path: &Path,
        open: Open,
        form: Form,
        layout: &'static Layout,
        size: usize,
    ) -> Result<Self, ReadError> {
        let could_not_open = |source| ReadError::could_not_open(path, source);
        let Opened { content, length } = open(path).map_err(could_not_open)?;
        Ok(Self {
            path: path.to_owned(),
            form,
            layout,
            size,
            file: content.take(length),
            file_length: usize::try_from(length).unwrap_or(usize::MAX),
            carried: Vec::new(),
            offset: 0,
            records_left: None,
            is_at_end: false,
        })
    }

    /// Whether the file is longer than one block.
    pub fn are_many(&self) -> bool {
        self.file_length > self.size
    }

    /// Replaces the block by the file's next one; false after the last. There is always one, if only an empty one.
    pub fn next_into(&mut self, block: &mut Block) -> Result<bool, ReadError> {
        if self.is_at_end {
            return Ok(false);
        }
        block.bytes.clear();
        block.bytes.append(&mut self.carried);
        block.offset = self.offset;
        block.file_length = self.file_length;
        block.records_left = self.records_left;
        let mut wanted = self.size.max(block.bytes.len() + 1);
        loop {
            self.read_up_to(wanted, block)
                .map_err(|source| ReadError::could_not_open(&self.path, source))?;
            if self.is_at_end {
                block.file_length = block.offset + block.bytes.len();
                return Ok(true);
            }
            if let Ok(Some(whole)) = block.read(self.form, WholeRecords(self.layout)) {
                self.carried.extend_from_slice(&block.bytes[whole.end..]);
                block.bytes.truncate(whole.end);
                self.offset += whole.end;
                self.records_left = whole.records_left;
                return Ok(true);
            }
            wanted *= 2;
        }
    }

    fn read_up_to(&mut self, wanted: usize, block: &mut Block) -> io::Result<()> {
        let missing = wanted - block.bytes.len();
        let left = usize::try_from(self.file.limit()).unwrap_or(usize::MAX);
        block.bytes.reserve_exact(missing.min(left));
        let read = self.file.by_ref().take(missing as u64).read_to_end(&mut block.bytes)?;
        self.is_at_end = read < missing;
        Ok(())
    }

    /// Reads all blocks, one after the other.
    pub fn for_each(
        mut self,
        mut read: impl FnMut(&Block) -> Result<(), Fault>,
    ) -> Result<(), ReadError> {
        let mut block = Block::default();
        while self.next_into(&mut block)? {
            read(&block).map_err(|fault| ReadError::at(&self.path, self.form, &block, fault))?;
        }
        Ok(())
    }
}

/// Looks for the end of the last record that is whole, if one is.
struct WholeRecords<'a>(&'a Layout);

struct Whole {
    /// The byte after the record, counted from the start of the block.
    end: usize,
    records_left: Option<usize>,
}

impl Records for WholeRecords<'_> {
    type Read = Option<Whole>;

    fn read(self, source: &mut impl Source) -> Result<Self::Read, Fault> {
        let mut whole = None;
        while source.skip_record(self.0) {
            whole = Some(Whole { end: source.at(), records_left: source.records_left() });
        }
        Ok(whole)
    }
}
