//! All tests of the library but those that stand in a generator's file: one executable, as each takes its time to link.

mod belt_pick;
mod classes;
mod conditions;
mod conformance;
mod contact;
mod cooperation;
mod curve_reference;
mod curve_splines;
mod curves;
mod each;
mod examples;
mod feed;
mod goals;
mod jerk_plan;
mod jerk_properties;
mod jerk_reference;
mod memory;
mod pages;
mod panel_jog;
mod peg_in_hole;
mod pictures;
mod profile_properties;
mod profiles;
mod reactive;
mod reference;
mod registry;
mod spline_properties;
mod spline_reference;
mod timing;
mod timing_reference;
mod trajectory;
mod via;
mod waypoints;

#[global_allocator]
static ALLOCATOR: mrroc_counting_allocator::Counting = mrroc_counting_allocator::Counting;
