//! WGSL, in the plain style of the parts, as GLSL.
//!
//! The two differ in the order of names and types, in the names of types and a few functions, and in where semicolons
//! stand; what is between is the same in both. What comes out is good for GLSL ES 3.00 and GLSL 4.50 alike.

use super::template::{Token, tokens};

/// The text in GLSL.
pub(super) fn glsl(wgsl: &str) -> String {
    let words: Vec<Token> = tokens(wgsl);
    let mut out = Vec::new();
    let mut i = 0;
    // Within a structure fields end with semicolons; within a function's head its type is still to come.
    let (mut in_struct, mut head) = (false, None);
    while i < words.len() {
        let text = words[i].text();
        match words[i] {
            // Their names come with their types.
            Token::Word("let" | "var") => i += 2,
            Token::Word("fn") => {
                head = Some(out.len());
                i += 2;
            }
            Token::Word("struct") => {
                in_struct = true;
                out.push(text.to_owned());
                i += 1;
            }
            Token::Word(_) if is(&words, i + 1, ":") => {
                let (kind, next) = type_at(&words, i + 3);
                out.push(format!("{kind} {text}"));
                i = next;
            }
            Token::Word(_) => {
                let (kind, next) = type_at(&words, i);
                out.push(kind);
                i = next;
            }
            Token::Other("-") if is(&words, i + 1, ">") => {
                let (kind, next) = type_at(&words, i + 3);
                out.insert(head.take().expect("an arrow after a function's arguments"), kind + " ");
                // The space before the arrow.
                out.pop();
                i = next;
            }
            Token::Other(",") if in_struct => {
                out.push(";".into());
                i += 1;
            }
            Token::Other("}") if in_struct => {
                in_struct = false;
                out.push("};".into());
                i += 1;
            }
            _ => {
                out.push(text.to_owned());
                i += 1;
            }
        }
    }
    out.concat()
}

fn is(words: &[Token], i: usize, text: &str) -> bool {
    words.get(i).is_some_and(|w| w.text() == text)
}

/// The word at a place, as a type or function of GLSL, and what follows it.
fn type_at(words: &[Token], i: usize) -> (String, usize) {
    let text = words[i].text();
    if is(words, i + 1, "<") && (text.starts_with("vec") || text.starts_with("mat")) {
        let size = &text[3..4];
        let name = match (&text[..3], words[i + 2].text()) {
            ("mat", _) => format!("mat{size}"),
            (_, "i32") => format!("ivec{size}"),
            (_, "u32") => format!("uvec{size}"),
            _ => format!("vec{size}"),
        };
        return (name, i + 4);
    }
    let name = match text {
        "f32" => "float",
        "i32" => "int",
        "u32" => "uint",
        "atan2" => "atan",
        other => other,
    };
    (name.to_owned(), i + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_types_change_places() {
        for (wgsl, expected) in [
            ("const A: vec3<f32> = vec3<f32>(1.0);", "const vec3 A = vec3(1.0);"),
            ("let k: i32 = i32(quarter) & 3;", "int k = int(quarter) & 3;"),
            ("var b: mat3x3<f32>;", "mat3 b;"),
            ("for (var i: i32 = 0; i < 4; i++) {", "for (int i = 0; i < 4; i++) {"),
            ("fn f(a: u32, b: vec2<i32>) -> Hit {", "Hit f(uint a, ivec2 b) {"),
            (
                "struct S {\n    // One, two.\n    a: f32,\n    b: vec3<u32>,\n}\n",
                "struct S {\n    // One, two.\n    float a;\n    uvec3 b;\n};\n",
            ),
            ("return atan2(y, x) < 2.0;", "return atan(y, x) < 2.0;"),
        ] {
            assert_eq!(glsl(wgsl), expected);
        }
    }
}
