//! What can be wrong with a face, a polygon or a mesh.

/// Why a polygon, a face, a terrain or a mesh was refused.
///
/// Vertices, rings and triangles are counted from 0, as they stand in the input.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Fewer vertices than a triangle has.
    #[error("a polygon needs at least 3 vertices, this one has {count}")]
    TooFewVertices {
        /// Number of vertices given.
        count: usize,
    },
    /// A coordinate is NaN or beyond [`WORLD_M`].
    #[error("vertex {vertex} is not within {} m: {point:?}", crate::WORLD_M)]
    VertexBeyondWorld {
        /// The vertex.
        vertex: usize,
        /// Its coordinates, m.
        point: Vec<f64>,
    },
    /// Two vertices are the same point.
    #[error("vertex {vertex} repeats vertex {of}: [{x}, {y}]")]
    RepeatedVertex {
        /// The later of the two.
        vertex: usize,
        /// The earlier of the two.
        of: usize,
        /// First coordinate, m.
        x: f64,
        /// Second coordinate, m.
        y: f64,
    },
    /// The vertices enclose no area.
    #[error(
        "all {count} vertices lie on one line: vertex {vertex}, the farthest from it, is off by \
         {off_m:.3e} m"
    )]
    Collinear {
        /// Number of vertices.
        count: usize,
        /// The vertex farthest from the line through the two that are farthest apart.
        vertex: usize,
        /// Its distance from that line, m.
        off_m: f64,
    },
    /// The vertices run clockwise about the outward normal.
    #[error(
        "the vertices run clockwise about the outward normal (at vertex {vertex} the boundary \
         turns right): give them counter-clockwise"
    )]
    Clockwise {
        /// The first vertex at which the boundary turns right.
        vertex: usize,
    },
    /// The boundary turns right at a vertex of a counter-clockwise polygon.
    #[error("not convex: the boundary turns right by {turn_rad:.3e} rad at vertex {vertex}")]
    NotConvex {
        /// The vertex.
        vertex: usize,
        /// The angle by which the boundary turns right there, rad.
        turn_rad: f64,
    },
    /// The boundary goes round more than once.
    #[error("the boundary crosses itself: it has gone round once before vertex {vertex}")]
    SelfCrossing {
        /// The vertex at which the boundary has turned by more than a full circle.
        vertex: usize,
    },
    /// A number that must be finite, or not negative, is not.
    #[error("{field} is {value}, which is not {expected}")]
    BadNumber {
        /// Name of the field.
        field: String,
        /// Its value.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A rotation is not a unit quaternion.
    #[error("quat_xyzw has the norm {norm}, which is not 1")]
    NonUnitQuaternion {
        /// Its norm.
        norm: f64,
    },
    /// A covariance is not symmetric and positive semi-definite.
    #[error("plane_covariance is not symmetric and positive semi-definite: {why}")]
    BadCovariance {
        /// The entry or the eigenvalue at fault.
        why: String,
    },
    /// A ring of an outline is bad.
    #[error("outline ring {ring}: {cause}")]
    Outline {
        /// The ring.
        ring: usize,
        /// What is wrong with it.
        cause: Box<Error>,
    },
    /// The kinds of edges do not fit the edges.
    #[error("{field}: {found} for {expected}")]
    EdgeCount {
        /// The field.
        field: String,
        /// What it has.
        found: String,
        /// What it is for.
        expected: String,
    },
    /// The rings of an outline cross themselves or each other.
    #[error(
        "the outline crosses itself: its rings enclose {enclosed_m2} m², its triangles \
         {triangles_m2} m²"
    )]
    CrossingOutline {
        /// Area of the outer ring less that of the holes, m².
        enclosed_m2: f64,
        /// Area that a triangulation of it covers, m².
        triangles_m2: f64,
    },
    /// A face is bad.
    #[error("face `{id}`: {cause}")]
    Face {
        /// Its id.
        id: String,
        /// What is wrong with it.
        cause: Box<Error>,
    },
    /// A face without a shape, or with two.
    #[error("it needs either `region`, a list of rings, or `polygon`, one ring")]
    OneShape,
    /// An obstacle is bad.
    #[error("obstacle `{id}`: {cause}")]
    Obstacle {
        /// Its id.
        id: String,
        /// What is wrong with it.
        cause: Box<Error>,
    },
    /// A body has too few points to have a volume.
    #[error("a convex body needs at least 4 points, this one has {count}")]
    TooFewPoints {
        /// Number of points given.
        count: usize,
    },
    /// An id is empty.
    #[error("{what} number {index} has an empty id")]
    EmptyId {
        /// `face` or `obstacle`.
        what: &'static str,
        /// Its position in the list, from 0.
        index: usize,
    },
    /// Two faces or two obstacles have the same id.
    #[error("{what} number {index} repeats the id `{id}` of number {of}")]
    DuplicateId {
        /// `face` or `obstacle`.
        what: &'static str,
        /// The id.
        id: String,
        /// Position of the later one in the list, from 0.
        index: usize,
        /// Position of the earlier one in the list, from 0.
        of: usize,
    },
    /// A name that is not known.
    #[error("no {what} `{name}`; there are: {}", candidates.join(", "))]
    Unknown {
        /// `face`, `obstacle` or `role`.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        candidates: Vec<String>,
    },
    /// The file is of another format or version.
    #[error("the format is `{found}`, not `{expected}`")]
    Format {
        /// The format named in the file.
        found: String,
        /// The format that is read here.
        expected: &'static str,
    },
    /// The text is not the JSON that is read here.
    #[error("{place}{message}")]
    Json {
        /// The face or obstacle in which it happened, empty or ending in `: `.
        place: String,
        /// What the parser says, with line and column.
        message: String,
    },
    /// The mesh has no triangle, or none with an area.
    #[error("the mesh has no triangle with an area ({triangles} triangles, {vertices} vertices)")]
    EmptyMesh {
        /// Number of triangles.
        triangles: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but the mesh has {count} vertices")]
    MeshIndex {
        /// The triangle.
        triangle: usize,
        /// The vertex it refers to.
        vertex: usize,
        /// Number of vertices.
        count: usize,
    },
}

impl Error {
    /// A number that is not what is expected.
    pub(crate) fn bad(field: &str, value: f64, expected: &'static str) -> Self {
        Self::BadNumber {
            field: field.into(),
            value,
            expected,
        }
    }

    /// The same of a face with this id.
    pub(crate) fn of_face(self, id: &str) -> Self {
        Self::Face {
            id: id.to_owned(),
            cause: Box::new(self),
        }
    }

    /// Refuses a number that is negative or not finite.
    pub(crate) fn check_not_negative(field: &str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value >= 0.0 {
            return Ok(());
        }
        Err(Self::bad(field, value, "a finite number ≥ 0"))
    }
}
