//! Letters as strokes, and those beyond ASCII for the Hershey fonts, which have none: an ASCII letter with marks and strokes, or strokes alone.
//!
//! Unicode's canonical decomposition says which letter and which marks (é is e and an acute accent). Lengths are in
//! the fonts' own units: capitals are 21 high, small letters 14, y up from the baseline.

use super::{Affine, Bounds, Vec2};
use unicode_normalization::UnicodeNormalization;

/// Height of capitals, and of small letters without ascenders.
const CAPITAL: f64 = 21.0;
const SMALL: f64 = 14.0;
/// Between a letter and its mark.
const GAP: f64 = 3.0;
/// Kept free beside strokes.
const SIDE: f64 = 4.0;
/// The most letters of one that is written as several, as ½ is.
const MOST_PARTS: usize = 6;

/// A glyph: edges and polylines in font units, y up from the baseline.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Glyph {
    pub left: f64,
    pub right: f64,
    pub lines: Vec<Vec<Vec2>>,
}

/// A polyline by its points.
type Points = &'static [(i8, i8)];

/// A letter that the font does not have, from those of ASCII, or `None`.
pub fn composed<'a>(letter: char, ascii: &impl Fn(char) -> Option<&'a Glyph>) -> Option<Glyph> {
    with_strokes(letter, ascii)
        .or_else(|| of_strokes(letter))
        .or_else(|| with_marks(letter, ascii))
        .or_else(|| of_several(letter, ascii))
}

/// A letter and what goes through it or stands beside it.
fn with_strokes<'a>(letter: char, ascii: &impl Fn(char) -> Option<&'a Glyph>) -> Option<Glyph> {
    let same = match letter {
        // Greek capitals that look as Latin ones do.
        'Α' => 'A',
        'Β' => 'B',
        'Ε' => 'E',
        'Ζ' => 'Z',
        'Η' => 'H',
        'Ι' => 'I',
        'Κ' => 'K',
        'Μ' => 'M',
        'Ν' => 'N',
        'Ο' | 'Θ' | 'Φ' | 'Ø' | '⌀' | '∅' => 'O',
        'Ρ' => 'P',
        'Τ' | 'Ŧ' => 'T',
        'Υ' => 'Y',
        'Χ' => 'X',
        'ο' | 'ø' | 'φ' | 'ϕ' => 'o',
        'Ł' => 'L',
        'ł' => 'l',
        'Đ' | 'Ð' => 'D',
        'đ' => 'd',
        'Ħ' => 'H',
        'ħ' => 'h',
        'ŧ' => 't',
        'µ' | 'μ' => 'u',
        'þ' => 'p',
        '€' => 'C',
        '¥' => 'Y',
        '¢' => 'c',
        '±' => '+',
        '÷' => '-',
        '≤' => '<',
        '≥' => '>',
        '≠' => '=',
        '·' | '∙' => '.',
        'ı' => 'i',
        'ȷ' => 'j',
        '¡' => '!',
        '¿' => '?',
        _ => return None,
    };
    let mut glyph = ascii(same)?.clone();
    let Bounds { min, max } = bounds(&glyph.lines)?;
    let middle = (min + max) * 0.5;
    let mut line = |a: (f64, f64), b: (f64, f64)| {
        glyph.lines.push(vec![Vec2::new(a.0, a.1), Vec2::new(b.0, b.1)]);
    };
    match letter {
        'Ø' | 'ø' | '⌀' | '∅' => line((min.x - 1.0, min.y - 1.0), (max.x + 1.0, max.y + 1.0)),
        'Θ' => line((min.x + 5.0, middle.y), (max.x - 5.0, middle.y)),
        'Φ' => line((middle.x, min.y - 2.0), (middle.x, max.y + 2.0)),
        'φ' | 'ϕ' => line((middle.x, min.y - 6.0), (middle.x, max.y + 6.0)),
        'Ł' => line((min.x - 3.0, 8.0), (min.x + 7.0, 13.0)),
        'ł' => line((middle.x - 4.0, 8.0), (middle.x + 4.0, 13.0)),
        'Đ' | 'Ð' => line((min.x - 3.0, middle.y), (min.x + 6.0, middle.y)),
        'đ' => line((max.x - 6.0, 18.0), (max.x + 3.0, 18.0)),
        'Ħ' => line((min.x - 2.0, 16.0), (max.x + 2.0, 16.0)),
        'ħ' => line((min.x - 3.0, 17.0), (min.x + 5.0, 17.0)),
        'Ŧ' => line((middle.x - 5.0, 10.0), (middle.x + 5.0, 10.0)),
        'ŧ' => line((middle.x - 4.0, 8.0), (middle.x + 4.0, 8.0)),
        'µ' | 'μ' => line((min.x, 3.0), (min.x, -7.0)),
        'þ' => line((min.x, SMALL), (min.x, CAPITAL)),
        '€' | '¥' => {
            line((min.x - 3.0, 12.0), (middle.x + 3.0, 12.0));
            line((min.x - 3.0, 8.0), (middle.x + 3.0, 8.0));
        }
        '¢' => line((middle.x, min.y - 3.0), (middle.x, max.y + 3.0)),
        '±' | '≤' | '≥' => line((min.x, min.y - 4.0), (max.x, min.y - 4.0)),
        '≠' => line((middle.x - 4.0, min.y - 4.0), (middle.x + 4.0, max.y + 4.0)),
        '÷' => {
            for y in [middle.y + 5.0, middle.y - 6.0] {
                glyph.lines.push(moved(&points(DOT), Vec2::new(middle.x, y)));
            }
        }
        '·' | '∙' => glyph.lines.iter_mut().for_each(|line| *line = moved(line, Vec2::new(0.0, 8.0))),
        'ı' | 'ȷ' => glyph.lines.retain(|line| !is_dot_above(line)),
        '¡' | '¿' => {
            for p in glyph.lines.iter_mut().flatten() {
                *p = min + max - *p;
            }
        }
        _ => {}
    }
    Some(glyph)
}

/// A letter that is nothing but strokes.
fn of_strokes(letter: char) -> Option<Glyph> {
    let lines: &[Points] = match letter {
        '°' | 'º' | '˚' => {
            &[&[(3, 18), (2, 20), (0, 21), (-2, 20), (-3, 18), (-2, 16), (0, 15), (2, 16), (3, 18)]]
        }
        'ß' | 'ẞ' => &[&[
            (0, 0),
            (0, 14),
            (1, 18),
            (3, 20),
            (6, 21),
            (9, 20),
            (10, 17),
            (9, 14),
            (6, 12),
            (9, 11),
            (11, 8),
            (11, 4),
            (9, 1),
            (6, 0),
            (3, 1),
        ]],
        'Ω' => &[&[
            (-9, 0),
            (-3, 0),
            (-6, 5),
            (-8, 10),
            (-7, 16),
            (-4, 20),
            (0, 21),
            (4, 20),
            (7, 16),
            (8, 10),
            (6, 5),
            (3, 0),
            (9, 0),
        ]],
        'Δ' | '∆' => &[&[(-8, 0), (0, 21), (8, 0), (-8, 0)]],
        'Γ' => &[&[(0, 0), (0, 21), (11, 21)]],
        'Λ' => &[&[(-8, 0), (0, 21), (8, 0)]],
        'Π' => &[&[(-7, 0), (-7, 21), (7, 21), (7, 0)]],
        'π' => &[&[(-8, 14), (8, 14)], &[(-4, 14), (-4, 0)], &[(4, 14), (4, 0)]],
        'Σ' | '∑' => &[&[(7, 21), (-7, 21), (1, 11), (-7, 0), (7, 0)]],
        'Ξ' => &[&[(-7, 21), (7, 21)], &[(-4, 11), (4, 11)], &[(-7, 0), (7, 0)]],
        'Ψ' => &[&[(0, 0), (0, 21)], &[(-8, 20), (-8, 13), (-5, 9), (0, 8), (5, 9), (8, 13), (8, 20)]],
        'Þ' => &[&[(0, 0), (0, 21)], &[(0, 16), (8, 16), (11, 14), (12, 11), (11, 8), (8, 6), (0, 6)]],
        '√' => &[&[(-8, 9), (-5, 11), (-1, 0), (5, 24), (12, 24)]],
        '≈' => &[
            &[(-8, 10), (-7, 12), (-5, 13), (-2, 12), (2, 10), (5, 9), (7, 10), (8, 12)],
            &[(-8, 4), (-7, 6), (-5, 7), (-2, 6), (2, 4), (5, 3), (7, 4), (8, 6)],
        ],
        '«' => &[&[(0, 13), (-5, 8), (0, 3)], &[(6, 13), (1, 8), (6, 3)]],
        '»' => &[&[(-5, 13), (0, 8), (-5, 3)], &[(1, 13), (6, 8), (1, 3)]],
        '‹' => &[&[(2, 13), (-3, 8), (2, 3)]],
        '›' => &[&[(-2, 13), (3, 8), (-2, 3)]],
        '¬' => &[&[(-8, 10), (8, 10), (8, 5)]],
        '•' => &[&[(3, 9), (2, 11), (0, 12), (-2, 11), (-3, 9), (-2, 7), (0, 6), (2, 7), (3, 9)]],
        '£' => &[
            &[(8, 17), (7, 20), (4, 21), (1, 20), (-1, 17), (-1, 6), (-2, 2), (-4, 0), (8, 0)],
            &[(-4, 11), (4, 11)],
        ],
        '→' => &[&[(-10, 9), (10, 9)], &[(5, 13), (10, 9), (5, 5)]],
        '←' => &[&[(10, 9), (-10, 9)], &[(-5, 13), (-10, 9), (-5, 5)]],
        '↑' => &[&[(0, 0), (0, 20)], &[(-4, 15), (0, 20), (4, 15)]],
        '↓' => &[&[(0, 20), (0, 0)], &[(-4, 5), (0, 0), (4, 5)]],
        '□' => &[&[(-7, 1), (7, 1), (7, 15), (-7, 15), (-7, 1)]],
        '∠' => &[&[(9, 14), (-7, 0), (9, 0)]],
        _ => return None,
    };
    beside(lines.iter().map(|line| points(line)).collect())
}

/// A letter of ASCII with accents, by Unicode's decomposition.
fn with_marks<'a>(letter: char, ascii: &impl Fn(char) -> Option<&'a Glyph>) -> Option<Glyph> {
    let mut parts = std::iter::once(letter).nfd();
    let base = parts.next().filter(|base| *base != letter)?;
    let mut glyph = match ascii(base) {
        Some(glyph) => glyph.clone(),
        None => with_strokes(base, ascii).or_else(|| of_strokes(base))?,
    };
    for mark in parts {
        add_mark(&mut glyph, base, mark)?;
    }
    Some(glyph)
}

/// Where a mark goes.
enum Side {
    Above,
    Below,
    /// Touching the letter from below, in its middle or at its right.
    Under,
    UnderRight,
    /// At the upper right.
    Beside,
}

fn add_mark(glyph: &mut Glyph, base: char, mark: char) -> Option<()> {
    let (side, lines): (Side, &[Points]) = match (mark, base) {
        // A caron beside a tall letter is written as an apostrophe; a cedilla below one of these as a comma.
        ('\u{30c}', 'd' | 't' | 'l' | 'L') => (Side::Beside, &[&[(1, 0), (0, -5)]]),
        ('\u{327}', 'g') => (Side::Above, &[&[(1, 5), (-1, 3), (-1, 0)]]),
        ('\u{327}', 'G' | 'K' | 'k' | 'L' | 'l' | 'N' | 'n' | 'R' | 'r') | ('\u{326}', _) => {
            (Side::Below, &[&[(1, 0), (1, -2), (-1, -5)]])
        }
        ('\u{300}', _) => (Side::Above, &[&[(-3, 5), (1, 0)]]),
        ('\u{301}', _) => (Side::Above, &[&[(3, 5), (-1, 0)]]),
        ('\u{302}', _) => (Side::Above, &[&[(-4, 0), (0, 4), (4, 0)]]),
        ('\u{303}', _) => (Side::Above, &[&[(-5, 0), (-4, 2), (-2, 3), (0, 2), (2, 1), (4, 2), (5, 4)]]),
        ('\u{304}', _) => (Side::Above, &[&[(-4, 2), (4, 2)]]),
        ('\u{306}', _) => (Side::Above, &[&[(-4, 4), (-3, 1), (0, 0), (3, 1), (4, 4)]]),
        ('\u{307}', _) => (Side::Above, &[DOT]),
        ('\u{308}', _) => (Side::Above, &[DOT_LEFT, DOT_RIGHT]),
        ('\u{309}', _) => (Side::Above, &[&[(-2, 5), (0, 6), (2, 5), (2, 3), (0, 2), (0, 0)]]),
        ('\u{30a}', _) => {
            (Side::Above, &[&[(2, 1), (2, 3), (1, 4), (-1, 4), (-2, 3), (-2, 1), (-1, 0), (1, 0), (2, 1)]])
        }
        ('\u{30b}', _) => (Side::Above, &[&[(0, 5), (-3, 0)], &[(5, 5), (2, 0)]]),
        ('\u{30c}', _) => (Side::Above, &[&[(-4, 4), (0, 0), (4, 4)]]),
        ('\u{30f}', _) => (Side::Above, &[&[(-5, 5), (-2, 0)], &[(0, 5), (3, 0)]]),
        ('\u{311}', _) => (Side::Above, &[&[(-4, 0), (-3, 3), (0, 4), (3, 3), (4, 0)]]),
        ('\u{31b}', _) => (Side::Beside, &[&[(0, -2), (2, -1), (2, 2)]]),
        ('\u{323}', _) => (Side::Below, &[DOT_BELOW]),
        ('\u{327}', _) => (Side::Under, &[&[(0, 0), (0, -2), (2, -3), (2, -5), (0, -6), (-2, -6)]]),
        ('\u{328}', _) => (Side::UnderRight, &[&[(0, 0), (-2, -2), (-2, -4), (0, -6), (2, -5)]]),
        ('\u{331}', _) => (Side::Below, &[&[(-4, 0), (4, 0)]]),
        _ => return None,
    };
    if matches!(side, Side::Above) && matches!(base, 'i' | 'j') {
        glyph.lines.retain(|line| !is_dot_above(line));
    }
    let Bounds { min, max } = bounds(&glyph.lines)?;
    let middle = (min.x + max.x) / 2.0;
    let at = match side {
        Side::Above => Vec2::new(middle, max.y + GAP),
        Side::Below => Vec2::new(middle, min.y - GAP),
        Side::Under => Vec2::new(middle, min.y),
        Side::UnderRight => Vec2::new(max.x, min.y),
        Side::Beside => Vec2::new(max.x + GAP, max.y.min(CAPITAL)),
    };
    glyph.lines.extend(lines.iter().map(|line| moved(&points(line), at)));
    if matches!(side, Side::Beside) {
        glyph.right = glyph.right.max(max.x + GAP + SIDE);
    }
    Some(())
}

/// A letter that is written as others in a row: by what Unicode says of ligatures, fractions and wide letters, raised or
/// lowered where it is an index.
fn of_several<'a>(letter: char, ascii: &impl Fn(char) -> Option<&'a Glyph>) -> Option<Glyph> {
    let (scale, up) = match letter {
        '¹' | '²' | '³' | 'ª' | '⁰' | '⁴'..='⁹' | '⁺' | '⁻' | 'ⁿ' | '™' => (0.6, 9.0),
        '₀'..='₉' => (0.6, -4.0),
        _ => (1.0, 0.0),
    };
    let parts: String = match letter {
        'Æ' => "AE".to_owned(),
        'æ' => "ae".to_owned(),
        'Œ' => "OE".to_owned(),
        'œ' => "oe".to_owned(),
        '©' => "(C)".to_owned(),
        '®' => "(R)".to_owned(),
        '⁄' | '∕' => "/".to_owned(),
        '∙' | '⋅' => "·".to_owned(),
        '¦' => "|".to_owned(),
        'ð' => "đ".to_owned(),
        '‚' => ",".to_owned(),
        '„' => ",,".to_owned(),
        letter => std::iter::once(letter).nfkd().take(MOST_PARTS).collect(),
    };
    if parts.chars().eq([letter]) {
        return None;
    }
    let mut glyph = Glyph::default();
    for part in parts.chars() {
        let other;
        let one = match (ascii(part), part) {
            (Some(one), _) => one,
            // One step down only: what stands for a letter is plain.
            (None, '⁄') => ascii('/')?,
            (None, part) => {
                other = with_strokes(part, ascii).or_else(|| of_strokes(part))?;
                &other
            }
        };
        let map = Affine::translation(Vec2::new(glyph.right, up))
            .after(&Affine::scaling(scale, scale))
            .after(&Affine::translation(Vec2::new(-one.left, 0.0)));
        glyph.lines.extend(one.lines.iter().map(|line| line.iter().map(|p| map.point(*p)).collect()));
        glyph.right += (one.right - one.left) * scale;
    }
    Some(glyph)
}

/// As Hershey's fonts draw the dot of an i, with its lowest point at the origin; and two of them.
const DOT: Points = &[(0, 0), (-1, 1), (0, 2), (1, 1), (0, 0)];
const DOT_LEFT: Points = &[(-3, 0), (-4, 1), (-3, 2), (-2, 1), (-3, 0)];
const DOT_RIGHT: Points = &[(3, 0), (2, 1), (3, 2), (4, 1), (3, 0)];
const DOT_BELOW: Points = &[(0, 0), (-1, -1), (0, -2), (1, -1), (0, 0)];

/// Whether a polyline of an i or a j is its dot.
fn is_dot_above(line: &[Vec2]) -> bool {
    line.iter().all(|p| p.y > SMALL + 1.0)
}

fn points(line: Points) -> Vec<Vec2> {
    line.iter().map(|(x, y)| Vec2::new(f64::from(*x), f64::from(*y))).collect()
}

fn moved(line: &[Vec2], by: Vec2) -> Vec<Vec2> {
    line.iter().map(|p| p + by).collect()
}

/// Strokes with room on both sides.
fn beside(lines: Vec<Vec<Vec2>>) -> Option<Glyph> {
    let Bounds { min, max } = bounds(&lines)?;
    Some(Glyph { left: min.x - SIDE, right: max.x + SIDE, lines })
}

fn bounds(lines: &[Vec<Vec2>]) -> Option<Bounds> {
    let mut points = lines.iter().flatten();
    let first = *points.next()?;
    let around = |bounds: Bounds, p: &Vec2| Bounds { min: bounds.min.inf(p), max: bounds.max.sup(p) };
    Some(points.fold(Bounds { min: first, max: first }, around))
}

#[cfg(test)]
mod tests {
    use super::super::hershey::Font;

    /// The letters of the languages of Europe that are written in Latin letters, and signs of drawings.
    const LETTERS: &str = "ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚÛÜÝÞßàáâãäåæçèéêëìíîïðñòóôõöøùúûüýþÿ\
        ĀāĂăĄąĆćĈĉĊċČčĎďĐđĒēĔĕĖėĘęĚěĜĝĞğĠġĢģĤĥĦħĨĩĪīĬĭĮįİıĴĵĶķĹĺĻļĽľŁłŃńŅņŇňŌōŎŏŐőŒœŔŕŖŗŘřŚśŜŝŞşŠšŢţŤťŦŧŨũŪūŬŭŮůŰűŲųŴŵŶŷŸŹźŻżŽžȘșȚț\
        °±²³µ·¹¼½¾¡¿«»€£¥¢©®™≤≥≠≈÷√ΩΔΦΣΠπ∅⌀";

    #[test]
    fn letters_of_latin_alphabets_and_signs_are_in_every_font() {
        for name in Font::shipped() {
            let font = Font::open(name).unwrap();
            for letter in LETTERS.chars() {
                let strokes = font.line(&letter.to_string());
                assert!(!strokes.unwrap().is_empty(), "{name} {letter}");
                assert!(font.width(&letter.to_string()).unwrap() > 0.2, "{name} {letter}");
            }
        }
        let font = Font::open("futural").unwrap();
        assert_eq!(font.engravable("a漢b\u{1F600}"), ("a b ".to_owned(), vec!['漢', '\u{1F600}']));
    }

    /// Composed letters are as far apart as Unicode says: the base is whole, and the mark is on its side of it.
    #[test]
    fn marks_stand_over_and_under_their_letters() {
        let font = Font::open("futural").unwrap();
        let box_of = |text: &str| {
            let strokes = font.line(text).unwrap();
            strokes.iter().map(|stroke| stroke.bounds()).reduce(|a, b| a.union(&b)).unwrap()
        };
        for (composed, base) in [("É", "E"), ("ñ", "n"), ("ů", "u"), ("Ż", "Z")] {
            let (composed, base) = (box_of(composed), box_of(base));
            assert!(composed.max.y > base.max.y + 0.1 && (composed.min.y - base.min.y).abs() < 1e-9);
        }
        for (composed, base) in [("ç", "c"), ("Ą", "A"), ("ș", "s")] {
            let (composed, base) = (box_of(composed), box_of(base));
            assert!(composed.min.y < base.min.y - 0.1 && (composed.max.y - base.max.y).abs() < 1e-9);
        }
        // The dot of an i is left out.
        let count = |text: &str| font.line(text).unwrap().len();
        assert_eq!(count("í"), count("i"));
        assert_eq!(count("ï"), count("i") + 1);
    }
}
