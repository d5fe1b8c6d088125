//! Bright things before a dark belt: which pixels belong together.

/// A thing in an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blob {
    /// Its pixels, row by row from the upper left.
    pub pixels: Vec<usize>,
    /// Columns and rows that hold it, ends excluded.
    pub window: [[usize; 2]; 2],
}

/// Finds things in images of one size.
#[derive(Clone, Debug)]
pub struct Blobs {
    size: [usize; 2],
    /// The grey value above which a pixel is no belt.
    threshold: Vec<u8>,
    /// The number of the thing that a pixel belongs to, from 1 on.
    labels: Vec<u16>,
    stack: Vec<usize>,
}

impl Blobs {
    /// Columns and rows of the squares whose mean is taken for the belt's brightness.
    const SQUARE: usize = 32;
    /// How much brighter than the belt something is at least: a factor, and grey values.
    const BRIGHTER: (f64, f64) = (1.3, 4.0);
    /// A thing has so many pixels at least.
    const LEAST: usize = 1500;

    /// For images of this many columns and rows, which an image of the empty belt shows how bright it is.
    ///
    /// # Panics
    /// If the image has another size.
    #[must_use]
    pub fn of(size: [usize; 2], empty: &[u8]) -> Self {
        assert_eq!(empty.len(), size[0] * size[1], "the image has another size");
        let squares = size.map(|side| side.div_ceil(Self::SQUARE));
        let mut sums = vec![(0_u32, 0_u32); squares[0] * squares[1]];
        for (index, grey) in empty.iter().enumerate() {
            let sum = &mut sums[index / size[0] / Self::SQUARE * squares[0] + index % size[0] / Self::SQUARE];
            *sum = (sum.0 + u32::from(*grey), sum.1 + 1);
        }
        let mean = |i: usize, j: usize| {
            let (sum, count) = sums[j.min(squares[1] - 1) * squares[0] + i.min(squares[0] - 1)];
            f64::from(sum) / f64::from(count)
        };
        let threshold = |index: usize| {
            // Between the middles of squares, linearly.
            let [x, y] = [index % size[0], index / size[0]]
                .map(|at| ((at as f64 + 0.5) / Self::SQUARE as f64 - 0.5).max(0.0));
            let (i, j) = (x as usize, y as usize);
            let (s, t) = (x.fract(), y.fract());
            let upper = mean(i, j) * (1.0 - s) + mean(i + 1, j) * s;
            let lower = mean(i, j + 1) * (1.0 - s) + mean(i + 1, j + 1) * s;
            let belt = upper * (1.0 - t) + lower * t;
            (Self::BRIGHTER.0 * belt + Self::BRIGHTER.1).clamp(0.0, 254.0) as u8
        };
        let threshold = (0..empty.len()).map(threshold).collect();
        Self { size, threshold, labels: vec![0; empty.len()], stack: Vec::new() }
    }

    /// The things that are wholly in an image.
    ///
    /// # Panics
    /// If the image has another size.
    pub fn find(&mut self, image: &[u8]) -> Vec<Blob> {
        assert_eq!(image.len(), self.threshold.len(), "the image has another size");
        self.labels.fill(0);
        let mut found = Vec::new();
        let mut number = 0;
        for start in 0..image.len() {
            if image[start] <= self.threshold[start] || self.labels[start] != 0 {
                continue;
            }
            number = if number == u16::MAX { 1 } else { number + 1 };
            let blob = self.fill(image, start, number);
            let inside = (0..2).all(|i| blob.window[i][0] > 0 && blob.window[i][1] < self.size[i]);
            if inside && blob.pixels.len() >= Self::LEAST {
                found.push(blob);
            }
        }
        found
    }

    /// All pixels that belong to one, by its edges.
    fn fill(&mut self, image: &[u8], start: usize, number: u16) -> Blob {
        let [width, height] = self.size;
        let mut blob = Blob { pixels: Vec::new(), window: [[usize::MAX, 0], [usize::MAX, 0]] };
        self.labels[start] = number;
        self.stack.push(start);
        while let Some(index) = self.stack.pop() {
            blob.pixels.push(index);
            for (side, at) in blob.window.iter_mut().zip([index % width, index / width]) {
                *side = [side[0].min(at), side[1].max(at + 1)];
            }
            let (x, y) = (index % width, index / width);
            let beside = [
                (x > 0).then(|| index - 1),
                (x + 1 < width).then(|| index + 1),
                (y > 0).then(|| index - width),
                (y + 1 < height).then(|| index + width),
            ];
            for next in beside.into_iter().flatten() {
                if self.labels[next] == 0 && image[next] > self.threshold[next] {
                    self.labels[next] = number;
                    self.stack.push(next);
                }
            }
        }
        blob.pixels.sort_unstable();
        blob
    }
}

impl Blob {
    /// The pixels of its rim, in images of this width: those with something else beside them.
    #[must_use]
    pub fn rim(&self, width: usize) -> Vec<usize> {
        let has = |index: usize| self.pixels.binary_search(&index).is_ok();
        let inner = |&index: &usize| {
            has(index.wrapping_sub(1))
                && has(index + 1)
                && has(index.wrapping_sub(width))
                && has(index + width)
        };
        self.pixels.iter().copied().filter(|index| !inner(index)).collect()
    }

    /// Pixels of its window that are its own, `true`, and of holes in it: how many those are.
    #[must_use]
    pub fn holes(&self, width: usize) -> usize {
        let [[left, right], [top, bottom]] = self.window;
        let (columns, rows) = (right - left + 2, bottom - top + 2);
        // A rim of its own around the window, from which all that is outside is reached.
        let mut taken = vec![false; columns * rows];
        for &index in &self.pixels {
            taken[(index / width - top + 1) * columns + index % width - left + 1] = true;
        }
        let mut outside = 0;
        let mut stack = vec![0];
        taken[0] = true;
        while let Some(at) = stack.pop() {
            outside += 1;
            let (x, y) = (at % columns, at / columns);
            let beside = [
                (x > 0).then(|| at - 1),
                (x + 1 < columns).then(|| at + 1),
                (y > 0).then(|| at - columns),
                (y + 1 < rows).then(|| at + columns),
            ];
            for next in beside.into_iter().flatten() {
                if !taken[next] {
                    taken[next] = true;
                    stack.push(next);
                }
            }
        }
        columns * rows - outside - self.pixels.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_told_apart_and_those_at_the_edge_left_out() {
        let size = [200, 150];
        let mut image = vec![20; size[0] * size[1]];
        let mut blobs = Blobs::of(size, &image);
        let mut paint = |columns: core::ops::Range<usize>, rows: core::ops::Range<usize>, grey| {
            for row in rows {
                columns.clone().for_each(|column| image[row * size[0] + column] = grey);
            }
        };
        paint(10..60, 10..70, 120); // with a hole of 10 x 20
        paint(20..30, 20..40, 20);
        paint(80..140, 50..90, 60);
        paint(150..200, 50..100, 90); // at the edge
        paint(100..110, 120..130, 200); // too small
        let found = blobs.find(&image);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].pixels.len(), found[0].holes(size[0])), (50 * 60 - 200, 200));
        assert_eq!((found[1].window, found[1].holes(size[0])), ([[80, 140], [50, 90]], 0));
        assert_eq!(found[1].rim(size[0]).len(), 2 * (60 + 40) - 4);
    }
}
