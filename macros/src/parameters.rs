//! Generic parameters of a step function.
//!
//! In: the parameters, and the type of the state. Out: the parameters that the state's type uses, for the
//! implementation.

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::{GenericParam, Generics, Signature, Type, WherePredicate};

use crate::errors::Errors;

/// The parameters of the implementation for the state of a function.
pub fn of_state(signature: &Signature, state: Option<&Type>, errors: &mut Errors) -> Generics {
    let mut generics = signature.generics.clone();
    let tokens = state.map(ToTokens::to_token_stream).unwrap_or_default();
    for parameter in &signature.generics.params {
        let ident = ident(parameter);
        let is_lifetime = matches!(parameter, GenericParam::Lifetime(_));
        if !is_lifetime && !mentions(tokens.clone(), ident) {
            errors.at(
                ident,
                match state {
                    Some(state) => format!(
                        "`{ident}` is not in the state's type, so a call could not say which it is: hold a `PhantomData<{ident}>` in `{}`",
                        crate::types::text(state)
                    ),
                    None => format!(
                        "without a state a call could not say which `{ident}`: give the function one that names it, `c: &mut Hold<{ident}>`"
                    ),
                },
            );
        }
    }
    // The implementation gets neither a lifetime that only the reference to the state has, nor a parameter that was a
    // mistake.
    let (kept, left): (Vec<_>, Vec<_>) =
        generics.params.into_iter().partition(|parameter| mentions(tokens.clone(), ident(parameter)));
    generics.params = kept.into_iter().collect();
    if let Some(bounds) = &mut generics.where_clause {
        let predicates = core::mem::take(&mut bounds.predicates);
        let names_left =
            |bound: &WherePredicate| left.iter().any(|left| mentions(bound.to_token_stream(), ident(left)));
        bounds.predicates = predicates.into_iter().filter(|bound| !names_left(bound)).collect();
    }
    generics
}

fn ident(parameter: &GenericParam) -> &Ident {
    match parameter {
        GenericParam::Type(parameter) => &parameter.ident,
        GenericParam::Const(parameter) => &parameter.ident,
        GenericParam::Lifetime(parameter) => &parameter.lifetime.ident,
    }
}

/// Whether the tokens name `ident`.
fn mentions(tokens: TokenStream, ident: &Ident) -> bool {
    tokens.into_iter().any(|token| match token {
        TokenTree::Ident(token) => token == *ident,
        TokenTree::Group(group) => mentions(group.stream(), ident),
        TokenTree::Punct(_) | TokenTree::Literal(_) => false,
    })
}
