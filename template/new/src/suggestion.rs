//! "Did you mean ..?"

/// The name that was probably meant.
fn nearest<'a>(written: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let written = written.to_lowercase();
    let farthest = (written.chars().count() / 3).clamp(1, 3);
    names
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(&written, &name.to_lowercase()), name))
        .min()
        .filter(|&(distance, _)| distance <= farthest)
        .map(|(_, name)| name)
}

/// What to write instead: the nearest name, if any is near, and all that there are.
pub fn help<'a>(written: &str, what: &str, names: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let all = names.clone().into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match nearest(written, names) {
        Some(name) => format!("did you mean `{name}`? {what}: {all}"),
        None => format!("{what}: {all}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_near_is_suggested() {
        assert_eq!(nearest("stright_line", ["spline_track", "straight_line"]), Some("straight_line"));
        assert_eq!(nearest("ONE", ["one", "two"]), Some("one"));
        assert_eq!(nearest("seven", ["one", "two"]), None);
        assert_eq!(help("tow", "it can be", ["one", "two"]), "did you mean `two`? it can be: `one`, `two`");
    }
}
