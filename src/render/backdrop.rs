//! What is behind the figure: a soft gradient, and a floor that fades into it and takes the shadows.

use super::{shader_sources, targets};
use wgpu::*;

/// The two pipelines.
pub(super) struct Backdrop {
    sky: RenderPipeline,
    floor: RenderPipeline,
}

impl Backdrop {
    pub fn new(device: &Device, globals: &BindGroupLayout, format: TextureFormat) -> Self {
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("backdrop"),
            source: ShaderSource::Wgsl(shader_sources::BACKDROP.into()),
        });
        let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("backdrop"),
            bind_group_layouts: &[Some(globals)],
            immediate_size: 0,
        });
        let pipeline = |vertex, fragment, topology, blend| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some(vertex),
                layout: Some(&layout),
                vertex: VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: PrimitiveState { topology, ..Default::default() },
                depth_stencil: Some(targets::depth_state(false)),
                multisample: targets::multisample(),
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &[Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let blend = Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        Self {
            sky: pipeline("sky_vertex", "sky_fragment", PrimitiveTopology::TriangleList, None),
            floor: pipeline("floor_vertex", "floor_fragment", PrimitiveTopology::TriangleStrip, blend),
        }
    }

    /// Draws both; group 0 is bound.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        pass.set_pipeline(&self.sky);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&self.floor);
        pass.draw(0..4, 0..1);
    }
}
