//! What needs the machine's clock: launches in real time. Each is checked by what holds of a late one, too, and none is started again:
//! what needs a punctual machine is tested in lock-step, beside this folder. `just real-time` runs them many times.

mod kills;
mod launches;
mod resets;
mod runs;
mod soak;
mod supervision;
