//! Plots as a list of shapes, written as SVG or rasterized.
//!
//! `brdf plot` and the report of `experiment` both draw with this. Coordinates are not rounded to
//! pixels, and [`raster`] has a typeface of its own, so a PNG looks the same on every machine.

pub mod palette;
pub mod raster;

use glam::DVec2;

/// Red, green and blue, sRGB.
pub type Color = [u8; 3];

/// Text and axes.
pub const INK: Color = [32, 33, 36];

/// Text of secondary importance.
pub const FAINT: Color = [105, 109, 114];

/// Grid lines.
pub const GRID: Color = [218, 220, 224];

/// Colours that remain distinct with any colour vision (Okabe and Ito 2008).
pub const COLORS: [Color; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [110, 110, 110],
];

/// One element of a drawing. Lengths are in units of the drawing; y points down.
#[derive(Clone, Debug)]
pub enum DrawingItem {
    /// An open polyline.
    Polyline {
        points: Vec<DVec2>,
        color: Color,
        width: f64,
        /// Alternating lengths of dashes and gaps; empty for a solid line.
        dashes: &'static [f64],
    },
    /// A filled polygon.
    Polygon { points: Vec<DVec2>, color: Color },
    /// A filled circle.
    Disk {
        center: DVec2,
        radius: f64,
        color: Color,
    },
    /// A line of text.
    Text(TextItem),
    /// An image.
    Image {
        /// Upper left corner.
        at: DVec2,
        /// Width and height in units of the drawing.
        size: DVec2,
        image: RgbImage,
    },
}

/// One line of text.
#[derive(Clone, Debug)]
pub struct TextItem {
    /// The anchor point on the baseline.
    pub at: DVec2,
    /// Which part of the line is at `at`.
    pub anchor: TextAnchor,
    /// Font size.
    pub size: f64,
    pub color: Color,
    /// Whether the text reads from bottom to top.
    pub is_vertical: bool,
    pub text: String,
}

/// The part of a line of text that is placed at its point, as in SVG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextAnchor {
    Start,
    Middle,
    End,
}

/// An opaque image.
#[derive(Clone, Debug)]
pub struct RgbImage {
    pub width: u32,
    pub height: u32,
    /// Red, green, blue, sRGB, rows from the top.
    pub rgb: Vec<u8>,
}

/// A list of shapes on a page.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width and height.
    pub size: DVec2,
    /// The page's colour; transparent without one.
    pub background: Option<Color>,
    /// Font families of the SVG, as in CSS.
    pub font_family: &'static str,
    /// From back to front.
    pub items: Vec<DrawingItem>,
}

impl Drawing {
    /// An empty white page; its text is set in the typeface of the rasterizer, or one like it.
    pub fn on_white(width: f64, height: f64) -> Drawing {
        Drawing {
            size: DVec2::new(width, height),
            background: Some([255; 3]),
            font_family: "'DejaVu Serif', Georgia, serif",
            items: Vec::new(),
        }
    }

    /// An empty transparent page, for SVG inside of another document.
    pub fn transparent(width: f64, height: f64) -> Drawing {
        Drawing {
            background: None,
            font_family: "sans-serif",
            ..Drawing::on_white(width, height)
        }
    }

    /// Adds a solid line.
    pub fn line(&mut self, points: Vec<DVec2>, color: Color, width: f64) {
        self.dashed(points, color, width, &[]);
    }

    /// Adds a dashed line.
    pub fn dashed(&mut self, points: Vec<DVec2>, color: Color, width: f64, dashes: &'static [f64]) {
        if points.len() > 1 {
            self.items.push(DrawingItem::Polyline {
                points,
                color,
                width,
                dashes,
            });
        }
    }

    /// Adds a filled polygon.
    pub fn polygon(&mut self, points: Vec<DVec2>, color: Color) {
        self.items.push(DrawingItem::Polygon { points, color });
    }

    /// Adds a filled circle.
    pub fn disk(&mut self, center: DVec2, radius: f64, color: Color) {
        self.items.push(DrawingItem::Disk {
            center,
            radius,
            color,
        });
    }

    /// Adds a line of text.
    pub fn text(&mut self, at: DVec2, anchor: TextAnchor, size: f64, color: Color, text: &str) {
        self.items.push(DrawingItem::Text(TextItem {
            at,
            anchor,
            size,
            color,
            is_vertical: false,
            text: text.to_owned(),
        }));
    }

    /// Adds a line of text that reads from bottom to top, centred on `at`.
    pub fn vertical_text(&mut self, at: DVec2, size: f64, color: Color, text: &str) {
        self.items.push(DrawingItem::Text(TextItem {
            at,
            anchor: TextAnchor::Middle,
            size,
            color,
            is_vertical: true,
            text: text.to_owned(),
        }));
    }

    /// Adds an image.
    pub fn image(&mut self, at: DVec2, size: DVec2, image: RgbImage) {
        self.items.push(DrawingItem::Image { at, size, image });
    }

    /// The drawing as an SVG document.
    pub fn svg(&self) -> String {
        let (w, h) = (self.size.x, self.size.y);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" font-family=\"{}\">\n",
            self.font_family
        );
        if let Some(color) = self.background {
            let color = hex(color);
            out += &format!("<rect width=\"{w}\" height=\"{h}\" fill=\"{color}\"/>\n");
        }
        for item in &self.items {
            out += &item.svg();
            out.push('\n');
        }
        out + "</svg>\n"
    }
}

impl DrawingItem {
    fn svg(&self) -> String {
        match self {
            DrawingItem::Polyline {
                points,
                color,
                width,
                dashes,
            } => {
                let dashes = match dashes {
                    [] => String::new(),
                    _ => format!(" stroke-dasharray=\"{}\"", list(dashes.iter().copied())),
                };
                format!(
                    "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" \
                     stroke-linejoin=\"round\"{dashes}/>",
                    coordinates(points),
                    hex(*color)
                )
            }
            DrawingItem::Polygon { points, color } => {
                format!(
                    "<polygon points=\"{}\" fill=\"{}\"/>",
                    coordinates(points),
                    hex(*color)
                )
            }
            DrawingItem::Disk {
                center,
                radius,
                color,
            } => format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"{}\"/>",
                round(center.x),
                round(center.y),
                hex(*color)
            ),
            DrawingItem::Text(text) => text.svg(),
            DrawingItem::Image { at, size, image } => format!(
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" \
                 href=\"data:image/png;base64,{}\"/>",
                round(at.x),
                round(at.y),
                round(size.x),
                round(size.y),
                base64(&image.png())
            ),
        }
    }
}

impl TextItem {
    fn svg(&self) -> String {
        let anchor = match self.anchor {
            TextAnchor::Start => "start",
            TextAnchor::Middle => "middle",
            TextAnchor::End => "end",
        };
        let (x, y) = (round(self.at.x), round(self.at.y));
        let turn = if self.is_vertical {
            format!(" transform=\"rotate(-90 {x} {y})\"")
        } else {
            String::new()
        };
        format!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{anchor}\"{turn}>{}</text>",
            self.size,
            hex(self.color),
            escaped(&self.text)
        )
    }
}

impl RgbImage {
    fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing into memory does not fail.
        let _ =
            azulejo_formats::picture::png::write(self.width, self.height, &self.rgb, &mut bytes);
        bytes
    }
}

fn coordinates(points: &[DVec2]) -> String {
    let pair = |p: &DVec2| format!("{},{}", round(p.x), round(p.y));
    points.iter().map(pair).collect::<Vec<_>>().join(" ")
}

fn list(numbers: impl Iterator<Item = f64>) -> String {
    numbers.map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

/// Two decimals are finer than the pixels of any screen.
fn round(x: f64) -> f64 {
    (100.0 * x).round() / 100.0
}

/// A colour as CSS and SVG write it: `#rrggbb`.
pub fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text with the special characters of XML and HTML escaped.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(c),
        }
    }
    out
}

/// Base64, RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            out.push(if k <= chunk.len() {
                letter as char
            } else {
                '='
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_short_texts() {
        let check = |bytes: &str, expected: &str| assert_eq!(base64(bytes.as_bytes()), expected);
        check("", "");
        check("f", "Zg==");
        check("fo", "Zm8=");
        check("foo", "Zm9v");
        check("foobar", "Zm9vYmFy");
    }

    #[test]
    fn a_drawing_is_xml() {
        let mut drawing = Drawing::on_white(20.0, 10.0);
        drawing.text(DVec2::ONE, TextAnchor::Middle, 12.0, INK, "a < b & \"c\"");
        drawing.vertical_text(DVec2::ONE, 12.0, INK, "up");
        drawing.disk(DVec2::ONE, 3.0, [0, 114, 178]);
        drawing.dashed(
            vec![DVec2::ZERO, DVec2::new(1.234567, 2.0)],
            INK,
            2.0,
            &[4.0, 2.0],
        );
        let svg = drawing.svg();
        for part in [
            "a &lt; b &amp; &quot;c&quot;",
            "rotate(-90 1 1)\">up",
            "r=\"3\" fill=\"#0072b2\"",
            "0,0 1.23,2",
            "dasharray=\"4 2\"",
            "middle",
            "fill=\"#ffffff\"",
        ] {
            assert!(svg.contains(part), "{part} is not in {svg}");
        }
        assert!(!Drawing::transparent(1.0, 1.0).svg().contains("<rect"));
    }
}
