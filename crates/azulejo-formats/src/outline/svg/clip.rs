//! What clips an element: the shapes that its property names.

use super::style::Style;
use super::values::transform;
use super::walk::{PendingElement, SvgWalk};
use crate::ReadError;
use crate::outline::clip::Clip;
use azulejo_scene::figure::Rectangle;
use azulejo_scene::{Figure, FillRule};
use glam::DAffine2;
use std::rc::Rc;

/// Deepest nesting of clip paths; deeper ones, and thereby those that clip themselves, are not applied.
const DEEPEST: u32 = 8;

impl<'a, 'i> SvgWalk<'a, 'i> {
    /// What an element with the property `clip-path` is clipped by: all that clips what is around it, and the shapes that
    /// the property names. `bounds` are those of the element's own outline, in its coordinates, where it is a shape.
    ///
    /// # Errors
    /// The drawing expands to more than the options allow.
    pub(super) fn clip(
        &mut self,
        site: &PendingElement<'a, 'i>,
        property: &str,
        bounds: Option<Rectangle>,
    ) -> Result<Option<Rc<Clip>>, ReadError> {
        let outer = site.clip.clone();
        let link = property
            .trim()
            .strip_prefix("url(")
            .and_then(|rest| rest.split_once(')'));
        let Some((link, _)) = link else {
            self.warn("clip-path that names no element: not applied", site.element);
            return Ok(outer);
        };
        let id = link
            .trim()
            .trim_matches(['"', '\''])
            .trim_start_matches('#');
        let target = self.ids.get(id).copied();
        let Some(target) = target.filter(|t| t.tag_name().name() == "clipPath") else {
            self.warn("clip-path that does not exist: not applied", site.element);
            return Ok(outer);
        };
        if self.clip_depth == DEEPEST {
            let message = format!("clip-path nested more than {DEEPEST} deep: not applied");
            self.warn(message, site.element);
            return Ok(outer);
        }
        let mut map = site.map;
        if let Some(own) = target.attribute("transform") {
            map *= transform(own).unwrap_or(DAffine2::IDENTITY);
        }
        if target.attribute("clipPathUnits") == Some("objectBoundingBox") {
            let Some(bounds) = bounds else {
                let message = "clip-path in units of the box of a group: not applied";
                self.warn(message, site.element);
                return Ok(outer);
            };
            map *= DAffine2::from_scale_angle_translation(bounds.size(), 0.0, bounds.min);
        }
        let inside = PendingElement {
            element: target,
            map,
            style: Style::default(),
            is_clip: true,
            ..site.clone()
        };
        self.clip_depth += 1;
        let figure = self.figure_of_children(inside);
        self.clip_depth -= 1;
        Ok(Some(Clip::new(figure?, outer)))
    }

    /// All that the children of a clip path fill, as one figure.
    fn figure_of_children(&mut self, inside: PendingElement<'a, 'i>) -> Result<Figure, ReadError> {
        // What clips the clip path itself has the same coordinates.
        let own = Style::default().of(inside.element, &self.sheet, inside.view);
        let property = own.and_then(|(_, own)| own.clip);
        let clip = match property {
            Some(property) => {
                let plain = PendingElement {
                    clip: None,
                    ..inside.clone()
                };
                self.clip(&plain, &property, None)?
            }
            None => None,
        };
        let outside = std::mem::take(&mut self.shapes);
        let walked = self.children(PendingElement { clip, ..inside });
        let shapes = std::mem::replace(&mut self.shapes, outside);
        walked?;
        let figures: Vec<&Figure> = shapes.iter().map(|shape| &shape.figure).collect();
        Ok(match figures[..] {
            [] => Figure::default(),
            [only] if only.rule == FillRule::NonZero => only.clone(),
            _ => Figure::union(&figures),
        })
    }
}
