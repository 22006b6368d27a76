//! Damage to files, the same in every run, and how much of it the tests of readers try.
#![allow(dead_code)] // Crates share this file.

/// How often each reader meets its damage, in multiples of the counts that stand beside it. With this all
/// readers together (meshes, scenes and their tables, curves, settings, files of material points, saved
/// benchmarks) take about a minute of processor time in a build without optimization.
pub const EFFORT: usize = 6;

/// Marsaglia's xorshift: the same damage in every run.
pub struct Damage(pub u64);

/// What a hand or a broken program puts into tables and JSON.
const TOKENS: [&str; 20] = [
    "NaN",
    "1e999",
    "-1",
    "4294967296",
    "18446744073709551616",
    "0",
    "-0.0",
    "1e-320",
    "null",
    "true",
    "\"",
    "{",
    "}",
    "[",
    "]",
    ",",
    ",,",
    "\r",
    "\u{feff}",
    "µ",
];

impl Damage {
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound.max(1)
    }

    /// One to three changes of a text.
    pub fn of(&mut self, text: &str) -> Vec<u8> {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=self.below(3) {
            let at = self.below(bytes.len());
            let end = (at + self.below(24)).min(bytes.len());
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let piece = bytes[at..end].to_vec();
                    let place = self.below(bytes.len());
                    bytes.splice(place..place, piece);
                }
                3 => {
                    let byte = self.below(256) as u8;
                    bytes.splice(at..end.min(at + 1), [byte]);
                }
                _ => {
                    let token = TOKENS[self.below(TOKENS.len())];
                    // In place of a number or a word.
                    let length = bytes[at..]
                        .iter()
                        .take_while(|b| b.is_ascii_alphanumeric())
                        .count();
                    bytes.splice(at..at + length, token.bytes());
                }
            }
        }
        bytes
    }
}
