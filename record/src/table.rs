//! Tables of figures, and the comparison of two.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

/// Which change of a figure is for the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Worse {
    /// A smaller figure.
    Less,
    /// A greater one.
    More,
    /// Neither: the figure only describes.
    Neither,
}

/// A column of figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// What it holds, with its unit.
    pub name: String,
    /// Which change is for the worse.
    pub worse: Worse,
    /// Changes up to this are noise.
    pub noise: f64,
    /// Changes up to this part of the old figure are noise.
    pub noise_ratio: f64,
    /// Digits behind the point.
    pub digits: usize,
}

/// A row: what was measured, and a figure a column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was measured.
    pub subject: String,
    /// Its figures; `None` where there is none.
    pub figures: Vec<Option<f64>>,
}

/// One table of the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// What it is about.
    pub title: String,
    /// What was left out and why, and what else a reader needs.
    pub notes: Vec<String>,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// A column in which `worse` is for the worse, beyond `noise` and `noise_ratio` of the old figure.
pub fn column(name: &str, worse: Worse, noise: f64, noise_ratio: f64, digits: usize) -> Column {
    Column {
        name: name.into(),
        worse,
        noise,
        noise_ratio,
        digits,
    }
}

impl Column {
    /// Whether the change from an old figure to a new one is for the worse, beyond the noise. A
    /// figure that is no longer there is worse.
    pub fn is_worse(&self, old: Option<f64>, new: Option<f64>) -> bool {
        let (old, new) = match (old, new) {
            (Some(old), Some(new)) => (old, new),
            (Some(_), None) => return self.worse != Worse::Neither,
            _ => return false,
        };
        let loss = match self.worse {
            Worse::Less => old - new,
            Worse::More => new - old,
            Worse::Neither => return false,
        };
        loss > self.noise + self.noise_ratio * old.abs() + 1e-9
    }

    fn text(&self, figure: Option<f64>) -> String {
        figure.map_or("–".into(), |value| format!("{value:.*}", self.digits))
    }
}

impl Table {
    /// An empty table.
    pub fn new(title: &str, columns: Vec<Column>) -> Self {
        Self {
            title: title.into(),
            notes: Vec::new(),
            columns,
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, subject: impl Into<String>, figures: Vec<Option<f64>>) {
        self.rows.push(Row {
            subject: subject.into(),
            figures,
        });
    }

    /// Adds a note.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// The table in Markdown; beside an `old` one every figure that changed is shown as `old → new`
    /// and marked where it is worse. Returns it with the list of what is worse.
    pub fn markdown(&self, old: Option<&Self>) -> (String, Vec<String>) {
        let mut text = format!("## {}\n\n", self.title);
        let mut worse = Vec::new();
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        let _ = writeln!(text, "| | {} |", names.join(" | "));
        let _ = writeln!(text, "|---|{}", "--:|".repeat(names.len()));
        for row in &self.rows {
            let before = old.and_then(|t| t.rows.iter().find(|r| r.subject == row.subject));
            let _ = write!(text, "| {} |", row.subject);
            for (i, column) in self.columns.iter().enumerate() {
                let new = row.figures.get(i).copied().flatten();
                let then = old
                    .and_then(|t| t.columns.iter().position(|c| c.name == column.name))
                    .zip(before)
                    .map(|(k, r)| r.figures.get(k).copied().flatten());
                let (now, then_text) = (column.text(new), then.map(|f| column.text(f)));
                let mut cell = match then_text {
                    Some(then) if then != now => format!("{then} → {now}"),
                    _ => now,
                };
                if then.is_some_and(|then| column.is_worse(then, new)) {
                    worse.push(format!("{}, {}: {cell}", row.subject, column.name));
                    cell = format!("**{cell} worse**");
                }
                let _ = write!(text, " {cell} |");
            }
            text.push('\n');
        }
        for row in old.iter().flat_map(|t| &t.rows) {
            if !self.rows.iter().any(|r| r.subject == row.subject) {
                worse.push(format!("{}, {}: is gone", self.title, row.subject));
            }
        }
        let mut noise = Vec::new();
        for column in self.columns.iter().filter(|c| c.worse != Worse::Neither) {
            let up = column.worse == Worse::Less;
            let sign = if up { '↑' } else { '↓' };
            let limit = match (column.noise, 100.0 * column.noise_ratio) {
                (noise, 0.0) => format!("{noise}"),
                (0.0, percent) => format!("{percent:.0} %"),
                (noise, percent) => format!("{noise} + {percent:.0} %"),
            };
            noise.push(format!("{} {sign} {limit}", column.name));
        }
        if !noise.is_empty() {
            let noise = noise.join("; ");
            let said = "\nBetter upwards (↑) or downwards (↓), and the noise:";
            let _ = writeln!(text, "{said} {noise}.");
        }
        for note in &self.notes {
            let _ = writeln!(text, "\n{note}");
        }
        text.push('\n');
        (text, worse)
    }
}

/// The middle one of the values, the mean of the middle two of an even number; `None` of none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0)
}

/// The mean; `None` of none.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_worse_in_its_direction_beyond_the_noise_only() {
        for (worse, old, new, expected) in [
            (Worse::Less, Some(10.0), Some(8.0), false),
            (Worse::Less, Some(10.0), Some(7.9), true),
            (Worse::Less, Some(10.0), Some(20.0), false),
            (Worse::More, Some(10.0), Some(12.1), true),
            (Worse::More, Some(10.0), None, true),
            (Worse::More, None, Some(1e9), false),
            (Worse::Neither, Some(10.0), Some(0.0), false),
        ] {
            let column = column("c", worse, 1.0, 0.1, 1);
            let is_worse = column.is_worse(old, new);
            assert_eq!(is_worse, expected, "{worse:?} {old:?} {new:?}");
        }
    }

    #[test]
    fn rows_that_are_gone_and_figures_that_fell_are_listed() {
        let mut old = Table::new("t", vec![column("found", Worse::Less, 0.0, 0.0, 0)]);
        old.push("a", vec![Some(3.0)]);
        old.push("b", vec![Some(1.0)]);
        let mut new = Table::new("t", old.columns.clone());
        new.push("a", vec![Some(2.0)]);
        let (text, worse) = new.markdown(Some(&old));
        assert!(text.contains("| a | **3 → 2 worse** |"), "{text}");
        assert_eq!(worse, ["a, found: 3 → 2", "t, b: is gone"]);
        assert_eq!(old.markdown(Some(&old)).1, Vec::<String>::new());
    }
}
