//! Which pairs of nodes of two trees have a pair of capsules below them that is checked.

use super::cover::Node;

/// A bit for each pair of nodes.
#[derive(Debug)]
pub(super) struct Bits {
    /// Words of a row, which is one of the nodes of the first tree.
    width: usize,
    words: Vec<u64>,
}

impl Bits {
    /// Of two trees whose nodes have such places, from what `is_checked` says of the numbers of two capsules.
    pub(super) fn of(one: &[Node], other: &[Node], is_checked: impl Fn(u32, u32) -> bool) -> Self {
        let width = other.len().div_ceil(64);
        let mut bits = Self { width, words: vec![0; width * one.len()] };
        for (i, a) in one.iter().enumerate().rev() {
            if !a.is_leaf() {
                let children = a.children(i);
                for k in 0..width {
                    bits.words[i * width + k] =
                        children.iter().fold(0, |all, child| all | bits.words[child * width + k]);
                }
                continue;
            }
            for (j, b) in other.iter().enumerate().rev() {
                let is_open = if b.is_leaf() {
                    is_checked(a.link, b.link)
                } else {
                    b.children(j).iter().any(|child| bits.has(i, *child))
                };
                bits.words[i * width + j / 64] |= u64::from(is_open) << (j % 64);
            }
        }
        bits
    }

    /// Whether there is one below the nodes with these places in their trees.
    pub(super) fn has(&self, one: usize, other: usize) -> bool {
        self.words[one * self.width + other / 64] >> (other % 64) & 1 == 1
    }
}
