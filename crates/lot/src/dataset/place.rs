//! Where a dataset is: a store, a prefix in it, and a pattern.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use datafusion::datasource::object_store::ObjectStoreUrl;
use futures::StreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::local::LocalFileSystem;
use object_store::path::{Path as Key, PathPart};
use object_store::{ObjectMeta, ObjectStore, ObjectStoreExt};
use url::Url;

/// Where a dataset is.
#[derive(Debug, Clone)]
pub struct Place {
    /// The store's root, as the engine knows it.
    pub root: ObjectStoreUrl,
    /// The store.
    pub store: Arc<dyn ObjectStore>,
    prefix: Key,
    pattern: Option<glob::Pattern>,
}

/// Why a dataset cannot be listed.
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// There is no such folder or file.
    #[error(
        "{dataset}: there is no such folder or file: give a folder of recordings, a glob in quotes, or s3://BUCKET/PREFIX"
    )]
    Missing {
        /// As it was given.
        dataset: String,
    },
    /// It holds nothing.
    #[error("{dataset}: no file there: give a folder of recordings, a glob in quotes, or s3://BUCKET/PREFIX")]
    Nothing {
        /// As it was given.
        dataset: String,
    },
    /// The glob is none.
    #[error("{dataset}: {source}")]
    Pattern {
        /// As it was given.
        dataset: String,
        /// What is wrong with it.
        source: glob::PatternError,
    },
    /// A kind of URL that is not read.
    #[error("{dataset}: datasets are read from folders and from s3:// URLs, not from {scheme}://")]
    Scheme {
        /// As it was given.
        dataset: String,
        /// The URL's scheme.
        scheme: String,
    },
    /// The store does not answer.
    #[error("{dataset}: {source}")]
    Store {
        /// As it was given.
        dataset: String,
        /// What it says.
        source: object_store::Error,
    },
}

/// The last cause of an error, which says it shortest.
fn cause(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(next) = cause.source() {
        cause = next;
    }
    cause.to_string()
}

impl Place {
    /// The place that a text names.
    ///
    /// # Errors
    /// [`PlaceError`], all but [`PlaceError::Nothing`].
    pub fn of(dataset: &str) -> Result<Self, PlaceError> {
        match Url::parse(dataset) {
            Ok(url) if dataset.contains("://") => Self::of_url(dataset, &url),
            _ => Self::of_path(dataset),
        }
    }

    fn of_path(dataset: &str) -> Result<Self, PlaceError> {
        let missing = || PlaceError::Missing { dataset: dataset.to_owned() };
        // A folder may have such letters in its name.
        let is_there = Path::new(dataset).exists();
        let special = |part: &str| !is_there && part.contains(['*', '?', '[']);
        // The folders before the first with a pattern in it.
        let plain: std::path::PathBuf =
            Path::new(dataset).components().take_while(|part| !special(&part.as_os_str().to_string_lossy())).collect();
        let plain = if plain.as_os_str().is_empty() { Path::new(".").to_owned() } else { plain };
        let plain = plain.canonicalize().map_err(|_| missing())?;
        let pattern = Path::new(dataset).components().skip_while(|part| !special(&part.as_os_str().to_string_lossy()));
        let rest: std::path::PathBuf = pattern.collect();
        let prefix = Key::from_absolute_path(&plain).map_err(|_| missing())?;
        let pattern = if rest.as_os_str().is_empty() {
            None
        } else {
            let text = rest.to_string_lossy().into_owned();
            Some(
                glob::Pattern::new(&text)
                    .map_err(|source| PlaceError::Pattern { dataset: dataset.to_owned(), source })?,
            )
        };
        Ok(Self { root: ObjectStoreUrl::local_filesystem(), store: Arc::new(LocalFileSystem::new()), prefix, pattern })
    }

    fn of_url(dataset: &str, url: &Url) -> Result<Self, PlaceError> {
        match url.scheme() {
            "file" => {
                let path = url.to_file_path().map_err(|()| PlaceError::Missing { dataset: dataset.to_owned() })?;
                Self::of_path(&path.to_string_lossy())
            }
            "s3" => {
                let failed = |source| PlaceError::Store { dataset: dataset.to_owned(), source };
                let bucket = url.host_str().unwrap_or_default();
                let store = AmazonS3Builder::from_env().with_bucket_name(bucket).build().map_err(failed)?;
                let root = ObjectStoreUrl::parse(format!("s3://{bucket}"))
                    .map_err(|_| PlaceError::Missing { dataset: dataset.to_owned() })?;
                let prefix = Key::from_url_path(url.path()).map_err(|source| failed(source.into()))?;
                Ok(Self { root, store: Arc::new(store), prefix, pattern: None })
            }
            scheme => Err(PlaceError::Scheme { dataset: dataset.to_owned(), scheme: scheme.to_owned() }),
        }
    }

    /// Every file of the dataset, and a reason for each entry of a folder that cannot be looked into.
    ///
    /// # Errors
    /// [`PlaceError::Store`].
    pub async fn list(&self) -> Result<(Vec<ObjectMeta>, Vec<String>), PlaceError> {
        // A single file is no prefix of itself.
        if let Ok(file) = self.store.head(&self.prefix).await {
            return Ok((vec![file], Vec::new()));
        }
        let (mut all, mut unlisted) = (Vec::new(), Vec::new());
        let mut entries = self.store.list(Some(&self.prefix));
        while let Some(entry) = entries.next().await {
            match entry {
                Ok(meta) => all.push(meta),
                // A link in a circle, a folder that is closed: the others are there. A store that fails is another matter.
                Err(error) if self.root == ObjectStoreUrl::local_filesystem() => unlisted.push(cause(&error)),
                Err(source) => return Err(PlaceError::Store { dataset: self.prefix.to_string(), source }),
            }
        }
        let wanted = |meta: &ObjectMeta| {
            let hidden =
                meta.location.filename().is_none_or(|name| name.starts_with('.') || name.ends_with(".partial"));
            !hidden && self.pattern.as_ref().is_none_or(|pattern| pattern.matches(&self.name_of(&meta.location)))
        };
        Ok((all.into_iter().filter(wanted).collect(), unlisted))
    }

    /// The path of a file, where the store is this machine's.
    #[must_use]
    pub fn local(&self, meta: &ObjectMeta) -> Option<PathBuf> {
        (self.root == ObjectStoreUrl::local_filesystem()).then(|| Path::new("/").join(meta.location.as_ref()))
    }

    /// The key of a file by its path from the dataset's root.
    #[must_use]
    pub fn key_of(&self, name: &str) -> Key {
        // A dataset of one file is its own root.
        if self.prefix.filename() == Some(name) {
            return self.prefix.clone();
        }
        // A name is of a key's parts, which are encoded already.
        let part = |part| PathPart::parse(part).unwrap_or_else(|_| PathPart::from(part));
        name.split('/').fold(self.prefix.clone(), |key, name| key.join(part(name)))
    }

    /// A file's path or key from the dataset's root.
    #[must_use]
    pub fn name_of(&self, key: &Key) -> String {
        let parts: Vec<_> = match key.prefix_match(&self.prefix) {
            Some(parts) => parts.map(|part| part.as_ref().to_owned()).collect(),
            None => Vec::new(),
        };
        if parts.is_empty() { key.filename().unwrap_or_default().to_owned() } else { parts.join("/") }
    }
}
