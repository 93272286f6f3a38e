//! What is known or estimated of the robot's joints and masses.

/// Mass of the robot without batteries and covers: the sum that the single source gives, kg.
pub const DRY_MASS_KG: f64 = 56.04;
/// Mass at which the robot is quoted, kg; the difference is carried as batteries on BODY.
pub const QUOTED_MASS_KG: f64 = 58.0;

/// One row of `joints.csv`: a joint and its child link, all values in the child's frame.
pub struct Row {
    pub joint: String,
    pub parent: String,
    pub child: String,
    pub axis: [f64; 3],
    pub origin_m: [f64; 3],
    pub lower_rad: f64,
    pub upper_rad: f64,
    pub velocity_rad_s: f64,
    pub mass_kg: f64,
    pub com_m: [f64; 3],
}

/// Reads the table.
pub fn read(csv: &str) -> Result<Vec<Row>, String> {
    csv.lines()
        .skip(1)
        .filter(|line| !line.trim().is_empty())
        .map(row)
        .collect()
}

fn row(line: &str) -> Result<Row, String> {
    let cells: Vec<&str> = line.trim().split(',').collect();
    if cells.len() != 17 {
        return Err(format!("{} cells instead of 17 in: {line}", cells.len()));
    }
    let number = |i: usize| {
        cells[i]
            .parse::<f64>()
            .map_err(|e| format!("{e} in: {line}"))
    };
    Ok(Row {
        joint: cells[0].into(),
        parent: cells[1].into(),
        child: cells[2].into(),
        axis: [number(3)?, number(4)?, number(5)?],
        origin_m: [number(6)?, number(7)?, number(8)?],
        lower_rad: number(9)?.to_radians(),
        upper_rad: number(10)?.to_radians(),
        velocity_rad_s: number(11)?,
        mass_kg: number(13)?,
        com_m: [number(14)?, number(15)?, number(16)?],
    })
}

/// Torque limit in N·m and why; the table's own column is a placeholder in its source.
pub fn effort(joint: &str) -> (f64, &'static str) {
    let (limb, index) = joint.split_once("_JOINT").unwrap_or((joint, ""));
    match (limb, index) {
        ("LLEG" | "RLEG", "2" | "3") => (
            200.0,
            "estimate: single support on a 0.25-0.35 m step needs 124-149 N m at the knee",
        ),
        ("LLEG" | "RLEG", _) => (100.0, "estimate: other leg joints"),
        ("CHEST", _) => (
            100.0,
            "estimate: 24 kg above it leaning by 30 deg, and 100 N at a hand",
        ),
        ("HEAD", _) => (
            10.0,
            "placeholder of the source; holding the head needs 1.1",
        ),
        ("LARM" | "RARM", "0" | "1" | "2") => (
            100.0,
            "estimate: 100 N at a hand 0.7 m away, and the arm's own 17",
        ),
        ("LARM" | "RARM", "3") => (
            60.0,
            "estimate: 100 N at a hand 0.45 m away, and 6 of its own",
        ),
        ("LARM" | "RARM", "4") => (30.0, "estimate: 100 N beside a bent wrist"),
        ("LARM" | "RARM", "5") => (
            30.0,
            "estimate: 100 N across the hand 0.20 m below the wrist",
        ),
        _ => (
            1.0,
            "placeholder of the source; holding the finger needs 0.03",
        ),
    }
}

/// Half-sitting, degrees (grippers: 0.1 rad).
pub fn half_sitting_rad(joint: &str) -> f64 {
    let leg: [f64; 6] = [0.0, 0.0, -26.0, 50.0, -24.0, 0.0];
    let left_arm: [f64; 6] = [15.0, 10.0, 0.0, -30.0, 0.0, 0.0];
    let right_arm: [f64; 6] = [15.0, -10.0, 0.0, -30.0, 0.0, 0.0];
    let (limb, index) = joint.split_once("_JOINT").unwrap_or((joint, "0"));
    let index: usize = index.parse().unwrap_or(0);
    match (limb, index) {
        ("LARM" | "RARM", 6) => 0.1,
        ("LLEG" | "RLEG", i) => leg[i].to_radians(),
        ("LARM", i) => left_arm[i].to_radians(),
        ("RARM", i) => right_arm[i].to_radians(),
        _ => 0.0,
    }
}
