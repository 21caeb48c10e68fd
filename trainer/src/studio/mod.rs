//! Pictures of figures without a screen, drawn as a page draws them, on whatever graphics adapter there is.

mod splats;

pub use splats::{Splats, splats};

use splats::CLAY;

use anyhow::{Context, ensure};
use crease::animate::Animator;
use crease::avatar::Avatar;
use crease::render::{Albedo, DrawnSurface, Renderer, Scene};
use image::RgbaImage;
use std::sync::mpsc;
use wgpu::*;

/// Shaders write sRGB-encoded numbers.
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// A device to draw with.
pub struct Studio {
    device: Device,
    queue: Queue,
    adapter: String,
}

impl Studio {
    /// Takes the strongest adapter there is, a software one if there is no other.
    ///
    /// Fails without any, and says what to install.
    pub fn open() -> anyhow::Result<Self> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
        let options =
            RequestAdapterOptions { power_preference: PowerPreference::HighPerformance, ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options)).context(
            "pictures need a graphics adapter, and there is none: a software one, such as Mesa's lavapipe (mesa-vulkan-drivers on Debian), will do",
        )?;
        let adapter_name = adapter.get_info().name;
        let (device, queue) = pollster::block_on(adapter.request_device(&DeviceDescriptor::default()))
            .with_context(|| format!("{adapter_name}: the graphics adapter gives no device"))?;
        Ok(Self { device, queue, adapter: adapter_name })
    }

    /// The adapter's name.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Makes `surface`, over a body of `vertex_count` vertices, ready to be drawn, in `texture` or else in its vertices' colours.
    pub fn figure(&self, surface: &DrawnSurface, vertex_count: usize, texture: Option<&RgbaImage>) -> Figure<'_> {
        let mut renderer = Renderer::new(self.device.clone(), self.queue.clone(), FORMAT, surface, vertex_count);
        if let Some(texture) = texture {
            let albedo = Albedo::from_rgba(&self.device, &self.queue, texture.width(), texture.height(), texture);
            renderer.set_albedo(&albedo);
        }
        Figure { studio: self, renderer, surface: surface.clone() }
    }
}

impl Studio {
    /// What `animator` poses, as a page shows it.
    pub fn dressed(&self, animator: &Animator) -> anyhow::Result<Figure<'_>> {
        let (surface, vertex_count) = drawn(animator)?;
        Ok(self.figure(&surface, vertex_count, decoded_texture(animator.avatar())?.as_ref()))
    }

    /// What `animator` poses, in clay.
    pub fn clay(&self, animator: &Animator) -> anyhow::Result<Figure<'_>> {
        let (mut surface, vertex_count) = drawn(animator)?;
        let [red, green, blue] = CLAY;
        surface.vertices.iter_mut().for_each(|vertex| vertex.colour = [red, green, blue, 255]);
        Ok(self.figure(&surface, vertex_count, None))
    }
}

/// What is drawn of an avatar, and how many vertices its finest level has.
fn drawn(animator: &Animator) -> anyhow::Result<(DrawnSurface, usize)> {
    let (avatar, subdivision) = (animator.avatar(), animator.subdivision());
    let surface = DrawnSurface::new(&avatar.appearance, animator.triangles(), &avatar.name)?;
    Ok((surface, subdivision.vertex_count(subdivision.level_count())))
}

/// A figure in a studio.
pub struct Figure<'a> {
    studio: &'a Studio,
    renderer: Renderer,
    surface: DrawnSurface,
}

impl Figure<'_> {
    /// A picture of `scene`, whose figure has this one's vertices, of `[width, height]` pixels.
    pub fn picture(&mut self, scene: &Scene, [width, height]: [u32; 2]) -> anyhow::Result<RgbaImage> {
        let device = &self.studio.device;
        let limit = device.limits().max_texture_dimension_2d;
        ensure!(
            (1..=limit).contains(&width) && (1..=limit).contains(&height),
            "size: expected 1 to {limit} pixels a side, found {width} × {height}"
        );
        if self.renderer.wants_lines(scene) {
            self.renderer.set_lines(&self.surface);
        }
        let target = device.create_texture(&TextureDescriptor {
            label: Some("picture"),
            size: Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.renderer.draw(&target.create_view(&TextureViewDescriptor::default()), [width, height], scene);
        self.studio.read(&target)
    }
}

impl Studio {
    /// The pixels of a texture of [`FORMAT`].
    fn read(&self, texture: &Texture) -> anyhow::Result<RgbaImage> {
        let Extent3d { width, height, .. } = texture.size();
        let row = 4 * width;
        let padded_row = row.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&BufferDescriptor {
            label: Some("pixels"),
            size: u64::from(padded_row) * u64::from(height),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&CommandEncoderDescriptor::default());
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        // The receiver outlives the call: it waits below.
        buffer.map_async(MapMode::Read, .., move |mapped| drop(sender.send(mapped)));
        self.device.poll(PollType::wait_indefinitely()).context("the graphics device does not finish")?;
        receiver.recv().context("the graphics device does not answer")?.context("the picture cannot be read back")?;
        let bytes = buffer.get_mapped_range(..).context("the picture cannot be read back")?;
        let pixels = bytes.chunks_exact(padded_row as usize).flat_map(|padded| &padded[..row as usize]).copied();
        RgbaImage::from_raw(width, height, pixels.collect()).context("the picture has another size than was asked for")
    }
}

/// The avatar's texture as pixels; none where its vertices have colours.
fn decoded_texture(avatar: &Avatar) -> anyhow::Result<Option<RgbaImage>> {
    let Some(texture) = &avatar.appearance.texture else { return Ok(None) };
    let decoded = image::load_from_memory(&texture.bytes);
    Ok(Some(decoded.with_context(|| format!("{}: the texture cannot be read", avatar.name))?.to_rgba8()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3A};

    /// Points on a sphere of 0.5 m about (0, 1, 0), red on its right (+x) half, blue on its left.
    fn ball() -> (Splats, Scene) {
        let directions = crate::shapes::sphere_points(4000, 1.0, 3);
        let points: Vec<Vec3A> = directions.iter().map(|&d| Vec3A::Y + 0.5 * d).collect();
        let normals: Vec<Vec3A> = directions.iter().map(|&d| d.normalize()).collect();
        let colour = |d: &Vec3A| if d.x > 0.0 { [230, 20, 20] } else { [20, 20, 230] };
        let colours: Vec<[u8; 3]> = directions.iter().map(colour).collect();
        let splats = splats(&points, &normals, Some(&colours), 0.03);
        let mut scene = Scene::default();
        scene.set_figure(&splats.positions, &splats.normals, 0);
        scene.camera.set_orbit(Some(0.0), Some(0.0), Some(4.0), 1.0);
        scene.camera.set_target(Some(glam::Vec3::Y));
        scene.camera.jump();
        (splats, scene)
    }

    #[test]
    fn right_is_red_and_left_is_blue_and_the_corner_is_backdrop() {
        let studio = Studio::open().unwrap();
        let (splats, scene) = ball();
        let mut figure = studio.figure(&splats.surface, splats.positions.len(), None);
        let picture = figure.picture(&scene, [101, 90]).unwrap();
        assert_eq!((picture.width(), picture.height()), (101, 90));
        let at = |share: Vec2| picture.get_pixel((share.x * 100.0) as u32, (share.y * 89.0) as u32).0;
        let [red, _, blue, _] = at(Vec2::new(0.58, 0.5));
        assert!(red > 2 * blue, "{red} {blue}");
        let [red, _, blue, _] = at(Vec2::new(0.42, 0.5));
        assert!(blue > 2 * red, "{red} {blue}");
        let corner = at(Vec2::new(0.02, 0.02));
        assert!(corner[..3].iter().all(|&channel| channel > 180), "{corner:?}");
        assert_eq!(picture, figure.picture(&scene, [101, 90]).unwrap(), "the same scene, the same picture");
    }

    #[test]
    fn a_picture_too_large_is_refused() {
        let studio = Studio::open().unwrap();
        let (splats, scene) = ball();
        let mut figure = studio.figure(&splats.surface, splats.positions.len(), None);
        let message = figure.picture(&scene, [100_000, 10]).unwrap_err().to_string();
        assert!(message.contains("100000"), "{message}");
        assert!(figure.picture(&scene, [0, 10]).is_err());
    }
}
