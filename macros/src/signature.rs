//! The analysis of a signature.
//!
//! In: the signature of a function, its level, and whether it is a generator or a condition. Out: the roles of its
//! arguments and the type that it returns; and mistakes.
//!
//! A macro sees names, not types: a role is recognised by the last segment of the path of its type. An argument that is
//! not recognised is a mistake; no role is guessed.

use proc_macro2::Span;
use syn::{
    FnArg, GenericParam, Generics, Ident, ReceiverKind, ReturnType, Safety, Signature, Type, TypePath,
    TypeTuple,
};

use crate::attribute::Kind;
use crate::class::{Level, Role, Uses};
use crate::errors::Errors;
use crate::types::{arguments, could_be_own, filled, image, last_segment, last_span, plain, text};

/// The result of the analysis.
pub struct Roles {
    /// The roles of the arguments in their order, each with its place.
    pub arguments: Vec<(Role, Span)>,
    pub uses: Uses,
    /// The type of the function's own state; `None` for a method, whose state is `Self`.
    pub state: Option<Type>,
    /// The list in `&State<L>`.
    pub robots: Option<Type>,
    /// The list in `&Reading<V>`.
    pub sensors: Option<Type>,
    /// The payload in `&Order<P>`.
    pub order: Option<Type>,
    /// What a step function returns; `None` for a condition, and after a mistake.
    pub outcome: Option<Outcome>,
}

impl Roles {
    /// The place of an argument.
    pub fn place(&self, role: Role) -> Option<Span> {
        self.arguments.iter().find(|(argument, _)| *argument == role).map(|(_, span)| *span)
    }
}

/// What a step function returns, without the `Result` around it.
pub struct Outcome {
    /// The list of robots.
    pub robots: Type,
    /// The language; `None` if it is left out.
    pub language: Option<Type>,
    /// The type as written, for messages.
    pub written: Type,
    /// Whether it is a `Step`, which has an end, and not an `Always`.
    pub ends: bool,
}

/// What a signature is expected to be: a function of a generator or of a condition, its level, and whether it is a
/// method.
#[derive(Clone, Copy)]
pub struct Expected<'a> {
    pub kind: Kind,
    pub level: Option<Level>,
    pub method: bool,
    /// The parameters of the function or, for a method, of its `impl` block.
    pub generics: &'a Generics,
}

/// Finds the roles of the arguments and the outcome.
pub fn analyse(signature: &Signature, expected: Expected<'_>) -> (Roles, Errors) {
    let mut analysis = Analysis {
        expected,
        roles: Roles {
            arguments: Vec::new(),
            uses: Uses::default(),
            state: None,
            robots: None,
            sensors: None,
            order: None,
            outcome: None,
        },
        errors: Errors::default(),
    };
    analysis.qualifiers(signature);
    for argument in &signature.inputs {
        match argument {
            FnArg::Receiver(receiver) => analysis.receiver(receiver),
            FnArg::Typed(argument) => analysis.argument(&argument.ty),
        }
    }
    match expected.kind {
        Kind::Generator => analysis.outcome(signature),
        Kind::Condition => analysis.verdict(signature),
    }
    analysis.lists_agree();
    (analysis.roles, analysis.errors)
}

struct Analysis<'a> {
    expected: Expected<'a>,
    roles: Roles,
    errors: Errors,
}

impl Analysis<'_> {
    /// Checks that a step function is an ordinary function.
    fn qualifiers(&mut self, signature: &Signature) {
        if let Some(asyncness) = &signature.asyncness {
            self.errors.at(asyncness, "a step function computes and returns within its step: drop `async`");
        }
        match &signature.safety {
            Safety::Unsafe(token) => {
                self.errors.at(token, "the runtime calls step functions without precautions: drop `unsafe`");
            }
            Safety::Safe(token) => self.errors.at(token, "a step function is safe as it is: drop `safe`"),
            Safety::Default => {}
        }
        if let Some(abi) = &signature.abi {
            self.errors.at(abi, "a step function is a plain Rust function: drop the `extern`");
        }
        if let Some(variadic) = &signature.variadic {
            self.errors.at(variadic, "a step function takes each argument once: drop the `...`");
        }
        for parameter in &signature.generics.params {
            if self.expected.method && !matches!(parameter, GenericParam::Lifetime(_)) {
                self.errors.at(parameter, "put this parameter on the `impl` block: `impl<R: Robot> Line<R>`");
            }
        }
    }

    fn receiver(&mut self, receiver: &syn::Receiver) {
        if !self.expected.method {
            self.errors.at(
                receiver,
                "a free function has no `self`: take its state as `c: &mut Carry`, or put the attribute over the `impl` block",
            );
        } else if let ReceiverKind::Reference(..) = receiver.kind {
            self.roles.uses.insert(Role::State);
            self.roles.arguments.push((Role::State, receiver.self_token.span));
        } else {
            self.errors.at(receiver, "the state stays with the motion: take `&mut self`");
        }
    }

    /// Finds the role of one argument by its type.
    fn argument(&mut self, written: &Type) {
        let Some((role, span)) = self.role(plain(written)) else { return };
        if !self.roles.uses.insert(role) {
            self.errors.at(
                written,
                match role {
                    Role::State => "a second state: one type holds all that is kept from step to step".into(),
                    role => format!("a second {}: one argument holds it all, as a list", role.noun()),
                },
            );
            return;
        }
        self.roles.arguments.push((role, span));
    }

    /// The role of an argument and the token that decides it; `None` after a mistake.
    fn role(&mut self, ty: &Type) -> Option<(Role, Span)> {
        if let Type::ImplTrait(_) = ty {
            self.errors.at(
                ty,
                "the runtime must know the type: make it a parameter of the state, `fn line<R: Robot>(c: &mut Line<R>, ..)`",
            );
            return None;
        }
        let Type::Reference(reference) = ty else { return self.role_by_value(ty) };
        let inner = plain(&reference.elem);
        match (image(inner), reference.mutability.is_some()) {
            (Some((Role::Tick, _)), _) => {
                self.errors.at(ty, "the tick is taken by value: `t: Tick`");
                None
            }
            (Some((role, segment)), false) => {
                self.image(role, inner);
                Some((role, segment.ident.span()))
            }
            (Some((role, _)), true) => {
                self.errors.at(ty, format_args!("this is read only: write `&{}`", filled(inner, role)));
                None
            }
            (None, true) if self.expected.method => {
                self.errors.at(ty, "the state of a method is its `self`: keep this in it");
                None
            }
            (None, true) => self.own_state(inner).then(|| (Role::State, last_span(inner))),
            (None, false) => {
                self.no_argument(ty, inner);
                None
            }
        }
    }

    /// Only the tick comes by value.
    fn role_by_value(&mut self, ty: &Type) -> Option<(Role, Span)> {
        match image(ty) {
            Some((Role::Tick, segment)) => return Some((Role::Tick, segment.ident.span())),
            Some((role, _)) => {
                self.errors.at(ty, format_args!("this is taken by reference: write `&{}`", filled(ty, role)));
            }
            None => self.no_argument(ty, ty),
        }
        None
    }

    /// Reports an argument without a role, which may be a state in the wrong form.
    fn no_argument(&mut self, written: &Type, inner: &Type) {
        let others = match (self.expected.level, self.expected.kind) {
            (Some(Level::Mp), _) => "`&State<(Rnt, Polycrank)>`, `&Reading<(WristForce,)>` and `Tick`",
            _ => "`&Order<Phase>`, `&State<Rnt>`, `&Reading<(WristForce,)>` and `Tick`",
        };
        let text = text(written);
        if self.expected.method || self.roles.uses.has(Role::State) || !could_be_own(inner) {
            self.errors.at(
                written,
                format_args!("`{text}` is no argument of a step function: keep it in the state; the others are {others}"),
            );
        } else {
            self.roles.state.get_or_insert(inner.clone());
            self.roles.uses.insert(Role::State);
            let inner = crate::types::text(inner);
            self.errors.at(
                written,
                format_args!(
                    "a step function takes its own state as `&mut {inner}`; its other arguments are {others}"
                ),
            );
        }
    }

    /// Whether `ty` can be a state: a type for which a trait can be implemented in this crate.
    fn own_state(&mut self, ty: &Type) -> bool {
        let parameter =
            |ident: &Ident| self.expected.generics.type_params().any(|parameter| parameter.ident == *ident);
        let own = match ty {
            Type::Path(path) => could_be_own(ty) && !path.path.get_ident().is_some_and(parameter),
            _ => false,
        };
        if own {
            self.roles.state.get_or_insert(ty.clone());
        } else {
            self.errors.at(
                ty,
                "the state is a type of your own: hold this in one, `struct Carry { .. }`, and take `&mut Carry`",
            );
        }
        own
    }

    /// The list in an image's type, or the payload in an order's.
    fn image(&mut self, role: Role, ty: &Type) {
        let inner = match arguments(ty).as_slice() {
            [inner] => *inner,
            // The compiler asks for the arguments of the type in any case.
            _ => return self.errors.leave_to_compiler(),
        };
        match role {
            Role::Robots => {
                self.list_of_robots(inner);
                self.roles.robots.get_or_insert(inner.clone());
            }
            Role::Sensors => {
                self.list_of_sensors(inner);
                self.roles.sensors.get_or_insert(inner.clone());
            }
            Role::Order => {
                self.roles.order.get_or_insert(inner.clone());
            }
            Role::State | Role::Tick => {}
        }
    }

    /// The form of a list of robots: a tuple or an array in an MP, one robot in an ECP.
    fn list_of_robots(&mut self, list: &Type) {
        match (self.expected.level, plain(list)) {
            (Some(Level::Mp), Type::Paren(inner)) => {
                let robot = text(&inner.elem);
                self.errors.at(list, format_args!("a list of one robot needs a comma: `({robot},)`"));
            }
            (Some(Level::Mp), Type::Path(path)) if !self.starts_with_parameter(path) => {
                let robot = text(list);
                self.errors.at(
                    list,
                    format_args!(
                        "an MP's list is a tuple or an array, written out, also for one robot: `({robot},)`"
                    ),
                );
            }
            (Some(Level::Mp), Type::Tuple(tuple)) if tuple.elems.is_empty() => {
                self.errors.at(list, "name the robots: `(Rnt, Polycrank)`");
            }
            (Some(Level::Ecp), Type::Tuple(TypeTuple { elems, .. })) => {
                let robot = elems.first().map_or("Rnt".into(), text);
                self.errors.at(list, format_args!("an ECP has one robot, without parentheses: `{robot}`"));
            }
            (Some(Level::Ecp), Type::Array(array)) => {
                let robot = text(&array.elem);
                self.errors.at(list, format_args!("an ECP has one robot: `{robot}`"));
            }
            _ => {}
        }
    }

    /// Whether the type is a type parameter, which stands for any list: `L` or `L::Robots`.
    fn starts_with_parameter(&self, path: &TypePath) -> bool {
        let first = path.path.segments.first();
        path.qself.is_some()
            || self
                .expected
                .generics
                .type_params()
                .any(|parameter| first.is_some_and(|segment| segment.ident == parameter.ident))
    }

    fn list_of_sensors(&mut self, list: &Type) {
        match plain(list) {
            // The type `Reading` itself refuses this list, with a message that the comma is missing.
            Type::Paren(_) => self.errors.leave_to_compiler(),
            Type::Tuple(tuple) if tuple.elems.is_empty() => {
                self.errors.at(list, "a reading of no sensors says nothing: leave the argument out");
            }
            _ => {}
        }
    }

    /// What a step function returns.
    fn outcome(&mut self, signature: &Signature) {
        let form = match (&self.roles.robots, self.expected.level) {
            (Some(list), _) => format!("Step<{}>", text(list)),
            (None, Some(Level::Ecp)) => "Step<Rnt>".into(),
            (None, _) => "Step<(Rnt, Polycrank)>".into(),
        };
        let ReturnType::Type(_, written) = &signature.output else {
            self.errors
                .at(&signature.ident, format_args!("a step function returns the next step: `-> {form}`"));
            return;
        };
        let Some(ty) = self.without_result(written, &form) else { return };
        let ends = match last_segment(ty) {
            Some(segment) if segment.ident == "Step" => true,
            Some(segment) if segment.ident == "Always" => false,
            Some(segment) if segment.ident == "bool" => {
                let level = self.expected.level.map_or("mp", Level::key);
                self.errors.at(
                    written,
                    format_args!(
                        "a step function returns `{form}`; a function that returns `bool` is a condition: `#[condition({level})]`"
                    ),
                );
                return;
            }
            _ => {
                self.errors.at(
                    written,
                    format_args!(
                        "a step function returns `{form}`, `Always<..>` when it never ends, or a `Result` of one with a `Fault`"
                    ),
                );
                return;
            }
        };
        match arguments(ty).as_slice() {
            [robots] => self.set_outcome(ty, robots, None, ends),
            [robots, language] => self.set_outcome(ty, robots, Some((*language).clone()), ends),
            _ => self.errors.leave_to_compiler(),
        }
    }

    fn set_outcome(&mut self, written: &Type, robots: &Type, language: Option<Type>, ends: bool) {
        self.list_of_robots(robots);
        self.roles.outcome =
            Some(Outcome { robots: robots.clone(), language, written: written.clone(), ends });
    }

    /// What a condition returns.
    fn verdict(&mut self, signature: &Signature) {
        let ReturnType::Type(_, written) = &signature.output else {
            self.errors.at(&signature.ident, "a condition returns whether it holds: `-> bool`");
            return;
        };
        let Some(ty) = self.without_result(written, "bool") else { return };
        match last_segment(ty) {
            Some(segment) if segment.ident == "bool" => {}
            Some(segment) if segment.ident == "Step" || segment.ident == "Always" => {
                let level = self.expected.level.map_or("mp", Level::key);
                self.errors.at(
                    written,
                    format_args!(
                        "a condition returns `bool`; a function that returns a step is a generator: `#[generator({level})]`"
                    ),
                );
            }
            _ => self.errors.at(written, "a condition returns `bool` or `Result<bool, Fault>`"),
        }
    }

    /// The type inside `Result<.., Fault>`, or the type itself.
    fn without_result<'t>(&mut self, written: &'t Type, form: &str) -> Option<&'t Type> {
        let ty = plain(written);
        if last_segment(ty).is_none_or(|segment| segment.ident != "Result") {
            return Some(ty);
        }
        match arguments(ty).as_slice() {
            // One argument: an alias, whose error the compiler checks.
            [inner] => Some(plain(inner)),
            [inner, fault] if last_segment(plain(fault)).is_some_and(|fault| fault.ident == "Fault") => {
                Some(plain(inner))
            }
            [inner, fault] => {
                let inner = text(inner);
                self.errors.at(
                    fault,
                    format_args!("a step function fails with a `Fault`: `Result<{inner}, Fault>`"),
                );
                None
            }
            _ => {
                self.errors.at(ty, format_args!("write `Result<{form}, Fault>`"));
                None
            }
        }
    }

    /// Reports lists that differ, such as `&State<(A, B)>` and `Step<(B, A)>`, if the names alone make this certain.
    fn lists_agree(&mut self) {
        let (Some(state), Some(outcome)) = (&self.roles.robots, &self.roles.outcome) else { return };
        let (Type::Tuple(seen), Type::Tuple(moved)) = (plain(state), plain(&outcome.robots)) else { return };
        let names = |tuple: &TypeTuple| tuple.elems.iter().map(text).collect::<Vec<_>>();
        let (seen, moved) = (names(seen), names(moved));
        let sorted = |names: &[String]| {
            let mut names = names.to_vec();
            names.sort();
            names
        };
        if seen.len() != moved.len() || (seen != moved && sorted(&seen) == sorted(&moved)) {
            let list = text(&outcome.robots);
            self.errors.at(
                state,
                format_args!("the robots differ from those returned, in number or order: `&State<{list}>`"),
            );
        }
    }
}
