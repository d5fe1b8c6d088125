//! The completeness argument of section 6 of the paper, checked by enumeration: of the eight combinations of an
//! MP five are legal, of an ECP all eight, and the class that the macros write is that of the paper's table.

use proc_macro2::TokenStream;
use proptest::prelude::*;
use proptest::sample::Index;
use quote::quote;

use crate::class::{Level, Role, Uses};
use crate::generator;

/// The classes as the runtime has them: its own file, which needs nothing else of it.
#[allow(dead_code)]
#[path = "../../../runtime/core/src/model/class.rs"]
mod of_runtime;

/// A step function that takes `roles`, in this order.
fn function(level: Level, roles: &[Role]) -> TokenStream {
    let list = match level {
        Level::Mp => quote!((Rnt, Polycrank)),
        Level::Ecp => quote!(Rnt),
    };
    let arguments = roles.iter().map(|role| match role {
        Role::Order => quote!(order: &Order<Phase>),
        Role::State => quote!(c: &mut Carry),
        Role::Robots => quote!(e: &State<#list>),
        Role::Sensors => quote!(v: &Reading<(WristForce,)>),
        Role::Tick => quote!(t: Tick),
    });
    let outcome = if roles.is_empty() { quote!(Always<#list>) } else { quote!(Step<#list>) };
    quote!(fn carry(#(#arguments),*) -> #outcome { todo!() })
}

fn attribute(level: Level) -> TokenStream {
    match level {
        Level::Mp => quote!(mp),
        Level::Ecp => quote!(ecp),
    }
}

/// Whether the function is a generator, and the expansion as text.
fn expand(level: Level, roles: &[Role]) -> (bool, String) {
    let text = generator::expand(attribute(level), function(level, roles)).to_string();
    (!text.contains("compile_error"), text)
}

#[test]
fn an_mp_has_five_classes_and_an_ecp_eight() {
    // The table: c0, e, v of an MP; c0 (the order), e, v of an ECP, whose own state is always there.
    let mp = [
        (&[][..], Some("f**() = const")),
        (&[Role::State], Some("f*0(c0)")),
        (&[Role::State, Role::Sensors], Some("f*1(c0, v)")),
        (&[Role::State, Role::Robots], Some("f*2(c0, e)")),
        (&[Role::State, Role::Robots, Role::Sensors], Some("f*3(c0, e, v)")),
        (&[Role::Sensors], None),
        (&[Role::Robots], None),
        (&[Role::Robots, Role::Sensors], None),
    ];
    for (roles, name) in mp {
        let (legal, text) = expand(Level::Mp, roles);
        assert_eq!(legal, name.is_some(), "{roles:?}");
        if let Some(name) = name {
            assert!(text.contains(&format!("Generator class: MP `{name}`.")), "{roles:?}: {text}");
        }
    }
    let ecp = [
        (&[Role::State][..], "f*0(c)"),
        (&[Role::State, Role::Sensors], "f*1(c, v)"),
        (&[Role::State, Role::Robots], "f*2(c, e)"),
        (&[Role::State, Role::Robots, Role::Sensors], "f*3(c, e, v)"),
        (&[Role::Order, Role::State], "f*4(c0, c)"),
        (&[Role::Order, Role::State, Role::Sensors], "f*5(c0, c, v)"),
        (&[Role::Order, Role::State, Role::Robots], "f*6(c0, c, e)"),
        (&[Role::Order, Role::State, Role::Robots, Role::Sensors], "f*7(c0, c, e, v)"),
    ];
    for (roles, name) in ecp {
        for roles in [roles, &roles.iter().copied().filter(|role| *role != Role::State).collect::<Vec<_>>()] {
            let (legal, text) = expand(Level::Ecp, roles);
            assert!(legal, "{roles:?}");
            assert!(text.contains(&format!("Generator class: ECP `{name}`.")), "{roles:?}: {text}");
        }
    }
}

/// Any of the arguments, each at most once, in any order.
fn any_roles() -> impl Strategy<Value = Vec<Role>> {
    prop::collection::vec((any::<bool>(), any::<Index>()), Role::ALL.len()).prop_map(|choices| {
        let mut roles = Vec::new();
        for (role, (taken, place)) in Role::ALL.into_iter().zip(choices) {
            if taken {
                roles.insert(place.index(roles.len() + 1), role);
            }
        }
        roles
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// The arguments' order is free, and the class depends on nothing but which there are: as the runtime has it.
    #[test]
    fn the_class_is_the_set_of_arguments(roles in any_roles(), in_mp: bool) {
        let (level, runtime_level) =
            if in_mp { (Level::Mp, of_runtime::Level::Mp) } else { (Level::Ecp, of_runtime::Level::Ecp) };
        let has = |role| roles.contains(&role);
        let runtime_uses = of_runtime::Uses {
            order: has(Role::Order),
            state: has(Role::State),
            robots: has(Role::Robots),
            sensors: has(Role::Sensors),
            tick: has(Role::Tick),
        };
        let (legal, text) = expand(level, &roles);
        prop_assert_eq!(legal, of_runtime::Class::is_legal(runtime_level, runtime_uses));

        let mut uses = Uses::default();
        for role in &roles {
            prop_assert!(uses.insert(*role));
        }
        prop_assert_eq!(uses.is_legal(level), legal);
        if legal {
            let name = of_runtime::Class::new(runtime_level, runtime_uses).to_string();
            prop_assert_eq!(format!("{level} {}", uses.in_paper(level)), name.clone());
            let (level, class) = name.split_once(' ').unwrap();
            let line = format!("class: {level} `{class}`");
            prop_assert!(text.contains(&line));
            for role in Role::ALL {
                let field = format!("{} : true", role.field());
                prop_assert_eq!(text.contains(&field), has(role), "{}", text);
            }
        }
    }
}
