//! What can go wrong between a robot and its simulation.

/// Every way in which a simulation cannot be set up; that a robot falls is a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A robot that MuJoCo cannot simulate.
    #[error("the robot cannot be simulated: {0}")]
    Robot(String),
    /// A stance or motion that does not fit the robot.
    #[error("{what}: {cause}")]
    Reference {
        /// Which stance, phase or contact.
        what: String,
        /// Why.
        cause: String,
    },
    /// MuJoCo refuses the model or leaves it.
    #[error("MuJoCo: {0}")]
    MuJoCo(String),
    /// The controller's program has no solution.
    #[error("whole-body controller: {0}")]
    Controller(String),
    /// Pictures cannot be drawn.
    #[error("rendering: {0}")]
    Render(String),
}
