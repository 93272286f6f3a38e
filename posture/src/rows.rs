//! The linearised constraints of one iterate.

/// What a row speaks of: enough to say in words which constraint fails.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// A contact is at its place (contact index).
    Closure(usize),
    /// A contact's patch is inside its surface (contact index).
    Inclusion(usize),
    /// Forces balance the weight.
    Equilibrium,
    /// Moments about the centre of mass balance.
    Balance,
    /// A contact's forces are inside the friction pyramid (contact index).
    Friction(usize),
    /// A joint holds the posture (body index).
    Torque(usize),
    /// A joint is inside its limits (body index).
    JointLimit(usize),
    /// Two parts of the robot keep apart (names of the links).
    SelfClearance(String, String),
    /// A part of the robot keeps away from the environment (link, body).
    Clearance(String, String),
    /// The base is where the goal wants it.
    BaseGoal,
    /// The base stays upright.
    BaseTilt,
}

/// What a row speaks of, by indices; [`Constraint`] has the names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Tag {
    Closure(usize),
    Inclusion(usize),
    Equilibrium,
    Balance,
    Friction(usize),
    Torque(usize),
    /// Two shapes of the robot.
    SelfClearance(usize, usize),
    /// A shape of the robot and a body of the environment.
    Clearance(usize, usize),
    BaseGoal,
    BaseTilt,
}

/// Rows `lower ≤ value + a·δ ≤ upper` over the step δ, with what they speak of.
///
/// Values are scaled: m for lengths, angles times 0.1 m, torques over their limit, forces over
/// the robot's weight.
pub(crate) struct Rows {
    /// Number of step variables.
    pub n: usize,
    /// Whether the coefficients are wanted, or the values only.
    pub with_jacobian: bool,
    /// Coefficients, row-major, `len × n`; empty without the Jacobian.
    pub a: Vec<f64>,
    /// Values at the iterate.
    pub value: Vec<f64>,
    /// Lower bounds of the values.
    pub lower: Vec<f64>,
    /// Upper bounds of the values.
    pub upper: Vec<f64>,
    /// What each row speaks of.
    pub tag: Vec<Tag>,
    /// Rows that the elastic mode must not relax.
    pub hard: Vec<bool>,
}

impl Rows {
    pub fn new(n: usize) -> Self {
        Self {
            n,
            with_jacobian: true,
            a: Vec::new(),
            value: Vec::new(),
            lower: Vec::new(),
            upper: Vec::new(),
            tag: Vec::new(),
            hard: Vec::new(),
        }
    }

    /// Forgets the rows, keeps the memory.
    pub fn clear(&mut self, with_jacobian: bool) {
        self.with_jacobian = with_jacobian;
        self.a.clear();
        self.value.clear();
        self.lower.clear();
        self.upper.clear();
        self.tag.clear();
        self.hard.clear();
    }

    pub fn len(&self) -> usize {
        self.value.len()
    }

    /// Adds a row and gives its coefficients to fill in, all zero; empty where only values are
    /// wanted.
    pub fn push(&mut self, tag: Tag, value: f64, lower: f64, upper: f64) -> &mut [f64] {
        self.value.push(value);
        self.lower.push(lower);
        self.upper.push(upper);
        self.tag.push(tag);
        self.hard.push(false);
        if !self.with_jacobian {
            return &mut [];
        }
        let start = self.a.len();
        self.a.resize(start + self.n, 0.0);
        &mut self.a[start..]
    }

    /// Marks the last row as one that is never relaxed.
    pub fn harden_last(&mut self) {
        if let Some(last) = self.hard.last_mut() {
            *last = true;
        }
    }

    /// Coefficients of row `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.a[i * self.n..(i + 1) * self.n]
    }

    /// How much the linear model changes row `i` by a step.
    pub fn change(&self, i: usize, delta: &[f64]) -> f64 {
        self.row(i).iter().zip(delta).map(|(a, d)| a * d).sum()
    }

    /// By how much row `i` is violated at the iterate.
    pub fn violation(&self, i: usize) -> f64 {
        (self.lower[i] - self.value[i])
            .max(self.value[i] - self.upper[i])
            .max(0.0)
    }

    /// Sum of the violations.
    pub fn total_violation(&self) -> f64 {
        (0..self.len()).map(|i| self.violation(i)).sum()
    }

    /// The row that is violated most.
    pub fn worst(&self) -> Option<(usize, f64)> {
        (0..self.len())
            .map(|i| (i, self.violation(i)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
    }
}
