//! Reads the parentheses of an attribute.
//!
//! In: their tokens, such as `(mp, first = grasp)`. Out: the arguments, and mistakes.

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::quote;
use syn::parse::{Parse, ParseStream, Parser};
use syn::punctuated::Punctuated;
use syn::{ExprPath, Path, Token, Type, ext::IdentExt};

use crate::class::Level;
use crate::errors::Errors;

/// The two attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Generator,
    Condition,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Generator => "generator",
            Kind::Condition => "condition",
        }
    }

    fn keys(self) -> &'static str {
        match self {
            Kind::Generator => {
                "`first = function`, `until = function`, `sensors = (WristForce,)`, `order = Phase`, `crate = path`"
            }
            Kind::Condition => "`crate = path`",
        }
    }
}

/// The arguments of an attribute.
pub struct Arguments {
    /// The level; absent only after a mistake.
    pub level: Option<Level>,
    pub first: Option<ExprPath>,
    pub until: Option<ExprPath>,
    pub sensors: Option<Type>,
    pub order: Option<Type>,
    krate: Option<Path>,
}

impl Arguments {
    /// The path of the runtime crate.
    pub fn krate(&self) -> TokenStream {
        self.krate.as_ref().map_or_else(|| quote!(::mrroc), |path| quote!(#path))
    }

    /// Reads the arguments of an attribute.
    pub fn parse(kind: Kind, tokens: TokenStream, errors: &mut Errors) -> Arguments {
        let mut arguments =
            Arguments { level: None, first: None, until: None, sensors: None, order: None, krate: None };
        let list = match Punctuated::<Argument, Token![,]>::parse_terminated.parse2(tokens.clone()) {
            Ok(list) => list,
            Err(error) => {
                arguments.level = level_at_the_front(tokens);
                let text = error.to_string();
                let form = format!("#[{}(ecp, key = value)]", kind.name());
                errors.add(match text.as_str() {
                    "expected `,`" => {
                        syn::Error::new(error.span(), format_args!("a comma separates arguments: `{form}`"))
                    }
                    _ => error,
                });
                return arguments;
            }
        };
        let mut seen: Vec<Ident> = Vec::new();
        for argument in list {
            let Argument { key, value } = argument;
            let name = key.to_string();
            if seen.contains(&key) {
                errors.at(&key, format_args!("`{name}` is said twice: leave one of them out"));
                continue;
            }
            seen.push(key.clone());
            if name == "mp" || name == "ecp" {
                if arguments.level.is_some() {
                    errors
                        .at(&key, format_args!("either `mp` or `ecp`: a {} works at one level", kind.name()));
                }
                arguments.level.get_or_insert(if name == "mp" { Level::Mp } else { Level::Ecp });
                continue;
            }
            match (name.as_str(), value, kind) {
                ("crate", Value::Path(path), _) => arguments.krate = Some(path.path),
                ("first", Value::Path(path), Kind::Generator) => arguments.first = Some(path),
                ("until", Value::Path(path), Kind::Generator) => arguments.until = Some(path),
                ("sensors", Value::Type(list), Kind::Generator) => arguments.sensors = Some(list),
                ("order", Value::Type(payload), Kind::Generator) => arguments.order = Some(payload),
                _ => errors.at(
                    &key,
                    format_args!(
                        "`{name}` is no argument of `#[{}(..)]`: write `mp` or `ecp` first, and then, where needed, {}",
                        kind.name(),
                        kind.keys()
                    ),
                ),
            }
        }
        // After another mistake the level may be present but misspelt.
        if arguments.level.is_none() && errors.is_empty() {
            errors.add(syn::Error::new(
                Span::call_site(),
                format_args!("name the level: `#[{0}(mp)]` or `#[{0}(ecp)]`", kind.name()),
            ));
        }
        arguments
    }
}

/// The level with which a list of arguments begins, whatever follows it.
fn level_at_the_front(tokens: TokenStream) -> Option<Level> {
    match tokens.into_iter().next() {
        Some(TokenTree::Ident(key)) if key == "mp" => Some(Level::Mp),
        Some(TokenTree::Ident(key)) if key == "ecp" => Some(Level::Ecp),
        Some(_) | None => None,
    }
}

/// One argument: `mp`, `first = grasp`, `sensors = (WristForce,)`.
struct Argument {
    key: Ident,
    value: Value,
}

#[allow(
    clippy::large_enum_variant,
    reason = "one at a time, while a macro expands; how large syn is depends on features"
)]
enum Value {
    None,
    Path(ExprPath),
    Type(Type),
}

impl Parse for Argument {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let key = input.call(Ident::parse_any)?;
        let value = if input.parse::<Option<Token![=]>>()?.is_none() {
            Value::None
        } else if key == "sensors" || key == "order" {
            Value::Type(input.parse()?)
        } else {
            Value::Path(input.parse()?)
        };
        Ok(Argument { key, value })
    }
}
