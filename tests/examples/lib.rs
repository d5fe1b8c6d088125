//! Nothing: the examples lie beside the crates that they show, and are targets of this package.
