//! Reading legacy VTK files, 1.0 to 5.1, as text or binary (always big-endian).

use super::super::array::{DataArray, Values};
use super::grid::{Grid, Problem};
use super::scalar::{Scalar, Unreadable};

pub(super) fn read(bytes: &[u8]) -> Result<Grid, Problem> {
    let mut reader = Reader::start(bytes)?;
    let mut grid = Grid::default();
    let mut read = ReadSoFar::default();
    while let Some(line) = reader.keyword_line() {
        let words = Words::of(line);
        match words.keyword.as_str() {
            "DATASET" if words.text(0) == "UNSTRUCTURED_GRID" => read.grid = true,
            "DATASET" => return Err(Problem::NoGrid),
            "METADATA" => reader.skip_metadata(),
            // Facts about the file as a whole, which a mesh has no place for.
            "FIELD" if read.section.is_none() => {
                reader.field(&words, None)?;
            }
            "POINTS" => {
                let count = reader.count(&words, 0)?;
                let scalar = reader.scalar(words.text(1))?;
                grid.set_points(reader.numbers("POINTS", scalar, count, 3)?)?;
            }
            "CELLS" => reader.cells(&words, &mut grid)?,
            "CELL_TYPES" => {
                let count = reader.count(&words, 0)?;
                grid.set_types(reader.numbers("CELL_TYPES", Scalar::I32, count, 1)?)?;
            }
            "POINT_DATA" => {
                read.section = Some(reader.section(&words, "POINT_DATA", grid.points.len())?);
            }
            "CELL_DATA" => {
                read.section = Some(reader.section(&words, "CELL_DATA", grid.offsets.len())?);
            }
            other => {
                let Some(section) = read.section else {
                    return Err(reader.problem(format!("\"{other}\" is not expected here")));
                };
                let arrays = reader.attribute(&words, section)?;
                match section.name {
                    "POINT_DATA" => grid.point_data.extend(arrays),
                    _ => grid.cell_data.extend(arrays),
                }
            }
        }
    }
    match (read.grid, grid.types.len() == grid.offsets.len()) {
        (false, _) => Err(Problem::NoGrid),
        (_, false) => Err(Problem::Other(
            "there are not as many cell types as cells".into(),
        )),
        _ => Ok(grid),
    }
}

#[derive(Default)]
struct ReadSoFar {
    grid: bool,
    section: Option<Section>,
}

/// `POINT_DATA` or `CELL_DATA`, and how many points or cells there are.
#[derive(Clone, Copy)]
struct Section {
    name: &'static str,
    count: usize,
}

/// A line of keywords.
struct Words {
    keyword: String,
    rest: Vec<String>,
}

impl Words {
    fn of(line: &[u8]) -> Self {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace().map(str::to_owned);
        Self {
            keyword: words.next().unwrap_or_default().to_ascii_uppercase(),
            rest: words.collect(),
        }
    }
    fn text(&self, k: usize) -> &str {
        self.rest.get(k).map_or("", String::as_str)
    }
}

struct Reader<'a> {
    all: &'a [u8],
    /// What was not read yet.
    left: &'a [u8],
    binary: bool,
}

impl<'a> Reader<'a> {
    fn start(bytes: &'a [u8]) -> Result<Self, Problem> {
        let mut reader = Self {
            all: bytes,
            left: bytes,
            binary: false,
        };
        if !reader.line().starts_with(b"# vtk DataFile Version") {
            return Err(Problem::Other(
                "the file does not start as a legacy VTK file does".into(),
            ));
        }
        let _title = reader.line();
        reader.binary = match reader.line().trim_ascii().to_ascii_uppercase().as_slice() {
            b"ASCII" => false,
            b"BINARY" => true,
            _ => return Err(reader.problem("neither ASCII nor BINARY".into())),
        };
        Ok(reader)
    }

    /// With the line that was read last.
    fn problem(&self, reason: String) -> Problem {
        let read = &self.all[..self.all.len() - self.left.len()];
        let read = read.strip_suffix(b"\n").unwrap_or(read);
        let line = 1 + read.iter().filter(|&&b| b == b'\n').count();
        Problem::Line { line, reason }
    }

    /// The next line without its end.
    fn line(&mut self) -> &'a [u8] {
        let end = self.left.iter().position(|&b| b == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.left[..end], &self.left[end + 1..]),
            None => (self.left, &[][..]),
        };
        self.left = rest;
        line.strip_suffix(b"\r").unwrap_or(line)
    }

    /// The next line that is not empty; `None` at the end of the file.
    fn keyword_line(&mut self) -> Option<&'a [u8]> {
        self.left = self.left.trim_ascii_start();
        (!self.left.is_empty()).then(|| self.line())
    }

    /// The next word of a text.
    fn word(&mut self) -> Option<&'a [u8]> {
        let text = self.left.trim_ascii_start();
        let end = text
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.left = rest;
        (!word.is_empty()).then_some(word)
    }

    /// Everything up to an empty line.
    fn skip_metadata(&mut self) {
        while !self.left.is_empty() && !self.line().trim_ascii().is_empty() {}
    }

    fn count(&self, words: &Words, k: usize) -> Result<usize, Problem> {
        let text = words.text(k);
        text.parse()
            .map_err(|_| self.problem(format!("{}: \"{text}\" is no count", words.keyword)))
    }

    fn scalar(&self, name: &str) -> Result<Scalar, Problem> {
        Scalar::of_legacy(&name.to_ascii_lowercase())
            .ok_or_else(|| self.problem(format!("the number type \"{name}\" is not known")))
    }

    /// `tuples` times `components` numbers. Nothing is set aside that the rest of the file could
    /// not fill.
    fn numbers(
        &mut self,
        name: &str,
        scalar: Scalar,
        tuples: usize,
        components: usize,
    ) -> Result<Values, Problem> {
        let short = |reader: &Self| {
            reader.problem(format!(
                "{name}: the file ends before {tuples} times {components} numbers"
            ))
        };
        let count = tuples.checked_mul(components).ok_or_else(|| short(self))?;
        if self.binary {
            let taken = scalar
                .bytes_of(count)
                .and_then(|n| self.left.split_at_checked(n));
            let (bytes, rest) = taken.ok_or_else(|| short(self))?;
            self.left = rest;
            return Ok(scalar.decode(bytes, false, count));
        }
        let room = self.left.len();
        let words = std::iter::from_fn(|| self.word());
        let values = scalar.parse(words, count, room);
        values.map_err(|why| match why {
            Unreadable::End { .. } => short(self),
            Unreadable::Word(word) => {
                self.problem(format!("{name}: \"{word}\" is no number of its type"))
            }
        })
    }

    /// Since 5.0 the cells are offsets and connectivity, before each cell led with its length.
    fn cells(&mut self, words: &Words, grid: &mut Grid) -> Result<(), Problem> {
        let (first, second) = (self.count(words, 0)?, self.count(words, 1)?);
        if self.left.trim_ascii_start().starts_with(b"OFFSETS") {
            return self.cells_by_offsets(first, second, grid);
        }
        let values = self.numbers("CELLS", Scalar::I32, second, 1)?;
        let (mut nodes, mut ends) = (Vec::new(), Vec::new());
        let Values::Integers(values) = values else {
            return Err(self.problem("CELLS: no whole numbers".into()));
        };
        let mut rest = values.as_slice();
        while let Some((&length, after)) = rest.split_first() {
            let cell = usize::try_from(length)
                .ok()
                .and_then(|n| after.split_at_checked(n));
            let (cell, after) = cell.ok_or_else(|| {
                self.problem(format!("CELLS: cell {} has {length} points", ends.len()))
            })?;
            nodes.extend_from_slice(cell);
            ends.push(nodes.len() as i64);
            rest = after;
        }
        if ends.len() != first {
            let found = ends.len();
            return Err(self.problem(format!(
                "CELLS: {first} cells are announced, {found} follow"
            )));
        }
        grid.set_offsets(Values::Integers(ends))?;
        grid.set_connectivity(Values::Integers(nodes))
    }

    fn cells_by_offsets(
        &mut self,
        offsets: usize,
        length: usize,
        grid: &mut Grid,
    ) -> Result<(), Problem> {
        let mut part = |keyword: &str, count| {
            let words = Words::of(self.keyword_line().unwrap_or_default());
            if words.keyword != keyword {
                return Err(self.problem(format!("CELLS: {keyword} is missing")));
            }
            let scalar = self.scalar(words.text(0))?;
            self.numbers(keyword, scalar, count, 1)
        };
        let starts = part("OFFSETS", offsets)?;
        let nodes = part("CONNECTIVITY", length)?;
        let ends = match starts {
            Values::Integers(mut starts) if starts.first() == Some(&0) => starts.split_off(1),
            Values::Integers(starts) if starts.is_empty() => starts,
            _ => return Err(self.problem("OFFSETS: the first is not 0".into())),
        };
        if grid.set_offsets(Values::Integers(ends))? != length {
            return Err(self.problem("OFFSETS: the last is not the length of CONNECTIVITY".into()));
        }
        grid.set_connectivity(nodes)
    }

    fn section(
        &self,
        words: &Words,
        name: &'static str,
        expected: usize,
    ) -> Result<Section, Problem> {
        let count = self.count(words, 0)?;
        if count != expected {
            let reason = format!("{name} {count}: the grid has {expected}");
            return Err(self.problem(reason));
        }
        Ok(Section { name, count })
    }

    /// One data set attribute, as "VTK File Formats" lists them.
    fn attribute(&mut self, words: &Words, section: Section) -> Result<Vec<DataArray>, Problem> {
        let (name, kind) = (decode_name(words.text(0)), words.text(1));
        let components = match words.keyword.as_str() {
            "FIELD" => return self.field(words, Some(section)),
            "LOOKUP_TABLE" => {
                let colors = self.count(words, 1)?;
                let scalar = if self.binary { Scalar::U8 } else { Scalar::F32 };
                self.numbers(&name, scalar, colors, 4)?;
                return Ok(Vec::new());
            }
            "COLOR_SCALARS" => return self.colors(name, words, section),
            "SCALARS" if words.text(2).is_empty() => 1,
            "SCALARS" | "TEXTURE_COORDINATES" => {
                let given = if words.keyword == "SCALARS" { 2 } else { 1 };
                self.count(words, given)?
            }
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
            other => return Err(self.problem(format!("\"{other}\" is not known"))),
        };
        let kind = match words.keyword.as_str() {
            "TEXTURE_COORDINATES" => words.text(2),
            _ => kind,
        };
        if words.keyword == "SCALARS" {
            let before = self.left;
            let table = self.keyword_line().unwrap_or_default();
            if Words::of(table).keyword != "LOOKUP_TABLE" {
                self.left = before;
            }
        }
        let array = self.array(name, kind, section.count, components)?;
        Ok(array.into_iter().collect())
    }

    /// Colors from 0 to 1; binary files hold them as bytes.
    fn colors(
        &mut self,
        name: String,
        words: &Words,
        section: Section,
    ) -> Result<Vec<DataArray>, Problem> {
        let components = self.count(words, 1)?;
        let scalar = if self.binary { Scalar::U8 } else { Scalar::F32 };
        let values = match self.numbers(&name, scalar, section.count, components)? {
            Values::Integers(v) => v.iter().map(|&x| x as f64 / 255.0).collect(),
            Values::Floats(v) => v,
        };
        Ok(vec![DataArray {
            name,
            components,
            values: Values::Floats(values),
        }])
    }

    /// Named arrays; each says its own size, which must be that of its section.
    fn field(
        &mut self,
        words: &Words,
        section: Option<Section>,
    ) -> Result<Vec<DataArray>, Problem> {
        let mut arrays = Vec::new();
        for _ in 0..self.count(words, 1)? {
            let line = loop {
                let line = self.keyword_line().ok_or_else(|| {
                    self.problem(format!("the file ends within FIELD {}", words.text(0)))
                })?;
                if line.trim_ascii() != b"METADATA" {
                    break line;
                }
                self.skip_metadata();
            };
            let head = String::from_utf8_lossy(line).into_owned();
            let mut head = head.split_ascii_whitespace();
            let name = decode_name(head.next().unwrap_or_default());
            let mut count = || head.next().and_then(|word| word.parse::<usize>().ok());
            let (Some(components), Some(tuples)) = (count(), count()) else {
                return Err(self.problem(format!("\"{name}\" does not say its size")));
            };
            if let Some(section) = section.filter(|section| section.count != tuples) {
                return Err(self.problem(format!(
                    "the {} array \"{name}\" has {tuples} entries, the grid needs {}",
                    section.name, section.count
                )));
            }
            arrays.extend(self.array(name, head.next().unwrap_or_default(), tuples, components)?);
        }
        Ok(arrays)
    }

    /// `None` for an array of texts.
    fn array(
        &mut self,
        name: String,
        kind: &str,
        tuples: usize,
        components: usize,
    ) -> Result<Option<DataArray>, Problem> {
        if matches!(kind, "string" | "utf8_string") {
            self.skip_texts(&name, tuples, components)?;
            return Ok(None);
        }
        let scalar = self.scalar(kind)?;
        let values = self.numbers(&name, scalar, tuples, components)?;
        Ok(Some(DataArray {
            name,
            components,
            values,
        }))
    }

    /// Texts are lines, or in binary files bytes behind their length, whose own length is in the
    /// two highest bits of its first byte.
    fn skip_texts(&mut self, name: &str, tuples: usize, components: usize) -> Result<(), Problem> {
        let mut left = tuples.saturating_mul(components);
        while left > 0 {
            left -= 1;
            if self.left.is_empty() {
                return Err(self.problem(format!("{name}: the file ends before its texts")));
            }
            if !self.binary {
                self.line();
                continue;
            }
            let size = [8, 4, 2, 1][usize::from(self.left[0] >> 6)];
            let rest = self.left.split_at_checked(size).and_then(|(head, rest)| {
                let mut word = [0; 8];
                word[8 - size..].copy_from_slice(head);
                word[8 - size] &= 0x3F;
                let length = usize::try_from(u64::from_be_bytes(word)).ok()?;
                rest.get(length..)
            });
            let cut = || self.problem(format!("{name}: the file ends within a text"));
            self.left = rest.ok_or_else(cut)?;
        }
        Ok(())
    }
}

/// VTK writes a space in a name as `%20`, and so whatever else is no plain character.
fn decode_name(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut name = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = bytes.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        let code = code.filter(|digits| digits.iter().all(u8::is_ascii_hexdigit));
        let code = code.and_then(|digits| str::from_utf8(digits).ok());
        match code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                name.push(byte);
                at += 3;
            }
            None => {
                name.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&name).into_owned()
}
