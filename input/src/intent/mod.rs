//! Intents: from samples and what is pressed at the desk to what people mean.
//!
//! ```text
//! hub (poses, buttons, axes, hands) --+
//! DeskState (keys, mouse, gamepad) ---+--IntentMapper (the rig's [intents])--> IntentState
//! ```
//!
//! Whoever acts on an [`IntentState`] knows no device: it says that somebody grabs, not that the
//! second glove's thumb touches its index finger. The mapping is pure: the same samples at the same
//! times give the same intents.
//!
//! ```
//! use sandtable_config::{Intent, KeyCode, Rig};
//! use sandtable_input::intent::{DeskState, IntentMapper};
//! use sandtable_input::Hub;
//! use sandtable_pose::Nanos;
//!
//! let rig = Rig::builtin("workbench").unwrap();
//! let hub = Hub::for_rig(&rig);
//! let mut mapper = IntentMapper::new(&rig);
//! let mut desk = DeskState::default();
//! desk.keys.insert(KeyCode::KeyW);
//! desk.keys.insert(KeyCode::Space);
//! let state = mapper.update(Nanos(1), &hub, &desk);
//! assert_eq!(state.flight.forward, 1.0);
//! assert!(state.holds(Intent::Act) && !state.holds(Intent::Grab));
//! ```

mod mapper;
mod state;

pub use mapper::{DeskState, IntentMapper};
pub use state::IntentState;
