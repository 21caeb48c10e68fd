//! Closest points between scan and body, in both directions: robust, with normals, asymmetric because cloth lies outside the skin.

use super::articulated::{ArticulatedBody, Posed};
use super::system::System;
use crate::closest::ClosestPoint;
use crate::nearest::NearestPoints;
use crate::normals::principal_frame;
use crate::sampling::generator;
use crate::sequence::{Camera, Frame};
use crate::visibility::visible_vertices;
use crease::laplacian::sample_elimination;
use crease::mesh::mixed_voronoi_areas;
use glam::Vec3A;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::num::NonZero;

/// Points kept of a scan.
const POINT_COUNT: usize = 5_000;
/// Neighbours whose plane is a point's normal, where a scan has none.
const NORMAL_NEIGHBOURS: NonZero<usize> = NonZero::new(20).expect("not zero");
/// Vertices of the body that look for the scan, spread evenly.
const SURFACE_SAMPLE_COUNT: usize = 1_000;
/// Joints whose surface is bare: there the scan is skin.
const BARE: [&str; 7] = ["head", "left_wrist", "right_wrist", "left_hand", "right_hand", "left_foot", "right_foot"];
/// Joints whose surface is a forearm or a hand.
const FOREARMS: [&str; 6] = ["left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_hand", "right_hand"];
/// Weight of a scan point outside the skin where cloth may be. Inside, and on bare skin, it is 1.
const OUTSIDE_WEIGHT: f32 = 0.25;
/// Weight of the tangential part of a gap from body to scan. From scan to body the gap is along the normal anyway.
const TANGENTIAL: f32 = 0.1;
/// Weight of the direction from body to scan.
const BODY_TO_SCAN: f64 = 0.5;
/// A forearm that the camera should see lies before the background where the scan is farther aside than this, metres …
const ASIDE: f32 = 0.03;
/// … and is pulled back, the less the farther beyond this, metres.
const ASIDE_REACH: f32 = 0.3;
/// Points further away than so many reaches are no counterpart.
const CUTOFF: f32 = 3.0;

/// A scan made ready for registration.
pub struct Cloud {
    /// A random choice of the scan's points, in random order, metres.
    pub points: Vec<Vec3A>,
    /// Unit normals.
    pub normals: Vec<Vec3A>,
    /// Whether normals point outward; else their sign is arbitrary.
    oriented: bool,
    weights: Vec<f32>,
    nearest: NearestPoints,
    /// The camera, where the scan is what one sees.
    pub camera: Option<Camera>,
}

impl Cloud {
    /// Takes what registration needs of a frame.
    pub fn new(frame: &Frame) -> Self {
        let mut order: Vec<usize> = (0..frame.points.len()).collect();
        order.shuffle(&mut generator(frame.index as u64));
        order.truncate(POINT_COUNT);
        let points: Vec<Vec3A> = order.iter().map(|&i| frame.points[i]).collect();
        let normals = match &frame.normals {
            Some(normals) => order.iter().map(|&i| normals[i]).collect(),
            None => {
                let all = NearestPoints::new(&frame.points);
                let normal = |&p: &Vec3A| principal_frame(&frame.points, p, &all.several(p, NORMAL_NEIGHBOURS))[2];
                points.par_iter().with_min_len(256).map(normal).collect()
            }
        };
        Self {
            nearest: NearestPoints::new(&points),
            weights: order.iter().map(|&i| frame.weights[i]).collect(),
            points,
            normals,
            oriented: frame.normals.is_some(),
            camera: frame.camera.clone(),
        }
    }

    fn cosine(&self, point: usize, normal: Vec3A) -> f32 {
        let cosine = self.normals[point].dot(normal);
        if self.oriented { cosine } else { cosine.abs() }
    }
}

/// What is constant of the body's surface.
#[derive(Clone)]
pub struct Surface {
    /// Vertices that look for the scan.
    samples: Vec<u32>,
    /// Weight of scan points outside each vertex.
    outside: Vec<f32>,
    /// Whether a vertex belongs to a forearm or hand. These alone vanish behind the trunk and come out where nothing is; elsewhere a gap in
    /// the scan is more likely hair or a shoe that the sensor missed.
    is_forearm: Vec<bool>,
}

impl Surface {
    /// Prepares the surface of a body.
    pub fn new(body: &ArticulatedBody) -> Self {
        let body = body.body;
        let mut areas = vec![0.0; body.template.len()];
        mixed_voronoi_areas(&body.template, &body.triangles, &mut areas);
        let bare: Vec<bool> = body.joint_names.iter().map(|name| BARE.contains(&name.as_str())).collect();
        let outside = body.skin.joints.iter().zip(&body.skin.weights).map(|(joints, weights)| {
            let share: f32 =
                joints.iter().zip(weights).filter(|&(&joint, _)| bare[joint as usize]).map(|(_, w)| w).sum();
            OUTSIDE_WEIGHT + (1.0 - OUTSIDE_WEIGHT) * share
        });
        Self {
            samples: sample_elimination(&body.template, areas.iter().sum(), SURFACE_SAMPLE_COUNT),
            outside: outside.collect(),
            is_forearm: body
                .skin
                .joints
                .iter()
                .map(|joints| FOREARMS.contains(&body.joint_names[joints[0] as usize].as_str()))
                .collect(),
        }
    }
}

impl Surface {
    /// The surface of a body whose clothes are known: nothing else lies outside.
    pub fn dressed(body: &ArticulatedBody) -> Self {
        let skin = Self::new(body);
        Self { outside: vec![1.0; skin.outside.len()], ..skin }
    }
}

/// How far and how strictly counterparts are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Scan points used.
    pub point_count: usize,
    /// Distance at which a gap begins to count less (Geman–McClure), metres.
    pub reach: f32,
    /// Counterparts whose normals make a smaller cosine are none.
    pub least_cosine: f32,
}

/// How well a body fits a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Closeness {
    /// Robust energy of both directions, m².
    pub energy: f64,
    /// Mean distance from scan points to the body, metres; none counts more than the cutoff.
    pub distance: f64,
}

/// A weighted pull of a surface point along a gap.
struct Pull {
    vertices: [u32; 3],
    weights: [f32; 3],
    normal: Vec3A,
    gap: Vec3A,
    weight: f32,
    tangential: f32,
}

/// Adds both directions to a new system of `unknowns`.
pub fn scan_system(
    posed: &Posed,
    surface: &Surface,
    triangles: &[[u32; 3]],
    cloud: &Cloud,
    search: &Search,
    unknowns: usize,
) -> anyhow::Result<(System, Closeness)> {
    let count = search.point_count.min(cloud.points.len());
    let hits = ClosestPoint::new(&posed.vertices, triangles)?.query_all(&cloud.points[..count]);
    let mut closeness = Closeness::default();
    let mut pulls = Vec::with_capacity(count + surface.samples.len());
    let scan_share = 1.0 / count as f32;
    let limit = CUTOFF * search.reach;
    let robust = |gap: Vec3A| 1.0 / (1.0 + gap.length_squared() / (search.reach * search.reach)).powi(2);
    let saturated = |gap: Vec3A| {
        let squared = f64::from(gap.length_squared());
        squared / (1.0 + squared / f64::from(search.reach * search.reach))
    };
    for (index, hit) in hits.iter().enumerate() {
        let corners = triangles[hit.triangle as usize];
        let gap = cloud.points[index] - hit.interpolate(triangles, &posed.vertices);
        let normal = hit.interpolate(triangles, &posed.normals).normalize_or_zero();
        let factor = if gap.dot(normal) > 0.0 { hit.interpolate(triangles, &surface.outside) } else { 1.0 };
        let weight = cloud.weights[index] * factor * scan_share;
        closeness.energy += f64::from(weight) * saturated(gap);
        closeness.distance += f64::from(gap.length().min(limit) * scan_share);
        if gap.length() < limit && cloud.cosine(index, normal) > search.least_cosine {
            let weight = weight * robust(gap);
            pulls.push(Pull { vertices: corners, weights: hit.barycentric, normal, gap, weight, tangential: 0.0 });
        }
    }

    let seen = cloud.camera.as_ref().map(|camera| visible_vertices(camera, &posed.vertices, triangles));
    let is_seen = |vertex: u32| seen.as_ref().is_none_or(|seen| seen[vertex as usize]);
    let samples: Vec<u32> = surface.samples.iter().copied().filter(|&vertex| is_seen(vertex)).collect();
    let sample_share = BODY_TO_SCAN as f32 / samples.len().max(1) as f32;
    for &vertex in &samples {
        let (position, normal) = (posed.vertices[vertex as usize], posed.normals[vertex as usize]);
        let point = cloud.nearest.one(position).index as usize;
        let gap = cloud.points[point] - position;
        if let Some(camera) = cloud.camera.as_ref().filter(|_| surface.is_forearm[vertex as usize]) {
            // The scan has nothing where the body should be seen: an occluded limb that came out on the wrong side.
            let aside = gap.reject_from((position - camera.position()).normalize_or(Vec3A::Z));
            if aside.length() > ASIDE {
                let weight = sample_share / (1.0 + aside.length_squared() / (ASIDE_REACH * ASIDE_REACH)).powi(2);
                let (normal, weights) = (aside.normalize(), [1.0, 0.0, 0.0]);
                closeness.energy += f64::from(weight * aside.length_squared());
                pulls.push(Pull { vertices: [vertex; 3], weights, normal, gap: aside, weight, tangential: 0.0 });
                continue;
            }
        }
        let factor = if gap.dot(normal) > 0.0 { surface.outside[vertex as usize] } else { 1.0 };
        let weight = factor * sample_share;
        closeness.energy += f64::from(weight) * saturated(gap);
        if gap.length() < limit && cloud.cosine(point, normal) > search.least_cosine {
            let weight = weight * robust(gap);
            pulls.push(Pull {
                vertices: [vertex; 3],
                weights: [1.0, 0.0, 0.0],
                normal,
                gap,
                weight,
                tangential: TANGENTIAL,
            });
        }
    }

    let system = pulls
        .par_chunks(256)
        .map(|pulls| {
            let mut system = System::new(unknowns);
            pulls.iter().for_each(|pull| add(posed, pull, &mut system));
            system
        })
        .reduce(|| System::new(unknowns), |a, b| a.merge(&b));
    Ok((system, closeness))
}

fn add(posed: &Posed, pull: &Pull, system: &mut System) {
    let motion = posed.motion(&pull.vertices, &pull.weights);
    let (first, second) = pull.normal.any_orthonormal_pair();
    for (direction, share) in [(pull.normal, 1.0), (first, pull.tangential), (second, pull.tangential)] {
        if share > 0.0 {
            let row = posed.row(&motion, direction);
            system.add(&row, -f64::from(direction.dot(pull.gap)), f64::from(pull.weight * share));
        }
    }
}
