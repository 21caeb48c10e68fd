//! Multisampled colour and depth, remade when the picture's size changes.

use wgpu::*;

/// Samples a pixel.
pub const SAMPLE_COUNT: u32 = 4;
const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth24Plus;

/// Depth testing of a pass of the picture.
pub(super) fn depth_state(write: bool) -> DepthStencilState {
    DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(CompareFunction::LessEqual),
        stencil: StencilState::default(),
        bias: DepthBiasState::default(),
    }
}

/// Multisampling of a pass of the picture.
pub(super) fn multisample() -> MultisampleState {
    MultisampleState { count: SAMPLE_COUNT, ..Default::default() }
}

/// Bytes of a texture, its mipmaps included. A depth whose size WebGPU leaves open counts four a texel.
pub(super) fn texture_bytes(texture: &Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4)) * u64::from(texture.sample_count());
    let side = |length: u32, level: u32| u64::from((length >> level).max(1));
    let size = texture.size();
    (0..texture.mip_level_count()).map(|level| texel * side(size.width, level) * side(size.height, level)).sum()
}

/// The attachments for pictures of one size.
pub(super) struct Targets {
    pub size: [u32; 2],
    colour: TextureView,
    depth: TextureView,
}

impl Targets {
    pub fn new(device: &Device, size: [u32; 2], format: TextureFormat) -> Self {
        let view = |label, format| {
            let texture = device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLE_COUNT,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&TextureViewDescriptor::default())
        };
        Self { size, colour: view("colour", format), depth: view("depth", DEPTH_FORMAT) }
    }

    /// Bytes of its textures.
    pub fn bytes(&self) -> u64 {
        texture_bytes(self.colour.texture()) + texture_bytes(self.depth.texture())
    }

    /// Begins the pass that ends up, resolved, in `target`.
    pub fn begin_pass<'encoder>(
        &self,
        encoder: &'encoder mut CommandEncoder,
        target: &TextureView,
    ) -> RenderPass<'encoder> {
        encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &self.colour,
                depth_slice: None,
                resolve_target: Some(target),
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}
