//! A small machine that runs functions of naga's intermediate representation, as far as shaders of grain use it.
//!
//! All values are words of 32 bits: scalars one, vectors, matrices and structures one after the other. Each expression of
//! a function has its place in the function's frame; a pointer is an index into the stack of frames. Floats are f32 at
//! every step; integers wrap.

use naga::valid::ModuleInfo;
use naga::{
    BinaryOperator as Op, Block, Expression, Function, Handle, Literal, MathFunction as Math, Module, ScalarKind,
    Statement, TypeInner, UnaryOperator,
};

/// A module with the layout of its functions' frames.
pub(crate) struct Machine<'m> {
    module: &'m Module,
    frames: Vec<Frame>,
    stack: Vec<u32>,
}

/// How a function's words lie.
struct Frame {
    /// Place and form of each expression.
    slots: Vec<Slot>,
    /// For each expression that takes a part of another, how many words stand before it.
    steps: Vec<usize>,
    /// Expressions that are arguments, with their numbers.
    arguments: Vec<(Slot, usize)>,
    /// Expressions that point to local variables, with those variables' places.
    pointers: Vec<(Slot, usize)>,
    /// The words at entry: constants, initial values, zeros.
    entry: Vec<u32>,
}

/// Where an expression's value lies in the frame, and what it is.
#[derive(Clone, Copy)]
struct Slot {
    at: usize,
    n: usize,
    kind: ScalarKind,
    /// Rows of a matrix; 0 for all else.
    rows: usize,
    is_pointer: bool,
}

/// How a block ends.
enum Flow {
    Next,
    Break,
    Continue,
    /// With the value's index on the stack.
    Return(Option<usize>),
}

impl<'m> Machine<'m> {
    pub(crate) fn new(module: &'m Module, info: &ModuleInfo) -> Self {
        let frames = module.functions.iter().map(|(h, f)| frame(module, f, &info[h])).collect();
        Self { module, frames, stack: Vec::new() }
    }

    /// Calls the function of this name with the words of its arguments, and gives those of its value.
    pub(crate) fn call(&mut self, name: &str, arguments: &[u32]) -> Vec<u32> {
        let (function, f) = self.module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(name)).unwrap();
        let n = f.result.as_ref().map_or(0, |r| n_words(self.module, &self.module.types[r.ty].inner));
        self.stack.clear();
        self.stack.extend(arguments);
        self.stack.resize(arguments.len() + n, 0);
        let mut from = 0;
        let places = f.arguments.iter().map(|a| {
            let at = from;
            from += n_words(self.module, &self.module.types[a.ty].inner);
            at
        });
        let places: Vec<usize> = places.collect();
        self.run(function, &places, arguments.len());
        self.stack[arguments.len()..].to_vec()
    }

    /// Runs a function with arguments at places of the stack, and puts its value at another.
    fn run(&mut self, function: Handle<Function>, arguments: &[usize], result: usize) {
        let module = self.module;
        let f = &module.functions[function];
        let base = self.stack.len();
        let frame = &self.frames[function.index()];
        self.stack.extend_from_slice(&frame.entry);
        for (slot, k) in &frame.arguments {
            self.stack.copy_within(arguments[*k]..arguments[*k] + slot.n, base + slot.at);
        }
        for (slot, place) in &frame.pointers {
            self.stack[base + slot.at] = (base + place) as u32;
        }
        let mut running = Running { machine: self, function: f, index: function.index(), base };
        let flow = running.block(&f.body);
        if let (Flow::Return(Some(from)), Some(r)) = (flow, &f.result) {
            let n = n_words(module, &module.types[r.ty].inner);
            self.stack.copy_within(from..from + n, result);
        }
        self.stack.truncate(base);
    }
}

/// How many words a type takes.
fn n_words(module: &Module, inner: &TypeInner) -> usize {
    let of = |ty| n_words(module, &module.types[ty].inner);
    match inner {
        TypeInner::Scalar(_) | TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => 1,
        TypeInner::Vector { size, .. } => *size as usize,
        TypeInner::Matrix { columns, rows, .. } => *columns as usize * *rows as usize,
        TypeInner::Struct { members, .. } => members.iter().map(|m| of(m.ty)).sum(),
        other => panic!("no words for {other:?}"),
    }
}

/// Words before the member or component of a type, where values of it lie.
fn offset(module: &Module, inner: &TypeInner, index: usize) -> usize {
    match inner {
        TypeInner::Struct { members, .. } => {
            members[..index].iter().map(|m| n_words(module, &module.types[m.ty].inner)).sum()
        }
        TypeInner::Matrix { rows, .. } => index * *rows as usize,
        TypeInner::Pointer { base, .. } => offset(module, &module.types[*base].inner, index),
        _ => index,
    }
}

/// How a function's words lie, and what does not change from call to call.
fn frame(module: &Module, f: &Function, info: &naga::valid::FunctionInfo) -> Frame {
    let inner = |h: Handle<Expression>| info[h].ty.inner_with(&module.types);
    let mut n = 0;
    let mut take = |words: usize| {
        n += words;
        n - words
    };
    let mut slots = Vec::new();
    for (h, _) in f.expressions.iter() {
        let words = n_words(module, inner(h));
        let rows = if let TypeInner::Matrix { rows, .. } = inner(h) { *rows as usize } else { 0 };
        let kind = inner(h).scalar_kind().unwrap_or(ScalarKind::Uint);
        let is_pointer = matches!(inner(h), TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. });
        slots.push(Slot { at: take(words), n: words, kind, rows, is_pointer });
    }
    let step = |e: &Expression| match e {
        Expression::AccessIndex { base, index } => offset(module, inner(*base), *index as usize),
        _ => 0,
    };
    let steps = f.expressions.iter().map(|(_, e)| step(e)).collect();
    let locals: Vec<usize> =
        f.local_variables.iter().map(|(_, l)| take(n_words(module, &module.types[l.ty].inner))).collect();
    let mut entry = vec![0; n];
    for (h, e) in f.expressions.iter() {
        if matches!(e, Expression::Literal(_) | Expression::Constant(_)) {
            let words = constant(module, e);
            entry[slots[h.index()].at..][..words.len()].copy_from_slice(&words);
        }
        // Constant expressions stand before all statements: what they are made of lies there already.
        if let Expression::Compose { components, .. } = e {
            let words: Vec<u32> = components.iter().flat_map(|c| entry[range(&slots, *c)].to_vec()).collect();
            entry[slots[h.index()].at..][..words.len()].copy_from_slice(&words);
        }
    }
    for ((_, local), at) in f.local_variables.iter().zip(&locals) {
        if let Some(init) = local.init {
            entry.copy_within(range(&slots, init), *at);
        }
    }
    let (mut arguments, mut pointers) = (Vec::new(), Vec::new());
    for (h, e) in f.expressions.iter() {
        match e {
            Expression::FunctionArgument(k) => arguments.push((slots[h.index()], *k as usize)),
            Expression::LocalVariable(l) => pointers.push((slots[h.index()], locals[l.index()])),
            _ => {}
        }
    }
    Frame { slots, steps, arguments, pointers, entry }
}

fn range(slots: &[Slot], h: Handle<Expression>) -> std::ops::Range<usize> {
    let Slot { at, n, .. } = slots[h.index()];
    at..at + n
}

/// The words of a constant.
fn constant(module: &Module, e: &Expression) -> Vec<u32> {
    let global = |h: Handle<Expression>| constant(module, &module.global_expressions[h]);
    match e {
        Expression::Literal(Literal::F32(x)) => vec![x.to_bits()],
        Expression::Literal(Literal::I32(x)) => vec![*x as u32],
        Expression::Literal(Literal::U32(x)) => vec![*x],
        Expression::Literal(Literal::Bool(x)) => vec![*x as u32],
        Expression::Constant(h) => global(module.constants[*h].init),
        Expression::Compose { components, .. } => components.iter().flat_map(|c| global(*c)).collect(),
        Expression::Splat { size, value } => global(*value).repeat(*size as usize),
        Expression::ZeroValue(ty) => vec![0; n_words(module, &module.types[*ty].inner)],
        other => panic!("no constant: {other:?}"),
    }
}

/// A function at work.
struct Running<'a, 'm> {
    machine: &'a mut Machine<'m>,
    function: &'m Function,
    index: usize,
    base: usize,
}

impl<'m> Running<'_, 'm> {
    fn slot(&self, h: Handle<Expression>) -> Slot {
        let slot = self.machine.frames[self.index].slots[h.index()];
        Slot { at: slot.at + self.base, ..slot }
    }

    /// The k-th word of a value; a scalar has the same everywhere.
    fn word(&self, slot: Slot, k: usize) -> u32 {
        self.machine.stack[slot.at + if slot.n == 1 { 0 } else { k }]
    }

    fn float(&self, slot: Slot, k: usize) -> f32 {
        f32::from_bits(self.word(slot, k))
    }

    fn is_true(&self, h: Handle<Expression>) -> bool {
        self.word(self.slot(h), 0) != 0
    }

    fn put(&mut self, slot: Slot, k: usize, word: u32) {
        self.machine.stack[slot.at + k] = word;
    }

    fn copy(&mut self, from: usize, n: usize, to: usize) {
        self.machine.stack.copy_within(from..from + n, to);
    }

    fn block(&mut self, block: &'m Block) -> Flow {
        for statement in block.iter() {
            let flow = self.statement(statement);
            if !matches!(flow, Flow::Next) {
                return flow;
            }
        }
        Flow::Next
    }

    fn statement(&mut self, statement: &'m Statement) -> Flow {
        match statement {
            Statement::Emit(range) => range.clone().for_each(|h| self.evaluate(h)),
            Statement::Block(block) => return self.block(block),
            Statement::If { condition, accept, reject } => {
                return self.block(if self.is_true(*condition) { accept } else { reject });
            }
            Statement::Loop { body, continuing, break_if } => loop {
                match self.block(body) {
                    Flow::Break => break,
                    Flow::Return(value) => return Flow::Return(value),
                    Flow::Next | Flow::Continue => {}
                }
                self.block(continuing);
                if break_if.is_some_and(|h| self.is_true(h)) {
                    break;
                }
            },
            Statement::Break => return Flow::Break,
            Statement::Continue => return Flow::Continue,
            Statement::Return { value } => return Flow::Return(value.map(|h| self.slot(h).at)),
            Statement::Store { pointer, value } => {
                let (to, from) = (self.word(self.slot(*pointer), 0), self.slot(*value));
                self.copy(from.at, from.n, to as usize);
            }
            Statement::Call { function, arguments, result } => {
                let places: Vec<usize> = arguments.iter().map(|h| self.slot(*h).at).collect();
                let to = result.map_or(0, |h| self.slot(h).at);
                self.machine.run(*function, &places, to);
            }
            other => panic!("no statement of a grain: {other:?}"),
        }
        Flow::Next
    }

    fn evaluate(&mut self, h: Handle<Expression>) {
        let function = self.function;
        let out = self.slot(h);
        match &function.expressions[h] {
            Expression::Load { pointer } => {
                let from = self.word(self.slot(*pointer), 0);
                self.copy(from as usize, out.n, out.at);
            }
            Expression::AccessIndex { base, .. } => {
                let (from, step) = (self.slot(*base), self.machine.frames[self.index].steps[h.index()]);
                if from.is_pointer {
                    self.put(out, 0, self.word(from, 0) + step as u32);
                } else {
                    self.copy(from.at + step, out.n, out.at);
                }
            }
            Expression::Compose { components, .. } => {
                let mut to = out.at;
                for part in components {
                    let part = self.slot(*part);
                    self.copy(part.at, part.n, to);
                    to += part.n;
                }
            }
            Expression::Splat { value, .. } => {
                let word = self.word(self.slot(*value), 0);
                (0..out.n).for_each(|k| self.put(out, k, word));
            }
            Expression::Swizzle { vector, pattern, .. } => {
                let from = self.slot(*vector);
                (0..out.n).for_each(|k| self.put(out, k, self.word(from, pattern[k] as usize)));
            }
            Expression::Unary { op, expr } => {
                let a = self.slot(*expr);
                (0..out.n).for_each(|k| self.put(out, k, unary(*op, a.kind, self.word(a, k))));
            }
            Expression::Binary { op, left, right } => {
                let (a, b) = (self.slot(*left), self.slot(*right));
                self.binary(*op, a, b, out);
            }
            Expression::Select { condition, accept, reject } => {
                let (c, a, b) = (self.slot(*condition), self.slot(*accept), self.slot(*reject));
                (0..out.n).for_each(|k| self.put(out, k, self.word(if self.word(c, k) != 0 { a } else { b }, k)));
            }
            Expression::As { expr, kind, convert } => {
                let a = self.slot(*expr);
                let kinds = (a.kind, if convert.is_some() { *kind } else { a.kind });
                (0..out.n).for_each(|k| self.put(out, k, converted(kinds, self.word(a, k))));
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let a = self.slot(*arg);
                let (b, c) = (arg1.map_or(a, |h| self.slot(h)), arg2.map_or(a, |h| self.slot(h)));
                self.math(*fun, [a, b, c], out);
            }
            Expression::ZeroValue(_) | Expression::Literal(_) | Expression::Constant(_) => {}
            other => panic!("no expression of a grain: {other:?}"),
        }
    }

    fn binary(&mut self, op: Op, a: Slot, b: Slot, out: Slot) {
        if op == Op::Multiply && a.rows > 0 && b.n > 1 {
            for r in 0..out.n {
                let sum = (0..b.n).fold(0.0, |sum, c| sum + self.float(a, c * a.rows + r) * self.float(b, c));
                self.put(out, r, sum.to_bits());
            }
        } else if op == Op::Multiply && b.rows > 0 && a.n > 1 {
            for c in 0..out.n {
                let sum = (0..a.n).fold(0.0, |sum, r| sum + self.float(a, r) * self.float(b, c * b.rows + r));
                self.put(out, c, sum.to_bits());
            }
        } else {
            (0..out.n).for_each(|k| self.put(out, k, binary(op, a.kind, self.word(a, k), self.word(b, k))));
        }
    }

    fn math(&mut self, fun: Math, [a, b, c]: [Slot; 3], out: Slot) {
        let dot = |s: &Self| (0..a.n).fold(0.0, |sum, k| sum + s.float(a, k) * s.float(b, k));
        match fun {
            Math::Dot => self.put(out, 0, dot(self).to_bits()),
            Math::Length => {
                let squared = (0..a.n).fold(0.0, |sum, k| sum + self.float(a, k) * self.float(a, k));
                self.put(out, 0, squared.sqrt().to_bits());
            }
            Math::Cross => {
                for k in 0..3 {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    let x = self.float(a, i) * self.float(b, j) - self.float(a, j) * self.float(b, i);
                    self.put(out, k, x.to_bits());
                }
            }
            _ => (0..out.n).for_each(|k| {
                let word = math(fun, a.kind, [a, b, c].map(|slot| self.word(slot, k)));
                self.put(out, k, word);
            }),
        }
    }
}

fn unary(op: UnaryOperator, kind: ScalarKind, x: u32) -> u32 {
    match (op, kind) {
        (UnaryOperator::Negate, ScalarKind::Float) => (-f32::from_bits(x)).to_bits(),
        (UnaryOperator::Negate, _) => x.wrapping_neg(),
        (UnaryOperator::LogicalNot, _) => (x == 0) as u32,
        (UnaryOperator::BitwiseNot, _) => !x,
    }
}

fn binary(op: Op, kind: ScalarKind, a: u32, b: u32) -> u32 {
    match kind {
        ScalarKind::Float => float_binary(op, f32::from_bits(a), f32::from_bits(b)),
        ScalarKind::Sint => signed_binary(op, a as i32, b),
        _ => unsigned_binary(op, a, b),
    }
}

fn float_binary(op: Op, a: f32, b: f32) -> u32 {
    match op {
        Op::Add => (a + b).to_bits(),
        Op::Subtract => (a - b).to_bits(),
        Op::Multiply => (a * b).to_bits(),
        Op::Divide => (a / b).to_bits(),
        Op::Equal => (a == b) as u32,
        Op::NotEqual => (a != b) as u32,
        Op::Less => (a < b) as u32,
        Op::LessEqual => (a <= b) as u32,
        Op::Greater => (a > b) as u32,
        Op::GreaterEqual => (a >= b) as u32,
        other => panic!("{other:?} of floats"),
    }
}

fn signed_binary(op: Op, a: i32, bits: u32) -> u32 {
    let b = bits as i32;
    match op {
        Op::Divide => a.wrapping_div(b) as u32,
        Op::Modulo => a.wrapping_rem(b) as u32,
        Op::ShiftRight => (a >> bits) as u32,
        Op::Less => (a < b) as u32,
        Op::LessEqual => (a <= b) as u32,
        Op::Greater => (a > b) as u32,
        Op::GreaterEqual => (a >= b) as u32,
        _ => unsigned_binary(op, a as u32, bits),
    }
}

fn unsigned_binary(op: Op, a: u32, b: u32) -> u32 {
    match op {
        Op::Add => a.wrapping_add(b),
        Op::Subtract => a.wrapping_sub(b),
        Op::Multiply => a.wrapping_mul(b),
        Op::Divide => a / b,
        Op::Modulo => a % b,
        Op::And | Op::LogicalAnd => a & b,
        Op::InclusiveOr | Op::LogicalOr => a | b,
        Op::ExclusiveOr => a ^ b,
        Op::ShiftLeft => a << b,
        Op::ShiftRight => a >> b,
        Op::Equal => (a == b) as u32,
        Op::NotEqual => (a != b) as u32,
        Op::Less => (a < b) as u32,
        Op::LessEqual => (a <= b) as u32,
        Op::Greater => (a > b) as u32,
        Op::GreaterEqual => (a >= b) as u32,
    }
}

/// From one kind of scalar to another.
fn converted((from, to): (ScalarKind, ScalarKind), x: u32) -> u32 {
    let float = f32::from_bits(x);
    match (from, to) {
        (ScalarKind::Float, ScalarKind::Sint) => float as i32 as u32,
        (ScalarKind::Float, ScalarKind::Uint) => float as u32,
        (ScalarKind::Sint, ScalarKind::Float) => (x as i32 as f32).to_bits(),
        (ScalarKind::Uint | ScalarKind::Bool, ScalarKind::Float) => (x as f32).to_bits(),
        _ => x,
    }
}

/// Functions component by component; those without an exact result go through f64.
fn math(fun: Math, kind: ScalarKind, words: [u32; 3]) -> u32 {
    let [x, y, z] = words.map(f32::from_bits);
    let float = |x: f32| x.to_bits();
    let [i, j, _] = words.map(|w| w as i32);
    match (fun, kind) {
        (Math::Max, ScalarKind::Sint) => i.max(j) as u32,
        (Math::Min, ScalarKind::Sint) => i.min(j) as u32,
        (Math::Max, ScalarKind::Uint) => words[0].max(words[1]),
        (Math::Min, ScalarKind::Uint) => words[0].min(words[1]),
        (Math::Abs, ScalarKind::Sint) => i.wrapping_abs() as u32,
        (Math::Abs, _) => float(x.abs()),
        (Math::Min, _) => float(if y < x { y } else { x }),
        (Math::Max, _) => float(if x < y { y } else { x }),
        (Math::Clamp, _) => float(if x < y {
            y
        } else if x > z {
            z
        } else {
            x
        }),
        (Math::Mix, _) => float(x * (1.0 - z) + y * z),
        (Math::Floor, _) => float(x.floor()),
        (Math::Ceil, _) => float(x.ceil()),
        (Math::Sqrt, _) => float(x.sqrt()),
        (Math::Pow, _) => float((x as f64).powf(y as f64) as f32),
        (Math::Atan2, _) => float((x as f64).atan2(y as f64) as f32),
        (Math::Acos, _) => float((x as f64).acos() as f32),
        other => panic!("no function of a grain: {other:?}"),
    }
}
