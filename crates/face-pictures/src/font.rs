//! A small stroke font, drawn for this crate: each glyph is a few lines on a 4 x 9 grid.
//!
//! Strokes are separated by spaces and written as pairs of digits `xy`; a leading `~` makes the
//! stroke a smooth curve (Catmull-Rom) through its points, closed where the last point repeats the
//! first. A single pair is a dot. Baseline y = 2, lower-case height 6, capitals 8, descenders 0.

/// Height of a capital letter above the baseline, in grid units.
pub(super) const CAP_HEIGHT: f64 = 6.0;
/// Gap between letters, in grid units.
const GAP: f64 = 1.7;
const BASELINE: f64 = 2.0;

fn glyph(c: char) -> &'static str {
    match c {
        'A' => "022842 0535",
        'B' => "0208 ~082837362505 ~053544433202",
        'C' => "~4738180703123243",
        'D' => "0208 ~082847432202",
        'E' => "48080242 0535",
        'F' => "480802 0535",
        'G' => "~4738180703123243 434525",
        'H' => "0208 4248 0545",
        'I' => "0828 1812 0222",
        'J' => "~3833221203",
        'K' => "0208 4804 1542",
        'L' => "080242",
        'M' => "0208254842",
        'N' => "02084248",
        'O' | '0' => "~183847433212030718",
        'P' => "0208 ~083847463505",
        'Q' => "~183847433212030718 2441",
        'R' => "0208 ~083847463505 2542",
        'S' => "~473818070615354443321203",
        'T' => "0848 2822",
        'U' => "~080312324348",
        'V' => "082248",
        'W' => "0812253248",
        'X' => "0248 0842",
        'Y' => "082548 2522",
        'Z' => "08480242",
        '1' => "172822 1232",
        '2' => "~071838474602 0242",
        '3' => "~07183847463525 ~25354443321203",
        '4' => "32380444",
        '5' => "480805 ~05354443321203",
        '6' => "~473818070312324344351504",
        '7' => "084812",
        '8' => "~183847463515060718 ~153544433212030415",
        '9' => "~031232434738180706153546",
        'a' => "~162635332212030516 3632",
        'b' => "0802 ~162635332212030516",
        'c' => "~3526160503122233",
        'd' => "~162635332212030516 3832",
        'e' => "0434 ~343526160503122233",
        'f' => "~38281712 0626",
        'g' => "~162635332212030516 ~3631201001",
        'h' => "0802 ~0516263532",
        'i' => "0602 08",
        'j' => "~161100 18",
        'k' => "0802 3604 1532",
        'l' => "~080312",
        'm' => "0602 ~05162522 ~25364542",
        'n' => "0602 ~0516263532",
        'o' => "~162635332212030516",
        'p' => "0600 ~162635332212030516",
        'q' => "~162635332212030516 3630",
        'r' => "0602 ~051626",
        's' => "~35261605142433221203",
        't' => "~181322 0626",
        'u' => "~0603122233 3632",
        'v' => "062246",
        'w' => "0612243246",
        'x' => "0236 0632",
        'y' => "0622 4610",
        'z' => "06360232",
        '.' => "02",
        ',' => "1201",
        ':' => "02 05",
        ';' => "1201 15",
        '-' | '–' => "0535",
        '+' => "0545 2327",
        '=' => "0646 0444",
        '/' => "0138",
        '\\' => "0831",
        '(' => "~18060411",
        ')' => "~08161401",
        '[' => "18080111",
        ']' => "08181101",
        '%' => "0248 0818170708 3343423233",
        '_' => "0141",
        '*' => "2327 0446 0644",
        '°' => "~0818170708",
        '<' => "360534",
        '>' => "063504",
        '!' => "0804 02",
        '?' => "~07182837362514 12",
        '\'' => "0807",
        '"' => "0807 1817",
        '#' => "1218 3238 0444 0646",
        '|' => "0901",
        '×' => "0337 0733",
        '·' => "05",
        '²' => "~091928060616 0626",
        '~' => "~05162535",
        '^' => "072937",
        '&' => "4216 ~1627180716 ~160403123243",
        '@' => "~44342535464738180703123243",
        _ => "0238083202 0832",
    }
}

/// Polylines of a text in units of the capital height, pen at the origin, y up from the baseline,
/// and the width of the text in the same unit. Control characters are skipped.
pub(super) fn strokes(text: &str) -> (Vec<Vec<[f64; 2]>>, f64) {
    let mut lines = Vec::new();
    let mut pen = 0.0;
    let mut width: f64 = 0.0;
    for c in text.chars().filter(|c| !c.is_control()) {
        if c == ' ' {
            pen += 3.2;
            width = pen;
            continue;
        }
        let mut right: f64 = 0.0;
        for stroke in glyph(c).split(' ') {
            let (smooth, digits) = match stroke.strip_prefix('~') {
                Some(rest) => (true, rest),
                None => (false, stroke),
            };
            let digit = |b: u8| f64::from(b.wrapping_sub(b'0'));
            let points: Vec<[f64; 2]> = digits
                .as_bytes()
                .chunks_exact(2)
                .map(|p| [digit(p[0]), digit(p[1]) - BASELINE])
                .collect();
            right = points.iter().fold(right, |m, p| m.max(p[0]));
            let curve = if smooth { catmull_rom(&points) } else { points };
            lines.push(
                curve
                    .iter()
                    .map(|p| [(p[0] + pen) / CAP_HEIGHT, p[1] / CAP_HEIGHT])
                    .collect(),
            );
        }
        width = pen + right;
        pen += right + GAP;
    }
    (lines, width / CAP_HEIGHT)
}

fn catmull_rom(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const STEPS: usize = 6;
    let n = points.len();
    if n < 3 {
        return points.to_vec();
    }
    let closed = points[0] == points[n - 1];
    let at = |i: isize| -> [f64; 2] {
        if closed {
            points[i.rem_euclid(n as isize - 1) as usize]
        } else {
            points[i.clamp(0, n as isize - 1) as usize]
        }
    };
    let mut curve = vec![points[0]];
    for i in 0..n as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for s in 1..=STEPS {
            let t = s as f64 / STEPS as f64;
            curve.push([0, 1].map(|k| {
                0.5 * (2.0 * b[k]
                    + (c[k] - a[k]) * t
                    + (2.0 * a[k] - 5.0 * b[k] + 4.0 * c[k] - d[k]) * t * t
                    + (3.0 * b[k] - a[k] - 3.0 * c[k] + d[k]) * t * t * t)
            }));
        }
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_character_has_its_own_strokes() {
        let unknown = glyph('\u{1F600}');
        for c in ('A'..='Z')
            .chain('a'..='z')
            .chain('0'..='9')
            .chain(".,:-+=/()[]%_°²×".chars())
        {
            assert_ne!(glyph(c), unknown, "{c}");
            let (lines, width) = strokes(&c.to_string());
            assert!(
                !lines.is_empty() && lines.iter().all(|l| !l.is_empty()),
                "{c}"
            );
            assert!((0.0..1.1).contains(&width), "{c} is {width} wide");
        }
        assert!(strokes("xx").1 > 2.0 * strokes("x").1);
    }
}
