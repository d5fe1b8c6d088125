//! The implementation that is printed after a mistake.

use proc_macro2::TokenStream;
use quote::quote;
use syn::Type;

use crate::attribute::Kind;
use crate::emit::Target;

/// An implementation that accepts any lists and computes nothing, so that the mistake is the only one reported.
pub fn implementation(target: &Target<'_>, kind: Kind, robot: Option<&Type>) -> TokenStream {
    let krate = &target.krate;
    let level = target.level();
    let anything = quote!(#krate::__private1::Anything);
    let robots = match (kind, robot) {
        (Kind::Condition, _) => quote!(#krate::generator::AnyRobots),
        (Kind::Generator, Some(robot)) => quote!(#robot),
        (Kind::Generator, None) => anything.clone(),
    };
    let arguments = target.arguments(|_| false);
    let types = quote! {
        type Robots = #robots;
        type Sensors = #anything;
        type Order = ();
        const CLASS: #krate::generator::Class = #krate::generator::Class::new(#level, #krate::generator::Uses::NOTHING);
    };
    let body = quote!({ ::core::unreachable!() });
    if kind == Kind::Condition {
        let items = quote! {
            #types
            fn is_met(#arguments) -> ::core::result::Result<bool, #krate::fault::Fault> #body
        };
        return target.implement("Condition", &[], &items);
    }
    let step = quote!(::core::result::Result<#krate::generator::Step<Self::Robots, Self::Language>, #krate::fault::Fault>);
    let language = match robot {
        Some(_) => quote!(#krate::generator::Motion),
        None => quote!(#krate::__private1::AnyLanguage),
    };
    let items = quote! {
        #types
        type Language = #language;
        fn first_step(#arguments) -> #step #body
        fn next_step(#arguments) -> #step #body
    };
    target.implement("Generator", &[], &items)
}
