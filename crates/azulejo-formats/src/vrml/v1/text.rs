//! AsciiText as flat letters in the plane z = 0.

use super::node::V1Node;
use super::walk::V1Traversal;
use crate::ReadError;
use crate::vrml::faces::{self, Binding, BoundPool, FaceSet};
use crate::vrml::text::{Justification, TextStyle, request};

impl<'d> V1Traversal<'d, '_, '_> {
    /// An AsciiText in the current FontStyle: seen from both sides, in the first of the current materials.
    pub fn text(&mut self, node: &'d V1Node<'d>) -> Result<(), ReadError> {
        let style = self.style_of(node);
        let strings: Vec<String> = (node.words("string").iter().map(|s| s.to_string())).collect();
        let widths = node.numbers("width").unwrap_or(&[]);
        let place = (self.source, node.at);
        let flat = (self.builder).flat_text(&strings, widths, 0.0, &style, place)?;
        if flat.positions.is_empty() {
            return Ok(());
        }
        let uvs = BoundPool {
            values: &flat.uvs,
            index: None,
            binding: Binding::PerVertexIndexed,
        };
        let set = FaceSet {
            positions: &flat.positions,
            coord_index: &flat.coord_index,
            colors: None,
            normals: None,
            uvs: self.state.texture.map(|_| uvs),
            ccw: true,
            crease_angle: 0.0,
            drop_unused: false,
        };
        self.builder.spend(set.cost())?;
        let mut mesh = faces::build(&set).mesh;
        self.map_texture(&mut mesh);
        mesh.face_materials.fill(self.material(0, true, false));
        self.put(node, mesh);
        Ok(())
    }

    fn style_of(&self, node: &V1Node) -> TextStyle {
        let font = self.state.font;
        let word = |field: &str| font.map_or("", |font| font.word(field));
        let along = match node.word("justification") {
            "RIGHT" => Justification::End,
            "CENTER" => Justification::Middle,
            _ => Justification::Begin,
        };
        TextStyle {
            // The style may be several words: BOLD | ITALIC.
            request: request(
                Some(word("family")).into_iter(),
                &font.map_or(String::new(), |font| font.words("style").concat()),
            ),
            size: font.map_or(10.0, |font| font.number("size", 10.0)),
            spacing: node.number("spacing", 1.0),
            is_horizontal: true,
            left_to_right: true,
            top_to_bottom: true,
            justify: [along, Justification::First],
        }
    }
}
