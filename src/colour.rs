//! sRGB, and the linear light that it stands for.

/// Linear light, 0 ..= 1, of a number in sRGB, 0 ..= 1.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// [`linear_from_srgb`] of bytes.
pub fn linear_byte_from_srgb(encoded: u8) -> u8 {
    (255.0 * linear_from_srgb(f32::from(encoded) / 255.0)).round() as u8
}
