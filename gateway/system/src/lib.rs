//! Runs the FMUs of a system description (`.ssp`) in real time with the executor of the simulation.
//! The component of the machine (the host) is left out: the caller, who owns the drives, writes its
//! outputs and reads its inputs.

mod archive;
mod component;
mod controller;
mod drives;
mod dynamics;
mod error;
mod executor;
mod ffi;
mod fmu;
mod folder;
mod guard;
mod inline;
mod inverse;
mod kinematics;
mod layout;
mod options;
mod planned;
mod plant;
mod pose;
mod snapshot;
mod ssd;
mod state;
mod structure;
mod system;
mod threaded;
mod trip;
mod unit;
mod value;
mod variables;
mod watch;
mod wiring;
mod worker;

/// Axes of the hexapod: the number of drives, limits and torques.
pub const AXES: usize = 6;

pub use component::Component;
pub use controller::Controller;
pub use dynamics::{Dynamics, Motion};
pub use error::Error;
pub use guard::Bounds;
pub use inverse::Inverse;
pub use kinematics::{Gain, Kinematics};
pub use options::{Late, Options};
pub use planned::Planned;
pub use plant::Plant;
pub use pose::Pose;
pub use state::State;
pub use system::System;
pub use trip::{Trip, What};
pub use value::Value;
pub use variables::{Causality, Variable};
pub use watch::hanging;
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
        may_move::<Kinematics>();
        may_move::<Inverse>();
        may_move::<Dynamics>();
    }
}
