//! Reads the tokens of a type: its name, its arguments, and its text in a message.

use proc_macro2::Span;
use quote::ToTokens;
use syn::spanned::Spanned;
use syn::{GenericArgument, PathArguments, PathSegment, Type};

use crate::class::Role;

/// The type without the invisible groups that `macro_rules!` puts around it.
pub fn plain(mut ty: &Type) -> &Type {
    while let Type::Group(group) = ty {
        ty = &group.elem;
    }
    ty
}

/// The last segment of a path: `Step<Rnt>` of `mrroc::generator::Step<Rnt>`.
pub fn last_segment(ty: &Type) -> Option<&PathSegment> {
    match ty {
        Type::Path(path) if path.qself.is_none() => path.path.segments.last(),
        _ => None,
    }
}

pub fn last_span(ty: &Type) -> Span {
    last_segment(ty).map_or_else(|| ty.span(), |segment| segment.ident.span())
}

/// The role of a type by its name; `None` for a state, whose type may have any name.
pub fn image(ty: &Type) -> Option<(Role, &PathSegment)> {
    let segment = last_segment(ty)?;
    let role = match segment.ident.to_string().as_str() {
        "Order" => Role::Order,
        "State" => Role::Robots,
        "Reading" => Role::Sensors,
        "Tick" => Role::Tick,
        _ => return None,
    };
    Some((role, segment))
}

/// The type arguments of a path's last segment.
pub fn arguments(ty: &Type) -> Vec<&Type> {
    let Some(PathArguments::AngleBracketed(arguments)) = last_segment(ty).map(|segment| &segment.arguments)
    else {
        return Vec::new();
    };
    let types = arguments.args.iter().filter_map(|argument| match argument {
        GenericArgument::Type(ty) => Some(ty),
        _ => None,
    });
    types.collect()
}

/// The type as written, for messages; with an example of a list if it has none.
pub fn filled(ty: &Type, role: Role) -> String {
    let example = match role {
        Role::Order => "Phase",
        Role::State | Role::Robots => "(Rnt, Polycrank)",
        Role::Sensors => "(WristForce,)",
        Role::Tick => return text(ty),
    };
    if arguments(ty).is_empty() { format!("{}<{example}>", text(ty)) } else { text(ty) }
}

/// Whether a trait can be implemented for the type in a user's crate, as far as the name shows it.
pub fn could_be_own(ty: &Type) -> bool {
    const FOREIGN: [&str; 26] = [
        "bool", "char", "str", "f32", "f64", "i8", "i16", "i32", "i64", "i128", "isize", "u8", "u16", "u32",
        "u64", "u128", "usize", "String", "Vec", "Box", "Option", "Result", "Arc", "Rc", "Duration",
        "Instant",
    ];
    last_segment(ty).is_some_and(|segment| FOREIGN.iter().all(|foreign| segment.ident != foreign))
}

/// A type as a person writes it.
pub fn text(ty: &Type) -> String {
    let mut text = ty.to_token_stream().to_string();
    for (spaced, written) in [
        (" < ", "<"),
        ("< ", "<"),
        (" <", "<"),
        (" >", ">"),
        (" ,", ","),
        (" :: ", "::"),
        (":: ", "::"),
        (" ::", "::"),
        ("& ", "&"),
        (" ;", ";"),
        ("( ", "("),
        (" )", ")"),
    ] {
        text = text.replace(spaced, written);
    }
    text
}
