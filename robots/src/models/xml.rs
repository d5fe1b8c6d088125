//! What an XML text may ask of roxmltree, checked before it is read: the reader compares all attributes of an element
//! with one another, and, where an element declares a namespace, all those that it can see.
//!
//! In: a text of any length. Out: nothing, or the first place that asks for too much. The check passes once over the
//! text, and finds tags as the reader does: outside of comments and CDATA, and with `>` in quotes as part of a value.

/// Most attributes of one element. Drawing programs and URDF write some ten.
pub const MOST_ATTRIBUTES: usize = 128;

/// Most attributes of all elements together, of which each takes some hundred bytes of memory. An element that declares a
/// namespace counts those that it can see as well: the reader lists them for it.
pub const MOST_ATTRIBUTES_IN_ALL: usize = 1_000_000;

/// Most declarations of namespaces that one element can see: its own, and those of the elements round it.
pub const MOST_NAMESPACES: usize = 32;

/// An XML text asks for more than any file that a program or a person would write. Lines count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TooMuchXml {
    /// An element has too many attributes.
    #[error("line {line}: an element of more than {MOST_ATTRIBUTES} attributes")]
    Attributes {
        /// Line where the element begins.
        line: usize,
    },
    /// All elements together have too many attributes.
    #[error("line {line}: more than {MOST_ATTRIBUTES_IN_ALL} attributes and namespaces in all")]
    AttributesInAll {
        /// Line of the element that has one too many.
        line: usize,
    },
    /// Too many declarations of namespaces stand within one another.
    #[error("line {line}: more than {MOST_NAMESPACES} declarations of namespaces within one another")]
    Namespaces {
        /// Line where the innermost element begins.
        line: usize,
    },
    /// Elements are nested too deep.
    #[error("line {line}: elements nested more than {limit} deep")]
    Depth {
        /// Line where the innermost element begins.
        line: usize,
        /// The depth that was allowed.
        limit: usize,
    },
}

impl TooMuchXml {
    /// The line of the element that is too much, from 1.
    #[must_use]
    pub const fn line(&self) -> usize {
        match *self {
            TooMuchXml::Attributes { line }
            | TooMuchXml::AttributesInAll { line }
            | TooMuchXml::Namespaces { line }
            | TooMuchXml::Depth { line, .. } => line,
        }
    }
}

/// Checks a text before roxmltree reads it. A text that is no XML passes up to the place where the reader refuses it.
///
/// # Errors
/// [`TooMuchXml`]: an element with too many attributes, too many namespaces, or elements nested deeper than `depth`.
pub fn check_xml(text: &str, depth: usize) -> Result<(), TooMuchXml> {
    // How many namespaces each open element can see.
    let mut open: Vec<usize> = Vec::new();
    let mut attributes = 0;
    let mut rest = text;
    let line = |rest: &str| text[..text.len() - rest.len()].bytes().filter(|byte| *byte == b'\n').count() + 1;
    while let Some(at) = rest.find('<') {
        let here = &rest[at..];
        let skipped = |end: &str| here.find(end).map(|found| &here[found + end.len()..]);
        let next = if here.starts_with("<!--") {
            skipped("-->")
        } else if here.starts_with("<![CDATA[") {
            skipped("]]>")
        } else if here.starts_with("<?") {
            skipped("?>")
        } else if here.starts_with("</") {
            open.pop();
            skipped(">")
        } else if here.starts_with("<!") {
            // A document type: the reader refuses it here.
            None
        } else {
            let tag = Tag::of(here);
            let sees = open.last().copied().unwrap_or(0) + tag.namespaces;
            if tag.attributes > MOST_ATTRIBUTES {
                return Err(TooMuchXml::Attributes { line: line(here) });
            }
            attributes += tag.attributes + if tag.namespaces > 0 { sees } else { 0 };
            if attributes > MOST_ATTRIBUTES_IN_ALL {
                return Err(TooMuchXml::AttributesInAll { line: line(here) });
            }
            if sees > MOST_NAMESPACES {
                return Err(TooMuchXml::Namespaces { line: line(here) });
            }
            if !tag.is_empty {
                open.push(sees);
            }
            if open.len() > depth {
                return Err(TooMuchXml::Depth { line: line(here), limit: depth });
            }
            here.get(tag.length..)
        };
        let Some(next) = next else { break };
        rest = next;
    }
    Ok(())
}

/// What is counted of a tag.
struct Tag {
    attributes: usize,
    namespaces: usize,
    /// Whether it ends with `/>`.
    is_empty: bool,
    /// Its bytes, up to its end or the text's.
    length: usize,
}

impl Tag {
    /// The tag with which a text begins.
    fn of(text: &str) -> Tag {
        let bytes = text.as_bytes();
        let mut tag = Tag { attributes: 0, namespaces: 0, is_empty: false, length: bytes.len() };
        // Where the last name began.
        let mut name = 1;
        let mut at = 1;
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'>' => {
                    tag.is_empty = bytes[at - 1] == b'/';
                    tag.length = at + 1;
                    break;
                }
                b'"' | b'\'' => {
                    let Some(end) = bytes[at + 1..].iter().position(|other| *other == byte) else { break };
                    at += end + 1;
                }
                b'=' => {
                    tag.attributes += 1;
                    tag.namespaces += usize::from(bytes[name..].starts_with(b"xmlns"));
                }
                byte if byte.is_ascii_whitespace() => {}
                _ if matches!(bytes[at - 1], b'"' | b'\'') || bytes[at - 1].is_ascii_whitespace() => {
                    name = at
                }
                _ => {}
            }
            at += 1;
        }
        tag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<(), TooMuchXml> {
        check_xml(text, 8)
    }

    #[test]
    fn ordinary_texts_pass_whatever_stands_in_comments_and_quotes() {
        let many = "a='' ".repeat(MOST_ATTRIBUTES);
        for text in [
            "",
            "no xml at all <",
            "<a",
            "<a b='",
            "<a><b/></a>",
            "<a b='>'><c d=\"/>\"/></a>",
            "<?xml version='1.0'?><!-- <a <b <c --><a><![CDATA[<b <c]]></a>",
            &format!("<a {many}/>"),
            &format!("<!-- <a {many} b=''> -->{}", "<a/>".repeat(100)),
            &format!("<a b=\"{}\"/>", "= ".repeat(1000)),
        ] {
            assert_eq!(checked(text), Ok(()), "{text}");
        }
    }

    #[test]
    fn an_element_of_too_many_attributes_is_named_by_its_line() {
        let many = "a=''\n".repeat(MOST_ATTRIBUTES + 1);
        assert_eq!(checked(&format!("<a>\n<b {many}/></a>")), Err(TooMuchXml::Attributes { line: 2 }));
        assert_eq!(checked(&format!("<a {many}")), Err(TooMuchXml::Attributes { line: 1 }));
        let element = format!("<a {}/>", "b='' ".repeat(100));
        let all = MOST_ATTRIBUTES_IN_ALL / 100;
        assert_eq!(checked(&element.repeat(all)), Ok(()));
        assert_eq!(
            checked(&format!("{}\n<a b=''/>", element.repeat(all))),
            Err(TooMuchXml::AttributesInAll { line: 2 })
        );
    }

    #[test]
    fn namespaces_are_counted_where_they_can_be_seen() {
        let declared = |n: usize| (0..n).map(|i| format!("xmlns:n{i}='u' ")).collect::<String>();
        let half = declared(MOST_NAMESPACES / 2);
        // Beside one another they do no harm, within one another they add up.
        assert_eq!(checked(&format!("<a>{}</a>", format!("<b {half}/>").repeat(20))), Ok(()));
        assert_eq!(checked(&format!("<a {half}><b {half}></b><b {half}/></a>")), Ok(()));
        for one_more in ["xmlns='u'", "xmlns:m = 'u'", "x='' xmlns:m\n=\n'u'"] {
            let nested = format!("<a {half}><b {half}>\n<c {one_more}/></b></a>");
            assert!(matches!(checked(&nested), Err(TooMuchXml::Namespaces { .. })), "{one_more}");
        }
    }

    #[test]
    fn a_sign_in_quotes_does_not_end_a_tag() {
        let deep = "<a b='/>'>".repeat(9);
        assert_eq!(checked(&deep), Err(TooMuchXml::Depth { line: 1, limit: 8 }));
        assert_eq!(checked(&"<a b='/>'/>".repeat(9)), Ok(()));
    }
}
