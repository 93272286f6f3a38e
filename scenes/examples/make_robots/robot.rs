//! The files of a robot, from what `robots/NAME/robot.toml.jinja` says of it.
//!
//! That file is a template itself, so that legs are written once and what follows from lengths is
//! computed; `robots/templates/` says how the files look.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, Value, context};

/// What went wrong.
pub type Error = Box<dyn std::error::Error>;

/// The robots.
pub const NAMES: [&str; 4] = ["hrp2", "hexapod", "hexapod_urp", "quadruped"];

/// Each file of a robot and its text.
pub fn files(name: &str) -> Result<[(PathBuf, String); 3], Error> {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let (folder, templates) = (robots.join(name), robots.join("templates"));
    let jinja = environment()?;
    let joints = read_to_string(folder.join("joints.csv")).unwrap_or_default();
    let said = read_to_string(folder.join("robot.toml.jinja"))?;
    let said = jinja.render_str(&said, context! { joints => rows(&joints) })?;
    let robot: Value = toml::from_str(&said)?;
    let file = |file: String, template: &str| -> Result<_, Error> {
        let template = read_to_string(templates.join(template))?;
        Ok((folder.join(file), jinja.render_str(&template, &robot)?))
    };
    Ok([
        file(format!("{name}.urdf"), "urdf.jinja")?,
        file(format!("{name}.srdf"), "srdf.jinja")?,
        file("contacts.toml".into(), "contacts.jinja")?,
    ])
}

fn environment() -> Result<Environment<'static>, Error> {
    let mut jinja = Environment::new();
    let syntax = SyntaxConfig::builder()
        .trim_blocks(true)
        .lstrip_blocks(true)
        .keep_trailing_newline(true)
        .build()?;
    jinja.set_syntax(syntax);
    jinja.add_filter("n", numbers);
    jinja.add_function("rad", |degrees: f64| degrees * (PI / 180.0));
    jinja.add_function("sin", f64::sin);
    jinja.add_function("cos", f64::cos);
    jinja.add_function("acos", f64::acos);
    jinja.add_function("atan2", f64::atan2);
    jinja.add_function("sqrt", f64::sqrt);
    Ok(jinja)
}

/// The lines of a CSV file by the names of its columns, numbers as such.
fn rows(csv: &str) -> Vec<BTreeMap<String, Value>> {
    let mut lines = csv.lines();
    let names = lines.next().unwrap_or_default();
    let value = |cell: &str| cell.parse::<f64>().map_or(cell.into(), Value::from);
    let names = names.split(',').map(str::to_owned);
    let row = |line: &str| names.clone().zip(line.split(',').map(value)).collect();
    lines.map(row).collect()
}

/// Decimals of at most ten places and no trailing zeros, with blanks between; text as it is.
fn numbers(value: &Value) -> Result<String, minijinja::Error> {
    if let Some(text) = value.as_str() {
        return Ok(text.to_owned());
    }
    let one = |value: &Value| {
        let text = format!("{:.10}", f64::try_from(value.clone())?);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        Ok(if text == "-0" { "0" } else { text }.to_owned())
    };
    match value.try_iter() {
        Err(_) => one(value),
        Ok(values) => {
            let words: Result<Vec<String>, minijinja::Error> = values.map(|v| one(&v)).collect();
            Ok(words?.join(" "))
        }
    }
}
