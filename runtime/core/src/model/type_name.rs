//! The name of a generator or a condition, for observers.
//!
//! In: its type. Out: the name that the program gives it, without paths and parameters.

use core::fmt::{self, Write};

/// The name of a generator's or condition's type, shown as the program writes it: `Carry` for
/// `program::carry::Carry<robots::Irp6>`. [`Each`](crate::generator::Each) is shown as its motions: `Line, Carry`.
///
/// ```
/// # use mrroc_core as mrroc;
/// use mrroc::generator::TypeName;
///
/// struct Carry<R>(R);
/// assert_eq!(TypeName::of::<Carry<Vec<u8>>>().to_string(), "Carry");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TypeName(&'static str);

impl TypeName {
    /// The name of nothing: the empty text.
    pub const NONE: TypeName = TypeName("");

    /// The name of this type.
    #[must_use]
    pub fn of<T: ?Sized>() -> TypeName {
        TypeName(core::any::type_name::<T>())
    }

    /// An instruction that has no generator or condition, by the name of its method.
    pub(crate) const fn named(method: &'static str) -> TypeName {
        TypeName(method)
    }

    /// The first `N` bytes of the name as it is shown, and how many bytes there are; without allocation.
    #[must_use]
    pub fn bytes<const N: usize>(self) -> ([u8; N], usize) {
        let mut room = Room { bytes: [0; N], len: 0 };
        // What has no room is left out.
        let _ = write!(room, "{self}");
        (room.bytes, room.len)
    }
}

/// A text of a fixed size.
struct Room<const N: usize> {
    bytes: [u8; N],
    len: usize,
}

impl<const N: usize> Write for Room<N> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = &mut self.bytes[self.len..];
        let taken = text.len().min(room.len());
        room[..taken].copy_from_slice(&text.as_bytes()[..taken]);
        self.len += taken;
        if taken == text.len() { Ok(()) } else { Err(fmt::Error) }
    }
}

impl fmt::Display for TypeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_short(f, self.0)
    }
}

fn write_short(f: &mut fmt::Formatter<'_>, name: &str) -> fmt::Result {
    let (path, parameters) = name.split_once('<').unwrap_or((name, ""));
    let last = path.rsplit("::").next().unwrap_or_default();
    if last != "Each" || !path.starts_with(concat!(env!("CARGO_CRATE_NAME"), "::")) {
        return f.write_str(last);
    }
    let mut rest = parameters.strip_suffix('>').unwrap_or(parameters).trim_matches(['(', ')']);
    // An array of motions of one kind: `[Line<Irp6>; 2]`.
    rest =
        rest.strip_prefix('[').map_or(rest, |array| array.rsplit_once(';').map_or(array, |(item, _)| item));
    let mut is_first = true;
    while let Some((item, after)) = first_of_list(rest) {
        if !core::mem::take(&mut is_first) {
            f.write_str(", ")?;
        }
        write_short(f, item)?;
        rest = after;
    }
    Ok(())
}

/// The first item of a list separated by commas, and what is behind it. Commas within brackets belong to an item.
fn first_of_list(list: &str) -> Option<(&str, &str)> {
    let list = list.trim_start();
    let mut depth = 0_usize;
    for (at, character) in list.char_indices() {
        match character {
            '<' | '(' | '[' => depth += 1,
            '>' | ')' | ']' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => return Some((&list[..at], &list[at + 1..])),
            _ => {}
        }
    }
    (!list.is_empty()).then_some((list, ""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::each::Each;

    struct Carry<T>(T);
    struct Turn;

    #[test]
    fn a_type_is_shown_by_the_name_that_the_program_gives_it() {
        for (name, shown) in [
            (TypeName::of::<Turn>(), "Turn"),
            (TypeName::of::<Carry<(Turn, Carry<u8>)>>(), "Carry"),
            (TypeName::of::<Each<(Carry<(u8, u8)>,)>>(), "Carry"),
            (TypeName::of::<Each<(Turn, Carry<[u8; 2]>, Turn)>>(), "Turn, Carry, Turn"),
            (TypeName::of::<Each<[Carry<(Turn, u8)>; 3]>>(), "Carry"),
            (TypeName::NONE, ""),
        ] {
            assert_eq!(name.to_string(), shown);
            let (bytes, len) = name.bytes::<4>();
            assert_eq!(bytes[..len], shown.as_bytes()[..shown.len().min(4)]);
        }
    }

    mod mine {
        pub struct Each<T>(pub T);
    }

    #[test]
    fn a_generator_of_the_users_that_is_called_each_keeps_its_name() {
        // Of the users' crates it is known by its path, which begins with another crate's name.
        let shown = |name: &'static str| TypeName(name).to_string();
        assert_eq!(shown("task::Each<(task::Line<robots::Irp6>,)>"), "Each");
        assert_eq!(TypeName::of::<Carry<mine::Each<u8>>>().to_string(), "Carry");
    }
}
