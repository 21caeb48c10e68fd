//! All passes of a picture, in order: key light's map, map from beneath, backdrop, figure.

use super::albedo::Albedo;
use super::backdrop::Backdrop;
use super::depth_map::DepthMap;
use super::drawn_surface::DrawnSurface;
use super::figure::{self, Figure};
use super::globals::Globals;
use super::light::{BELOW_MAP, KEY_MAP};
use super::scene::Scene;
use super::targets::{Targets, texture_bytes};
use super::view::View;
use wgpu::*;

/// Draws one figure into textures of one format.
pub struct Renderer {
    device: Device,
    queue: Queue,
    format: TextureFormat,
    figure_layout: BindGroupLayout,
    globals: Buffer,
    globals_group: BindGroup,
    key_map: DepthMap,
    below_map: DepthMap,
    backdrop: Backdrop,
    figure_pipeline: RenderPipeline,
    line_pipeline: RenderPipeline,
    figure: Figure,
    albedo_bytes: u64,
    targets: Option<Targets>,
}

impl Renderer {
    /// Prepares to draw `surface`, over a body with `vertex_count` vertices on its finest level, into textures of `format`, to which
    /// the shaders write sRGB-encoded numbers: no `…Srgb` format, which would encode them twice.
    /// Its albedo is white until [`Self::set_albedo`].
    pub fn new(
        device: Device,
        queue: Queue,
        format: TextureFormat,
        surface: &DrawnSurface,
        vertex_count: usize,
    ) -> Self {
        let figure_layout = figure::group_layout(&device);
        let globals_layout = globals_layout(&device);
        let key_map = DepthMap::new(&device, "key light's map", KEY_MAP, &figure_layout);
        let below_map = DepthMap::new(&device, "map from beneath", BELOW_MAP, &figure_layout);
        let globals = device.create_buffer(&BufferDescriptor {
            label: Some("globals"),
            size: size_of::<Globals>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let albedo = Albedo::white(&device, &queue);
        let [figure_pipeline, line_pipeline] = figure::pipelines(&device, &globals_layout, &figure_layout, format);
        Self {
            globals_group: globals_group(&device, &globals_layout, &globals, &key_map, &below_map),
            backdrop: Backdrop::new(&device, &globals_layout, format),
            figure_pipeline,
            line_pipeline,
            figure: Figure::new(&device, &queue, &figure_layout, surface, vertex_count, &albedo),
            albedo_bytes: texture_bytes(albedo.view.texture()),
            targets: None,
            device,
            queue,
            format,
            figure_layout,
            globals,
            key_map,
            below_map,
        }
    }

    /// Replaces the figure's albedo.
    pub fn set_albedo(&mut self, albedo: &Albedo) {
        self.albedo_bytes = texture_bytes(albedo.view.texture());
        self.figure.set_albedo(&self.device, &self.figure_layout, albedo);
    }

    /// Whether `scene` asks for edges that [`Self::set_lines`] has not been given yet.
    pub fn wants_lines(&self, scene: &Scene) -> bool {
        scene.view == View::Wireframe && !self.figure.has_lines()
    }

    /// Makes the edges of `surface`, the one that is drawn, ready to draw.
    pub fn set_lines(&mut self, surface: &DrawnSurface) {
        self.figure.set_lines(&self.device, &self.queue, surface);
    }

    /// The buffer that the figure is drawn from: 16 bytes a vertex, position and octahedral normal. Whoever fills it on the GPU tells
    /// the scene where the figure is with [`Scene::set_outline`].
    pub fn vertices(&self) -> &Buffer {
        self.figure.vertices()
    }

    /// Bytes of its buffers and textures.
    pub fn bytes(&self) -> u64 {
        let maps = [&self.key_map, &self.below_map].map(|map| texture_bytes(map.view.texture()));
        let targets = self.targets.as_ref().map_or(0, Targets::bytes);
        self.figure.bytes() + self.globals.size() + maps.iter().sum::<u64>() + self.albedo_bytes + targets
    }

    /// Draws a picture of `scene`, `size` = (width, height) pixels, neither zero, into `target`.
    pub fn draw(&mut self, target: &TextureView, size: [u32; 2], scene: &Scene) {
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            self.targets = Some(Targets::new(&self.device, size, self.format));
        }
        let Some(targets) = &self.targets else { return };
        let aspect = size[0] as f32 / size[1] as f32;
        self.figure.update(&self.queue, scene);
        let globals = scene.globals(aspect);
        self.queue.write_buffer(&self.globals, 0, bytemuck::bytes_of(&globals));

        let mut encoder = self.device.create_command_encoder(&CommandEncoderDescriptor { label: Some("picture") });
        self.key_map.draw(&self.queue, &mut encoder, &self.figure, scene.coarser(), globals.key_from_world);
        self.below_map.draw(&self.queue, &mut encoder, &self.figure, scene.coarser(), globals.below_from_world);
        {
            let mut pass = targets.begin_pass(&mut encoder, target);
            pass.set_bind_group(0, &self.globals_group, &[]);
            self.backdrop.draw(&mut pass);
            pass.set_pipeline(&self.figure_pipeline);
            self.figure.draw(&mut pass, scene.coarser());
            if scene.view == View::Wireframe {
                pass.set_pipeline(&self.line_pipeline);
                self.figure.draw_lines(&mut pass, scene.coarser_lines());
            }
        }
        self.queue.submit([encoder.finish()]);
    }

    /// The device, for making textures.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The queue.
    pub fn queue(&self) -> &Queue {
        &self.queue
    }
}

fn globals_layout(device: &Device) -> BindGroupLayout {
    let depth_map = BindingType::Texture {
        sample_type: TextureSampleType::Depth,
        view_dimension: TextureViewDimension::D2,
        multisampled: false,
    };
    let depths = BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable: false },
        view_dimension: TextureViewDimension::D2,
        multisampled: false,
    };
    let uniform =
        BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
    let entry = |binding, visibility, ty| BindGroupLayoutEntry { binding, visibility, ty, count: None };
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("globals"),
        entries: &[
            entry(0, ShaderStages::VERTEX_FRAGMENT, uniform),
            entry(1, ShaderStages::FRAGMENT, depth_map),
            entry(2, ShaderStages::FRAGMENT, depths),
            entry(3, ShaderStages::FRAGMENT, depths),
            entry(4, ShaderStages::FRAGMENT, BindingType::Sampler(SamplerBindingType::Comparison)),
        ],
    })
}

fn globals_group(
    device: &Device,
    layout: &BindGroupLayout,
    globals: &Buffer,
    key_map: &DepthMap,
    below_map: &DepthMap,
) -> BindGroup {
    let nearer = device.create_sampler(&SamplerDescriptor {
        label: Some("nearer"),
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        compare: Some(CompareFunction::LessEqual),
        ..Default::default()
    });
    device.create_bind_group(&BindGroupDescriptor {
        label: Some("globals"),
        layout,
        entries: &[
            BindGroupEntry { binding: 0, resource: globals.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&key_map.view) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&key_map.view) },
            BindGroupEntry { binding: 3, resource: BindingResource::TextureView(&below_map.view) },
            BindGroupEntry { binding: 4, resource: BindingResource::Sampler(&nearer) },
        ],
    })
}
