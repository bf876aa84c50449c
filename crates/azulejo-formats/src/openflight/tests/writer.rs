//! Writes small OpenFlight files, record by record.

use super::super::opcode::*;

/// One record.
#[derive(Clone)]
pub struct FltRecord(pub Vec<u8>);

impl FltRecord {
    /// A record of zeros.
    pub fn new(opcode: u16, length: u16) -> FltRecord {
        FltRecord(vec![0; length.into()])
            .bytes(0, &opcode.to_be_bytes())
            .bytes(2, &length.to_be_bytes())
    }

    pub fn bytes(mut self, at: usize, bytes: &[u8]) -> FltRecord {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
        self
    }

    pub fn text(self, at: usize, text: &str) -> FltRecord {
        self.bytes(at, text.as_bytes())
    }

    pub fn u8(self, at: usize, value: u8) -> FltRecord {
        self.bytes(at, &[value])
    }

    pub fn u16(self, at: usize, value: u16) -> FltRecord {
        self.bytes(at, &value.to_be_bytes())
    }

    pub fn u32(self, at: usize, value: u32) -> FltRecord {
        self.bytes(at, &value.to_be_bytes())
    }

    pub fn singles(self, at: usize, values: &[f32]) -> FltRecord {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        self.bytes(at, &bytes)
    }

    pub fn doubles(self, at: usize, values: &[f64]) -> FltRecord {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        self.bytes(at, &bytes)
    }

    /// Appends bytes to the record and updates its length.
    pub fn more(mut self, bytes: &[u8]) -> FltRecord {
        self.0.extend(bytes);
        let length = self.0.len() as u16;
        self.bytes(2, &length.to_be_bytes())
    }

    /// Gives a node its name.
    pub fn named(self, name: &str) -> FltRecord {
        self.text(4, name)
    }
}

/// A header of a revision, in metres.
pub fn header(revision: u32) -> FltRecord {
    FltRecord::new(HEADER, 324).named("db").u32(12, revision)
}

pub fn group(name: &str) -> FltRecord {
    FltRecord::new(GROUP, 44).named(name)
}

pub fn object(name: &str) -> FltRecord {
    FltRecord::new(OBJECT, 28).named(name)
}

/// A white face without material and texture.
pub fn face() -> FltRecord {
    FltRecord::new(FACE, 80)
        .u16(28, u16::MAX)
        .u16(30, u16::MAX)
        .u32(44, 1 << 30)
}

/// A mesh of the same kind.
pub fn mesh() -> FltRecord {
    FltRecord::new(MESH, 84)
        .u16(32, u16::MAX)
        .u16(34, u16::MAX)
        .u32(48, 1 << 30)
}

/// A vertex with a packed colour of its own.
pub fn vertex(position: [f64; 3], abgr: u32) -> FltRecord {
    FltRecord::new(VERTEX_C, 40)
        .u16(6, 0x1000)
        .doubles(8, &position)
        .u32(32, abgr)
}

/// Offsets in the vertex palette.
pub fn vertex_list(offsets: &[u32]) -> FltRecord {
    let bytes: Vec<u8> = offsets.iter().flat_map(|o| o.to_be_bytes()).collect();
    FltRecord::new(VERTEX_LIST, 4).more(&bytes)
}

/// A translation matrix.
pub fn translation(x: f32, y: f32, z: f32) -> FltRecord {
    matrix([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, y, z]])
}

/// A matrix by its rows.
pub fn matrix(rows: [[f32; 3]; 4]) -> FltRecord {
    let row = |record: FltRecord, k: usize| record.singles(4 + 16 * k, &rows[k]);
    (0..4)
        .fold(FltRecord::new(MATRIX, 68), row)
        .singles(64, &[1.0])
}

/// A file under construction.
#[derive(Clone)]
pub struct Flt(pub Vec<u8>);

impl Flt {
    /// A file of revision 16 with the corners of the unit square, white, in its palette.
    pub fn new() -> Flt {
        Flt::of(header(1600)).square()
    }

    pub fn of(header: FltRecord) -> Flt {
        Flt(header.0)
    }

    /// The vertices at [`CORNERS`].
    pub fn square(self) -> Flt {
        let white = |x, y| vertex([x, y, 0.0], 0xffff_ffff);
        self.palette(vec![
            white(0.0, 0.0),
            white(1.0, 0.0),
            white(1.0, 1.0),
            white(0.0, 1.0),
        ])
    }

    /// A palette of vertices.
    pub fn palette(self, vertices: Vec<FltRecord>) -> Flt {
        let start = self.add(FltRecord::new(VERTEX_PALETTE, 8));
        vertices.into_iter().fold(start, Flt::add)
    }

    pub fn add(mut self, record: FltRecord) -> Flt {
        self.0.extend(record.0);
        self
    }

    /// Adds children to the node that was added last.
    pub fn with(self, children: impl FnOnce(Flt) -> Flt) -> Flt {
        let pushed = self.add(FltRecord::new(PUSH, 4));
        children(pushed).add(FltRecord::new(POP, 4))
    }

    /// A face, the unit square.
    pub fn face(self, face: FltRecord) -> Flt {
        self.add(face).with(|f| f.add(vertex_list(&CORNERS)))
    }

    /// Adds a node with its ancillary records, and a face below it.
    pub fn node(self, node: FltRecord, ancillary: &[FltRecord]) -> Flt {
        let flt = self.add(node);
        let flt = ancillary.iter().cloned().fold(flt, Flt::add);
        flt.with(|f| f.face(face()))
    }
}

/// Offsets of the corners of the unit square.
pub const CORNERS: [u32; 4] = [8, 48, 88, 128];
