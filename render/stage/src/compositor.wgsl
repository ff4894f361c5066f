// One pass over the frame: which eye's image, and which place in it, each pixel shows.
// The same arithmetic as compose.rs.

struct Composition {
    frame: vec2<u32>,
}

// Set for each pipeline: software adapters would walk through the other modes' branches too.
override mode: u32;
// Whether the target encodes linear values as sRGB by itself.
override target_encodes: bool;

const MONO: u32 = 0u;
const SIDE_BY_SIDE: u32 = 1u;
const TOP_BOTTOM: u32 = 2u;

@group(0) @binding(0) var<uniform> composition: Composition;
@group(0) @binding(1) var left: texture_2d<f32>;
@group(0) @binding(2) var right: texture_2d<f32>;

// One triangle that covers the frame.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}

struct Neighbours {
    first: i32,
    second: i32,
    along: f32,
}

fn neighbours(share: f32, count: u32) -> Neighbours {
    let last = f32(count - 1u);
    var place = clamp(share * f32(count) - 0.5, 0.0, last);
    let nearest = floor(place + 0.5);
    if abs(place - nearest) < 1.0 / 256.0 {
        place = nearest;
    }
    let first = floor(place);
    return Neighbours(i32(first), i32(min(first + 1.0, last)), place - first);
}

fn sample(eye: texture_2d<f32>, place: vec2<f32>) -> vec3<f32> {
    let size = textureDimensions(eye);
    let x = neighbours(place.x, size.x);
    let y = neighbours(place.y, size.y);
    let a = textureLoad(eye, vec2<i32>(x.first, y.first), 0).rgb;
    let b = textureLoad(eye, vec2<i32>(x.second, y.first), 0).rgb;
    let c = textureLoad(eye, vec2<i32>(x.first, y.second), 0).rgb;
    let d = textureLoad(eye, vec2<i32>(x.second, y.second), 0).rgb;
    return mix(mix(a, b, x.along), mix(c, d, x.along), y.along);
}

fn linear(encoded: vec3<f32>) -> vec3<f32> {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, low, encoded <= vec3<f32>(0.04045));
}

@fragment
fn shade(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let size = vec2<f32>(composition.frame);
    let pixel = position.xy;
    var colour: vec3<f32>;
    if mode == MONO {
        colour = sample(left, pixel / size);
    } else if mode == SIDE_BY_SIDE {
        let middle = f32(composition.frame.x / 2u);
        if pixel.x < middle {
            colour = sample(left, pixel / vec2<f32>(middle, size.y));
        } else {
            let part = vec2<f32>(size.x - middle, size.y);
            colour = sample(right, (pixel - vec2<f32>(middle, 0.0)) / part);
        }
    } else if mode == TOP_BOTTOM {
        let middle = f32(composition.frame.y / 2u);
        if pixel.y < middle {
            colour = sample(left, pixel / vec2<f32>(size.x, middle));
        } else {
            let part = vec2<f32>(size.x, size.y - middle);
            colour = sample(right, (pixel - vec2<f32>(0.0, middle)) / part);
        }
    } else {
        colour = vec3<f32>(sample(left, pixel / size).r, sample(right, pixel / size).gb);
    }
    if target_encodes {
        colour = linear(colour);
    }
    return vec4<f32>(colour, 1.0);
}
