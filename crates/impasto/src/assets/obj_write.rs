//! A scene to OBJ, with its materials and textures beside it.

use crate::Result;
use crate::assets::files::write_atomically;
use crate::assets::image_write;
use crate::assets::{Material, Mesh, Scene, Texels, TextureImage, TextureRef, Wrap};
use crate::color::srgb_from_linear;
use std::fmt::Write as _;
use std::path::Path;

/// Writes `path`, and where there are materials `NAME.mtl` and `NAME_0.png` ... beside it.
///
/// The mesh file is written last: where it is, all it refers to is too.
pub(super) fn save(path: &Path, scene: &Scene) -> Result<()> {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let texture_name = |i: u32| format!("{stem}_{i}.png");
    for (i, image) in scene.images.iter().enumerate() {
        let path = path.with_file_name(texture_name(i as u32));
        let bytes = png(image);
        write_atomically(&path, |w| w.write_all(&bytes))?;
    }
    let library = (!scene.materials.is_empty()).then(|| format!("{stem}.mtl"));
    if let Some(name) = &library {
        let text = materials(&scene.materials, &texture_name);
        write_atomically(&path.with_file_name(name), |w| w.write_all(text.as_bytes()))?;
    }
    let text = mesh(&scene.mesh, &scene.materials, library.as_deref());
    write_atomically(path, |w| w.write_all(text.as_bytes()))
}

/// The name a material goes by in the file: unique, and one word.
fn material_name(materials: &[Material], i: usize) -> String {
    let name: String = materials[i].name.chars().map(|c| if c.is_whitespace() { '_' } else { c }).collect();
    let is_taken = materials.iter().take(i).any(|m| m.name == materials[i].name);
    if name.is_empty() || is_taken { format!("{name}material{i}") } else { name }
}

/// The mesh as text. Numbers have all the digits they need to be read back the same.
pub(super) fn mesh(mesh: &Mesh, all_materials: &[Material], library: Option<&str>) -> String {
    let mut out = String::from("# written by Impasto\n");
    // Writing to a string cannot fail.
    if let Some(library) = library {
        _ = writeln!(out, "mtllib {library}");
    }
    for (i, p) in mesh.positions().iter().enumerate() {
        _ = write!(out, "v {} {} {}", p.x, p.y, p.z);
        if let Some(c) = mesh.colors().get(i) {
            let [r, g, b] = [c.x, c.y, c.z].map(|x| srgb_from_linear(x as f64));
            _ = write!(out, " {r} {g} {b}");
        }
        out.push('\n');
    }
    let uv = mesh.uv_sets().first();
    for uv in uv.iter().flat_map(|set| &set.uv) {
        // In f64: nothing is lost when v is turned.
        _ = writeln!(out, "vt {} {}", uv.x, 1.0 - uv.y as f64);
    }
    for n in mesh.normals() {
        _ = writeln!(out, "vn {} {} {}", n.x, n.y, n.z);
    }
    for part in mesh.parts() {
        if !part.name.is_empty() {
            _ = writeln!(out, "g {}", part.name.replace(['\n', '\r'], " "));
        }
        if let Some(i) = part.material.filter(|i| (*i as usize) < all_materials.len()) {
            _ = writeln!(out, "usemtl {}", material_name(all_materials, i as usize));
        }
        for t in &mesh.triangles()[part.triangles.start as usize..part.triangles.end as usize] {
            out.push('f');
            for v in t.map(|v| v + 1) {
                _ = if uv.is_some() { write!(out, " {v}/{v}/{v}") } else { write!(out, " {v}//{v}") };
            }
            out.push('\n');
        }
    }
    out
}

fn materials(materials: &[Material], texture_name: &dyn Fn(u32) -> String) -> String {
    let mut out = String::from("# written by Impasto\n");
    for (i, m) in materials.iter().enumerate() {
        let rgb = |c: [f32; 3]| c.map(|x| srgb_from_linear(x as f64)).map(|x| x.to_string()).join(" ");
        let [r, g, b, alpha] = m.base_color;
        _ = writeln!(out, "\nnewmtl {}", material_name(materials, i));
        _ = writeln!(out, "Kd {}", rgb([r, g, b]));
        _ = writeln!(out, "Pr {}\nPm {}\nd {alpha}\nillum {}", m.roughness, m.metalness, if m.unlit { 0 } else { 2 });
        if m.emission != [0.0; 3] {
            _ = writeln!(out, "Ke {}", rgb(m.emission));
        }
        let mut map = |keyword: &str, texture: &Option<TextureRef>, options: &str| {
            if let Some(t) = texture {
                _ = writeln!(out, "{keyword} {options}{}{}", placement(t), texture_name(t.image));
            }
        };
        map("map_Kd", &m.base_color_texture, "");
        map("map_Ke", &m.emission_texture, "");
        map("map_d", &m.alpha_texture, "");
        map("norm", &m.normal_texture, &format!("-bm {} ", m.normal_scale));
        map("map_Bump", &m.bump_texture, &format!("-bm {} ", m.bump_scale));
        // Green and blue of one image, told apart by their channel.
        map("map_Pr", &m.metal_rough_texture, "-imfchan g ");
        map("map_Pm", &m.metal_rough_texture, "-imfchan b ");
    }
    out
}

/// A transform as `-s` and `-o`, which count v upwards. What they cannot say (turning, shearing) is left out.
fn placement(t: &TextureRef) -> String {
    let [[su, _], [_, sv]] = t.transform.matrix;
    let [ou, ov] = [t.transform.offset[0], 1.0 - sv - t.transform.offset[1]];
    let mut text = String::new();
    if (su, sv) != (1.0, 1.0) {
        text += &format!("-s {su} {sv} 1 ");
    }
    if (ou, ov) != (0.0, 0.0) {
        text += &format!("-o {ou} {ov} 0 ");
    }
    if t.sampler.wrap[0] == Wrap::ClampToBorder {
        text += "-clamp on ";
    }
    text
}

/// An image with as many bits and channels as it came with; floats get 16 bits.
fn png(image: &TextureImage) -> Vec<u8> {
    fn samples<T: Copy>(texels: &[[T; 4]], n_channels: u8) -> Vec<T> {
        // Grey is repeated in memory: its channels are the first and the last.
        let which: &[usize] = match n_channels {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        texels.iter().flat_map(|t| which.iter().map(|&c| t[c])).collect()
    }
    let (size, n, encoding) = (image.texels.size(), image.n_channels, image.encoding);
    match &image.texels {
        Texels::U8(i) => image_write::png8(size, &samples(&i.texels, n), encoding, &[]),
        Texels::U16(i) => image_write::png16(size, &samples(&i.texels, n), encoding, &[]),
        Texels::F32(i) => {
            let wide: Vec<u16> =
                samples(&i.texels, n).iter().map(|x| (x.clamp(0.0, 1.0) * 65535.0).round() as u16).collect();
            image_write::png16(size, &wide, encoding, &[])
        }
    }
}
