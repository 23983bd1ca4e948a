//! Placement of whole batches: surface points in, texture coordinates with exact footprints out.
//!
//! Positions and normals change over a cell as the barycentrics do (`Surfels::d_barycentric`); [`Dual`] numbers carry
//! these changes through the coordinate function. So a footprint is right at every single cell, also where the
//! coordinate jumps - at the back of a cylinder, between the sides of a box: the jump has no derivative, and the texels
//! on either side are filtered as if it were not there.

use crate::assets::Mesh;
use crate::math::{BATCH, Lane, Mat3, Mat4, Vec3};
use crate::placement::number::{Dual, Number, Vector, affine, stretched};
use crate::placement::rules::{Local, Point, Rule, Visitor, box_side, resolve, rows};
use crate::placement::{Measures, Needs, Placement, Projector, PropertyAxis, Surfels, TexCoords, Viewpoint};

/// Beyond this many texture widths f32 has no texel left; keeps infinities away from the samplers.
const FARTHEST: f32 = (1 << 30) as f32;

/// Where on the texture the surfels are: `matrix * (s, t, r, 1)` of the placement, divided by its fourth component.
///
/// Reads the lanes that [`Placement::needs`] names. Fills s, t, r and their changes for the valid cells of `out`; the
/// numbers are finite, but for missing values of a property (NaN, with footprint 0). A UV set or field that is not there
/// gives 0 ([`Placement::fits`] tells). Properties that `measures` holds of these surfels are not measured again; it must
/// not hold those of others.
pub fn place(
    placement: &Placement,
    matrix: &Mat4,
    view: &Viewpoint,
    mesh: &Mesh,
    surfels: &Surfels,
    measures: &mut Measures,
    out: &mut TexCoords,
) {
    match placement {
        Placement::Uv(set) => copy_uv(*set, surfels, out),
        Placement::Property { axes } => {
            for (k, axis) in axes.iter().enumerate() {
                read_property(axis.as_ref(), k, mesh, surfels, measures, out);
            }
        }
        Placement::PropertyInLight { axis, toward } => {
            read_property(Some(axis), 0, mesh, surfels, measures, out);
            read_property(None, 2, mesh, surfels, measures, out);
            read_light(*toward, view, surfels, out);
        }
        _ => {
            let visitor = Fill { needs: placement.needs(), mesh, surfels, out };
            resolve(placement, view, mesh, visitor);
        }
    }
    transform(matrix, surfels.n, out);
}

/// The same with coordinates worked out at the three corners and interpolated, as graphics hardware of the nineties did
/// it: for comparison. Coordinates that jump within a triangle smear there; `place` has no such fault.
pub fn place_per_vertex(
    placement: &Placement,
    matrix: &Mat4,
    view: &Viewpoint,
    mesh: &Mesh,
    surfels: &Surfels,
    out: &mut TexCoords,
) {
    let mut corner = Surfels::new(mesh.uv_sets().len());
    let mut coords: [TexCoords; 3] = [TexCoords::ZERO; 3];
    for c in 0..3 {
        stand_on_corner(c, mesh, surfels, &mut corner);
        place(placement, matrix, view, mesh, &corner, &mut Measures::default(), &mut coords[c]);
    }
    for i in 0..surfels.n {
        let blended = |k: usize| {
            let [a, b, c] = [0, 1, 2].map(|corner: usize| match k {
                2 => coords[corner].r[0][i],
                _ => coords[corner].st[k][i],
            });
            let change = |w: &[Lane; 2]| w[0][i] * (b - a) + w[1][i] * (c - a);
            let [dx, dy] = [0, 1].map(|axis: usize| change(&surfels.d_barycentric[axis]));
            Dual { value: a + change(&surfels.barycentric), dx, dy }
        };
        store(out, i, [blended(0), blended(1), blended(2)]);
    }
}

/// Three planar projections along the projector's axes, and how much each counts: the sides of a box mixed softly.
/// `out[k]` looks along axis k; `weights` sum to 1 and grow with the `sharpness`-th power of the normal's part along it
/// (Geiss, "Generating Complex Procedural Terrains Using the GPU", GPU Gems 3, 2007).
pub fn triplanar(
    projector: &Projector,
    sharpness: u32,
    mesh: &Mesh,
    surfels: &Surfels,
    out: &mut [TexCoords; 3],
    weights: &mut [Lane; 3],
) {
    let local = Local::of(projector);
    for axis in 0..3 {
        let rule = OneSide { local, axis };
        let needs = Needs { position: true, normal: true, ..Needs::default() };
        Fill { needs, mesh, surfels, out: &mut out[axis as usize] }.visit(&rule);
    }
    for i in 0..surfels.n {
        let normal = local.direction([0, 1, 2].map(|k: usize| Dual::constant(surfels.normal[k][i])));
        let parts = normal.map(|n| (0..sharpness).fold(1.0, |product, _| product * n.value.abs()));
        let sum = parts[0] + parts[1] + parts[2];
        for k in 0..3 {
            // A power so high that it underflows everywhere leaves the shares equal.
            weights[k][i] = if sum > 0.0 { parts[k] / sum } else { 1.0 / 3.0 };
        }
    }
}

/// The pictures of one axis of a box, front or back by the normal.
struct OneSide {
    local: Local,
    axis: u32,
}

impl Rule for OneSide {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let n = self.local.direction(point.normal)[self.axis as usize];
        let p = stretched(self.local.place(point.position), self.local.per_size);
        box_side(p, self.axis, !n.is_below(N::constant(0.0)))
    }
}

/// Runs a rule over the batch.
struct Fill<'a> {
    needs: Needs,
    mesh: &'a Mesh,
    surfels: &'a Surfels,
    out: &'a mut TexCoords,
}

impl Visitor for Fill<'_> {
    type Output = ();

    fn visit(self, rule: &impl Rule) {
        let mut motion = Motion::STILL;
        motion.gather(self.needs, self.mesh, self.surfels);
        let n = self.surfels.n.min(BATCH);
        for i in 0..n {
            let point = Point {
                position: motion.position_at(self.surfels, i),
                normal: motion.normal_at(self.surfels, i),
                side: self.surfels.side[i],
            };
            store(self.out, i, rule.at(&point));
        }
    }
}

/// How positions and normals change from cell to cell: `[x|y][component]`.
pub(super) struct Motion {
    position: [[Lane; 3]; 2],
    normal: [[Lane; 3]; 2],
}

impl Motion {
    pub(super) const STILL: Self = Self { position: [[[0.0; BATCH]; 3]; 2], normal: [[[0.0; BATCH]; 3]; 2] };

    /// From the corners of each cell's triangle. A pass of its own: it reads here and there, the rule then does not.
    pub(super) fn gather(&mut self, needs: Needs, mesh: &Mesh, surfels: &Surfels) {
        for i in 0..surfels.n.min(BATCH) {
            let corners = mesh.triangles()[surfels.triangle[i] as usize].map(|v| v as usize);
            if needs.position {
                let [a, b, c] = corners.map(|v| mesh.positions()[v].to_array());
                for axis in 0..2 {
                    let [second, third] = surfels.d_barycentric[axis].each_ref().map(|lane| lane[i]);
                    for k in 0..3 {
                        self.position[axis][k][i] = second * (b[k] - a[k]) + third * (c[k] - a[k]);
                    }
                }
            }
            if needs.normal {
                let [a, b, c] = corners.map(|v| mesh.normals()[v].to_array());
                let [second, third] = surfels.barycentric.each_ref().map(|lane| lane[i]);
                let blend: [f32; 3] = [0, 1, 2].map(|k| a[k] + second * (b[k] - a[k]) + third * (c[k] - a[k]));
                let squared = blend[0] * blend[0] + blend[1] * blend[1] + blend[2] * blend[2];
                let per_length = if squared > f32::MIN_POSITIVE { 1.0 / squared.sqrt() } else { 0.0 };
                let unit = surfels.normal.each_ref().map(|lane| lane[i]);
                for axis in 0..2 {
                    let [second, third] = surfels.d_barycentric[axis].each_ref().map(|lane| lane[i]);
                    let d: [f32; 3] = [0, 1, 2].map(|k| second * (b[k] - a[k]) + third * (c[k] - a[k]));
                    // What runs along the normal is lost when it is made unit.
                    let lost = d[0] * unit[0] + d[1] * unit[1] + d[2] * unit[2];
                    for k in 0..3 {
                        self.normal[axis][k][i] = (d[k] - lost * unit[k]) * per_length;
                    }
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn position_at(&self, surfels: &Surfels, i: usize) -> Vector<Dual> {
        [0, 1, 2].map(|k: usize| Dual {
            value: surfels.position[k][i],
            dx: self.position[0][k][i],
            dy: self.position[1][k][i],
        })
    }

    #[inline(always)]
    pub(super) fn normal_at(&self, surfels: &Surfels, i: usize) -> Vector<Dual> {
        [0, 1, 2].map(|k: usize| Dual {
            value: surfels.normal[k][i],
            dx: self.normal[0][k][i],
            dy: self.normal[1][k][i],
        })
    }
}

/// `x` within +-[`FARTHEST`]; NaN becomes 0.
#[inline(always)]
fn tame(x: f32) -> f32 {
    let x = if x > -FARTHEST { x } else { -FARTHEST * ((x <= -FARTHEST) as u32 as f32) };
    if x < FARTHEST { x } else { FARTHEST }
}

#[inline(always)]
fn store(out: &mut TexCoords, i: usize, st: Vector<Dual>) {
    for k in 0..2 {
        out.st[k][i] = tame(st[k].value);
        out.d_dx[k][i] = tame(st[k].dx);
        out.d_dy[k][i] = tame(st[k].dy);
    }
    out.r[0][i] = tame(st[2].value);
    out.r[1][i] = tame(st[2].dx);
    out.r[2][i] = tame(st[2].dy);
}

#[inline(always)]
fn load(coords: &TexCoords, i: usize) -> Vector<Dual> {
    let [s, t] = [0, 1].map(|k: usize| Dual { value: coords.st[k][i], dx: coords.d_dx[k][i], dy: coords.d_dy[k][i] });
    [s, t, Dual { value: coords.r[0][i], dx: coords.r[1][i], dy: coords.r[2][i] }]
}

fn copy_uv(set: usize, surfels: &Surfels, out: &mut TexCoords) {
    let n = surfels.n.min(BATCH);
    out.r.iter_mut().for_each(|lane| lane[..n].fill(0.0));
    for k in 0..2 {
        match surfels.uv.get(set) {
            Some(uv) => {
                out.st[k][..n].copy_from_slice(&uv.st[k][..n]);
                out.d_dx[k][..n].copy_from_slice(&uv.d_dx[k][..n]);
                out.d_dy[k][..n].copy_from_slice(&uv.d_dy[k][..n]);
            }
            None => [&mut out.st, &mut out.d_dx, &mut out.d_dy].into_iter().for_each(|lanes| lanes[k][..n].fill(0.0)),
        }
    }
}

/// The texture matrix, in place.
fn transform(matrix: &Mat4, n: usize, out: &mut TexCoords) {
    if *matrix == Mat4::IDENTITY {
        return;
    }
    let rows = rows(matrix);
    let [a, b, c, d] = rows[3];
    let projective = rows[3] != [0.0, 0.0, 0.0, 1.0];
    for i in 0..n.min(BATCH) {
        let v = load(out, i);
        let mut moved = [0, 1, 2].map(|k: usize| affine([rows[k][0], rows[k][1], rows[k][2]], rows[k][3], v));
        if projective {
            let q = affine([a, b, c], d, v);
            moved = moved.map(|x| x / q);
        }
        // A missing value stays missing, whatever the matrix.
        let missing = v[0].value.is_nan() || v[1].value.is_nan() || v[2].value.is_nan();
        if missing { store_missing(out, i, moved) } else { store(out, i, moved) }
    }
}

/// Keeps NaN, without a footprint.
fn store_missing(out: &mut TexCoords, i: usize, st: Vector<Dual>) {
    store(out, i, st);
    for (k, x) in st.iter().enumerate().filter(|(_, x)| x.value.is_nan()) {
        let lane = if k < 2 { &mut out.st[k] } else { &mut out.r[0] };
        lane[i] = x.value;
    }
}

/// A property as coordinate `k`, 0 for s to 2 for r; without one, the middle. In f64 until scale and offset have brought it
/// near [0, 1].
fn read_property(
    axis: Option<&PropertyAxis>,
    k: usize,
    mesh: &Mesh,
    surfels: &Surfels,
    measures: &mut Measures,
    out: &mut TexCoords,
) {
    let n = surfels.n.min(BATCH);
    let [r, r_dx, r_dy] = &mut out.r;
    let (value, dx, dy) = match k {
        2 => (r, r_dx, r_dy),
        _ => (&mut out.st[k], &mut out.d_dx[k], &mut out.d_dy[k]),
    };
    let Some(PropertyAxis { property, scale, offset }) = axis else {
        value[..n].fill(0.5);
        dx[..n].fill(0.0);
        dy[..n].fill(0.0);
        return;
    };
    let measure = measures.of(property, mesh, surfels);
    for i in 0..n {
        let x = (measure.value[i] * scale + offset) as f32;
        value[i] = if x.is_nan() { x } else { tame(x) };
        dx[i] = tame((measure.d[0][i] * scale) as f32);
        dy[i] = tame((measure.d[1][i] * scale) as f32);
    }
}

/// How a matt surface would look in parallel light: 1/2 where it faces the eye, 0 turned away from the light, 1 turned to it.
fn read_light(toward: Vec3, view: &Viewpoint, surfels: &Surfels, out: &mut TexCoords) {
    let world_from_eye = Mat3::from_mat4(view.eye_from_world).transpose();
    let toward = world_from_eye * toward;
    for i in 0..surfels.n {
        let at = |lanes: &[Lane; 3]| [lanes[0][i], lanes[1][i], lanes[2][i]];
        let (normal, eye, side) = (at(&surfels.normal), at(&surfels.view), surfels.side[i]);
        let facing = (normal[0] * toward.x + normal[1] * toward.y + normal[2] * toward.z) * side;
        let straight = eye[0] * toward.x + eye[1] * toward.y + eye[2] * toward.z;
        let light = if facing > straight {
            0.5 + 0.5 * (facing - straight) / (1.0 - straight)
        } else {
            0.5 * (facing + 1.0) / (straight + 1.0)
        };
        let light = if light > 0.0 { light } else { 0.0 };
        out.st[1][i] = if light < 1.0 { light } else { 1.0 };
        (out.d_dx[1][i], out.d_dy[1][i]) = (0.0, 0.0);
    }
}

/// The batch moved to corner `c` of each cell's triangle.
fn stand_on_corner(c: usize, mesh: &Mesh, surfels: &Surfels, corner: &mut Surfels) {
    corner.n = surfels.n;
    corner.side = surfels.side;
    corner.triangle = surfels.triangle;
    corner.barycentric = [[if c == 1 { 1.0 } else { 0.0 }; BATCH], [if c == 2 { 1.0 } else { 0.0 }; BATCH]];
    for i in 0..surfels.n {
        let v = mesh.triangles()[surfels.triangle[i] as usize][c] as usize;
        let (p, n) = (mesh.positions()[v].to_array(), mesh.normals()[v].to_array());
        for k in 0..3 {
            corner.position[k][i] = p[k];
            corner.normal[k][i] = n[k];
        }
        for (set, uv) in mesh.uv_sets().iter().enumerate() {
            corner.uv[set].st[0][i] = uv.uv[v].x;
            corner.uv[set].st[1][i] = uv.uv[v].y;
        }
    }
}
