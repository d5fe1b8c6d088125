//! Two arms of a cell are calibrated by two theodolites: the task that the MRROC++ paper names, "the tedious process of calibrating the
//! two-robot system".
//!
//! [`mp`] coordinates: the arms visit postures together, and the coordinator waits until both instruments have sighted all balls in both
//! faces. [`scene`] is how the cell truly is, [`theodolite`] what an instrument is, [`sensor`] the instrument as a virtual sensor, [`drives`] arms whose
//! dimensions are not those that programs believe. [`visits`] says where the arms go; [`estimate`] makes of the sights what is wanted, and
//! [`pictures`] draws it.

pub mod drives;
pub mod estimate;
pub mod mp;
pub mod options;
pub mod pictures;
pub mod random;
pub mod scene;
pub mod sensor;
pub mod theodolite;
pub mod visits;
