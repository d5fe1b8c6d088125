//! Prints implementations of the traits.
//!
//! In: what the analysis has found. Out: tokens. Every path of the runtime that an expansion uses is named in this
//! file.

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Attribute, ExprPath, Generics};

use crate::class::{Level, Role, Uses};
use crate::signature::Roles;

/// What the implementations of both traits need.
pub struct Target<'a> {
    /// The path of the runtime crate.
    pub krate: TokenStream,
    pub level: Level,
    pub generics: Generics,
    /// The type that implements the trait.
    pub self_type: TokenStream,
    pub cfgs: &'a [Attribute],
    /// A line of documentation for the implementation, if the function has no documentation of its own.
    pub doc: Option<String>,
}

/// A call of a function whose signature the macro has seen.
pub struct Call<'a> {
    /// `carry` or `<Self>::next_step`.
    pub path: TokenStream,
    pub roles: &'a Roles,
}

/// How a step or the terminal condition is computed.
pub enum Source<'a> {
    Seen(Call<'a>),
    /// A plain function that the attribute names: only the compiler sees its signature.
    Named(&'a ExprPath),
}

/// An implementation of `Generator`.
pub struct GeneratorImpl<'a> {
    pub target: Target<'a>,
    pub robots: TokenStream,
    pub language: TokenStream,
    pub sensors: TokenStream,
    /// Whether the list of sensors stands in a signature, and not only in the attribute.
    pub sensors_are_seen: bool,
    pub order: TokenStream,
    /// The first step; `None` if the function of the next steps also computes the first one.
    pub first: Option<Source<'a>>,
    pub next: Call<'a>,
    pub until: Option<Source<'a>>,
    pub ends: bool,
}

/// An implementation of `Condition`.
pub struct ConditionImpl<'a> {
    pub target: Target<'a>,
    pub robots: TokenStream,
    pub sensors: TokenStream,
    pub order: TokenStream,
    pub is_met: Call<'a>,
}

/// A local name of the expansion, which cannot collide with a name of the user's.
fn local(name: &str, span: Span) -> Ident {
    Ident::new(name, Span::mixed_site().located_at(span))
}

/// The name of an argument in the expansion, as in the paper.
fn argument(role: Role, span: Span) -> Ident {
    match role {
        Role::Order => local("order", span),
        Role::State => Ident::new("self", span),
        Role::Robots => local("e", span),
        Role::Sensors => local("v", span),
        Role::Tick => local("t", span),
    }
}

impl Call<'_> {
    /// The call, with each argument at the span of its type, so that the compiler reports a mismatch there.
    fn tokens(&self) -> TokenStream {
        let path = &self.path;
        let arguments = self.roles.arguments.iter().map(|(role, span)| {
            let span = if *role == Role::State { Span::call_site() } else { *span };
            argument(*role, span)
        });
        quote!(#path(#(#arguments),*))
    }
}

impl Target<'_> {
    pub fn level(&self) -> TokenStream {
        let krate = &self.krate;
        match self.level {
            Level::Mp => quote!(#krate::generator::Level::Mp),
            Level::Ecp => quote!(#krate::generator::Level::Ecp),
        }
    }

    /// `Uses { state: true, tick: true, ..Uses::NOTHING }`
    fn uses(&self, uses: Uses) -> TokenStream {
        let krate = &self.krate;
        let fields: Vec<Ident> = Role::ALL
            .iter()
            .filter(|role| uses.has(**role))
            .map(|role| format_ident!("{}", role.field()))
            .collect();
        match fields.len() {
            0 => quote!(#krate::generator::Uses::NOTHING),
            5 => quote!(#krate::generator::Uses { #(#fields: true),* }),
            _ => quote!(#krate::generator::Uses { #(#fields: true,)* ..#krate::generator::Uses::NOTHING }),
        }
    }

    /// The arguments of a trait's method; arguments that are not `used` have no name.
    pub fn arguments(&self, used: impl Fn(Role) -> bool) -> TokenStream {
        let krate = &self.krate;
        let name = |role| {
            if used(role) { argument(role, Span::call_site()).to_token_stream() } else { quote!(_) }
        };
        let [order, e, v, t] = [Role::Order, Role::Robots, Role::Sensors, Role::Tick].map(name);
        quote! {
            &mut self,
            #order: &#krate::payload::Order<Self::Order>,
            #e: &#krate::robot::State<Self::Robots>,
            #v: &#krate::sensor::Reading<Self::Sensors>,
            #t: #krate::generator::Tick
        }
    }

    /// The implementation of `trait_name` around its items, in a scope of its own.
    ///
    /// `assumed` are the bounds on the lists. The compiler has checked them already, at the signature of the
    /// user's function; as assumptions here, they are not reported a second and a third time. The lifetime
    /// makes the compiler accept them as assumptions.
    pub fn implement(&self, trait_name: &str, assumed: &[TokenStream], items: &TokenStream) -> TokenStream {
        let Target { krate, self_type, cfgs, .. } = self;
        let trait_name = Ident::new(trait_name, Span::call_site());
        let (generics, _, _) = self.generics.split_for_impl();
        let assumed = assumed.iter().map(|bound| quote!(for<'seen_above> #bound));
        let where_clause = where_clause(&self.generics, assumed);
        let doc = self.doc.as_ref().map(|doc| {
            let doc = format!(" {doc}");
            quote!(#[doc = #doc])
        });
        // At the span of the state's type, where the compiler reports a second implementation.
        let implement = quote_spanned!(self_type.span()=> impl);
        let mut body = Group::new(Delimiter::Brace, items.clone());
        body.set_span(self_type.span());
        quote! {
            #(#cfgs)*
            const _: () = {
                #doc
                #[automatically_derived]
                #implement #generics #krate::generator::#trait_name for #self_type #where_clause #body
            };
        }
    }
}

/// The bounds of `generics`, and `more`.
pub fn where_clause(generics: &Generics, more: impl IntoIterator<Item = TokenStream>) -> Option<TokenStream> {
    let written = generics.where_clause.iter().flat_map(|bounds| &bounds.predicates);
    let bounds: Vec<_> = written.map(ToTokens::to_token_stream).chain(more).collect();
    (!bounds.is_empty()).then(|| quote!(where #(#bounds,)*))
}

/// The tokens, all placed at `span`.
pub fn placed(tokens: TokenStream, span: Span) -> TokenStream {
    let place = |token| match token {
        TokenTree::Group(group) => {
            let mut placed = Group::new(group.delimiter(), self::placed(group.stream(), span));
            placed.set_span(span);
            TokenTree::Group(placed)
        }
        mut token => {
            token.set_span(span);
            token
        }
    };
    tokens.into_iter().map(place).collect()
}

/// The arguments in the order of the trait's methods.
fn all_arguments() -> [Ident; 4] {
    [Role::Order, Role::Robots, Role::Sensors, Role::Tick].map(|role| argument(role, Span::call_site()))
}

impl GeneratorImpl<'_> {
    pub fn tokens(&self) -> TokenStream {
        let GeneratorImpl { target, robots, language, sensors, order, .. } = self;
        let krate = &target.krate;
        let class = self.class();
        let ends = (!self.ends).then(|| {
            quote!(
                const ENDS: bool = false;
            )
        });
        let first = self.step("first_step", self.first.as_ref());
        let next = self.step("next_step", None);
        let mut assumed = vec![quote!(#robots: #krate::generator::Robots<#language>)];
        if self.sensors_are_seen {
            assumed.push(quote!(#sensors: #krate::generator::SensorList));
        }
        target.implement(
            "Generator",
            &assumed,
            &quote! {
                type Robots = #robots;
                type Language = #language;
                type Sensors = #sensors;
                type Order = #order;
                const CLASS: #krate::generator::Class = #class;
                #ends
                #first
                #next
            },
        )
    }

    fn class(&self) -> TokenStream {
        let target = &self.target;
        let krate = &target.krate;
        let level = target.level();
        let next = target.uses(self.next.roles.uses);
        if self.first.is_none() && self.until.is_none() {
            return quote!(#krate::generator::Class::new(#level, #next));
        }
        let uses = |source: &Source<'_>, until| match source {
            Source::Seen(call) => target.uses(call.roles.uses),
            Source::Named(path) => {
                let plain = self.named(path, until);
                quote!(#plain.uses)
            }
        };
        let first = self.first.as_ref().map_or_else(|| next.clone(), |first| uses(first, false));
        let until = self.until.as_ref().map_or_else(
            || quote!(::core::option::Option::None),
            |until| {
                let until = uses(until, true);
                quote!(::core::option::Option::Some(#until))
            },
        );
        quote!(#krate::generator::Class { level: #level, first: #first, next: #next, until: #until })
    }

    /// A plain function, wrapped so that its type gives its arguments. The expression is the same wherever the function
    /// is used, so that the compiler reports a mistake about it once.
    fn named(&self, path: &ExprPath, until: bool) -> TokenStream {
        let krate = &self.target.krate;
        let adapter = match (until, self.target.level) {
            (true, _) => quote!(until),
            (false, Level::Mp) => quote!(first_in_mp),
            (false, Level::Ecp) => quote!(first_in_ecp),
        };
        quote_spanned!(path.span()=> #krate::__private1::#adapter::<Self, _, _>(&#path))
    }

    /// One method of the trait; `first` if a separate function computes the first step.
    fn step(&self, name: &str, first: Option<&Source<'_>>) -> TokenStream {
        let krate = &self.target.krate;
        let method = Ident::new(name, Span::call_site());
        let [order, e, v, t] = all_arguments();
        let all = quote!(#order, self, #e, #v, #t);
        let serves_as_first = name == "first_step" && first.is_none();
        let mut uses_all = serves_as_first;
        let mut used = Uses::default();
        let mut take = |roles: &Roles| {
            for (role, _) in &roles.arguments {
                used.insert(*role);
            }
        };

        let step = if serves_as_first {
            quote!(#krate::generator::Generator::next_step(self, #order, #e, #v, #t))
        } else {
            match first {
                Some(Source::Named(path)) => {
                    uses_all = true;
                    let plain = self.named(path, false);
                    quote!(#plain.step(#all))
                }
                Some(Source::Seen(call)) => {
                    take(call.roles);
                    let call = call.tokens();
                    quote!(#krate::__private1::IntoStep::into_step(#call))
                }
                None => {
                    take(self.next.roles);
                    let call = self.next.tokens();
                    quote!(#krate::__private1::IntoStep::into_step(#call))
                }
            }
        };
        let until = self.until.as_ref().filter(|_| !serves_as_first).map(|until| {
            let holds = match until {
                Source::Named(path) => {
                    uses_all = true;
                    let plain = self.named(path, true);
                    quote!(#plain.holds(#all)?)
                }
                Source::Seen(call) => {
                    take(call.roles);
                    let call = call.tokens();
                    quote!(#krate::__private1::IntoVerdict::into_verdict(#call)?)
                }
            };
            quote! {
                if #holds {
                    return ::core::result::Result::Ok(#krate::generator::Step::Done);
                }
            }
        });
        let arguments = self.target.arguments(|role| uses_all || used.has(role));
        quote! {
            fn #method(
                #arguments
            ) -> ::core::result::Result<#krate::generator::Step<Self::Robots, Self::Language>, #krate::fault::Fault> {
                #until
                #step
            }
        }
    }
}

impl ConditionImpl<'_> {
    pub fn tokens(&self) -> TokenStream {
        let ConditionImpl { target, robots, sensors, order, is_met } = self;
        let krate = &target.krate;
        let level = target.level();
        let uses = target.uses(is_met.roles.uses);
        let arguments = target.arguments(|role| is_met.roles.uses.has(role));
        let call = is_met.tokens();
        let mut assumed = Vec::new();
        if is_met.roles.uses.has(Role::Robots) {
            assumed.push(quote!(#robots: #krate::generator::RobotList));
        }
        if is_met.roles.uses.has(Role::Sensors) {
            assumed.push(quote!(#sensors: #krate::generator::SensorList));
        }
        target.implement(
            "Condition",
            &assumed,
            &quote! {
                type Robots = #robots;
                type Sensors = #sensors;
                type Order = #order;
                const CLASS: #krate::generator::Class = #krate::generator::Class::new(#level, #uses);
                fn is_met(#arguments) -> ::core::result::Result<bool, #krate::fault::Fault> {
                    #krate::__private1::IntoVerdict::into_verdict(#call)
                }
            },
        )
    }
}

/// The type of a function without state, which has the function's name: names of functions and of types do not collide.
pub fn unit_type(function: &crate::item::Function, doc: &str) -> TokenStream {
    let visibility = &function.visibility;
    let name = &function.signature.ident;
    let cfgs = crate::item::cfgs(&function.attributes);
    let docs: Vec<_> = function.docs().collect();
    let blank = (!docs.is_empty()).then(|| quote!(#[doc = ""]));
    let doc = format!(" {doc}");
    quote! {
        #(#cfgs)*
        #(#docs)*
        #blank
        #[doc = #doc]
        #[allow(non_camel_case_types, dead_code)]
        #[derive(::core::clone::Clone, ::core::marker::Copy, ::core::fmt::Debug, ::core::default::Default)]
        #visibility struct #name {}
    }
}
