//! The figure: static drawn topology, this frame's vertices, albedo, and the pass that lights them.

use super::albedo::Albedo;
use super::drawn_surface::{DrawnSurface, DrawnVertex};
use super::scene::Scene;
use super::{shader_sources, targets};
use crate::filled_buffer::filled_buffer;
use crease_posing::surface_vertex::SurfaceVertex;
use std::mem::offset_of;
use wgpu::*;

/// Attributes of a [`DrawnVertex`], in its order.
pub(super) const VERTEX_ATTRIBUTES: [VertexAttribute; 3] = [
    VertexAttribute {
        format: VertexFormat::Uint32,
        offset: offset_of!(DrawnVertex, body_vertex) as u64,
        shader_location: 0,
    },
    VertexAttribute {
        format: VertexFormat::Float32x2,
        offset: offset_of!(DrawnVertex, texture_coordinates) as u64,
        shader_location: 1,
    },
    VertexAttribute {
        format: VertexFormat::Unorm8x4,
        offset: offset_of!(DrawnVertex, colour) as u64,
        shader_location: 2,
    },
];

/// Layout of the buffer of drawn vertices, for a pass that reads `attributes`.
pub(super) fn vertex_layout(attributes: &[VertexAttribute]) -> VertexBufferLayout<'_> {
    VertexBufferLayout { array_stride: size_of::<DrawnVertex>() as u64, step_mode: VertexStepMode::Vertex, attributes }
}

/// Group 1: vertices of the frame, albedo and its sampler.
pub(super) fn group_layout(device: &Device) -> BindGroupLayout {
    let entry = |binding, visibility, ty| BindGroupLayoutEntry { binding, visibility, ty, count: None };
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("figure"),
        entries: &[
            entry(
                0,
                ShaderStages::VERTEX,
                BindingType::Buffer {
                    ty: BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            entry(
                1,
                ShaderStages::FRAGMENT,
                BindingType::Texture {
                    sample_type: TextureSampleType::Float { filterable: true },
                    view_dimension: TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
            entry(2, ShaderStages::FRAGMENT, BindingType::Sampler(SamplerBindingType::Filtering)),
        ],
    })
}

/// The figure's buffers and bindings.
pub(super) struct Figure {
    drawn_vertices: Buffer,
    /// Triangles of each level and how many indices they are, level 0 first.
    levels: Vec<(Buffer, u32)>,
    /// Edges of each level and how many indices they are; none until they are wanted.
    lines: Vec<(Buffer, u32)>,
    vertices: Buffer,
    /// Revision of the scene whose vertices were uploaded last.
    revision: u32,
    group: BindGroup,
}

impl Figure {
    /// `vertex_count` is the body's, on the finest level.
    pub fn new(
        device: &Device,
        queue: &Queue,
        layout: &BindGroupLayout,
        surface: &DrawnSurface,
        vertex_count: usize,
        albedo: &Albedo,
    ) -> Self {
        let buffer = |label, contents, usage| filled_buffer(device, queue, label, contents, usage);
        let vertices = device.create_buffer(&BufferDescriptor {
            label: Some("figure: vertices of the frame"),
            size: (vertex_count * size_of::<SurfaceVertex>()) as u64,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let levels = surface.levels.iter().map(|triangles| {
            let indices = buffer("figure: triangles", bytemuck::cast_slice(triangles), BufferUsages::INDEX);
            (indices, 3 * triangles.len() as u32)
        });
        Self {
            drawn_vertices: buffer(
                "figure: drawn vertices",
                bytemuck::cast_slice(&surface.vertices),
                BufferUsages::VERTEX,
            ),
            levels: levels.collect(),
            lines: Vec::new(),
            group: group(device, layout, &vertices, albedo),
            vertices,
            revision: 0,
        }
    }

    /// Makes the edges of `surface`, the figure's, ready to draw.
    pub fn set_lines(&mut self, device: &Device, queue: &Queue, surface: &DrawnSurface) {
        let lines = (0..surface.levels.len()).map(|level| {
            let edges = surface.edges(level);
            let contents = bytemuck::cast_slice(&edges);
            let indices = filled_buffer(device, queue, "figure: edges", contents, BufferUsages::INDEX);
            (indices, 2 * edges.len() as u32)
        });
        self.lines = lines.collect();
    }

    /// Whether edges are ready to draw.
    pub fn has_lines(&self) -> bool {
        !self.lines.is_empty()
    }

    /// Replaces the albedo.
    pub fn set_albedo(&mut self, device: &Device, layout: &BindGroupLayout, albedo: &Albedo) {
        self.group = group(device, layout, &self.vertices, albedo);
    }

    /// Bytes of its buffers.
    pub fn bytes(&self) -> u64 {
        let indices = self.levels.iter().chain(&self.lines).map(|(buffer, _)| buffer.size());
        self.drawn_vertices.size() + self.vertices.size() + indices.sum::<u64>()
    }

    /// Where this frame's vertices lie.
    pub fn vertices(&self) -> &Buffer {
        &self.vertices
    }

    /// Uploads the vertices of `scene` unless they are there already.
    pub fn update(&mut self, queue: &Queue, scene: &Scene) {
        if self.revision != scene.revision() {
            if !scene.vertices().is_empty() {
                queue.write_buffer(&self.vertices, 0, bytemuck::cast_slice(scene.vertices()));
            }
            self.revision = scene.revision();
        }
    }

    /// Draws the triangles of the level `coarser` levels below the finest (of level 0 where there are fewer) with the pass's pipeline.
    pub fn draw(&self, pass: &mut RenderPass<'_>, coarser: usize) {
        self.draw_level(pass, &self.levels, coarser);
    }

    /// [`Self::draw`] for the edges.
    pub fn draw_lines(&self, pass: &mut RenderPass<'_>, coarser: usize) {
        self.draw_level(pass, &self.lines, coarser);
    }

    fn draw_level(&self, pass: &mut RenderPass<'_>, levels: &[(Buffer, u32)], coarser: usize) {
        let level = levels.len().saturating_sub(1 + coarser);
        let Some((indices, count)) = levels.get(level) else { return };
        pass.set_bind_group(1, &self.group, &[]);
        pass.set_vertex_buffer(0, self.drawn_vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed(0..*count, 0, 0..1);
    }
}

fn group(device: &Device, layout: &BindGroupLayout, vertices: &Buffer, albedo: &Albedo) -> BindGroup {
    device.create_bind_group(&BindGroupDescriptor {
        label: Some("figure"),
        layout,
        entries: &[
            BindGroupEntry { binding: 0, resource: vertices.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&albedo.view) },
            BindGroupEntry { binding: 2, resource: BindingResource::Sampler(&albedo.sampler) },
        ],
    })
}

/// The pipelines that draw the lit figure, and its edges.
pub(super) fn pipelines(
    device: &Device,
    globals: &BindGroupLayout,
    figure: &BindGroupLayout,
    format: TextureFormat,
) -> [RenderPipeline; 2] {
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: Some("figure"),
        source: ShaderSource::Wgsl(shader_sources::FIGURE.into()),
    });
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some("figure"),
        bind_group_layouts: &[Some(globals), Some(figure)],
        immediate_size: 0,
    });
    let pipeline = |vertex, fragment, primitive| {
        device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: VertexState {
                module: &module,
                entry_point: Some(vertex),
                compilation_options: Default::default(),
                buffers: &[Some(vertex_layout(&VERTEX_ATTRIBUTES))],
            },
            primitive,
            depth_stencil: Some(targets::depth_state(true)),
            multisample: targets::multisample(),
            fragment: Some(FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    let triangles = PrimitiveState { cull_mode: Some(Face::Back), ..Default::default() };
    let lines = PrimitiveState { topology: PrimitiveTopology::LineList, ..Default::default() };
    [pipeline("vertex", "fragment", triangles), pipeline("line_vertex", "line_fragment", lines)]
}
