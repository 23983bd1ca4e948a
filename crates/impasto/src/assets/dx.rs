//! OpenDX scalar fields as APBS and its kin write them: regular positions and connections, values as text.
//!
//! The last index runs fastest. What the comments say in capitals with a unit, as `POTENTIAL (kT/e)`, names the values.

use crate::assets::Lattice;
use crate::assets::molecule::Molecule;
use crate::assets::text::{self, Lines, Words, format_error, integer, parse_error, string};
use crate::assets::volume::{self, Volume, fortran_number, line_of};
use crate::error::{Report, Result, note};
use crate::math::DVec3;
use std::path::Path;

/// Reads the first array of an OpenDX file as a grid.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Volume>> {
    let text = text::utf8(bytes);
    let mut mended = Vec::new();
    let mut head = Head::default();
    let mut lines = Lines::new(&text);
    loop {
        let Some((number, line)) = lines.next() else {
            return Err(format_error(path, "the file ends before its array of values"));
        };
        if head.line(number, &line, path)? {
            break;
        }
    }
    let size = head.size.ok_or_else(|| format_error(path, "no counts of grid positions before the values"))?;
    let mut words = Words(lines.rest());
    let n = volume::room_for(size, 1, 16, words.0.len() + 1, path)?;
    if head.n_items.is_some_and(|m| m != n as u64) {
        let fault = format!("an array of {} items for {n} grid points", head.n_items.unwrap_or(0));
        return Err(format_error(path, fault));
    }
    let mut values = Vec::with_capacity(n);
    while values.len() < n {
        let mut ahead = words.clone();
        let Some(word) = ahead.next() else { break };
        match fortran_number(word) {
            Some(x) => values.push(x as f32),
            None if matches!(word, b"attribute" | b"object" | b"component" | b"end") => break,
            None => return Err(parse_error(path, line_of(&text, ahead.0), "a value", word)),
        }
        words = ahead;
    }
    note(&mut mended, n - values.len(), "values that the head claims are not in the file");
    values.resize(n, f32::NAN);
    let [nx, ny, nz] = size.map(|s| s as usize);
    let mut turned = Vec::with_capacity(n);
    for k in 0..nz {
        for j in 0..ny {
            turned.extend((0..nx).map(|i| values[(i * ny + j) * nz + k]));
        }
    }
    if head.n_deltas < 3 {
        note(&mut mended, 3 - head.n_deltas, "steps that the file does not tell taken as 1");
    }
    let lattice = Lattice { size: size.map(|s| s as u32), origin: head.origin, axes: head.deltas };
    let grid = volume::checked(lattice, turned, path)?.named(head.name, head.unit);
    Ok(Report { value: Volume { grids: vec![grid], molecule: Molecule::default(), length_unit: "Å" }, mended })
}

struct Head {
    size: Option<[u64; 3]>,
    origin: DVec3,
    deltas: [DVec3; 3],
    n_deltas: usize,
    n_items: Option<u64>,
    name: String,
    unit: String,
}

impl Default for Head {
    fn default() -> Self {
        Self {
            size: None,
            origin: DVec3::ZERO,
            deltas: [DVec3::X, DVec3::Y, DVec3::Z],
            n_deltas: 0,
            n_items: None,
            name: "value".into(),
            unit: String::new(),
        }
    }
}

impl Head {
    /// Takes in a line; whether the values follow it.
    fn line(&mut self, number: usize, line: &[u8], path: &Path) -> Result<bool> {
        let mut words = Words(line);
        let place = |words: &mut Words| -> Result<DVec3> {
            let mut x = [0.0; 3];
            for x in &mut x {
                let word = words.next().unwrap_or_default();
                *x = fortran_number(word).ok_or_else(|| parse_error(path, number, "three numbers", word))?;
            }
            Ok(DVec3::from(x))
        };
        match words.next() {
            Some(b"origin") => self.origin = place(&mut words)?,
            Some(b"delta") if self.n_deltas < 3 => {
                self.deltas[self.n_deltas] = place(&mut words)?;
                self.n_deltas += 1;
            }
            Some(b"object") => return self.object(number, line, path),
            Some(word) if word.starts_with(b"#") => self.comment(&string(line)),
            _ => {}
        }
        Ok(false)
    }

    fn object(&mut self, number: usize, line: &[u8], path: &Path) -> Result<bool> {
        let words: Vec<&[u8]> = Words(line).collect();
        let after = |key: &[u8]| words.iter().position(|w| *w == key).map(|i| &words[i + 1..]);
        match after(b"class").and_then(|w| w.first()) {
            Some(&b"gridpositions") => {
                let counts = after(b"counts").unwrap_or_default();
                let count = |i: usize| counts.get(i).and_then(|w| integer(w)).and_then(|n| u64::try_from(n).ok());
                self.size = count(0).zip(count(1)).zip(count(2)).map(|((x, y), z)| [x, y, z]);
                if self.size.is_none() || counts.len() > 3 {
                    return Err(parse_error(path, number, "counts along three axes", line));
                }
                Ok(false)
            }
            Some(&b"array") => {
                if words.iter().any(|w| matches!(*w, b"binary" | b"ieee" | b"xdr" | b"lsb" | b"msb")) {
                    return Err(format_error(
                        path,
                        format!("line {number}: binary OpenDX is not read; save it as text"),
                    ));
                }
                if after(b"data").and_then(|w| w.first()) == Some(&&b"file"[..]) {
                    return Err(format_error(path, format!("line {number}: values in another file are not read")));
                }
                if after(b"rank").and_then(|w| integer(w.first()?)).is_some_and(|rank| rank != 0) {
                    return Err(format_error(path, format!("line {number}: vectors are not read, only scalars")));
                }
                self.n_items = after(b"items").and_then(|w| u64::try_from(integer(w.first()?)?).ok());
                Ok(true)
            }
            _ => Ok(false),
        }
    }

    /// `# POTENTIAL (kT/e)` names the values and their unit.
    fn comment(&mut self, line: &str) {
        let said = line.trim_start_matches('#').trim();
        if let Some((name, unit)) = said.split_once('(')
            && let Some(unit) = unit.strip_suffix(')')
            && !name.is_empty()
            && name.chars().all(|c| c.is_uppercase() || c == ' ')
        {
            (self.name, self.unit) = (name.trim().to_lowercase(), unit.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::volume::Kind;
    use crate::assets::volume::tests::survives_damage;

    const HEAD: &str = "# by hand\n#\n# POTENTIAL (kT/e)\n#\nobject 1 class gridpositions counts 2 3 4
origin -1.0 2.0 3.0
delta 0.5 0.0 0.0
delta 0.0 0.25 0.0
delta 0.0 0.0 1.0
object 2 class gridconnections counts 2 3 4
object 3 class array type double rank 0 items 24 data follows
";

    fn file(n_values: usize) -> String {
        let values: Vec<String> =
            (0..n_values).map(|i| format!("{i}.5e-1{}", if i % 3 == 2 { "\n" } else { " " })).collect();
        format!("{HEAD}{}\nattribute \"dep\" string \"positions\"\n", values.concat())
    }

    #[test]
    fn the_last_index_runs_fastest() {
        let report = read(file(24).as_bytes(), Path::new("a.dx")).unwrap();
        let grid = &report.value.grids[0];
        assert!(report.mended.is_empty() && grid.size() == [2, 3, 4]);
        assert_eq!([grid.at(0, 0, 1), grid.at(0, 1, 0), grid.at(1, 0, 0)], [0.15, 0.45, 1.25]);
        assert_eq!((grid.name.as_str(), grid.unit.as_str()), ("potential", "kT/e"));
        assert_eq!((grid.origin(), grid.axes()[1]), (DVec3::new(-1.0, 2.0, 3.0), DVec3::Y * 0.25));
    }

    #[test]
    fn faults_are_told_in_one_line() {
        let fault = |text: String| read(text.as_bytes(), Path::new("a.dx")).unwrap_err().to_string();
        assert!(fault("object 1\n".into()).contains("ends before its array"));
        assert!(fault(file(24).replace("counts 2 3 4", "counts 2000 3000 4000")).contains("values are claimed"));
        assert!(fault(file(24).replace("items 24", "items 25")).contains("an array of 25 items for 24 grid points"));
        assert!(fault(file(24).replace("5.5e-1", "x")).contains("line 13: expected a value"));
        assert!(fault(file(24).replace("type double", "type double lsb ieee")).contains("line 11: binary"));
        assert!(fault(file(24).replace("delta 0.0 0.25", "delta 1.0 0.00")).contains("span no volume"));
        let short = read(file(20).as_bytes(), Path::new("a.dx")).unwrap();
        assert_eq!(short.mended[0].to_string(), "4 values that the head claims are not in the file");
    }

    #[test]
    fn damage_gives_a_grid_or_one_line() {
        survives_damage(Kind::Dx, file(24).as_bytes());
    }
}
