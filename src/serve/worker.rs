//! Who carries a request and its answer where the program runs in a browser's worker: the standard input and output.

use std::io::{Read, Write};
use std::path::Path;

use anyhow::{Result, anyhow};

use super::{Answer, Refusal, Site};
use crate::cli::Global;

/// Answers the request on the standard input: a line with the method and the address, and the body. A plan's
/// progress goes to the standard error, a JSON object a line.
///
/// # Errors
/// What is refused.
pub fn answer(folder: &Path, global: &Global) -> Result<()> {
    let mut asked = String::new();
    std::io::stdin().read_to_string(&mut asked)?;
    let (line, body) = asked.split_once('\n').unwrap_or((&asked, ""));
    let (method, path) = line.split_once(' ').unwrap_or((line, ""));
    let site = Site::new(folder, global)?;
    let answer = site.answer(method, path, || Ok(body.as_bytes().to_vec()));
    let text = match answer {
        Ok(Answer::Page(html)) => html,
        Ok(Answer::Data(data)) => data.to_string(),
        Err(Refusal(code, why)) => {
            tracing::info!("{line}: {code}");
            return Err(anyhow!(why));
        }
    };
    Ok(std::io::stdout().write_all(text.as_bytes())?)
}
