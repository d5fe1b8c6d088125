//! Whole cells, put on links that their tests watch or disturb.

mod arms_without_mp;
