//! Data on a surface: one number or a few per vertex, face or corner, with its unit and its missing values.

/// What a field's values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// One value a vertex of the mesh; interpolated over triangles.
    Vertex,
    /// One value a triangle; constant over it.
    Face,
    /// Three values a triangle, in the order of its corners; interpolated within it.
    Corner,
}

/// The numbers of a field, element after element, components together. NaN is missing.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Holds 8- and 16-bit integers and f32 exactly.
    F32(Vec<f32>),
    /// Holds 32-bit integers and f64 exactly.
    F64(Vec<f64>),
}

impl Values {
    /// How many numbers.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number at `i`.
    #[inline]
    pub fn at(&self, i: usize) -> f64 {
        match self {
            Self::F32(v) => v[i] as f64,
            Self::F64(v) => v[i],
        }
    }

    /// Moves groups of `n` numbers: the new group `i` is the old group `source[i]`.
    pub fn gathered(&self, source: &[u32], n: usize) -> Self {
        fn go<T: Copy>(values: &[T], source: &[u32], n: usize) -> Vec<T> {
            source.iter().flat_map(|&s| values[s as usize * n..][..n].iter().copied()).collect()
        }
        match self {
            Self::F32(v) => Self::F32(go(v, source, n)),
            Self::F64(v) => Self::F64(go(v, source, n)),
        }
    }
}

/// A named property of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// As the file names it.
    pub name: String,
    /// Unit as text; empty when unknown.
    pub unit: String,
    /// What its values belong to.
    pub element: Element,
    /// Numbers a value: 1 scalar, 3 vector ...
    pub n_components: usize,
    /// `n_components` numbers for each element, in the mesh's order.
    pub values: Values,
}

/// The least and the greatest finite number, and how many are missing (NaN) or infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least finite value; +infinity when there is none.
    pub min: f64,
    /// Greatest finite value; -infinity when there is none.
    pub max: f64,
    /// NaN and infinite values.
    pub n_missing: usize,
}

impl Field {
    /// How many elements have a value.
    pub fn n_elements(&self) -> usize {
        self.values.len() / self.n_components.max(1)
    }

    /// The range of one component.
    pub fn range(&self, component: usize) -> Range {
        let mut range = Range { min: f64::INFINITY, max: f64::NEG_INFINITY, n_missing: 0 };
        for i in 0..self.n_elements() {
            let x = self.values.at(i * self.n_components + component);
            if x.is_finite() {
                range.min = range.min.min(x);
                range.max = range.max.max(x);
            } else {
                range.n_missing += 1;
            }
        }
        range
    }
}
