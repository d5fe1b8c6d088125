//! The library's generators and their source text: what is copied into a project to be changed there.
//!
//! They stand in the registry of the library's tests as text, so that a project is made without compiling the library first.

/// One generator of the library.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name of its module and, with `.rs`, of its file.
    pub name: &'static str,
    /// Name of its type.
    pub type_name: &'static str,
    /// Its class in the paper's classification, which does not depend on the kinds of robot and sensor.
    pub class: &'static str,
    /// The text of its file, on the public interface alone.
    pub source: &'static str,
}

impl Entry {
    /// What it does: the first line of its file.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.source.lines().next().unwrap_or_default().trim_start_matches("//!").trim()
    }

    /// What is copied: its text without the examples of its documentation, which use it as the library's.
    #[must_use]
    pub fn copied(&self) -> String {
        let mut copied = String::with_capacity(self.source.len());
        let mut example = false;
        for line in self.source.split_inclusive('\n') {
            let of_example = example;
            if line.trim() == "/// ```" {
                example = !example;
                if example && copied.ends_with("///\n") {
                    copied.truncate(copied.len() - "///\n".len());
                }
            }
            if !of_example && !example {
                copied.push_str(line);
            }
        }
        copied
    }

    /// Whether it moves one robot, in the program of its ECP or of the MP.
    #[must_use]
    pub fn is_of_an_ecp(&self) -> bool {
        self.class.starts_with("ECP")
    }

    /// Whether it reads sensors.
    #[must_use]
    pub fn reads_sensors(&self) -> bool {
        self.reads("v")
    }

    /// Whether it is an ECP's and reads the MP's orders, so that the MP itself cannot move a robot by it.
    #[must_use]
    pub fn reads_orders(&self) -> bool {
        self.is_of_an_ecp() && self.reads("c0")
    }

    fn reads(&self, argument: &str) -> bool {
        self.class.split(['(', ',', ')']).any(|used| used.trim() == argument)
    }
}

macro_rules! registry {
    (
        copied: {
            $($name:ident: $type_name:ident<$($parameter:ty),*> { class: $class:literal, $($tried:tt)* })*
        }
        used: $used:tt
    ) => {
        /// All generators of the library that are copied, by name.
        pub const CATALOGUE: &[Entry] = &[$(Entry {
            name: stringify!($name),
            type_name: stringify!($type_name),
            class: $class,
            source: include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../../generators-lib/src/generators/",
                stringify!($name),
                ".rs"
            )),
        }),*];
    };
}

include!("../../../generators-lib/tests/registry/rows.rs");

#[cfg(test)]
mod tests {
    use super::*;

    /// The library's tests compare the classes with those of the code.
    #[test]
    fn a_class_says_whose_a_generator_is_and_what_it_reads() {
        for (name, says) in [
            ("joint_move", (true, false, false)),
            ("followed_frame", (true, true, false)),
            ("reach_state", (true, false, true)),
            ("ordered_force", (true, true, true)),
            ("constant_order", (false, false, false)),
            ("rigid_carry", (false, false, false)),
            ("squeezed_carry", (false, true, false)),
        ] {
            let entry = CATALOGUE.iter().find(|entry| entry.name == name).expect("in the catalogue");
            assert_eq!((entry.is_of_an_ecp(), entry.reads_sensors(), entry.reads_orders()), says, "{name}");
        }
    }

    #[test]
    fn every_entry_says_what_it_does_and_is_short() {
        for entry in CATALOGUE {
            assert!(entry.source.starts_with("//! ") && entry.summary().ends_with('.'), "{}", entry.name);
            assert!(entry.source.contains(&format!("pub struct {}", entry.type_name)), "{}", entry.name);
            let copied = entry.copied();
            let (generator, tests) = copied.split_once("#[cfg(test)]").expect("its test");
            assert!(generator.lines().count() < 100 && tests.contains("#[test]"), "{}", entry.name);
        }
    }

    /// An example names the library's type, which a copy is not, and robots that a project may not have.
    #[test]
    fn every_entry_has_an_example_which_is_not_copied() {
        for entry in CATALOGUE {
            let (generator, _) = entry.source.split_once("#[cfg(test)]").expect("its test");
            let uses = "/// use mrroc_generators::generators::";
            assert!(generator.contains(uses) && generator.contains("/// assert"), "{}", entry.name);
            let copied = entry.copied();
            assert!(!copied.contains("```") && !copied.contains("/// assert"), "{}", entry.name);
            let code = |text: &str| text.lines().filter(|line| !line.starts_with("///")).count();
            assert_eq!(code(&copied), code(entry.source), "{}", entry.name);
        }
    }
}
