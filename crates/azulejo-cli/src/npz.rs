//! NumPy's `.npz`: `.npy` files in a ZIP archive, stored without compression.
//!
//! Form factors hardly compress, and a stored archive is a page of code: local headers, data,
//! a central directory (*PKWARE APPNOTE* 6.3, sections 4.3 and 4.5.3). Sizes are always in
//! 64 bits, because a matrix passes 4 GiB without effort.

use std::io::{self, Write};

/// Writes archive members one after the other; [`finish`](Archive::finish) writes the directory.
pub struct Archive<W: Write> {
    out: W,
    position: u64,
    members: Vec<Member>,
}

struct Member {
    name: String,
    offset: u64,
    length: u64,
    crc: u32,
}

/// "Version needed": 4.5, the first with 64-bit sizes.
const VERSION: u16 = 45;
/// 1 January 1980, midnight: the archive depends on its content alone.
const DATE: u16 = 0x21;

impl<W: Write> Archive<W> {
    /// An archive without members.
    pub fn new(out: W) -> Archive<W> {
        Archive {
            out,
            position: 0,
            members: Vec::new(),
        }
    }

    /// Adds a member. `write` runs twice and must write the same both times: a first run finds
    /// length and checksum, which stand before the data, so that nothing is held in memory.
    pub fn add(
        &mut self,
        name: &str,
        write: impl Fn(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut counter = Counter::default();
        write(&mut counter)?;
        let member = Member {
            name: name.to_owned(),
            offset: self.position,
            length: counter.length,
            crc: counter.crc.finalize(),
        };
        let header = member.local_header();
        self.out.write_all(&header)?;
        write(&mut self.out)?;
        self.position += header.len() as u64 + member.length;
        self.members.push(member);
        Ok(())
    }

    /// Writes the directory and gives the writer back.
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
    /// What both headers share: flags, method, time, date, checksum, sizes and name length.
    fn common(&self) -> Vec<u8> {
        let mut bytes = [VERSION, 0, 0, 0, DATE].map(u16::to_le_bytes).concat();
        bytes.extend(
            [self.crc, u32::MAX, u32::MAX]
                .map(u32::to_le_bytes)
                .concat(),
        );
        bytes.extend((self.name.len() as u16).to_le_bytes());
        bytes
    }

    fn local_header(&self) -> Vec<u8> {
        let mut bytes = b"PK\x03\x04".to_vec();
        bytes.extend(self.common());
        bytes.extend(20u16.to_le_bytes());
        bytes.extend(self.name.as_bytes());
        bytes.extend([1u16, 16].map(u16::to_le_bytes).concat());
        bytes.extend([self.length; 2].map(u64::to_le_bytes).concat());
        bytes
    }

    fn directory_entry(&self) -> Vec<u8> {
        let mut bytes = b"PK\x01\x02".to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.common());
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

/// Counts and sums what is written to it.
#[derive(Default)]
struct Counter {
    length: u64,
    crc: crc32fast::Hasher,
}

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.length += bytes.len() as u64;
        self.crc.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_stand_where_the_format_wants_them() {
        let mut archive = Archive::new(Vec::new());
        archive.add("a.npy", |w| w.write_all(b"123456789")).unwrap();
        archive.add("b.npy", |w| w.write_all(b"")).unwrap();
        let bytes = archive.finish().unwrap();
        // The checksum of "123456789" is CRC-32's published check value.
        assert_eq!(bytes[14..18], 0xcbf4_3926u32.to_le_bytes());
        let data = 30 + 5 + 20;
        assert_eq!(&bytes[data..data + 9], b"123456789");
        let second = data + 9;
        assert_eq!(&bytes[second..second + 4], b"PK\x03\x04");
        let directory = second + 30 + 5 + 20;
        assert_eq!(&bytes[directory..directory + 4], b"PK\x01\x02");
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        let record = end - 20 - 56;
        assert_eq!(&bytes[record..record + 4], b"PK\x06\x06");
        assert_eq!(
            bytes[record + 48..record + 56],
            (directory as u64).to_le_bytes()
        );
        assert_eq!(directory + 2 * (46 + 5 + 28), record);
    }
}
