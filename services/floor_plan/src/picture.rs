//! Pictures as cells.

use image::{DynamicImage, ImageDecoder, ImageReader};

use crate::description::{Description, Mode};
use crate::error::MapError;
use crate::grid::{CellState, OccupancyGrid};

/// What the map server's tools save unknown cells as, 205 of 255, is just above this
/// occupancy, and this is the `free_thresh` that they write.
const GREY: f64 = 0.196;

/// Reads a map's picture.
pub(crate) fn read(description: &Description) -> Result<OccupancyGrid, MapError> {
    let path = &description.image;
    let unreadable = |cause| MapError::Read { path: path.clone(), cause };
    let no_picture = |cause| MapError::Picture { path: path.clone(), cause };
    let decoder = ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(unreadable)?
        .into_decoder()
        .map_err(no_picture)?;
    let (width, height) = decoder.dimensions();
    OccupancyGrid::check_size(u64::from(width), u64::from(height))
        .map_err(|cause| MapError::Grid { path: path.clone(), cause })?;
    let picture = DynamicImage::from_decoder(decoder).map_err(no_picture)?;
    Ok(grid(&picture, description))
}

fn grid(picture: &DynamicImage, description: &Description) -> OccupancyGrid {
    let reading = Reading {
        channels: usize::from(picture.color().channel_count()),
        alpha: picture.color().has_alpha(),
        description,
    };
    let mut grid = OccupancyGrid::new(picture.width() as usize, picture.height() as usize);
    match picture {
        DynamicImage::ImageLuma8(p) => reading.fill(&mut grid, p.as_raw(), u8::MAX),
        DynamicImage::ImageLumaA8(p) => reading.fill(&mut grid, p.as_raw(), u8::MAX),
        DynamicImage::ImageRgb8(p) => reading.fill(&mut grid, p.as_raw(), u8::MAX),
        DynamicImage::ImageRgba8(p) => reading.fill(&mut grid, p.as_raw(), u8::MAX),
        DynamicImage::ImageLuma16(p) => reading.fill(&mut grid, p.as_raw(), u16::MAX),
        DynamicImage::ImageLumaA16(p) => reading.fill(&mut grid, p.as_raw(), u16::MAX),
        DynamicImage::ImageRgb16(p) => reading.fill(&mut grid, p.as_raw(), u16::MAX),
        DynamicImage::ImageRgba16(p) => reading.fill(&mut grid, p.as_raw(), u16::MAX),
        // PNG, PNM and BMP have no others.
        other => {
            let other = other.to_rgba16();
            let reading = Reading { channels: 4, alpha: true, description };
            reading.fill(&mut grid, other.as_raw(), u16::MAX);
        }
    }
    grid
}

/// How the samples of a picture are read.
struct Reading<'a> {
    channels: usize,
    alpha: bool,
    description: &'a Description,
}

impl Reading<'_> {
    /// Reads the cells of a picture, whose rows begin at the top.
    fn fill<S>(&self, grid: &mut OccupancyGrid, samples: &[S], full: S)
    where
        S: Copy + PartialEq + Into<u32>,
    {
        let row_length = grid.width() * self.channels;
        // Neighbours are mostly alike, and so are whole words of them.
        let mut last = &samples[..self.channels];
        let mut bits = self.bits(last, full.into());
        for (y, row) in samples.chunks_exact(row_length).rev().enumerate() {
            let [occupied, unknown, grey] = grid.rows_mut(y);
            let words = occupied.iter_mut().zip(unknown).zip(grey);
            for (pixels, ((occupied, unknown), grey)) in row.chunks(64 * self.channels).zip(words) {
                let (first, second) =
                    (&pixels[..pixels.len() - self.channels], &pixels[self.channels..]);
                if first == second && &pixels[..self.channels] == last {
                    let all = u64::MAX >> (64 - pixels.len() / self.channels);
                    [*occupied, *unknown, *grey] = bits.map(|bit| bit * all);
                    continue;
                }
                for (x, pixel) in pixels.chunks_exact(self.channels).enumerate() {
                    if pixel != last {
                        (last, bits) = (pixel, self.bits(pixel, full.into()));
                    }
                    *occupied |= bits[0] << x;
                    *unknown |= bits[1] << x;
                    *grey |= bits[2] << x;
                }
            }
        }
    }

    /// Whether a pixel is occupied, unknown, or free although grey, as bits.
    fn bits<S: Copy + Into<u32>>(&self, pixel: &[S], full: u32) -> [u64; 3] {
        let (state, occupancy) = self.cell(pixel, full);
        let grey = state == CellState::Free && occupancy >= GREY;
        [state == CellState::Occupied, state == CellState::Unknown, grey].map(u64::from)
    }

    /// What a pixel is by the rules of the map server's `loadMapFromFile`, and its occupancy.
    fn cell<S: Copy + Into<u32>>(&self, pixel: &[S], full: u32) -> (CellState, f64) {
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
        if mode == Mode::Raw {
            let percent = (f64::from(sum) / f64::from(brightest) * 255.0).round();
            let state = match percent {
                0.0..=100.0 if percent / 100.0 < free => CellState::Free,
                0.0..=100.0 => CellState::Occupied,
                _ => CellState::Unknown,
            };
            // Unknown has shades of its own here: what is free is known to be.
            return (state, 0.0);
        }
        let occupancy = if negate { sum } else { brightest - sum };
        let occupancy = f64::from(occupancy) / f64::from(brightest);
        let state = match mode {
            Mode::Scale if alpha != full => CellState::Unknown,
            _ if occupied < occupancy => CellState::Occupied,
            _ if occupancy < free => CellState::Free,
            Mode::Scale => CellState::Occupied,
            _ => CellState::Unknown,
        };
        (state, occupancy)
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
            origin: [0.0; 3],
            negate: false,
            occupied: 0.65,
            free: 0.196,
            mode: Mode::Trinary,
        }
    }

    /// What pixels side by side are, in words.
    #[track_caller]
    fn check<P>(description: &Description, pixels: &[(P, &str)])
    where
        P: Pixel<Subpixel: std::fmt::Debug>,
        DynamicImage: From<ImageBuffer<P, Vec<P::Subpixel>>>,
    {
        let samples = pixels.iter().flat_map(|(pixel, _)| pixel.channels().to_vec()).collect();
        let picture = ImageBuffer::<P, _>::from_raw(pixels.len() as u32, 1, samples).unwrap();
        let grid = grid(&picture.into(), description);
        assert_eq!((grid.width(), grid.height()), (pixels.len(), 1));
        for (x, (pixel, expected)) in pixels.iter().enumerate() {
            let found = match grid.cell(x, 0).unwrap() {
                CellState::Free if grid.is_grey(x, 0) => "grey",
                CellState::Free => "free",
                CellState::Occupied => "occupied",
                CellState::Unknown => "unknown",
            };
            assert_eq!(&found, expected, "{:?}", pixel.channels());
        }
    }

    #[test]
    fn what_the_map_server_saves_is_read_back() {
        // It saves unknown cells as 205: 50 / 255 is just above 0.196.
        let shades = [
            (0u8, "occupied"),
            (89, "occupied"),
            (90, "unknown"),
            (205, "unknown"),
            (206, "free"),
            (254, "free"),
            (255, "free"),
        ];
        check(&description(), &shades.map(|(shade, state)| (image::Luma([shade]), state)));
    }

    #[test]
    fn a_higher_threshold_makes_grey_free() {
        // 51 / 255 = 0.2, which is not less.
        let fifth = Description { free: 0.2, ..description() };
        let shades = [(204u8, "unknown"), (205, "grey"), (206, "free")];
        check(&fifth, &shades.map(|(shade, state)| (image::Luma([shade]), state)));
        let scale = Description { mode: Mode::Scale, ..fifth };
        let shades = [(204u8, "occupied"), (205, "grey"), (206, "free")];
        check(&scale, &shades.map(|(shade, state)| (image::Luma([shade]), state)));
    }

    #[test]
    fn negate_makes_bright_occupied() {
        let negated = Description { negate: true, ..description() };
        let shades = [(0u8, "free"), (49, "free"), (50, "unknown"), (254, "occupied")];
        check(&negated, &shades.map(|(shade, state)| (image::Luma([shade]), state)));
    }

    #[test]
    fn sixteen_bits_are_not_rounded_to_eight() {
        // (65535 - s) / 65535 = 0.196 at s = 52690.14; both are 205 in eight bits.
        let shades = [(52690u16, "unknown"), (52691, "free")];
        check(&description(), &shades.map(|(shade, state)| (image::Luma([shade]), state)));
        check(&description(), &shades.map(|(shade, state)| (image::Rgb([shade; 3]), state)));
    }

    #[test]
    fn colours_are_averaged() {
        // Of 3 * 255 = 765, 149 dark is 0.1948 and 150 dark 0.1961.
        check(
            &description(),
            &[(image::Rgb([255u8, 255, 106]), "free"), (image::Rgb([105, 255, 255]), "unknown")],
        );
    }

    #[test]
    fn trinary_averages_alpha_in() {
        // Grey counts three times: (3 * 180 + 255) / 4 is 0.22 dark, without alpha 0.29.
        let quarter = Description { free: 0.25, ..description() };
        check(
            &quarter,
            &[
                (image::LumaA([200u8, 255]), "free"),
                (image::LumaA([171, 255]), "grey"),
                (image::LumaA([170, 255]), "unknown"),
                (image::LumaA([255, 0]), "unknown"),
                (image::LumaA([255, 255]), "free"),
                (image::LumaA([0, 255]), "occupied"),
            ],
        );
        check(
            &quarter,
            &[(image::Rgba([200u8, 200, 200, 255]), "free"), (image::Rgba([255; 4]), "free")],
        );
        check(&quarter, &[(image::Rgba([180u16 * 257; 4]), "unknown")]);
    }

    #[test]
    fn scale_takes_transparent_for_unknown_and_leaves_alpha_out() {
        let scale = Description { free: 0.25, mode: Mode::Scale, ..description() };
        check(
            &scale,
            &[
                (image::LumaA([255u8, 255]), "free"),
                (image::LumaA([255, 254]), "unknown"),
                (image::LumaA([0, 0]), "unknown"),
                (image::LumaA([192, 255]), "grey"),
                (image::LumaA([191, 255]), "occupied"),
            ],
        );
    }

    #[test]
    fn raw_shades_are_percentages_whatever_negate_says() {
        for negate in [false, true] {
            let raw = Description { free: 0.25, mode: Mode::Raw, negate, ..description() };
            let shades = [
                (0u8, "free"),
                (24, "free"),
                (25, "occupied"),
                (100, "occupied"),
                (101, "unknown"),
                (255, "unknown"),
            ];
            check(&raw, &shades.map(|(shade, state)| (image::Luma([shade]), state)));
        }
        let certain = Description { free: 1.0, mode: Mode::Raw, ..description() };
        let shades = [(99u8, "free"), (100, "occupied"), (101, "unknown")];
        check(&certain, &shades.map(|(shade, state)| (image::Luma([shade]), state)));
    }

    #[test]
    fn rows_longer_than_a_word_are_read_from_below() {
        let drawn = image::GrayImage::from_fn(130, 3, |x, y| {
            image::Luma([if (x * 7 + y * 5) % 11 < 4 { 0 } else { 254 }])
        });
        let grid = grid(&drawn.clone().into(), &description());
        for (x, y, pixel) in drawn.enumerate_pixels() {
            let expected = if pixel.0 == [0] { CellState::Occupied } else { CellState::Free };
            assert_eq!(grid.cell(x as usize, 2 - y as usize), Some(expected), "{x}, {y}");
        }
        assert_eq!((grid.cell(130, 0), grid.cell(0, 3)), (None, None));
    }
}
