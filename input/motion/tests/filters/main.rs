//! Filters and predictions on streams whose answers are known.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod any_input;
mod constant_velocity;
mod gaps_and_losses;
mod noise_and_steps;
mod rates;
mod settings;
mod streams;
mod worked_numbers;
