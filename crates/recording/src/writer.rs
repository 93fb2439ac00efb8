//! Writing: group by group as a stream, and at the end as Parquet.

use std::path::{Path, PathBuf};

use crate::schema;
use crate::streamed::Streamed;
use crate::{GroupRow, RecordingInfo, WriteError};

/// A recording that is being written.
pub struct RecordingWriter(Streamed);

impl RecordingWriter {
    /// Starts a recording that will be finished as the Parquet file `path`; until then it is the stream beside it with
    /// the extension `arrows`. An earlier Parquet file stays until this one is finished; an earlier stream, which a cut
    /// recording left, is kept under the extension `cut.arrows`, or `cut-1.arrows` and so on where one is kept already.
    ///
    /// # Errors
    /// When the folder or the stream cannot be written.
    pub fn create(path: &Path, info: &RecordingInfo) -> Result<Self, WriteError> {
        Streamed::create(path, schema::schema(info), "groups").map(Self)
    }

    /// Writes all rows of one group and hands them to the system: from then on the end of this program cannot lose them.
    ///
    /// # Errors
    /// When they cannot be written, as with a full disk; the groups before are kept.
    pub fn write_group(&mut self, rows: &[GroupRow]) -> Result<(), WriteError> {
        self.0.write(|schema| schema::batch(schema, rows))
    }

    /// Finishes the recording: rewrites the stream as Parquet, puts that in place at once, and removes the stream.
    ///
    /// # Errors
    /// When that fails: the stream then still holds every group, and an earlier Parquet file is as it was.
    pub fn finish(self) -> Result<PathBuf, WriteError> {
        self.0.finish()
    }
}
