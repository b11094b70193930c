//! Whole runs in the process of the test.

mod al_codes;
mod arming;
mod bring_up;
mod links;
mod panic;
mod property;
mod replay;
mod rig;
mod stall;

use super::*;
