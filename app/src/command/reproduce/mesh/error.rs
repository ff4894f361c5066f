//! Why a ground cannot be drawn as triangles.

use sandtable_stage::GpuError;

/// Why a ground cannot be drawn as triangles.
#[derive(Debug, thiserror::Error)]
pub(super) enum MeshError {
    /// A buffer is larger than the adapter's.
    #[error(
        "{cols} x {rows} posts need {bytes} bytes for their {part}, and the graphics adapter's \
         buffers hold {limit} (max_buffer_size); take a terrain of fewer posts (--size)"
    )]
    Buffer {
        /// Posts from west to east.
        cols: u32,
        /// Posts from south to north.
        rows: u32,
        /// What the buffer is for.
        part: &'static str,
        /// What it would take.
        bytes: u64,
        /// What it may take.
        limit: u64,
    },
    /// The ground has more posts along a side than the adapter's textures have texels.
    #[error(
        "{cols} x {rows} posts need a texel each, and the graphics adapter's textures have \
         {longest} a side (max_texture_dimension_2d); take a terrain of fewer posts (--size)"
    )]
    Texture {
        /// Posts from west to east.
        cols: u32,
        /// Posts from south to north.
        rows: u32,
        /// Texels that a texture may have along a side.
        longest: u32,
    },
    /// Nothing can be seen.
    #[error(
        "the view has no pixels, or its eye lies in its window's plane; move the eye off the \
         window"
    )]
    View,
    /// The image is larger than the adapter's.
    #[error(transparent)]
    Size(#[from] GpuError),
}
