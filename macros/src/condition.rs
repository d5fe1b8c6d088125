//! `#[condition(mp|ecp)]`: a function that returns `bool`, or an `impl` block with `is_met`, becomes a
//! `Condition`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};

use crate::attribute::{Arguments, Kind};
use crate::class::{Level, Role};
use crate::emit::{self, Call, ConditionImpl, Target};
use crate::errors::Errors;
use crate::fallback;
use crate::generator::analyse_method;
use crate::item::{self, Block, Function};
use crate::parameters;
use crate::signature::{Expected, Roles, analyse};

/// Expands the attribute.
pub fn expand(attribute: TokenStream, item: TokenStream) -> TokenStream {
    item::expand(Kind::Condition, attribute, item, of_function, of_block)
}

/// The front end for functions.
fn of_function(
    arguments: &Arguments,
    function: &Function,
    mut errors: Errors,
    item: &TokenStream,
) -> TokenStream {
    let signature = &function.signature;
    let (roles, mistakes) = analyse(
        signature,
        Expected {
            kind: Kind::Condition,
            level: arguments.level,
            method: false,
            generics: &signature.generics,
        },
    );
    errors.append(mistakes);
    if signature.receiver().is_some() {
        // Inside a block the implementation cannot be placed beside the function.
        let errors = errors.into_tokens();
        return quote!(#item #errors);
    }
    check_no_order(arguments.level, &roles, &mut errors);
    let generics = parameters::of_state(signature, roles.state.as_ref(), &mut errors);

    let name = &signature.ident;
    let cfgs = item::cfgs(&function.attributes);
    let target = Target {
        krate: arguments.krate(),
        level: arguments.level.unwrap_or(Level::Ecp),
        generics,
        self_type: roles.state.as_ref().map_or_else(|| name.to_token_stream(), ToTokens::to_token_stream),
        cfgs: &cfgs,
        doc: None,
    };
    let doc = class_line(&roles, target.level);
    let unit_type = roles.state.is_none().then(|| emit::unit_type(function, &doc));
    if !errors.is_empty() {
        let fallback = fallback::implementation(&target, Kind::Condition, None);
        let errors = errors.into_tokens();
        return quote!(#item #errors #unit_type #fallback);
    }
    let implementation = implementation(target, name.to_token_stream(), &roles);
    let function = function.with_doc(&doc);
    quote!(#function #unit_type #implementation)
}

/// The front end for `impl` blocks.
fn of_block(arguments: &Arguments, block: &Block, mut errors: Errors, item: &TokenStream) -> TokenStream {
    let signature = block.methods.iter().find(|signature| signature.ident == "is_met");
    let roles = signature
        .map(|signature| analyse_method(signature, Kind::Condition, arguments.level, block, &mut errors));
    match &roles {
        None => {
            errors.at(&block.self_type, "a condition needs its function: `fn is_met(&mut self, ..) -> bool`");
        }
        Some(roles) => check_no_order(arguments.level, roles, &mut errors),
    }
    let cfgs = item::cfgs(&block.attributes);
    let mut target = Target {
        krate: arguments.krate(),
        level: arguments.level.unwrap_or(Level::Ecp),
        generics: block.generics.clone(),
        self_type: block.self_type.to_token_stream(),
        cfgs: &cfgs,
        doc: None,
    };
    let Some(roles) = roles.filter(|_| errors.is_empty()) else {
        let fallback = fallback::implementation(&target, Kind::Condition, None);
        let errors = errors.into_tokens();
        return quote!(#item #errors #fallback);
    };
    target.doc = Some(class_line(&roles, target.level));
    let implementation = implementation(target, quote!(<Self>::is_met), &roles);
    quote!(#item #implementation)
}

fn implementation(target: Target<'_>, path: TokenStream, roles: &Roles) -> TokenStream {
    let krate = &target.krate;
    let or = |list: &Option<syn::Type>, nothing: TokenStream| {
        list.as_ref().map_or(nothing, ToTokens::to_token_stream)
    };
    ConditionImpl {
        robots: or(&roles.robots, quote!(#krate::generator::AnyRobots)),
        sensors: or(&roles.sensors, quote!(())),
        order: or(&roles.order, quote!(())),
        is_met: Call { path, roles },
        target,
    }
    .tokens()
}

/// The line of documentation that names the class.
fn class_line(roles: &Roles, level: Level) -> String {
    format!("Condition class: {level} `{}`.", roles.uses.in_paper(level))
}

/// Reports an order that an MP's condition takes: an MP gets no orders.
fn check_no_order(level: Option<Level>, roles: &Roles, errors: &mut Errors) {
    if level == Some(Level::Mp)
        && let Some(at) = roles.place(Role::Order)
    {
        errors.add(syn::Error::new(
            at,
            "nobody orders an MP: a condition of an MP takes some of `&mut Dwell`, `&State<(Rnt, Polycrank)>`, `&Reading<(WristForce,)>` and `Tick`",
        ));
    }
}
