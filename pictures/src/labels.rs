//! Labels in a column that do not overlap.
//!
//! In: where each label would like to be. Out: where it is: in the same order, at least a line apart, within the column.

use crate::svg::Range;

/// Heights of labels \[px\], each as near to its wish as the others let it; the column grows downwards when they
/// do not fit.
pub(crate) fn spread(wishes: &[f64], gap: f64, column: Range) -> Vec<f64> {
    let Range { low, high } = column;
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by(|a, b| wishes[*a].total_cmp(&wishes[*b]).then(a.cmp(b)));
    // Blocks of labels that touch, each centred on its wishes: first label, count, sum of wishes of its first label.
    let mut blocks: Vec<(usize, f64)> = Vec::new();
    let room = high.max(low + gap * wishes.len().saturating_sub(1) as f64);
    let top = |block: &(usize, f64)| {
        let span = gap * (block.0 - 1) as f64;
        (block.1 / block.0 as f64).clamp(low, (room - span).max(low))
    };
    for index in &order {
        let mut block = (1, wishes[*index]);
        while let Some(before) = blocks.last() {
            if top(before) + gap * before.0 as f64 <= top(&block) {
                break;
            }
            block = (before.0 + block.0, before.1 + block.1 - gap * (before.0 * block.0) as f64);
            blocks.pop();
        }
        blocks.push(block);
    }
    let heights = blocks
        .iter()
        .flat_map(|block| (0..block.0).map(move |k| (block, k)))
        .map(|(block, k)| top(block) + gap * k as f64);
    let mut spread = vec![0.0; wishes.len()];
    order.into_iter().zip(heights).for_each(|(index, height)| spread[index] = height);
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMN: Range = Range { low: 0.0, high: 100.0 };

    #[test]
    fn labels_with_room_stay_and_others_keep_apart_in_order() {
        assert_eq!(spread(&[10.0, 50.0], 12.0, COLUMN), [10.0, 50.0]);
        // Two at 50 are centred on it.
        assert_eq!(spread(&[50.0, 50.0], 12.0, COLUMN), [44.0, 56.0]);
        assert_eq!(spread(&[99.0, 98.0], 12.0, COLUMN), [100.0, 88.0]);
        for wishes in [vec![5.0; 8], vec![0.0, 3.0, 90.0, 91.0, 92.0, 4.0, 50.0, 51.0]] {
            let placed = spread(&wishes, 12.0, COLUMN);
            let mut sorted = placed.clone();
            sorted.sort_by(f64::total_cmp);
            assert!(sorted.windows(2).all(|w| w[1] - w[0] >= 12.0 - 1e-9), "{placed:?}");
            assert!(sorted[0] >= -1e-9 && sorted[7] <= 100.0 + 1e-9);
        }
        assert!(spread(&[], 12.0, COLUMN).is_empty());
    }
}
