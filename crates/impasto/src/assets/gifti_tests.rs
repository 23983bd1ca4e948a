//! Small files and broken ones.

use super::*;
use crate::assets::broken;

/// A square, its shape, labels, and two numbers a point column after column.
const SQUARE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE GIFTI SYSTEM "http://www.nitrc.org/frs/download.php/115/gifti.dtd">
<GIFTI Version="1.0" NumberOfDataArrays="5">
<MetaData/>
<LabelTable><Label Key="0" Red="1" Green="1" Blue="1" Alpha="0"><![CDATA[???]]></Label>
<Label Key="7" Red="1" Green="0" Blue="0" Alpha="1">cortex</Label></LabelTable>
<DataArray Intent="NIFTI_INTENT_POINTSET" DataType="NIFTI_TYPE_FLOAT32" ArrayIndexingOrder="RowMajorOrder" Dimensionality="2"
 Dim0="4" Dim1="3" Encoding="ASCII" Endian="LittleEndian"><Data>0 0 0 1 0 0 0 1 0 1 1 0</Data></DataArray>
<DataArray Intent="NIFTI_INTENT_TRIANGLE" DataType="NIFTI_TYPE_INT32" ArrayIndexingOrder="ColumnMajorOrder" Dimensionality="2"
 Dim0="2" Dim1="3" Encoding="ASCII" Endian="LittleEndian"><Data>0 2 1 1 2 3</Data></DataArray>
<DataArray Intent="NIFTI_INTENT_SHAPE" DataType="NIFTI_TYPE_FLOAT32" ArrayIndexingOrder="RowMajorOrder" Dimensionality="1"
 Dim0="4" Encoding="Base64Binary" Endian="BigEndian"><MetaData><MD><Name>Name</Name><Value>thickness</Value></MD></MetaData>
 <Data>P4AAAEAAAABAQAAAQIAAAA==</Data></DataArray>
<DataArray Intent="NIFTI_INTENT_LABEL" DataType="NIFTI_TYPE_INT32" ArrayIndexingOrder="RowMajorOrder" Dimensionality="1"
 Dim0="4" Encoding="ASCII" Endian="LittleEndian"><Data>0 7 7 0</Data></DataArray>
<DataArray Intent="NIFTI_INTENT_NONE" DataType="NIFTI_TYPE_UINT8" ArrayIndexingOrder="ColumnMajorOrder" Dimensionality="2"
 Dim0="4" Dim1="2" Encoding="GZipBase64Binary" Endian="LittleEndian"><Data>eJxjZGJmYWVj5wAAAIAAJQ==</Data></DataArray>
</GIFTI>"#;

#[test]
fn surfaces_and_their_data_are_read() {
    let loose = read_loose(SQUARE.as_bytes(), Path::new("a.b.gii")).unwrap();
    assert_eq!(loose.mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(loose.mesh.positions[3], vec3(1.0, 1.0, 0.0));
    let names: Vec<&str> = loose.mesh.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names[..2], ["thickness", "label"]);
    assert_eq!(loose.mesh.fields[0].values, Values::F32(vec![1.0, 2.0, 3.0, 4.0]));
    assert_eq!((names[2], loose.mended.len()), ("a", 0));
    assert_eq!(loose.mesh.fields[2].values, Values::F32(vec![1.0, 5.0, 2.0, 6.0, 3.0, 7.0, 4.0, 8.0]));
    let bad = SQUARE.replace("<Data>eJ", "<Data>AA");
    let told = read_loose(bad.as_bytes(), Path::new("a.gii")).unwrap().mended;
    assert!(told[0].what.contains("array 5: packed bytes cannot be unpacked"));
}

#[test]
fn columns_have_their_labels() {
    let columns = read_columns(SQUARE.as_bytes(), Path::new("a.b.gii")).unwrap().value;
    let label = columns.named("label").unwrap();
    assert_eq!((label.labels[1].key, label.labels[1].name.as_str()), (7, "cortex"));
    assert_eq!((label.labels[0].name.as_str(), label.labels[0].color), ("???", [1.0, 1.0, 1.0, 0.0]));
    assert_eq!(transposed(&Values::F32(vec![1.0, 2.0, 3.0, 4.0]), 2, 2), Values::F32(vec![1.0, 3.0, 2.0, 4.0]));
}

#[test]
fn what_cannot_be_read_is_told() {
    let without = SQUARE.replace("_POINTSET", "_SHAPE");
    let error = read_loose(without.as_bytes(), Path::new("a")).err().unwrap().to_string();
    assert!(error.contains("no surface in it, but data for one"), "{error}");
    for (from, to, wanted) in [
        ("Dim0=\"4\" Dim1=\"3\"", "Dim0=\"4000\" Dim1=\"3\"", "12000 numbers are claimed, 12 are there"),
        ("Dim0=\"4\" Dim1=\"3\"", "Dim0=\"400000000000\" Dim1=\"3\"", "too large"),
        ("Dim0=\"4\" Dim1=\"3\"", "Dim0=\"6\" Dim1=\"2\"", "2 numbers in a row"),
        (
            "Dim0=\"4\" Dim1=\"3\" Encoding=\"ASCII\"",
            "Dim0=\"4\" Dim1=\"3\" Encoding=\"ExternalFileBinary\"",
            "in another file",
        ),
        ("<GIFTI", "<XIFTI", "not valid XML"),
    ] {
        let error = read_loose(SQUARE.replace(from, to).as_bytes(), Path::new("a")).err().unwrap().to_string();
        assert!(error.contains(wanted) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn broken_files_give_an_error_or_a_mesh() {
    broken::check(SQUARE.as_bytes(), 600, |b| Ok(read_loose(b, Path::new("a"))?.mend().map(|s| s.mesh)));
    broken::check(SQUARE.as_bytes(), 200, |b| {
        read_columns(b, Path::new("a")).map(|r| r.map(|_| crate::assets::Mesh::default()))
    });
}
