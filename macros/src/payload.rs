//! `#[derive(Payload)]`: an enum, with or without data, or a struct of plain values becomes words on the wire.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Data, DataEnum, DeriveInput, Fields, Index, Member, Path, Type};

use crate::emit::{placed, where_clause};
use crate::errors::Errors;

/// Expands the derive.
pub fn expand(item: TokenStream) -> TokenStream {
    let input: DeriveInput = match syn::parse2(item) {
        Ok(input) => input,
        Err(error) => return error.into_compile_error(),
    };
    let mut errors = Errors::default();
    let krate = krate(&input, &mut errors);
    if let Some(parameter) = input.generics.params.first() {
        errors.at(parameter, "a payload has one size and one identity: name its types, without parameters");
    }
    let body = match &input.data {
        Data::Enum(data) => {
            if data.variants.is_empty() {
                errors.at(&input.ident, "an order needs something to say: name at least one variant");
            }
            if carries_data(data) {
                variants_body(&krate, &input.ident, data)
            } else {
                choice_body(&krate, &input.ident, data)
            }
        }
        Data::Struct(data) => struct_body(&krate, &input.ident, &data.fields),
        Data::Union(data) => {
            errors.at(
                data.union_token,
                "the runtime could not check what a union holds: write a `struct` or an `enum`",
            );
            TokenStream::new()
        }
    };
    let tight = matches!(input.data, Data::Struct(_));
    let name = &input.ident;
    let is_valid = errors.is_empty();
    let (parameters, arguments, _) = input.generics.split_for_impl();
    let plain = (!is_valid).then(|| quote!(Self: ::core::marker::Copy + 'static));
    let bounds = where_clause(&input.generics, plain.clone());
    // What `Wire` lacks is reported with `Wire`; `Payload` assumes it (the lifetime makes that possible).
    let with_wire = quote!(for<'seen_above> Self: #krate::payload::Wire);
    let bounds_with_wire = where_clause(&input.generics, plain.into_iter().chain([with_wire]));
    let text = name.to_string();
    let fields = match &input.data {
        Data::Struct(data) if is_valid && !data.fields.is_empty() => Some(fields(&krate, &data.fields)),
        Data::Enum(data) if is_valid && carries_data(data) => Some(fields_of_variants(&krate, data)),
        _ => None,
    };
    let fits = fields.is_some().then(|| {
        let fits = quote!(const _: () = #krate::__private1::fits_a_message(__LEN););
        placed(fits, name.span())
    });
    let body = if is_valid {
        body
    } else {
        // The traits are implemented even after a mistake, so that uses of the type report no further errors.
        quote! {
            const LEN: usize = 0;
            const LAYOUT: u64 = 0;
            fn put(&self, _: &mut [u64]) {
                ::core::unreachable!()
            }
            fn get(_: &[u64]) -> ::core::result::Result<Self, #krate::payload::BadWords> {
                ::core::unreachable!()
            }
        }
    };
    let errors = errors.into_tokens();
    quote! {
        #errors
        const _: () = {
            #fields
            #[automatically_derived]
            impl #parameters #krate::payload::Wire for #name #arguments #bounds {
                #body
            }
            #[automatically_derived]
            impl #parameters #krate::payload::Payload for #name #arguments #bounds_with_wire {
                const NAME: &'static str = #text;
                const TIGHT: bool = #tight;
            }
            #fits
        };
    }
}

fn carries_data(data: &DataEnum) -> bool {
    data.variants.iter().any(|variant| !matches!(variant.fields, Fields::Unit))
}

/// The properties of the fields' types and the words of a value.
fn fields(krate: &TokenStream, fields: &Fields) -> TokenStream {
    let constant = fields_constant(krate, &format_ident!("__FIELDS"), fields);
    let field = (0..fields.len()).map(Index::from);
    quote! {
        #constant
        const __LEN: usize = #(__FIELDS.#field.len)+*;
    }
}

/// The properties of some fields' types in one constant, so that a type that is no plain value is reported once.
fn fields_constant(krate: &TokenStream, name: &Ident, fields: &Fields) -> TokenStream {
    let types: Vec<&Type> = fields.iter().map(|field| &field.ty).collect();
    let of_types = types.iter().map(|ty| quote_spanned!(ty.span()=> #krate::__private1::field::<#ty>()));
    quote!(const #name: (#(#krate::__private1::Field<#types>,)*) = (#(#of_types,)*);)
}

/// The constant with the fields of the variant at place `i`.
fn fields_name(i: usize) -> Ident {
    format_ident!("__FIELDS_{i}")
}

/// The same for each variant of an enum: a value takes the words of the longest one, and one for the choice.
fn fields_of_variants(krate: &TokenStream, data: &DataEnum) -> TokenStream {
    let constants = data
        .variants
        .iter()
        .enumerate()
        .filter(|(_, variant)| !variant.fields.is_empty())
        .map(|(i, variant)| fields_constant(krate, &fields_name(i), &variant.fields));
    let lengths = data.variants.iter().enumerate().map(|(i, variant)| {
        let name = fields_name(i);
        let field = (0..variant.fields.len()).map(Index::from);
        quote!(0 #(+ #name.#field.len)*)
    });
    quote! {
        #(#constants)*
        const __LEN: usize = 1 + #krate::__private1::longest(&[#(#lengths),*]);
    }
}

/// The path of the runtime crate, `#[payload(crate = path)]`.
fn krate(input: &DeriveInput, errors: &mut Errors) -> TokenStream {
    let mut krate = quote!(::mrroc);
    for attribute in input.attrs.iter().filter(|attribute| attribute.path().is_ident("payload")) {
        let parsed = attribute.parse_nested_meta(|meta| {
            if meta.path.is_ident("crate") {
                let path: Path = meta.value()?.parse()?;
                krate = quote!(#path);
                Ok(())
            } else {
                Err(meta.error("the one argument is the path of the runtime: `#[payload(crate = path)]`"))
            }
        });
        if let Err(error) = parsed {
            errors.add(error);
        }
    }
    krate
}

/// A choice with data: one word, the variant's index, and the words of the variant's fields; zeros to the longest.
fn variants_body(krate: &TokenStream, name: &Ident, data: &DataEnum) -> TokenStream {
    let text = name.to_string();
    let mut hashes = TokenStream::new();
    let mut shapes = Vec::new();
    let mut puts = TokenStream::new();
    let mut gets = TokenStream::new();
    for (i, variant) in data.variants.iter().enumerate() {
        let (ident, constant, tag) = (&variant.ident, fields_name(i), i as u64);
        let variant_text = ident.to_string();
        let members = members(&variant.fields);
        let names: Vec<_> = members.iter().map(text_of).collect();
        let field: Vec<_> = (0..members.len()).map(Index::from).collect();
        let values: Vec<_> = (0..members.len()).map(|i| format_ident!("__value_{i}")).collect();
        hashes.extend(quote! {
            let hash = #krate::__private1::layout_hash(hash, #variant_text);
            #(let hash = #krate::__private1::layout_hash(hash ^ #constant.#field.layout, #names);)*
        });
        shapes.push(quote! {
            (#variant_text, &#krate::__private1::Shape::Fields(&[#((#names, #constant.#field.shape)),*]))
        });
        puts.extend(quote! {
            Self::#ident { #(#members: #values),* } => {
                *choice = #tag;
                #(let words = #constant.#field.put(#values, words);)*
                words.fill(0);
            }
        });
        gets.extend(quote! {
            #tag => ::core::result::Result::Ok(Self::#ident {
                #(#members: #constant.#field.get(&mut words)?,)*
            }),
        });
    }
    quote! {
        const LEN: usize = __LEN;
        const LAYOUT: u64 = {
            let hash = #krate::__private1::layout_hash(0, #text);
            #hashes
            hash
        };
        const SHAPE: &'static #krate::__private1::Shape =
            &#krate::__private1::Shape::Variants(&[#(#shapes),*]);
        fn put(&self, words: &mut [u64]) {
            let [choice, words @ ..] = &mut words[..__LEN] else { ::core::unreachable!() };
            match self {
                #puts
            }
        }
        fn get(words: &[u64]) -> ::core::result::Result<Self, #krate::payload::BadWords> {
            let ::core::option::Option::Some([choice, words @ ..]) = words.get(..__LEN) else {
                return ::core::result::Result::Err(#krate::payload::BadWords);
            };
            let mut words = words;
            match *choice {
                #gets
                _ => ::core::result::Result::Err(#krate::payload::BadWords),
            }
        }
    }
}

/// The names or places of fields.
fn members(fields: &Fields) -> Vec<Member> {
    let member = |(i, field): (usize, &syn::Field)| match &field.ident {
        Some(ident) => Member::Named(ident.clone()),
        None => Member::Unnamed(Index::from(i)),
    };
    fields.iter().enumerate().map(member).collect()
}

fn text_of(member: &Member) -> String {
    match member {
        Member::Named(ident) => ident.to_string(),
        Member::Unnamed(index) => index.index.to_string(),
    }
}

/// A choice: one word, the variant's index.
fn choice_body(krate: &TokenStream, name: &Ident, data: &DataEnum) -> TokenStream {
    let variants: Vec<_> = data.variants.iter().map(|variant| &variant.ident).collect();
    let names: Vec<_> = variants.iter().map(ToString::to_string).collect();
    let words: Vec<_> = (0..variants.len() as u64).collect();
    let text = name.to_string();
    quote! {
        const LEN: usize = 1;
        const LAYOUT: u64 = {
            let hash = #krate::__private1::layout_hash(0, #text);
            #(let hash = #krate::__private1::layout_hash(hash, #names);)*
            hash
        };
        const SHAPE: &'static #krate::__private1::Shape = &#krate::__private1::Shape::Choice(&[#(#names),*]);
        fn put(&self, words: &mut [u64]) {
            words[0] = match self {
                #(Self::#variants => #words,)*
            };
        }
        fn get(words: &[u64]) -> ::core::result::Result<Self, #krate::payload::BadWords> {
            match words.first() {
                #(::core::option::Option::Some(#words) => ::core::result::Result::Ok(Self::#variants),)*
                _ => ::core::result::Result::Err(#krate::payload::BadWords),
            }
        }
    }
}

/// Plain values: the words of the fields one after another.
fn struct_body(krate: &TokenStream, name: &Ident, fields: &Fields) -> TokenStream {
    let types: Vec<&Type> = fields.iter().map(|field| &field.ty).collect();
    let members = members(fields);
    let names: Vec<_> = members.iter().map(text_of).collect();
    let text = name.to_string();
    if types.is_empty() {
        return quote! {
            const LEN: usize = 0;
            const LAYOUT: u64 = #krate::__private1::layout_hash(1, #text);
            const SHAPE: &'static #krate::__private1::Shape = &#krate::__private1::Shape::Fields(&[]);
            fn put(&self, _: &mut [u64]) {}
            fn get(_: &[u64]) -> ::core::result::Result<Self, #krate::payload::BadWords> {
                ::core::result::Result::Ok(Self {})
            }
        };
    }
    let field: Vec<_> = (0..types.len()).map(Index::from).collect();
    quote! {
        const LEN: usize = __LEN;
        const LAYOUT: u64 = {
            let hash = #krate::__private1::layout_hash(1, #text);
            #(let hash = #krate::__private1::layout_hash(hash ^ __FIELDS.#field.layout, #names);)*
            hash
        };
        const SHAPE: &'static #krate::__private1::Shape =
            &#krate::__private1::Shape::Fields(&[#((#names, __FIELDS.#field.shape)),*]);
        fn put(&self, words: &mut [u64]) {
            #(let words = __FIELDS.#field.put(&self.#members, words);)*
            let _ = words;
        }
        fn get(words: &[u64]) -> ::core::result::Result<Self, #krate::payload::BadWords> {
            let mut words = words;
            ::core::result::Result::Ok(Self {
                #(#members: __FIELDS.#field.get(&mut words)?,)*
            })
        }
    }
}
