//! `#[generator(mp|ecp, ..)]`: a step function, or an `impl` block that holds some, becomes a `Generator`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{ExprPath, Signature, Type};

use crate::attribute::{Arguments, Kind};
use crate::class::{Level, Role, Uses};
use crate::demands;
use crate::emit::{self, Call, GeneratorImpl, Source, Target};
use crate::errors::Errors;
use crate::fallback;
use crate::item::{self, Block, Function};
use crate::parameters;
use crate::signature::{Expected, Roles, analyse};
use crate::types::text;

/// Expands the attribute.
pub fn expand(attribute: TokenStream, item: TokenStream) -> TokenStream {
    item::expand(Kind::Generator, attribute, item, of_function, of_block)
}

/// The front end for functions.
fn of_function(
    arguments: &Arguments,
    function: &Function,
    mut errors: Errors,
    item: &TokenStream,
) -> TokenStream {
    let item = &demands::alone(arguments.level, item, &mut errors);
    let signature = &function.signature;
    let (roles, mistakes) = analyse(
        signature,
        Expected {
            kind: Kind::Generator,
            level: arguments.level,
            method: false,
            generics: &signature.generics,
        },
    );
    let has_mistakes = !mistakes.is_empty();
    errors.append(mistakes);
    if signature.receiver().is_some() {
        // Inside a block the implementation cannot be placed beside the function.
        let errors = errors.into_tokens();
        return quote!(#item #errors);
    }
    check_no_order(arguments.level, &roles, &mut errors);
    if !has_mistakes {
        check_class(arguments.level, &roles, &mut errors);
        check_keys(arguments, &roles, &mut errors);
    }
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
    let doc = class_line(arguments, &roles, target.level);
    let unit_type = roles.state.is_none().then(|| emit::unit_type(function, &doc));

    let Some(outcome) = roles.outcome.as_ref().filter(|_| errors.is_empty()) else {
        let fallback = fallback::implementation(&target, Kind::Generator, robot_of_ecp(arguments, &roles));
        let errors = errors.into_tokens();
        return quote!(#item #errors #unit_type #fallback);
    };
    let krate = &target.krate;
    let sensors = arguments.sensors.as_ref().or(roles.sensors.as_ref());
    let order = arguments.order.as_ref().or(roles.order.as_ref());
    let implementation = GeneratorImpl {
        robots: outcome.robots.to_token_stream(),
        language: outcome
            .language
            .as_ref()
            .map_or_else(|| quote!(#krate::generator::Motion), ToTokens::to_token_stream),
        sensors: or_nothing(sensors),
        sensors_are_seen: roles.sensors.is_some(),
        order: or_nothing(order),
        first: arguments.first.as_ref().map(Source::Named),
        next: Call { path: name.to_token_stream(), roles: &roles },
        until: arguments.until.as_ref().map(Source::Named),
        ends: outcome.ends || arguments.until.is_some(),
        target,
    }
    .tokens();
    let function = function.with_doc(&doc);
    quote!(#function #unit_type #implementation)
}

/// The front end for `impl` blocks.
fn of_block(arguments: &Arguments, block: &Block, mut errors: Errors, item: &TokenStream) -> TokenStream {
    let item = &demands::alone(arguments.level, item, &mut errors);
    for (key, method) in [(&arguments.first, "first_step"), (&arguments.until, "until")] {
        if let Some(path) = key {
            errors
                .at(path, format_args!("in an `impl` block this is a method: `fn {method}(&mut self, ..)`"));
        }
    }
    if let Some(list) = arguments.sensors.as_ref().or(arguments.order.as_ref()) {
        errors.at(list, "the methods say what they read: leave this out");
    }
    let method = |name: &str, kind: Kind, errors: &mut Errors| {
        let signature = block.methods.iter().find(|signature| signature.ident == name)?;
        Some(analyse_method(signature, kind, arguments.level, block, errors))
    };
    let first = method("first_step", Kind::Generator, &mut errors);
    let next = method("next_step", Kind::Generator, &mut errors);
    let until = method("until", Kind::Condition, &mut errors);
    if next.is_none() {
        errors.at(
            &block.self_type,
            "a generator needs its step function: `fn next_step(&mut self, t: Tick) -> Step<R>`",
        );
    }
    let has_mistakes = !errors.is_empty();
    for roles in [&first, &next].into_iter().flatten().filter(|_| !has_mistakes) {
        check_class(arguments.level, roles, &mut errors);
    }
    for roles in [&first, &next, &until].into_iter().flatten() {
        check_no_order(arguments.level, roles, &mut errors);
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
    let all = || [&first, &next, &until].into_iter().flatten();
    let outcome = next.as_ref().and_then(|next| next.outcome.as_ref().map(|outcome| (next, outcome)));
    let Some((next, outcome)) = outcome.filter(|_| errors.is_empty()) else {
        let roles_of = |signature| {
            analyse_method(signature, Kind::Generator, arguments.level, block, &mut Errors::default())
        };
        let methods: Vec<Roles> = block.methods.iter().map(roles_of).collect();
        let robot = methods.iter().find_map(|roles| robot_of_ecp(arguments, roles));
        let fallback = fallback::implementation(&target, Kind::Generator, robot);
        let errors = errors.into_tokens();
        return quote!(#item #errors #fallback);
    };
    target.doc = Some(class_line_of_methods(target.level, next, first.as_ref(), until.as_ref()));
    let krate = &target.krate;
    let source = |name: &'static str, roles| {
        let name = proc_macro2::Ident::new(name, proc_macro2::Span::call_site());
        Source::Seen(Call { path: quote!(<Self>::#name), roles })
    };
    let implementation = GeneratorImpl {
        robots: outcome.robots.to_token_stream(),
        language: outcome
            .language
            .as_ref()
            .map_or_else(|| quote!(#krate::generator::Motion), ToTokens::to_token_stream),
        sensors: or_nothing(all().find_map(|roles| roles.sensors.as_ref())),
        sensors_are_seen: all().any(|roles| roles.sensors.is_some()),
        order: or_nothing(all().find_map(|roles| roles.order.as_ref())),
        first: first.as_ref().map(|roles| source("first_step", roles)),
        next: Call { path: quote!(<Self>::next_step), roles: next },
        until: until.as_ref().map(|roles| source("until", roles)),
        ends: outcome.ends || until.is_some(),
        target,
    }
    .tokens();
    quote!(#item #implementation)
}

/// The roles of a method of the block.
pub fn analyse_method(
    signature: &Signature,
    kind: Kind,
    level: Option<Level>,
    block: &Block,
    errors: &mut Errors,
) -> Roles {
    let expected = Expected { kind, level, method: true, generics: &block.generics };
    let (roles, mistakes) = analyse(signature, expected);
    errors.append(mistakes);
    roles
}

/// Checks that the paper has a class for the arguments of the function (section 6).
fn check_class(level: Option<Level>, roles: &Roles, errors: &mut Errors) {
    if level == Some(Level::Mp)
        && !roles.uses.has(Role::Order)
        && !roles.uses.is_legal(Level::Mp)
        && let Some(at) = roles.place(Role::Robots).or(roles.place(Role::Sensors))
    {
        let seen = if roles.uses.has(Role::Robots) { "e" } else { "v" };
        errors.add(syn::Error::new(
            at,
            format_args!(
                "in an MP, reacting to `{seen}` without a state of the coordinator has no meaning: {FIVE_FORMS}"
            ),
        ));
    }
    if roles.uses == Uses::default()
        && let Some(outcome) = roles.outcome.as_ref().filter(|outcome| outcome.ends)
    {
        let robots = text(&outcome.robots);
        errors.at(
            &outcome.written,
            format_args!(
                "a step function without arguments returns the same in every step: `Always<{robots}>`; one that ends takes its state, `c: &mut Carry`"
            ),
        );
    }
}

/// Reports an order that an MP's generator takes: an MP gets no orders.
fn check_no_order(level: Option<Level>, roles: &Roles, errors: &mut Errors) {
    if level == Some(Level::Mp)
        && let Some(at) = roles.place(Role::Order)
    {
        errors.add(syn::Error::new(
            at,
            format_args!("nobody orders an MP: only a function of an ECP takes `&Order<..>`; {FIVE_FORMS}"),
        ));
    }
}

const FIVE_FORMS: &str = "the five forms of an MP's step function are \
    `f*0(c0)`: `(c: &mut Carry)`, \
    `f*1(c0, v)`: `(c: &mut Carry, v: &Reading<..>)`, \
    `f*2(c0, e)`: `(c: &mut Carry, e: &State<..>)`, \
    `f*3(c0, e, v)`: `(c: &mut Carry, e: &State<..>, v: &Reading<..>)`, each with or without `t: Tick`, \
    and `f**() = const`: no argument and `-> Always<..>`";

/// Checks that `sensors` and `order` name only what the annotated function itself does not take.
fn check_keys(arguments: &Arguments, roles: &Roles, errors: &mut Errors) {
    let named = arguments.first.is_some() || arguments.until.is_some();
    for (key, list, taken, form) in [
        ("sensors", &arguments.sensors, roles.uses.has(Role::Sensors), "&Reading<..>"),
        ("order", &arguments.order, roles.uses.has(Role::Order), "&Order<..>"),
    ] {
        let Some(list) = list else { continue };
        if taken {
            errors.at(list, format_args!("`{form}` in the signature says this already: leave `{key}` out"));
        } else if !named {
            errors.at(
                list,
                format_args!(
                    "nothing reads this: take `{form}`, or name the function that does, `first = grasp`"
                ),
            );
        }
    }
}

/// The robot of an ECP for the fallback, so that calls of the motion still compile.
fn robot_of_ecp<'a>(arguments: &Arguments, roles: &'a Roles) -> Option<&'a Type> {
    let list = roles.outcome.as_ref().map(|outcome| &outcome.robots).or(roles.robots.as_ref())?;
    let robot = match (arguments.level, list) {
        (Some(Level::Mp), _) => return None,
        (Some(Level::Ecp), Type::Tuple(list)) => list.elems.first()?,
        (Some(Level::Ecp), Type::Array(list)) => &list.elem,
        // If the level is missing, the form of the list shows it.
        (Some(Level::Ecp) | None, robot) => robot,
    };
    matches!(robot, Type::Path(_)).then_some(robot)
}

fn or_nothing(list: Option<&Type>) -> TokenStream {
    list.map_or_else(|| quote!(()), ToTokens::to_token_stream)
}

/// The line of documentation that names the class, as far as the signature shows it.
fn class_line(arguments: &Arguments, roles: &Roles, level: Level) -> String {
    let see = |key: &str, path: &Option<ExprPath>| {
        let path = path.as_ref()?.to_token_stream().to_string().replace(' ', "");
        Some(format!("; {key}: see `{path}`"))
    };
    [
        Some(format!("Generator class: {level} `{}`", roles.uses.in_paper(level))),
        see("first step", &arguments.first),
        see("until", &arguments.until),
        Some(".".into()),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn class_line_of_methods(level: Level, next: &Roles, first: Option<&Roles>, until: Option<&Roles>) -> String {
    let class = |key: &str, roles: &Roles| format!("{key} `{}`", roles.uses.in_paper(level));
    [
        Some(class(&format!("Generator class: {level}"), next)),
        first.map(|first| class(", first step", first)),
        until.map(|until| class(", until", until)),
        Some(".".into()),
    ]
    .into_iter()
    .flatten()
    .collect()
}
