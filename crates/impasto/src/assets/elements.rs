//! The chemical elements: symbols, radii, colours.
//!
//! Van der Waals radii: Bondi, "van der Waals Volumes and Radii", 1964, for the non-metals he gives; Alvarez, "A
//! cartography of the van der Waals territories", 2013, for all others. Covalent radii: Cordero et al., "Covalent radii
//! revisited", 2008. Colours are ours, near to the custom of Corey, Pauling and Koltun.

use crate::color::LINEAR_FROM_SRGB8;

/// The greatest atomic number that is known here.
pub const MOST: u8 = 96;

/// Symbols by atomic number; 0 is an unknown element.
const SYMBOLS: [&str; MOST as usize + 1] = [
    "?", "H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S", "Cl", "Ar", "K", "Ca",
    "Sc", "Ti", "V", "Cr", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Ga", "Ge", "As", "Se", "Br", "Kr", "Rb", "Sr", "Y",
    "Zr", "Nb", "Mo", "Tc", "Ru", "Rh", "Pd", "Ag", "Cd", "In", "Sn", "Sb", "Te", "I", "Xe", "Cs", "Ba", "La", "Ce",
    "Pr", "Nd", "Pm", "Sm", "Eu", "Gd", "Tb", "Dy", "Ho", "Er", "Tm", "Yb", "Lu", "Hf", "Ta", "W", "Re", "Os", "Ir",
    "Pt", "Au", "Hg", "Tl", "Pb", "Bi", "Po", "At", "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U", "Np", "Pu", "Am", "Cm",
];

/// Angstroms, by atomic number. Where neither paper has one: 2.
#[rustfmt::skip]
const VAN_DER_WAALS: [f32; MOST as usize + 1] = [
    1.70,
    1.20, 1.40, 2.12, 1.98, 1.91, 1.70, 1.55, 1.52, 1.47, 1.54, 2.50, 2.51, 2.25, 2.10, 1.80, 1.80,
    1.75, 1.88, 2.73, 2.62, 2.58, 2.46, 2.42, 2.45, 2.45, 2.44, 2.40, 2.40, 2.38, 2.39, 2.32, 2.29,
    1.85, 1.90, 1.85, 2.02, 3.21, 2.84, 2.75, 2.52, 2.56, 2.45, 2.44, 2.46, 2.44, 2.15, 2.53, 2.49,
    2.43, 2.42, 2.47, 2.06, 1.98, 2.16, 3.48, 3.03, 2.98, 2.88, 2.92, 2.95, 2.00, 2.90, 2.87, 2.83,
    2.79, 2.87, 2.81, 2.83, 2.79, 2.80, 2.74, 2.63, 2.53, 2.57, 2.49, 2.48, 2.41, 2.29, 2.32, 2.45,
    2.47, 2.60, 2.54, 2.00, 2.00, 2.00, 2.00, 2.00, 2.80, 2.93, 2.88, 2.71, 2.82, 2.81, 2.83, 3.05,
];

/// Angstroms, by atomic number.
#[rustfmt::skip]
const COVALENT: [f32; MOST as usize + 1] = [
    0.76,
    0.31, 0.28, 1.28, 0.96, 0.84, 0.76, 0.71, 0.66, 0.57, 0.58, 1.66, 1.41, 1.21, 1.11, 1.07, 1.05,
    1.02, 1.06, 2.03, 1.76, 1.70, 1.60, 1.53, 1.39, 1.39, 1.32, 1.26, 1.24, 1.32, 1.22, 1.22, 1.20,
    1.19, 1.20, 1.20, 1.16, 2.20, 1.95, 1.90, 1.75, 1.64, 1.54, 1.47, 1.46, 1.42, 1.39, 1.45, 1.44,
    1.42, 1.39, 1.39, 1.38, 1.39, 1.40, 2.44, 2.15, 2.07, 2.04, 2.03, 2.01, 1.99, 1.98, 1.98, 1.96,
    1.94, 1.92, 1.92, 1.89, 1.90, 1.87, 1.87, 1.75, 1.70, 1.62, 1.51, 1.44, 1.41, 1.36, 1.36, 1.32,
    1.45, 1.46, 1.48, 1.40, 1.50, 1.50, 2.60, 2.21, 2.15, 2.06, 2.00, 1.96, 1.90, 1.87, 1.80, 1.69,
];

/// The atomic number of a symbol in any case; D and T are hydrogen.
pub fn by_symbol(symbol: &str) -> Option<u8> {
    if symbol.eq_ignore_ascii_case("D") || symbol.eq_ignore_ascii_case("T") {
        return Some(1);
    }
    (1..=MOST).find(|z| SYMBOLS[*z as usize].eq_ignore_ascii_case(symbol))
}

/// The symbol; `?` for what is unknown.
pub fn symbol(element: u8) -> &'static str {
    SYMBOLS.get(element as usize).unwrap_or(&SYMBOLS[0])
}

/// Van der Waals radius, angstroms.
pub fn van_der_waals(element: u8) -> f32 {
    VAN_DER_WAALS.get(element as usize).copied().unwrap_or(VAN_DER_WAALS[0])
}

/// Covalent radius, angstroms.
pub fn covalent(element: u8) -> f32 {
    COVALENT.get(element as usize).copied().unwrap_or(COVALENT[0])
}

/// The colour that stands for an element, linear light.
pub fn color(element: u8) -> [f32; 3] {
    let bytes: [u8; 3] = match element {
        1 => [238, 236, 228],
        2 | 10 | 18 | 36 | 54 | 86 => [120, 200, 206],
        3 | 11 | 19 | 37 | 55 | 87 => [142, 112, 204],
        4 | 12 | 20 | 38 | 56 | 88 => [84, 146, 92],
        5 => [226, 168, 150],
        6 => [108, 112, 118],
        7 => [62, 98, 208],
        8 => [208, 58, 46],
        9 => [134, 204, 112],
        14 => [204, 172, 128],
        15 => [228, 136, 48],
        16 => [230, 194, 62],
        17 => [76, 178, 84],
        26 => [204, 112, 58],
        29 => [190, 118, 72],
        30 => [134, 138, 176],
        34 => [232, 156, 44],
        35 => [150, 62, 44],
        53 => [120, 58, 150],
        79 => [222, 176, 60],
        57..=71 | 89.. => [104, 170, 168],
        0 => [200, 96, 168],
        _ => [150, 160, 176],
    };
    bytes.map(|b| LINEAR_FROM_SRGB8[b as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_and_radii_stand_in_their_rows() {
        for (name, z, radius, bond) in [
            ("H", 1, 1.20, 0.31),
            ("C", 6, 1.70, 0.76),
            ("cl", 17, 1.75, 1.02),
            ("FE", 26, 2.44, 1.32),
            ("Br", 35, 1.85, 1.20),
            ("I", 53, 1.98, 1.39),
            ("Lu", 71, 2.74, 1.87),
            ("Pt", 78, 2.29, 1.36),
            ("U", 92, 2.71, 1.96),
            ("Cm", 96, 3.05, 1.69),
        ] {
            assert_eq!(by_symbol(name), Some(z));
            assert_eq!((van_der_waals(z), covalent(z)), (radius, bond), "{name}");
        }
        assert_eq!((by_symbol("D"), by_symbol("?"), by_symbol(""), symbol(200)), (Some(1), None, None, "?"));
        assert!((0..=255).all(|z| van_der_waals(z) > 1.0 && covalent(z) > 0.2 && color(z)[0] > 0.0));
    }
}
