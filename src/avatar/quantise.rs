//! Rounding to what the file holds: tables of half-precision numbers with a common scale, 16-bit skinning weights.

use super::Avatar;
use crate::body::Skin;
use crate::network::SurfaceFunction;
use half::f16;

/// `values` as half-precision numbers of magnitude at most 1 and the power of two that they are to be multiplied by.
///
/// The scale keeps small tables (metres) clear of half precision's subnormal numbers. Rounding twice gives what rounding once gives.
pub fn half_table(values: &[f32]) -> (Vec<f16>, f32) {
    let largest = values.iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
    // Rounded first, so that a value that rounds up to a power of two gives the same scale again.
    let rounded = f64::from(largest) / 2f64.powi(exponent(largest));
    let rounded = f64::from(f16::from_f64(rounded)) * 2f64.powi(exponent(largest));
    let scale = 2f64.powi(exponent(rounded as f32)) as f32;
    (values.iter().map(|&value| f16::from_f64(f64::from(value) / f64::from(scale))).collect(), scale)
}

/// Smallest e, within f32's normal range, with |value| ≤ 2^e; 0 for zero.
fn exponent(value: f32) -> i32 {
    if value == 0.0 { 0 } else { (value.log2().ceil() as i32).clamp(-126, 127) }
}

/// Rounds `values` to what [`half_table`] can hold.
pub fn round_to_half(values: &mut [f32]) {
    let (halves, scale) = half_table(values);
    for (value, half) in values.iter_mut().zip(halves) {
        *value = half.to_f32() * scale;
    }
}

/// Four weights in steps of 1/65535 that sum to exactly 1; the largest takes up what rounding left.
pub fn quantised_weights(weights: [f32; 4]) -> [u16; 4] {
    let mut steps = weights.map(|weight| (weight * 65535.0).round() as i32);
    let largest = (0..4).max_by_key(|&i| (steps[i], -(i as i32))).unwrap_or(0);
    steps[largest] += 65535 - steps.iter().sum::<i32>();
    steps.map(|step| step.clamp(0, 65535) as u16)
}

/// The weight that a step stands for.
pub fn weight_from_step(step: u16) -> f32 {
    f32::from(step) / 65535.0
}

/// `skin` with the weights that the file holds; joints of weight zero are joint 0, as glTF has it.
pub fn quantised_skin(skin: &Skin) -> Skin {
    let mut skin = skin.clone();
    for (joints, weights) in skin.joints.iter_mut().zip(&mut skin.weights) {
        let steps = quantised_weights(*weights);
        *weights = steps.map(weight_from_step);
        for (joint, step) in joints.iter_mut().zip(steps) {
            if step == 0 {
                *joint = 0;
            }
        }
    }
    skin
}

/// Step of the solver's coarse factor, whose entries are about 1 at most. As a preconditioner it bears this without one iteration more.
const FACTOR_STEP: f32 = 1.0 / 256.0;

impl Avatar {
    /// The avatar as its file gives it back: networks, tables and weights rounded to what the format holds.
    pub fn quantised(&self) -> Self {
        let mut avatar = self.clone();
        avatar.rig.skin = quantised_skin(&self.rig.skin);
        for value in &mut avatar.factor.values {
            *value = f16::from_f32((value.to_f32() / FACTOR_STEP).round() * FACTOR_STEP);
        }
        for function in [&mut avatar.deformation, &mut avatar.laplacian] {
            round_function(function);
        }
        if let Some(directions) = &mut avatar.rig.pose_directions {
            let mut numbers: Vec<f32> = directions.iter().flatten().flat_map(|d| d.to_array()).collect();
            round_to_half(&mut numbers);
            for (direction, number) in directions.iter_mut().flatten().zip(numbers.chunks_exact(3)) {
                *direction = glam::Vec3A::from_slice(number);
            }
        }
        avatar
    }
}

fn round_function(function: &mut SurfaceFunction) {
    match function {
        SurfaceFunction::Mlp(mlp) => {
            for layer in &mut mlp.layers {
                round_to_half(&mut layer.weight);
                round_to_half(&mut layer.bias);
            }
        }
        SurfaceFunction::Compact(compact) => {
            round_to_half(&mut compact.centres);
            round_to_half(&mut compact.mean);
            // One table for all regions, so one scale.
            let mut coefficients: Vec<f32> =
                compact.regions.iter().flat_map(|region| region.coefficient_from_kernel.iter().copied()).collect();
            round_to_half(&mut coefficients);
            let mut rounded = coefficients.into_iter();
            for region in &mut compact.regions {
                region
                    .coefficient_from_kernel
                    .iter_mut()
                    .zip(&mut rounded)
                    .for_each(|(value, rounded)| *value = rounded);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_tables_keep_eleven_bits_at_any_scale_and_round_once() {
        for scale in [1e-6f32, 3e-3, 1.0, 1.00001, 1.9999, 65_000.0, 1e9] {
            let values: Vec<f32> = (-50..=50).map(|i| scale * i as f32 / 50.0).collect();
            let mut once = values.clone();
            round_to_half(&mut once);
            for (value, rounded) in values.iter().zip(&once) {
                assert!((value - rounded).abs() <= value.abs() * 0.0005, "{value} became {rounded}");
            }
            let mut twice = once.clone();
            round_to_half(&mut twice);
            assert_eq!(once, twice, "scale {scale}");
        }
        assert_eq!(half_table(&[0.0, 0.0]).1, 1.0);
    }

    #[test]
    fn weights_sum_to_one_exactly_and_round_once() {
        for weights in [[1.0, 0.0, 0.0, 0.0], [0.25; 4], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0], [0.7, 0.1, 0.15, 0.05]]
        {
            let steps = quantised_weights(weights);
            assert_eq!(steps.iter().map(|&step| u32::from(step)).sum::<u32>(), 65535);
            assert_eq!(quantised_weights(steps.map(weight_from_step)), steps);
            for (weight, step) in weights.iter().zip(steps) {
                assert!((weight - weight_from_step(step)).abs() < 4.0 / 65535.0);
            }
        }
    }
}
