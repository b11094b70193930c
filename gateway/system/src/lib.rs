//! The system description on the machine: the `.ssp` with its FMUs, run by the executor of the
//! simulation. The component that stands for the machine (the host) is left out: who owns the
//! drives writes its outputs and reads its inputs.

mod archive;
mod component;
mod controller;
mod drives;
mod error;
mod executor;
mod ffi;
mod fmu;
mod inline;
mod layout;
mod plant;
mod ssd;
mod system;
mod trip;
mod wiring;
mod worker;

pub use component::Component;
pub use controller::{Controller, Late, Options};
pub use error::Error;
pub use fmu::{Causality, Variable};
pub use plant::Plant;
pub use system::System;
pub use trip::{Trip, What};
pub use worker::ThreadHook;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_opened_may_move_to_another_thread() {
        fn may_move<T: Send>() {}
        may_move::<System>();
        may_move::<Controller>();
        may_move::<Plant>();
    }
}
