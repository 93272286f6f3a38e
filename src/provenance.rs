//! What a result was computed from: each input's role, name and SHA-256.

use std::path::Path;

use anyhow::{Context, Result};
use plan::Input;
use sha2::{Digest, Sha256};

/// The role of what flags asked for beside a scene.
pub const FLAGS: &str = "flags";

/// The inputs read so far, in the order in which they were read.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    list: Vec<Input>,
}

impl Inputs {
    /// Notes an input of which the bytes are at hand.
    pub fn note(&mut self, role: &str, name: &str, bytes: &[u8]) {
        let input = Input {
            role: role.to_owned(),
            name: name.to_owned(),
            sha256: sha256(bytes),
        };
        if !self.list.contains(&input) {
            self.list.push(input);
        }
    }

    /// Reads a file and notes it.
    ///
    /// # Errors
    /// What the operating system says, with the role and the path.
    pub fn read(&mut self, role: &str, path: &Path) -> Result<Vec<u8>> {
        let bytes = read(role, path)?;
        self.note(role, &path.display().to_string(), &bytes);
        Ok(bytes)
    }

    /// The inputs.
    pub fn into_list(self) -> Vec<Input> {
        self.list
    }
}

/// The bytes of a file.
///
/// # Errors
/// What the operating system says, with the role and the path.
pub fn read(role: &str, path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("{}: cannot read this {role} file", path.display()))
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_agrees_with_the_standards_example() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            sha256(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn an_input_that_is_read_twice_is_listed_once() {
        let mut inputs = Inputs::default();
        inputs.note("scan", "a.png", b"1");
        inputs.note("scan", "a.png", b"1");
        inputs.note("scan", "b.png", b"2");
        let names: Vec<_> = inputs.into_list().into_iter().map(|i| i.name).collect();
        assert_eq!(names, ["a.png", "b.png"]);
    }
}
