//! The `#[generator]` and `#[condition]` attributes and the `Payload` derive of `mrroc`.

use proc_macro::TokenStream;

mod attribute;
mod class;
mod condition;
mod emit;
mod errors;
mod generator;
mod item;
mod parameters;
mod payload;
mod signature;
#[cfg(test)]
mod tests;

/// Makes a generator of a step function.
#[proc_macro_attribute]
pub fn generator(attribute: TokenStream, item: TokenStream) -> TokenStream {
    generator::expand(attribute.into(), item.into()).into()
}

/// Makes a condition of a function that returns `bool`.
#[proc_macro_attribute]
pub fn condition(attribute: TokenStream, item: TokenStream) -> TokenStream {
    condition::expand(attribute.into(), item.into()).into()
}

/// Makes a payload of an `enum` without data or of a `struct` of plain values.
#[proc_macro_derive(Payload, attributes(payload))]
pub fn payload(item: TokenStream) -> TokenStream {
    payload::expand(item.into()).into()
}
