//! One array as a `.npy` file: a line of text with type and shape, then the values.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. The header is
//! written in version 1.0. Versions 1 to 3 are read, little-endian and in C order only.

use std::iter::repeat;

use super::{Array, Data};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Bytes of a character of numpy's `str`, which is UTF-32.
const CHARACTER: usize = 4;

/// An array as a file.
pub(super) fn encode(array: &Array) -> Vec<u8> {
    let (kind, values): (_, Vec<u8>) = match &array.data {
        Data::F64(v) => ("<f8".to_owned(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Data::F32(v) => ("<f4".to_owned(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Data::U32(v) => ("<u4".to_owned(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Data::U64(v) => ("<u8".to_owned(), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Data::U8(v) => ("|u1".to_owned(), v.clone()),
        Data::Bool(v) => ("|b1".to_owned(), v.iter().map(|x| u8::from(*x)).collect()),
        Data::Text(v) => {
            // numpy has no texts of length 0.
            let width = v.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
            let padded = v.iter().flat_map(|text| text.chars().chain(repeat('\0')).take(width));
            (format!("<U{width}"), padded.flat_map(|c| u32::from(c).to_le_bytes()).collect())
        }
    };
    // A tuple of one item has a comma behind it.
    let shape = match array.shape.as_slice() {
        [one] => format!("({one},)"),
        all => format!("({})", all.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    // The values begin at a multiple of 64 bytes.
    let used = MAGIC.len() + 4 + header.len() + 1;
    header += &" ".repeat(used.next_multiple_of(64) - used);
    header += "\n";
    let length = (header.len() as u16).to_le_bytes();
    [MAGIC, &[1, 0], &length, header.as_bytes(), &values].concat()
}

/// The array of a file, or what is wrong with it.
pub(super) fn decode(bytes: &[u8]) -> Result<Array, String> {
    let cut = || "cut short".to_owned();
    let rest = bytes.strip_prefix(MAGIC).ok_or("not a .npy file")?;
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk().map(|(n, rest)| (u16::from_le_bytes(*n) as usize, rest)),
        2 | 3 => rest.split_first_chunk().map(|(n, rest)| (u32::from_le_bytes(*n) as usize, rest)),
        other => return Err(format!("version {other} of the .npy format")),
    }
    .ok_or_else(cut)?;
    let (header, values) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "a header that is no text")?;
    if field(header, "fortran_order") != Some("False") {
        return Err("not in C order; save `numpy.ascontiguousarray` of it".to_owned());
    }
    let shape = field(header, "shape").and_then(|shape| {
        let items = shape.strip_prefix('(')?.strip_suffix(')')?.split(',').map(str::trim);
        items.filter(|item| !item.is_empty()).map(|item| item.parse().ok()).collect()
    });
    let shape: Vec<usize> = shape.ok_or("a header without a shape")?;
    let kind = field(header, "descr").and_then(|kind| kind.strip_prefix('\'')?.strip_suffix('\''));
    let kind = kind.ok_or("a header without one type")?;
    let size = match (kind, kind.strip_prefix("<U").and_then(|n| n.parse::<usize>().ok())) {
        ("<f8" | "<u8", _) => 8,
        ("<f4" | "<u4", _) => 4,
        ("|u1" | "|b1", _) => 1,
        (_, Some(width)) => width.saturating_mul(CHARACTER),
        _ => {
            return Err(format!(
                "type `{kind}`, where float64, float32, uint32, uint64, uint8, bool or str is expected"
            ));
        }
    };
    let number = shape.iter().try_fold(1, |n: usize, k| n.checked_mul(*k));
    if number.and_then(|n| n.checked_mul(size)) != Some(values.len()) {
        return Err(format!("{} bytes for the shape {shape:?} of `{kind}`", values.len()));
    }
    let data = match kind {
        "<f8" => Data::F64(values.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
        "<f4" => Data::F32(values.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
        "<u4" => Data::U32(values.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect()),
        "<u8" => Data::U64(values.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b)).collect()),
        "|u1" => Data::U8(values.to_vec()),
        "|b1" => Data::Bool(values.iter().map(|b| *b != 0).collect()),
        _ => Data::Text(texts(values, size, number.unwrap_or(0))?),
    };
    Ok(Array { shape, data })
}

/// The value of a field in the text of a Python dictionary, as it is written there.
fn field<'a>(header: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{name}':"))?;
    let rest = rest.trim_start();
    let end = match rest.as_bytes().first()? {
        b'(' => rest.find(')')? + 1,
        b'\'' => rest.get(1..)?.find('\'')? + 2,
        _ => rest.find([',', '}'])?,
    };
    rest.get(..end).map(str::trim_end)
}

/// Texts of `size` bytes each.
fn texts(values: &[u8], size: usize, number: usize) -> Result<Vec<String>, String> {
    if size == 0 {
        return Ok(vec![String::new(); number]);
    }
    let text = |bytes: &[u8]| -> Option<String> {
        let units = bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
        let text: Option<String> = units.map(char::from_u32).collect();
        text.map(|text| text.trim_end_matches('\0').to_owned())
    };
    let all = values.chunks_exact(size).map(text).collect::<Option<_>>();
    all.ok_or_else(|| "a character that does not exist".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes that `numpy.save` (2.4) writes for `numpy.array([[1.0, 2.0]])`.
    #[test]
    fn the_bytes_are_those_of_numpy() {
        let mut expected = b"\x93NUMPY\x01\x00v\x00".to_vec();
        expected.extend_from_slice(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }");
        expected.resize(127, b' ');
        expected.push(b'\n');
        expected.extend_from_slice(&[0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0x40]);
        let array = Array::vectors([[1.0, 2.0]]);
        let bytes = encode(&array);
        assert_eq!(bytes, expected);
        assert_eq!(decode(&bytes).unwrap(), array);
    }

    #[test]
    fn what_is_not_read_is_named() {
        let header = |text: &str| {
            let length = (text.len() as u16).to_le_bytes();
            [MAGIC, &[1, 0], &length, text.as_bytes()].concat()
        };
        for (text, said) in [
            ("{'descr': '<i8', 'fortran_order': False, 'shape': (), }", "type `<i8`"),
            ("{'descr': '>f8', 'fortran_order': False, 'shape': (), }", "type `>f8`"),
            ("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (0,), }", "one type"),
            ("{'descr': '<f8', 'fortran_order': True, 'shape': (0, 2), }", "C order"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", "0 bytes for the shape"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': 2, }", "without a shape"),
            ("{'descr': '<U18446744073709551615', 'fortran_order': False, 'shape': (9,)}", "bytes"),
            ("", "C order"),
        ] {
            let found = decode(&header(text)).unwrap_err();
            assert!(found.contains(said), "{text}: {found}");
        }
    }
}
