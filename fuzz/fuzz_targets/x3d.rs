//! Any bytes as X3D in XML: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, vrml};
use libfuzzer_sys::fuzz_target;

const PARTS: &str = "<X3D><Scene><ProtoDeclare name='A'><ProtoInterface>
  <field name='r' type='SFFloat' accessType='initializeOnly' value='1'/></ProtoInterface><ProtoBody>
  <Shape><Sphere><IS><connect nodeField='radius' protoField='r'/></IS></Sphere></Shape>
  </ProtoBody></ProtoDeclare><ProtoInstance name='A'/></Scene></X3D>";

fuzz_target!(|bytes: &[u8]| {
    let text = match bytes.starts_with(b"<") {
        true => bytes.to_vec(),
        false => [b"<X3D><Scene>", bytes, b"</Scene></X3D>"].concat(),
    };
    let options = ReadOptions::in_proportion(text.len());
    let files = Memory::new().with("a.x3d", PARTS);
    if let Ok(loaded) = vrml::read(&text, "fuzz.x3d", &files, &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
    }
});
