//! Motions of your own, a file each: none so far. `mrroc-new generator --list` shows those of the library, to be copied and changed.
