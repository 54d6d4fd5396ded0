//! Documents that tests put together.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use trisect_mesh::{Mesh, MeshError, MeshFormat, ReadOptions};

pub(crate) const STRICT: ReadOptions =
    ReadOptions { strict: true, sandbox: false, max_memory: ReadOptions::MAX_MEMORY };

pub(crate) type Corners = [[f32; 3]; 3];

pub(crate) fn corners(mesh: &Mesh) -> Vec<Corners> {
    mesh.triangles.iter().map(|t| t.corners().map(trisect_core::Vec3::to_array)).collect()
}

pub(crate) const O: [f32; 3] = [0.0; 3];
pub(crate) const X: [f32; 3] = [1.0, 0.0, 0.0];
pub(crate) const Y: [f32; 3] = [0.0, 1.0, 0.0];
pub(crate) const Z: [f32; 3] = [0.0, 0.0, 1.0];
/// A document of one mesh: its numbers, the JSON of its accessors after the first view, and of the rest.
pub(crate) struct Document {
    pub(crate) bytes: Vec<u8>,
    /// Begin and length of each view, and what else it says.
    pub(crate) views: Vec<(usize, usize, &'static str)>,
    pub(crate) accessors: String,
    pub(crate) primitive: String,
    pub(crate) mesh: &'static str,
    pub(crate) nodes: String,
    pub(crate) more: String,
}

impl Document {
    /// Views of these bytes, each begun at a multiple of 4; a triangle of three floats each is the first.
    pub(crate) fn new(views: &[&[u8]]) -> Self {
        let floats: Vec<u8> =
            [O, X, Y].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let mut this = Self {
            bytes: Vec::new(),
            views: Vec::new(),
            accessors: POSITIONS.to_owned(),
            primitive: r#""attributes": {"POSITION": 0}"#.to_owned(),
            mesh: "",
            nodes: r#"{"mesh": 0}"#.to_owned(),
            more: r#""scene": 0, "scenes": [{"nodes": [0]}]"#.to_owned(),
        };
        for view in [floats.as_slice()].into_iter().chain(views.iter().copied()) {
            this.views.push((this.bytes.len(), view.len(), ""));
            this.bytes.extend(view);
            this.bytes.resize(this.bytes.len().next_multiple_of(4), 0);
        }
        this
    }

    pub(crate) fn text(&self) -> String {
        let views = self.views.iter().map(|(at, length, more)| {
            format!(r#"{{"buffer": 0, "byteOffset": {at}, "byteLength": {length}{more}}}"#)
        });
        let views = views.collect::<Vec<_>>().join(",");
        let (length, data) = (self.bytes.len(), BASE64.encode(&self.bytes));
        let Self { accessors, primitive, mesh, nodes, more, .. } = self;
        format!(
            r#"{{"asset": {{"version": "2.0"}}, {more}, "nodes": [{nodes}],
            "meshes": [{{"primitives": [{{{primitive}}}]{mesh}}}], "accessors": [{accessors}],
            "bufferViews": [{views}],
            "buffers": [{{"byteLength": {length}, "uri": "data:;base64,{data}"}}]}}"#
        )
    }

    pub(crate) fn load(&self) -> Result<Mesh, MeshError> {
        Mesh::from_bytes("m", MeshFormat::Gltf, self.text().as_bytes())
    }

    #[track_caller]
    pub(crate) fn gives(&self, expected: &[Corners]) -> Mesh {
        let mesh = self.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(corners(&mesh), expected);
        mesh
    }

    #[track_caller]
    pub(crate) fn is_refused(&self, expected: &str) {
        let message = self.load().expect_err(expected).to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }

    /// Whether a strict reading takes it.
    pub(crate) fn is_standard(&self) -> bool {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("m.gltf");
        std::fs::write(&path, self.text()).expect("it is written");
        Mesh::load_with(path, &STRICT).is_ok()
    }
}

pub(crate) const POSITIONS: &str = r#"{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
    "min": [0, 0, 0], "max": [1, 1, 0]}"#;

/// What is left of positions once their type and view are given.
pub(crate) fn positions(view: &str) -> String {
    format!(r#"{{{view}, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}"#)
}
