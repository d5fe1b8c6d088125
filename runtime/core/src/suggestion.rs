//! What was probably meant by a word that is not known: for messages about names of robots, sensors, keys and options.

/// What was probably meant by a word, if anything.
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let likeness = |known: &str| strsim::jaro_winkler(&word.to_lowercase(), &known.to_lowercase());
    // One letter wrong, missing, or two in the wrong order: in short words a great part of them.
    let slip = |known: &&&str| strsim::damerau_levenshtein(word, known) == 1 && known.len() > 2;
    if let Some(slip) = known.iter().find(slip) {
        return Some(slip);
    }
    known
        .iter()
        .copied()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .filter(|best| likeness(best) > 0.8)
}

/// A sentence for a message: the word that was probably meant, and all that are known; `what_there_is` begins the list.
pub fn suggestion(word: &str, known: &[impl AsRef<str>], what_there_is: &str) -> String {
    let known: Vec<_> = known.iter().map(AsRef::as_ref).collect();
    let all = known.join(", ");
    match nearest(word, &known) {
        Some(meant) => format!("did you mean `{meant}`? {what_there_is}: {all}"),
        None => format!("{what_there_is}: {all}"),
    }
}
