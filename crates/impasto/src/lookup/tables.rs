//! The colour tables that have names: who made each, under which licence, and what it is good for.
//!
//! The 256-entry tables lie in `tables.bin`, 768 sRGB bytes each, taken once and unchanged from the packages matplotlib
//! 3.11, cmcrameri 1.10, cmocean 4.0 and colorcet 3.2; `tables.LICENSE.md` beside it holds their notices.

mod parse;

pub use parse::parse;

use crate::color::{LinearRgba, linear_from_bytes};
use crate::lookup::ColorTable;

/// What a table is good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From little to much: lightness goes one way.
    Sequential,
    /// Two ways from a middle that means something, like zero.
    Diverging,
    /// The last colour meets the first: angles, phases, times of day.
    Cyclic,
    /// Colours without an order, one for each of a few classes.
    Categorical,
    /// All hues: edges appear where the data has none. Here for comparison with older pictures.
    Rainbow,
}

/// A named table's papers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    /// As people write it; found in any case.
    pub name: &'static str,
    /// What it is good for.
    pub kind: Kind,
    /// Who made it, and when or where.
    pub source: &'static str,
    /// Under which licence its numbers may be passed on.
    pub licence: &'static str,
    stored: Stored,
}

/// Where a table's numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stored {
    /// The so-manieth of `tables.bin`.
    Extracted(usize),
    /// sRGB, as few as there are classes.
    Listed(&'static [u32]),
    /// Made by `color_table`.
    Formula,
}

const BYTES: &[u8] = include_bytes!("tables.bin");
const N_ENTRIES: usize = 256;

const CRAMERI: &str = "Fabio Crameri, Scientific colour maps, doi 10.5281/zenodo.1243862";
const CMOCEAN: &str = "Kristen Thyng et al., cmocean, Oceanography 29(3), 2016";
const CET: &str = "Peter Kovesi, Good Colour Maps: How to Design Them, arXiv 1509.03700, 2015";
const MATPLOTLIB: &str = "Matplotlib licence";

const fn table(name: &'static str, kind: Kind, source: &'static str, licence: &'static str, stored: Stored) -> Info {
    Info { name, kind, source, licence, stored }
}

/// All named tables.
#[rustfmt::skip]
pub const TABLES: [Info; 51] = [
    table("viridis", Kind::Sequential, "Stéfan van der Walt, Nathaniel Smith, 2015", "CC0", Stored::Extracted(0)),
    table("plasma", Kind::Sequential, "Stéfan van der Walt, Nathaniel Smith, 2015", "CC0", Stored::Extracted(1)),
    table("inferno", Kind::Sequential, "Stéfan van der Walt, Nathaniel Smith, 2015", "CC0", Stored::Extracted(2)),
    table("magma", Kind::Sequential, "Stéfan van der Walt, Nathaniel Smith, 2015", "CC0", Stored::Extracted(3)),
    table("cividis", Kind::Sequential, "Jamie Nuñez, Christopher Anderton, Ryan Renslow, 2018", MATPLOTLIB, Stored::Extracted(4)),
    table("turbo", Kind::Rainbow, "Anton Mikhailov, Google, 2019", "Apache-2.0", Stored::Extracted(5)),
    table("twilight", Kind::Cyclic, "Bastian Bechtold, 2018", "CC0", Stored::Extracted(6)),
    table("jet", Kind::Rainbow, "after MATLAB; for comparison with older pictures only", MATPLOTLIB, Stored::Extracted(7)),
    table("batlow", Kind::Sequential, CRAMERI, "MIT", Stored::Extracted(8)),
    table("devon", Kind::Sequential, CRAMERI, "MIT", Stored::Extracted(9)),
    table("lajolla", Kind::Sequential, CRAMERI, "MIT", Stored::Extracted(10)),
    table("oslo", Kind::Sequential, CRAMERI, "MIT", Stored::Extracted(11)),
    table("hawaii", Kind::Sequential, CRAMERI, "MIT", Stored::Extracted(12)),
    table("vik", Kind::Diverging, CRAMERI, "MIT", Stored::Extracted(13)),
    table("roma", Kind::Diverging, CRAMERI, "MIT", Stored::Extracted(14)),
    table("berlin", Kind::Diverging, CRAMERI, "MIT", Stored::Extracted(15)),
    table("broc", Kind::Diverging, CRAMERI, "MIT", Stored::Extracted(16)),
    table("cork", Kind::Diverging, CRAMERI, "MIT", Stored::Extracted(17)),
    table("romaO", Kind::Cyclic, CRAMERI, "MIT", Stored::Extracted(18)),
    table("vikO", Kind::Cyclic, CRAMERI, "MIT", Stored::Extracted(19)),
    table("thermal", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(20)),
    table("haline", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(21)),
    table("ice", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(22)),
    table("deep", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(23)),
    table("dense", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(24)),
    table("algae", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(25)),
    table("matter", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(26)),
    table("speed", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(27)),
    table("amp", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(28)),
    table("tempo", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(29)),
    table("oxy", Kind::Sequential, CMOCEAN, "MIT", Stored::Extracted(30)),
    table("topo", Kind::Diverging, CMOCEAN, "MIT", Stored::Extracted(31)),
    table("balance", Kind::Diverging, CMOCEAN, "MIT", Stored::Extracted(32)),
    table("delta", Kind::Diverging, CMOCEAN, "MIT", Stored::Extracted(33)),
    table("curl", Kind::Diverging, CMOCEAN, "MIT", Stored::Extracted(34)),
    table("phase", Kind::Cyclic, CMOCEAN, "MIT", Stored::Extracted(35)),
    table("fire", Kind::Sequential, CET, "CC-BY-4.0", Stored::Extracted(36)),
    table("bmy", Kind::Sequential, CET, "CC-BY-4.0", Stored::Extracted(37)),
    table("bgy", Kind::Sequential, CET, "CC-BY-4.0", Stored::Extracted(38)),
    table("cet-gray", Kind::Sequential, CET, "CC-BY-4.0", Stored::Extracted(39)),
    table("cet-coolwarm", Kind::Diverging, CET, "CC-BY-4.0", Stored::Extracted(40)),
    table("bkr", Kind::Diverging, CET, "CC-BY-4.0", Stored::Extracted(41)),
    table("cet-rainbow", Kind::Rainbow, CET, "CC-BY-4.0", Stored::Extracted(42)),
    table("cet-c1", Kind::Cyclic, CET, "CC-BY-4.0", Stored::Extracted(43)),
    table("cet-c2", Kind::Cyclic, CET, "CC-BY-4.0", Stored::Extracted(44)),
    table("cet-c3", Kind::Cyclic, CET, "CC-BY-4.0", Stored::Extracted(45)),
    table("cet-c5", Kind::Cyclic, CET, "CC-BY-4.0", Stored::Extracted(46)),
    table("grey", Kind::Sequential, "even steps of sRGB", "none needed", Stored::Formula),
    table("coolwarm", Kind::Diverging, "Kenneth Moreland, 2009, by his formula", "none needed", Stored::Formula),
    table("okabe-ito", Kind::Categorical, "Masataka Okabe, Kei Ito, Color Universal Design, 2008", "free to use", Stored::Listed(&OKABE_ITO)),
    table("petroff10", Kind::Categorical, "Matthew Petroff, Accessible Color Sequences, arXiv 2107.02270, 2021", MATPLOTLIB, Stored::Listed(&PETROFF10)),
];

const OKABE_ITO: [u32; 8] = [0xe69f00, 0x56b4e9, 0x009e73, 0xf0e442, 0x0072b2, 0xd55e00, 0xcc79a7, 0x000000];
const PETROFF10: [u32; 10] =
    [0x3f90da, 0xffa90e, 0xbd1f01, 0x94a4a2, 0x832db6, 0xa96b59, 0xe76300, 0xb9ac70, 0x717581, 0x92dadd];

/// The names of [`TABLES`].
pub(super) const NAMES: [&str; TABLES.len()] = {
    let mut names = [""; TABLES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = TABLES[i].name;
        i += 1;
    }
    names
};

/// The papers of a table: names are found in any case, `_` is `-`, `gray` is `grey`.
pub fn info(name: &str) -> Option<&'static Info> {
    let folded = name.to_ascii_lowercase().replace('_', "-");
    let folded = if folded == "gray" { "grey" } else { folded.as_str() };
    TABLES.iter().find(|t| t.name.to_ascii_lowercase() == folded)
}

/// The papers of the named table that has these colours, forward or backward.
pub fn info_of(table: &ColorTable) -> Option<&'static Info> {
    TABLES.iter().find(|info| {
        let of = ColorTable::named(info.name).map_or_else(Vec::new, |t| t.colors);
        of == table.colors || of.iter().rev().eq(&table.colors)
    })
}

/// A stored table's colours; none for those made by formula.
pub(super) fn colors(info: &Info) -> Option<Vec<LinearRgba>> {
    let opaque = |bytes: [u8; 3]| {
        let [r, g, b] = linear_from_bytes(bytes);
        [r, g, b, 1.0]
    };
    match info.stored {
        Stored::Formula => None,
        Stored::Listed(colors) => Some(colors.iter().map(|c| opaque([16, 8, 0].map(|s| (c >> s) as u8))).collect()),
        Stored::Extracted(i) => {
            let bytes = BYTES[i * 3 * N_ENTRIES..][..3 * N_ENTRIES].as_chunks().0;
            Some(bytes.iter().map(|&b| opaque(b)).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_table() {
        assert_eq!(
            BYTES.len(),
            3 * N_ENTRIES * TABLES.iter().filter(|t| matches!(t.stored, Stored::Extracted(_))).count()
        );
        for info in &TABLES {
            let table = ColorTable::named(info.name).expect(info.name);
            assert_eq!(info_of(&table).map(|i| i.name), Some(info.name));
            let n = table.colors.len();
            assert!(if info.kind == Kind::Categorical { n <= 10 } else { n == N_ENTRIES }, "{}", info.name);
            assert!(!info.source.is_empty() && !info.licence.is_empty());
        }
        let folded: std::collections::BTreeSet<String> = TABLES.iter().map(|t| t.name.to_lowercase()).collect();
        assert_eq!(folded.len(), TABLES.len());
    }

    #[test]
    fn names_are_found_in_any_spelling() {
        for (given, wanted) in
            [("VIRIDIS", "viridis"), ("romao", "romaO"), ("CET_Rainbow", "cet-rainbow"), ("gray", "grey")]
        {
            assert_eq!(info(given).map(|i| i.name), Some(wanted), "{given}");
        }
        assert!(info("virides").is_none());
        let (forward, back) = (ColorTable::named("Vik").expect("known"), ColorTable::named("vik_r").expect("known"));
        assert_eq!(back, forward.reversed());
        assert_eq!(info_of(&back).map(|i| i.name), Some("vik"));
    }
}
