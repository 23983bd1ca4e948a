//! Rooms with walls, and what is in each of them: the wedges of a citrus fruit, the chambers of a pomegranate, the bundles
//! of a muscle.
//!
//! A room is a wedge about an axis or a cell; walls and the rind outside are one, rounded where they meet. What is in a room
//! stays in it: particles whose centre is in another, or too near to the wall, are left out.

use super::Cells;
use super::check::within;
use super::eval::{Candidate, Hit, HitKind};
use super::filling::Filling;
use super::question::{Question, Turn};
use super::spec::parameter;
use crate::Result;
use crate::math::{DMat3, DVec3, Vec3, atan2, exact, hash, unit_float};

/// How rooms are laid out.
#[derive(Clone, Debug)]
pub enum Rooms {
    /// Wedges about an axis.
    Wedges(Wedges),
    /// One in each cell; the cells' walls are the rooms'.
    Cells(Box<Cells>),
}

/// Wedges about an axis. In each of them what fills it has its own space: x points away from the axis along the wedge's
/// middle, z along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Wedges {
    /// How many.
    pub n: u32,
    /// A point of the axis, model space.
    pub center: Vec3,
    /// Its direction, model space.
    pub axis: Vec3,
    /// How much the wedges' angles differ: 0 to 0.7.
    pub spread: f32,
    /// Width of the membranes between them, model units.
    pub wall: f32,
    /// Radius of the core about the axis, model units.
    pub core: f32,
    /// Another seed, other angles.
    pub seed: u32,
}

/// Rooms as a person describes them.
#[derive(Clone, Debug)]
pub struct ChambersSpec {
    /// How they are laid out.
    pub rooms: Rooms,
    /// Depth below the skin where they begin, model units.
    pub rind: f32,
    /// Radius of their rounded corners, model units.
    pub rounding: f32,
    /// Particles whose centre is nearer to a wall than this are left out; model units.
    pub clear: f32,
    /// What is in them.
    pub inner: Filling,
}

/// Checked rooms, ready to be asked.
#[derive(Clone, Debug)]
pub struct Chambers {
    spec: ChambersSpec,
    model_from_axis: DMat3,
}

/// Where a point is.
#[derive(Clone, Copy, Debug)]
struct Room {
    /// Of wedges their number, of cells their name.
    id: u32,
    /// How far from the wall, model units, negative in it.
    inset: f32,
}

impl Chambers {
    /// Rooms from their description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: ChambersSpec) -> Result<Self> {
        for (what, x) in [("rind", spec.rind), ("rounding", spec.rounding), ("clearance", spec.clear)] {
            within(what, x, 0.0..=f32::MAX, "it is a length, zero or above")?;
        }
        let mut model_from_axis = DMat3::IDENTITY;
        if let Rooms::Wedges(wedges) = &spec.rooms {
            model_from_axis = wedges.checked()?;
        }
        Ok(Self { spec, model_from_axis })
    }

    /// What is in the rooms.
    pub fn inner(&self) -> &Filling {
        &self.spec.inner
    }

    pub(super) fn answer(&self, p: DVec3, question: &Question) -> Hit {
        let room = self.room(p, question);
        if room.inset <= 0.0 {
            return question.plain(p);
        }
        let keep = |c: &Candidate| {
            let other = self.room(c.center, question);
            other.id == room.id && other.inset >= self.spec.clear && (question.keep)(c)
        };
        let inner = Question { keep: &keep, ..*question };
        let hit = match &self.spec.rooms {
            Rooms::Cells(_) => self.spec.inner.answer(p, &inner),
            Rooms::Wedges(wedges) => {
                let turn = wedges.own_space(room.id, self.model_from_axis);
                turn.ask(p, &inner, |p, q| self.spec.inner.answer(p, q))
            }
        };
        // What is between the particles of a room has the room's name.
        let particle = if hit.kind == HitKind::Matrix { room.id.max(1) } else { hit.particle };
        Hit { leaf: hit.leaf + 1, particle, ..hit }
    }

    fn room(&self, p: DVec3, question: &Question) -> Room {
        let rind = (question.depth)(p) - self.spec.rind;
        let mut corner = Corner::new(self.spec.rounding);
        corner.add(rind);
        let id = match &self.spec.rooms {
            Rooms::Wedges(wedges) => {
                wedges.room(self.model_from_axis.transpose() * (p - wedges.center.as_dvec3()), &mut corner)
            }
            Rooms::Cells(cells) => {
                let (id, wall) = cells.room(p);
                corner.add(wall);
                id
            }
        };
        Room { id, inset: corner.inset() }
    }
}

/// The inside of walls that meet with a rounded corner.
struct Corner {
    rounding: f32,
    least: f32,
    squares: f32,
}

impl Corner {
    fn new(rounding: f32) -> Self {
        Self { rounding, least: f32::INFINITY, squares: 0.0 }
    }

    /// Takes in a wall at a distance.
    fn add(&mut self, distance: f32) {
        self.least = if distance < self.least { distance } else { self.least };
        let near = self.rounding - distance;
        self.squares += if near > 0.0 { near * near } else { 0.0 };
    }

    fn inset(&self) -> f32 {
        if self.squares > 0.0 { self.rounding - self.squares.sqrt() } else { self.least }
    }
}

impl Wedges {
    /// A rotation whose third column is the axis.
    fn checked(&self) -> Result<DMat3> {
        if !(2..=64).contains(&self.n) {
            return Err(parameter("wedges", self.n, "from 2 to 64"));
        }
        within("spread", self.spread, 0.0..=0.7, "from 0 to 0.7")?;
        within("wall", self.wall, 0.0..=f32::MAX, "it is a length, zero or above")?;
        within("core", self.core, 0.0..=f32::MAX, "it is a length, zero or above")?;
        let axis = self.axis.as_dvec3();
        if !(axis.is_finite() && axis.length() > 1e-30 && self.center.is_finite()) {
            let given = format!("{},{},{}", self.axis.x, self.axis.y, self.axis.z);
            return Err(parameter(
                "axis",
                given,
                "it needs three finite numbers that are not all zero, as its point does",
            ));
        }
        let plane = crate::section::Plane { normal: axis.normalize(), offset: 0.0 };
        let [u, v] = plane.axes();
        Ok(DMat3::from_cols(u, v, plane.normal))
    }

    /// Where wedge `k` begins, as a part of the circle times n.
    fn border(&self, k: i32) -> f32 {
        let name = k.rem_euclid(self.n as i32) as u32;
        k as f32 + self.spread * (unit_float(hash(hash(self.seed).wrapping_add(name))) - 0.5)
    }

    /// The wedge a point is in; its walls are added to a corner.
    fn room(&self, q: DVec3, corner: &mut Corner) -> u32 {
        let (x, y) = (q.x as f32, q.y as f32);
        let r = (x * x + y * y).sqrt();
        let n = self.n as f32;
        let turn = atan2(y, x) * (n / std::f32::consts::TAU);
        let mut k = (turn + 0.5).floor() as i32;
        k -= (turn < self.border(k)) as i32;
        let to_wall = |part: f32| {
            let angle = (part / n) as f64 * std::f64::consts::TAU;
            // Beyond a right angle the nearest point of the wall is on the axis.
            let sin = if angle < std::f64::consts::FRAC_PI_2 { exact::sin(angle) as f32 } else { 1.0 };
            r * sin - self.wall * 0.5
        };
        corner.add(to_wall(turn - self.border(k)));
        corner.add(to_wall(self.border(k + 1) - turn));
        corner.add(r - self.core);
        k.rem_euclid(self.n as i32) as u32
    }

    fn own_space(&self, id: u32, model_from_axis: DMat3) -> Turn {
        let middle = 0.5 * (self.border(id as i32) + self.border(id as i32 + 1)) as f64;
        let angle = middle / self.n as f64 * std::f64::consts::TAU;
        let (sin, cos) = (exact::sin(angle), exact::cos(angle));
        let turn = DMat3::from_cols(DVec3::new(cos, -sin, 0.0), DVec3::new(sin, cos, 0.0), DVec3::Z);
        let own_from_model = turn * model_from_axis.transpose();
        // Moved along the axis, so that no two wedges are alike.
        let moved = DVec3::Z * (1 + id) as f64 * 9.7 * self.core.max(self.wall).max(1e-3) as f64;
        Turn { own_from_model, origin: moved - own_from_model * self.center.as_dvec3() }
    }
}
