//! Whatever stands in the source: the macros never panic, and the user's item survives every mistake.

use proc_macro2::{Delimiter, Group, Ident, Punct, Spacing, Span, TokenStream, TokenTree};
use proptest::prelude::*;
use quote::quote;

use crate::{condition, generator, payload};

/// Words that step functions are made of, so that random items come close to real ones.
const WORDS: [&str; 40] = [
    "fn",
    "impl",
    "pub",
    "struct",
    "enum",
    "async",
    "unsafe",
    "extern",
    "const",
    "self",
    "Self",
    "mut",
    "where",
    "for",
    "crate",
    "mp",
    "ecp",
    "first",
    "until",
    "sensors",
    "order",
    "Step",
    "Always",
    "State",
    "Reading",
    "Order",
    "Tick",
    "Result",
    "Fault",
    "bool",
    "next_step",
    "first_step",
    "is_met",
    "carry",
    "Carry",
    "R",
    "Rnt",
    "f64",
    "union",
    "_",
];

fn token() -> impl Strategy<Value = TokenTree> {
    let leaf = prop_oneof![
        6 => prop::sample::select(&WORDS[..]).prop_map(|word| TokenTree::Ident(Ident::new(word, Span::call_site()))),
        4 => prop::sample::select(&['<', '>', '&', ',', ':', ';', '=', '-', '#', '!', '\'', '.', '|'][..])
            .prop_filter("a lone quote is no token", |c| *c != '\'')
            .prop_flat_map(|c| prop_oneof![Just((c, Spacing::Joint)), Just((c, Spacing::Alone))])
            .prop_map(|(c, spacing)| TokenTree::Punct(Punct::new(c, spacing))),
        1 => (0u8..9).prop_map(|n| TokenTree::Literal(proc_macro2::Literal::u8_unsuffixed(n))),
    ];
    leaf.prop_recursive(3, 24, 6, |inner| {
        let delimiter = prop::sample::select(
            &[Delimiter::Parenthesis, Delimiter::Brace, Delimiter::Bracket, Delimiter::None][..],
        );
        (delimiter, prop::collection::vec(inner, 0..6)).prop_map(|(delimiter, tokens)| {
            TokenTree::Group(Group::new(delimiter, tokens.into_iter().collect()))
        })
    })
}

fn tokens() -> impl Strategy<Value = TokenStream> {
    prop::collection::vec(token(), 0..16).prop_map(|tokens| tokens.into_iter().collect())
}

/// A step function one of whose parts is replaced by random tokens.
fn damaged() -> impl Strategy<Value = TokenStream> {
    (tokens(), 0usize..7).prop_map(|(noise, place)| {
        let part = |i: usize, whole: TokenStream| if i == place { noise.clone() } else { whole };
        let qualifiers = part(0, quote!(pub));
        let generics = part(1, quote!(<R: Robot>));
        let state = part(2, quote!(&mut Line<R>));
        let seen = part(3, quote!(&State<R>));
        let outcome = part(4, quote!(Result<Step<R>, Fault>));
        let bounds = part(5, quote!(where R: Clone));
        let body = part(6, quote!(todo!()));
        quote!(#qualifiers fn carry #generics(c: #state, e: #seen) -> #outcome #bounds { #body })
    })
}

fn any_item() -> impl Strategy<Value = TokenStream> {
    prop_oneof![
        1 => tokens(),
        2 => damaged(),
        1 => damaged().prop_map(|method| quote!(impl<R: Robot> Line<R> { #method })),
    ]
}

fn any_attribute() -> impl Strategy<Value = TokenStream> {
    prop_oneof![Just(quote!(mp)), Just(quote!(ecp)), tokens()]
}

/// After a mistake the item stands at the front, token for token.
fn survives(item: &TokenStream, expansion: &TokenStream) -> bool {
    let (item, expansion) = (item.to_string(), expansion.to_string());
    !expansion.contains("compile_error") || expansion.starts_with(&item)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn attributes_never_panic_and_keep_the_item(attribute in any_attribute(), item in any_item()) {
        for expand in [generator::expand, condition::expand] {
            let expansion = expand(attribute.clone(), item.clone());
            prop_assert!(survives(&item, &expansion), "{item}\n=> {expansion}");
        }
    }

    #[test]
    fn the_derive_never_panics(name in prop::sample::select(&["struct", "enum", "union"][..]), parts in tokens()) {
        let keyword = Ident::new(name, Span::call_site());
        let _ = payload::expand(quote!(#keyword Plan { #parts }));
        let _ = payload::expand(quote!(#keyword Plan #parts));
        let _ = payload::expand(parts);
    }
}
