//! The tests of this crate, one executable: a file for each robot, or for each promise that all of them keep.

mod calibrated;
mod cell;
mod clearance;
mod conformance;
mod conformance_catches;
mod coupled;
mod dynamics;
mod examples;
mod grasp;
mod gripper;
mod homing;
mod irp6_variants;
mod kinds;
mod kinds_urdf;
mod kinematics;
mod loads;
mod memory;
mod mesh_cover;
mod mesh_files;
mod plant;
mod polycrank;
mod redundancy;
mod reference;
mod regulators;
mod rnt;
mod singularities;
mod support;
mod transmission;
mod urdf_allocation;
mod urdf_closed;
mod urdf_conformance;
mod urdf_drives;
mod urdf_errors;
mod urdf_held;
mod urdf_inertia;
mod urdf_inverse;
mod urdf_outline;
mod urdf_reference;
mod urdf_rounded;

use mrroc_counting_allocator::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
