//! Which cells of a map are solid.

use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader};

use super::description::{Description, Mode};
use super::{MOST_CELLS, MapError};

/// The cells of a map, by rows from the least y to the greatest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OccupancyGrid {
    pub(super) width: usize,
    pub(super) height: usize,
    /// `width * height`: everything that is not free.
    pub(super) solid: Vec<bool>,
}

impl OccupancyGrid {
    /// Reads a map's picture; `path` is the YAML's, for messages.
    pub(super) fn read(path: &Path, description: &Description) -> Result<Self, MapError> {
        let image = &description.image;
        let unreadable = |cause| MapError::Read { path: image.clone(), cause };
        let no_picture = |cause| MapError::Picture { path: image.clone(), cause };
        let decoder = ImageReader::open(image)
            .and_then(ImageReader::with_guessed_format)
            .map_err(unreadable)?
            .into_decoder()
            .map_err(no_picture)?;
        let (width, height) = decoder.dimensions();
        if width == 0 || height == 0 {
            return Err(MapError::NoCells { path: image.clone(), width, height });
        }
        let has = u64::from(width) * u64::from(height);
        if has > MOST_CELLS {
            let path = image.clone();
            return Err(MapError::TooManyCells { path, width, height, has, most: MOST_CELLS });
        }
        let picture = DynamicImage::from_decoder(decoder).map_err(no_picture)?;
        let grid = Self::of(&picture, description);
        if grid.solid.iter().all(|solid| *solid) {
            return Err(MapError::NothingFree {
                path: path.to_owned(),
                cells: grid.solid.len(),
                free: description.free,
            });
        }
        Ok(grid)
    }

    fn of(picture: &DynamicImage, description: &Description) -> Self {
        let reading = Reading {
            channels: usize::from(picture.color().channel_count()),
            alpha: picture.color().has_alpha(),
            description,
        };
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let solid = match picture {
            DynamicImage::ImageLuma8(p) => reading.solid(width, p.as_raw(), u8::MAX),
            DynamicImage::ImageLumaA8(p) => reading.solid(width, p.as_raw(), u8::MAX),
            DynamicImage::ImageRgb8(p) => reading.solid(width, p.as_raw(), u8::MAX),
            DynamicImage::ImageRgba8(p) => reading.solid(width, p.as_raw(), u8::MAX),
            DynamicImage::ImageLuma16(p) => reading.solid(width, p.as_raw(), u16::MAX),
            DynamicImage::ImageLumaA16(p) => reading.solid(width, p.as_raw(), u16::MAX),
            DynamicImage::ImageRgb16(p) => reading.solid(width, p.as_raw(), u16::MAX),
            DynamicImage::ImageRgba16(p) => reading.solid(width, p.as_raw(), u16::MAX),
            // PNG and PNM have no others.
            other => {
                let other = other.to_rgba16();
                let reading = Reading { channels: 4, alpha: true, description };
                reading.solid(width, other.as_raw(), u16::MAX)
            }
        };
        Self { width, height, solid }
    }
}

/// How the samples of a picture are read.
struct Reading<'a> {
    channels: usize,
    alpha: bool,
    description: &'a Description,
}

impl Reading<'_> {
    /// Whether cells are solid, by rows from below.
    fn solid<S: Copy + Into<u32>>(&self, width: usize, samples: &[S], full: S) -> Vec<bool> {
        let mut solid = Vec::with_capacity(samples.len() / self.channels);
        for row in samples.chunks_exact(width * self.channels).rev() {
            let pixels = row.chunks_exact(self.channels);
            solid.extend(pixels.map(|pixel| !self.free(pixel, full.into())));
        }
        solid
    }

    /// Whether a pixel is free, by the rules of the map server's `loadMapFromFile`.
    fn free<S: Copy + Into<u32>>(&self, pixel: &[S], full: u32) -> bool {
        let sample = |channel: usize| -> u32 { pixel[channel].into() };
        let colours = if self.alpha { self.channels - 1 } else { self.channels };
        let alpha = if self.alpha { sample(colours) } else { full };
        // Grey is red, green and blue alike.
        let mut sum = match colours {
            1 => 3 * sample(0),
            _ => sample(0) + sample(1) + sample(2),
        };
        let mut brightest = 3 * full;
        let Description { negate, free, occupied, mode, .. } = *self.description;
        if mode == Mode::Trinary && self.alpha {
            sum += alpha;
            brightest += full;
        }
        match mode {
            Mode::Raw => {
                let percent = (f64::from(sum) / f64::from(brightest) * 255.0).round();
                percent <= 100.0 && percent / 100.0 < free
            }
            Mode::Scale if alpha != full => false,
            Mode::Trinary | Mode::Scale => {
                let occupancy = if negate { sum } else { brightest - sum };
                let occupancy = f64::from(occupancy) / f64::from(brightest);
                occupancy <= occupied && occupancy < free
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use image::{ImageBuffer, Pixel};

    use super::*;

    fn description() -> Description {
        Description {
            image: PathBuf::new(),
            resolution: 1.0,
            origin: [0.0, 0.0],
            negate: false,
            occupied: 0.65,
            free: 0.196,
            mode: Mode::Trinary,
        }
    }

    /// Of pixels side by side, those that are free, in words.
    #[track_caller]
    fn check<P>(description: &Description, pixels: &[(P, &str)])
    where
        P: Pixel<Subpixel: std::fmt::Debug>,
        DynamicImage: From<ImageBuffer<P, Vec<P::Subpixel>>>,
    {
        let samples = pixels.iter().flat_map(|(pixel, _)| pixel.channels().to_vec()).collect();
        let picture = ImageBuffer::<P, _>::from_raw(pixels.len() as u32, 1, samples).unwrap();
        let grid = OccupancyGrid::of(&picture.into(), description);
        assert_eq!((grid.width, grid.height), (pixels.len(), 1));
        for (cell, (pixel, expected)) in grid.solid.iter().zip(pixels) {
            let found = if *cell { "solid" } else { "free" };
            assert_eq!(&found, expected, "{:?}", pixel.channels());
        }
    }

    #[test]
    fn unknown_is_solid_as_occupied_is() {
        // 205 is what the map server saves unknown cells as: 50 / 255 is just above 0.196.
        let shades = [(0u8, "solid"), (89, "solid"), (90, "solid"), (205, "solid"), (206, "free")];
        check(&description(), &shades.map(|(shade, free)| (image::Luma([shade]), free)));
        check(&description(), &[(image::Luma([254u8]), "free"), (image::Luma([255u8]), "free")]);
    }

    #[test]
    fn an_occupancy_at_the_threshold_is_not_free() {
        // 51 / 255 = 0.2.
        let fifth = Description { free: 0.2, ..description() };
        check(&fifth, &[(image::Luma([204u8]), "solid"), (image::Luma([205u8]), "free")]);
    }

    #[test]
    fn negate_makes_bright_occupied() {
        let negated = Description { negate: true, ..description() };
        let shades = [(0u8, "free"), (49, "free"), (50, "solid"), (254, "solid")];
        check(&negated, &shades.map(|(shade, free)| (image::Luma([shade]), free)));
    }

    #[test]
    fn sixteen_bits_are_not_rounded_to_eight() {
        // (65535 - s) / 65535 = 0.196 at s = 52690.14; both are 205 in eight bits.
        let shades = [(52690u16, "solid"), (52691, "free")];
        check(&description(), &shades.map(|(shade, free)| (image::Luma([shade]), free)));
        check(&description(), &shades.map(|(shade, free)| (image::Rgb([shade; 3]), free)));
    }

    #[test]
    fn colours_are_averaged() {
        // Of 3 * 255 = 765, 149 dark is 0.1948 and 150 dark 0.1961.
        check(
            &description(),
            &[(image::Rgb([255u8, 255, 106]), "free"), (image::Rgb([105, 255, 255]), "solid")],
        );
    }

    #[test]
    fn trinary_averages_alpha_in() {
        // Grey counts three times: (3 * 180 + 255) / 4 is 0.22 dark, without alpha 0.29.
        let quarter = Description { free: 0.25, ..description() };
        check(
            &quarter,
            &[
                (image::LumaA([180u8, 255]), "free"),
                (image::LumaA([171, 255]), "free"),
                (image::LumaA([170, 255]), "solid"),
                (image::LumaA([255, 0]), "solid"),
            ],
        );
        check(
            &quarter,
            &[(image::Rgba([180u8, 180, 180, 255]), "free"), (image::Rgba([255; 4]), "free")],
        );
        check(&quarter, &[(image::Rgba([180u16 * 257; 4]), "solid")]);
    }

    #[test]
    fn scale_takes_transparent_for_unknown_and_leaves_alpha_out() {
        let scale = Description { free: 0.25, mode: Mode::Scale, ..description() };
        check(
            &scale,
            &[
                (image::LumaA([255u8, 255]), "free"),
                (image::LumaA([255, 254]), "solid"),
                (image::LumaA([192, 255]), "free"),
                (image::LumaA([191, 255]), "solid"),
            ],
        );
        check(&scale, &[(image::Luma([192u8]), "free"), (image::Luma([191]), "solid")]);
    }

    #[test]
    fn raw_shades_are_percentages_whatever_negate_says() {
        for negate in [false, true] {
            let raw = Description { free: 0.25, mode: Mode::Raw, negate, ..description() };
            let shades =
                [(0u8, "free"), (24, "free"), (25, "solid"), (100, "solid"), (255, "solid")];
            check(&raw, &shades.map(|(shade, free)| (image::Luma([shade]), free)));
        }
        let certain = Description { free: 1.0, mode: Mode::Raw, ..description() };
        let shades = [(99u8, "free"), (100, "solid"), (101, "solid"), (255, "solid")];
        check(&certain, &shades.map(|(shade, free)| (image::Luma([shade]), free)));
    }
}
