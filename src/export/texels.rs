//! A decoded picture, looked at between its texels.

/// sRGB texels, four bytes each, row by row from the top.
#[derive(Clone, Copy, Debug)]
pub struct Texels<'a> {
    width: usize,
    height: usize,
    bytes: &'a [u8],
}

impl<'a> Texels<'a> {
    /// `width` × `height` texels; none where `bytes` are not as many.
    pub fn new(width: usize, height: usize, bytes: &'a [u8]) -> Option<Self> {
        let fits = width > 0 && width.checked_mul(height)?.checked_mul(4)? == bytes.len() && !bytes.is_empty();
        fits.then_some(Self { width, height, bytes })
    }

    /// The colour at (u, v), v down, 0 to 1: between the four nearest texels; outside, that of the edge.
    pub fn at(&self, [u, v]: [f32; 2]) -> [u8; 3] {
        let place = |share: f32, count: usize| {
            let at = (share * count as f32 - 0.5).clamp(0.0, (count - 1) as f32);
            let first = at as usize;
            (first, (first + 1).min(count - 1), at - at.floor())
        };
        let ((left, right, x), (top, bottom, y)) = (place(u, self.width), place(v, self.height));
        let texel = |column: usize, row: usize, channel: usize| {
            f32::from(self.bytes[4 * (row * self.width + column) + channel])
        };
        std::array::from_fn(|channel| {
            let row = |row| texel(left, row, channel) * (1.0 - x) + texel(right, row, channel) * x;
            (row(top) * (1.0 - y) + row(bottom) * y).round() as u8
        })
    }
}
