//! Which cells of a map are solid.

use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader};

use super::description::{Description, Mode};
use super::{MOST_CELLS, MapError};

/// The cells of a map, by rows from the least y to the greatest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
    /// `width * height`: everything that is not free.
    pub(super) solid: Vec<bool>,
}

impl Grid {
    /// Reads a map's picture; `path` is the YAML's, for errors.
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
            // Neither PNG nor PNM has others.
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

    /// Whether a pixel is free, as the map server's `loadMapFromFile` has it.
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
