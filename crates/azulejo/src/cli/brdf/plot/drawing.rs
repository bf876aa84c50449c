//! A drawing as a list of shapes, which becomes SVG or pixels.
//!
//! Plots of `experiment` go through the crate `plotters`, whose places are whole pixels and whose
//! letters are those of the system. Lobes need finer lines, and pictures need letters wherever
//! they are made; so both kinds of file are written from this list.

use glam::DVec2;

/// Red, green, blue as on screens.
pub type Color = [u8; 3];

/// Text and axes.
pub const INK: Color = [32, 33, 36];

/// Words that matter less.
pub const FAINT: Color = [105, 109, 114];

/// Lines across.
pub const GRID: Color = [218, 220, 224];

/// Colours that people with any colour vision tell apart (Okabe and Ito 2008), from dark to pale.
pub const COLORS: [Color; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [110, 110, 110],
];

/// What a drawing is made of, the first at the back. Lengths are units of the drawing, y down.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A line through points.
    Line {
        points: Vec<DVec2>,
        color: Color,
        width: f64,
        /// Lengths drawn and left out, in turn; empty for a whole line.
        dashes: &'static [f64],
    },
    /// A filled polygon.
    Polygon { points: Vec<DVec2>, color: Color },
    /// Words.
    Text(Text),
    /// Pixels.
    Picture {
        /// Upper left corner.
        at: DVec2,
        /// Width and height in units of the drawing.
        size: DVec2,
        pixels: Pixels,
    },
}

/// One line of words.
#[derive(Clone, Debug)]
pub struct Text {
    /// The end or middle of its base line.
    pub at: DVec2,
    /// Where it stands to that point.
    pub anchor: Anchor,
    /// Height of the letters.
    pub size: f64,
    pub color: Color,
    pub words: String,
}

/// Where words stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// They begin at the point.
    Start,
    /// Their middle is there.
    Middle,
    /// They end there.
    End,
}

/// A picture without transparency.
#[derive(Clone, Debug)]
pub struct Pixels {
    pub width: u32,
    pub height: u32,
    /// Red, green, blue, rows from the top, sRGB.
    pub rgb: Vec<u8>,
}

/// Shapes on white paper.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width and height.
    pub size: DVec2,
    /// The first at the back.
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// White paper.
    pub fn new(width: f64, height: f64) -> Drawing {
        Drawing {
            size: DVec2::new(width, height),
            shapes: Vec::new(),
        }
    }

    /// A whole line.
    pub fn line(&mut self, points: Vec<DVec2>, color: Color, width: f64) {
        self.dashed(points, color, width, &[]);
    }

    /// A line with gaps.
    pub fn dashed(&mut self, points: Vec<DVec2>, color: Color, width: f64, dashes: &'static [f64]) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line {
                points,
                color,
                width,
                dashes,
            });
        }
    }

    /// A filled polygon.
    pub fn polygon(&mut self, points: Vec<DVec2>, color: Color) {
        self.shapes.push(Shape::Polygon { points, color });
    }

    /// Words.
    pub fn text(&mut self, at: DVec2, anchor: Anchor, size: f64, color: Color, words: &str) {
        self.shapes.push(Shape::Text(Text {
            at,
            anchor,
            size,
            color,
            words: words.to_owned(),
        }));
    }

    /// A picture.
    pub fn picture(&mut self, at: DVec2, size: DVec2, pixels: Pixels) {
        self.shapes.push(Shape::Picture { at, size, pixels });
    }

    /// The drawing as an SVG document.
    pub fn svg(&self) -> String {
        let (w, h) = (self.size.x, self.size.y);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" font-family=\"'DejaVu Serif', Georgia, serif\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n"
        );
        for shape in &self.shapes {
            out += &shape.svg();
            out.push('\n');
        }
        out + "</svg>\n"
    }
}

impl Shape {
    fn svg(&self) -> String {
        match self {
            Shape::Line {
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
                    places(points),
                    hex(*color)
                )
            }
            Shape::Polygon { points, color } => {
                format!(
                    "<polygon points=\"{}\" fill=\"{}\"/>",
                    places(points),
                    hex(*color)
                )
            }
            Shape::Text(text) => text.svg(),
            Shape::Picture { at, size, pixels } => format!(
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" \
                 href=\"data:image/png;base64,{}\"/>",
                round(at.x),
                round(at.y),
                round(size.x),
                round(size.y),
                base64(&pixels.png())
            ),
        }
    }
}

impl Text {
    fn svg(&self) -> String {
        let anchor = match self.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        format!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{anchor}\">{}</text>",
            round(self.at.x),
            round(self.at.y),
            self.size,
            hex(self.color),
            escaped(&self.words)
        )
    }
}

impl Pixels {
    fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing into memory does not fail.
        let _ =
            azulejo_formats::picture::png::write(self.width, self.height, &self.rgb, &mut bytes);
        bytes
    }
}

fn places(points: &[DVec2]) -> String {
    let place = |p: &DVec2| format!("{},{}", round(p.x), round(p.y));
    points.iter().map(place).collect::<Vec<_>>().join(" ")
}

fn list(numbers: impl Iterator<Item = f64>) -> String {
    numbers.map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

/// Two decimals are finer than any screen.
fn round(x: f64) -> f64 {
    (100.0 * x).round() / 100.0
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// Bytes as letters, RFC 4648.
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
    fn bytes_become_letters() {
        let check = |bytes: &str, expected: &str| assert_eq!(base64(bytes.as_bytes()), expected);
        check("", "");
        check("f", "Zg==");
        check("fo", "Zm8=");
        check("foo", "Zm9v");
        check("foobar", "Zm9vYmFy");
    }

    #[test]
    fn a_drawing_is_xml() {
        let mut drawing = Drawing::new(20.0, 10.0);
        drawing.text(DVec2::ONE, Anchor::Middle, 12.0, INK, "a < b & c");
        drawing.dashed(
            vec![DVec2::ZERO, DVec2::new(1.234567, 2.0)],
            INK,
            2.0,
            &[4.0, 2.0],
        );
        let svg = drawing.svg();
        for part in [
            "a &lt; b &amp; c",
            "0,0 1.23,2",
            "dasharray=\"4 2\"",
            "middle",
        ] {
            assert!(svg.contains(part), "{part} is not in {svg}");
        }
    }
}
