//! Packages: requests of a client, answers of a controller.

use core::str;

use super::value::{Offer, Values};

/// The version that is spoken.
pub const VERSION: u16 = 2;

/// The most bytes of a package that is taken. The longest one here is a recipe, whose names have at most [`MAX_NAMES`].
pub const MAX_PACKAGE: usize = 4096;

/// The most bytes that the names of a recipe may have, by UR's guide.
pub const MAX_NAMES: usize = 2048;

const HEADER: usize = 3;

/// A package says that it is longer than [`MAX_PACKAGE`], or shorter than its header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

/// A package: its kind and its payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Package<'b> {
    kind: u8,
    payload: &'b [u8],
}

impl<'b> Package<'b> {
    /// How long the package at the front of these bytes is; `None` while that is not known.
    ///
    /// # Errors
    /// [`TooLong`].
    pub fn length(bytes: &[u8]) -> Result<Option<usize>, TooLong> {
        let Some((first, _)) = bytes.split_first_chunk() else { return Ok(None) };
        let length = usize::from(u16::from_be_bytes(*first));
        if (HEADER..=MAX_PACKAGE).contains(&length) { Ok(Some(length)) } else { Err(TooLong) }
    }

    /// The package at the front of these bytes, and what follows it; `None` while it is not all there.
    ///
    /// # Errors
    /// [`TooLong`].
    pub fn first(bytes: &'b [u8]) -> Result<Option<(Package<'b>, &'b [u8])>, TooLong> {
        let Some(length) = Package::length(bytes)? else { return Ok(None) };
        if bytes.len() < length {
            return Ok(None);
        }
        let (package, rest) = bytes.split_at(length);
        Ok(Some((Package { kind: package[2], payload: &package[HEADER..] }, rest)))
    }

    fn write(kind: u8, to: &mut Vec<u8>, payload: impl FnOnce(&mut Vec<u8>)) {
        let start = to.len();
        to.extend([0, 0, kind]);
        payload(to);
        // Longer ones are written by nobody: names are cut off at `MAX_NAMES`.
        let length = u16::try_from(to.len() - start).unwrap_or(u16::MAX);
        to[start..start + 2].copy_from_slice(&length.to_be_bytes());
    }
}

/// What a client asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request<'b> {
    /// To speak this version.
    Version(u16),
    /// Which version of its software the controller has.
    ControllerVersion,
    /// To be told fields with these names, separated by commas, so many times a second \[Hz\].
    Outputs {
        /// Finite, > 0.
        frequency: f64,
        /// At most [`MAX_NAMES`] bytes.
        names: &'b str,
    },
    /// To write fields with these names, separated by commas.
    Inputs {
        /// At most [`MAX_NAMES`] bytes.
        names: &'b str,
    },
    /// To be told the outputs from now on.
    Start,
    /// To be told nothing more.
    Pause,
    /// Inputs, in the order of a recipe.
    Data {
        /// The recipe's number.
        recipe: u8,
        /// Their bytes.
        values: &'b [u8],
    },
    /// A text for the controller's log.
    Text,
}

impl<'b> Request<'b> {
    /// Reads a package of a client; `None` if it is none of these.
    #[must_use]
    pub fn read(package: &Package<'b>) -> Option<Request<'b>> {
        let mut values = Values(package.payload);
        Some(match package.kind {
            b'V' => Request::Version(values.u16().filter(|_| values.is_over())?),
            b'v' => Request::ControllerVersion,
            b'O' => {
                let frequency = values.f64().filter(|frequency| frequency.is_finite() && *frequency > 0.0)?;
                Request::Outputs { frequency, names: names(values.0)? }
            }
            b'I' => Request::Inputs { names: names(values.0)? },
            b'S' => Request::Start,
            b'P' => Request::Pause,
            b'U' => Request::Data { recipe: values.u8()?, values: values.0 },
            b'M' => Request::Text,
            _ => return None,
        })
    }

    /// Appends its package.
    pub fn write(&self, to: &mut Vec<u8>) {
        let bounded = |names: &'b str| &names.as_bytes()[..names.len().min(MAX_NAMES)];
        match *self {
            Request::Version(version) => Package::write(b'V', to, |to| to.extend(version.to_be_bytes())),
            Request::ControllerVersion => Package::write(b'v', to, |_| ()),
            Request::Outputs { frequency, names } => Package::write(b'O', to, |to| {
                to.extend(frequency.to_be_bytes());
                to.extend(bounded(names));
            }),
            Request::Inputs { names } => Package::write(b'I', to, |to| to.extend(bounded(names))),
            Request::Start => Package::write(b'S', to, |_| ()),
            Request::Pause => Package::write(b'P', to, |_| ()),
            Request::Data { recipe, values } => Package::write(b'U', to, |to| {
                to.push(recipe);
                to.extend(values);
            }),
            Request::Text => Package::write(b'M', to, |to| to.extend([0, 0, 0])),
        }
    }
}

fn names(bytes: &[u8]) -> Option<&str> {
    str::from_utf8(bytes).ok().filter(|names| names.len() <= MAX_NAMES)
}

/// What a controller answers, or tells by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer<'b> {
    /// Whether it speaks the version that was asked for.
    Version(bool),
    /// The version of its software: major, minor, bug fix, build.
    ControllerVersion([u32; 4]),
    /// The recipe for outputs: what it has for each name.
    Outputs {
        /// Its number: 0 if a field is missing.
        recipe: u8,
        /// [`Offer`]s, separated by commas.
        offers: &'b str,
    },
    /// The same for inputs.
    Inputs {
        /// Its number: 0 if a field is missing or in use.
        recipe: u8,
        /// [`Offer`]s, separated by commas.
        offers: &'b str,
    },
    /// Whether it tells the outputs from now on.
    Started(bool),
    /// Whether it tells nothing more.
    Paused(bool),
    /// Outputs, in the order of a recipe.
    Data {
        /// The recipe's number.
        recipe: u8,
        /// Their bytes.
        values: &'b [u8],
    },
    /// A message of the controller.
    Text(&'b [u8]),
}

impl<'b> Answer<'b> {
    /// Reads a package of a controller; `None` if it is none of these.
    #[must_use]
    pub fn read(package: &Package<'b>) -> Option<Answer<'b>> {
        let mut values = Values(package.payload);
        let mut yes = || values.u8().map(|byte| byte != 0);
        Some(match package.kind {
            b'V' => Answer::Version(yes()?),
            b'v' => Answer::ControllerVersion([values.u32()?, values.u32()?, values.u32()?, values.u32()?]),
            b'O' => Answer::Outputs { recipe: values.u8()?, offers: names(values.0)? },
            b'I' => Answer::Inputs { recipe: values.u8()?, offers: names(values.0)? },
            b'S' => Answer::Started(yes()?),
            b'P' => Answer::Paused(yes()?),
            b'U' => Answer::Data { recipe: values.u8()?, values: values.0 },
            b'M' => {
                let length = usize::from(values.u8()?);
                Answer::Text(values.0.get(..length)?)
            }
            _ => return None,
        })
    }

    /// Appends its package.
    pub fn write(&self, to: &mut Vec<u8>) {
        match *self {
            Answer::Version(yes) => Package::write(b'V', to, |to| to.push(u8::from(yes))),
            Answer::ControllerVersion(version) => {
                Package::write(b'v', to, |to| to.extend(version.iter().flat_map(|part| part.to_be_bytes())));
            }
            Answer::Outputs { recipe, offers } => Package::write(b'O', to, |to| {
                to.push(recipe);
                to.extend(offers.bytes());
            }),
            Answer::Inputs { recipe, offers } => Package::write(b'I', to, |to| {
                to.push(recipe);
                to.extend(offers.bytes());
            }),
            Answer::Started(yes) => Package::write(b'S', to, |to| to.push(u8::from(yes))),
            Answer::Paused(yes) => Package::write(b'P', to, |to| to.push(u8::from(yes))),
            Answer::Data { recipe, values } => Package::write(b'U', to, |to| {
                to.push(recipe);
                to.extend(values);
            }),
            Answer::Text(text) => Package::write(b'M', to, |to| {
                let text = &text[..text.len().min(255)];
                to.push(text.len() as u8);
                to.extend(text);
                // No source, and the level of information.
                to.extend([0, 3]);
            }),
        }
    }

    /// What the controller has for each name, of a text of offers; `None` if one of them is none.
    #[must_use]
    pub fn offers(text: &str) -> Option<Vec<Offer>> {
        text.split(',').filter(|offer| !offer.is_empty()).map(|offer| offer.parse().ok()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_answers_are_read_back_from_their_packages() {
        let requests = [
            Request::Version(2),
            Request::ControllerVersion,
            Request::Outputs { frequency: 500.0, names: "timestamp,actual_q" },
            Request::Inputs { names: "speed_slider_mask" },
            Request::Start,
            Request::Pause,
            Request::Data { recipe: 3, values: &[1, 2, 3] },
            Request::Text,
        ];
        let mut bytes = Vec::new();
        requests.iter().for_each(|request| request.write(&mut bytes));
        let mut rest = &bytes[..];
        for request in requests {
            let (package, after) = Package::first(rest).expect("short").expect("all there");
            assert_eq!(Request::read(&package), Some(request));
            rest = after;
        }
        assert_eq!(Package::first(rest), Ok(None));

        let answers = [
            Answer::Version(true),
            Answer::ControllerVersion([5, 19, 0, 1_210_631]),
            Answer::Outputs { recipe: 1, offers: "DOUBLE,VECTOR6D" },
            Answer::Inputs { recipe: 0, offers: "IN_USE" },
            Answer::Started(true),
            Answer::Paused(false),
            Answer::Data { recipe: 1, values: &[9; 8] },
            Answer::Text(b"hello"),
        ];
        bytes.clear();
        answers.iter().for_each(|answer| answer.write(&mut bytes));
        rest = &bytes[..];
        for answer in answers {
            let (package, after) = Package::first(rest).expect("short").expect("all there");
            assert_eq!(Answer::read(&package), Some(answer));
            rest = after;
        }
    }

    /// The bytes of UR's guide: length with header, kind, payload.
    #[test]
    fn a_package_begins_with_its_length_and_kind() {
        let mut bytes = Vec::new();
        Request::Version(2).write(&mut bytes);
        assert_eq!(bytes, [0, 5, b'V', 0, 2]);
        // 500 Hz is 0x407f400000000000.
        bytes.clear();
        Request::Outputs { frequency: 500.0, names: "timestamp" }.write(&mut bytes);
        assert_eq!(&bytes[..11], [0, 20, b'O', 0x40, 0x7f, 0x40, 0, 0, 0, 0, 0]);
        assert_eq!(&bytes[11..], b"timestamp");
    }

    #[test]
    fn a_package_that_is_not_all_there_is_waited_for_and_one_that_is_too_long_is_refused() {
        assert_eq!(Package::first(&[0]), Ok(None));
        assert_eq!(Package::first(&[0, 5, b'V', 0]), Ok(None));
        assert_eq!(Package::first(&[0, 2, b'V']), Err(TooLong));
        assert_eq!(Package::first(&[0xff, 0xff]), Err(TooLong));
        let frequency = f64::NAN.to_be_bytes();
        assert_eq!(Request::read(&Package { kind: b'O', payload: &frequency }), None);
        assert_eq!(Answer::read(&Package { kind: b'M', payload: &[9, b'x'] }), None);
        assert_eq!(
            Answer::offers("DOUBLE,NOT_FOUND"),
            Some(vec![Offer::Has(super::super::Type::Double), Offer::NotFound])
        );
        assert_eq!(Answer::offers("DOUBLE,FLOAT"), None);
    }
}
