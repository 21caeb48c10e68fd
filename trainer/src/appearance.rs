//! What is drawn on an avatar: a texture baked from the scans' colours, or colours of vertices.

use crate::closest::ClosestPoint;
use crate::context::{Sample, TrainContext};
use crate::targets::base_surface;
use crate::texture::{ColouredPoint, TextureAccumulator};
use anyhow::Context;
use crease::avatar::{Appearance, Texture};
use crease::body::TextureCoordinates;
use crease::colour::linear_from_srgb;
use crease::mesh::Triangle;
use crease::network::SurfaceFunction;
use image::codecs::jpeg::JpegEncoder;
use std::collections::HashMap;

/// Frames beyond the reference's neighbours, spread over all: they colour what those do not see.
const SPREAD_FRAME_COUNT: usize = 16;
/// Cloth slides over the body, so frames far apart in time blur each other's pattern: weights fall off over so many frames …
const REFERENCE_WIDTH: f32 = 1.2;
/// … down to this, which counts only where nothing better is.
const LEAST_WEIGHT: f32 = 1e-3;
const JPEG_QUALITY: u8 = 88;
/// sRGB of a surface that no colour was seen of.
const UNSEEN: [u8; 3] = [160; 3];

/// Carries the colours of the training scans to the surface of the base mesh.
pub fn bake(context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<Appearance> {
    let samples = weighted_samples(context);
    let coordinates = context.body.texture_coordinates.as_ref();
    let mut texture = coordinates.map(|_| TextureAccumulator::new(context.options.texture_size));
    let mut sums = vec![[0.0; 4]; context.body.template.len()];
    let mut seen = false;
    let bar = context.progress.bar("baking the texture", samples.len());
    for (sample, weight) in samples {
        let points = coloured_points(context, deformation, sample, weight)?;
        seen |= !points.is_empty();
        match (&mut texture, coordinates) {
            (Some(texture), Some(coordinates)) => texture.splat(coordinates, &points),
            _ => splat_on_vertices(&context.body.triangles, &points, &mut sums),
        }
        bar.advance(1);
    }
    Ok(match (texture, coordinates) {
        (Some(texture), Some(coordinates)) if seen => {
            let pixels = texture.finish();
            textured(context, coordinates, encode_jpeg(&pixels, context.options.texture_size)?)
        }
        _ => Appearance {
            drawn_vertices: (0..context.body.template.len() as u32).collect(),
            drawn_triangles: context.body.triangles.clone(),
            texture_coordinates: Vec::new(),
            texture: None,
            vertex_colours: sums.iter().map(mean_colour).collect(),
        },
    })
}

/// The frames whose colours are used, with their weights: those around the calmest moment, and a spread of all.
fn weighted_samples(context: &TrainContext) -> Vec<(Sample, f32)> {
    let samples = &context.samples;
    let reference = calmest(context);
    let step = samples.len().div_ceil(SPREAD_FRAME_COUNT).max(1);
    let weighted = samples.iter().enumerate().filter_map(|(i, &sample)| {
        let steps = i.abs_diff(reference) as f32 / REFERENCE_WIDTH;
        let same_sequence = sample.sequence == samples[reference].sequence;
        let weight = if same_sequence { (-steps * steps).exp() } else { 0.0 };
        (weight > LEAST_WEIGHT || i % step == 0).then_some((sample, weight.max(LEAST_WEIGHT)))
    });
    weighted.collect()
}

/// The training frame whose pose differs least from the frames before and after it.
fn calmest(context: &TrainContext) -> usize {
    let samples = &context.samples;
    let change = |a: Sample, b: Sample| -> f32 {
        if a.sequence != b.sequence {
            return f32::INFINITY;
        }
        let (a, b) = (context.pose(a), context.pose(b));
        a.rotations.iter().zip(&b.rotations).map(|(a, b)| a.angle_between(*b)).sum()
    };
    let restlessness = |i: usize| change(samples[i - 1], samples[i]) + change(samples[i], samples[i + 1]);
    (1..samples.len().saturating_sub(1)).min_by(|&a, &b| restlessness(a).total_cmp(&restlessness(b))).unwrap_or(0)
}

/// The scan's coloured points on the base mesh's surface, without those that are too far from it.
fn coloured_points(
    context: &TrainContext,
    deformation: &SurfaceFunction,
    sample: Sample,
    weight: f32,
) -> anyhow::Result<Vec<ColouredPoint>> {
    let scan = context.scan(sample)?;
    let weights: Vec<f32> = scan.frontality().iter().map(|frontality| weight * frontality).collect();
    let Some(colours) = scan.colours else { return Ok(Vec::new()) };
    let surface = base_surface(context, deformation, sample);
    let (positions, triangles) = (surface.positions(0), &context.body.triangles);
    let found = ClosestPoint::new(positions, triangles)?.query_all(&scan.points);
    let greatest = context.options.localisation.greatest_distance;
    let coloured = found.iter().zip(&scan.points).zip(colours).zip(weights);
    let points = coloured.filter_map(|(((hit, point), colour), weight)| {
        let distance = hit.interpolate(triangles, positions).distance(*point);
        (distance <= greatest).then_some(ColouredPoint {
            triangle: hit.triangle,
            barycentrics: hit.barycentric,
            colour,
            weight,
        })
    });
    Ok(points.collect())
}

fn splat_on_vertices(triangles: &[Triangle], points: &[ColouredPoint], sums: &mut [[f32; 4]]) {
    for point in points {
        for (&vertex, share) in triangles[point.triangle as usize].iter().zip(point.barycentrics) {
            let sum = &mut sums[vertex as usize];
            for channel in 0..3 {
                sum[channel] += share * point.weight * f32::from(point.colour[channel]);
            }
            sum[3] += share * point.weight;
        }
    }
}

/// Linear RGB of the mean of sRGB colours.
fn mean_colour(sum: &[f32; 4]) -> [u8; 3] {
    std::array::from_fn(|channel| {
        let mean = if sum[3] > 1e-3 { sum[channel] / sum[3] } else { f32::from(UNSEEN[channel]) } / 255.0;
        (255.0 * linear_from_srgb(mean)).round() as u8
    })
}

/// One drawn vertex for each pair of body vertex and texture coordinate.
fn textured(context: &TrainContext, coordinates: &TextureCoordinates, texture: Texture) -> Appearance {
    let mut drawn: HashMap<(u32, u32), u32> = HashMap::new();
    let (mut drawn_vertices, mut texture_coordinates) = (Vec::new(), Vec::new());
    let corners = context.body.triangles.iter().zip(&coordinates.triangles);
    let drawn_triangles = corners
        .map(|(vertices, texels)| {
            std::array::from_fn(|corner| {
                *drawn.entry((vertices[corner], texels[corner])).or_insert_with(|| {
                    drawn_vertices.push(vertices[corner]);
                    let [u, v] = coordinates.coordinates[texels[corner] as usize];
                    texture_coordinates.push([u, 1.0 - v]);
                    drawn_vertices.len() as u32 - 1
                })
            })
        })
        .collect();
    Appearance {
        drawn_vertices,
        drawn_triangles,
        texture_coordinates,
        texture: Some(texture),
        vertex_colours: Vec::new(),
    }
}

fn encode_jpeg(pixels: &[u8], size: usize) -> anyhow::Result<Texture> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .encode(pixels, size as u32, size as u32, image::ExtendedColorType::Rgb8)
        .context("the texture cannot be encoded")?;
    Ok(Texture { mime: "image/jpeg".into(), bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertex_colours_are_linear_means() {
        let mut sums = vec![[0.0; 4]; 3];
        let point = |colour, weight| ColouredPoint { triangle: 0, barycentrics: [1.0, 0.0, 0.0], colour, weight };
        splat_on_vertices(&[[0, 1, 2]], &[point([255, 0, 0], 1.0), point([255, 0, 255], 1.0)], &mut sums);
        assert_eq!(mean_colour(&sums[0]), [255, 0, 55], "half of sRGB blue is 0.216 in linear light");
        assert_eq!(mean_colour(&sums[1]), mean_colour(&[0.0; 4]), "unseen vertices are grey");
    }
}
