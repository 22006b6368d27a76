//! The bytes of one array: header, blocks, compression.

use super::base64;
use std::borrow::Cow;
use std::io::Read;

/// How VTK packs the blocks of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
    /// In an .xz container.
    Lzma,
}

/// What a VTU file says once about all its binary arrays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub(super) little_endian: bool,
    /// Headers are 64-bit numbers, not 32-bit ones.
    pub(super) wide_header: bool,
    pub(super) compressor: Option<Compressor>,
}

/// Where the bytes of an array stand.
pub(super) enum Source<'a> {
    Raw(&'a [u8]),
    Base64(base64::Decoder<'a>),
}

impl<'a> Source<'a> {
    fn available(&self) -> usize {
        match self {
            Self::Raw(bytes) => bytes.len(),
            Self::Base64(decoder) => decoder.available(),
        }
    }
    fn take(&mut self, count: usize) -> Option<Cow<'a, [u8]>> {
        match self {
            Self::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count)?;
                *bytes = rest;
                Some(Cow::Borrowed(taken))
            }
            Self::Base64(decoder) => decoder.take(count).map(Cow::Owned),
        }
    }
}

/// Why the bytes of an array cannot be had.
#[derive(Debug, thiserror::Error)]
pub(super) enum Damage {
    #[error("its data ends too early or is no base64; write the file again")]
    CutOff,
    #[error("its header announces {announced} bytes, the grid needs {needed}")]
    Size { announced: u128, needed: usize },
    #[error("its header announces {0} compressed blocks, more than the file has bytes for")]
    Blocks(u64),
    #[error("its compressed block {0} is damaged, or unpacks to another size than it says")]
    Block(u64),
}

impl Encoding {
    fn word(&self, source: &mut Source<'_>) -> Result<u64, Damage> {
        let bytes = source.take(self.word_size()).ok_or(Damage::CutOff)?;
        let mut word = [0; 8];
        for (k, &byte) in bytes.iter().enumerate() {
            let at = if self.little_endian {
                k
            } else {
                bytes.len() - 1 - k
            };
            word[at] = byte;
        }
        Ok(u64::from_le_bytes(word))
    }
    fn word_size(&self) -> usize {
        if self.wide_header { 8 } else { 4 }
    }

    /// The `needed` bytes of an array. Nothing is set aside for what a header announces before it
    /// agrees with `needed`, nor for compressed data beyond what it yields.
    pub(super) fn read<'a>(
        &self,
        mut source: Source<'a>,
        needed: usize,
    ) -> Result<Cow<'a, [u8]>, Damage> {
        if needed == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        if let Some(compressor) = self.compressor {
            return self.unpack(&mut source, compressor, needed).map(Cow::Owned);
        }
        let announced = self.word(&mut source)?.into();
        if announced != needed as u128 {
            return Err(Damage::Size { announced, needed });
        }
        source.take(needed).ok_or(Damage::CutOff)
    }

    /// Header: blocks, size of a block, size of the last one (0: a full one), packed size of each.
    fn unpack(
        &self,
        source: &mut Source<'_>,
        compressor: Compressor,
        needed: usize,
    ) -> Result<Vec<u8>, Damage> {
        let [blocks, size, last] = [(); 3].map(|()| self.word(source));
        let (blocks, size, last) = (blocks?, size?, last?);
        let last = if last == 0 { size } else { last };
        let full = u128::from(blocks.saturating_sub(1)) * u128::from(size);
        let announced = if blocks == 0 {
            0
        } else {
            full + u128::from(last)
        };
        if announced != needed as u128 {
            return Err(Damage::Size { announced, needed });
        }
        if blocks > (source.available() / self.word_size()) as u64 {
            return Err(Damage::Blocks(blocks));
        }
        let packed: Vec<u64> = (0..blocks)
            .map(|_| self.word(source))
            .collect::<Result<_, _>>()?;
        let mut bytes = Vec::new();
        for (block, &length) in (0..).zip(&packed) {
            let length = usize::try_from(length).map_err(|_| Damage::CutOff)?;
            let packed = source.take(length).ok_or(Damage::CutOff)?;
            let size = if block + 1 == blocks { last } else { size };
            // Not above `needed`, which is a usize.
            compressor
                .unpack(&packed, size as usize, &mut bytes)
                .ok_or(Damage::Block(block))?;
        }
        Ok(bytes)
    }
}

/// LZ4 cannot make more than this of one byte.
const LZ4_YIELD: usize = 255;
/// The largest dictionary of VTK's LZMA; a file cannot ask for more.
const LARGEST_DICTIONARY: usize = 64 << 20;

impl Compressor {
    /// Appends what `packed` unpacks to, which must be `size` bytes.
    fn unpack(self, packed: &[u8], size: usize, out: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::Zlib => {
                let block =
                    miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(packed, size).ok()?;
                out.extend_from_slice(&block);
                (block.len() == size).then_some(())
            }
            Self::Lz4 => {
                if size > packed.len().saturating_mul(LZ4_YIELD) {
                    return None;
                }
                let start = out.len();
                out.resize(start + size, 0);
                let made = lz4_flex::block::decompress_into(packed, &mut out[start..]).ok()?;
                (made == size).then_some(())
            }
            Self::Lzma => {
                let start = out.len();
                let check = unpack_xz(packed, size, out)?;
                let right = check.is_none_or(|check| check == crc32(&out[start..]));
                (right && out.len() - start == size).then_some(())
            }
        }
    }
}

/// Unpacks the one block of an .xz stream and returns its CRC-32 where it has one
/// (The .xz File Format 1.2.1, sections 2.1.1 and 3.1).
fn unpack_xz(stream: &[u8], size: usize, out: &mut Vec<u8>) -> Option<Option<u32>> {
    let (header, rest) = stream.split_at_checked(12)?;
    if header[..7] != *b"\xFD7zXZ\0\0" || crc32(&header[6..8]) != word(&header[8..])? {
        return None;
    }
    let length = 4 * (usize::from(*rest.first()?) + 1);
    let (block_header, data) = rest.split_at_checked(length)?;
    let (fields, check) = block_header.split_at(length - 4);
    if crc32(fields) != word(check)? {
        return None;
    }
    let mut data_left = data;
    let mut reader = lzma_rust2::Lzma2Reader::new(&mut data_left, dictionary(fields, size)?, None);
    reader.by_ref().take(size as u64).read_to_end(out).ok()?;
    // One more byte would be one too many; asking for it also reads the mark of the end.
    if reader.read(&mut [0]).ok()? != 0 {
        return None;
    }
    drop(reader);
    if header[7] != 1 {
        return Some(None);
    }
    let padding = (data.len() - data_left.len()).wrapping_neg() % 4;
    word(data_left.get(padding..)?).map(Some)
}

/// The size of the dictionary from a block header with LZMA2 as its only filter.
fn dictionary(fields: &[u8], size: usize) -> Option<u32> {
    let flags = *fields.get(1)?;
    if flags & 0x3F != 0 {
        return None;
    }
    let mut at = 2;
    for present in [flags & 0x40, flags & 0x80] {
        if present != 0 {
            while *fields.get(at)? & 0x80 != 0 {
                at += 1;
            }
            at += 1;
        }
    }
    let [0x21, 1, bits] = *fields.get(at..at + 3)? else {
        return None;
    };
    let announced = match bits {
        0..40 => (2 | u64::from(bits) & 1) << (bits / 2 + 11),
        40 => u64::from(u32::MAX),
        _ => return None,
    };
    let useful = size.clamp(1 << 12, LARGEST_DICTIONARY);
    Some(announced.min(useful as u64) as u32)
}

fn word(bytes: &[u8]) -> Option<u32> {
    bytes.first_chunk().copied().map(u32::from_le_bytes)
}

/// The checksum of IEEE 802.3, bit by bit over a table of 16.
fn crc32(bytes: &[u8]) -> u32 {
    const fn table() -> [u32; 16] {
        let mut table = [0; 16];
        let mut k = 0;
        while k < 16 {
            let mut value = k as u32;
            let mut bit = 0;
            while bit < 4 {
                value = if value & 1 == 1 {
                    value >> 1 ^ 0xEDB8_8320
                } else {
                    value >> 1
                };
                bit += 1;
            }
            table[k] = value;
            k += 1;
        }
        table
    }
    const TABLE: [u32; 16] = table();
    let mut crc = !0_u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        crc = crc >> 4 ^ TABLE[(crc & 15) as usize];
        crc = crc >> 4 ^ TABLE[(crc & 15) as usize];
    }
    !crc
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_of_the_catalogue() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    /// Eight megabytes of zeros where a few bytes were asked for.
    #[test]
    fn unpacking_stops_where_it_should_end() {
        let bomb = vec![0; 8 << 20];
        let options = lzma_rust2::Lzma2Options::with_preset(6);
        let mut writer = lzma_rust2::Lzma2Writer::new(Vec::new(), options);
        std::io::Write::write_all(&mut writer, &bomb).expect("in memory");
        let fields = [2, 0, 0x21, 1, 22, 0, 0, 0];
        let mut stream = b"\xFD7zXZ\0\0\0".to_vec();
        stream.extend(crc32(&[0, 0]).to_le_bytes());
        stream.extend(fields);
        stream.extend(crc32(&fields).to_le_bytes());
        stream.extend(writer.finish().expect("in memory"));
        let mut out = Vec::new();
        assert_eq!(Compressor::Lzma.unpack(&stream, 324, &mut out), None);
        assert_eq!(out.len(), 324);
        out.clear();
        assert_eq!(
            Compressor::Lzma.unpack(&stream, bomb.len(), &mut out),
            Some(())
        );
        assert_eq!(out, bomb);
        // Four bytes cannot become a terabyte.
        let mut out = Vec::new();
        assert_eq!(
            Compressor::Lz4.unpack(&[0x10, 0, 1, 0], 1 << 40, &mut out),
            None
        );
        assert_eq!(out.capacity(), 0);
    }
}
