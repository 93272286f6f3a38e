//! Pictures of a run, drawn off screen by MuJoCo through EGL.

use std::path::{Path, PathBuf};

use mujoco_rs::prelude::*;
use mujoco_rs::renderer::{MjRenderer, png};

use crate::Error;
use crate::execution::{Observer, TraceRow};
use crate::plant::Plant;

/// Width of a picture, pixels.
const WIDTH: u32 = 960;
/// Height of a picture, pixels.
const HEIGHT: u32 = 720;
/// Distance of the camera from the robot, m.
const DISTANCE_M: f64 = 3.2;
/// Direction of view, degrees: from behind the robot's right shoulder, downward.
const AZIMUTH_DEG: f64 = 120.0;
const ELEVATION_DEG: f64 = -18.0;

/// Draws a picture every so often into a folder: `000000.png`, `000001.png`, ….
pub struct Pictures {
    folder: PathBuf,
    every_s: f64,
    next_s: f64,
    drawn: usize,
    renderer: Option<MjRenderer>,
}

impl Pictures {
    /// Pictures `every_s` apart; the folder has to exist.
    pub fn new(folder: &Path, every_s: f64) -> Self {
        Self {
            folder: folder.to_owned(),
            every_s,
            next_s: 0.0,
            drawn: 0,
            renderer: None,
        }
    }

    /// How many were drawn.
    pub fn drawn(&self) -> usize {
        self.drawn
    }

    fn draw(&mut self, plant: &mut Plant, row: &TraceRow) -> Result<(), Error> {
        let fail = |e: &dyn std::fmt::Display| Error::Render(e.to_string());
        let data = plant.data_mut();
        if self.renderer.is_none() {
            let made = MjRenderer::builder()
                .width(WIDTH)
                .height(HEIGHT)
                .png_compression(png::Compression::Fast)
                .build(data.model());
            self.renderer = Some(made.map_err(|e| fail(&e))?);
        }
        let Some(renderer) = &mut self.renderer else {
            return Ok(());
        };
        let mut camera = MjvCamera::new_free(data.model());
        camera.lookat = [row.q[0], row.q[1], row.q[2]];
        camera.distance = DISTANCE_M;
        camera.azimuth = AZIMUTH_DEG;
        camera.elevation = ELEVATION_DEG;
        renderer.set_camera(camera);
        renderer.sync_data(data).map_err(|e| fail(&e))?;
        renderer.render().map_err(|e| fail(&e))?;
        let path = self.folder.join(format!("{:06}.png", self.drawn));
        renderer.save_rgb(&path).map_err(|e| fail(&e))?;
        self.drawn += 1;
        Ok(())
    }
}

impl Observer for Pictures {
    fn see(&mut self, plant: &mut Plant, row: &TraceRow) -> Result<(), Error> {
        if row.t_s + 1e-9 < self.next_s {
            return Ok(());
        }
        self.next_s += self.every_s;
        self.draw(plant, row)
    }
}

impl<A: Observer, B: Observer> Observer for (&mut A, &mut B) {
    fn see(&mut self, plant: &mut Plant, row: &TraceRow) -> Result<(), Error> {
        self.0.see(plant, row)?;
        self.1.see(plant, row)
    }
}
