//! Recognizes the formats of measured data.

use super::{LoadedBrdf, merl, rgl, tensors};
use crate::{ReadError, Warning};
use azulejo_scene::brdf::{Content, Measured};
use std::sync::Arc;

/// Reads measured data; `None` for anything else.
pub(crate) fn measured(bytes: &[u8], name: &str) -> Option<Result<LoadedBrdf, ReadError>> {
    if bytes.starts_with(tensors::MAGIC) {
        let rgl = rgl::read(bytes, name);
        return Some(rgl.map(|(rgl, warnings)| loaded(Measured::Rgl(Box::new(rgl)), warnings)));
    }
    if merl::is_merl(bytes) {
        let merl = merl::read(bytes, name);
        return Some(merl.map(|(merl, warnings)| loaded(Measured::Merl(merl), warnings)));
    }
    None
}

fn loaded(measured: Measured, warnings: Vec<Warning>) -> LoadedBrdf {
    LoadedBrdf {
        content: Content::Measured(Arc::new(measured)),
        warnings,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_are_known_by_their_content() {
        let bytes = rgl::tests::file(&rgl::tests::fields());
        let read = measured(&bytes, "a.binary").unwrap().unwrap();
        assert!(matches!(read.content, Content::Measured(_)));

        // A table whose size is not that of the database is recognized, and rejected.
        let bytes = merl::tests::file([6, 5, 8], "diffuse kd = 0.5");
        let error = measured(&bytes, "a.bsdf")
            .unwrap()
            .err()
            .map(|e| e.to_string());
        let expected = "a.bsdf: byte 0 (0x0): found 6, expected 90, the bins of θ_h";
        assert_eq!(error.as_deref(), Some(expected));

        assert!(measured(b"begin brdf", "a.brdf").is_none());
        assert!(measured(b"", "a.brdf").is_none());
    }

    /// Tests a table with the database's own size, once: 33 MB.
    #[test]
    fn a_whole_table_is_read() {
        let header: Vec<u8> = [90u32, 90, 180]
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect();
        let bytes = [header, 150.0f64.to_le_bytes().repeat(3 * 90 * 90 * 180)].concat();
        let read = measured(&bytes, "m").unwrap().unwrap();
        let Content::Measured(measured) = &read.content else {
            panic!("{:?}", read.content);
        };
        assert_eq!(format!("{measured:?}"), "Merl [90, 90, 180]");
        assert!(read.warnings.is_empty());
    }
}
