//! A camera and an echo sounder in one: hands over an image of 8 bits, one of 16 bits and an echo with each reading.

use mrroc::prelude::*;
use mrroc::sensor::Frames;

/// Pixels in a row, rows.
pub const SIZE: (u32, u32) = (16, 12);

/// What it reads.
pub struct Seen;

impl Sensor for Seen {
    const KIND: &'static str = "camera";
    type Reading = Brightness;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
pub struct Brightness {
    pub mean: f64,
}

pub struct Camera {
    frames: Frames,
    colours: Vec<u8>,
    depths: Vec<u16>,
    echo: Vec<f32>,
}

/// A channel of a pixel of the image of a step.
pub fn colour(step: u64, i: usize) -> u8 {
    (step as usize * 7 + i * 3) as u8
}

/// A pixel of its image of 16 bits.
pub fn depth(step: u64, i: usize) -> u16 {
    (step as usize * 301 + i * 257) as u16
}

/// A sample of its echo.
pub fn sample(step: u64, i: usize) -> f32 {
    step as f32 * 0.25 - i as f32
}

impl Camera {
    pub fn new(slots: usize) -> Camera {
        let pixels = (SIZE.0 * SIZE.1) as usize;
        Camera {
            frames: Frames::new(slots, 3 * pixels),
            colours: vec![0; 3 * pixels],
            depths: vec![0; pixels],
            echo: vec![0.0; 5],
        }
    }
}

impl VirtualSensor for Camera {
    type Kind = Seen;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Brightness, Fault> {
        let step = order.step;
        self.colours.iter_mut().enumerate().for_each(|(i, c)| *c = colour(step, i));
        self.depths.iter_mut().enumerate().for_each(|(i, d)| *d = depth(step, i));
        self.echo.iter_mut().enumerate().for_each(|(i, s)| *s = sample(step, i));
        // Two images of one step would have one file: the odd steps have depths.
        if step.is_multiple_of(2) {
            self.frames.image(step, SIZE, 3, &self.colours);
        } else {
            self.frames.image_u16(step, SIZE, 1, &self.depths);
        }
        self.frames.echo(step, 1e-6, &self.echo);
        let sum: f64 = self.colours.iter().copied().map(f64::from).sum();
        Ok(Brightness { mean: sum / self.colours.len() as f64 })
    }

    fn frames(&mut self) -> Option<&mut Frames> {
        Some(&mut self.frames)
    }
}

struct Looks(u32);

#[condition(mp)]
fn looks(c: &mut Looks, v: &Reading<(Seen,)>) -> bool {
    c.0 -= u32::from(v.0.reading().is_some());
    c.0 == 0
}

/// Takes thirty readings.
pub fn look(mp: &mut Mp) -> Result<(), Fault> {
    let mut camera = mp.sensor::<Seen>("camera")?;
    mp.wait_until((), (&mut camera,), Looks(30)).map(drop)
}
