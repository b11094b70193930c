//! A run as others see it while it goes on: its newest cycle, a local socket, a page.

mod board;
mod error;
mod serve;
mod view;

pub use board::Board;
pub use error::{LiveError, LiveFault};
pub use serve::{ask, serve_page, serve_status};
pub use view::{phase, view};
