//! What can go wrong at the edges, and what was mended there. Inside, nothing fails.

use std::path::PathBuf;

/// What can go wrong at the edges: files, and numbers people type. One line each; the cause last.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system said no.
    #[error("cannot read {path:?}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file system said no.
    #[error("cannot write {path:?}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Text that cannot be understood at a line.
    #[error("{path:?}, line {line}: expected {expected}, found {found:?}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What would have been right.
        expected: String,
        /// What stands there, shortened.
        found: String,
    },
    /// Any other fault in a file's content, with the place if there is one.
    #[error("{path:?}: {fault}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        fault: String,
    },
    /// No reader or writer for it.
    #[error("{path:?}: {kind} is not a format Impasto {verb}; it {verb} {known}")]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The extension or magic found.
        kind: String,
        /// "reads" or "writes".
        verb: &'static str,
        /// The ones it knows.
        known: &'static str,
    },
    /// Work that needs texture coordinates on a mesh that has none.
    #[error("{path:?} has no texture coordinates; unwrap it before you {task}")]
    NoUv {
        /// The file.
        path: PathBuf,
        /// What needs them.
        task: &'static str,
    },
    /// A number or name a person typed.
    #[error("{what} {given:?} is not possible: {why}")]
    Parameter {
        /// The option or key.
        what: String,
        /// What was given.
        given: String,
        /// What is allowed.
        why: String,
    },
}

/// `std::result::Result` with our [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// A usable value, and what had to be mended to get it.
#[derive(Clone, Debug)]
pub struct Report<T> {
    /// The value, valid.
    pub value: T,
    /// What was wrong with the input, in the order found.
    pub mended: Vec<Mended>,
}

/// One kind of defect, how often it occurred, and what was done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mended {
    /// How many.
    pub count: usize,
    /// What was wrong and what was done: "triangles without area dropped".
    pub what: String,
}

impl std::fmt::Display for Mended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.count, self.what)
    }
}

impl<T> Report<T> {
    /// A value that needed no mending.
    pub fn clean(value: T) -> Self {
        Self { value, mended: Vec::new() }
    }

    /// The same report about another value.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Report<U> {
        Report { value: f(self.value), mended: self.mended }
    }
}

/// Notes a defect unless its count is zero.
pub fn note(mended: &mut Vec<Mended>, count: usize, what: impl Into<String>) {
    if count > 0 {
        mended.push(Mended { count, what: what.into() });
    }
}
