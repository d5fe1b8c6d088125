//! Conversion of words to JSON and back, by the shape of their type; and the schema of such JSON.
//!
//! In: words and a [`Shape`]. Out: JSON text. In: a parsed value and a [`Shape`]. Out: the same words again, to the
//! bit.

use core::fmt::Write;

use serde_json::{Map, Value, json};

use mrroc_core::payload::{Shape, Wire};
use mrroc_core::pose::Pose;
use mrroc_core::robot::MAX_JOINTS;

/// Writes a number, also one that is not finite.
pub fn number(out: &mut String, x: f64) {
    // Writing to a text cannot fail.
    let _ = if x.is_nan() {
        out.write_str("\"NaN\"")
    } else if x.is_infinite() {
        out.write_str(if x > 0.0 { "\"Infinity\"" } else { "\"-Infinity\"" })
    } else {
        // Debug formatting gives the fewest digits that are read back as the same number.
        write!(out, "{x:?}")
    };
}

/// Reads a number of a recording, also one that is not finite.
#[must_use]
pub fn as_number(value: &Value) -> Option<f64> {
    match value.as_str() {
        Some("NaN") => Some(f64::NAN),
        Some("Infinity") => Some(f64::INFINITY),
        Some("-Infinity") => Some(f64::NEG_INFINITY),
        Some(_) => None,
        None => value.as_f64(),
    }
}

/// Reads a pose of finite numbers; `None` of one that is none.
pub fn pose(value: &Value) -> Option<Pose> {
    let mut of_pose = Vec::new();
    words(Shape::POSE, value, &mut of_pose)?;
    let is_finite = of_pose.iter().all(|word| f64::from_bits(*word).is_finite());
    let pose = Pose::get(&of_pose).ok().filter(|_| is_finite)?;
    // As it was shown, to the bit, where it is a turn.
    ((pose.rotation.norm() - 1.0).abs() < 1e-6).then_some(pose)
}

/// Writes a list of numbers.
pub fn numbers(out: &mut String, words: &[u64]) {
    list(out, words.len(), |out, i| number(out, f64::from_bits(words[i])));
}

fn list(out: &mut String, len: usize, mut item: impl FnMut(&mut String, usize)) {
    out.push('[');
    for i in 0..len {
        if i > 0 {
            out.push(',');
        }
        item(out, i);
    }
    out.push(']');
}

/// Writes the value that words of this shape represent. Missing words at the end count as 0.
pub fn value(out: &mut String, shape: &Shape, words: &[u64]) {
    let word = words.first().copied().unwrap_or(0);
    let _ = match shape {
        Shape::Float => return number(out, f64::from_bits(word)),
        Shape::Single => return number(out, f64::from(f32::from_bits(word as u32))),
        Shape::Unsigned => write!(out, "{word}"),
        Shape::Signed => write!(out, "{}", word.cast_signed()),
        Shape::Truth => write!(out, "{}", word != 0),
        Shape::Choice(names) => match usize::try_from(word).ok().and_then(|word| names.get(word)) {
            Some(name) => write!(out, "\"{name}\""),
            None => write!(out, "{word}"),
        },
        Shape::Array(item, count) => {
            let of = |i: usize| words.get(i * item.len()..).unwrap_or(&[]);
            return list(out, *count, |out, i| value(out, item, of(i)));
        }
        Shape::Fields(fields) => {
            let mut rest = words;
            for (i, (name, shape)) in fields.iter().enumerate() {
                let _ = write!(out, "{}\"{name}\":", if i == 0 { '{' } else { ',' });
                value(out, shape, rest);
                rest = rest.get(shape.len()..).unwrap_or(&[]);
            }
            out.write_str(if fields.is_empty() { "{}" } else { "}" })
        }
        Shape::Variants(variants) => {
            let chosen = usize::try_from(word).ok().and_then(|word| variants.get(word));
            let Some((name, shape)) = chosen else {
                let _ = write!(out, "{{\"choice\":{word}}}");
                return;
            };
            let _ = write!(out, "{{\"choice\":\"{name}\"");
            if !shape.is_empty() {
                let _ = write!(out, ",\"{name}\":");
                value(out, shape, words.get(1..).unwrap_or(&[]));
            }
            out.write_str("}")
        }
        Shape::Demand => return demand(out, words),
        Shape::Words(len) => {
            let word = |i: usize| words.get(i).copied().unwrap_or(0);
            return list(out, *len, |out, i| {
                let _ = write!(out, "\"{:016x}\"", word(i));
            });
        }
    };
}

/// The value that words of this shape represent, as a recording has it.
#[must_use]
pub fn json_of(shape: &Shape, words: &[u64]) -> Value {
    let mut text = String::new();
    value(&mut text, shape, words);
    serde_json::from_str(&text).unwrap_or_default()
}

/// Appends the words that represent a value; `None` if the value does not have this shape.
pub fn words(shape: &Shape, value: &Value, out: &mut Vec<u64>) -> Option<()> {
    match shape {
        Shape::Float => out.push(as_number(value)?.to_bits()),
        Shape::Single => out.push(u64::from((as_number(value)? as f32).to_bits())),
        Shape::Unsigned => out.push(value.as_u64()?),
        Shape::Signed => out.push(value.as_i64()?.cast_unsigned()),
        Shape::Truth => out.push(u64::from(value.as_bool()?)),
        Shape::Choice(names) => {
            let name = value.as_str()?;
            out.push(names.iter().position(|known| *known == name)? as u64);
        }
        Shape::Array(item, count) => {
            let items = value.as_array().filter(|items| items.len() == *count)?;
            items.iter().try_for_each(|value| words(item, value, out))?;
        }
        Shape::Fields(fields) => {
            let found = value.as_object()?;
            fields.iter().try_for_each(|(name, shape)| words(shape, found.get(*name)?, out))?;
        }
        Shape::Variants(variants) => {
            let name = value.get("choice")?.as_str()?;
            let place = variants.iter().position(|(known, _)| *known == name)?;
            let end = out.len() + shape.len();
            out.push(place as u64);
            let chosen = variants[place].1;
            if !chosen.is_empty() {
                words(chosen, value.get(name)?, out)?;
            }
            out.resize(end, 0);
        }
        Shape::Words(len) => {
            let items = value.as_array().filter(|items| items.len() == *len)?;
            for item in items {
                out.push(u64::from_str_radix(item.as_str()?, 16).ok()?);
            }
        }
        // Demands are not read back, because a replay computes them anew.
        Shape::Demand => return None,
    }
    Some(())
}

/// Writes the part of a demand that its first word chooses, in the layout of `Demand`.
fn demand(out: &mut String, words: &[u64]) {
    if words.is_empty() {
        return out.push_str("{}");
    }
    // Words that would say nothing are not sent.
    let mut whole = [0; 1 + MAX_JOINTS + 9];
    for (word, said) in whole.iter_mut().zip(words) {
        *word = *said;
    }
    let [head, ref body @ ..] = whole;
    let form =
        [("hold", None), ("joints", None), ("pose", Some(Shape::POSE)), ("displacement", Some(Shape::POSE))]
            .get((head & 0xff) as usize)
            .copied()
            .unwrap_or(("unknown", None));
    let _ = write!(out, "{{\"form\":\"{}\"", form.0);
    match form {
        ("joints", _) => {
            out.push_str(",\"joints\":");
            numbers(out, &body[..MAX_JOINTS]);
        }
        (name, Some(shape)) => {
            let _ = write!(out, ",\"{name}\":");
            value(out, shape, body);
        }
        (_, None) => {}
    }
    if head & 1 << 8 != 0 {
        out.push_str(",\"tool\":");
        value(out, Shape::POSE, &body[MAX_JOINTS..]);
    }
    if head & 1 << 9 != 0 {
        out.push_str(",\"redundancy\":");
        number(out, f64::from_bits(body[MAX_JOINTS + 7]));
    }
    if head & 1 << 10 != 0 {
        out.push_str(",\"regulators\":");
        list(out, MAX_JOINTS, |out, i| {
            let _ = write!(out, "{}", body[MAX_JOINTS + 8].to_le_bytes()[i]);
        });
    }
    out.push('}');
}

/// The JSON schema of a shape.
pub fn schema(shape: &Shape) -> Value {
    match shape {
        Shape::Float | Shape::Single => json!({"type": "number"}),
        Shape::Unsigned | Shape::Signed => json!({"type": "integer"}),
        Shape::Truth => json!({"type": "boolean"}),
        Shape::Choice(names) => json!({"type": "string", "enum": names}),
        Shape::Array(item, count) => {
            json!({"type": "array", "items": schema(item), "minItems": count, "maxItems": count})
        }
        Shape::Fields(fields) => object(fields.iter().map(|(name, shape)| (*name, schema(shape)))),
        Shape::Variants(variants) => {
            let names: Vec<_> = variants.iter().map(|(name, _)| *name).collect();
            let values = variants.iter().filter(|(_, shape)| !shape.is_empty());
            let choice = ("choice", json!({"type": "string", "enum": names}));
            let properties = values.map(|(name, shape)| (*name, schema(shape))).chain([choice]);
            let mut object = object(properties);
            object["required"] = json!(["choice"]);
            object
        }
        Shape::Demand => {
            let numbers = || json!({"type": "array", "items": {"type": "number"}});
            let mut object = object([
                ("form", json!({"type": "string"})),
                ("joints", numbers()),
                ("pose", schema(Shape::POSE)),
                ("displacement", schema(Shape::POSE)),
                ("tool", schema(Shape::POSE)),
                ("redundancy", json!({"type": "number"})),
                ("regulators", json!({"type": "array", "items": {"type": "integer"}})),
            ]);
            object["required"] = json!(["form"]);
            object
        }
        Shape::Words(_) => json!({"type": "array", "items": {"type": "string"}}),
    }
}

/// The schema of an object with these properties, all of them required.
pub fn object<'a>(properties: impl IntoIterator<Item = (&'a str, Value)>) -> Value {
    let properties: Map<_, _> =
        properties.into_iter().map(|(name, schema)| (name.to_owned(), schema)).collect();
    let required: Vec<_> = properties.keys().cloned().collect();
    json!({"type": "object", "properties": properties, "required": required})
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::generator::Demand;
    use mrroc_core::payload::WORDS;
    use proptest::prelude::*;

    const MIXED: &Shape = &Shape::Fields(&[
        ("x", &Shape::Float),
        ("count", &Shape::Unsigned),
        ("offset", &Shape::Signed),
        ("touches", &Shape::Truth),
        ("phase", &Shape::Choice(&["Out", "Back"])),
        (
            "part",
            &Shape::Variants(&[("Rest", &Shape::Fields(&[])), ("Pick", &Shape::Array(&Shape::Unsigned, 2))]),
        ),
        ("single", &Shape::Single),
        ("force", &Shape::Array(&Shape::Float, 3)),
        ("pose", Shape::POSE),
        ("rest", &Shape::Words(2)),
    ]);

    proptest! {
        #[test]
        fn words_come_back_to_the_bit(
            bits in proptest::array::uniform11(any::<u64>()),
            (count, offset) in any::<(u64, i64)>(),
            (touches, phase, single) in (0..2_u64, 0..2_u64, any::<f32>()),
            (part, bin) in proptest::option::of(any::<(u64, u64)>()).prop_map(|of| (of.is_some(), of.unwrap_or_default())),
            rest in any::<[u64; 2]>(),
        ) {
            let mut floats = bits.iter().map(|&bits| {
                // JSON text has a single NaN, so that the bits of a NaN are not kept.
                let x = f64::from_bits(bits);
                if x.is_nan() { f64::NAN.to_bits() } else { bits }
            });
            let mut given = vec![floats.next().unwrap_or(0), count, offset.cast_unsigned(), touches, phase];
            given.extend([u64::from(part), bin.0, bin.1]);
            given.push(u64::from(if single.is_nan() { f32::NAN } else { single }.to_bits()));
            given.extend(floats);
            given.extend(rest);
            prop_assert_eq!(given.len(), MIXED.len());
            let mut text = String::new();
            value(&mut text, MIXED, &given);
            let parsed = serde_json::from_str(&text).expect("JSON");
            let mut found = Vec::new();
            prop_assert!(words(MIXED, &parsed, &mut found).is_some(), "{}", text);
            prop_assert_eq!(found, given);
        }
    }

    #[test]
    fn a_demand_shows_what_it_demands_and_nothing_that_was_left_in_the_message() {
        use mrroc_robots::Gripper;
        let mut words = [7; WORDS];
        Demand::<Gripper>::pose(Pose::translation(1.0, 2.0, 3.0)).put(&mut words);
        let mut text = String::new();
        value(&mut text, &Shape::Demand, &words);
        let expected = json!({"form": "pose", "pose": {
            "position": {"x": 1.0, "y": 2.0, "z": 3.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        }});
        assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), expected);
    }

    #[test]
    fn numbers_that_are_not_finite_are_texts() {
        let mut text = String::new();
        numbers(
            &mut text,
            &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 0.1, 5e-324].map(f64::to_bits),
        );
        assert_eq!(text, "[\"NaN\",\"Infinity\",\"-Infinity\",-0.0,0.1,5e-324]");
    }
}
