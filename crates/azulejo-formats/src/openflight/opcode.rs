//! Record opcodes.

/// First record of a file.
pub const HEADER: u16 = 1;
pub const GROUP: u16 = 2;
/// Level of detail with integer distances.
pub const OLD_LOD: u16 = 3;
pub const OBJECT: u16 = 4;
pub const FACE: u16 = 5;
pub const PUSH: u16 = 10;
pub const POP: u16 = 11;
/// Degree of freedom.
pub const DOF: u16 = 14;
pub const PUSH_SUBFACE: u16 = 19;
pub const POP_SUBFACE: u16 = 20;
pub const PUSH_EXTENSION: u16 = 21;
pub const POP_EXTENSION: u16 = 22;
pub const CONTINUATION: u16 = 23;
pub const COLOR_PALETTE: u16 = 32;
pub const LONG_ID: u16 = 33;
pub const MATRIX: u16 = 49;
/// Binary space partition.
pub const BSP: u16 = 55;
pub const REPLICATE: u16 = 60;
pub const TRANSLATE: u16 = 78;
pub const INSTANCE_REFERENCE: u16 = 61;
pub const INSTANCE_DEFINITION: u16 = 62;
pub const EXTERNAL_REFERENCE: u16 = 63;
pub const TEXTURE_PALETTE: u16 = 64;
/// All 64 materials in one record, before revision 15.
pub const OLD_MATERIAL_PALETTE: u16 = 66;
pub const VERTEX_PALETTE: u16 = 67;
/// Vertex with colour.
pub const VERTEX_C: u16 = 68;
/// Vertex with colour and normal.
pub const VERTEX_CN: u16 = 69;
/// Vertex with colour, normal and texture coordinates.
pub const VERTEX_CNT: u16 = 70;
/// Vertex with colour and texture coordinates.
pub const VERTEX_CT: u16 = 71;
pub const VERTEX_LIST: u16 = 72;
/// Level of detail.
pub const LOD: u16 = 73;
pub const MESH: u16 = 84;
pub const LOCAL_VERTEX_POOL: u16 = 85;
pub const MESH_PRIMITIVE: u16 = 86;
pub const MORPH_VERTEX_LIST: u16 = 89;
pub const SWITCH: u16 = 96;
pub const CLIP_REGION: u16 = 98;
pub const EXTENSION: u16 = 100;
pub const LIGHT_SOURCE: u16 = 101;
pub const LIGHT_SOURCE_PALETTE: u16 = 102;
pub const MATERIAL_PALETTE: u16 = 113;
pub const PUSH_ATTRIBUTE: u16 = 122;
pub const POP_ATTRIBUTE: u16 = 123;

/// The role of a record in the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpcodeRole {
    /// Begins the children of the node before it.
    Push,
    /// Ends them.
    Pop,
    /// A node, which may have children.
    Node,
    /// Belongs to the node before it, and is used.
    Ancillary,
    /// Belongs to the file as a whole, and is used.
    Palette,
    /// Does not affect the appearance, or repeats the content of another record.
    Silent,
    /// Is not supported.
    Skipped,
}

impl OpcodeRole {
    pub fn of(opcode: u16) -> OpcodeRole {
        match opcode {
            PUSH | PUSH_SUBFACE | PUSH_EXTENSION | PUSH_ATTRIBUTE => OpcodeRole::Push,
            POP | POP_SUBFACE | POP_EXTENSION | POP_ATTRIBUTE => OpcodeRole::Pop,
            // Light points, curves, sounds and the like are nodes, too: their children must not be
            // assigned to their siblings.
            HEADER..=FACE | DOF | BSP | INSTANCE_REFERENCE..=EXTERNAL_REFERENCE => OpcodeRole::Node,
            VERTEX_LIST | LOD | MESH | MESH_PRIMITIVE | MORPH_VERTEX_LIST => OpcodeRole::Node,
            SWITCH | CLIP_REGION | EXTENSION | LIGHT_SOURCE => OpcodeRole::Node,
            87 | 91 | 92 | 95 | 111 | 115 | 116 | 126 | 127 | 130 | 131 => OpcodeRole::Node,
            LONG_ID | MATRIX | REPLICATE | TRANSLATE | LOCAL_VERTEX_POOL => OpcodeRole::Ancillary,
            COLOR_PALETTE | TEXTURE_PALETTE | OLD_MATERIAL_PALETTE => OpcodeRole::Palette,
            VERTEX_PALETTE..=VERTEX_CT | LIGHT_SOURCE_PALETTE | MATERIAL_PALETTE => {
                OpcodeRole::Palette
            }
            // Comments, the other individual transforms of a matrix, bounding volumes, names of switch
            // masks.
            31 | 74 | 76 | 77 | 79..=82 | 94 | 105..=110 | 119 | 132 => OpcodeRole::Silent,
            _ => OpcodeRole::Skipped,
        }
    }
}

/// The name of a record type, for messages.
pub fn name(opcode: u16) -> &'static str {
    match opcode {
        HEADER => "header",
        GROUP => "group",
        OLD_LOD => "level of detail (old)",
        OBJECT => "object",
        FACE => "face",
        7 => "absolute vertex (before revision 13)",
        8 => "shaded vertex (before revision 13)",
        9 => "normal vertex (before revision 13)",
        PUSH..=POP => "push or pop",
        DOF => "degree of freedom",
        PUSH_SUBFACE..=POP_EXTENSION => "push or pop of sub-faces or extensions",
        CONTINUATION => "continuation",
        31 => "comment",
        COLOR_PALETTE => "colour palette",
        LONG_ID => "long ID",
        MATRIX => "matrix",
        50 => "vector",
        52 => "multitexture",
        53 => "UV list",
        BSP => "binary space partition",
        REPLICATE => "replicate",
        INSTANCE_REFERENCE => "instance reference",
        INSTANCE_DEFINITION => "instance definition",
        EXTERNAL_REFERENCE => "external reference",
        TEXTURE_PALETTE => "texture palette",
        OLD_MATERIAL_PALETTE => "material palette (old)",
        VERTEX_PALETTE => "vertex palette",
        VERTEX_C..=VERTEX_CT => "vertex",
        VERTEX_LIST => "vertex list",
        LOD => "level of detail",
        74 => "bounding box",
        76..=82 => "transform",
        83 => "eyepoint and trackplane palette",
        MESH => "mesh",
        LOCAL_VERTEX_POOL => "local vertex pool",
        MESH_PRIMITIVE => "mesh primitive",
        87 => "road segment",
        88 => "road zone",
        MORPH_VERTEX_LIST => "morph vertex list",
        90 => "linkage palette",
        91 => "sound",
        92 => "road path",
        93 => "sound palette",
        94 => "general matrix",
        95 => "text",
        SWITCH => "switch",
        97 => "line style palette",
        CLIP_REGION => "clip region",
        EXTENSION => "extension",
        LIGHT_SOURCE => "light source",
        LIGHT_SOURCE_PALETTE => "light source palette",
        105..=110 | 119 => "bounding volume",
        111 => "light point",
        112 => "texture mapping palette",
        MATERIAL_PALETTE => "material palette",
        114 => "name table",
        115 => "continuously adaptive terrain",
        116 => "continuously adaptive terrain data",
        PUSH_ATTRIBUTE..=POP_ATTRIBUTE => "push or pop of attributes",
        125 => "adaptive attribute",
        126 => "curve",
        127 => "road construction",
        128 => "light point appearance palette",
        129 => "light point animation palette",
        130 => "indexed light point",
        131 => "light point system",
        132 => "indexed string",
        133 => "shader palette",
        _ => "record of unknown type",
    }
}
