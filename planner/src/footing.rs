//! Where on the route feet stand.

/// Where on the route a foot stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Footing {
    /// Progress along the route, m.
    pub along_m: f64,
    /// Distance beside it, and what its height counts for, m.
    pub lateral_m: f64,
    /// Whether it is in the air, and this is where it stood last.
    pub in_air: bool,
    /// Whether it is elsewhere than it is wanted at the goal: by the posture that is wanted there, or on another face.
    pub astray: bool,
}

/// Progress of the hindmost foot beside the one of that index, m: of those in the air, too, which
/// would otherwise be left behind without a price.
pub(crate) fn hindmost(feet: &[Footing], but: usize) -> f64 {
    let others = feet.iter().enumerate().filter(|(i, _)| *i != but);
    others
        .map(|(_, foot)| foot.along_m)
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NEG_INFINITY)
}
