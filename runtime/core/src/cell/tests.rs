//! Whole cells, put on links that their tests watch or disturb.

mod arm_cut_off;
mod arm_refused;
mod arms_without_mp;
mod shown_stops;
