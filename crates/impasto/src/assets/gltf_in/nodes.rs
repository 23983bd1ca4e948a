//! The node tree, flattened: where in the world each mesh, camera and light stands.
//!
//! All in f64 with plain arithmetic, so that far-off scenes keep their detail and every machine gets the same bits.

use super::Notes;
use super::json::{Fault, Json};
use crate::assets::{SceneCamera, SceneLight, SceneLightKind};
use crate::math::{DVec3, Mat4, Projection, Vec3, exact, unit_or};
use glam::{DMat4, DVec4};

/// What stands in the world.
#[derive(Default)]
pub(super) struct World<'a> {
    pub(super) meshes: Vec<Instance<'a>>,
    pub(super) cameras: Vec<SceneCamera>,
    pub(super) lights: Vec<SceneLight>,
}

/// A mesh somewhere in the world.
pub(super) struct Instance<'a> {
    pub(super) mesh: usize,
    /// For messages, and the name of parts whose mesh has none.
    pub(super) node: Json<'a>,
    pub(super) world_from_mesh: DMat4,
    /// For each joint of the skin: from mesh space, by way of the joint, to the world. Without bind matrices yet.
    pub(super) skin: Option<Skin>,
    /// The node's own weights of morph targets.
    pub(super) weights: Option<Vec<f64>>,
}

/// The skeleton that a mesh hangs on, as it stands.
pub(super) struct Skin {
    pub(super) world_from_joints: Vec<DMat4>,
    /// Accessor with the inverse bind matrices; none: identities.
    pub(super) bind: Option<usize>,
}

/// Everything in the file's default scene; without scenes, everything below the nodes without parents.
pub(super) fn flattened<'a>(root: &Json<'a>, notes: &mut Notes) -> World<'a> {
    let mut world = World::default();
    let n_nodes = root.n_items("nodes");
    // A node has at most one parent; one that is met twice (or its own ancestor) counts once.
    let mut world_from_nodes: Vec<Option<DMat4>> = vec![None; n_nodes];
    let mut stack: Vec<(usize, DMat4)> = Vec::new();
    for root_node in roots(root, notes).into_iter().rev() {
        stack.push((root_node, DMat4::IDENTITY));
    }
    let mut order = Vec::new();
    while let Some((i, world_from_parent)) = stack.pop() {
        let node = match root.item("nodes", i) {
            Ok(node) => node,
            Err(fault) => {
                notes.add("nodes left out", fault);
                continue;
            }
        };
        if world_from_nodes[i].is_some() {
            notes.add("nodes met a second time left out", node.place);
            continue;
        }
        let local = notes.kept_or(transform(&node), "nodes", DMat4::IDENTITY);
        let world_from_node = world_from_parent * local;
        world_from_nodes[i] = Some(world_from_node);
        for child in notes.kept_or(indices(&node, "children"), "nodes", Vec::new()).into_iter().rev() {
            stack.push((child, world_from_node));
        }
        order.push((i, node));
    }
    for (i, node) in order {
        let world_from_node = world_from_nodes[i].unwrap_or(DMat4::IDENTITY);
        if !world_from_node.to_cols_array().iter().all(|x| x.abs() < 1e30) {
            notes.add("nodes whose transform is beyond all numbers left out", node.place);
            continue;
        }
        stand(root, node, world_from_node, &world_from_nodes, &mut world, notes);
    }
    // A library of meshes without any node is shown as it is.
    if n_nodes == 0 && root.n_items("scenes") == 0 && root.n_items("meshes") > 0 {
        notes.add("file without nodes; its meshes are shown where they are", "");
        for mesh in 0..root.n_items("meshes") {
            let node = Json { value: root.value, place: format!("meshes[{mesh}]") };
            world.meshes.push(Instance { mesh, node, world_from_mesh: DMat4::IDENTITY, skin: None, weights: None });
        }
    }
    world
}

/// The nodes at which the scene starts.
fn roots(root: &Json, notes: &mut Notes) -> Vec<usize> {
    let scenes = notes.kept_or(root.items("scenes"), "scenes", Vec::new());
    let wanted = notes.kept(root.index("scene"), "scenes").unwrap_or(0);
    if let Some(scene) = scenes.get(wanted).or(scenes.first()) {
        notes.add_many("further scenes left out", scenes.len() - 1, "");
        return notes.kept_or(indices(scene, "nodes"), "scenes", Vec::new());
    }
    let n_nodes = root.n_items("nodes");
    let mut has_parent = vec![false; n_nodes];
    for node in (0..n_nodes).filter_map(|i| root.item("nodes", i).ok()) {
        for child in indices(&node, "children").unwrap_or_default() {
            has_parent.get_mut(child).into_iter().for_each(|p| *p = true);
        }
    }
    if n_nodes > 0 {
        notes.add("file without a scene; all its nodes are shown", "");
    }
    (0..n_nodes).filter(|&i| !has_parent[i]).collect()
}

/// What a node holds, put into the world.
fn stand<'a>(
    root: &Json<'a>,
    node: Json<'a>,
    world_from_node: DMat4,
    world_from_nodes: &[Option<DMat4>],
    world: &mut World<'a>,
    notes: &mut Notes,
) {
    if let Some(i) = notes.kept(node.index("camera"), "nodes") {
        match root.item("cameras", i).and_then(|camera| projection(&camera).map(|p| (camera, p))) {
            Ok((camera, projection)) => world.cameras.push(SceneCamera {
                name: node.name().or(camera.name()).map_or_else(|| format!("camera{i}"), Into::into),
                world_from_camera: rigid(world_from_node),
                projection,
            }),
            Err(fault) => notes.add("cameras left out", fault),
        }
    }
    let light = notes.kept(node.extension("KHR_lights_punctual"), "nodes");
    if let Some(i) = light.and_then(|l| notes.kept(l.index("light"), "nodes")) {
        match light_at(root, i, &node, world_from_node) {
            Ok(light) => world.lights.push(light),
            Err(fault) => notes.add("lights left out", fault),
        }
    }
    if let Some(mesh) = notes.kept(node.index("mesh"), "nodes") {
        let skin = notes.kept(node.index("skin"), "nodes");
        let skin = skin.and_then(|i| match skin_at(root, i, world_from_nodes) {
            Ok(skin) => Some(skin),
            Err(fault) => {
                notes.add("skins left out", fault);
                None
            }
        });
        let weights = notes.kept(weights(&node), "nodes");
        world.meshes.push(Instance { mesh, node, world_from_mesh: world_from_node, skin, weights });
    }
}

fn skin_at(root: &Json, i: usize, world_from_nodes: &[Option<DMat4>]) -> Result<Skin, Fault> {
    let skin = root.item("skins", i)?;
    let joints = indices(&skin, "joints")?;
    let joint =
        |j: usize| world_from_nodes.get(j).copied().flatten().ok_or_else(|| skin.fault("a joint outside of the scene"));
    Ok(Skin {
        world_from_joints: joints.into_iter().map(joint).collect::<Result<_, _>>()?,
        bind: skin.index("inverseBindMatrices")?,
    })
}

/// Weights of morph targets, of a node or a mesh.
pub(super) fn weights(json: &Json) -> Result<Option<Vec<f64>>, Fault> {
    let Some(_) = json.member("weights") else { return Ok(None) };
    json.items("weights")?.iter().map(Json::as_number).collect::<Result<_, _>>().map(Some)
}

fn indices(json: &Json, key: &str) -> Result<Vec<usize>, Fault> {
    json.items(key)?.iter().map(Json::as_index).collect()
}

/// `parent_from_node`: a matrix, or scale, then rotation, then translation.
fn transform(node: &Json) -> Result<DMat4, Fault> {
    if node.member("matrix").is_some() {
        return Ok(DMat4::from_cols_array(&node.numbers("matrix", [0.0; 16])?));
    }
    let [tx, ty, tz] = node.numbers("translation", [0.0; 3])?;
    let [sx, sy, sz] = node.numbers("scale", [1.0; 3])?;
    let [x, y, z, w] = node.numbers("rotation", [0.0, 0.0, 0.0, 1.0])?;
    // Written out, so that unit axes stay exact: normalising (0, 0, 0, 1) must change nothing.
    let n = x * x + y * y + z * z + w * w;
    let s = if n > 0.0 { 2.0 / n } else { 0.0 };
    Ok(DMat4::from_cols(
        DVec4::new(1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w), 0.0) * sx,
        DVec4::new(s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w), 0.0) * sy,
        DVec4::new(s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y), 0.0) * sz,
        DVec4::new(tx, ty, tz, 1.0),
    ))
}

/// A camera's scale does not count, says glTF: unit axes at right angles, the line of sight kept.
fn rigid(m: DMat4) -> Mat4 {
    let unit = |v: DVec3, fallback: DVec3| {
        let length = (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
        if length > 0.0 && length.is_finite() { v / length } else { fallback }
    };
    let z = unit(m.z_axis.truncate(), DVec3::Z);
    let up = m.y_axis.truncate();
    let side = if z.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let x = unit(up.cross(z), unit(side.cross(z), DVec3::X));
    let y = z.cross(x);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), m.w_axis).as_mat4()
}

fn projection(camera: &Json) -> Result<Projection, Fault> {
    let positive = |json: &Json, key| {
        let x = json.need(key)?.as_number()? as f32;
        if x > 0.0 { Ok(x) } else { Err(json.fault(format_args!("{key} is not positive"))) }
    };
    if camera.text("type")? == Some("orthographic") {
        let orthographic = camera.need("orthographic")?;
        return Ok(Projection::Orthographic { height: 2.0 * positive(&orthographic, "ymag")? });
    }
    let perspective = camera.need("perspective")?;
    let fov_y = positive(&perspective, "yfov")?;
    if fov_y < 3.1 { Ok(Projection::Perspective { fov_y }) } else { Err(perspective.fault("yfov is not below pi")) }
}

/// A light of KHR_lights_punctual; it shines along its node's -Z.
fn light_at(root: &Json, i: usize, node: &Json, world_from_node: DMat4) -> Result<SceneLight, Fault> {
    let all = root.extension("KHR_lights_punctual")?.ok_or("there is no extensions.KHR_lights_punctual")?;
    let light =
        all.items("lights")?.into_iter().nth(i).ok_or_else(|| all.fault(format_args!("there is no light {i}")))?;
    let color = light.numbers("color", [1.0; 3])?;
    let intensity = light.number("intensity", 1.0)?;
    let position = world_from_node.w_axis.truncate().as_vec3();
    let towards = unit_or(world_from_node.z_axis.truncate().as_vec3(), Vec3::Z);
    let kind = match light.text("type")? {
        Some("directional") => SceneLightKind::Directional(towards),
        Some("point") => SceneLightKind::Point(position),
        Some("spot") => {
            let spot = light.object("spot")?;
            let angle = |key, default| spot.as_ref().map_or(Ok(default), |s| s.number(key, default));
            let outer = angle("outerConeAngle", std::f64::consts::FRAC_PI_4)?;
            let inner = angle("innerConeAngle", 0.0)?.min(outer);
            let cone = [exact::cos(inner) as f32, exact::cos(outer) as f32];
            SceneLightKind::Spot { position, axis: -towards, cone }
        }
        _ => return Err(light.fault("a light of no known type")),
    };
    let name = node.name().or(light.name()).map_or_else(|| format!("light{i}"), Into::into);
    Ok(SceneLight { name, color: color.map(|c| (c * intensity).max(0.0) as f32), kind })
}
