//! OpenEXR: lossless linear pictures.

use super::error::{MOST_PIXELS, PictureError, assert_whole, check_size, malformed};
use crate::reading::text::shortened;
use ::exr::meta::BlockDescription;
use ::exr::meta::header::Header;
use ::exr::prelude::*;
use azulejo_scene::Image as Picture;
use std::collections::HashSet;
use std::io::{self, Cursor};

/// Reads the channels R, G and B as linear values, without colour management; without them those of a
/// layer, or luminance (Y) as grey. Alpha is ignored.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, without such channels, deep, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> std::result::Result<Picture, PictureError> {
    let meta = check_headers(bytes)?;
    let channels = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels();
    macro_rules! pixels {
        ($channels:expr, $sample:pat => $pixel:expr, $samples:ty) => {
            $channels
                .collect_pixels(
                    |size, _| Picture::new(size.width() as u32, size.height() as u32),
                    |picture: &mut Picture, Vec2(x, y), $sample: $samples| {
                        picture.pixels[y * picture.width as usize + x] = $pixel;
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map_err(|error| unread(error, bytes))?
                .layer_data
                .channel_data
                .pixels
        };
    }
    let [r, g, b] = shown_channels(&meta.headers)?;
    if r == g {
        return Ok(pixels!(channels.required(r), (v,) => [v; 3], (f32,)));
    }
    let channels = channels.required(r).required(g).required(b);
    Ok(pixels!(channels, (r, g, b) => [r, g, b], (f32, f32, f32)))
}

/// Names of the channels that are shown: those without a layer, then those of the layer `Combined`, as Blender calls
/// what the camera sees, then those of the first one; colours before luminance.
fn shown_channels(headers: &[Header]) -> std::result::Result<[Text; 3], PictureError> {
    let all = || headers.iter().flat_map(|header| &header.channels.list);
    let names: Vec<String> = all().map(|channel| channel.name.to_string()).collect();
    let known: HashSet<&str> = names.iter().map(String::as_str).collect();
    let layer = |name: &str, channel: &str| {
        let layer = name.strip_suffix(channel)?;
        (layer.is_empty() || layer.ends_with('.')).then(|| layer.to_owned())
    };
    let shown = |channels: [&str; 3]| {
        let is_whole = |layer: &String| {
            let is_there = |c: &&str| known.contains(&*format!("{layer}{c}"));
            channels.iter().all(is_there)
        };
        let layers = names.iter().filter_map(|name| layer(name, channels[0]));
        let order = |layer: &String| (!layer.is_empty(), !layer.ends_with("Combined."));
        let first = layers.filter(is_whole).min_by_key(order)?;
        let names = channels.map(|c| Text::new_or_none(format!("{first}{c}")));
        let [Some(r), Some(g), Some(b)] = names else {
            return None;
        };
        Some([r, g, b])
    };
    shown(["R", "G", "B"])
        .or_else(|| shown(["Y"; 3]))
        .ok_or_else(|| {
            let names = shortened(&names.join(", "));
            malformed(format!(
                "an OpenEXR without channels R, G and B, or Y: it has {names}"
            ))
        })
}

/// What the reader does not know, by its name.
fn unread(error: Error, bytes: &[u8]) -> PictureError {
    const ATTRIBUTE: &[u8] = b"compression\0compression\0\x01\0\0\0";
    let mut places = bytes.windows(ATTRIBUTE.len());
    let at = places.position(|w| w == ATTRIBUTE);
    let number = at.and_then(|at| bytes.get(at + ATTRIBUTE.len()));
    // The numbers of OpenEXR 3.5.
    let compression = match number {
        Some(8) => "DWAA",
        Some(9) => "DWAB",
        Some(10) => "HTJ2K256",
        Some(11) => "HTJ2K32",
        Some(12) => "LJ2K",
        Some(13) => "ZSTD",
        _ => "",
    };
    if !compression.is_empty() {
        return malformed(format!(
            "an OpenEXR compressed by {compression}, which is not read; written anew with ZIP it is"
        ));
    }
    match error {
        Error::NotSupported(what) => malformed(format!("an OpenEXR that is not read: {what}")),
        other => malformed(other),
    }
}

/// Columns and rows.
pub type PictureSize = (u32, u32);

/// Reads all channels of the first layer, in the order of their names; numbers of 16 bits become
/// ones of 32.
///
/// # Errors
/// As [`read`](fn@read).
pub fn read_channels(
    bytes: &[u8],
) -> std::result::Result<(PictureSize, Vec<NamedChannel>), PictureError> {
    check_headers(bytes)?;
    let image = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| unread(error, bytes))?;
    let layer = image.layer_data;
    let channel = |channel: AnyChannel<FlatSamples>| NamedChannel {
        name: channel.name.to_string(),
        values: match channel.sample_data {
            FlatSamples::F16(v) => ChannelValues::Float(v.iter().map(|x| x.to_f32()).collect()),
            FlatSamples::F32(v) => ChannelValues::Float(v),
            FlatSamples::U32(v) => ChannelValues::Index(v),
        },
    };
    let size = (layer.size.width() as u32, layer.size.height() as u32);
    let channels = layer.channel_data.list.into_iter().map(channel);
    Ok((size, channels.collect()))
}

/// Columns and rows, from the header of the first layer alone; the others are checked when it is read.
pub(super) fn size(bytes: &[u8]) -> std::result::Result<[u64; 2], PictureError> {
    let meta = meta(bytes)?;
    let sizes = meta.headers.iter().map(|header| header.layer_size);
    let largest = sizes.max_by_key(|size| size.0.saturating_mul(size.1));
    let Vec2(width, height) = largest.ok_or_else(|| malformed("an OpenEXR without a layer"))?;
    Ok([width as u64, height as u64])
}

/// Most bytes that one byte of a file can encode: 1032 by DEFLATE, of which PXR24 makes four of three.
const MOST_BYTES_PER_BYTE: u64 = 1400;

/// A block that is always allowed, bytes: tiles may be larger than the picture.
const SMALL_BLOCK: u64 = 1 << 26;

fn meta(bytes: &[u8]) -> std::result::Result<MetaData, PictureError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false);
    meta.map_err(|error| unread(error, bytes))
}

/// The headers; rejects files of which a layer is larger than their bytes justify.
fn check_headers(bytes: &[u8]) -> std::result::Result<MetaData, PictureError> {
    let meta = meta(bytes)?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        check_size(width as u64, height as u64, bytes.len())?;
        check_bytes(header, bytes.len())?;
    }
    Ok(meta)
}

/// Rejects pictures whose pixels, with all their channels, take memory which the file's own length does
/// not justify, and those that are divided into still larger blocks: a block is allocated as a whole.
fn check_bytes(header: &Header, bytes: usize) -> std::result::Result<(), PictureError> {
    let pixel = header.channels.bytes_per_pixel as u64;
    let size = |width: usize, height: usize| {
        let pixels = (width as u64).checked_mul(height as u64);
        pixels.and_then(|n| n.checked_mul(pixel))
    };
    let Vec2(width, height) = header.layer_size;
    let block = match header.blocks {
        BlockDescription::Tiles(tiles) => size(tiles.tile_size.0, tiles.tile_size.1),
        BlockDescription::ScanLines => size(width, header.compression.scan_lines_per_block()),
    };
    let justified = (bytes as u64).saturating_mul(MOST_BYTES_PER_BYTE);
    let fits = |(whole, block): (u64, u64)| {
        whole <= justified.min(16 * MOST_PIXELS) && block <= whole.max(SMALL_BLOCK)
    };
    if size(width, height).zip(block).is_some_and(fits) {
        return Ok(());
    }
    Err(malformed(format!(
        "{width} × {height} pixels of {pixel} bytes, more than its {bytes} bytes can hold"
    )))
}

/// Writes a picture as 32-bit floats with lossless compression.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If the picture does not have `width × height` pixels.
pub fn write(image: &Picture, out: &mut dyn io::Write) -> io::Result<()> {
    assert_whole(image);
    let channel = |k: usize| NamedChannel {
        name: ["R", "G", "B"][k].to_owned(),
        values: ChannelValues::Float(image.pixels.iter().map(|pixel| pixel[k]).collect()),
    };
    let channels = (0..3).map(channel).collect();
    write_channels((image.width, image.height), channels, "", &[], out)
}

/// Largest value of half precision.
pub const MOST_HALF: f32 = 65504.0;

/// Smallest value of half precision with all of its eleven bits; below it there are fewer.
pub const LEAST_HALF: f32 = 6.103_515_6e-5;

/// Writes a picture of values 0..=[`MOST_HALF`] as 16-bit floats with lossless compression: half as large, and
/// exact to 0.05% above [`LEAST_HALF`].
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If the picture does not have `width × height` pixels.
pub fn write_half(image: &Picture, out: &mut dyn io::Write) -> io::Result<()> {
    assert_whole(image);
    let channel = |k: usize| {
        let values = image.pixels.iter().map(|pixel| f16::from_f32(pixel[k]));
        AnyChannel::new(["R", "G", "B"][k], FlatSamples::F16(values.collect()))
    };
    let channels = AnyChannels::sort((0..3).map(channel).collect());
    let size = (image.width as usize, image.height as usize);
    write_layer(size, channels, "", &[], out)
}

/// The values of one channel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Numbers of 32 bits.
    Float(Vec<f32>),
    /// Unsigned integers of 32 bits, such as indices.
    Index(Vec<u32>),
}

/// One channel of a picture of many.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedChannel {
    /// Its name; that of its layer stands before a dot, as in `albedo.R`.
    pub name: String,
    /// One value per pixel.
    pub values: ChannelValues,
}

/// Writes a picture of any channels, with lossless compression, `comments` for readers, and further `texts` by their
/// names, which have at most 31 characters. All of them are of ASCII.
///
/// # Errors
/// Errors of `out`, a picture without pixels, and channels of equal names.
///
/// # Panics
/// If a channel does not have `width × height` values.
pub fn write_channels(
    (width, height): (u32, u32),
    channels: Vec<NamedChannel>,
    comments: &str,
    texts: &[(String, String)],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let size = (width as usize, height as usize);
    let channel = |channel: NamedChannel| {
        let (count, samples) = match channel.values {
            ChannelValues::Float(v) => (v.len(), FlatSamples::F32(v)),
            ChannelValues::Index(v) => (v.len(), FlatSamples::U32(v)),
        };
        assert_eq!(count, size.0 * size.1, "values of {}", channel.name);
        AnyChannel::new(channel.name.as_str(), samples)
    };
    let channels = AnyChannels::sort(channels.into_iter().map(channel).collect());
    write_layer(size, channels, comments, texts, out)
}

fn write_layer(
    size: (usize, usize),
    channels: AnyChannels<FlatSamples>,
    comments: &str,
    texts: &[(String, String)],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes = LayerAttributes {
        comments: Text::new_or_none(comments).filter(|_| !comments.is_empty()),
        other: texts.iter().filter_map(text_attribute).collect(),
        ..LayerAttributes::default()
    };
    let layer = Layer::new(size, attributes, encoding, channels);
    // The format's table of offsets is written last, which requires a seekable target.
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|e| match e {
            Error::Io(e) => e,
            other => io::Error::new(io::ErrorKind::InvalidInput, other.to_string()),
        })?;
    let mut file = file.into_inner();
    if !texts.is_empty() {
        sort_attributes(&mut file);
    }
    out.write_all(&file)
}

fn text_attribute((name, value): &(String, String)) -> Option<(Text, AttributeValue)> {
    let value = AttributeValue::Text(Text::new_or_none(value)?);
    Some((Text::new_or_none(name)?, value))
}

/// Sorts the attributes of a file's one header by name: the library has them in the random order of its map, and equal
/// pictures shall be equal files.
fn sort_attributes(file: &mut [u8]) {
    // Magic number and version precede the header.
    const START: usize = 8;
    let mut parts: Vec<Vec<u8>> = Vec::new();
    let mut at = START;
    let ends = |from: usize| {
        file[from..]
            .iter()
            .position(|b| *b == 0)
            .map(|n| from + n + 1)
    };
    while file.get(at).is_some_and(|b| *b != 0) {
        // Name and type end with a zero each; the length of the value follows.
        let Some(length_at) = ends(at).and_then(ends) else {
            return;
        };
        let Some(&length) = file[length_at..].first_chunk::<4>() else {
            return;
        };
        let end = length_at + 4 + u32::from_le_bytes(length) as usize;
        let Some(part) = file.get(at..end) else {
            return;
        };
        parts.push(part.to_vec());
        at = end;
    }
    parts.sort();
    file[START..at].copy_from_slice(&parts.concat());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::{damage, gradient};

    #[test]
    fn nothing_is_lost() {
        for (width, height) in [(1, 1), (7, 3), (64, 33)] {
            let image = gradient(width, height);
            let mut file = Vec::new();
            write(&image, &mut file).unwrap();
            assert_eq!(read(&file).unwrap(), image);
        }
        assert!(write(&Picture::new(0, 0), &mut Vec::new()).is_err());
    }

    /// Half precision has eleven bits.
    #[test]
    fn halves_are_within_their_steps() {
        let image = gradient(31, 7);
        let (mut half, mut whole) = (Vec::new(), Vec::new());
        write_half(&image, &mut half).unwrap();
        write(&image, &mut whole).unwrap();
        let picture = read(&half).unwrap();
        assert_eq!([picture.width, picture.height], [31, 7]);
        for (a, b) in picture
            .pixels
            .as_flattened()
            .iter()
            .zip(image.pixels.as_flattened())
        {
            assert!((a - b).abs() <= b / 2048.0 + 3e-8, "{a} {b}");
        }
        assert!(half.len() < whole.len());
        let ends = Picture::opaque(2, 1, vec![[MOST_HALF, LEAST_HALF, 0.0], [1.0; 3]]);
        let mut file = Vec::new();
        write_half(&ends, &mut file).unwrap();
        assert_eq!(read(&file).unwrap(), ends);
        assert!(write_half(&Picture::new(0, 0), &mut Vec::new()).is_err());
    }

    #[test]
    fn channels_are_written_with_their_names() {
        let channel = |name: &str, values| NamedChannel {
            name: name.into(),
            values,
        };
        let channels = vec![
            channel("R", ChannelValues::Float(vec![0.5, 1.5])),
            channel("objectId", ChannelValues::Index(vec![7, 1 << 30])),
            channel("G", ChannelValues::Float(vec![0.25, -1.0])),
            channel("B", ChannelValues::Float(vec![0.0, 1e10])),
        ];
        let mut file = Vec::new();
        write_channels((2, 1), channels, "what they are", &[], &mut file).unwrap();
        assert_eq!(
            read(&file).unwrap().pixels,
            [[0.5, 0.25, 0.0], [1.5, -1.0, 1e10]]
        );
        let (size, channels) = read_channels(&file).unwrap();
        let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!((size, names), ((2, 1), vec!["B", "G", "R", "objectId"]));
        assert_eq!(channels[3].values, ChannelValues::Index(vec![7, 1 << 30]));
        assert!(String::from_utf8_lossy(&file).contains("what they are"));
        damage(&file, |bytes| read_channels(bytes).is_ok());
    }

    /// A pixel of two thousand channels, whose file is then said to be a long line or to have a large tile.
    #[test]
    fn channels_and_blocks_are_justified() {
        let names = (0..2000).map(|k| format!("c{k}"));
        let channel = |name: String| {
            let samples = FlatSamples::F32(vec![0.0]);
            AnyChannel::new(name.as_str(), samples)
        };
        let names = names.chain(["R", "G", "B"].map(str::to_owned));
        let channels = AnyChannels::sort(names.map(channel).collect());
        let file = |encoding: Encoding| {
            let attributes = LayerAttributes::default();
            let layer = Layer::new((1, 1), attributes, encoding, channels.clone());
            let mut file = Cursor::new(Vec::new());
            let image = Image::from_layer(layer);
            let writer = image.write().non_parallel();
            writer.to_buffered(&mut file).unwrap();
            file.into_inner()
        };
        // The bytes after an attribute's name, type and length.
        let changed = |mut file: Vec<u8>, name: &[u8], at: usize, value: u32| {
            let start = file.windows(name.len()).position(|w| w == name).unwrap();
            let start = start + name.len() + 4 + at;
            file[start..start + 4].copy_from_slice(&value.to_le_bytes());
            file
        };
        let lines = file(Encoding {
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
            ..Encoding::default()
        });
        assert_eq!(read(&lines).unwrap().pixels, [[0.0; 3]]);
        let wide = changed(lines, b"dataWindow\0box2i\0", 8, 1 << 20);
        let error = read(&wide).unwrap_err().to_string();
        assert!(error.contains("can hold"), "{error}");
        let tiles = file(Encoding {
            blocks: Blocks::Tiles(Vec2(64, 64)),
            ..Encoding::default()
        });
        assert_eq!(read(&tiles).unwrap().pixels, [[0.0; 3]]);
        let large = changed(tiles, b"tiles\0tiledesc\0", 0, 1 << 24);
        let error = read(&large).unwrap_err().to_string();
        assert!(error.contains("can hold"), "{error}");
    }

    /// A file of one pixel whose channels have these names and values.
    fn one_pixel(channels: &[(&str, f32)]) -> Vec<u8> {
        let channel = |&(name, value): &(&str, f32)| NamedChannel {
            name: name.into(),
            values: ChannelValues::Float(vec![value]),
        };
        let mut file = Vec::new();
        let channels = channels.iter().map(channel).collect();
        write_channels((1, 1), channels, "", &[], &mut file).unwrap();
        file
    }

    #[test]
    fn luminance_and_layers_are_read() {
        let check = |channels: &[(&str, f32)], expected: [f32; 3]| {
            let file = one_pixel(channels);
            assert_eq!(read(&file).unwrap().pixels, [expected], "{channels:?}");
            damage(&file, |bytes| read(bytes).is_ok());
        };
        check(&[("A", 1.0), ("Y", 0.25)], [0.25; 3]);
        let layer = [("albedo.B", 3.0), ("albedo.G", 2.0), ("albedo.R", 1.0)];
        check(&layer, [1.0, 2.0, 3.0]);
        let combined = [
            ("V.Combined.B", 6.0),
            ("V.Combined.G", 5.0),
            ("V.Combined.R", 4.0),
        ];
        let several = [&layer[..], &[("A.Y", 9.0)], &combined].concat();
        check(&several, [4.0, 5.0, 6.0]);
        let own = [("R", 7.0), ("G", 8.0), ("B", 9.0), ("Y", 1.0)];
        check(&[&own[..], &several].concat(), [7.0, 8.0, 9.0]);
        let error = read(&one_pixel(&[("Z", 1.0), ("xR", 0.0)])).unwrap_err();
        assert!(error.to_string().contains("it has Z, xR"), "{error}");
    }

    #[test]
    fn unknown_compressions_are_named() {
        for (number, name) in [(8, "DWAA"), (10, "HTJ2K256"), (11, "HTJ2K32"), (13, "ZSTD")] {
            let mut file = Vec::new();
            write(&Picture::new(64, 64), &mut file).unwrap();
            let start = b"compression\0compression\0\x01\0\0\0";
            let at = file.windows(start.len()).position(|w| w == start).unwrap();
            file[at + start.len()] = number;
            for error in [read(&file).map(|_| ()), size(&file).map(|_| ())] {
                let Err(error) = error else { continue };
                let error = error.to_string();
                assert!(
                    error.contains(name) && error.contains("is not read"),
                    "{error}"
                );
            }
            assert!(read(&file).is_err());
        }
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        let mut file = Vec::new();
        write(&gradient(16, 16), &mut file).unwrap();
        damage(&file, |bytes| read(bytes).is_ok());
    }
}
