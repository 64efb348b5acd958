//! A drawing as PNG, two pixels to a CSS pixel.

use plotters::backend::{BitMapBackend, DrawingBackend};

use super::PlotError;
use super::drawing::Drawing;
use super::font::Font;
use super::render::{View, render};

/// Pixels of the picture in a CSS pixel.
const DENSITY: u32 = 2;
/// Each pixel is the mean of so many each way: plotters smooths the edges of text, but not those of polygons.
const FINER: u32 = 2;
/// Rows of the page drawn at a time, so that a long page needs no more memory than a short one.
const BAND: u32 = 64;
/// Pixels in a metre at 96 CSS pixels to the inch, from which viewers tell the size in print.
const PIXELS_PER_METER: u32 = 3780 * DENSITY;

pub fn to_png(drawing: &Drawing, font: &Font, title: &str) -> Result<Vec<u8>, PlotError> {
    let (width, height) = (pixels(drawing.width), pixels(drawing.height));
    let mut image = Vec::new();
    let mut fine = vec![0xFF; 3 * size(width * FINER * FINER) * size(BAND * DENSITY)];
    let mut top = 0;
    while top < height {
        let band = (BAND * DENSITY).min(height - top);
        fine.fill(0xFF);
        let mut backend = BitMapBackend::with_buffer(&mut fine, (width * FINER, band * FINER));
        let rows = [top, top + band].map(|row| f64::from(row) / f64::from(DENSITY));
        render(drawing, font, View { scale: DENSITY * FINER, rows }, &mut backend)
            .map_err(PlotError::png)?;
        backend.present().map_err(PlotError::png)?;
        drop(backend);
        append_means(&fine, size(width), size(band), &mut image);
        top += band;
    }
    encode(&image, (width, height), title).map_err(PlotError::png)
}

/// The mean of each square of fine pixels.
fn append_means(fine: &[u8], width: usize, height: usize, image: &mut Vec<u8>) {
    let finer = size(FINER);
    let row_length = 3 * width * finer;
    let count = FINER * FINER;
    for rows in fine.chunks_exact(row_length * finer).take(height) {
        for column in 0..width {
            let mut sums = [0_u32; 3];
            for row in rows.chunks_exact(row_length) {
                for pixel in row[3 * finer * column..][..3 * finer].chunks_exact(3) {
                    sums.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(*value));
                }
            }
            image
                .extend(sums.map(|sum| u8::try_from((sum + count / 2) / count).unwrap_or(u8::MAX)));
        }
    }
}

fn encode(
    image: &[u8],
    (width, height): (u32, u32),
    title: &str,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Flat colours compress best as they are.
    encoder.set_filter(png::Filter::NoFilter);
    // A fifth larger than at the usual level, in half of the time.
    encoder.set_deflate_compression(png::DeflateCompression::Level(2));
    let density = png::PixelDimensions {
        xppu: PIXELS_PER_METER,
        yppu: PIXELS_PER_METER,
        unit: png::Unit::Meter,
    };
    encoder.set_pixel_dims(Some(density));
    encoder.add_itxt_chunk("Title".to_owned(), title.to_owned())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image)?;
    writer.finish()?;
    Ok(bytes)
}

fn pixels(length: f64) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    // a page has a positive size of a few thousand
    let pixels = (length * f64::from(DENSITY)).ceil() as u32;
    pixels
}

fn size(count: u32) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}
