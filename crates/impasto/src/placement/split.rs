//! Values of corners to values of vertices: a vertex whose corners disagree becomes several.

use crate::assets::{Element, RawMesh};

/// Gives each corner's value (in the order of the triangles) to its vertex, and splits vertices that would need several.
/// The first value stays with the vertex, copies are appended; `unused` goes to vertices without a triangle. Returns the
/// value of each vertex and how many copies there are. Vertex attributes, fields and source points go along.
pub(super) fn split_corners<T: Copy + PartialEq>(raw: &mut RawMesh, corners: &[T], unused: T) -> (Vec<T>, usize) {
    const NONE: u32 = u32::MAX;
    let n_before = raw.positions.len();
    let mut source: Vec<u32> = (0..n_before as u32).collect();
    let mut values: Vec<Option<T>> = vec![None; n_before];
    // The copies of a vertex form a chain.
    let mut next: Vec<u32> = vec![NONE; n_before];
    for (corner, &value) in raw.triangles.iter_mut().flatten().zip(corners) {
        let mut at = *corner as usize;
        while values[at].is_some_and(|known| known != value) && next[at] != NONE {
            at = next[at] as usize;
        }
        if values[at].is_some_and(|known| known != value) {
            next[at] = values.len() as u32;
            at = values.len();
            source.push(*corner);
            values.push(None);
            next.push(NONE);
        }
        values[at] = Some(value);
        *corner = at as u32;
    }
    let n_copies = values.len() - n_before;
    if n_copies > 0 {
        append_copies(raw, &source);
    }
    (values.into_iter().map(|value| value.unwrap_or(unused)).collect(), n_copies)
}

/// Vertex i of the result is vertex `source[i]` of before.
fn append_copies(raw: &mut RawMesh, source: &[u32]) {
    fn extend<T: Copy>(values: &mut Vec<T>, source: &[u32]) {
        if !values.is_empty() {
            let copies = &source[values.len()..];
            values.reserve_exact(copies.len());
            copies.iter().for_each(|&s| values.push(values[s as usize]));
        }
    }
    extend(&mut raw.positions, source);
    extend(&mut raw.normals, source);
    extend(&mut raw.tangents, source);
    extend(&mut raw.colors, source);
    raw.uv_sets.iter_mut().for_each(|set| extend(&mut set.uv, source));
    match raw.source_points.is_empty() {
        true => raw.source_points = source.to_vec(),
        false => extend(&mut raw.source_points, source),
    }
    for field in raw.fields.iter_mut().filter(|f| f.element == Element::Vertex) {
        field.values = field.values.gathered(source, field.n_components);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{Field, Values};
    use crate::math::{Vec3, vec3};

    #[test]
    fn corners_that_disagree_split_their_vertex_and_all_its_attributes() {
        let mut raw = RawMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y, vec3(9.0, 9.0, 9.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            fields: vec![Field {
                name: "id".into(),
                unit: String::new(),
                element: Element::Vertex,
                n_components: 1,
                values: Values::F32(vec![0.0, 1.0, 2.0, 3.0, 4.0]),
            }],
            ..RawMesh::default()
        };
        let (values, n_copies) = split_corners(&mut raw, &[10, 11, 12, 10, 22, 13], -1);
        assert_eq!((values, n_copies), (vec![10, 11, 12, 13, -1, 22], 1));
        assert_eq!(raw.triangles, [[0, 1, 2], [0, 5, 3]]);
        assert_eq!((raw.positions[5], raw.source_points.as_slice()), (Vec3::ONE, &[0, 1, 2, 3, 4, 2][..]));
        assert_eq!(raw.fields[0].values.at(5), 2.0);
    }
}
