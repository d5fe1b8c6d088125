//! Mistakes of the user, collected so that all of them are reported at once.

use proc_macro2::TokenStream;
use quote::ToTokens;

/// The mistakes found so far.
#[derive(Default)]
pub struct Errors {
    errors: Option<syn::Error>,
    /// Whether there are mistakes that the compiler itself reports, at the same place and equally well.
    left: bool,
}

impl Errors {
    /// Adds a mistake at `tokens`; the message names the form to write.
    pub fn at(&mut self, tokens: impl ToTokens, message: impl core::fmt::Display) {
        self.add(syn::Error::new_spanned(tokens, message));
    }

    /// Adds a mistake.
    pub fn add(&mut self, error: syn::Error) {
        match &mut self.errors {
            Some(errors) => errors.combine(error),
            None => self.errors = Some(error),
        }
    }

    /// Adds all of `others`.
    pub fn append(&mut self, others: Errors) {
        if let Some(error) = others.errors {
            self.add(error);
        }
        self.left |= others.left;
    }

    /// Leaves a mistake to the compiler: it is not reported here, but counts as a mistake.
    pub fn leave_to_compiler(&mut self) {
        self.left = true;
    }

    /// Whether there are no mistakes.
    pub fn is_empty(&self) -> bool {
        self.errors.is_none() && !self.left
    }

    /// The mistakes as `compile_error!` invocations.
    pub fn into_tokens(self) -> TokenStream {
        self.errors.map(syn::Error::into_compile_error).unwrap_or_default()
    }
}
