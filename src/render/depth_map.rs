//! The figure's depth as a light sees it: the key light's shadow map, and the map from beneath the floor.

use super::figure::{self, Figure};
use super::light::MapSize;
use super::shader_sources;
use glam::Mat4;
use wgpu::*;

/// A light sees less than ten metres, so a step is a seventh of a millimetre: a tenth of what shadows are offset by.
const FORMAT: TextureFormat = TextureFormat::Depth16Unorm;

/// A square depth texture and the pass that fills it.
pub(super) struct DepthMap {
    label: &'static str,
    /// For sampling.
    pub view: TextureView,
    /// How many levels coarser than the finest the figure may be here.
    coarser: usize,
    matrix: Buffer,
    group: BindGroup,
    pipeline: RenderPipeline,
}

impl DepthMap {
    pub fn new(device: &Device, label: &'static str, size: MapSize, figure_layout: &BindGroupLayout) -> Self {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(label),
            size: Extent3d { width: size.texels, height: size.texels, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let matrix = device.create_buffer(&BufferDescriptor {
            label: Some(label),
            size: size_of::<Mat4>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &[BindGroupLayoutEntry {
                binding: 0,
                visibility: ShaderStages::VERTEX,
                ty: BindingType::Buffer {
                    ty: BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some(label),
            layout: &layout,
            entries: &[BindGroupEntry { binding: 0, resource: matrix.as_entire_binding() }],
        });
        let pipeline = pipeline(device, label, &layout, figure_layout);
        Self {
            label,
            view: texture.create_view(&TextureViewDescriptor::default()),
            coarser: size.coarser,
            matrix,
            group,
            pipeline,
        }
    }

    /// Fills the map with `figure`, `coarser` levels coarser at least, seen through `clip_from_world`.
    pub fn draw(
        &self,
        queue: &Queue,
        encoder: &mut CommandEncoder,
        figure: &Figure,
        coarser: usize,
        clip_from_world: Mat4,
    ) {
        queue.write_buffer(&self.matrix, 0, bytemuck::bytes_of(&clip_from_world));
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some(self.label),
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        figure.draw(&mut pass, self.coarser.max(coarser));
    }
}

fn pipeline(device: &Device, label: &str, layout: &BindGroupLayout, figure_layout: &BindGroupLayout) -> RenderPipeline {
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source: ShaderSource::Wgsl(shader_sources::DEPTH_MAP.into()),
    });
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &[Some(layout), Some(figure_layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(figure::vertex_layout(&figure::VERTEX_ATTRIBUTES[..1]))],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Less),
            stencil: StencilState::default(),
            bias: DepthBiasState::default(),
        }),
        multisample: MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
