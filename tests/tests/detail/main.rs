//! Level of detail.

mod hard;
mod places;
