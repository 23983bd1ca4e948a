//! Bytes written as text, and packed bytes: base64, zlib, gzip. What unpacks to more than it may is refused.

use std::io::Read;

/// No file and no array may unpack to more.
pub(super) const MAX_UNPACKED: usize = 1 << 30;

/// The first bytes, at most `most`, that base64 text stands for.
///
/// Blanks are passed over. Padding ends a group of four, not the text: some write several runs in a row.
pub(super) fn base64(text: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(most.min(text.len() / 4 * 3 + 3) + 3);
    let (mut group, mut n_digits, mut n_pads) = (0u32, 0, 0);
    for &b in text {
        let digit = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                n_pads += 1;
                0
            }
            _ if b <= b' ' => continue,
            _ => return Err(format!("base64 text holds the byte {b:#04x}")),
        };
        group = group << 6 | digit as u32;
        n_digits += 1;
        if n_digits == 4 {
            let bytes = group.to_be_bytes();
            out.extend_from_slice(&bytes[1..4 - n_pads.min(2)]);
            (group, n_digits, n_pads) = (0, 0, 0);
            if out.len() >= most {
                break;
            }
        }
    }
    // Some leave the last padding out.
    if n_digits > 1 && out.len() < most {
        let bytes = (group << (6 * (4 - n_digits))).to_be_bytes();
        out.extend_from_slice(&bytes[1..n_digits]);
    }
    out.truncate(most);
    Ok(out)
}

/// Unpacks a zlib stream of at most `most` bytes.
pub(super) fn inflate(bytes: &[u8], most: usize) -> Result<Vec<u8>, String> {
    unpack(flate2::read::ZlibDecoder::new(bytes), most)
}

/// Unpacks a gzip archive of at most `most` bytes.
pub(super) fn gunzip(bytes: &[u8], most: usize) -> Result<Vec<u8>, String> {
    unpack(flate2::read::MultiGzDecoder::new(bytes), most)
}

fn unpack(from: impl Read, most: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let read = from.take(most as u64 + 1).read_to_end(&mut out);
    read.map_err(|e| format!("packed bytes cannot be unpacked: {e}"))?;
    match out.len() > most {
        true => Err(format!("packed bytes unpack to more than {most} bytes")),
        false => Ok(out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn base64_is_read_in_runs_and_without_padding() {
        for (text, wanted) in [
            ("", &b""[..]),
            ("TWFu", b"Man"),
            (" TW\nE= TQ==", b"MaM"),
            ("TWE", b"Ma"),
            ("TQ", b"M"),
            ("T", b""),
            ("====", b"\0"),
        ] {
            assert_eq!(base64(text.as_bytes(), 99).unwrap(), wanted, "{text}");
        }
        assert_eq!(base64(b"TWFuTWFu<", 4).unwrap(), b"ManM");
        assert!(base64(b"TW<u", 4).is_err());
    }

    #[test]
    fn what_unpacks_to_too_much_is_refused() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), Default::default());
        packed.write_all(&[7; 1000]).unwrap();
        let packed = packed.finish().unwrap();
        assert_eq!(gunzip(&packed, 1000).unwrap(), [7; 1000]);
        assert!(gunzip(&packed, 999).unwrap_err().contains("more than 999"));
        assert!(gunzip(&packed[..20], 1000).is_err());
        assert!(inflate(b"nothing", 9).is_err());
    }
}
