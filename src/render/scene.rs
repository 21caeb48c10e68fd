//! What there is to see, made ready for whatever draws it: packed vertices, camera, light, colours. No device.

use super::camera::OrbitCamera;
use super::environment::Environment;
use super::globals::{Globals, Theme};
use super::light::Bounds;
use super::view::View;
use crease_posing::surface_vertex::{SurfaceVertex, pack_surface};
use glam::Vec3A;
use std::sync::atomic::{AtomicU32, Ordering};

/// Beyond each of these, metres, a wireframe is a level coarser.
const WIREFRAME_DISTANCES: [f32; 2] = [0.9, 1.8];

/// A figure, and how it is looked at.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: OrbitCamera,
    /// Colours around the figure.
    pub theme: Theme,
    /// Light on the figure.
    pub environment: Environment,
    /// What the surface's colours tell.
    pub view: View,
    vertices: Vec<SurfaceVertex>,
    coarser: usize,
    bounds: Bounds,
    revision: u32,
}

impl Default for Scene {
    /// No figure yet, the first view, a pale studio.
    fn default() -> Self {
        let bounds = Bounds::of(&[]);
        Self {
            camera: OrbitCamera::default(),
            theme: Theme::LIGHT,
            environment: Environment::STUDIO,
            view: View::Lit,
            vertices: Vec::new(),
            coarser: 0,
            bounds,
            revision: 0,
        }
    }
}

impl Scene {
    /// Takes the figure's positions (metres) and unit normals, one each for every vertex of the body, in the body's order, on the level
    /// `coarser` levels below the finest.
    pub fn set_figure(&mut self, positions: &[Vec3A], normals: &[Vec3A], coarser: usize) {
        self.coarser = coarser;
        self.bounds = Bounds::of(positions);
        pack_surface(positions, normals, &mut self.vertices);
        self.revision = next_revision();
    }

    /// [`Self::set_figure`] with a number for each vertex in place of its normal, for [`View::Values`].
    pub fn set_figure_of_values(&mut self, positions: &[Vec3A], values: &[f32], coarser: usize) {
        self.coarser = coarser;
        self.bounds = Bounds::of(positions);
        self.vertices.clear();
        let pairs = positions.iter().zip(values);
        self.vertices.extend(pairs.map(|(&position, &value)| SurfaceVertex::of_value(position, value)));
        self.revision = next_revision();
    }

    /// The figure is posed on the GPU, `coarser` levels below the finest; the box of `points` (metres) holds it.
    pub fn set_outline(&mut self, points: &[Vec3A], coarser: usize) {
        self.bounds = Bounds::of(points);
        self.vertices.clear();
        self.coarser = coarser;
        self.revision = next_revision();
    }

    /// The figure's vertices as shaders read them.
    pub fn vertices(&self) -> &[SurfaceVertex] {
        &self.vertices
    }

    /// How many levels coarser than the finest the figure is.
    pub fn coarser(&self) -> usize {
        self.coarser
    }

    /// How many levels coarser than the finest the edges of a wireframe are: from afar those of the finest level would be one dark shape.
    pub fn coarser_lines(&self) -> usize {
        let distance = self.camera.orbit_now().distance;
        self.coarser + WIREFRAME_DISTANCES.iter().filter(|&&metres| distance > metres).count()
    }

    /// Another number for every figure that was set, in this scene or another; 0 before the first.
    pub fn revision(&self) -> u32 {
        self.revision
    }

    /// What all passes of a picture of `aspect` = width / height share.
    pub fn globals(&self, aspect: f32) -> Globals {
        Globals::new(&self.camera, aspect, self.bounds, &self.theme, &self.environment, self.view)
    }
}

/// Whoever draws several scenes must not take one's figure for another's.
fn next_revision() -> u32 {
    static LAST: AtomicU32 = AtomicU32::new(0);
    LAST.fetch_add(1, Ordering::Relaxed).wrapping_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_figure_replaces_the_old_one_and_changes_the_revision() {
        let mut scene = Scene::default();
        scene.set_figure(&[Vec3A::ZERO, Vec3A::ONE], &[Vec3A::Y; 2], 0);
        let first = scene.revision();
        scene.set_figure(&[Vec3A::X], &[Vec3A::Y], 0);
        assert_ne!(scene.revision(), first);
        assert_eq!(scene.vertices(), [SurfaceVertex::new(Vec3A::X, Vec3A::Y)]);
    }

    #[test]
    fn figures_of_two_scenes_are_told_apart() {
        let [first, second] = std::array::from_fn(|_| {
            let mut scene = Scene::default();
            scene.set_figure(&[Vec3A::ZERO], &[Vec3A::Y], 0);
            scene.revision()
        });
        assert_ne!(first, second);
    }

    #[test]
    fn a_wireframe_is_coarser_from_afar() {
        let mut scene = Scene::default();
        scene.set_figure(&[Vec3A::ZERO], &[Vec3A::Y], 1);
        let coarser = |scene: &mut Scene, metres| {
            scene.camera.set_orbit(None, None, Some(metres), 1.0);
            scene.camera.jump();
            scene.coarser_lines()
        };
        assert_eq!([0.5, 1.0, 4.0].map(|metres| coarser(&mut scene, metres)), [1, 2, 3]);
    }

    #[test]
    fn the_light_covers_the_figure() {
        let mut scene = Scene::default();
        let far = Vec3A::new(3.0, 1.0, 0.0);
        scene.set_figure(&[far, far + Vec3A::ONE], &[Vec3A::Y; 2], 0);
        let seen = scene.globals(1.0).key_from_world.project_point3(far.into());
        assert!(seen.abs().max_element() <= 1.0001, "{seen}");
    }
}
