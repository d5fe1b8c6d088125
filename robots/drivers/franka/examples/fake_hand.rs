//! The hand of this crate's tests, served for clients of others: `cargo run -p mrroc-examples --example fake_hand -- 127.0.0.1:1338 part=0.03
//! unhomed`. `part` is how wide what lies between its fingers is \[m\].
//!
//! For each line that it reads it says what it was asked for since, and where its fingers are, as one line of JSON; it ends where its
//! input ends.

#[path = "../src/hand/fake.rs"]
#[allow(dead_code, reason = "tests use all of it")]
mod fake;

use std::error::Error;
use std::io::{BufRead, stdin};
use std::sync::{Arc, Mutex, PoisonError};

use fake::{Fake, Fingers};
use mrroc_driver_kit::testing::Server;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let address = words.next().ok_or("which address?")?.parse()?;
    let mut fingers = Fingers::open();
    for word in words {
        match word.split_once('=') {
            Some(("part", width)) => fingers.object = Some(width.parse()?),
            None if word == "unhomed" => (fingers.max_width, fingers.width) = (0.0, 0.04),
            _ => return Err(format!("`{word}` is neither `part=WIDTH` nor `unhomed`").into()),
        }
    }
    let hand = Arc::new(Mutex::new(Fake::new(fingers)));
    let server = Server::start(address, Arc::clone(&hand))?;
    println!("a hand at {}", server.address());
    for line in stdin().lock().lines() {
        line?;
        let mut hand = hand.lock().unwrap_or_else(PoisonError::into_inner);
        let fingers = &mut hand.fingers;
        let (asked, width, is_grasped) =
            (std::mem::take(&mut fingers.asked), fingers.width, fingers.is_grasped);
        drop(hand);
        let asked: Vec<String> =
            asked.iter().map(|(request, numbers)| format!("[{request}, {numbers:?}]")).collect();
        println!(r#"{{"asked": [{}], "width": {width}, "is_grasped": {is_grasped}}}"#, asked.join(", "));
    }
    Ok(())
}
