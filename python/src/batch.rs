//! Items of a batch, planned and written as `scandent batch` does.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use pyo3::prelude::*;
use scandent::batch::item::Item;
use scandent::batch::{self, Extras, index};
use scandent::robot_files::Robots;

use crate::{error, work};

/// Does items one after the other, or several at a time; reads each of their robots once.
#[pyclass(frozen)]
pub struct Worker(Robots);

#[pymethods]
impl Worker {
    #[new]
    fn new() -> Self {
        Self(Robots::default())
    }

    /// What came of the item of a line, as JSON; one that was done before is not done again.
    fn item(
        &self,
        py: Python<'_>,
        line: &str,
        number: usize,
        folder: PathBuf,
        npz: bool,
        view: bool,
    ) -> PyResult<String> {
        let item = Item::new(line, number);
        let cancel = AtomicBool::new(false);
        let extras = Extras { npz, view };
        let row = work::long(py, &cancel, None, |_| {
            if let Some(record) = batch::done(&folder, &item) {
                return Ok(Some(record.row));
            }
            batch::run(&item, &folder, extras, &self.0, &cancel)
        })?;
        let row = row.map_err(|e| error::input(e, Some("folder")))?;
        serde_json::to_string(&row).map_err(error::of)
    }
}

/// Writes the index of the items of a manifest.
#[pyfunction]
pub fn batch_index(py: Python<'_>, manifest: PathBuf, folder: PathBuf) -> PyResult<()> {
    let written = work::briefly(py, || index::write(&manifest, &folder))?;
    written.map_err(|e| error::input(e, Some("folder")))
}
