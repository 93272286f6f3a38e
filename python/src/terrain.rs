//! What may be touched, and the bytes that it is planned from.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use numpy::{PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use perception::PosedScan;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scandent::cli::Global;
use scandent::config::Config;
use scandent::environment::{self, Perceived};
use scandent::provenance::Inputs;
use scandent::report::Stages;
use scandent::scene::{Environment, Files};
use scandent::threads;
use scenes::scene_file::ScanSource;
use surfaces::TriangleMesh;

use crate::{error, work};

/// The name of a terrain that came from no file: a plan's folder holds it under this one.
const NAME: &str = "surfaces.json";

/// Settings as `--set` takes them.
pub fn settings(set: Vec<String>) -> Global {
    Global {
        set,
        ..Global::default()
    }
}

/// Faces and obstacles, with the file or the bytes of a file that they are planned from.
#[pyclass(frozen)]
pub struct Terrain {
    /// The flag of `plan` and the name of the file.
    named: (&'static str, String),
    /// Its bytes.
    bytes: Vec<u8>,
    /// What it says.
    pub terrain: surfaces::Terrain,
    /// The points that it was perceived from, in W, m.
    pub cloud_W: Vec<[f32; 3]>,
    notes: Vec<String>,
}

impl Terrain {
    fn of_memory(perceived: Perceived) -> PyResult<Self> {
        let json = perceived.terrain.to_json().map_err(error::of)?;
        Ok(Self {
            named: ("--surfaces", NAME.to_owned()),
            bytes: json.into_bytes(),
            terrain: perceived.terrain,
            cloud_W: perceived.cloud_W,
            notes: perceived.notes,
        })
    }

    fn of_file(
        py: Python<'_>,
        flag: &'static str,
        path: String,
        read: fn(String) -> Environment,
        set: Vec<String>,
    ) -> PyResult<Self> {
        let worked = || {
            let config = Config::layered(None, &settings(set))?;
            let bytes = Inputs::default().read(flag.trim_start_matches("--"), Path::new(&path))?;
            let files = Files::Memory(BTreeMap::from([(path.clone(), bytes.clone())]));
            let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
            let environment = read(path.clone());
            let read =
                environment::perceive(&environment, &files, &config, &mut stages, &mut inputs)?;
            anyhow::Ok((bytes, read))
        };
        let argument = if flag == "--mesh" { "mesh" } else { "file" };
        let read = work::briefly(py, worked)?;
        let (bytes, read) = read.map_err(|e| error::input(e, Some(argument)))?;
        Ok(Self {
            named: (flag, path),
            bytes,
            terrain: read.terrain,
            cloud_W: Vec::new(),
            notes: read.notes,
        })
    }

    /// The flags of `plan` that name it.
    pub fn flags(&self) -> [String; 2] {
        [self.named.0.to_owned(), self.named.1.clone()]
    }

    /// Its file.
    pub fn files(&self) -> Files {
        Files::Memory(BTreeMap::from([(self.named.1.clone(), self.bytes.clone())]))
    }
}

#[pymethods]
impl Terrain {
    #[staticmethod]
    fn load(py: Python<'_>, path: String) -> PyResult<Self> {
        Self::of_file(py, "--surfaces", path, Environment::Surfaces, Vec::new())
    }

    #[staticmethod]
    fn mesh_file(py: Python<'_>, path: String, set: Vec<String>) -> PyResult<Self> {
        Self::of_file(py, "--mesh", path, Environment::Mesh, set)
    }

    #[staticmethod]
    fn mesh(
        py: Python<'_>,
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
        set: Vec<String>,
    ) -> PyResult<Self> {
        let worked = || {
            let thickness_m = Config::layered(None, &settings(set))?
                .surfaces
                .body
                .thickness_m;
            let mesh = TriangleMesh {
                vertices: vertices.into_iter().map(Into::into).collect(),
                triangles,
            };
            anyhow::Ok(surfaces::mesh::extract(&mesh, thickness_m)?.0)
        };
        let terrain = work::briefly(py, worked)?.map_err(error::of)?;
        Self::of_memory(Perceived {
            terrain,
            ..Perceived::default()
        })
    }

    /// A terrain of the text of its file.
    #[staticmethod]
    fn json(text: &str, argument: &str) -> PyResult<Self> {
        let terrain = surfaces::Terrain::from_json(text);
        Self::of_memory(Perceived {
            terrain: terrain.map_err(|e| error::input(e, Some(argument)))?,
            ..Perceived::default()
        })
    }

    /// The same with these coefficients of friction of faces by their names.
    fn with_friction(&self, friction: BTreeMap<String, f64>) -> PyResult<Self> {
        let mut terrain = self.terrain.clone();
        let blame = |e: anyhow::Error| error::input(e, Some("friction"));
        for (name, value) in friction {
            let known = || terrain.faces.iter().map(|face| face.id.to_string());
            let at = known().position(|id| id == name);
            let at = at.with_context(|| {
                let known: Vec<String> = known().collect();
                format!("friction: no face {name:?}; there are {}", known.join(", "))
            });
            terrain.faces[at.map_err(blame)?].friction = Some(value);
        }
        terrain.validate().map_err(|e| blame(e.into()))?;
        Self::of_memory(Perceived {
            terrain,
            cloud_W: self.cloud_W.clone(),
            looked: Vec::new(),
            notes: self.notes.clone(),
        })
    }

    fn to_json(&self) -> PyResult<String> {
        self.terrain.to_json().map_err(error::of)
    }

    fn source<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    fn cloud_W<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let rows = numpy::ndarray::Array2::from(self.cloud_W.clone());
        PyArray2::from_owned_array(py, rows)
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn __len__(&self) -> usize {
        self.terrain.faces.len()
    }
}

/// A depth image and how it was taken: pixels, pose of V in W, fx fy cx cy, sensor, metres a unit.
type Shot<'py> = (
    PyReadonlyArray2<'py, u16>,
    [f64; 7],
    Option<[f64; 4]>,
    Option<String>,
    Option<f64>,
);

/// What depth images show, one after the other in time.
#[pyfunction]
pub fn perceive(
    py: Python<'_>,
    shots: Vec<Shot<'_>>,
    set: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Terrain> {
    let sources = shots.into_iter().map(|(depth, pose, K, sensor, scale)| {
        let (rows, columns) = (depth.shape()[0], depth.shape()[1]);
        let units: Vec<u16> = depth.as_array().iter().copied().collect();
        let [x, y, z, qx, qy, qz, qw] = pose;
        let source = ScanSource {
            depth: Some("depth".to_owned()),
            sensor,
            fx: K.map(|k| k[0]),
            fy: K.map(|k| k[1]),
            cx: K.map(|k| k[2]),
            cy: K.map(|k| k[3]),
            depth_scale_m: scale,
            position_m: Some([x, y, z]),
            quat_xyzw: Some([qx, qy, qz, qw]),
            ..ScanSource::default()
        };
        (source, (columns, rows), units)
    });
    let sources: Vec<_> = sources.collect();
    let worked = || {
        let config = Config::layered(None, &settings(set))?;
        let scans = sources
            .iter()
            .enumerate()
            .map(|(i, (source, size, units))| {
                let name = format!("depth image {i}");
                let options = environment::sensor_options(source);
                let scan = perception::depth_scan(Path::new(&name), *size, units, &options)?;
                let X_WV = source.X_WV() * scan.X_WV;
                anyhow::Ok((name, scan, X_WV))
            });
        let scans = scans.collect::<anyhow::Result<Vec<_>>>()?;
        let posed = scans.iter().map(|(name, scan, X_WV)| PosedScan::Scan {
            name,
            scan,
            X_WV: *X_WV,
        });
        let posed: Vec<PosedScan> = posed.collect();
        let threads = threads.and_then(std::num::NonZeroUsize::new);
        threads::pool(threads)?
            .install(|| environment::of_scans(&posed, &config, &mut Stages::default()))
            .context("depth")
    };
    let perceived = work::briefly(py, worked)?.map_err(|e| error::input(e, Some("depth")))?;
    Terrain::of_memory(perceived)
}
