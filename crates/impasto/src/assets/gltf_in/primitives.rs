//! Meshes of the file, put into the world one after another, and made one mesh.

use super::Notes;
use super::buffers::{Accessor, Buffers};
use super::json::{Fault, Json};
use super::looks::Looks;
use super::nodes::{Instance, weights};
use crate::assets::numbers::Kind;
use crate::assets::{Element, Field, Material, Part, RawMesh, UvSet, Values};
use crate::math::{DVec3, Frame, Vec2, Vec3, Vec4, unit_or, vec2, vec3, vec4};
use glam::{DMat3, DMat4};

/// More sets of texture coordinates than anyone uses.
const MAX_UV_SETS: usize = 16;
/// Instances may not make a scene larger than this ...
const MAX_BYTES: usize = 1 << 30;
/// ... unless the file is large itself: so many bytes of mesh for each byte of its buffers.
const MAX_GROWTH: usize = 64;

/// The one mesh that all others are added to.
pub(super) struct Shape<'a> {
    buffers: &'a Buffers<'a>,
    raw: RawMesh,
    /// For each part: the file's material, and whether its vertices have tangents of their own.
    looks: Vec<(Option<usize>, bool)>,
    /// For each UV set: does any vertex have it, and how many have not.
    uv: Vec<Lacking>,
    colors: Lacking,
    n_points: u32,
}

/// How many vertices have an attribute, how many have not.
#[derive(Clone, Copy, Default)]
struct Lacking {
    n_with: usize,
    n_without: usize,
}

/// The vertices of one primitive, or of several that share them, in world space.
struct Block {
    positions: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    tangents: Option<Vec<Vec4>>,
    colors: Option<Vec<Vec4>>,
    uv: Vec<Option<Vec<Vec2>>>,
    fields: Vec<Field>,
    /// Which of the primitive's points each vertex is; none: itself.
    source: Option<Vec<u32>>,
}

/// Vertices that several primitives of a mesh may use: those with the same attributes.
struct Shared {
    attributes: Vec<(String, usize)>,
    first: u32,
    has_tangents: bool,
}

impl<'a> Shape<'a> {
    pub(super) fn new(buffers: &'a Buffers<'a>) -> Self {
        let raw = RawMesh::default();
        Self { buffers, raw, looks: Vec::new(), uv: Vec::new(), colors: Lacking::default(), n_points: 0 }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.raw.triangles.is_empty()
    }

    /// Adds a mesh where it stands. Fails only when the whole becomes too large.
    pub(super) fn add(&mut self, instance: &Instance<'a>, notes: &mut Notes) -> Result<(), Fault> {
        let root = &self.buffers.root;
        let mesh = root.item("meshes", instance.mesh);
        let mesh = match mesh.and_then(|mesh| mesh.items("primitives").map(|p| (mesh, p))) {
            Ok(found) => found,
            Err(fault) => {
                notes.add("meshes left out", fault);
                return Ok(());
            }
        };
        let (mesh, primitives) = mesh;
        notes.add_many("primitives of morph targets shown with the file's own weights", has_targets(&primitives), "");
        let mut shared: Vec<Shared> = Vec::new();
        let n_primitives = primitives.len();
        for (i, primitive) in primitives.iter().enumerate() {
            let name = name(instance, &mesh, primitive, (n_primitives > 1).then_some(i));
            match self.add_primitive(instance, &mesh, primitive, &mut shared, name, notes) {
                Ok(()) => {}
                Err(fault) if fault.starts_with(TOO_LARGE) => return Err(fault),
                Err(fault) => notes.add("primitives left out", fault),
            }
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        instance: &Instance,
        mesh: &Json,
        primitive: &Json,
        shared: &mut Vec<Shared>,
        name: String,
        notes: &mut Notes,
    ) -> Result<(), Fault> {
        let mode = primitive.index("mode")?.unwrap_or(4);
        if mode < 4 {
            notes.add("primitives of points or lines left out", primitive.place.clone());
            return Ok(());
        }
        let attributes = attributes(primitive)?;
        let n_vertices = self.position(primitive, &attributes)?.count;
        let (triangles, n_out) = self.triangles(primitive, mode, n_vertices, notes)?;
        notes.add_many("triangles with vertices that do not exist left out", n_out, primitive.place.clone());
        if triangles.is_empty() {
            return Ok(());
        }
        self.check_growth(n_vertices, triangles.len(), primitive)?;
        let material = notes.kept(primitive.index("material"), "primitives");
        let mirrored = instance.skin.is_none() && instance.world_from_mesh.determinant() < 0.0;
        let flip = |t: [u32; 3]| if mirrored { [t[0], t[2], t[1]] } else { t };
        let mut triangles: Vec<[u32; 3]> = triangles.into_iter().map(flip).collect();

        let known = shared.iter().find(|s| s.attributes == attributes && primitive.member("targets").is_none());
        let (first, has_tangents) = match known {
            Some(known) => (known.first, known.has_tangents),
            None => {
                let mut block = self.block(instance, mesh, primitive, &attributes, mirrored, notes)?;
                let has_normals = block.normals.is_some();
                if !has_normals {
                    notes.add("primitives without normals given flat ones, as glTF asks", primitive.place.clone());
                    self.check_growth(triangles.len() * 3, triangles.len(), primitive)?;
                    block = flat(block, &mut triangles);
                }
                let has_tangents = block.tangents.is_some();
                let first = self.append(block, n_vertices as u32);
                if has_normals {
                    shared.push(Shared { attributes, first, has_tangents });
                }
                (first, has_tangents)
            }
        };
        let start = self.raw.triangles.len() as u32;
        self.raw.triangles.extend(triangles.iter().map(|t| t.map(|i| i + first)));
        let end = self.raw.triangles.len() as u32;
        self.raw.parts.push(Part { name, triangles: start..end, material: None });
        self.looks.push((material, has_tangents));
        Ok(())
    }

    fn position(&self, primitive: &Json, attributes: &[(String, usize)]) -> Result<Accessor<'a>, Fault> {
        let (_, i) =
            attributes.iter().find(|(name, _)| name == "POSITION").ok_or_else(|| primitive.fault("no POSITION"))?;
        let accessor = self.buffers.accessor(*i)?;
        if accessor.n_components() != 3 {
            return Err(accessor.json.fault("positions must have three components"));
        }
        let packed = ["KHR_draco_mesh_compression"].iter().any(|e| primitive.extension(e).is_ok_and(|e| e.is_some()));
        if packed && accessor.json.member("bufferView").is_none() {
            return Err(primitive.fault("Draco compression is not read"));
        }
        self.buffers.check(&accessor)?;
        Ok(accessor)
    }

    fn check_growth(&self, n_vertices: usize, n_triangles: usize, primitive: &Json) -> Result<(), Fault> {
        let n_vertices = self.raw.positions.len().saturating_add(n_vertices);
        let n_triangles = self.raw.triangles.len().saturating_add(n_triangles);
        let n_numbers: usize = self.raw.fields.iter().map(|f| f.n_components).sum();
        let per_vertex = 60 + 8 * self.raw.uv_sets.len() + 8 * n_numbers;
        let n_bytes = n_vertices.saturating_mul(per_vertex).saturating_add(n_triangles.saturating_mul(12));
        let most = MAX_BYTES.max(self.buffers.n_bytes().saturating_mul(MAX_GROWTH)).min(u32::MAX as usize * 12);
        if n_bytes > most {
            return Err(format!(
                "{TOO_LARGE} at {}: {n_vertices} vertices from {} bytes of buffers",
                primitive.place,
                self.buffers.n_bytes()
            ));
        }
        Ok(())
    }

    /// Corners of the primitive's triangles, and how many were dropped because a vertex does not exist.
    fn triangles(
        &self,
        primitive: &Json,
        mode: usize,
        n_vertices: usize,
        notes: &mut Notes,
    ) -> Result<(Vec<[u32; 3]>, usize), Fault> {
        let indices: Vec<u32> = match primitive.index("indices")? {
            None => (0..u32::try_from(n_vertices).map_err(|_| primitive.fault("too many vertices"))?).collect(),
            Some(i) => {
                let accessor = self.buffers.accessor(i)?;
                let fits = matches!(accessor.component, Kind::U8 | Kind::U16 | Kind::U32);
                if !fits || accessor.n_components() != 1 {
                    return Err(accessor.json.fault("indices must be unsigned whole numbers"));
                }
                self.buffers.numbers(&accessor, false)?.into_iter().map(|x| x as u32).collect()
            }
        };
        let mut triangles: Vec<[u32; 3]> = match mode {
            4 => indices.as_chunks().0.to_vec(),
            5 => (0..indices.len().saturating_sub(2))
                .map(|i| [indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]])
                .collect(),
            6 => indices.windows(2).skip(1).map(|w| [w[0], w[1], indices[0]]).collect(),
            other => return Err(primitive.fault(format_args!("{other} is no primitive mode"))),
        };
        if mode == 4 {
            notes.add_many("corners left over after the last triangle", indices.len() % 3, primitive.place.clone());
        }
        let n_all = triangles.len();
        triangles.retain(|t| t.iter().all(|&i| (i as usize) < n_vertices));
        let n_out = n_all - triangles.len();
        if mode != 4 {
            // Strips are turned and joined with triangles without area.
            triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        }
        Ok((triangles, n_out))
    }

    /// The vertices of a primitive in world space.
    fn block(
        &self,
        instance: &Instance,
        mesh: &Json,
        primitive: &Json,
        attributes: &[(String, usize)],
        mirrored: bool,
        notes: &mut Notes,
    ) -> Result<Block, Fault> {
        let n = self.position(primitive, attributes)?.count;
        let mut read = Attributes { buffers: self.buffers, primitive, attributes, n_vertices: n, notes };
        let mut positions = read.vectors::<3>("POSITION", Meaning::AsFlagged)?.unwrap_or_default();
        let mut normals = read.optional::<3>("NORMAL", Meaning::Fraction);
        let mut tangents = read.optional::<4>("TANGENT", Meaning::Fraction).filter(|_| normals.is_some());
        let colors = read.colors();
        let uv = read.uv_sets();
        let fields = read.fields();

        let own = instance.weights.clone();
        let weights = own.map_or_else(|| read.notes.kept(weights(mesh), "meshes"), Some).unwrap_or_default();
        read.morph(&weights, &mut positions, &mut normals, &mut tangents);

        let flipped = if mirrored { -1.0 } else { 1.0 };
        let poses = instance.skin.as_ref().and_then(|skin| read.poses(skin, instance));
        let world = |i: usize| poses.as_ref().map_or(instance.world_from_mesh, |p| p[i]);
        let still = poses.is_none() && instance.world_from_mesh == DMat4::IDENTITY;
        let to_vec3 = |v: &[f64; 3]| vec3(v[0] as f32, v[1] as f32, v[2] as f32);
        let moved = |(i, p): (usize, &[f64; 3])| world(i).transform_point3(DVec3::from_array(*p)).as_vec3();
        let turned = |(i, v): (usize, &[f64; 3])| {
            let v = (normal_matrix(world(i)) * DVec3::from_array(*v)).as_vec3();
            unit_or(v, v)
        };
        let along = |(i, v): (usize, &[f64; 4])| {
            let t = world(i).transform_vector3(DVec3::new(v[0], v[1], v[2])).as_vec3();
            let t = unit_or(t, t);
            vec4(t.x, t.y, t.z, v[3] as f32 * flipped)
        };
        let as_it_is = |v: &[f64; 4]| vec4(v[0] as f32, v[1] as f32, v[2] as f32, v[3] as f32);
        Ok(Block {
            positions: match still {
                true => positions.iter().map(to_vec3).collect(),
                false => positions.iter().enumerate().map(moved).collect(),
            },
            normals: normals.map(|normals| match still {
                true => normals.iter().map(to_vec3).collect(),
                false => normals.iter().enumerate().map(turned).collect(),
            }),
            tangents: tangents.map(|tangents| match still {
                true => tangents.iter().map(as_it_is).collect(),
                false => tangents.iter().enumerate().map(along).collect(),
            }),
            colors,
            uv,
            fields,
            source: None,
        })
    }

    /// Adds vertices; gives the index of the first.
    fn append(&mut self, block: Block, n_points: u32) -> u32 {
        let raw = &mut self.raw;
        let (first, n) = (raw.positions.len(), block.positions.len());
        let normals = block.normals.unwrap_or_default();
        raw.positions.extend(block.positions);
        // Vertices without tangents get some at right angles to the normal; whether they may stay is seen at the end.
        match block.tangents {
            Some(tangents) => raw.tangents.extend(tangents),
            None => raw.tangents.extend(normals.iter().map(|n| Frame::about(unit_or(*n, Vec3::Y)).tangent.extend(1.0))),
        }
        raw.normals.extend(normals);
        fill(&mut raw.colors, block.colors, [first, n], Vec4::ONE, &mut self.colors);
        for k in 0..block.uv.len().max(raw.uv_sets.len()) {
            if k == raw.uv_sets.len() {
                raw.uv_sets.push(UvSet { name: format!("uv{k}"), uv: vec![Vec2::ZERO; first] });
                self.uv.push(Lacking { n_with: 0, n_without: first });
            }
            let uv = block.uv.get(k).cloned().flatten();
            fill(&mut raw.uv_sets[k].uv, uv, [first, n], Vec2::ZERO, &mut self.uv[k]);
        }
        for field in block.fields {
            let known = raw.fields.iter().position(|f| f.name == field.name && f.n_components == field.n_components);
            let k = known.unwrap_or_else(|| {
                raw.fields.push(Field { values: Values::F32(Vec::new()), ..field.clone() });
                raw.fields.len() - 1
            });
            extend(&mut raw.fields[k], first, Some(field.values));
        }
        let sources = block.source.unwrap_or_else(|| (0..n as u32).collect());
        raw.source_points.extend(sources.into_iter().map(|i| i + self.n_points));
        self.n_points += n_points;
        first as u32
    }

    /// The whole mesh, and the materials that it uses.
    pub(super) fn finish(mut self, looks: &mut Looks<'a>, notes: &mut Notes) -> (RawMesh, Vec<Material>) {
        let n = self.raw.positions.len();
        for field in &mut self.raw.fields {
            extend(field, n, None);
        }
        let raw = &mut self.raw;
        if self.colors.n_with == 0 {
            raw.colors.clear();
        } else {
            notes.add_many("vertices without a colour made white", self.colors.n_without, "");
        }
        for (k, lacking) in self.uv.iter().enumerate() {
            notes.add_many(&format!("vertices without TEXCOORD_{k} given zeros"), lacking.n_without, "");
        }
        if raw.source_points.iter().enumerate().all(|(i, &s)| i as u32 == s) {
            raw.source_points.clear();
        }
        let materials = self.materials(looks, notes);
        self.judge_tangents(&materials, notes);
        (self.raw, materials)
    }

    /// The materials in use, in the file's order, bound to the parts.
    fn materials(&mut self, looks: &mut Looks<'a>, notes: &mut Notes) -> Vec<Material> {
        let mut used: Vec<usize> = self.looks.iter().filter_map(|l| l.0).collect();
        used.sort_unstable();
        used.dedup();
        let mut materials = Vec::new();
        for &i in &used {
            let mut material = match looks.material(i, notes) {
                Ok(material) => material,
                Err(fault) => {
                    notes.add("materials replaced by glTF's default", fault);
                    super::looks::gltf_default()
                }
            };
            let n_uv_sets = self.raw.uv_sets.len() as u32;
            for slot in material.texture_slots_mut() {
                if slot.is_some_and(|t| t.uv_set >= n_uv_sets) {
                    *slot = None;
                    notes.add("textures left out whose coordinates the file lacks", format!("materials[{i}]"));
                }
            }
            materials.push(material);
        }
        for (part, (material, _)) in self.raw.parts.iter_mut().zip(&self.looks) {
            part.material = material.and_then(|m| used.binary_search(&m).ok()).map(|k| k as u32);
        }
        materials
    }

    /// Tangents stay only if all surfaces that need them have them; else all are to be derived alike.
    fn judge_tangents(&mut self, materials: &[Material], notes: &mut Notes) {
        let bumpy = |m: &Material| m.normal_texture.is_some() || m.clearcoat.normal_texture.is_some();
        let needs = |part: &Part| part.material.is_some_and(|m| bumpy(&materials[m as usize]));
        let any = self.looks.iter().any(|l| l.1);
        let lacking = self.raw.parts.iter().zip(&self.looks).filter(|(part, look)| needs(part) && !look.1).count();
        if !any || lacking > 0 {
            self.raw.tangents.clear();
        }
        if any {
            notes.add_many("parts with a normal map but no tangents; the tangents of all are dropped", lacking, "");
        }
    }
}

/// How a message starts that ends the reading.
const TOO_LARGE: &str = "the scene becomes too large";

fn has_targets(primitives: &[Json]) -> usize {
    primitives.iter().filter(|p| p.n_items("targets") > 0).count()
}

/// The part's name: the primitive's, if it says one, else its mesh's, else its node's.
fn name(instance: &Instance, mesh: &Json, primitive: &Json, number: Option<usize>) -> String {
    if let Some(name) = primitive.member("extras").and_then(|e| e.value.get("name")?.as_str()) {
        return name.into();
    }
    let base = mesh.name().or(instance.node.name()).map_or_else(|| format!("mesh{}", instance.mesh), Into::into);
    number.map_or(base.clone(), |i| format!("{base}.{i}"))
}

/// Names and accessors of a primitive's attributes, in the order of their names.
fn attributes(primitive: &Json) -> Result<Vec<(String, usize)>, Fault> {
    let json = primitive.object("attributes")?.ok_or_else(|| primitive.fault("it has no attributes"))?;
    let names = json.value.as_object().into_iter().flat_map(|o| o.keys());
    let mut attributes = Vec::new();
    for name in names {
        attributes.push((name.clone(), json.need(name)?.as_index()?));
    }
    attributes.sort();
    Ok(attributes)
}

/// When integers are fractions of their range.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    /// When the accessor says so.
    AsFlagged,
    /// Always: glTF has no other integers here.
    Fraction,
    /// Never.
    Whole,
}

/// Reads the attributes of one primitive.
struct Attributes<'r, 'a> {
    buffers: &'r Buffers<'a>,
    primitive: &'r Json<'a>,
    attributes: &'r [(String, usize)],
    n_vertices: usize,
    notes: &'r mut Notes,
}

impl Attributes<'_, '_> {
    fn accessor(&self, name: &str) -> Result<Option<Accessor<'_>>, Fault> {
        let found = self.attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, i)| self.checked(*i)).transpose()
    }

    fn checked(&self, i: usize) -> Result<Accessor<'_>, Fault> {
        let accessor = self.buffers.accessor(i)?;
        if accessor.count != self.n_vertices {
            let n = self.n_vertices;
            return Err(accessor.json.fault(format_args!("{} elements for {n} vertices", accessor.count)));
        }
        Ok(accessor)
    }

    fn numbers(&self, accessor: &Accessor, meaning: Meaning) -> Result<Vec<f64>, Fault> {
        let fraction = match meaning {
            Meaning::AsFlagged => accessor.normalized,
            Meaning::Fraction => true,
            Meaning::Whole => false,
        };
        self.buffers.numbers(accessor, fraction)
    }

    fn vectors<const N: usize>(&self, name: &str, meaning: Meaning) -> Result<Option<Vec<[f64; N]>>, Fault> {
        let Some(accessor) = self.accessor(name)? else { return Ok(None) };
        if accessor.n_components() != N {
            return Err(accessor.json.fault(format_args!("{name} must have {N} components")));
        }
        Ok(Some(self.numbers(&accessor, meaning)?.as_chunks().0.to_vec()))
    }

    /// Vectors that one can do without; those in integers are made unit (they are directions).
    fn optional<const N: usize>(&mut self, name: &str, meaning: Meaning) -> Option<Vec<[f64; N]>> {
        let whole = self.accessor(name).ok().flatten().is_some_and(|a| a.component != Kind::F32);
        let vectors = self.vectors::<N>(name, meaning);
        let vectors = self.found(vectors)?;
        let unit = |v: [f64; N]| {
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            std::array::from_fn(|i| if i < 3 && length > 0.0 { v[i] / length } else { v[i] })
        };
        Some(if whole { vectors.into_iter().map(unit).collect() } else { vectors })
    }

    fn found<T>(&mut self, value: Result<Option<T>, Fault>) -> Option<T> {
        value.unwrap_or_else(|fault| {
            self.notes.add("vertex attributes left out", fault);
            None
        })
    }

    fn colors(&mut self) -> Option<Vec<Vec4>> {
        let colors = (|| {
            let Some(accessor) = self.accessor("COLOR_0")? else { return Ok(None) };
            let numbers = self.numbers(&accessor, Meaning::Fraction)?;
            let c = |v: &[f64], i: usize| v[i] as f32;
            match accessor.n_components() {
                3 => Ok(Some(numbers.chunks_exact(3).map(|v| vec4(c(v, 0), c(v, 1), c(v, 2), 1.0)).collect())),
                4 => Ok(Some(numbers.chunks_exact(4).map(|v| vec4(c(v, 0), c(v, 1), c(v, 2), c(v, 3))).collect())),
                n => Err(accessor.json.fault(format_args!("colours of {n} components"))),
            }
        })();
        self.found(colors)
    }

    fn uv_sets(&mut self) -> Vec<Option<Vec<Vec2>>> {
        let mut sets = Vec::new();
        for (name, _) in self.attributes {
            let Some(k) = name.strip_prefix("TEXCOORD_").and_then(|k| k.parse::<usize>().ok()) else { continue };
            if k >= MAX_UV_SETS {
                self.notes.add("vertex attributes left out", self.primitive.fault(name));
                continue;
            }
            let uv = self.vectors::<2>(name, Meaning::AsFlagged);
            let Some(uv) = self.found(uv) else { continue };
            sets.resize(sets.len().max(k + 1), None);
            sets[k] = Some(uv.into_iter().map(|[u, v]| vec2(u as f32, v as f32)).collect());
        }
        sets
    }

    /// Attributes of the application's own, their names kept as written.
    fn fields(&mut self) -> Vec<Field> {
        let mut fields: Vec<Field> = Vec::new();
        for (name, i) in self.attributes {
            let known = ["POSITION", "NORMAL", "TANGENT", "COLOR_0"].contains(&name.as_str())
                || ["TEXCOORD_", "JOINTS_", "WEIGHTS_"].iter().any(|p| name.starts_with(p));
            if known {
                continue;
            }
            if !name.starts_with('_') {
                self.notes.add("vertex attributes of no known meaning left out", self.primitive.fault(name));
                continue;
            }
            let field = self.checked(*i).and_then(|accessor| self.field(name, &accessor));
            if let Some(field) = self.found(field.map(Some)) {
                fields.push(field);
            }
        }
        fields
    }

    fn field(&self, name: &str, accessor: &Accessor) -> Result<Field, Fault> {
        let mut numbers = self.numbers(accessor, Meaning::AsFlagged)?;
        let extras = accessor.json.value.get("extras");
        let extra = |key: &str| extras.and_then(|e| e.get(key));
        // glTF forbids NaN; our writer says which number stands for missing values.
        if let Some(missing) = extra("missing").and_then(|m| m.as_f64()) {
            numbers.iter_mut().filter(|x| **x as f32 == missing as f32).for_each(|x| *x = f64::NAN);
        }
        let text = |key| extra(key).and_then(|t| t.as_str());
        let values = match accessor.component {
            Kind::U32 => Values::F64(numbers),
            _ => Values::F32(numbers.into_iter().map(|x| x as f32).collect()),
        };
        Ok(Field {
            name: text("field").unwrap_or(name).into(),
            unit: text("unit").unwrap_or_default().into(),
            element: Element::Vertex,
            n_components: accessor.n_components(),
            values,
        })
    }

    /// Adds the morph targets, as much of each as `weights` say.
    fn morph(
        &mut self,
        weights: &[f64],
        positions: &mut [[f64; 3]],
        normals: &mut Option<Vec<[f64; 3]>>,
        tangents: &mut Option<Vec<[f64; 4]>>,
    ) {
        let targets = self.notes.kept_or(self.primitive.items("targets"), "morph targets", Vec::new());
        for (target, &weight) in targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            let mut delta = |name: &str| {
                let read = target.index(name).and_then(|i| {
                    let Some(i) = i else { return Ok(None) };
                    let accessor = self.checked(i)?;
                    let numbers = self.numbers(&accessor, Meaning::AsFlagged)?;
                    let fits = accessor.n_components() == 3;
                    if fits {
                        Ok(Some(numbers))
                    } else {
                        Err(accessor.json.fault("morph targets have three components"))
                    }
                });
                self.found(read)
            };
            let mut add = |name: &str, to: &mut dyn Iterator<Item = &mut [f64]>| {
                let Some(numbers) = delta(name) else { return };
                for (v, d) in to.zip(numbers.chunks_exact(3)) {
                    v.iter_mut().zip(d).for_each(|(x, d)| *x += weight * d);
                }
            };
            add("POSITION", &mut positions.iter_mut().map(|v| &mut v[..]));
            add("NORMAL", &mut normals.iter_mut().flatten().map(|v| &mut v[..]));
            add("TANGENT", &mut tangents.iter_mut().flatten().map(|v| &mut v[..3]));
        }
    }

    /// For each vertex the weighted sum of its joints' matrices; none (and a note) if they cannot be read.
    fn poses(&mut self, skin: &super::nodes::Skin, instance: &Instance) -> Option<Vec<DMat4>> {
        let poses = (|| {
            let n_joints = skin.world_from_joints.len();
            let mut joints = skin.world_from_joints.clone();
            if let Some(i) = skin.bind {
                let accessor = self.buffers.accessor(i)?;
                if accessor.n_components() != 16 || accessor.count < n_joints {
                    return Err(accessor.json.fault("too few inverse bind matrices"));
                }
                let numbers = self.buffers.numbers(&accessor, false)?;
                for (joint, m) in joints.iter_mut().zip(numbers.as_chunks::<16>().0) {
                    *joint *= DMat4::from_cols_array(m);
                }
            }
            let mut sums = vec![[0.0f64; 16]; self.n_vertices];
            let mut totals = vec![0.0; self.n_vertices];
            for set in 0..2 {
                let indices = self.vectors::<4>(&format!("JOINTS_{set}"), Meaning::Whole)?;
                let weights = self.vectors::<4>(&format!("WEIGHTS_{set}"), Meaning::Fraction)?;
                let (Some(indices), Some(weights)) = (indices, weights) else { break };
                for (v, (i, w)) in indices.iter().zip(&weights).enumerate() {
                    for (&i, &w) in i.iter().zip(w).filter(|(_, w)| **w > 0.0) {
                        let joint =
                            joints.get(i as usize).ok_or_else(|| self.primitive.fault(format_args!("no joint {i}")))?;
                        sums[v].iter_mut().zip(joint.to_cols_array()).for_each(|(s, x)| *s += w * x);
                        totals[v] += w;
                    }
                }
            }
            // A vertex without weights stays with its node.
            let pose = |(sum, total): (&[f64; 16], &f64)| match *total > 0.0 {
                true => DMat4::from_cols_array(&sum.map(|x| x / total)),
                false => instance.world_from_mesh,
            };
            Ok(sums.iter().zip(&totals).map(pose).collect())
        })();
        match poses {
            Ok(poses) => {
                self.notes.add("primitives with a skin shown in the pose of its joints", self.primitive.place.clone());
                Some(poses)
            }
            Err(fault) => {
                self.notes.add("skins left out", fault);
                None
            }
        }
    }
}

/// The inverse transpose but for its length: the cofactors, with the determinant's sign. Good for flat scales, too.
fn normal_matrix(m: DMat4) -> DMat3 {
    let [x, y, z] = [m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate()];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if x.dot(y.cross(z)) < 0.0 { cofactors * -1.0 } else { cofactors }
}

/// Each triangle gets vertices of its own, with its own normal; glTF asks for this where normals are missing.
fn flat(block: Block, triangles: &mut [[u32; 3]]) -> Block {
    let corners: Vec<u32> = triangles.as_flattened().to_vec();
    let mut normals = Vec::with_capacity(corners.len());
    for t in triangles.iter() {
        let [a, b, c] = t.map(|i| block.positions[i as usize]);
        let n = unit_or((b - a).cross(c - a), Vec3::Y);
        normals.extend([n; 3]);
    }
    fn pick<T: Copy>(values: &[T], corners: &[u32]) -> Vec<T> {
        corners.iter().map(|&i| values[i as usize]).collect()
    }
    let block = Block {
        positions: pick(&block.positions, &corners),
        normals: Some(normals),
        tangents: None,
        colors: block.colors.map(|c| pick(&c, &corners)),
        uv: block.uv.into_iter().map(|uv| uv.map(|uv| pick(&uv, &corners))).collect(),
        fields: block
            .fields
            .into_iter()
            .map(|f| Field { values: f.values.gathered(&corners, f.n_components), ..f })
            .collect(),
        source: Some(corners),
    };
    for (i, t) in triangles.iter_mut().enumerate() {
        let first = i as u32 * 3;
        *t = [first, first + 1, first + 2];
    }
    block
}

/// Adds an attribute of `n` vertices after the first `first`, or a filling for each of them.
fn fill<T: Copy>(all: &mut Vec<T>, new: Option<Vec<T>>, [first, n]: [usize; 2], filling: T, lacking: &mut Lacking) {
    all.resize(first, filling);
    match new {
        Some(new) => {
            lacking.n_with += n;
            all.extend(new);
        }
        None => {
            lacking.n_without += n;
            all.resize(first + n, filling);
        }
    }
}

/// Fills a field with missing values up to vertex `n`, then adds what is new.
fn extend(field: &mut Field, n: usize, new: Option<Values>) {
    let n = n * field.n_components;
    match (&mut field.values, new) {
        (Values::F32(all), new) if !matches!(new, Some(Values::F64(_))) => {
            all.resize(n.max(all.len()), f32::NAN);
            if let Some(Values::F32(new)) = new {
                all.extend(new);
            }
        }
        (values, new) => {
            let mut all: Vec<f64> = (0..values.len()).map(|i| values.at(i)).collect();
            all.resize(n.max(all.len()), f64::NAN);
            if let Some(new) = new {
                all.extend((0..new.len()).map(|i| new.at(i)));
            }
            *values = Values::F64(all);
        }
    }
}
