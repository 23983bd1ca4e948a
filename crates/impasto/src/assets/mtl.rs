//! Wavefront MTL: materials of the nineties in the words of metal and roughness.
//!
//! - Colours (`Kd`, `Ke`) are display values (sRGB), as the tools of the format's time showed them.
//! - `Ns` becomes roughness by the usual match of Blinn-Phong and GGX highlights (Karis 2013, after Walter et al. 2007):
//!   alpha = sqrt(2 / (Ns + 2)), roughness = sqrt(alpha). A black `Ks`, or `illum` 0 and 1, mean no highlight: roughness 1.
//! - `Pr`, `Pm` and their maps (the format's physical extension) are taken as they are. `illum 0` is unlit.
//! - `Tr 1` without `d` would make all invisible; many scanners' tools write opacity there, so it is taken as opaque.
//! - `map_Kd` with a black `Kd` is taken as meant for the map alone.
//! - `-s` and `-o` act on coordinates that count v upwards; they are turned into ours. `-clamp on` is once only.
//! - A bump map whose channels differ and whose blue is high holds normals, and is used as a normal map.

use crate::assets::image::Image;
use crate::assets::text::{Lines, Words, number, string, trimmed};
use crate::assets::{
    AlphaMode, Material, Neighbours, Sampler, Texels, TextureImage, TextureRef, UvTransform, Wrap, image_files,
};
use crate::color::{Encoding, linear_from_srgb};
use crate::error::{Mended, note};
use std::collections::HashMap;
use std::path::Path;

/// What material libraries hold.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<TextureImage>,
    /// By name as written and by what was made of it: index into `images`; none where it could not be read. Never
    /// enumerated.
    loaded: HashMap<(String, Use), Option<u32>>,
}

/// Which of an image's numbers are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Use {
    /// All, as they are.
    Whole,
    /// One channel, made grey.
    Channel(Channel),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channel {
    Red,
    Green,
    Blue,
    /// Alpha where the file has it, else red.
    Matte,
}

/// A texture statement: options and name.
#[derive(Clone, Debug, PartialEq)]
struct Map {
    name: String,
    scale: [f32; 2],
    offset: [f32; 2],
    bump: f32,
    clamp: bool,
    channel: Option<Channel>,
    /// Options that change the look but are not followed.
    n_passed_over: usize,
}

/// What a `newmtl` section says, before it is made a material.
#[derive(Default)]
struct Section {
    name: String,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    exponent: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    roughness: Option<f32>,
    metalness: Option<f32>,
    illum: Option<f32>,
    maps: Vec<(String, Map)>,
}

/// Adds a library's materials. What cannot be read is reported, never fatal.
pub(super) fn read(bytes: &[u8], neighbours: &Neighbours, library: &mut Library, mended: &mut Vec<Mended>) {
    let text = super::text::utf8(bytes);
    let mut section: Option<Section> = None;
    for (_, line) in Lines::joined(&text) {
        let mut words = Words(&line);
        let Some(keyword) = words.next() else { continue };
        let keyword = string(keyword).to_ascii_lowercase();
        if keyword == "newmtl" {
            if let Some(done) = section.take() {
                library.add(done, neighbours, mended);
            }
            section = Some(Section { name: string(trimmed(words.0)), ..Default::default() });
        } else if let Some(section) = &mut section {
            section.statement(&keyword, words);
        }
    }
    if let Some(done) = section {
        library.add(done, neighbours, mended);
    }
}

impl Section {
    fn statement(&mut self, keyword: &str, words: Words) {
        let x: Vec<f32> = words.clone().map_while(number).map(|x| x as f32).filter(|x| x.is_finite()).take(3).collect();
        let one = x.first().copied();
        // One number stands for all three.
        let color = one.map(|r| [r, x.get(1).copied().unwrap_or(r), x.get(2).copied().unwrap_or(r)]);
        match keyword {
            "kd" => self.diffuse = color,
            "ks" => self.specular = color,
            "ke" => self.emission = color,
            "ns" => self.exponent = one,
            "d" => {
                // `d -halo 0.5` dissolves towards the rim; its number is the least opacity.
                self.opacity = one.or_else(|| words.clone().filter_map(number).next().map(|x| x as f32));
            }
            "tr" => self.transparency = one,
            "pr" => self.roughness = one,
            "pm" => self.metalness = one,
            "illum" => self.illum = one,
            _ => {
                let is_map = keyword.starts_with("map_") || ["bump", "norm", "disp", "refl"].contains(&keyword);
                if let (true, Some(map)) = (is_map, Map::parse(words)) {
                    self.maps.push((keyword.into(), map));
                }
            }
        }
    }
}

impl Map {
    /// `-options ... name with blanks`; options after the name are known too. None without a name.
    fn parse(words: Words) -> Option<Self> {
        let mut map = Self {
            name: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            bump: 1.0,
            clamp: false,
            channel: None,
            n_passed_over: 0,
        };
        let mut name: Vec<&[u8]> = Vec::new();
        let mut rest = words;
        let mut start = None;
        loop {
            let before = rest.clone();
            let Some(word) = rest.next() else { break };
            if !map.option(word, &mut rest) {
                start.get_or_insert(trimmed(before.0));
                name.push(word);
            } else if !name.is_empty() {
                // What follows an option after the name is not part of it.
                continue;
            }
        }
        // The name keeps its own blanks where nothing follows it.
        let whole = start?;
        let joined = name.join(&b' ');
        map.name = if Words(whole).eq(name.iter().copied()) { string(whole) } else { string(&joined) };
        Some(map)
    }

    /// Takes an option and its values; false if the word is none.
    fn option(&mut self, word: &[u8], rest: &mut Words) -> bool {
        let mut numbers = |most: usize| {
            let mut values = Vec::new();
            while values.len() < most {
                let mut ahead = rest.clone();
                let Some(x) = ahead.next().and_then(number).filter(|x| x.is_finite()) else { break };
                values.push(x as f32);
                *rest = ahead;
            }
            values
        };
        let pair =
            |v: Vec<f32>, default: f32| [v.first().copied().unwrap_or(default), v.get(1).copied().unwrap_or(default)];
        match word {
            b"-s" => self.scale = pair(numbers(3), 1.0),
            b"-o" => self.offset = pair(numbers(3), 0.0),
            b"-bm" => self.bump = numbers(1).first().copied().unwrap_or(1.0),
            b"-clamp" => self.clamp = rest.next() == Some(b"on"),
            b"-imfchan" => {
                self.channel = match rest.next() {
                    Some(b"r") => Some(Channel::Red),
                    Some(b"g") => Some(Channel::Green),
                    Some(b"b") => Some(Channel::Blue),
                    Some(b"m") => Some(Channel::Matte),
                    _ => None,
                }
            }
            // Filtering is ours to choose, and `-cc`, `-type` change nothing for a flat map.
            b"-blendu" | b"-blendv" | b"-cc" | b"-type" | b"-colorspace" => drop(rest.next()),
            b"-texres" => drop(numbers(1)),
            b"-t" => {
                numbers(3);
                self.n_passed_over += 1;
            }
            b"-mm" => {
                numbers(2);
                self.n_passed_over += 1;
            }
            b"-boost" => {
                numbers(1);
                self.n_passed_over += 1;
            }
            _ => return false,
        }
        true
    }

    fn texture(&self, image: u32) -> TextureRef {
        let wrap = if self.clamp { Wrap::ClampToBorder } else { Wrap::Repeat };
        let [su, sv] = self.scale;
        // v counts downwards here: 1 - (sv (1 - v) + ov).
        let offset = [self.offset[0], 1.0 - sv - self.offset[1]];
        TextureRef {
            image,
            uv_set: 0,
            sampler: Sampler { wrap: [wrap; 3], ..Default::default() },
            transform: UvTransform { matrix: [[su, 0.0], [0.0, sv]], offset },
        }
    }
}

fn light(c: [f32; 3]) -> [f32; 3] {
    c.map(|x| linear_from_srgb(x.max(0.0) as f64) as f32)
}

impl Library {
    fn add(&mut self, section: Section, neighbours: &Neighbours, mended: &mut Vec<Mended>) {
        let mut m = Material { name: section.name.clone(), ..Default::default() };
        let find = |names: &[&str]| section.maps.iter().find(|(k, _)| names.contains(&k.as_str())).map(|(_, map)| map);
        let mut load = |names: &[&str], usage: Use, library: &mut Self| {
            let map = find(names)?;
            note(mended, map.n_passed_over, "texture options -t, -mm, -boost passed over");
            let image = library.load(&map.name, usage, neighbours, mended)?;
            Some((map.texture(image), map.bump))
        };
        let texture = |found: Option<(TextureRef, f32)>| found.map(|f| f.0);

        m.base_color_texture = texture(load(&["map_kd"], Use::Whole, self));
        m.emission_texture = texture(load(&["map_ke"], Use::Whole, self));
        if let Some((normal, scale)) = load(&["norm", "map_kn"], Use::Whole, self) {
            (m.normal_texture, m.normal_scale) = (Some(normal), scale);
        }
        let bump_channel = find(&["map_bump", "bump"]).and_then(|map| map.channel);
        let bump_use = bump_channel.map_or(Use::Whole, Use::Channel);
        if let Some((bump, scale)) = load(&["map_bump", "bump"], bump_use, self) {
            if bump_channel.is_none() && holds_normals(&self.images[bump.image as usize].texels) {
                m.normal_texture.get_or_insert(bump);
                m.normal_scale = scale;
            } else {
                (m.bump_texture, m.bump_scale) = (Some(bump), scale);
            }
        }
        let alpha_channel = find(&["map_d"]).and_then(|map| map.channel).unwrap_or(Channel::Matte);
        m.alpha_texture = texture(load(&["map_d"], Use::Channel(alpha_channel), self));
        let grey = |name: &str| find(&[name]).and_then(|map| map.channel).map_or(Use::Whole, Use::Channel);
        let rough = texture(load(&["map_pr"], grey("map_pr"), self));
        let metal = texture(load(&["map_pm"], grey("map_pm"), self));
        m.metal_rough_texture = self.metal_rough(rough, metal);
        let passed_over = section
            .maps
            .iter()
            .filter(|(k, _)| ["map_ks", "map_ns", "disp", "refl", "map_disp", "map_refl"].contains(&k.as_str()));
        note(
            mended,
            passed_over.count(),
            "textures for specular colour, sharpness, displacement, reflection passed over",
        );
        section.set_factors(&mut m, rough.is_some(), metal.is_some(), mended);
        self.materials.push(m);
    }

    /// The index of an image, read once for each use.
    fn load(&mut self, name: &str, usage: Use, neighbours: &Neighbours, mended: &mut Vec<Mended>) -> Option<u32> {
        if let Some(image) = self.loaded.get(&(name.to_string(), usage)) {
            return *image;
        }
        let image = match neighbours(name) {
            Err(why) => {
                note(mended, 1, format!("texture {name:?} not read: {why}"));
                None
            }
            Ok(bytes) => match image_files::read(&bytes, Path::new(name)) {
                Err(why) => {
                    note(mended, 1, format!("texture not read: {why}"));
                    None
                }
                Ok(report) => {
                    mended.extend(report.mended);
                    Some(report.value)
                }
            },
        };
        let image = image.map(|mut image| {
            if let Use::Channel(channel) = usage {
                image = image.channel(channel);
            }
            self.images.push(image);
            self.images.len() as u32 - 1
        });
        self.loaded.insert((name.into(), usage), image);
        image
    }

    /// Two grey maps as the green and the blue of one. Different sizes are brought to the greater by the nearest texel.
    fn metal_rough(&mut self, rough: Option<TextureRef>, metal: Option<TextureRef>) -> Option<TextureRef> {
        let texture = rough.or(metal)?;
        let grey = |t: Option<TextureRef>| t.map(|t| self.images[t.image as usize].clone());
        let (rough, metal) = (grey(rough), grey(metal));
        let size = |i: &Option<TextureImage>| i.as_ref().map(|i| i.texels.size()).unwrap_or_default();
        let (a, b) = (size(&rough), size(&metal));
        let size = crate::math::Size::new(a.width.max(b.width), a.height.max(b.height));
        let at = |image: &Option<TextureImage>, x: u32, y: u32| match image {
            None => 255,
            Some(image) => {
                let s = image.texels.size();
                let scaled = |i: u32, from: u32, to: u32| (i as u64 * to as u64 / from.max(1) as u64) as u32;
                image.texels.byte(scaled(x, size.width, s.width), scaled(y, size.height, s.height), 0)
            }
        };
        let texels = Image::from_fn(size, |x, y| [255, at(&rough, x, y), at(&metal, x, y), 255]);
        let name = format!("metal_rough_{}.png", self.images.len());
        self.images.push(TextureImage { name, texels: Texels::U8(texels), encoding: Encoding::Linear, n_channels: 3 });
        Some(TextureRef { image: self.images.len() as u32 - 1, ..texture })
    }
}

impl Section {
    fn set_factors(&self, m: &mut Material, has_rough_map: bool, has_metal_map: bool, mended: &mut Vec<Mended>) {
        let mut diffuse = self.diffuse.unwrap_or(if m.base_color_texture.is_some() { [1.0; 3] } else { [0.6; 3] });
        if diffuse == [0.0; 3] && m.base_color_texture.is_some() {
            diffuse = [1.0; 3];
            note(mended, 1, "black colours under a colour texture taken as white");
        }
        let mut alpha = self.opacity.or(self.transparency.map(|t| 1.0 - t)).unwrap_or(1.0).clamp(0.0, 1.0);
        if self.opacity.is_none() && alpha == 0.0 {
            alpha = 1.0;
            note(mended, 1, "fully transparent materials (Tr 1) taken as opaque");
        }
        let [r, g, b] = light(diffuse);
        m.base_color = [r, g, b, alpha];
        m.alpha_mode = if alpha < 1.0 || m.alpha_texture.is_some() { AlphaMode::Blend } else { AlphaMode::Opaque };
        let emission = self.emission.unwrap_or([0.0; 3]);
        let is_map_alone = emission == [0.0; 3] && m.emission_texture.is_some();
        m.emission = if is_map_alone { [1.0; 3] } else { light(emission) };
        let is_dull = self.specular == Some([0.0; 3]) || self.illum.is_some_and(|i| i < 2.0);
        m.roughness = match (self.roughness, self.exponent) {
            (Some(r), _) => r.clamp(0.0, 1.0),
            (None, _) if has_rough_map => 1.0,
            (None, _) if is_dull => 1.0,
            (None, Some(ns)) => (2.0 / (ns.max(0.0) + 2.0)).sqrt().sqrt(),
            (None, None) => m.roughness,
        };
        m.metalness = self.metalness.unwrap_or(if has_metal_map { 1.0 } else { 0.0 }).clamp(0.0, 1.0);
        m.unlit = self.illum == Some(0.0);
    }
}

impl TextureImage {
    /// One channel as a grey image.
    fn channel(&self, channel: Channel) -> Self {
        let has_alpha = self.n_channels == 2 || self.n_channels == 4;
        let i = match channel {
            Channel::Red => 0,
            Channel::Green => 1,
            Channel::Blue => 2,
            Channel::Matte => {
                if has_alpha {
                    3
                } else {
                    0
                }
            }
        };
        fn grey<T: Copy>(image: &Image<[T; 4]>, i: usize, full: T) -> Image<[T; 4]> {
            let texels = image.texels.iter().map(|t| [t[i], t[i], t[i], full]).collect();
            Image { size: image.size, texels }
        }
        let texels = match &self.texels {
            Texels::U8(image) => Texels::U8(grey(image, i, u8::MAX)),
            Texels::U16(image) => Texels::U16(grey(image, i, u16::MAX)),
            Texels::F32(image) => Texels::F32(grey(image, i, 1.0)),
        };
        Self { name: self.name.clone(), texels, encoding: Encoding::Linear, n_channels: 1 }
    }
}

impl Texels {
    /// A channel of a texel as one of 256 steps.
    fn byte(&self, x: u32, y: u32, channel: usize) -> u8 {
        match self {
            Self::U8(i) => i.at(x, y)[channel],
            Self::U16(i) => (i.at(x, y)[channel] >> 8) as u8,
            Self::F32(i) => crate::color::unorm8(i.at(x, y)[channel]),
        }
    }
}

/// Whether an image's colours are unit vectors that look out of the surface: blue is high, and is not just grey.
fn holds_normals(texels: &Texels) -> bool {
    let size = texels.size();
    let (mut blue, mut spread, mut n) = (0u64, 0u64, 0u64);
    // A grid of some thousand texels tells.
    let step = |n: u32| (n / 64).max(1) as usize;
    for y in (0..size.height).step_by(step(size.height)) {
        for x in (0..size.width).step_by(step(size.width)) {
            let [r, g, b] = [0, 1, 2].map(|c| texels.byte(x, y, c) as u64);
            blue += b;
            spread += b.abs_diff(r) + b.abs_diff(g);
            n += 1;
        }
    }
    n > 0 && blue > 180 * n && spread > 120 * n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_options_are_parsed_before_and_after_names_with_blanks() {
        let parse = |line: &str| Map::parse(Words(line.as_bytes())).unwrap();
        assert_eq!(parse("texture 01.png").name, "texture 01.png");
        assert_eq!(parse("two  blanks.png ").name, "two  blanks.png");
        let map = parse("-bm 2 bump 01.png");
        assert_eq!((map.name.as_str(), map.bump), ("bump 01.png", 2.0));
        let map = parse("-imfchan r bumpmap2.jpg -bm 1.5");
        assert_eq!((map.name.as_str(), map.bump, map.channel), ("bumpmap2.jpg", 1.5, Some(Channel::Red)));
        let map = parse("-s 2 4 -o 0.1 -clamp on -blendu off -mm 0 1 -type sphere a.jpg");
        assert_eq!((map.scale, map.offset, map.clamp, map.name.as_str()), ([2.0, 4.0], [0.1, 0.0], true, "a.jpg"));
        let t = map.texture(7).transform;
        // At the file's (u, v) = (0.25, 0.75), ours (0.25, 0.25): 2 u + 0.1, and 1 - 4 * 0.75.
        let v = t.matrix[1][1] * 0.25 + t.offset[1];
        assert_eq!([t.matrix[0][0] * 0.25 + t.offset[0], v], [0.6, -2.0]);
        assert_eq!(Map::parse(Words(b"-bm 2")), None);
    }

    #[test]
    fn materials_are_translated() {
        let text =
            b"newmtl a\nKd 1 0.5 0\nNs 98\nd 0.25\nKe 1 1 1\nnewmtl b\nTr 1\nillum 0\nnewmtl c\nPr 0.3\nPm 1\nKs 0 0 0";
        let (mut library, mut mended) = (Library::default(), Vec::new());
        read(text, &|_| Err(std::io::ErrorKind::NotFound.into()), &mut library, &mut mended);
        let [a, b, c] = &library.materials[..] else { panic!("three materials") };
        assert_eq!(a.base_color, [1.0, linear_from_srgb(0.5) as f32, 0.0, 0.25]);
        assert_eq!((a.alpha_mode, a.emission), (AlphaMode::Blend, [1.0; 3]));
        assert!((a.roughness - 0.02f32.powf(0.25)).abs() < 1e-6);
        assert_eq!((b.base_color[3], b.unlit, b.roughness), (1.0, true, 1.0));
        assert_eq!((c.roughness, c.metalness), (0.3, 1.0));
        assert_eq!(mended.len(), 1);
    }
}
