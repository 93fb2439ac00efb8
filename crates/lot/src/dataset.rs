//! Finding the recordings of a lot, in a folder, by a glob, or in object storage, and reading what their footers say.
//!
//! Nothing here stops at a bad file: what is no recording that can be fitted is named with its reason.

pub(crate) mod footer;
mod place;
mod serials;

use std::collections::BTreeMap;
use std::sync::Arc;

use chrono::SecondsFormat;
use futures::{StreamExt, TryStreamExt};
use object_store::{ObjectMeta, ObjectStore, ObjectStoreExt};
use serde::{Deserialize, Serialize};
use zerorate_bench::setup::{Limits, SetUp};
use zerorate_cal::quality::Reason;
use zerorate_cal::recording::{RECORDED_AT, RecordingInfo};

pub(crate) use footer::columns;
pub use place::{Place, PlaceError};

/// Footers read at a time.
const AT_ONCE: usize = 16;

/// The procedure whose recordings are fitted.
const PROCEDURE: &str = "full-temperature";

/// Files that our own commands write beside recordings.
const OURS: [&str; 6] = [
    crate::simulate::TRUTH,
    "calibration.json",
    "summary.json",
    "report.html",
    "certificate.html",
    "device-record.bin",
];

/// A recording that can be fitted, as far as its footer tells.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its path or key from the dataset's root.
    pub file: String,
    /// Where it is in the store, its size, and when it was written.
    pub meta: ObjectMeta,
    /// Its metadata.
    pub info: RecordingInfo,
    /// Its rows, one a group and axis.
    pub rows: u64,
    /// The limits of its set-up; `None` where the set-up cannot be read.
    pub limits: Option<Limits>,
    /// What is wrong with its serial.
    pub serial_reason: Option<Reason>,
}

/// A file that is not fitted, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// Its path or key from the dataset's root.
    pub file: String,
    /// Why.
    pub reason: String,
}

/// What was found.
#[derive(Debug)]
pub struct Dataset {
    /// Where.
    pub place: Place,
    /// What can be fitted, by name.
    pub found: Vec<Found>,
    /// What cannot, by name.
    pub skipped: Vec<Skipped>,
    /// Recordings of other procedures, a count for each: they belong to a bench's results and are no fault.
    pub other_procedures: BTreeMap<String, u64>,
}

impl Found {
    /// A label of the recording, as `station`; empty where it has none.
    #[must_use]
    pub fn label(&self, name: &str) -> &str {
        self.info.labels.get(name).map_or("", String::as_str)
    }

    /// When it was recorded: its label `recorded_at`, else when it was begun, else when the file was written. RFC 3339.
    #[must_use]
    pub fn recorded_at(&self) -> String {
        match self.label(RECORDED_AT) {
            "" => self.info.started.unwrap_or(self.meta.last_modified).to_rfc3339_opts(SecondsFormat::Secs, true),
            said => said.to_owned(),
        }
    }
}

impl Dataset {
    /// Finds the recordings of a dataset: a folder, a glob, a file, or the URL of a prefix in a store.
    ///
    /// # Errors
    /// [`PlaceError`], when the dataset itself cannot be listed or holds no file at all.
    pub async fn open(dataset: &str) -> Result<Self, PlaceError> {
        let place = Place::of(dataset)?;
        let (mut files, unlisted) = place.list().await?;
        files.sort_by(|a, b| a.location.cmp(&b.location));
        if files.is_empty() {
            return Err(PlaceError::Nothing { dataset: dataset.to_owned() });
        }
        let unlisted = unlisted.into_iter().map(|reason| Skipped { file: "an entry of the folder".to_owned(), reason });
        let skipped = unlisted.collect();
        let mut dataset = Self { place, found: Vec::new(), skipped, other_procedures: BTreeMap::new() };
        let looked: Vec<(ObjectMeta, Result<Found, Unfit>)> = futures::stream::iter(files)
            .map(|meta| {
                let (store, file) = (Arc::clone(&dataset.place.store), dataset.place.name_of(&meta.location));
                async move {
                    let found = look(store.as_ref(), file, meta.clone()).await;
                    (meta, found)
                }
            })
            .buffered(AT_ONCE)
            .collect()
            .await;
        for (meta, found) in looked {
            match found {
                Ok(found) => dataset.found.push(found),
                Err(Unfit::OtherProcedure(procedure)) => *dataset.other_procedures.entry(procedure).or_default() += 1,
                Err(Unfit::Ours) => {}
                Err(Unfit::Bad(reason)) => {
                    let file = dataset.place.name_of(&meta.location);
                    dataset.skipped.push(Skipped { file, reason });
                }
            }
        }
        serials::judge(&mut dataset.found);
        Ok(dataset)
    }
}

/// Why a file is not fitted.
enum Unfit {
    /// Another command of ours wrote it.
    Ours,
    /// A recording of another procedure.
    OtherProcedure(String),
    /// Something is wrong with it.
    Bad(String),
}

async fn look(store: &dyn ObjectStore, file: String, meta: ObjectMeta) -> Result<Found, Unfit> {
    let name = meta.location.filename().unwrap_or_default().to_owned();
    if OURS.contains(&name.as_str()) {
        return Err(Unfit::Ours);
    }
    if meta.size == 0 {
        return Err(Unfit::Bad("empty: it has no bytes".to_owned()));
    }
    if name.ends_with(".arrows") {
        return Err(Unfit::Bad(
            "a recording that was not finished: `zerorate fit` reads it alone; record again for the lot".to_owned(),
        ));
    }
    let footer = footer::read(store, &meta).await.map_err(Unfit::Bad)?;
    if footer.schema.field_with_name("model_asked").is_ok() {
        // Models that were written into the dataset's folder.
        return Err(Unfit::Ours);
    }
    let info = RecordingInfo::of_schema(&footer.schema).map_err(|fault| Unfit::Bad(fault.to_string()))?;
    footer::check_columns(&footer.schema).map_err(Unfit::Bad)?;
    if info.procedure != PROCEDURE {
        return Err(Unfit::OtherProcedure(info.procedure));
    }
    if footer.rows == 0 {
        return Err(Unfit::Bad("empty: it has no groups".to_owned()));
    }
    let limits = SetUp::parse(&info.set_up, &file).ok().map(|setup| setup.limits);
    Ok(Found { file, meta, info, rows: footer.rows, limits, serial_reason: None })
}

/// The bytes of a file of the dataset.
///
/// # Errors
/// What the store says.
pub async fn bytes(place: &Place, meta: &ObjectMeta) -> Result<Vec<u8>, object_store::Error> {
    let stream = place.store.get(&meta.location).await?.into_stream();
    let chunks: Vec<_> = stream.try_collect().await?;
    Ok(chunks.concat())
}
