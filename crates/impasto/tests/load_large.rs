//! A scan of a million triangles loads in the memory of its arrays and its file, and in the time of a glance.

use impasto::assets::files::{LoadOptions, load};
use std::io::Write;
use std::path::Path;

/// Cells of a hilly grid along a side; two triangles each.
const SIDE: u32 = 708;

/// Writes the file without holding it: memory is measured in this process.
fn write_scan(path: &Path, with_normals: bool) {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let (n, n_faces) = ((SIDE + 1) * (SIDE + 1), SIDE * SIDE * 2);
    let normals = if with_normals { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" };
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float z\n\
         {normals}element face {n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .unwrap();
    for i in 0..n {
        let (x, z) = ((i % (SIDE + 1)) as f32 * 0.01, (i / (SIDE + 1)) as f32 * 0.01);
        let p = [x, (x * 3.0).sin() * (z * 2.0).cos() * 0.3, z];
        let slope = [0.9 * (x * 3.0).cos() * (z * 2.0).cos(), -0.6 * (x * 3.0).sin() * (z * 2.0).sin()];
        let length = (slope[0] * slope[0] + slope[1] * slope[1] + 1.0).sqrt();
        let normal = [-slope[0] / length, 1.0 / length, -slope[1] / length];
        let numbers = p.iter().chain(normal.iter().filter(|_| with_normals));
        numbers.for_each(|x| out.write_all(&x.to_le_bytes()).unwrap());
    }
    for y in 0..SIDE {
        for x in 0..SIDE {
            let a = y * (SIDE + 1) + x;
            let (b, c, d) = (a + SIDE + 1, a + SIDE + 2, a + 1);
            for t in [[a, b, c], [a, c, d]] {
                out.write_all(&[3]).unwrap();
                t.iter().for_each(|v| out.write_all(&v.to_le_bytes()).unwrap());
            }
        }
    }
    out.flush().unwrap();
}

/// A line of the process' status in bytes, where there is one.
fn status(key: &str) -> Option<usize> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|l| l.starts_with(key))?;
    Some(line.split_whitespace().nth(1)?.parse::<usize>().ok()? * 1024)
}

/// Nanoseconds this thread has been on a core.
fn time_on_core() -> Option<u64> {
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split_whitespace().next()?.parse().ok()
}

/// In the environment of the process that measures: which of the two scans.
const WHICH: &str = "IMPASTO_TEST_SCAN";

/// Loads one scan in a process of its own, whose memory nothing else has used.
fn measure(with_normals: bool) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.ply");
    write_scan(&path, with_normals);
    let n_file = std::fs::metadata(&path).unwrap().len() as usize;
    let before = status("VmRSS");
    let start = time_on_core();
    let report = load(&path, &LoadOptions::default()).unwrap();
    let milliseconds = start.zip(time_on_core()).map(|(a, b)| (b - a) as f64 / 1e6);
    let peak = status("VmHWM");
    let mesh = &report.value.mesh;
    assert_eq!(mesh.triangles().len(), 2 * (SIDE * SIDE) as usize);
    assert!(report.mended.is_empty(), "{:?}", report.mended);
    let n_final = mesh.positions().len() * 24 + mesh.triangles().len() * 12;
    let (Some(before), Some(peak)) = (before, peak) else { return println!("skipped: no /proc") };
    let taken = peak - before;
    let mib = |n: usize| n as f64 / 1048576.0;
    println!(
        "normals {with_normals}: file {:.1} MiB, arrays {:.1} MiB, peak {:.1} MiB, {:.0} ms on a core",
        mib(n_file),
        mib(n_final),
        mib(taken),
        milliseconds.unwrap_or(f64::NAN)
    );
    // Two MiB for stacks, buffers and the allocator's rounding.
    assert!(taken <= n_file + n_final + n_final / 5 + (2 << 20), "{} MiB", mib(taken));
}

#[test]
fn a_million_triangles_take_the_memory_of_their_arrays_and_their_file() {
    if let Ok(which) = std::env::var(WHICH) {
        return measure(which == "true");
    }
    for which in ["true", "false"] {
        let mut child = std::process::Command::new(std::env::current_exe().unwrap());
        let output = child.arg("--nocapture").env(WHICH, which).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        println!("{}", text.lines().filter(|l| l.contains("normals")).collect::<String>());
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    }
}
