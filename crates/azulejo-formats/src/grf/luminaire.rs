//! `ext light` of the kind `luminaire`: a point light with intensities by direction.

use super::entries::{EntryValue, GrfEntries};
use super::parser::{GrfParser, ParseResult};
use super::write::{GrfOutput, Number, point, rgb};
use azulejo_scene::{LightKind, PhotometricWeb, Rgb, WebType};
use glam::{DMat3, DVec3};
use std::io::{self, Write};
use std::sync::Arc;

const TYPES: [(&str, WebType); 3] = [("a", WebType::A), ("b", WebType::B), ("c", WebType::C)];

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads what comes after the kind.
    pub fn luminaire(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<LightKind> {
        let axes = self.needed(entries, "axes")?;
        let world_from_web = match &axes.value {
            EntryValue::Vectors(axes) => match axes[..] {
                [x, y, z] => frame([x, y, z].map(DVec3::from_array)),
                _ => None,
            },
            _ => None,
        };
        let Some(world_from_web) = world_from_web else {
            return Err(self.wrong(&axes, "three vectors at right angles to each other"));
        };
        let kind = self.take_choice(entries, "type", &TYPES)?;
        let kind = self.required(entries, "type", kind)?;
        let vertical = self.needed_numbers(entries, "vertical")?;
        let horizontal = self.needed_numbers(entries, "horizontal")?;
        let values = self.needed_numbers(entries, "values")?;
        let web = PhotometricWeb::new(kind, [&vertical, &horizontal], values).map_err(|wrong| {
            self.fail(
                entries.offset,
                format!("a luminaire with {wrong}"),
                "ascending angles in degrees, and an intensity for each vertical angle of each horizontal one",
            )
        })?;
        Ok(LightKind::Luminaire {
            position: self.needed_point(entries, "position")?,
            world_from_web,
            scale: self.needed_rgb(entries, "scale")?,
            web: Arc::new(web),
        })
    }

    fn needed_numbers(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<Vec<f64>> {
        let entry = self.needed(entries, key)?;
        match entry.value {
            EntryValue::Numbers(numbers) => Ok(numbers),
            _ => Err(self.wrong(&entry, "numbers")),
        }
    }
}

/// Unit vectors at right angles to each other, if they are; written ones are not changed.
fn frame(axes: [DVec3; 3]) -> Option<DMat3> {
    let frame = DMat3::from_cols(axes[0], axes[1], axes[2]);
    let product = frame.transpose() * frame;
    product.abs_diff_eq(DMat3::IDENTITY, 1e-4).then_some(frame)
}

/// Writes what comes after the kind.
pub(super) fn write(
    out: &mut GrfOutput<'_>,
    position: DVec3,
    world_from_web: &DMat3,
    scale: Rgb,
    web: &PhotometricWeb,
) -> io::Result<()> {
    let [vertical, horizontal] = web.angles();
    let kind = TYPES.iter().find(|(_, kind)| *kind == web.kind());
    let kind = kind.map_or("c", |(word, _)| *word);
    write!(
        out,
        "luminaire position = {} axes = {} {} {} scale = {} type = {kind}",
        point(position),
        point(world_from_web.x_axis),
        point(world_from_web.y_axis),
        point(world_from_web.z_axis),
        rgb(scale),
    )?;
    for (key, numbers) in [
        ("vertical", vertical),
        ("horizontal", horizontal),
        ("values", web.values()),
    ] {
        write!(out, "\n  {key} =")?;
        for (k, number) in numbers.iter().enumerate() {
            // Short enough to be looked at.
            let gap = if k > 0 && k % 16 == 0 { "\n   " } else { "" };
            write!(out, "{gap} {}", Number(*number))?;
        }
    }
    Ok(())
}
