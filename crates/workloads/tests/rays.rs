//! Ray files: round trips, defaults, and every way in which a file can be wrong.

use proptest::prelude::*;
use trisect_core::Ray;
use trisect_mesh::ReadOptions;
use trisect_workloads::{
    read_rays, read_rays_binary, read_rays_csv, read_rays_csv_with, read_rays_with,
    write_rays_binary, write_rays_csv,
};

#[test]
fn the_interval_has_defaults() {
    let file = read_rays_csv("-", "ox,oy,oz,dx,dy,dz\n1, 2 ,3,0,0,-1.5\n".as_bytes());
    let ray = Ray::<f64>::new([1.0, 2.0, 3.0], [0.0, 0.0, -1.5]);
    assert_eq!(file.expect("sound").rays, [ray]);
    let content = "\u{feff}ox,oy,oz,dx,dy,dz,tmax\r\n1,2,3,0,0,-1.5,inf\r\n1,2,3,0,0,0,4\r\n";
    let rays = read_rays_csv("-", content.as_bytes()).expect("sound").rays;
    let zero = Ray { d: [0.0; 3].into(), tmax: 4.0, ..ray };
    assert_eq!(rays, [ray, zero]);
}

#[test]
fn each_precision_is_rounded_once() {
    // Just above the middle of 1 and the next f32: by way of f64 it would be the middle, and
    // go down to even.
    let content = "ox,oy,oz,dx,dy,dz\n1.0000000596046447753906251,0,0,0,0,1\n";
    let file = read_rays_csv("-", content.as_bytes()).expect("sound");
    assert_eq!(file.rays[0].o.x, 1.0 + f64::from(f32::EPSILON) / 2.0);
    assert_eq!(file.rays_f32[0].o.x, 1.0 + f32::EPSILON);
}

#[test]
fn no_rays_are_accepted() {
    assert!(read_rays_csv("-", "ox,oy,oz,dx,dy,dz\n".as_bytes()).expect("sound").rays.is_empty());
    assert!(read_rays_binary("none.rays", &[0; 4]).expect("sound").rays.is_empty());
}

#[test]
fn wrong_csv_says_what_where_and_what_mends_it() {
    let header = "; write `ox,oy,oz,dx,dy,dz`, and `tmin`, `tmax` after it where they are wanted";
    let finite = "; write a finite decimal number";
    let interval = "; write a decimal number or `inf`";
    let cases = [
        ("", format!("line 1: the header is ``{header}")),
        ("1,2,3,0,0,1\n", format!("line 1: the header is `1,2,3,0,0,1`{header}")),
        ("ox,oy,oz,dx,dy\n", format!("line 1: the header is `ox,oy,oz,dx,dy`{header}")),
        ("ox,oy,oz,dx,dy,dz,dz\n", format!("line 1: the header is `ox,oy,oz,dx,dy,dz,dz`{header}")),
        (
            "ox,oy,oz,dx,dy,dz,tmax,tmin\n",
            format!("line 1: the header is `ox,oy,oz,dx,dy,dz,tmax,tmin`{header}"),
        ),
        (
            "1,2,3,0,0,1\n1,2,3,0,0\n",
            "line 3: 5 fields, the header names 6; write one for each column".to_owned(),
        ),
        (
            "1,2,3,0,0,1,2\n",
            "line 2: 7 fields, the header names 6; write one for each column".to_owned(),
        ),
        ("1,2,x,0,0,1\n", format!("line 2, oz: `x` is not a number{finite}")),
        ("1,2,,0,0,1\n", format!("line 2, oz: `` is not a number{finite}")),
        ("1,2,3,nan,0,1\n", format!("line 2, dx: `nan` is not a number{finite}")),
        ("1,2,3,0,-inf,1\n", format!("line 2, dy: `-inf` is not finite in f32{finite}")),
        ("1,2,3,0,1e39,1\n", format!("line 2, dy: `1e39` is not finite in f32{finite}")),
        (
            "ox,oy,oz,dx,dy,dz,tmin\n1,2,3,0,0,1,NaN\n",
            format!("line 2, tmin: `NaN` is not a number{interval}"),
        ),
    ];
    for (content, expected) in cases {
        let own_header =
            content.is_empty() || content.starts_with('o') || expected.contains("header is");
        let content =
            if own_header { content.to_owned() } else { format!("ox,oy,oz,dx,dy,dz\n{content}") };
        let error = read_rays_csv("r.csv", content.as_bytes()).expect_err(&expected);
        assert_eq!(error.to_string(), format!("r.csv: {expected}"));
    }
    let error = read_rays_csv("r.csv", &b"ox,oy,oz,dx,dy,dz\n1,2,\xff,0,0,1\n"[..]);
    let expected = "r.csv: line 2, oz: `ÿ` is not a number; write a finite decimal number";
    assert_eq!(error.expect_err("not a number").to_string(), expected);
}

#[test]
fn csv_of_any_line_ends_and_marks_is_the_same() {
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    let plain = "ox,oy,oz,dx,dy,dz\n1,2,3,0,0,1\n4,5,6,0,1,0\n";
    let expected = read_rays_csv("-", plain.as_bytes()).expect("sound");
    let comments = plain.replace("1,2", "# caf\u{e9}, with \"quotes\n1,2");
    let latin: Vec<u8> = comments.chars().map(|c| u8::try_from(c).expect("Latin-1")).collect();
    for (bytes, is_standard) in [
        (plain.replace('\n', "\r\n").into_bytes(), true),
        (plain.replace('\n', "\r").into_bytes(), true),
        (plain.trim_end().as_bytes().to_vec(), true),
        (comments.into_bytes(), true),
        (format!("\u{feff}{plain}").into_bytes(), false),
        (latin, false),
    ] {
        let read = read_rays_csv("-", bytes.as_slice()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read, expected);
        assert_eq!(read_rays_csv_with("-", bytes.as_slice(), &strict).is_ok(), is_standard);
    }
    let error = read_rays_csv("-", "ox,oy,oz,dx,dy,dz\r1,2,3,0,0,1\r1,2,3\r".as_bytes());
    assert!(error.expect_err("too few").to_string().starts_with("-: line 3: 3 fields"));
}

#[test]
fn no_file_takes_more_memory_than_is_allowed() {
    let options = ReadOptions { max_memory: 1000, ..ReadOptions::default() };
    // Standard input may have no end.
    let error = read_rays_csv_with("-", std::io::repeat(b'1'), &options).expect_err("endless");
    let expected = "-: needs more than the 1000 bytes that --max-memory allows; raise it";
    assert_eq!(error.to_string(), expected);
    let csv = format!("ox,oy,oz,dx,dy,dz\n{}", "0,0,0,0,0,1\n".repeat(40));
    let error = read_rays_csv_with("-", csv.as_bytes(), &options).expect_err("40 rays");
    assert_eq!(error.to_string(), expected);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("r.rays");
    write_rays_binary(
        std::fs::File::create(&path).expect("made"),
        &[Ray::<f32>::new([0.0; 3], [0.0, 0.0, 1.0]); 20],
    )
    .expect("written");
    assert!(read_rays_with(&path, &options).is_err() && read_rays(&path).is_ok());
    // A count without rays.
    let error = read_rays_binary("r.rays", &u32::MAX.to_le_bytes()).expect_err("cut").to_string();
    assert!(error.starts_with("r.rays: 4294967295 rays need 137438953444 bytes"), "{error}");
    let error = read_rays(folder.path().with_extension("rays")).expect_err("not there");
    assert!(error.to_string().contains("cannot be read ("), "{error}");
    let folder = folder.path().join("folder.csv");
    std::fs::create_dir(&folder).expect("made");
    assert!(
        read_rays(&folder)
            .expect_err("a folder")
            .to_string()
            .ends_with("not a regular file; name one")
    );
}

#[test]
fn wrong_binary_files_say_what_where_and_what_mends_it() {
    let mut bytes = Vec::new();
    let rays = [Ray::<f32>::new([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]); 2];
    write_rays_binary(&mut bytes, &rays).expect("written");
    assert_eq!(bytes.len(), 68);
    for length in 0..bytes.len() {
        let error = read_rays_binary("r.rays", &bytes[..length]).expect_err("cut").to_string();
        let expected = if length < 4 { "0 rays need 4" } else { "2 rays need 68" };
        let expected = format!(
            "r.rays: {expected} bytes, the file has {length}; copy or write the file again"
        );
        assert_eq!(error, expected);
    }
    let long: Vec<u8> = bytes.iter().copied().chain([0]).collect();
    let error = read_rays_binary("r.rays", &long).expect_err("long").to_string();
    assert!(error.contains("2 rays need 68 bytes, the file has 69"), "{error}");
    bytes[4 + 32 + 16..4 + 32 + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = read_rays_binary("r.rays", &bytes).expect_err("NaN").to_string();
    let expected = "r.rays: ray 1, dx: NaN is not a number; write a finite decimal number";
    assert_eq!(error, expected);
}

#[test]
fn files_are_told_by_their_ending() {
    let folder = tempfile::tempdir().expect("a folder");
    let rays = vec![Ray { tmax: 0.5, ..Ray::<f32>::new([0.1, 2.0, 3.0], [0.0, -0.0, 1e-30]) }];
    let wide: Vec<Ray<f64>> = rays.iter().map(|&ray| ray.into()).collect();
    let (csv, binary) = (folder.path().join("r.csv"), folder.path().join("r.RAYS"));
    write_rays_csv(std::fs::File::create(&csv).expect("made"), &wide).expect("written");
    write_rays_binary(std::fs::File::create(&binary).expect("made"), &rays).expect("written");
    for path in [csv, binary] {
        let file = read_rays(path).expect("sound");
        assert_eq!((file.rays, file.rays_f32), (wide.clone(), rays.clone()));
    }
    let error = read_rays("r.txt").expect_err("unknown").to_string();
    assert_eq!(error, "r.txt: unknown file type; known are .csv and .rays");
    let error = read_rays("nowhere/r.csv").expect_err("missing").to_string();
    assert!(error.starts_with("nowhere/r.csv: cannot be read ("), "{error}");
}

fn bits(ray: &Ray<f64>) -> [u64; 8] {
    let ([a, b, c], [d, e, f]) = (ray.o.to_array(), ray.d.to_array());
    [a, b, c, d, e, f, ray.tmin, ray.tmax].map(f64::to_bits)
}

proptest! {
    #[test]
    fn csv_round_trips_every_finite_float(
        coordinates in prop::array::uniform6(prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL
            | prop::num::f32::ZERO),
        tmin in any::<f32>(),
        tmax in any::<f32>(),
    ) {
        let [ox, oy, oz, dx, dy, dz] = coordinates;
        let clean = |t: f32| if t.is_nan() { f32::INFINITY } else { t };
        let ray = Ray {
            o: [ox, oy, oz].into(),
            d: [dx, dy, dz].into(),
            tmin: clean(tmin),
            tmax: clean(tmax),
        };
        let mut text = Vec::new();
        write_rays_csv(&mut text, &[ray.into()]).expect("written");
        let file = read_rays_csv("-", text.as_slice()).expect("sound");
        prop_assert_eq!(bits(&file.rays[0]), bits(&ray.into()));
        prop_assert_eq!(bits(&file.rays_f32[0].into()), bits(&ray.into()));
    }

    #[test]
    fn any_text_is_read_or_refused(text in "[-0-9eEinfoxyzdtm.,\"\n\r ]{0,80}") {
        let _ = read_rays_csv("-", text.as_bytes());
        let _ = read_rays_csv("-", format!("ox,oy,oz,dx,dy,dz\n{text}").as_bytes());
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..120)) {
        let _ = read_rays_csv("-", bytes.as_slice());
        let _ = read_rays_binary("r.rays", &bytes);
    }
}
