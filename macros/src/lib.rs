//! The `#[generator]` and `#[condition]` attributes and the `Payload` derive of `mrroc`.
//!
//! Users import them from `mrroc`. In: a step function. Out: the same function, unchanged, and beside it the
//! implementation of a trait, which could also be written by hand:
//!
//! ```text
//! attribute, item ── the arguments and the signature, read ── roles and mistakes ── the implementation, printed
//! ```
//!
//! A macro sees names, not types. So the role of an argument follows from the name of its type (`&State<..>` is
//! `e`), and an argument of any other type is a mistake. Mistakes are collected and reported at once, each at the
//! token concerned and with the form to write. After a mistake the item is kept and the trait is implemented
//! without a meaning, so that the compiler reports nothing else.
//!
//! What users read about them is in `docs`: `mrroc-core` runs its examples, as they need that crate.

use proc_macro::TokenStream;

mod attribute;
mod class;
mod condition;
mod demands;
mod emit;
mod errors;
mod fallback;
mod generator;
mod item;
mod parameters;
mod payload;
mod signature;
#[cfg(test)]
mod tests;
mod types;

#[doc = include_str!("docs/generator.md")]
#[proc_macro_attribute]
pub fn generator(attribute: TokenStream, item: TokenStream) -> TokenStream {
    generator::expand(attribute.into(), item.into()).into()
}

#[doc = include_str!("docs/condition.md")]
#[proc_macro_attribute]
pub fn condition(attribute: TokenStream, item: TokenStream) -> TokenStream {
    condition::expand(attribute.into(), item.into()).into()
}

#[doc = include_str!("docs/payload.md")]
#[proc_macro_derive(Payload, attributes(payload))]
pub fn payload(item: TokenStream) -> TokenStream {
    payload::expand(item.into()).into()
}
