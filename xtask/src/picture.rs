//! What a screenshot shows: something or nothing, the same as another one or not.

use anyhow::{Context, Result, bail, ensure};

/// A picture has at least this many colours unless it is blank. Text on a plain ground has fewer than a lit surface.
const FEWEST_COLOURS: usize = 32;

/// Of a picture that shows something, one colour never takes a larger share than this.
const LARGEST_SHARE: f64 = 0.995;

/// A pixel has changed when a channel differs by more than this, of 255: encoders and blending stay below.
const NOISE: u8 = 12;

/// Of a figure that moves, at least this share of the pixels changes. A clock or a slider changes a tenth of it.
const SMALLEST_CHANGE: f64 = 0.002;

/// A rectangle of a picture, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Left edge.
    pub x: usize,
    /// Upper edge.
    pub y: usize,
    /// Pixels to the right.
    pub width: usize,
    /// Pixels downwards.
    pub height: usize,
}

/// Red, green and blue of every pixel, row by row.
#[derive(Clone, Debug)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Reads a PNG with eight bits a channel, with or without transparency (which is ignored).
    pub fn from_png(bytes: &[u8]) -> Result<Self> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().context("not a PNG")?;
        let mut samples = vec![0; reader.output_buffer_size().context("the PNG is too large")?];
        let info = reader.next_frame(&mut samples).context("the PNG is broken")?;
        let channels = match (info.color_type, info.bit_depth) {
            (png::ColorType::Rgb, png::BitDepth::Eight) => 3,
            (png::ColorType::Rgba, png::BitDepth::Eight) => 4,
            other => bail!("the PNG has pixels of type {other:?}, expected 8-bit RGB or RGBA"),
        };
        let (width, height) = (info.width as usize, info.height as usize);
        let pixels = samples[..width * height * channels].chunks_exact(channels);
        Ok(Picture { width, height, pixels: pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect() })
    }

    /// The part of the region that lies in the picture; an error where that is nothing.
    pub fn crop(&self, region: Region) -> Result<Picture> {
        let columns = region.x.min(self.width)..(region.x + region.width).min(self.width);
        let rows = region.y.min(self.height)..(region.y + region.height).min(self.height);
        ensure!(!columns.is_empty() && !rows.is_empty(), "{region:?} lies outside {} x {}", self.width, self.height);
        let row = |row: usize| &self.pixels[row * self.width..][columns.clone()];
        let pixels = rows.clone().flat_map(|index| row(index).iter().copied()).collect();
        Ok(Picture { width: columns.len(), height: rows.len(), pixels })
    }
}

/// An error where the picture shows next to nothing.
pub fn require_content(picture: &Picture) -> Result<()> {
    // Five bits a channel: 32 768 bins.
    let mut counts = vec![0_usize; 1 << 15];
    for pixel in &picture.pixels {
        let [red, green, blue] = pixel.map(|channel| usize::from(channel >> 3));
        counts[red << 10 | green << 5 | blue] += 1;
    }
    let colours = counts.iter().filter(|&&count| count > 0).count();
    let largest = counts.iter().copied().max().unwrap_or(0) as f64 / picture.pixels.len() as f64;
    ensure!(
        colours >= FEWEST_COLOURS && largest <= LARGEST_SHARE,
        "the picture is blank: {colours} colours, one of them on {:.1} % of it",
        100.0 * largest
    );
    Ok(())
}

/// An error where two pictures of the same place differ too little for a moving figure.
pub fn require_motion(before: &Picture, after: &Picture) -> Result<()> {
    let share = changed_share(before, after)?;
    ensure!(
        share >= SMALLEST_CHANGE,
        "the figure does not move: {:.3} % of the picture changed, expected at least {:.1} %",
        100.0 * share,
        100.0 * SMALLEST_CHANGE
    );
    Ok(())
}

/// How far the channels of two pictures are apart, of 255, on average over all pixels.
pub fn mean_absolute_difference(a: &Picture, b: &Picture) -> Result<f64> {
    require_same_size(a, b)?;
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let sum: u64 = channels.map(|(&first, &second)| u64::from(first.abs_diff(second))).sum();
    Ok(sum as f64 / a.pixels.as_flattened().len() as f64)
}

fn require_same_size(a: &Picture, b: &Picture) -> Result<()> {
    let same = (a.width, a.height) == (b.width, b.height);
    ensure!(same, "the pictures differ in size: {} x {} and {} x {}", a.width, a.height, b.width, b.height);
    Ok(())
}

/// Share of the pixels, 0 to 1, that differ by more than noise.
fn changed_share(before: &Picture, after: &Picture) -> Result<f64> {
    require_same_size(before, after)?;
    let differs =
        |(a, b): &(&[u8; 3], &[u8; 3])| a.iter().zip(b.iter()).any(|(&first, &second)| first.abs_diff(second) > NOISE);
    let changed = before.pixels.iter().zip(&after.pixels).filter(differs).count();
    Ok(changed as f64 / before.pixels.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaded disc on a plain ground, its centre at the given column.
    fn disc(centre: f32) -> Picture {
        let (width, height) = (200, 100);
        let pixel = |index: usize| {
            let (x, y) = ((index % width) as f32 - centre, (index / width) as f32 - 50.0);
            let shade = 1.0 - (x * x + y * y).sqrt() / 20.0;
            if shade > 0.0 { [(255.0 * shade) as u8, 40, (120.0 * shade) as u8] } else { [230, 230, 230] }
        };
        Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    fn plain(colour: [u8; 3]) -> Picture {
        Picture { width: 200, height: 100, pixels: vec![colour; 20_000] }
    }

    #[test]
    fn a_shaded_figure_is_content() {
        require_content(&disc(100.0)).unwrap();
    }

    #[test]
    fn plain_and_nearly_plain_pictures_are_blank() {
        assert!(require_content(&plain([0, 0, 0])).is_err());
        let mut message = plain([255, 255, 255]);
        message.pixels[..2_000].fill([0, 0, 0]);
        assert!(require_content(&message).is_err(), "black on white, like a text");
        let mut dot = plain([9, 9, 9]);
        for (index, pixel) in dot.pixels[..60].iter_mut().enumerate() {
            *pixel = [4 * index as u8, 0, 0];
        }
        assert!(require_content(&dot).is_err(), "many colours on almost no pixels");
    }

    #[test]
    fn a_shifted_figure_has_moved() {
        require_motion(&disc(100.0), &disc(104.0)).unwrap();
    }

    #[test]
    fn the_same_picture_with_noise_has_not_moved() {
        let before = disc(100.0);
        let mut after = before.clone();
        for (index, pixel) in after.pixels.iter_mut().enumerate() {
            pixel[index % 3] = pixel[index % 3].saturating_add(NOISE);
        }
        after.pixels[..20].fill([0, 0, 0]);
        let error = require_motion(&before, &after).unwrap_err().to_string();
        assert!(error.contains("0.100 %"), "twenty pixels of 20 000: {error}");
    }

    #[test]
    fn the_mean_difference_counts_every_channel() {
        let mut other = plain([9, 9, 9]);
        other.pixels[..10_000].fill([12, 9, 0]);
        assert_eq!(mean_absolute_difference(&plain([9, 9, 9]), &plain([9, 9, 9])).unwrap(), 0.0);
        assert_eq!(mean_absolute_difference(&plain([9, 9, 9]), &other).unwrap(), 2.0);
    }

    #[test]
    fn pictures_of_other_sizes_cannot_be_compared() {
        let part = disc(100.0).crop(Region { x: 0, y: 0, width: 10, height: 10 }).unwrap();
        assert!(changed_share(&disc(100.0), &part).is_err());
    }

    #[test]
    fn a_crop_keeps_the_rows_and_columns_of_its_region() {
        let picture = disc(100.0);
        let part = picture.crop(Region { x: 90, y: 45, width: 500, height: 3 }).unwrap();
        assert_eq!((part.width, part.height), (110, 3));
        assert_eq!(part.pixels[110], picture.pixels[46 * 200 + 90]);
        assert!(picture.crop(Region { x: 200, y: 0, width: 5, height: 5 }).is_err());
    }

    #[test]
    fn png_files_come_back_as_their_pixels_and_broken_ones_are_errors() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[1, 2, 3, 255, 4, 5, 6, 0]).unwrap();
        writer.finish().unwrap();
        assert_eq!(Picture::from_png(&bytes).unwrap().pixels, [[1, 2, 3], [4, 5, 6]]);
        assert!(Picture::from_png(&bytes[..bytes.len() / 2]).is_err());
        assert!(Picture::from_png(b"GIF89a").is_err());
    }
}
