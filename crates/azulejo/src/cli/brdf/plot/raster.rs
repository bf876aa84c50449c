//! A drawing as pixels, with letters of its own.

use super::drawing::{Anchor, Color, Drawing, Pixels, Shape, Text};
use azulejo_formats::outline::{ppe, ppf};
use azulejo_scene::figure::Segment;
use azulejo_scene::{Encoding, Figure, FillRule, Font, Line};
use glam::DVec2;
use tiny_skia::{
    FilterQuality, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Stroke, StrokeDash,
    Transform,
};

/// DejaVu Serif as RTRACE's outlines, and the names of its characters.
const OUTLINES: &[u8] = include_bytes!("../../../../../../examples/fonts/dejavu-serif.ppf");
const NAMES: &[u8] = include_bytes!("../../../../../../examples/fonts/latin.ppe");

/// Blank behind each letter, em: a PPF's letters end where their ink does.
const SPACING: f64 = 0.045;

/// Blank between words, em.
const BLANK: f64 = 0.4;

/// The drawing at `width` pixels; `None` if that is no picture.
pub fn pixels(drawing: &Drawing, width: u32) -> Option<Pixels> {
    let scale = f64::from(width) / drawing.size.x;
    let height = (drawing.size.y * scale).round() as u32;
    let mut sheet = Sheet {
        pixels: Pixmap::new(width, height)?,
        scale,
        letters: Letters::embedded(),
    };
    sheet.pixels.fill(tiny_skia::Color::WHITE);
    for shape in &drawing.shapes {
        sheet.draw(shape);
    }
    let opaque = |p: &[u8]| [p[0], p[1], p[2]];
    Some(Pixels {
        width,
        height,
        rgb: sheet
            .pixels
            .data()
            .chunks_exact(4)
            .flat_map(opaque)
            .collect(),
    })
}

struct Sheet {
    pixels: Pixmap,
    /// Pixels of a unit of the drawing.
    scale: f64,
    letters: Letters,
}

impl Sheet {
    fn to_pixels(&self) -> Transform {
        Transform::from_scale(self.scale as f32, self.scale as f32)
    }

    fn draw(&mut self, shape: &Shape) {
        match shape {
            Shape::Line {
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
                    let transform = self.to_pixels();
                    self.pixels
                        .stroke_path(&path, &paint(*color), &stroke, transform, None);
                }
            }
            Shape::Polygon { points, color } => {
                if let Some(path) = path(points, true) {
                    self.fill(&path, *color, FillRule::NonZero);
                }
            }
            Shape::Text(text) => self.write(text),
            Shape::Picture { at, size, pixels } => self.paste(*at, *size, pixels),
        }
    }

    fn fill(&mut self, path: &Path, color: Color, rule: FillRule) {
        let rule = match rule {
            FillRule::EvenOdd => tiny_skia::FillRule::EvenOdd,
            FillRule::NonZero => tiny_skia::FillRule::Winding,
        };
        let transform = self.to_pixels();
        self.pixels
            .fill_path(path, &paint(color), rule, transform, None);
    }

    fn write(&mut self, text: &Text) {
        let line = self.letters.set(&text.words);
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5,
            Anchor::End => 1.0,
        };
        let start = text.at - DVec2::new(back * text.size * line.advance, 0.0);
        for glyph in &line.glyphs {
            let place =
                |p: DVec2| start + text.size * DVec2::new(glyph.pen.x + p.x, -(glyph.pen.y + p.y));
            if let Some(path) = outline(&glyph.figure, place) {
                self.fill(&path, text.color, glyph.figure.rule);
            }
        }
    }

    fn paste(&mut self, at: DVec2, size: DVec2, picture: &Pixels) {
        let Some(mut source) = Pixmap::new(picture.width, picture.height) else {
            return;
        };
        let colors = picture.rgb.chunks_exact(3);
        for (pixel, rgb) in source.data_mut().chunks_exact_mut(4).zip(colors) {
            pixel.copy_from_slice(&[rgb[0], rgb[1], rgb[2], 255]);
        }
        let paint = PixmapPaint {
            quality: FilterQuality::Bilinear,
            ..PixmapPaint::default()
        };
        let stretch = self.scale * size / DVec2::new(picture.width.into(), picture.height.into());
        // Whole pixels, where the picture was made for them, stay sharp.
        let corner = (self.scale * at).round();
        let transform = Transform::from_scale(stretch.x as f32, stretch.y as f32)
            .post_translate(corner.x as f32, corner.y as f32);
        self.pixels
            .draw_pixmap(0, 0, source.as_ref(), &paint, transform, None);
    }
}

/// A typeface of which every character of Latin-1 is known.
struct Letters {
    font: Font,
    encoding: Encoding,
}

impl Letters {
    /// The typeface that comes with the program.
    fn embedded() -> Letters {
        // Without letters a picture is still one; that they can be read is tested below.
        let font = ppf::read(OUTLINES, "dejavu-serif.ppf").map(|(font, _)| font);
        let encoding = ppe::read(NAMES, "latin.ppe").map(|(encoding, _)| encoding);
        Letters {
            font: font.unwrap_or_default(),
            encoding: encoding.unwrap_or_default(),
        }
    }

    /// One line; what has no letter is a question mark.
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
            // Between slashes stands the name of a glyph.
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
    use super::super::drawing::INK;
    use super::*;

    #[test]
    fn letters_are_there() {
        let letters = Letters::embedded();
        let check = |words: &str, glyphs: usize| {
            assert_eq!(letters.set(words).glyphs.len(), glyphs, "{words}");
        };
        check("f_r cos, 1/sr", 11);
        check("60° · ²", 5);
        check("θ", 1);
    }

    #[test]
    fn a_square_is_filled_and_words_leave_ink() {
        let mut drawing = Drawing::new(40.0, 20.0);
        let square = [(0.0, 0.0), (10.0, 0.0), (10.0, 20.0), (0.0, 20.0)];
        drawing.polygon(square.map(DVec2::from).to_vec(), [255, 0, 0]);
        drawing.text(DVec2::new(39.0, 15.0), Anchor::End, 14.0, INK, "az");
        let found = pixels(&drawing, 80).unwrap();
        assert_eq!((found.width, found.height), (80, 40));
        let at = |x: usize, y: usize| &found.rgb[3 * (80 * y + x)..][..3];
        assert_eq!((at(5, 5), at(25, 5)), (&[255, 0, 0][..], &[255; 3][..]));
        let dark = found.rgb.chunks(3).filter(|p| p[0] < 128).count();
        assert!((100..700).contains(&dark), "{dark}");
    }
}
