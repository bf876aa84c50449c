//! What designers set of a font: its OpenType features, and the axes of variable fonts.

use super::face::{FontFace, Typeface};
use harfrust::{Feature, Tag};
use read_fonts::TableProvider;
use read_fonts::model::variation::Variation;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// A feature of OpenType that is switched, as in `smcp`, `liga=0` or `salt=2`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FontFeature {
    tag: Tag,
    value: u32,
}

/// A value on an axis of a variable font, as in `wght=650`.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisValue {
    tag: Tag,
    value: f32,
}

/// An axis of a variable font, and where on it the typeface is.
#[derive(Clone, Debug, PartialEq)]
pub struct FontAxis {
    /// Its tag, as `wght`.
    pub tag: String,
    /// Least, default and largest value.
    pub range: [f32; 3],
    /// The value of this typeface.
    pub value: f32,
}

/// Why a font has no instance at given values.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum VariationError {
    /// No font has this axis; the axes there are.
    NoAxis(String, Vec<FontAxis>),
    /// The value is outside of an axis.
    OutOfRange(f32, FontAxis),
}

impl FromStr for FontFeature {
    type Err = String;

    fn from_str(text: &str) -> Result<FontFeature, String> {
        let (name, value) = text.split_once('=').unwrap_or((text, "1"));
        let value = match value {
            "on" => Some(1),
            "off" => Some(0),
            number => number.parse().ok(),
        };
        let expected = "expected a feature of four letters, as in smcp, liga=0 or salt=2";
        match (tag(name), value) {
            (Some(tag), Some(value)) => Ok(FontFeature { tag, value }),
            _ => Err(expected.to_owned()),
        }
    }
}

impl FromStr for AxisValue {
    type Err = String;

    fn from_str(text: &str) -> Result<AxisValue, String> {
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        let value = value.parse().ok().filter(|v: &f32| v.is_finite());
        let expected = "expected an axis of four letters and its value, as in wght=650";
        match (tag(name), value) {
            (Some(tag), Some(value)) => Ok(AxisValue { tag, value }),
            _ => Err(expected.to_owned()),
        }
    }
}

/// A tag of one to four visible characters of ASCII; shorter ones are filled with blanks.
fn tag(name: &str) -> Option<Tag> {
    let is_spelled = name.bytes().all(|b| b.is_ascii_graphic());
    Tag::new_checked(name.as_bytes())
        .ok()
        .filter(|_| is_spelled)
}

impl FontFeature {
    /// The feature for all letters.
    pub(super) fn everywhere(&self) -> Feature {
        Feature::new(self.tag, self.value, ..)
    }

    /// Its tag, as `liga`.
    pub fn tag(&self) -> String {
        self.tag.to_string()
    }
}

impl fmt::Display for FontAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, default, largest] = self.range;
        write!(f, "{} {least} to {largest}", self.tag)?;
        if self.value == default && default == least && self.tag == "wght" {
            f.write_str(" (the lightest is its default)")
        } else if self.value == default {
            write!(f, " (default {default})")
        } else {
            write!(f, " (here {})", self.value)
        }
    }
}

impl fmt::Display for VariationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            VariationError::NoAxis(tag, axes) if axes.is_empty() => {
                write!(f, "no font has an axis {tag}: none is variable")
            }
            VariationError::NoAxis(tag, axes) => {
                let axes: Vec<String> = axes.iter().map(FontAxis::to_string).collect();
                write!(f, "no font has an axis {tag}, expected {}", axes.join(", "))
            }
            VariationError::OutOfRange(value, axis) => {
                let [least, _, largest] = axis.range;
                let tag = &axis.tag;
                write!(f, "{tag}={value}: expected {tag} from {least} to {largest}")
            }
        }
    }
}

impl std::error::Error for VariationError {}

impl Typeface {
    /// Its axes; none if it is not variable.
    pub fn axes(&self) -> Vec<FontAxis> {
        let axis = |axis: read_fonts::model::variation::Axis| {
            let own = self.variations.iter().rev().find(|v| v.tag == axis.tag());
            FontAxis {
                tag: axis.tag().to_string(),
                range: [axis.min_value(), axis.default_value(), axis.max_value()],
                value: own.map_or(axis.default_value(), |v| v.value),
            }
        };
        self.file.axes().iter().map(axis).collect()
    }

    /// The name of its instance, such as `SemiBold`; `None` if the font has no name for it.
    pub fn instance(&self) -> Option<String> {
        let here: Vec<f32> = self.axes().iter().map(|axis| axis.value).collect();
        let instances = self.file.named_instances();
        let named = instances
            .iter()
            .find(|i| i.user_coords().eq(here.iter().copied()))?;
        let name = self.file.names().get(named.subfamily_name())?;
        Some(name.english_or_first()?.name().chars().collect())
    }

    /// The tags of the features that it has; `None` of fonts of Apple's tables, which do not list them by tag.
    pub fn features(&self) -> Option<BTreeSet<String>> {
        let tables = self.file.tables();
        if tables.morx().is_ok() {
            return None;
        }
        let (gsub, gpos) = (tables.gsub(), tables.gpos());
        let lists = [
            gsub.ok().and_then(|t| t.feature_list().ok()),
            gpos.ok().and_then(|t| t.feature_list().ok()),
        ];
        let records = lists
            .iter()
            .flatten()
            .flat_map(|list| list.feature_records());
        let mut tags: BTreeSet<String> = records.map(|r| r.feature_tag().to_string()).collect();
        // Older fonts kern by a table, those of Type 1 by a file.
        if tables.kern().is_ok() || !self.kerning.is_empty() {
            tags.insert("kern".to_owned());
        }
        Some(tags)
    }
}

/// Sets axes of all fonts that have them.
///
/// # Errors
/// An axis that no font has, and a value that one of them does not reach.
pub fn vary(fonts: &mut [FontFace], values: &[AxisValue]) -> Result<(), VariationError> {
    let typefaces = |fonts: &[FontFace]| -> Vec<FontAxis> {
        fonts
            .iter()
            .filter_map(FontFace::typeface)
            .flat_map(Typeface::axes)
            .collect()
    };
    let axes = typefaces(fonts);
    for wanted in values {
        let tag = wanted.tag.to_string();
        let mut own = axes.iter().filter(|a| a.tag == tag).peekable();
        if own.peek().is_none() {
            return Err(VariationError::NoAxis(tag, axes));
        }
        let reaches = |a: &&FontAxis| (a.range[0]..=a.range[2]).contains(&wanted.value);
        if let Some(short) = own.find(|a| !reaches(a)) {
            return Err(VariationError::OutOfRange(wanted.value, short.clone()));
        }
    }
    let variation = |v: &AxisValue| Variation::new(v.tag, v.value);
    let variations: Vec<Variation> = values.iter().map(variation).collect();
    for font in fonts {
        if let FontFace::Typeface(typeface) = font {
            let builder = typeface.file.instance_builder();
            typeface.file = builder.variations(&variations).build();
            typeface.variations.clone_from(&variations);
        }
    }
    Ok(())
}
