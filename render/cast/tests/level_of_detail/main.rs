//! Level of detail of the default caster: calmer than one point a pixel, and nowhere worse.

mod afar;
mod calm;
mod colours;
mod ground;
mod history;
mod quality;
mod seen;
mod truth;
mod views;
mod walls;
