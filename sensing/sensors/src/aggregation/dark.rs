//! Regions of an image that are darker than what is around them.

use super::chessboard::Grey;

/// So much darker than the mean around it \[grey values\].
const DARKER: f64 = 12.0;

/// The pixels of each region whose pixels are darker than the mean of a square of `around` pixels about them, and joined side by side; regions that reach the image's rim are
/// left out.
pub(super) fn dark_regions(image: &Grey<'_>, around: usize) -> Vec<Vec<usize>> {
    let (width, height) = (image.width, image.height);
    let grey = |x: usize, y: usize| f64::from(image.pixels[y * width + x]);
    // Sums of all pixels above and to the left.
    let mut sums = vec![0.0; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0.0;
        for x in 0..width {
            row += grey(x, y);
            sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
        }
    }
    let half = (around / 2).max(2);
    let mean = |x: usize, y: usize| {
        let (x0, x1) = (x.saturating_sub(half), (x + half + 1).min(width));
        let (y0, y1) = (y.saturating_sub(half), (y + half + 1).min(height));
        let of = |x: usize, y: usize| sums[y * (width + 1) + x];
        (of(x1, y1) - of(x0, y1) - of(x1, y0) + of(x0, y0)) / ((x1 - x0) * (y1 - y0)) as f64
    };
    let mut dark: Vec<bool> = (0..width * height)
        .map(|i| grey(i % width, i / width) < mean(i % width, i / width) - DARKER)
        .collect();
    let mut regions = Vec::new();
    for first in 0..dark.len() {
        if !dark[first] {
            continue;
        }
        let mut pixels = vec![first];
        dark[first] = false;
        let (mut next, mut leaves) = (0, false);
        while let Some(i) = pixels.get(next).copied() {
            next += 1;
            let (x, y) = (i % width, i / width);
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                leaves = true;
                continue;
            }
            for other in [i - 1, i + 1, i - width, i + width] {
                if dark[other] {
                    dark[other] = false;
                    pixels.push(other);
                }
            }
        }
        if !leaves {
            regions.push(pixels);
        }
    }
    regions
}
