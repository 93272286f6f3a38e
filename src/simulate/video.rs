//! Pictures of a run → a video, by FFmpeg where it is installed.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

/// Extensions of the containers that take H.264.
const CONTAINERS: [&str; 3] = ["mp4", "mkv", "mov"];

/// Refuses what cannot become a video, before anything is computed for it.
///
/// # Errors
/// A file name with another extension, FFmpeg that does not start.
pub fn check(file: &Path) -> Result<()> {
    let extension = file.extension().and_then(OsStr::to_str).unwrap_or_default();
    if !CONTAINERS.contains(&extension) {
        let (file, known) = (file.display(), CONTAINERS.join(", ."));
        bail!("{file}: a video's name ends with one of .{known}");
    }
    let started = Command::new("ffmpeg")
        .arg("-version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    if !started.is_ok_and(|status| status.success()) {
        bail!(
            "{}: a video is made by ffmpeg, which does not start here; install it, or take the \
             pictures with --frames",
            file.display()
        );
    }
    Ok(())
}

/// Joins the pictures `000000.png`, `000001.png`, … of a folder, `every_s` apart.
///
/// # Errors
/// FFmpeg's own, a file that cannot be put in its place.
pub fn encode(frames: &Path, every_s: f64, file: &Path) -> Result<()> {
    let extension = file.extension().and_then(OsStr::to_str).unwrap_or("mp4");
    let unfinished = frames.join(format!("unfinished.{extension}"));
    let output = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error", "-framerate"])
        .arg(format!("{}", 1.0 / every_s))
        .arg("-i")
        .arg(frames.join("%06d.png"))
        .args(["-c:v", "libx264", "-pix_fmt", "yuv420p"])
        .arg(&unfinished)
        .output()
        .context("ffmpeg")?;
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        bail!("{}: ffmpeg: {}", file.display(), words.trim());
    }
    let bytes = std::fs::read(&unfinished).with_context(|| unfinished.display().to_string())?;
    crate::output::write(file, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_no_videos_is_refused() {
        let refused = check(Path::new("climb.gif")).expect_err("no video");
        assert!(refused.to_string().contains("climb.gif"), "{refused}");
        assert!(refused.to_string().contains(".mp4"), "{refused}");
    }
}
