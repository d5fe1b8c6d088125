//! What the counting allocator counts.

use std::hint::black_box;

use mrroc_counting_allocator::{bytes, count, peak};

#[test]
fn allocations_and_reallocations_are_counted() {
    let (_, none) = count(|| black_box(1.0_f64).sqrt());
    let (mut list, one) = count(|| black_box(Vec::<u8>::with_capacity(10)));
    let (_, more) = count(|| list.reserve_exact(100));
    let (_, zeroed) = count(|| black_box(vec![0_u8; 10]));
    assert_eq!([none, one, more, zeroed], [0, 1, 1, 1]);
}

#[test]
fn bytes_are_those_asked_for_and_stay_counted_when_freed() {
    let before = bytes();
    drop(black_box(vec![0_u8; 100]));
    drop(black_box(Vec::<u8>::with_capacity(23)));
    assert_eq!(bytes() - before, 123);
}

#[test]
fn the_peak_is_the_most_that_is_held_at_once() {
    let (inner, outer) = peak(|| {
        drop(black_box(vec![0_u8; 500]));
        let kept = black_box(vec![0_u8; 100]);
        let ((), inner) = peak(|| drop(black_box(vec![0_u8; 200])));
        drop(kept);
        inner
    });
    assert_eq!((inner, outer), (200, 500));
}

#[test]
fn another_thread_counts_for_itself() {
    let (send, receive) = std::sync::mpsc::sync_channel::<()>(1);
    let other = std::thread::spawn(move || {
        receive.recv().expect("the other thread sends");
        count(|| drop(black_box(vec![0_u8; 100]))).1
    });
    let ((), here) = count(|| {
        send.send(()).expect("the other thread receives");
        while !other.is_finished() {
            std::thread::yield_now();
        }
    });
    assert_eq!((here, other.join().expect("it ends")), (0, 1));
}
