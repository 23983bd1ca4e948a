//! The file system's side of the readers and writers: which reader, what lies beside a file, and no half-written output.

use crate::assets::mend::MendOptions;
use crate::assets::{
    Element, Material, Mesh, Molecule, Neighbours, RawMesh, Scene, TextureImage, TextureRef, UvTransform, gifti, glb,
    gltf_in, height_map, image_files, molecular_surface, obj, obj_write, off, packed, pdb, ply, ply_write, pqr, stl,
    three_json, volume, volume_scene, vtk, vtk_xml, vtp_write,
};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{Bounds, Vec3, vec3};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

/// Which axis of a file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// As is the custom of the format: Z for STL and GIfTI, Y for OBJ, PLY, OFF and VTK; glTF and height maps say it
    /// themselves.
    #[default]
    Auto,
    /// +Y, as here.
    Y,
    /// +Z: turned about X, so that the file's -Y becomes our +Z.
    Z,
}

/// How a file is loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Which axis of the file points up.
    pub up: Up,
    /// Height maps: how cells and numbers become lengths.
    pub height_map: height_map::Options,
    /// Grids: the value whose isosurface is shown; none: one that suits the values ([`isolevel`](super::isolevel)).
    pub isolevel: Option<f64>,
}

/// What `load` can read, for messages.
pub const SCENE_FORMATS: &str = "obj, ply, stl, off, gltf, glb, vtk, vtp, vtu, vts, vtr, vti, gii, json (three.js), asc, dem, \
                                 npy, npz, png, tif, cube, dx, mrc, map, ccp4, nrrd, pdb, pqr, each also as .gz";

/// What `save_mesh` can write, for messages.
pub const MESH_FORMATS: &str = "obj, ply, stl, glb, vtp";

/// Reads a mesh, a scene, a height map, a grid or a molecule, whichever the file is; its name's extension decides, then
/// its first bytes. Files that are packed (`.gz`) are unpacked.
///
/// An image file is read as a height map. Grids become an isosurface, molecules their smooth surface. What the file refers
/// to is sought beside it.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Report<Scene>> {
    let (bytes, name) = read_unpacked(path)?;
    let format = Format::of(path, &name, &bytes)?;
    let neighbours = |name: &str| neighbour(path, name);
    let mut report = match format {
        Format::Gltf => gltf_in::read(&bytes, path, &neighbours)?,
        Format::HeightMap(kind) => height_map::read_as(kind, &bytes, path, &options.height_map)?,
        Format::Volume(kind) => {
            let Report { value, mut mended } = volume::read_as(kind, &bytes, path)?;
            drop(bytes);
            let mut report = volume_scene::to_scene(value, kind, name_of(path), options.isolevel)?;
            mended.append(&mut report.mended);
            Report { mended, ..report }
        }
        Format::Pdb => molecule_scene(pdb::read(&bytes, path)?, path)?,
        Format::Pqr => molecule_scene(pqr::read(&bytes, path)?, path)?,
        _ => {
            let loose = match format {
                Format::Obj => obj::read_loose(&bytes, path, &neighbours)?,
                Format::Ply => ply::read_loose(&bytes, path, &neighbours)?,
                Format::Stl => stl::read_loose(&bytes, path)?,
                Format::Vtk => vtk::read_loose(&bytes, path)?,
                Format::VtkXml => vtk_xml::read_loose(&bytes, path)?,
                Format::Gifti => gifti::read_loose(&bytes, path)?,
                Format::ThreeJson => three_json::read_loose(&bytes, path)?,
                _ => off::read_loose(&bytes, path)?,
            };
            // The file's bytes are given back before mending takes memory for its work.
            drop(bytes);
            loose.mend()
        }
    };
    let is_z = match (options.up, format) {
        (Up::Auto, Format::Stl) => {
            report.value.up_note = "STL does not say what is up: +Z, as is the custom of CAD".into();
            true
        }
        (Up::Auto, Format::Gifti) => {
            report.value.up_note = "+Z is up, as GIfTI has it: x right, y forward, z up".into();
            true
        }
        (Up::Auto | Up::Y, _) => false,
        (Up::Z, _) => {
            report.value.up_note = "+Z is up, as asked".into();
            true
        }
    };
    if is_z {
        report.value.turn_z_up();
    }
    Ok(report)
}

/// A molecule's surface.
fn molecule_scene(report: Report<Molecule>, path: &Path) -> Result<Report<Scene>> {
    let Report { value, mut mended } = report;
    let mut report = molecular_surface::scene(&value, name_of(path), &Default::default());
    if report.value.mesh.triangles().is_empty() {
        return Err(Error::Format { path: path.into(), fault: "its atoms lie too far apart for a surface".into() });
    }
    mended.append(&mut report.mended);
    Ok(Report { mended, ..report })
}

/// Reads the values on 3-D grids that a file holds, and what atoms come with them.
pub fn load_volume(path: &Path) -> Result<Report<volume::Volume>> {
    let (bytes, name) = read_unpacked(path)?;
    match Format::of(path, &name, &bytes) {
        Ok(Format::Volume(kind)) => volume::read_as(kind, &bytes, path),
        _ => {
            let kind = kind_of(&extension(&name));
            Err(Error::UnknownFormat { path: path.into(), kind, verb: "reads as a grid", known: VOLUME_FORMATS })
        }
    }
}

/// What `load_volume` can read, for messages.
pub const VOLUME_FORMATS: &str = "cube, dx, mrc, map, ccp4, nrrd; also packed as .gz";

/// Reads an image of any kind that is known.
pub fn load_image(path: &Path) -> Result<Report<TextureImage>> {
    image_files::read(&read_file(path)?, path)
}

/// Writes a mesh with what the format holds; the file name's extension decides. Tells which fields are lost.
///
/// OBJ comes with a material library and PNG textures beside it, GLB holds them. PLY keeps every field, VTP those of vertices
/// and faces, GLB those of vertices; PLY and VTP keep no materials, STL keeps triangles alone.
pub fn save_mesh(path: &Path, scene: &Scene) -> Result<Vec<Mended>> {
    use Element::{Corner, Face, Vertex};
    let (extension, mut lost) = (extension(path), Vec::new());
    let no_place: &[Element] = match extension.as_str() {
        "obj" | "stl" => &[Vertex, Face, Corner],
        "glb" => &[Face, Corner],
        "vtp" => &[Corner],
        _ => &[],
    };
    vtp_write::note_lost(&scene.mesh, no_place, &mut lost);
    let bytes = match extension.as_str() {
        "obj" => {
            obj_write::save(path, scene)?;
            return Ok(lost);
        }
        "ply" => ply_write::write(&scene.mesh),
        "stl" => stl::write(&scene.mesh),
        "glb" => glb::write(scene)?,
        "vtp" => vtp_write::write(&scene.mesh).value,
        other => {
            let kind = kind_of(other);
            return Err(Error::UnknownFormat { path: path.into(), kind, verb: "writes", known: MESH_FORMATS });
        }
    };
    write_atomically(path, |w| w.write_all(&bytes))?;
    Ok(lost)
}

/// Writes a file beside its place and moves it there when it is whole. Nothing is left behind on failure.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let error = |source| Error::Write { path: path.into(), source };
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    // A device or a pipe is written to, not replaced.
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let mut file = io::BufWriter::new(std::fs::File::create(path).map_err(error)?);
        return write(&mut file).and_then(|()| file.flush()).map_err(error);
    }
    if path.is_dir() {
        return Err(error(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder")));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".impasto-").suffix(".part");
    #[cfg(unix)]
    {
        // As any new file: the system takes away what the user's mask forbids.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(error)?;
    let mut buffered = io::BufWriter::with_capacity(1 << 16, file.as_file_mut());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(error)?;
    drop(buffered);
    file.persist(path).map_err(|e| error(e.error))?;
    Ok(())
}

/// What stands beside `path` under `name`, as another file writes it.
///
/// Slashes lean either way, `./` is dropped, percent signs are decoded if the name does not exist as written. `..` may lead
/// out of the folder, as exporters write it. Absolute names belong to another machine: only their last part is sought,
/// beside the file.
pub fn neighbour(path: &Path, name: &str) -> io::Result<Vec<u8>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut names = vec![name.to_string()];
    if name.contains('%') {
        names.push(percent_decoded(name));
    }
    let mut first_error = None;
    for name in names {
        let name = name.replace('\\', "/");
        let relative = Path::new(name.trim_start_matches("./"));
        let is_drive = name.as_bytes().get(1) == Some(&b':');
        let is_relative = !is_drive
            && relative
                .components()
                .all(|c| matches!(c, Component::Normal(_) | Component::ParentDir | Component::CurDir));
        let sought: PathBuf =
            if is_relative { relative.into() } else { name.rsplit('/').next().unwrap_or_default().into() };
        if sought.as_os_str().is_empty() {
            continue;
        }
        match read_regular(&folder.join(sought)) {
            Ok(bytes) => return Ok(bytes),
            Err(e) => first_error = first_error.or(Some(e)),
        }
    }
    Err(first_error.unwrap_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name")))
}

/// Text with `%20` for a blank and the like, as it is meant.
pub(super) fn percent_decoded(name: &str) -> String {
    let hex = |b: Option<&u8>| b.and_then(|b| (*b as char).to_digit(16));
    let bytes = name.as_bytes();
    let (mut out, mut i) = (Vec::with_capacity(bytes.len()), 0);
    while i < bytes.len() {
        match (bytes[i], hex(bytes.get(i + 1)), hex(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            (b, ..) => {
                out.push(b);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// Folders, pipes and devices are no files to read whole.
fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a folder or a device, not a file"));
    }
    std::fs::read(path)
}

fn read_file(path: &Path) -> Result<Vec<u8>> {
    let bytes = read_regular(path).map_err(|source| Error::Read { path: path.into(), source })?;
    if bytes.is_empty() {
        return Err(Error::Format { path: path.into(), fault: "the file is empty".into() });
    }
    Ok(bytes)
}

/// A file's bytes, unpacked if it is a gzip archive, and its name without `.gz`, by which it is known.
pub(super) fn read_unpacked(path: &Path) -> Result<(Vec<u8>, PathBuf)> {
    let bytes = read_file(path)?;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok((bytes, path.into()));
    }
    let unpacked = packed::gunzip(&bytes, packed::MAX_UNPACKED);
    let unpacked = unpacked.map_err(|fault| Error::Format { path: path.into(), fault })?;
    let name = if extension(path) == "gz" { path.with_extension("") } else { path.into() };
    Ok((unpacked, name))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Stl,
    Off,
    Gltf,
    Vtk,
    VtkXml,
    Gifti,
    ThreeJson,
    HeightMap(height_map::Kind),
    Volume(volume::Kind),
    Pdb,
    Pqr,
}

impl Format {
    /// By the extension of `name`, then by the first bytes; `path` is for messages.
    fn of(path: &Path, name: &Path, bytes: &[u8]) -> Result<Self> {
        use height_map::Kind;
        let by_name = match extension(name).as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "off" | "coff" | "noff" | "stoff" => Some(Self::Off),
            "gltf" | "glb" => Some(Self::Gltf),
            "vtk" => Some(Self::Vtk),
            "vtp" | "vtu" | "vts" | "vtr" | "vti" => Some(Self::VtkXml),
            "gii" => Some(Self::Gifti),
            "json" => Some(Self::ThreeJson),
            "asc" => Some(Self::HeightMap(Kind::Asc)),
            "dem" => Some(Self::HeightMap(Kind::Dem)),
            "npy" => Some(Self::HeightMap(Kind::Npy)),
            "npz" => Some(Self::HeightMap(Kind::Npz)),
            "png" | "tif" | "tiff" => Some(Self::HeightMap(Kind::Image)),
            "cube" | "cub" => Some(Self::Volume(volume::Kind::Cube)),
            "dx" => Some(Self::Volume(volume::Kind::Dx)),
            "mrc" | "map" | "ccp4" => Some(Self::Volume(volume::Kind::Mrc)),
            "nrrd" => Some(Self::Volume(volume::Kind::Nrrd)),
            "pdb" | "ent" => Some(Self::Pdb),
            "pqr" => Some(Self::Pqr),
            _ => None,
        };
        if let Some(format) = by_name {
            return Ok(format);
        }
        let starts = |magic: &[u8]| bytes.starts_with(magic);
        let head = &bytes[..bytes.len().min(1024)];
        let holds = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
        let first_word = bytes.split(|b| *b <= b' ').next().unwrap_or_default();
        Ok(match () {
            _ if starts(b"ply\n") || starts(b"ply\r") => Self::Ply,
            _ if starts(b"glTF") => Self::Gltf,
            _ if starts(b"\x93NUMPY") => Self::HeightMap(Kind::Npy),
            _ if starts(b"\x89PNG") || starts(b"II*\0") || starts(b"MM\0*") => Self::HeightMap(Kind::Image),
            _ if starts(b"ncols") || starts(b"NCOLS") => Self::HeightMap(Kind::Asc),
            _ if starts(b"solid ") => Self::Stl,
            _ if starts(b"# vtk DataFile") => Self::Vtk,
            _ if holds(b"<VTKFile") => Self::VtkXml,
            _ if holds(b"<GIFTI") => Self::Gifti,
            _ if starts(b"{") && holds(b"BufferGeometry") => Self::ThreeJson,
            _ if starts(b"NRRD0") => Self::Volume(volume::Kind::Nrrd),
            _ if bytes.get(208..212) == Some(b"MAP ") => Self::Volume(volume::Kind::Mrc),
            _ if starts(b"HEADER    ") => Self::Pdb,
            _ if first_word.ends_with(b"OFF") => Self::Off,
            _ => {
                let kind = match () {
                    _ if starts(b"PK\x03\x04") => "a zip archive".into(),
                    _ => kind_of(&extension(name)),
                };
                return Err(Error::UnknownFormat { path: path.into(), kind, verb: "reads", known: SCENE_FORMATS });
            }
        })
    }
}

pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

pub(super) fn kind_of(extension: &str) -> String {
    if extension.is_empty() { "a name without extension".into() } else { format!(".{extension}") }
}

/// A file's name without its folder, for messages and export.
pub(super) fn name_of(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// What a reader found, before mending.
pub(super) struct Loose {
    pub(super) name: String,
    pub(super) mesh: RawMesh,
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<TextureImage>,
    pub(super) mended: Vec<Mended>,
    pub(super) options: MendOptions,
}

impl Loose {
    /// A mesh alone.
    pub(super) fn new(name: String, mesh: RawMesh, mended: Vec<Mended>, options: MendOptions) -> Self {
        Self { name, mesh, materials: Vec::new(), images: Vec::new(), mended, options }
    }

    /// The scene, with all reports in the order of their making.
    pub(super) fn mend(self) -> Report<Scene> {
        let report = self.mesh.mend_with(self.options);
        let mut mended = self.mended;
        mended.extend(report.mended);
        let scene = Scene { materials: self.materials, images: self.images, ..Scene::of(self.name, report.value) };
        Report { value: scene, mended }
    }
}

/// A material with the first texture of `names` that can be read, and its image.
pub(super) fn texture_named_in_comment(
    names: &[String],
    neighbours: &Neighbours,
    mended: &mut Vec<Mended>,
) -> (Vec<Material>, Vec<TextureImage>) {
    for name in names {
        let image = neighbours(name)
            .map_err(|e| e.to_string())
            .and_then(|bytes| image_files::read(&bytes, Path::new(name)).map_err(|e| e.to_string()));
        match image {
            Ok(image) => {
                mended.extend(image.mended);
                let texture =
                    TextureRef { image: 0, uv_set: 0, sampler: Default::default(), transform: UvTransform::IDENTITY };
                let material =
                    Material { base_color: [1.0; 4], base_color_texture: Some(texture), ..Default::default() };
                return (vec![material], vec![image.value]);
            }
            Err(why) => note(mended, 1, format!("texture {name:?} not read: {why}")),
        }
    }
    (Vec::new(), Vec::new())
}

impl Scene {
    /// Turns the mesh from +Z up to +Y up. Fields keep their numbers.
    fn turn_z_up(&mut self) {
        let turned = |v: Vec3| vec3(v.x, v.z, -v.y);
        let Mesh { raw, bounds } = &mut self.mesh;
        raw.positions.iter_mut().chain(&mut raw.normals).for_each(|v| *v = turned(*v));
        raw.tangents.iter_mut().for_each(|t| *t = turned(t.truncate()).extend(t.w));
        *bounds = Some(Bounds::of(raw.positions.iter().copied()));
    }
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
