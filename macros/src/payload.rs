//! `#[derive(Payload)]`: an enum of unit variants or a struct of plain values becomes words on the wire.

use proc_macro2::{Ident, TokenStream};
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Fields, Index, Member, Path, Type};

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
            for variant in &data.variants {
                if !matches!(variant.fields, Fields::Unit) {
                    errors.at(
                        &variant.fields,
                        "an order of loose cooperation is a choice without data: write the variant alone; numbers for every step go into a `struct` of their own",
                    );
                }
            }
            enum_body(&krate, &input.ident, data.variants.iter().map(|variant| &variant.ident))
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
    let (generics, arguments, where_clause) = input.generics.split_for_impl();
    let text = name.to_string();
    let is_valid = errors.is_empty();
    let errors = errors.into_tokens();
    let body = if is_valid {
        body
    } else {
        // The mistake above is the only one: whoever uses the type finds it implemented.
        quote! {
            const LEN: usize = 0;
            const LAYOUT: u64 = 0;
            fn put(&self, _: &mut [u64]) {
                ::core::unreachable!()
            }
            fn get(_: &[u64]) -> ::core::result::Result<Self, #krate::BadWords> {
                ::core::unreachable!()
            }
        }
    };
    let fits = (is_valid && tight).then(|| {
        let message =
            format!("a message holds at most 56 words, `{text}` takes more: send less, or send it in parts");
        quote_spanned! {name.span()=>
            const _: () = ::core::assert!(<#name as #krate::Wire>::LEN <= #krate::WORDS, #message);
        }
    });
    quote! {
        #errors
        const _: () = {
            #[automatically_derived]
            impl #generics #krate::Wire for #name #arguments #where_clause {
                #body
            }
            #[automatically_derived]
            impl #generics #krate::Payload for #name #arguments #where_clause {
                const NAME: &'static str = #text;
                const TIGHT: bool = #tight;
            }
            #fits
        };
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

/// A choice: one word, the variant's index.
fn enum_body<'a>(
    krate: &TokenStream,
    name: &Ident,
    variants: impl Iterator<Item = &'a Ident>,
) -> TokenStream {
    let variants: Vec<_> = variants.collect();
    let names: Vec<_> = variants.iter().map(|variant| variant.to_string()).collect();
    let words: Vec<_> = (0..variants.len() as u64).collect();
    let text = name.to_string();
    quote! {
        const LEN: usize = 1;
        const LAYOUT: u64 = {
            let hash = #krate::__private1::layout_hash(0, #text);
            #(let hash = #krate::__private1::layout_hash(hash, #names);)*
            hash
        };
        fn put(&self, words: &mut [u64]) {
            words[0] = match self {
                #(Self::#variants => #words,)*
            };
        }
        fn get(words: &[u64]) -> ::core::result::Result<Self, #krate::BadWords> {
            match words.first() {
                #(::core::option::Option::Some(#words) => ::core::result::Result::Ok(Self::#variants),)*
                _ => ::core::result::Result::Err(#krate::BadWords),
            }
        }
    }
}

/// Plain values: the words of the fields one after another.
fn struct_body(krate: &TokenStream, name: &Ident, fields: &Fields) -> TokenStream {
    let types: Vec<&Type> = fields.iter().map(|field| &field.ty).collect();
    let members: Vec<Member> = fields
        .iter()
        .enumerate()
        .map(|(i, field)| match &field.ident {
            Some(ident) => Member::Named(ident.clone()),
            None => Member::Unnamed(Index::from(i)),
        })
        .collect();
    let names = members.iter().map(|member| match member {
        Member::Named(ident) => ident.to_string(),
        Member::Unnamed(index) => index.index.to_string(),
    });
    // The same expression wherever a field is used, so that the compiler reports a type that is not plain once.
    let plain: Vec<_> =
        types.iter().map(|ty| quote_spanned!(ty.span()=> #krate::__private1::field::<#ty>())).collect();
    let text = name.to_string();
    let (words, words_mut) =
        if types.is_empty() { (quote!(_), quote!(_)) } else { (quote!(words), quote!(words)) };
    quote! {
        const LEN: usize = 0 #(+ #plain.len)*;
        const LAYOUT: u64 = {
            let hash = #krate::__private1::layout_hash(1, #text);
            #(let hash = #krate::__private1::layout_hash(hash ^ #plain.layout, #names);)*
            hash
        };
        fn put(&self, #words_mut: &mut [u64]) {
            #(let words = #plain.put(&self.#members, words);)*
        }
        fn get(#words: &[u64]) -> ::core::result::Result<Self, #krate::BadWords> {
            let mut words = words;
            ::core::result::Result::Ok(Self {
                #(#members: #plain.get(&mut words)?,)*
            })
        }
    }
}
