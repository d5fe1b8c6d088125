//! Style sheets and `style` attributes, put so that usvg reads them as browsers do.
//!
//! In: CSS as people write it. Out: the same declarations with names in lower case, without comments, at-rules and names
//! of vendors, and with transforms in the grammar of the `transform` attribute, which has no units.

use super::units;
use std::borrow::Cow;
use std::fmt::Write;

/// A declaration: a name in lower case, a value without blanks round it, and whether it is `!important`.
pub struct Declaration<'a> {
    /// The property.
    pub name: String,
    /// Its value.
    pub value: Cow<'a, str>,
    /// Whether it wins over what comes later.
    pub important: bool,
}

/// The declarations of a `style` attribute or of a rule's block, without comments; what is none is passed over.
pub fn declarations(css: &str) -> impl Iterator<Item = Declaration<'_>> {
    split(css).filter_map(|text| {
        let (name, value) = text.split_once(':')?;
        let name = name.trim();
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
        let (value, important) = match value.rsplit_once('!') {
            Some((value, mark)) if mark.trim().eq_ignore_ascii_case("important") => (value.trim(), true),
            _ => (value.trim(), false),
        };
        let name = name.to_ascii_lowercase();
        let is_keyword = value.bytes().all(|byte| byte.is_ascii_alphabetic() || byte == b'-');
        let value = if name == "transform" {
            transform(value).map_or(Cow::Borrowed(value), Cow::Owned)
        } else if is_keyword && value.bytes().any(|byte| byte.is_ascii_uppercase()) {
            Cow::Owned(value.to_ascii_lowercase())
        } else {
            Cow::Borrowed(value)
        };
        (is_name && !value.is_empty()).then_some(Declaration { name, value, important })
    })
}

/// Splits at semicolons outside of quotes and brackets.
fn split(css: &str) -> impl Iterator<Item = &str> {
    let (mut quote, mut brackets) = (None, 0_i32);
    css.split(move |c| {
        match (quote, c) {
            (Some(open), _) if open == c => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '(') => brackets += 1,
            (None, ')') => brackets -= 1,
            (None, ';') => return brackets <= 0,
            (None, _) => {}
        }
        false
    })
}

/// The text without `/* .. */`.
pub fn without_comments(css: &str) -> Cow<'_, str> {
    let Some(first) = css.find("/*") else { return Cow::Borrowed(css) };
    let (mut kept, mut rest) = (css[..first].to_owned(), &css[first..]);
    while let Some(start) = rest.find("/*") {
        kept.push_str(&rest[..start]);
        kept.push(' ');
        let inside = &rest[start + 2..];
        rest = inside.find("*/").map_or("", |end| &inside[end + 2..]);
    }
    kept.push_str(rest);
    Cow::Owned(kept)
}

/// A `style` attribute's value as usvg is to read it.
pub fn style(css: &str) -> String {
    let mut tidy = String::new();
    for Declaration { name, value, important } in declarations(&without_comments(css)) {
        let mark = if important { "!important" } else { "" };
        // Writing to a string does not fail.
        let _ = write!(tidy, "{name}:{value}{mark};");
    }
    tidy
}

/// A style sheet as usvg is to read it.
pub fn sheet(css: &str) -> String {
    let css = without_comments(css);
    let mut tidy = String::new();
    let mut rest = css.trim_start_matches("<!--");
    while let Some(end) = rest.find(['{', ';', '}']) {
        let selector = rest[..end].trim();
        let opens = rest[end..].starts_with('{');
        rest = &rest[end + 1..];
        if !opens {
            continue;
        }
        let block = block(rest);
        if !selector.starts_with('@') && !selector.is_empty() {
            let _ = writeln!(tidy, "{selector}{{{}}}", style(block));
        }
        rest = rest.get(block.len() + 1..).unwrap_or("");
    }
    tidy
}

/// Up to the brace that closes the block that has been opened.
fn block(css: &str) -> &str {
    let mut open = 1;
    for (at, byte) in css.bytes().enumerate() {
        match byte {
            b'{' => open += 1,
            b'}' => open -= 1,
            _ => {}
        }
        if open == 0 {
            return &css[..at];
        }
    }
    css
}

/// A CSS transform in the grammar of the attribute; `None` where it cannot be put so.
fn transform(css: &str) -> Option<String> {
    let mut list = String::new();
    let mut rest = css.trim();
    while !rest.is_empty() {
        let (name, tail) = rest.split_once('(')?;
        let (arguments, tail) = tail.split_once(')')?;
        let words =
            arguments.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|word| !word.is_empty());
        let words: Vec<&str> = words.collect();
        let name = name.trim().to_ascii_lowercase();
        let number = |word: &str| -> Option<f64> {
            match name.as_str() {
                "rotate" | "skew" | "skewx" | "skewy" => degrees(word),
                "translate" | "translatex" | "translatey" => pixels(word),
                _ => word.parse().ok(),
            }
        };
        let numbers: Vec<f64> = words.into_iter().map(number).collect::<Option<_>>()?;
        let _ = match (name.as_str(), numbers.as_slice()) {
            ("translate" | "translatex", [x]) => write!(list, "translate({x} 0)"),
            ("translate", [x, y]) => write!(list, "translate({x} {y})"),
            ("translatey", [y]) => write!(list, "translate(0 {y})"),
            ("scale", [s]) => write!(list, "scale({s} {s})"),
            ("scale", [x, y]) => write!(list, "scale({x} {y})"),
            ("scalex", [x]) => write!(list, "scale({x} 1)"),
            ("scaley", [y]) => write!(list, "scale(1 {y})"),
            ("rotate", [angle]) => write!(list, "rotate({angle})"),
            ("rotate", [angle, x, y]) => write!(list, "rotate({angle} {x} {y})"),
            ("skewx" | "skew", [angle]) => write!(list, "skewX({angle})"),
            ("skewy", [angle]) => write!(list, "skewY({angle})"),
            ("skew", [x, y]) => {
                write!(list, "matrix(1 {} {} 1 0 0)", y.to_radians().tan(), x.to_radians().tan())
            }
            ("matrix", [a, b, c, d, e, f]) => write!(list, "matrix({a} {b} {c} {d} {e} {f})"),
            _ => return None,
        };
        rest = tail.trim_start().trim_start_matches(',').trim_start();
    }
    Some(list)
}

fn degrees(word: &str) -> Option<f64> {
    let word = word.to_ascii_lowercase();
    for (unit, scale) in [("deg", 1.0), ("grad", 0.9), ("rad", 1_f64.to_degrees()), ("turn", 360.0)] {
        if let Some(number) = word.strip_suffix(unit) {
            return Some(number.parse::<f64>().ok()? * scale);
        }
    }
    word.parse().ok()
}

fn pixels(word: &str) -> Option<f64> {
    let length: svgtypes::Length = word.to_ascii_lowercase().parse().ok()?;
    units::absolute(length)
}
