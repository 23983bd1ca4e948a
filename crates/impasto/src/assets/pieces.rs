//! Which triangles hang together, and which of them are wound the other way round? Disjoint sets with a parity.

/// Sets of triangles. Each triangle knows whether it is turned against its set's first triangle.
pub(super) struct Pieces {
    /// Parent's index times two, plus one if turned against it.
    parents: Vec<u32>,
}

/// What joining two triangles found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Joined {
    /// Nothing that speaks against it.
    Agree,
    /// They are in one set already, and turned otherwise: the piece has only one side.
    Contradict,
}

impl Pieces {
    /// `n` triangles, each its own piece.
    pub(super) fn new(n: usize) -> Self {
        Self { parents: (0..n as u32).map(|i| i << 1).collect() }
    }

    /// The first triangle of `t`'s piece, and 1 if `t` is turned against it.
    #[inline]
    fn find(&mut self, t: u32) -> (u32, u32) {
        let (mut t, mut turned) = (t, 0);
        loop {
            let up = self.parents[t as usize];
            if up >> 1 == t {
                return (t, turned);
            }
            // Path halving: hang it on its grandparent on the way.
            let upper = self.parents[(up >> 1) as usize];
            let halved = upper ^ (up & 1);
            self.parents[t as usize] = halved;
            turned ^= halved & 1;
            t = halved >> 1;
        }
    }

    /// Puts two triangles into one piece; `turned`: they are wound against each other.
    #[inline]
    pub(super) fn join(&mut self, a: usize, b: usize, turned: bool) -> Joined {
        let ((a, turned_a), (b, turned_b)) = (self.find(a as u32), self.find(b as u32));
        let parity = turned_a ^ turned_b ^ turned as u32;
        match a.cmp(&b) {
            std::cmp::Ordering::Equal if parity != 0 => Joined::Contradict,
            std::cmp::Ordering::Equal => Joined::Agree,
            std::cmp::Ordering::Less => {
                self.parents[b as usize] = a << 1 | parity;
                Joined::Agree
            }
            std::cmp::Ordering::Greater => {
                self.parents[a as usize] = b << 1 | parity;
                Joined::Agree
            }
        }
    }

    /// Numbers the pieces in the order of their first triangles.
    pub(super) fn numbered(mut self) -> Numbered {
        for t in 0..self.parents.len() as u32 {
            let (root, turned) = self.find(t);
            self.parents[t as usize] = root << 1 | turned;
        }
        let mut n = 0;
        for t in 0..self.parents.len() {
            let (root, turned) = ((self.parents[t] >> 1) as usize, self.parents[t] & 1);
            // A piece's first triangle has the least index, so its number is known when the others ask.
            self.parents[t] = if root == t {
                n += 1;
                (n - 1) << 1
            } else {
                self.parents[root] & !1 | turned
            };
        }
        Numbered { of: self.parents, n: n as usize }
    }
}

/// For each triangle: which piece, and whether it is turned.
pub(super) struct Numbered {
    of: Vec<u32>,
    /// How many pieces there are.
    pub(super) n: usize,
}

impl Numbered {
    /// The piece of a triangle, and whether it is wound against the piece's first.
    #[inline]
    pub(super) fn at(&self, triangle: usize) -> (usize, bool) {
        ((self.of[triangle] >> 1) as usize, self.of[triangle] & 1 == 1)
    }
}
