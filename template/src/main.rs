//! A provisional task.

mod generators;

fn main() {
    println!("nothing moves yet");
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_project_passes_its_own_test() {}
}
