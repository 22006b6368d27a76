//! Base64 as VTK writes it: a header and the data behind it may each have an end of their own.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
const NONE: u8 = 64;

const fn values() -> [u8; 256] {
    let mut table = [NONE; 256];
    let mut k = 0;
    while k < 64 {
        table[ALPHABET[k] as usize] = k as u8;
        k += 1;
    }
    table
}
const VALUES: [u8; 256] = values();

/// Decodes text piece by piece; white space is skipped, and text goes on after a padded end.
pub(super) struct Decoder<'a> {
    text: &'a [u8],
    group: [u8; 3],
    /// The bytes of the group that were not asked for yet.
    left: std::ops::Range<usize>,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self {
            text,
            group: [0; 3],
            left: 0..0,
        }
    }

    /// The most bytes that can still come.
    pub(super) fn available(&self) -> usize {
        self.left.len() + self.text.len() / 4 * 3
    }

    /// The next `count` bytes; `None` where the text ends or is no base64.
    pub(super) fn take(&mut self, count: usize) -> Option<Vec<u8>> {
        if count > self.available() {
            return None;
        }
        let mut bytes = Vec::with_capacity(count);
        while bytes.len() < count {
            if self.left.is_empty() {
                self.next_group()?;
            }
            let end = self.left.end.min(self.left.start + count - bytes.len());
            bytes.extend_from_slice(&self.group[self.left.start..end]);
            self.left.start = end;
        }
        Some(bytes)
    }

    fn next_group(&mut self) -> Option<()> {
        let mut four = [0; 4];
        let mut found = 0;
        while found < 4 {
            let (&byte, rest) = self.text.split_first()?;
            self.text = rest;
            if !byte.is_ascii_whitespace() {
                four[found] = byte;
                found += 1;
            }
        }
        let length = match four {
            [_, _, b'=', b'='] => 1,
            [_, _, _, b'='] => 2,
            _ => 3,
        };
        let mut bits = 0_u32;
        for (k, &byte) in four.iter().enumerate() {
            let value = VALUES[byte as usize];
            if value == NONE && k <= length {
                return None;
            }
            bits = bits << 6 | u32::from(value % NONE);
        }
        self.group = [(bits >> 16) as u8, (bits >> 8) as u8, bits as u8];
        self.left = 0..length;
        Some(())
    }
}

/// Appends the bytes as base64, padded at the end.
pub(super) fn encode(bytes: &[u8], out: &mut Vec<u8>) {
    for group in bytes.chunks(3) {
        let mut three = [0; 3];
        three[..group.len()].copy_from_slice(group);
        let bits = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for k in 0..4 {
            let digit = (bits >> (18 - 6 * k)) as usize & 63;
            out.push(if k <= group.len() {
                ALPHABET[digit]
            } else {
                b'='
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn the_vectors_of_the_standard() {
        for (plain, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut out = Vec::new();
            encode(plain.as_bytes(), &mut out);
            assert_eq!(out, text.as_bytes());
            let back = Decoder::new(text.as_bytes()).take(plain.len());
            assert_eq!(back.as_deref(), Some(plain.as_bytes()));
        }
    }

    #[test]
    fn pieces_may_end_anywhere_and_padding_may_stand_in_the_middle() {
        let mut decoder = Decoder::new(b" Zg==Zm\n8=Zm9v YmFy");
        assert_eq!(decoder.take(2).as_deref(), Some(&b"ff"[..]));
        assert_eq!(decoder.take(3).as_deref(), Some(&b"ofo"[..]));
        assert_eq!(decoder.take(5), None);
        assert_eq!(decoder.take(4).as_deref(), Some(&b"obar"[..]));
        assert_eq!(decoder.take(1), None);
        assert_eq!(Decoder::new(b"Zm9").take(1), None);
        assert_eq!(Decoder::new(b"Z*9v").take(1), None);
        assert_eq!(Decoder::new(b"=m9v").take(1), None);
        assert_eq!(Decoder::new(b"Zm9v").take(usize::MAX), None);
    }
}
