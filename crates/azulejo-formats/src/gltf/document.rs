//! Parses and checks the JSON document, as far as possible without the buffers.

use super::container::Container;
use super::messages::GltfMessages;
use crate::ReadError;
use crate::reading::text::{shortened, text};
use gltf_json::validation::{Checked, Error, Validate};
use gltf_json::{Path, Root, mesh::Semantic};

/// Extensions that a file may require.
const SUPPORTED: [&str; 23] = [
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    super::meshopt::NAMES[0],
    super::meshopt::NAMES[1],
    "EXT_texture_webp",
    super::draco::DRACO,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    // KTX2, whose Basis Universal is refused picture by picture.
    "KHR_texture_basisu",
    "KHR_texture_transform",
    super::lightmap::OF_MATERIALS,
    super::lightmap::OF_NODES,
    super::pictures::BRIGHT_PICTURES,
    "MSFT_texture_dds",
    // These affect neither the geometry nor the light at rest.
    "KHR_animation_pointer",
    "KHR_xmp_json_ld",
    "KHR_node_visibility",
];

/// Least number of bytes in the file for each JSON object. In memory an empty `{}` is as large as a
/// complete material, and a hostile file may consist of nothing else.
const BYTES_PER_OBJECT: usize = 20;

/// Number of objects that are accepted in a file of any size.
const FREE_OBJECTS: usize = 1000;

/// Parses and checks the JSON of a file.
///
/// # Errors
/// Text that is not JSON or not glTF 2.0, with its position; indices out of range; required
/// extensions that are not supported.
pub(super) fn parse(
    container: &Container,
    file: &str,
    messages: &mut GltfMessages,
) -> Result<Root, ReadError> {
    let objects = container.json.iter().filter(|b| **b == b'{').count();
    if objects.saturating_sub(FREE_OBJECTS) > container.json.len() / BYTES_PER_OBJECT {
        let found = format!(
            "{objects} objects in {} bytes of JSON",
            container.json.len()
        );
        return Err(ReadError::whole(
            file,
            found,
            "fewer objects without content",
        ));
    }
    let json = super::animations::blanked(container.json, messages);
    let mut root = Root::from_slice(&json).map_err(|e| malformed(&e, container, file))?;
    check_version(&root, file)?;
    check_extensions(&mut root, file, messages)?;
    check(&root, file, messages)?;
    Ok(root)
}

/// The error for malformed JSON, or values of other types than glTF's.
fn malformed(e: &gltf_json::Error, container: &Container, file: &str) -> ReadError {
    let message = e.to_string();
    let what = message.split(" at line ").next().unwrap_or(&message);
    let (line, column) = (e.line(), e.column());
    let expected = match version_of(container.json) {
        Some(version) if !version.starts_with('2') => {
            return ReadError::whole(file, format!("glTF {version}"), "glTF 2.0");
        }
        _ => "glTF 2.0",
    };
    match container.json_start {
        Some(start) => {
            let before = container.json.split_inclusive(|b| *b == b'\n');
            let lines: usize = before.take(line.saturating_sub(1)).map(<[u8]>::len).sum();
            let at = start + (lines + column.saturating_sub(1)) as u64;
            ReadError::at_byte(file, at, what, expected)
        }
        None => {
            let (line, column) = (line.max(1) as u32, column.max(1) as u32);
            ReadError::at_line(file, &text(container.json), line, column, what, expected)
        }
    }
}

/// The version that the JSON declares, if it is JSON at all.
fn version_of(json: &[u8]) -> Option<String> {
    let value: serde_json::Value = serde_json::from_slice(json).ok()?;
    Some(value.get("asset")?.get("version")?.as_str()?.to_owned())
}

fn check_version(root: &Root, file: &str) -> Result<(), ReadError> {
    let (version, least) = (&root.asset.version, root.asset.min_version.as_deref());
    if version.starts_with('2') && least.is_none_or(|v| v.starts_with("2.0")) {
        return Ok(());
    }
    let found = format!("glTF {}", shortened(least.unwrap_or(version)));
    Err(ReadError::whole(file, found, "glTF 2.0"))
}

/// Rejects unsupported required extensions; warns about unsupported optional ones.
fn check_extensions(
    root: &mut Root,
    file: &str,
    messages: &mut GltfMessages,
) -> Result<(), ReadError> {
    for name in root.extensions_required.drain(..) {
        if !SUPPORTED.contains(&name.as_str()) {
            let found = format!("the required extension \"{}\"", shortened(&name));
            return Err(ReadError::whole(
                file,
                found,
                "a file that does not require it",
            ));
        }
    }
    for name in &root.extensions_used {
        if !SUPPORTED.contains(&name.as_str()) {
            messages.whole(&format!("extension \"{}\": not used", shortened(name)));
        }
    }
    Ok(())
}

/// Checks indices and enumerations by the rules of `gltf-json`; some of its errors do not
/// matter for a reader that examines the data itself.
fn check(root: &Root, file: &str, messages: &mut GltfMessages) -> Result<(), ReadError> {
    check_positions(root, file)?;
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        if first.is_some() {
            return;
        }
        let path = path();
        match consequence(path.as_str(), error) {
            Consequence::None => {}
            Consequence::Warning(message) => messages.of(message, || path.0),
            Consequence::Error => first = Some((path, error)),
        }
    });
    let Some((path, error)) = first else {
        return Ok(());
    };
    let found = match error {
        Error::IndexOutOfBounds => "an index out of range",
        Error::Missing => "nothing",
        Error::Oversize => "a number too large",
        Error::Invalid | Error::Unsupported => "a value that is not valid in glTF",
    };
    let path = shortened(path.as_str());
    Err(ReadError::whole(
        file,
        format!("{found} at {path}"),
        "valid glTF 2.0",
    ))
}

/// The validation of `gltf-json` looks up positions before it has checked their index.
fn check_positions(root: &Root, file: &str) -> Result<(), ReadError> {
    let key = Checked::Valid(Semantic::Positions);
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let index = primitive.attributes.get(&key);
            if index.is_some_and(|i| root.get(*i).is_none()) {
                let found = format!("an index out of range at meshes[{m}].primitives[{p}]");
                return Err(ReadError::whole(file, found, "valid glTF 2.0"));
            }
        }
    }
    Ok(())
}

enum Consequence {
    None,
    Warning(&'static str),
    Error,
}

fn consequence(path: &str, error: Error) -> Consequence {
    use Consequence::{None, Warning};
    let bound = path.ends_with("[\"POSITION\"].min") || path.ends_with("[\"POSITION\"].max");
    match error {
        // Integer positions (KHR_mesh_quantization) have bounds beyond the range of a single.
        Error::Invalid if bound => None,
        Error::Missing if bound => Warning("positions without min and max, which glTF requires"),
        Error::Missing if path.ends_with("[\"POSITION\"]") => None,
        // Zeros, or compressed with the rest of a primitive.
        Error::Missing if path.starts_with("accessors[") && path.ends_with("].bufferView") => None,
        Error::Invalid if path.contains(".attributes[") => {
            Warning("vertex attribute with an unknown name: skipped")
        }
        _ => Consequence::Error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(json: &str, expected: Result<usize, &str>) {
        let mut messages = GltfMessages::default();
        let container = Container {
            json: json.as_bytes(),
            json_start: None,
            bin: None,
        };
        match (parse(&container, "a.gltf", &mut messages), expected) {
            (Ok(_), Ok(warned)) => {
                let mut warnings = crate::reading::warnings::Warnings::default();
                messages.report("a.gltf", &mut warnings);
                assert_eq!(warnings.finish("a.gltf").len(), warned, "{json}");
            }
            (Err(e), Err(part)) => assert!(e.to_string().contains(part), "{e}"),
            (parsed, _) => panic!("{json}: {parsed:?}"),
        }
    }

    fn with(more: &str) -> String {
        format!("{{\"asset\":{{\"version\":\"2.0\"}}{more}}}")
    }

    #[test]
    fn versions() {
        check(&with(""), Ok(0));
        check("{}", Err("a.gltf:1:2: found missing field `asset`"));
        check("{\"asset\":{\"version\":\"1.0\"}}", Err("found glTF 1.0"));
        let old = "{\"asset\":{\"version\":\"1.0\"},\"meshes\":{}}";
        check(old, Err("found glTF 1.0, expected glTF 2.0"));
        check("{\n \"asset\": 7 }", Err("a.gltf:2:11"));
        let newer = "{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}";
        check(newer, Err("found glTF 2.1"));
    }

    #[test]
    fn extensions() {
        check(
            &with(",\"extensionsRequired\":[\"KHR_mesh_quantization\"]"),
            Ok(0),
        );
        check(
            &with(",\"extensionsUsed\":[\"EXT_x\",\"KHR_materials_ior\"]"),
            Ok(1),
        );
        check(
            &with(",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
            Ok(0),
        );
        check(
            &with(",\"extensionsRequired\":[\"X\"]"),
            Err("the required extension \"X\""),
        );
    }

    #[test]
    fn indices() {
        check(&with(",\"nodes\":[{\"mesh\":0}]"), Err("nodes[0].mesh"));
        let primitive = |p| with(&format!(",\"meshes\":[{{\"primitives\":[{p}]}}]"));
        let far = primitive("{\"attributes\":{\"POSITION\":7}}");
        check(
            &far,
            Err("an index out of range at meshes[0].primitives[0]"),
        );
        check(&primitive("{\"attributes\":{}}"), Ok(0));
        check(
            &with(",\"animations\":[{\"channels\":[],\"samplers\":[],\"x\":1}]"),
            Ok(1),
        );
    }

    #[test]
    fn many_empty_objects_are_refused() {
        let nodes = |n: usize| with(&format!(",\"nodes\":[{}{{}}]", "{},".repeat(n)));
        check(&nodes(900), Ok(0));
        check(&nodes(9000), Err("9003 objects in"));
    }
}
