//! Prints the true world of a scene as JSON.
//!
//! ```sh
//! cargo run -p scandent-scenes --example print_truth irregular-stairs
//! ```

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_default();
    let scene = scenes::builtin(&name).ok_or_else(|| {
        let names: Vec<_> = scenes::names().collect();
        format!("no scene `{name}`; there are {}", names.join(", "))
    })?;
    println!("{}", serde_json::to_string_pretty(&(scene.truth)())?);
    Ok(())
}
