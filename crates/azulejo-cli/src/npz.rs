//! NumPy's `.npz`: `.npy` files in a ZIP archive, stored without compression.
//!
//! Form factors hardly compress. Checksum and length of a member follow its data in a data
//! descriptor, so that members are streamed in one pass and nothing is held in memory (*PKWARE
//! APPNOTE* 6.3, sections 4.3 and 4.5.3). Sizes are always in 64 bits (ZIP64), because matrices of
//! more than 4 GiB are common.

use std::io::{self, BufWriter, Write};

/// Writes archive members one after the other; [`finish`](Archive::finish) writes the directory.
pub struct Archive<W: Write> {
    out: W,
    position: u64,
    members: Vec<Member>,
}

struct Member {
    name: String,
    /// Position of the local header.
    offset: u64,
    length: u64,
    crc: u32,
}

/// "Version needed": 4.5, the first with 64-bit sizes.
const VERSION: u16 = 45;
/// Checksum and sizes follow the data (bit 3).
const FLAGS: u16 = 1 << 3;
/// 1 January 1980, midnight: the archive depends on its content alone.
const DATE: u16 = 0x21;
/// Bytes gathered before they are added to the checksum and written.
const BUFFER: usize = 1 << 16;

impl<W: Write> Archive<W> {
    /// An archive without members.
    pub fn new(out: W) -> Archive<W> {
        Archive {
            out,
            position: 0,
            members: Vec::new(),
        }
    }

    /// Adds a member with the content that `write` writes.
    pub fn add(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut member = Member {
            name: name.to_owned(),
            offset: self.position,
            length: 0,
            crc: 0,
        };
        let header = member.local_header();
        self.out.write_all(&header)?;
        let data = Measured {
            out: &mut self.out,
            length: 0,
            crc: crc32fast::Hasher::new(),
        };
        let mut data = BufWriter::with_capacity(BUFFER, data);
        write(&mut data)?;
        let data = data.into_inner().map_err(io::IntoInnerError::into_error)?;
        (member.length, member.crc) = (data.length, data.crc.finalize());
        let descriptor = member.data_descriptor();
        self.out.write_all(&descriptor)?;
        self.position += (header.len() + descriptor.len()) as u64 + member.length;
        self.members.push(member);
        Ok(())
    }

    /// Writes the directory and returns the writer.
    pub fn finish(mut self) -> io::Result<W> {
        let directory: Vec<u8> = self
            .members
            .iter()
            .flat_map(Member::directory_entry)
            .collect();
        self.out.write_all(&directory)?;
        let (count, length, start) = (
            self.members.len() as u64,
            directory.len() as u64,
            self.position,
        );
        let mut end = Vec::new();
        end.extend(b"PK\x06\x06");
        end.extend(44u64.to_le_bytes());
        end.extend([VERSION, VERSION].map(u16::to_le_bytes).concat());
        end.extend([0u32; 2].map(u32::to_le_bytes).concat());
        end.extend([count, count, length, start].map(u64::to_le_bytes).concat());
        end.extend(b"PK\x06\x07");
        end.extend(0u32.to_le_bytes());
        end.extend((start + length).to_le_bytes());
        end.extend(1u32.to_le_bytes());
        end.extend(b"PK\x05\x06");
        end.extend([0, 0, 0xffff, 0xffff].map(u16::to_le_bytes).concat());
        end.extend([u32::MAX; 2].map(u32::to_le_bytes).concat());
        end.extend(0u16.to_le_bytes());
        self.out.write_all(&end)?;
        Ok(self.out)
    }
}

impl Member {
    /// The fields that both headers share, from the flags to the length of the name. The sizes are
    /// in the ZIP64 field.
    fn common(&self, crc: u32) -> Vec<u8> {
        let mut bytes = [VERSION, FLAGS, 0, 0, DATE].map(u16::to_le_bytes).concat();
        bytes.extend([crc, u32::MAX, u32::MAX].map(u32::to_le_bytes).concat());
        bytes.extend((self.name.len() as u16).to_le_bytes());
        bytes
    }

    /// The header before the data, in which checksum and sizes are zero.
    fn local_header(&self) -> Vec<u8> {
        let mut bytes = b"PK\x03\x04".to_vec();
        bytes.extend(self.common(0));
        bytes.extend(20u16.to_le_bytes());
        bytes.extend(self.name.as_bytes());
        bytes.extend([1u16, 16].map(u16::to_le_bytes).concat());
        bytes.extend([0u64; 2].map(u64::to_le_bytes).concat());
        bytes
    }

    /// What follows the data: its sizes have 64 bits because the local header has a ZIP64 field.
    fn data_descriptor(&self) -> Vec<u8> {
        let mut bytes = b"PK\x07\x08".to_vec();
        bytes.extend(self.crc.to_le_bytes());
        bytes.extend([self.length; 2].map(u64::to_le_bytes).concat());
        bytes
    }

    fn directory_entry(&self) -> Vec<u8> {
        let mut bytes = b"PK\x01\x02".to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.common(self.crc));
        bytes.extend([28u16, 0, 0, 0].map(u16::to_le_bytes).concat());
        bytes.extend([0, u32::MAX].map(u32::to_le_bytes).concat());
        bytes.extend(self.name.as_bytes());
        bytes.extend([1u16, 24].map(u16::to_le_bytes).concat());
        bytes.extend(
            [self.length, self.length, self.offset]
                .map(u64::to_le_bytes)
                .concat(),
        );
        bytes
    }
}

/// A writer that computes the length and the checksum of what passes through it.
struct Measured<W> {
    out: W,
    length: u64,
    crc: crc32fast::Hasher,
}

impl<W: Write> Write for Measured<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.length += count as u64;
        self.crc.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn u16_at(bytes: &[u8], at: usize) -> usize {
        usize::from(u16::from_le_bytes(*bytes[at..].first_chunk().unwrap()))
    }

    fn u64_at(bytes: &[u8], at: usize) -> usize {
        u64::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize
    }

    /// Names and contents of the members of an archive, found through its directory, with their
    /// checksums compared.
    pub(crate) fn members(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
        let record = bytes.len() - 22 - 20 - 56;
        assert_eq!(&bytes[record..record + 4], b"PK\x06\x06");
        let (count, mut at) = (u64_at(bytes, record + 32), u64_at(bytes, record + 48));
        let mut members = Vec::new();
        for _ in 0..count {
            let entry = &bytes[at..];
            assert_eq!(&entry[..4], b"PK\x01\x02");
            let name = &entry[46..46 + u16_at(entry, 28)];
            let extra = 46 + name.len();
            let (length, offset) = (u64_at(entry, extra + 4), u64_at(entry, extra + 20));
            let local = &bytes[offset..];
            assert_eq!(&local[..4], b"PK\x03\x04");
            let start = 30 + u16_at(local, 26) + u16_at(local, 28);
            let data = &local[start..start + length];
            let after = &local[start + length..];
            assert_eq!(&after[..4], b"PK\x07\x08");
            assert_eq!(after[4..8], entry[16..20]);
            assert_eq!(crc32fast::hash(data).to_le_bytes(), entry[16..20]);
            assert_eq!([u64_at(after, 8), u64_at(after, 16)], [length; 2]);
            let name = String::from_utf8(name.to_vec()).unwrap();
            members.push((name, data.to_vec()));
            at += extra + u16_at(entry, 30);
        }
        assert_eq!(at, record);
        members
    }

    #[test]
    fn members_are_found_through_the_directory() {
        let mut archive = Archive::new(Vec::new());
        archive.add("a.npy", |w| w.write_all(b"123456789")).unwrap();
        archive.add("b.npy", |w| w.write_all(b"")).unwrap();
        let bytes = archive.finish().unwrap();
        let expected = [("a.npy", &b"123456789"[..]), ("b.npy", b"")];
        assert_eq!(
            members(&bytes),
            expected.map(|(n, b)| (n.to_owned(), b.to_vec()))
        );
        // The checksum of "123456789" is CRC-32's published check value.
        let descriptor = 30 + 5 + 20 + 9;
        assert_eq!(
            bytes[descriptor + 4..descriptor + 8],
            0xcbf4_3926u32.to_le_bytes()
        );
        assert_eq!(&bytes[bytes.len() - 22..][..4], b"PK\x05\x06");
    }

    #[test]
    fn sizes_and_offsets_have_64_bits() {
        let member = Member {
            name: "a".to_owned(),
            offset: 6 << 32,
            length: 5 << 32,
            crc: 0,
        };
        let entry = member.directory_entry();
        assert_eq!(u64_at(&entry, 46 + 1 + 4), 5 << 32);
        assert_eq!(u64_at(&entry, 46 + 1 + 20), 6 << 32);
        assert_eq!(u64_at(&member.data_descriptor(), 8), 5 << 32);
    }
}
