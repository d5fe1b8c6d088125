//! Generic parameters of a step function: those of its state's type carry over to the implementation.

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{GenericParam, Generics, Signature, Type};

use crate::errors::Errors;

/// The parameters of the implementation for the state of a function.
pub fn of_state(signature: &Signature, state: Option<&Type>, errors: &mut Errors) -> Generics {
    let mut generics = signature.generics.clone();
    let tokens = state.map(ToTokens::to_token_stream).unwrap_or_default();
    for parameter in &signature.generics.params {
        let ident = match parameter {
            GenericParam::Type(parameter) => &parameter.ident,
            GenericParam::Const(parameter) => &parameter.ident,
            GenericParam::Lifetime(_) => continue,
        };
        if !mentions(tokens.clone(), ident) {
            errors.at(
                ident,
                match state {
                    Some(state) => format!(
                        "`{ident}` is not in the state's type, so a call could not say which it is: hold a `PhantomData<{ident}>` in `{}`",
                        crate::signature::text(state)
                    ),
                    None => format!(
                        "without a state a call could not say which `{ident}`: give the function one that names it, `c: &mut Hold<{ident}>`"
                    ),
                },
            );
        }
    }
    // A lifetime that only the reference to the state has does not reach the implementation.
    generics.params = generics
        .params
        .into_iter()
        .filter(|parameter| match parameter {
            GenericParam::Lifetime(lifetime) => mentions(tokens.clone(), &lifetime.lifetime.ident),
            GenericParam::Type(parameter) => mentions(tokens.clone(), &parameter.ident),
            GenericParam::Const(parameter) => mentions(tokens.clone(), &parameter.ident),
        })
        .collect();
    if generics.params.is_empty() {
        generics.where_clause = None;
    }
    generics
}

/// Whether the tokens name `ident`.
fn mentions(tokens: TokenStream, ident: &Ident) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(token) => token == *ident,
        TokenTree::Group(group) => mentions(group.stream(), ident),
        TokenTree::Punct(_) | TokenTree::Literal(_) => false,
    })
}
