//! Four legs carry a trunk over steps.
fn main() {
    for q in legs::places::start() { println!("{q:?}"); }
}
