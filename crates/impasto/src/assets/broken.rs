//! For tests: a file with some of its bytes changed or its end cut off must give an error or a valid mesh, never a panic.

use crate::assets::Mesh;
use crate::error::{Report, Result};

/// Runs `read` on `n` broken forms of a file.
pub(super) fn check(bytes: &[u8], n: u32, read: impl Fn(&[u8]) -> Result<Report<Mesh>>) {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    for i in 0..n {
        let mut broken = bytes.to_vec();
        if i % 4 == 3 {
            broken.truncate(random(bytes.len()));
        }
        for _ in 0..1 + random(6) {
            // Digits turn into others more often than into noise, or no text would get past its first number.
            let at = random(broken.len());
            let new = if random(2) == 0 { b"0123456789- \n.<>\"="[random(18)] } else { random(256) as u8 };
            if let Some(b) = broken.get_mut(at) {
                *b = new;
            }
        }
        match read(&broken) {
            Ok(report) => {
                let mesh = report.value;
                let n = mesh.positions().len();
                assert!(mesh.triangles().as_flattened().iter().all(|v| (*v as usize) < n));
                assert!(mesh.fields().iter().all(|f| f.n_elements() == mesh.n_elements(f.element)));
                assert!(mesh.positions().iter().all(|p| p.is_finite()));
            }
            Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
        }
    }
}
