//! What the macros write, for the reader of a diff.

use proc_macro2::TokenStream;
use quote::quote;

use crate::{condition, generator, payload};

macro_rules! assert_expansion {
    ($name:literal, $expansion:expr) => {
        let expansion: TokenStream = $expansion;
        let file = syn::parse2(expansion).expect("an expansion is a list of items");
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!($name, prettyplease::unparse(&file));
        });
    };
}

#[test]
fn a_motion_with_a_first_step_of_its_own() {
    assert_expansion!(
        "mp_with_first_step",
        generator::expand(
            quote!(mp, first = grasp),
            quote! {
                /// Carries the body along a straight line.
                #[inline]
                pub fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
                    c.advance(t)
                }
            },
        )
    );
}

#[test]
fn a_motion_that_takes_all_there_is_in_any_order() {
    assert_expansion!(
        "ecp_with_all_arguments",
        generator::expand(
            quote!(ecp),
            quote! {
                fn follow(
                    t: Tick,
                    v: &Reading<(WristForce, Camera)>,
                    c: &mut Follow,
                    order: &mrroc::payload::Order<Phase>,
                    e: &State<Rnt>,
                ) -> Result<mrroc::generator::Step<Rnt>, Fault> {
                    todo!()
                }
            },
        )
    );
}

#[test]
fn a_constant_of_the_mp() {
    assert_expansion!(
        "mp_constant",
        generator::expand(
            quote!(mp),
            quote! {
                /// Tells each to grasp.
                pub(crate) fn trigger() -> Always<(Rnt, Polycrank), Phase> {
                    Always((Phase::Grasp, Phase::Grasp))
                }
            },
        )
    );
}

#[test]
fn a_function_without_state() {
    assert_expansion!(
        "ecp_without_state",
        generator::expand(
            quote!(ecp, crate = crate::runtime),
            quote! {
                #[cfg(feature = "tight")]
                fn transmit(order: &Order<Displacement>) -> Always<Rnt> {
                    Always(Demand::displacement(order.value()))
                }
            },
        )
    );
}

#[test]
fn a_terminal_condition_that_reads_more_than_the_steps() {
    assert_expansion!(
        "ecp_generic_with_until",
        generator::expand(
            quote!(ecp, first = begin::<R>, until = pressed, sensors = (WristForce,)),
            quote! {
                fn press<R, const N: usize>(c: &mut Press<R, N>, e: &State<R>) -> Step<R>
                where
                    R: Robot,
                {
                    todo!()
                }
            },
        )
    );
}

#[test]
fn a_block_of_methods() {
    assert_expansion!(
        "block",
        generator::expand(
            quote!(ecp),
            quote! {
                impl<R: Robot> Line<R> {
                    const SPEED: f64 = { 0.5 };
                    pub fn to(goal: Pose) -> Self {
                        todo!()
                    }
                    fn first_step(&mut self, e: &State<R>) -> Step<R> {
                        todo!()
                    }
                    fn next_step(&mut self, t: Tick) -> Step<R> {
                        todo!()
                    }
                    fn until(&self, v: &Reading<(WristForce,)>) -> bool {
                        todo!()
                    }
                }
            },
        )
    );
}

#[test]
fn a_condition() {
    assert_expansion!(
        "condition",
        condition::expand(
            quote!(mp),
            quote! {
                fn body_held(c: &mut Dwell, v: &Reading<(WristForce,)>) -> bool {
                    todo!()
                }
            },
        )
    );
}

#[test]
fn a_condition_without_state() {
    assert_expansion!(
        "condition_without_state",
        condition::expand(
            quote!(ecp),
            quote!(
                fn near(e: &State<Rnt>) -> Result<bool, Fault> {
                    todo!()
                }
            )
        )
    );
}

#[test]
fn an_order_of_loose_cooperation() {
    assert_expansion!(
        "payload_enum",
        payload::expand(quote!(
            enum Phase {
                Grasp,
                Close,
            }
        ))
    );
}

#[test]
fn an_order_of_loose_cooperation_with_data() {
    assert_expansion!(
        "payload_enum_with_data",
        payload::expand(quote!(
            enum Handle {
                Pick { part: u32, at: Pose },
                Drop(u8),
                Rest,
            }
        ))
    );
}

#[test]
fn an_order_of_tight_cooperation() {
    assert_expansion!(
        "payload_struct",
        payload::expand(quote!(
            struct Displacement {
                pose: Pose,
                step: u64,
            }
        ))
    );
}

#[test]
fn what_is_left_after_a_mistake() {
    assert_expansion!(
        "after_a_mistake",
        generator::expand(
            quote!(mp),
            quote! {
                fn carry(c: &mut Carry, order: &Order<Phase>, speed: f64) -> Step<(Rnt)> {
                    todo!()
                }
            },
        )
    );
}
