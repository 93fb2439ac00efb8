//! What the crates write as JSON, as Python's own.

use pyo3::prelude::*;

/// A text of JSON as dicts, lists and numbers.
pub fn loaded<'py>(py: Python<'py>, text: String) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}
