//! Drawings as pixels, with an embedded typeface.

use super::{Color, Drawing, DrawingItem, RgbImage, TextAnchor, TextItem};
use azulejo::typeface::{DEJAVU_SERIF, LATIN};
use azulejo_formats::outline::{ppe, ppf};
use azulejo_scene::figure::Segment;
use azulejo_scene::{Encoding, Figure, FillRule, Font, Line};
use glam::DVec2;
use tiny_skia::{
    FilterQuality, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Stroke, StrokeDash,
    Transform,
};

/// Space after each letter, em: the advance of a PPF glyph ends with its ink.
const SPACING: f64 = 0.045;

/// Space between words, em.
const BLANK: f64 = 0.4;

/// The drawing at `width` pixels; `None` if that size is not possible.
pub fn rasterize(drawing: &Drawing, width: u32) -> Option<RgbImage> {
    let scale = f64::from(width) / drawing.size.x;
    let height = (drawing.size.y * scale).round() as u32;
    let mut raster = Rasterizer {
        pixmap: Pixmap::new(width, height)?,
        scale,
        typeface: EmbeddedTypeface::load(),
    };
    let [r, g, b] = drawing.background.unwrap_or([255; 3]);
    raster
        .pixmap
        .fill(tiny_skia::Color::from_rgba8(r, g, b, 255));
    for item in &drawing.items {
        raster.draw(item);
    }
    let pixels = raster.pixmap.data().chunks_exact(4);
    Some(RgbImage {
        width,
        height,
        rgb: pixels.flat_map(|p| [p[0], p[1], p[2]]).collect(),
    })
}

struct Rasterizer {
    pixmap: Pixmap,
    /// Pixels per unit of the drawing.
    scale: f64,
    typeface: EmbeddedTypeface,
}

impl Rasterizer {
    fn pixels_from_drawing(&self) -> Transform {
        Transform::from_scale(self.scale as f32, self.scale as f32)
    }

    fn draw(&mut self, item: &DrawingItem) {
        match item {
            DrawingItem::Polyline {
                points,
                color,
                width,
                dashes,
            } => {
                let dashes = dashes.iter().map(|d| *d as f32).collect();
                let stroke = Stroke {
                    width: *width as f32,
                    line_join: LineJoin::Round,
                    dash: StrokeDash::new(dashes, 0.0),
                    ..Stroke::default()
                };
                if let Some(path) = path(points, false) {
                    let transform = self.pixels_from_drawing();
                    self.pixmap
                        .stroke_path(&path, &paint(*color), &stroke, transform, None);
                }
            }
            DrawingItem::Polygon { points, color } => {
                if let Some(path) = path(points, true) {
                    self.fill(&path, *color, FillRule::NonZero);
                }
            }
            DrawingItem::Disk {
                center,
                radius,
                color,
            } => {
                let (x, y) = (center.x as f32, center.y as f32);
                if let Some(path) = PathBuilder::from_circle(x, y, *radius as f32) {
                    self.fill(&path, *color, FillRule::NonZero);
                }
            }
            DrawingItem::Text(text) => self.write(text),
            DrawingItem::Image { at, size, image } => self.paste(*at, *size, image),
        }
    }

    fn fill(&mut self, path: &Path, color: Color, rule: FillRule) {
        let rule = match rule {
            FillRule::EvenOdd => tiny_skia::FillRule::EvenOdd,
            FillRule::NonZero => tiny_skia::FillRule::Winding,
        };
        let transform = self.pixels_from_drawing();
        self.pixmap
            .fill_path(path, &paint(color), rule, transform, None);
    }

    fn write(&mut self, item: &TextItem) {
        let line = self.typeface.set(&item.text);
        let share = match item.anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => 0.5,
            TextAnchor::End => 1.0,
        };
        let start = -share * line.advance;
        // Along the baseline, and up from it.
        let [along, up] = if item.is_vertical {
            [DVec2::NEG_Y, DVec2::NEG_X]
        } else {
            [DVec2::X, DVec2::NEG_Y]
        };
        for glyph in &line.glyphs {
            let place = |p: DVec2| {
                let p = glyph.pen + p;
                item.at + item.size * ((start + p.x) * along + p.y * up)
            };
            if let Some(path) = outline(&glyph.figure, place) {
                self.fill(&path, item.color, glyph.figure.rule);
            }
        }
    }

    fn paste(&mut self, at: DVec2, size: DVec2, image: &RgbImage) {
        let Some(mut source) = Pixmap::new(image.width, image.height) else {
            return;
        };
        let colors = image.rgb.chunks_exact(3);
        for (pixel, rgb) in source.data_mut().chunks_exact_mut(4).zip(colors) {
            pixel.copy_from_slice(&[rgb[0], rgb[1], rgb[2], 255]);
        }
        let paint = PixmapPaint {
            quality: FilterQuality::Bilinear,
            ..PixmapPaint::default()
        };
        let stretch = self.scale * size / DVec2::new(image.width.into(), image.height.into());
        // An image of the right resolution stays sharp if it starts at a whole pixel.
        let corner = (self.scale * at).round();
        let transform = Transform::from_scale(stretch.x as f32, stretch.y as f32)
            .post_translate(corner.x as f32, corner.y as f32);
        self.pixmap
            .draw_pixmap(0, 0, source.as_ref(), &paint, transform, None);
    }
}

/// The typeface that is part of the program: Latin-1 and a few other characters.
struct EmbeddedTypeface {
    font: Font,
    encoding: Encoding,
}

impl EmbeddedTypeface {
    fn load() -> EmbeddedTypeface {
        // A test below ensures that both can be read.
        let font = ppf::read(DEJAVU_SERIF, "dejavu-serif.ppf").map(|(font, _)| font);
        let encoding = ppe::read(LATIN, "latin.ppe").map(|(encoding, _)| encoding);
        EmbeddedTypeface {
            font: font.unwrap_or_default(),
            encoding: encoding.unwrap_or_default(),
        }
    }

    /// Sets one line; characters without a glyph become question marks.
    fn set(&self, words: &str) -> Line {
        let mut line = Line::default();
        for word in words.split(' ') {
            let spelled: String = word.chars().map(|c| self.spelled(c)).collect();
            let set = self.font.set_line(&spelled, &self.encoding, SPACING);
            let set = set.unwrap_or_default();
            for mut glyph in set.glyphs {
                glyph.pen.x += line.advance;
                line.glyphs.push(glyph);
            }
            line.advance += set.advance + BLANK;
        }
        line.advance -= BLANK;
        line
    }

    fn spelled(&self, c: char) -> String {
        let known = |c: char| self.encoding.names.contains_key(&u32::from(c));
        match c {
            // A name between slashes selects a glyph.
            '/' => "/slash/".to_owned(),
            '–' => "-".to_owned(),
            _ if known(c) => c.to_string(),
            _ => "?".to_owned(),
        }
    }
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(color[0], color[1], color[2], 255);
    paint.anti_alias = true;
    paint
}

fn path(points: &[DVec2], is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (k, p) in points.iter().enumerate() {
        match k {
            0 => builder.move_to(p.x as f32, p.y as f32),
            _ => builder.line_to(p.x as f32, p.y as f32),
        }
    }
    if is_closed {
        builder.close();
    }
    builder.finish()
}

fn outline(figure: &Figure, place: impl Fn(DVec2) -> DVec2) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let place = |p: DVec2| {
        let p = place(p);
        (p.x as f32, p.y as f32)
    };
    for contour in &figure.contours {
        for (k, segment) in contour.segments().enumerate() {
            let (x, y) = place(segment.at(0.0));
            if k == 0 {
                builder.move_to(x, y);
            }
            match segment {
                Segment::Line([_, b]) => {
                    let (x, y) = place(b);
                    builder.line_to(x, y);
                }
                Segment::Cubic([_, b, c, d]) => {
                    let ((x1, y1), (x2, y2), (x, y)) = (place(b), place(c), place(d));
                    builder.cubic_to(x1, y1, x2, y2, x, y);
                }
            }
        }
        builder.close();
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::super::INK;
    use super::*;

    #[test]
    fn every_letter_has_a_glyph() {
        let typeface = EmbeddedTypeface::load();
        let check = |words: &str, glyphs: usize| {
            assert_eq!(typeface.set(words).glyphs.len(), glyphs, "{words}");
        };
        check("f_r cos, 1/sr", 11);
        check("60° · ²", 5);
        check("θ", 1);
    }

    #[test]
    fn shapes_and_text_leave_ink() {
        let mut drawing = Drawing::on_white(40.0, 20.0);
        let square = [(0.0, 0.0), (10.0, 0.0), (10.0, 20.0), (0.0, 20.0)];
        drawing.polygon(square.map(DVec2::from).to_vec(), [255, 0, 0]);
        drawing.text(DVec2::new(39.0, 15.0), TextAnchor::End, 14.0, INK, "az");
        let image = rasterize(&drawing, 80).unwrap();
        assert_eq!((image.width, image.height), (80, 40));
        let at = |x: usize, y: usize| &image.rgb[3 * (80 * y + x)..][..3];
        assert_eq!((at(5, 5), at(25, 5)), (&[255, 0, 0][..], &[255; 3][..]));
        let dark = image.rgb.chunks(3).filter(|p| p[0] < 128).count();
        assert!((100..700).contains(&dark), "{dark}");
    }
}
