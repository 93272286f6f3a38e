//! Criteria as a table for the terminal.

use std::collections::BTreeMap;
use std::fmt::Write;

use simulation::criteria::{Criterion, Sense, Unit};
use simulation::outcome::Executed;

use super::report::HeldStance;

/// The worst value of every criterion over all stances, plain and pushed.
pub fn of_stances(held: &[HeldStance]) -> String {
    let mut text = String::new();
    let place = |h: &HeldStance| format!("stance {}", h.stance);
    let plain = held.iter().map(|h| (place(h), &h.plain.criteria));
    let pushed = held
        .iter()
        .flat_map(|h| h.pushed.iter().map(move |p| (place(h), &p.criteria)));
    for (title, rows) in [("held", worst(plain)), ("pushed", worst(pushed))] {
        let _ = writeln!(text, "{title}, worst of {} stances", held.len());
        for (place, criterion) in rows {
            text.push_str(&row(criterion, Some(&place)));
        }
    }
    text
}

/// What fails of a stance, in words.
pub fn failures_of_stance(held: &HeldStance) -> String {
    let mut words = vec![format!("stance {} ({})", held.stance, held.change)];
    let runs = std::iter::once(&held.plain).chain(&held.pushed);
    for (how, run) in ["held", "+x", "-x", "+y", "-y"].into_iter().zip(runs) {
        let failed = failures(&run.criteria);
        words.extend(failed.map(|failed| format!("{how}: {failed}")));
    }
    words.join("; ")
}

/// The criteria that do not hold, in words; nothing where all do.
pub fn failures(criteria: &[Criterion]) -> Option<String> {
    let failed = criteria.iter().filter(|c| !c.pass);
    let failed: Vec<String> = failed.map(failure).collect();
    (!failed.is_empty()).then(|| failed.join(", "))
}

fn failure(criterion: &Criterion) -> String {
    let (name, value, unit) = (&criterion.name, criterion.value, &criterion.unit);
    let place = criterion.detail.as_deref().unwrap_or_default();
    let words = format!("{name} {value:.2} {unit} {place}");
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// How many perturbed runs pass, and why the others do not.
pub fn of_robust(runs: &[Executed]) -> String {
    let count = |is: fn(&Executed) -> bool| runs.iter().filter(|run| is(run)).count();
    let mut text = format!(
        "perturbed: {} of {} runs end standing, {} fall; {} meet every criterion\n",
        count(|run| run.stands),
        runs.len(),
        count(|run| run.fell_s.is_some()),
        count(|run| run.pass),
    );
    let mut causes: BTreeMap<&str, usize> = BTreeMap::new();
    let criteria = runs.iter().flat_map(|run| &run.criteria);
    for criterion in criteria.filter(|c| !c.pass) {
        *causes.entry(&criterion.name).or_default() += 1;
    }
    for (cause, count) in causes {
        let _ = writeln!(text, "  {count} runs miss: {cause}");
    }
    for (number, run) in runs.iter().enumerate() {
        if let Some(cause) = &run.cause {
            let _ = writeln!(text, "  run {number}: {cause}");
        }
    }
    let numbered = runs.iter().enumerate();
    let criteria = numbered.map(|(number, run)| (format!("run {number}"), &run.criteria));
    text.push_str("worst of the perturbed runs\n");
    for (place, criterion) in worst(criteria) {
        text.push_str(&row(criterion, Some(&place)));
    }
    text
}

/// Part of the perturbed runs that must meet every criterion.
const MET_MIN: f64 = 0.9;

/// Whether enough of the perturbed runs meet every criterion, and all of them end standing.
pub fn robust(runs: &[Executed]) -> [Criterion; 2] {
    let part = |is: fn(&Executed) -> bool| {
        runs.iter().filter(|run| is(run)).count() as f64 / runs.len().max(1) as f64
    };
    [
        (
            "runs that meet every criterion",
            part(|run| run.pass),
            MET_MIN,
        ),
        ("runs that end standing", part(|run| run.stands), 1.0),
    ]
    .map(|(name, part, least)| Criterion::at_least(name, part, least, Unit::Plain("")))
}

/// The criteria of one run.
pub fn of_run<'c>(title: &str, criteria: impl IntoIterator<Item = &'c Criterion>) -> String {
    let mut text = format!("{title}\n");
    for criterion in criteria {
        text.push_str(&row(criterion, None));
    }
    text
}

/// For each criterion the run that comes nearest to failing it or fails it by most.
fn worst<'c>(
    runs: impl Iterator<Item = (String, &'c Vec<Criterion>)>,
) -> Vec<(String, &'c Criterion)> {
    let mut rows: Vec<(String, &Criterion)> = Vec::new();
    for (place, criteria) in runs {
        for criterion in criteria {
            match rows.iter_mut().find(|(_, c)| c.name == criterion.name) {
                Some(row) if is_worse(criterion, row.1) => *row = (place.clone(), criterion),
                Some(_) => {}
                None => rows.push((place.clone(), criterion)),
            }
        }
    }
    rows
}

fn is_worse(a: &Criterion, b: &Criterion) -> bool {
    match a.sense {
        Sense::AtMost => a.value > b.value || a.value.is_nan(),
        Sense::AtLeast => a.value < b.value || a.value.is_nan(),
    }
}

fn row(criterion: &Criterion, place: Option<&str>) -> String {
    let relation = match criterion.sense {
        Sense::AtMost => "≤",
        Sense::AtLeast => "≥",
    };
    let (name, value, unit) = (&criterion.name, criterion.value, &criterion.unit);
    let verdict = if criterion.pass { "pass" } else { "FAIL" };
    let words: Vec<&str> = place
        .into_iter()
        .chain(criterion.detail.as_deref())
        .collect();
    let bound = format!("{:.3}", criterion.bound);
    let bound = bound.trim_end_matches('0').trim_end_matches('.');
    let line = format!(
        "  {verdict}  {name:<24} {value:>9.3} {relation} {bound:<6} {unit:<5}  {}",
        words.join(": ")
    );
    format!("{}\n", line.trim_end())
}
