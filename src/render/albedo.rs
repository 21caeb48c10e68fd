//! The figure's base colour: an sRGB texture with mipmaps.

use super::shader_sources;
use wgpu::*;

/// Most texels that one look at the texture may average where it is seen at a slant.
pub const ANISOTROPY: u16 = 8;

/// Texels are sRGB; shaders read linear.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// A texture, and how to sample it.
pub struct Albedo {
    pub(super) view: TextureView,
    pub(super) sampler: Sampler,
}

impl Albedo {
    /// One white texel, for figures coloured by their vertices.
    pub fn white(device: &Device, queue: &Queue) -> Self {
        Self::from_rgba(device, queue, 1, 1, &[255; 4])
    }

    /// From sRGB `pixels`, four bytes each, row by row from the top.
    pub fn from_rgba(device: &Device, queue: &Queue, width: u32, height: u32, pixels: &[u8]) -> Self {
        let texture = texture(device, width, height);
        queue.write_texture(
            texture.as_image_copy(),
            pixels,
            TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None },
            texture.size(),
        );
        Self::finish(device, queue, &texture)
    }

    /// From a picture that the browser decoded.
    #[cfg(all(target_arch = "wasm32", feature = "web"))]
    pub fn from_bitmap(device: &Device, queue: &Queue, bitmap: web_sys::ImageBitmap) -> Self {
        let texture = texture(device, bitmap.width(), bitmap.height());
        queue.copy_external_image_to_texture(
            &CopyExternalImageSourceInfo {
                source: ExternalImageSource::ImageBitmap(bitmap),
                origin: Origin2d::ZERO,
                flip_y: false,
            },
            CopyExternalImageDestInfo {
                texture: &texture,
                mip_level: 0,
                origin: Origin3d::ZERO,
                aspect: TextureAspect::All,
                color_space: PredefinedColorSpace::Srgb,
                premultiplied_alpha: false,
            },
            texture.size(),
        );
        Self::finish(device, queue, &texture)
    }

    fn finish(device: &Device, queue: &Queue, texture: &Texture) -> Self {
        make_mipmaps(device, queue, texture);
        let sampler = device.create_sampler(&SamplerDescriptor {
            label: Some("albedo"),
            address_mode_u: AddressMode::Repeat,
            address_mode_v: AddressMode::Repeat,
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            mipmap_filter: MipmapFilterMode::Linear,
            // One texel looks the same from everywhere, and drivers in software divide by how fast coordinates change.
            anisotropy_clamp: if texture.mip_level_count() == 1 { 1 } else { ANISOTROPY },
            ..Default::default()
        });
        Self { view: texture.create_view(&TextureViewDescriptor::default()), sampler }
    }
}

fn texture(device: &Device, width: u32, height: u32) -> Texture {
    device.create_texture(&TextureDescriptor {
        label: Some("albedo"),
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: width.max(height).max(1).ilog2() + 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: FORMAT,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

fn make_mipmaps(device: &Device, queue: &Queue, texture: &Texture) {
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: Some("mipmap"),
        source: ShaderSource::Wgsl(shader_sources::MIPMAP.into()),
    });
    let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("mipmap"),
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: None,
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let sampler = device.create_sampler(&SamplerDescriptor {
        label: Some("mipmap"),
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..Default::default()
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: Some("mipmap") });
    for level in 1..texture.mip_level_count() {
        let view = |level| {
            texture.create_view(&TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("mipmap"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&view(level - 1)) },
                BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) },
            ],
        });
        let target = view(level);
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("mipmap"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
    queue.submit([encoder.finish()]);
}
