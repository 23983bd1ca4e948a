//! A grain's numbers as constants of a shader, each with a word on what it does.

use super::template::Item;
use crate::math::{DMat3, Vec3};

/// Constants one after the other.
#[derive(Default)]
pub(super) struct Constants(pub(super) Vec<Item>);

impl Constants {
    pub(super) fn float(&mut self, name: &str, value: f32, what: &str) {
        self.put(name, "f32", float(value), what);
    }

    pub(super) fn unsigned(&mut self, name: &str, value: u32, what: &str) {
        self.put(name, "u32", format!("{value}u"), what);
    }

    pub(super) fn vector(&mut self, name: &str, value: Vec3, what: &str) {
        self.put(name, "vec3<f32>", vector(value), what);
    }

    fn put(&mut self, name: &str, kind: &str, value: String, what: &str) {
        let text = format!("const {name}: {kind} = {value}; // {what}\n");
        self.0.push(Item { name: name.into(), text });
    }

    /// A rotation, model from lattice, and for whole steps along the model's axes: where they lead on the lattice, in whole
    /// 4096ths and what is left of them.
    pub(super) fn turn(&mut self, model_from_lattice: DMat3) {
        let column = |k: usize| vector(model_from_lattice.col(k).as_vec3());
        self.matrix("TURN", [0, 1, 2].map(column), "the model's directions from the lattice's");
        let mut rests = Vec::new();
        for (k, name) in ["TURN_X", "TURN_Y", "TURN_Z"].into_iter().enumerate() {
            let exact = model_from_lattice.row(k) * 4096.0;
            let whole = (exact + crate::math::DVec3::splat(0.5)).floor();
            let value = format!("vec3<i32>({}, {}, {})", whole.x as i32, whole.y as i32, whole.z as i32);
            self.put(name, "vec3<i32>", value, "a whole step of the model on the lattice, in 4096ths");
            rests.push(((exact - whole) / 4096.0).as_vec3());
        }
        // A row of steps times this matrix.
        let rest = |i: usize| vector(Vec3::new(rests[0][i], rests[1][i], rests[2][i]));
        self.matrix("TURN_REST", [0, 1, 2].map(rest), "what those steps leave over");
    }

    fn matrix(&mut self, name: &str, columns: [String; 3], what: &str) {
        let columns = columns.join(",\n    ");
        let text = format!("const {name}: mat3x3<f32> = mat3x3<f32>( // {what}\n    {columns}\n);\n");
        self.0.push(Item { name: name.into(), text });
    }
}

/// The shortest digits that are this number again.
pub(super) fn float(x: f32) -> String {
    format!("{x:?}")
}

pub(super) fn vector(v: Vec3) -> String {
    format!("vec3<f32>({}, {}, {})", float(v.x), float(v.y), float(v.z))
}

pub(super) fn vector4(v: Vec3, w: f32) -> String {
    format!("vec4<f32>({}, {}, {}, {})", float(v.x), float(v.y), float(v.z), float(w))
}
