// The ground's triangles in perspective, with its colours as a texture.

@group(0) @binding(0) var<uniform> clip_from_eye: mat4x4<f32>;
@group(0) @binding(1) var colours: texture_2d<f32>;
@group(0) @binding(2) var bilinear: sampler;

struct Post {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
}

// `offset` leads from the eye to the post, in world metres; `place` is the post's in the texture.
@vertex
fn project(@location(0) offset: vec3<f32>, @location(1) place: vec2<f32>) -> Post {
    return Post(clip_from_eye * vec4<f32>(offset, 1.0), place);
}

@fragment
fn shade(post: Post) -> @location(0) vec4<f32> {
    return vec4<f32>(textureSample(colours, bilinear, post.place).rgb, 1.0);
}
