//! Demands in a tuple where an ECP's generator has one robot.
//!
//! In: the annotated item. Out: the item without these tuples, so that the compiler does not report them once more, in words
//! that are the wrong way round ("expected `(Demand<_>,)`"); and a mistake at each of them.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

use crate::class::Level;
use crate::errors::Errors;

/// The item with `Step::Next(demand)` for `Step::Next((demand,))`, if it is an ECP's.
pub fn alone(level: Option<Level>, item: &TokenStream, errors: &mut Errors) -> TokenStream {
    if level == Some(Level::Ecp) { unwrapped(item.clone(), errors) } else { item.clone() }
}

fn unwrapped(tokens: TokenStream, errors: &mut Errors) -> TokenStream {
    let mut done: Vec<TokenTree> = Vec::new();
    for token in tokens {
        let TokenTree::Group(group) = token else {
            done.push(token);
            continue;
        };
        let inner = match only_element(&group).filter(|_| is_step_next(&done)) {
            Some((tuple, element)) => {
                errors.at(tuple, "an ECP has one robot: `Step::Next(demand)`, without a tuple");
                element
            }
            None => group.stream(),
        };
        let mut new = Group::new(group.delimiter(), unwrapped(inner, errors));
        new.set_span(group.span());
        done.push(new.into());
    }
    done.into_iter().collect()
}

/// Whether the last tokens are `Step::Next`.
fn is_step_next(tokens: &[TokenTree]) -> bool {
    let [.., step, first, second, next] = tokens else { return false };
    let is = |token: &TokenTree, name: &str| matches!(token, TokenTree::Ident(ident) if ident == name);
    let colon = |token: &TokenTree| matches!(token, TokenTree::Punct(punct) if punct.as_char() == ':');
    is(step, "Step") && colon(first) && colon(second) && is(next, "Next")
}

/// Of `((demand,))` the tuple and what is in it.
fn only_element(arguments: &Group) -> Option<(Group, TokenStream)> {
    let mut tokens = arguments.stream().into_iter();
    let (Some(TokenTree::Group(tuple)), None) = (tokens.next(), tokens.next()) else { return None };
    let parenthesised = |group: &Group| group.delimiter() == Delimiter::Parenthesis;
    if !parenthesised(arguments) || !parenthesised(&tuple) {
        return None;
    }
    let mut element: Vec<TokenTree> = tuple.stream().into_iter().collect();
    let is_comma = |token: &TokenTree| matches!(token, TokenTree::Punct(punct) if punct.as_char() == ',');
    let comma = element.pop()?;
    (is_comma(&comma) && !element.is_empty() && !element.iter().any(is_comma))
        .then(|| (tuple, element.into_iter().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quote::quote;

    /// The item of an ECP without its tuples, and whether there was a mistake.
    fn of_ecp(item: &TokenStream) -> (String, bool) {
        let mut errors = Errors::default();
        let done = alone(Some(Level::Ecp), item, &mut errors);
        (done.to_string(), !errors.is_empty())
    }

    #[test]
    fn a_tuple_of_one_demand_is_taken_out_at_any_depth() {
        let item = quote! { fn f() { if a { Step::Next((Demand::hold(),)) } else { Step::Done } } };
        let mended = quote! { fn f() { if a { Step::Next(Demand::hold()) } else { Step::Done } } };
        assert_eq!(of_ecp(&item), (mended.to_string(), true));
    }

    #[test]
    fn everything_else_stays_as_it_is() {
        for item in [
            quote! { fn f() { Step::Next(Demand::hold()) } },
            quote! { fn f() { Step::Next((demand)) } },
            quote! { fn f() { Step::Next((a, b)) } },
            quote! { fn f() { Step::Next((a, b,)) } },
            quote! { fn f() { Some((demand,)) } },
            quote! { fn f() { Step::Next(with((demand,))) } },
        ] {
            assert_eq!(of_ecp(&item), (item.to_string(), false));
        }
        let of_mp = quote! { fn f() { Step::Next((Demand::hold(),)) } };
        let mut errors = Errors::default();
        let same = alone(Some(Level::Mp), &of_mp, &mut errors).to_string();
        assert!(same == of_mp.to_string() && errors.is_empty());
    }
}
