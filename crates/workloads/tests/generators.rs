//! Generators: the same bits for the same seed, and what each promises.

use trisect_core::{Hit, Ray, Triangle, Vec3};
use trisect_workloads::{
    Light, Mesh, Workload, diffuse_bounce, hit_rate, occlusion, primary, random,
    random_through_box, working_set,
};

/// The hit by Möller and Trumbore's formula in f64: these cases are far from any edge.
fn hit(ray: &Ray<f32>, triangle: &Triangle<f32>) -> Option<Hit<f64>> {
    let (ray, Triangle { a, b, c }) = (Ray::<f64>::from(*ray), Triangle::<f64>::from(*triangle));
    let (e1, e2, s) = (b - a, c - a, ray.o - a);
    let (p, q) = (ray.d.cross(e2), s.cross(e1));
    let det = e1.dot(p);
    let (t, beta, gamma) = (e2.dot(q) / det, s.dot(p) / det, ray.d.dot(q) / det);
    let inside = beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0;
    (inside && t >= ray.tmin && t <= ray.tmax).then_some(Hit { t, beta, gamma })
}

#[allow(clippy::cast_possible_truncation, reason = "the nearest f32 is good enough to start from")]
fn closest(mesh: &Mesh, ray: &Ray<f32>) -> Option<(usize, Hit<f32>)> {
    let (index, hit) = mesh
        .triangles
        .iter()
        .enumerate()
        .filter_map(|(index, triangle)| Some((index, hit(ray, triangle)?)))
        .min_by(|(_, one), (_, other)| one.t.total_cmp(&other.t))?;
    Some((index, Hit { t: hit.t as f32, beta: hit.beta as f32, gamma: hit.gamma as f32 }))
}

/// FNV-1a over the bits of all rays and triangles.
fn hash(workload: &Workload) -> u64 {
    let rays = workload.rays.iter().flat_map(|ray| {
        let ([a, b, c], [d, e, f]) = (ray.o.to_array(), ray.d.to_array());
        [a, b, c, d, e, f, ray.tmin, ray.tmax]
    });
    let corners = workload.triangles.iter().flat_map(|t| t.corners()).flat_map(Vec3::to_array);
    rays.chain(corners).flat_map(f32::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

fn box_mesh() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../mesh/tests/data/box.little.ply");
    Mesh::load(path).expect("sound")
}

fn all(seed: u64) -> Vec<Workload> {
    let mesh = box_mesh();
    let light = Light::above(&mesh.bounds);
    vec![
        random(seed, 100, 200),
        working_set(seed, 10, 1_000),
        hit_rate(seed, 0, 10, 100),
        hit_rate(seed, 50, 10, 100),
        random_through_box(seed, &mesh, 100),
        diffuse_bounce(seed, &mesh, 32, 24, &mut |ray| closest(&mesh, ray)),
        occlusion(seed, &mesh, &light, 32, 24, &mut |ray| closest(&mesh, ray)),
    ]
}

#[test]
fn a_seed_gives_the_same_bits_everywhere() {
    let golden: [(&str, u64); 7] = [
        ("random", 0x6c5c_5fce_b64f_c0c4),
        ("working-set/1000", 0xdd4e_1a9e_867a_5a13),
        ("hit-rate/0", 0xb2b4_82f7_c030_d871),
        ("hit-rate/50", 0x3970_ba9f_5293_92b1),
        ("box.little/random", 0xf563_bcc4_450f_bdb2),
        ("box.little/diffuse", 0x1973_6c3e_091e_5b64),
        ("box.little/occlusion", 0x8339_3af6_fc22_bac2),
    ];
    let hashes: Vec<_> = all(42).iter().map(|w| (w.name.clone(), hash(w))).collect();
    let golden = golden.map(|(name, hash)| (name.to_owned(), hash));
    assert_eq!(hashes, golden, "{hashes:#x?}");
    let camera = hash(&primary(&box_mesh(), 16, 9));
    assert_eq!(camera, 0x57b9_7253_e365_d125, "{camera:#x}");
}

#[test]
fn seeds_differ() {
    for (one, other) in all(1).iter().zip(all(2)) {
        assert_ne!(hash(one), hash(&other), "{}", one.name);
    }
}

#[test]
fn a_larger_set_begins_with_the_smaller() {
    let (small, large) = (working_set(7, 5, 100), working_set(7, 5, 300));
    assert_eq!(small.rays, large.rays);
    assert_eq!(small.triangles[..], large.triangles[..100]);
}

#[test]
fn random_is_in_the_ball_and_hits_its_share() {
    let workload = random(42, 1_000, 1_000);
    for ray in &workload.rays {
        assert!(ray.o.dot(ray.o) <= 1.0);
        assert!((ray.o + ray.d).dot(ray.o + ray.d) <= 1.000_001);
    }
    let pairs =
        workload.rays.iter().flat_map(|ray| workload.triangles.iter().map(move |t| (ray, t)));
    let share = pairs.filter(|(ray, t)| hit(ray, t).is_some()).count() as f64 / 1e6;
    assert!((share - 0.1).abs() < 0.01, "{share}");
}

#[test]
fn hit_rates_are_exact_and_no_two_rays_alike() {
    for percent in (0..=100).step_by(10) {
        let Workload { rays, triangles, .. } = hit_rate(42, percent, 200, 300);
        let hits = |ray: &Ray<f32>| -> Vec<bool> {
            triangles.iter().map(|triangle| hit(ray, triangle).is_some()).collect()
        };
        let table: Vec<Vec<bool>> = rays.iter().map(hits).collect();
        for triangle in 0..triangles.len() {
            let count = table.iter().filter(|hits| hits[triangle]).count();
            assert_eq!(count, 2 * percent as usize);
        }
        if percent == 50 {
            // Neither sorted nor alternating, and different for another ray.
            let changes = table[0].windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!((100..200).contains(&changes), "{changes}");
            let differ = table[0].iter().zip(&table[1]).filter(|(one, other)| one != other).count();
            assert!(differ > 30, "{differ}");
        }
    }
}

#[test]
fn misses_are_beside_each_edge_and_of_both_faces() {
    let workload = hit_rate(42, 0, 1, 600);
    let ray = Ray::<f64>::from(workload.rays[0]);
    let (mut kinds, mut front) = ([0; 3], 0);
    for triangle in workload.triangles.iter() {
        let Triangle { a, b, c } = Triangle::<f64>::from(*triangle);
        let (e1, e2, s) = (b - a, c - a, ray.o - a);
        let (p, q) = (ray.d.cross(e2), s.cross(e1));
        let det = e1.dot(p);
        front += usize::from(det > 0.0);
        let (beta, gamma) = (s.dot(p) / det, ray.d.dot(q) / det);
        let failures = [1.0 - beta - gamma, beta, gamma].map(|x| x < 0.0);
        assert_eq!(failures.into_iter().filter(|&failed| failed).count(), 1);
        for (kind, failed) in kinds.iter_mut().zip(failures) {
            *kind += usize::from(failed);
        }
    }
    assert!(kinds.iter().all(|kind| (150..250).contains(kind)), "{kinds:?}");
    assert!((250..350).contains(&front), "{front}");
}

/// Whether a ray meets the box of the mesh, by slabs in f64.
fn meets_bounds(mesh: &Mesh, ray: &Ray<f32>) -> bool {
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let (min, max) = (mesh.bounds.min.to_array(), mesh.bounds.max.to_array());
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let at = |plane: f32| (f64::from(plane) - f64::from(o[axis])) / f64::from(d[axis]);
        let (one, other) = (at(min[axis]), at(max[axis]));
        near = near.max(one.min(other));
        far = far.min(one.max(other));
    }
    near <= far
}

#[test]
fn the_camera_frames_the_bunny() {
    let bunny = trisect_workloads::bunny();
    let (width, height) = (80, 60);
    let rays = primary(&bunny, width, height).rays;
    let met: Vec<bool> = rays.iter().map(|ray| meets_bounds(&bunny, ray)).collect();
    let count = met.iter().filter(|&&met| met).count();
    assert!(count > width * height / 4, "{count}");
    for (pixel, met) in met.iter().enumerate() {
        let (row, column) = (pixel / width, pixel % width);
        let border = row == 0 || row == height - 1 || column == 0 || column == width - 1;
        assert!(!(border && *met), "the picture cuts the mesh at {row}, {column}");
    }
    assert!(met[height / 2 * width + width / 2]);
    // From the top down, from the left to the right as the camera sees it.
    assert!(rays[0].d.y > rays[width * (height - 1)].d.y);
    assert!(rays[0].d.x < rays[width - 1].d.x);
}

#[test]
fn secondary_rays_leave_the_surface() {
    let mesh = box_mesh();
    let seen = primary(&mesh, 32, 24).rays.iter().filter(|r| closest(&mesh, r).is_some()).count();
    let [.., bounce, shadow] = &all(42)[..] else { unreachable!("seven workloads") };
    assert_eq!((bounce.rays.len(), shadow.rays.len()), (seen, seen));
    assert!(seen > 50, "{seen}");
    // A box is convex: nothing that leaves it comes back.
    for ray in &bounce.rays {
        assert!(closest(&mesh, ray).is_none());
    }
    let size = mesh.bounds.diagonal();
    let height = mesh.bounds.center().y + size;
    for ray in &shadow.rays {
        assert!((ray.o.y + ray.d.y - height).abs() < 1e-5 * size);
        assert!(ray.tmin > 0.0 && ray.tmax < 1.0);
    }
}
