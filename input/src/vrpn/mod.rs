//! VRPN: other programs' trackers, buttons and analogs by TCP, and ours for other programs.
//!
//! ```text
//! socket --bytes--> Connection --what follows the cookie--> Inbound --Event--> VrpnStream --Sample--> hub
//!        <--bytes--            <-- descriptions, reports <-- driver (ping) or VrpnServer <--Sample--- hub
//! ```
//!
//! The protocol is that of version 07 of the Virtual-Reality Peripheral Network (Taylor et al.
//! 2001), its TCP part: a cookie, then messages of a header and a payload, big-endian. Numbers of
//! senders and types hold for one connection, so that all is known by its name.
//!
//! The wire (`cookie`, `message`, `description`, `report`) is pure functions, [`Inbound`] and
//! [`Connection`] are pure state; the driver's and the server's threads alone know sockets and
//! clocks. UDP is not spoken: a C++ client names our server `tcp://`, as in
//! `flock@tcp://host:3883`, and whoever offers UDP is let talk.

mod connection;
mod cookie;
mod description;
pub(crate) mod driver;
mod hand;
mod inbound;
mod message;
mod report;
mod server;
mod stream;

pub use connection::{Connection, LONGEST_QUEUE, QueueFull};
pub use cookie::{COOKIE, COOKIE_LENGTH, CookieError, check_cookie};
pub use description::{
    LONGEST_NAME, SENDER_DESCRIPTION, TYPE_DESCRIPTION, decode_name, write_description,
};
pub use driver::VrpnError;
pub use inbound::{Event, Inbound};
pub use message::{
    HEADER_LENGTH, Header, LONGEST_MESSAGE, LONGEST_PAYLOAD, LengthError, Stamp, write_message,
};
pub use report::{
    BigEndian, MOST_BUTTONS, MOST_CHANNELS, Report, ReportKind, Text, TrackerPose, TrackerVelocity,
};
pub use server::{ServerError, VrpnServer, VrpnServerSettings};
pub use stream::{ServerText, VrpnStream};
