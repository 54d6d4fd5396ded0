//! Material libraries of OBJ files (MTL).
//!
//! Read here: the library at hand, tobj, ends the program where a colour has fewer than three numbers.

use std::path::Path;

use glam::{Vec2, Vec3};
use trisect_mesh::Reading;

use crate::error::{SceneError, SceneProblem};
use crate::load::read_text;
use crate::model::{Color, Material, Scene};
use crate::texture::Texture;

/// A material as the file has it.
struct Read {
    name: String,
    diffuse: Color,
    specular: Color,
    emission: Color,
    shininess: f32,
    index_of_refraction: f32,
    opacity: f32,
    illumination: u8,
    texture: Option<usize>,
}

/// Reads the materials of a library: `Kd`, `Ks`, `Ns`, `Ke`, `Ni`, `d`, `Tr`, `map_Kd` and `illum`; all else
/// is passed over. Textures are added to the scene.
pub(crate) fn load(
    path: &Path,
    scene: &mut Scene,
    reading: &mut Reading,
) -> Result<Vec<Material>, SceneError> {
    let text = read_text(path, reading)?;
    let file = path.display().to_string();
    let mut materials: Vec<Read> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (field, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let fault = |what: &str, mend: &str| {
            SceneProblem::faulty(format!("line {}", number + 1), field, what, mend)
                .of_file(file.as_str())
        };
        if field == "newmtl" {
            materials.push(Read::new(rest));
            continue;
        }
        let Some(material) = materials.last_mut() else {
            match field {
                "" => continue,
                _ => return Err(fault("stands before any material", "begin with newmtl")),
            }
        };
        let color = || -> Result<Color, SceneError> {
            let numbers: Option<Vec<f32>> = rest.split_whitespace().map(finite).collect();
            let numbers = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
            numbers.map(Color::from).filter(|color| color.min_element() >= 0.0).ok_or_else(|| {
                fault(&format!("`{rest}` is not three numbers from 0"), "write red, green and blue")
            })
        };
        let from = |least: f32| {
            finite(rest).filter(|x| *x >= least).ok_or_else(|| {
                fault(&format!("`{rest}` is not a number from {least}"), "write one")
            })
        };
        match field {
            "Kd" => material.diffuse = color()?,
            "Ks" => material.specular = color()?,
            "Ke" => material.emission = color()?,
            "Ns" => material.shininess = from(0.0)?,
            "Ni" => material.index_of_refraction = from(0.001)?,
            "d" => material.opacity = from(0.0)?.min(1.0),
            "Tr" => material.opacity = 1.0 - from(0.0)?.min(1.0),
            "illum" => {
                let mend = "write 0 to 10";
                material.illumination =
                    rest.parse().map_err(|_| fault(&format!("`{rest}` is no model"), mend))?;
            }
            "map_Kd" => {
                let pixels =
                    Texture::load(&path.with_file_name(rest), reading).map_err(|problem| {
                        fault(
                            &format!("`{rest}`: {problem}"),
                            "name a PNG or a JPEG beside the library",
                        )
                    })?;
                material.texture = Some(scene.textures.len());
                // v grows upwards in OBJ.
                scene.textures.push(Texture { scale: Vec2::new(1.0, -1.0), pixels });
            }
            _ => {}
        }
    }
    Ok(materials.into_iter().map(Read::finish).collect())
}

fn finite(word: &str) -> Option<f32> {
    word.parse().ok().filter(|x: &f32| x.is_finite())
}

impl Read {
    fn new(name: &str) -> Self {
        let Material { diffuse, specular, emission, shininess, index_of_refraction, .. } =
            Material::default();
        Self {
            name: name.to_owned(),
            diffuse,
            specular,
            emission,
            shininess,
            index_of_refraction,
            opacity: 1.0,
            illumination: 2,
            texture: None,
        }
    }

    /// By the illumination model 3, 5 and 8 reflect `Ks`; 4, 6, 7 and 9, or `d` below 1, are glass.
    fn finish(self) -> Material {
        let is_mirror = matches!(self.illumination, 3 | 5 | 8);
        let is_glass = matches!(self.illumination, 4 | 6 | 7 | 9);
        let opacity = if is_glass && self.opacity == 1.0 { 0.0 } else { self.opacity };
        Material {
            diffuse: self.diffuse * opacity,
            specular: if is_mirror { Vec3::ZERO } else { self.specular },
            shininess: self.shininess,
            reflection: if is_mirror { self.specular } else { Vec3::ZERO },
            transmission: Vec3::splat(1.0 - opacity),
            index_of_refraction: self.index_of_refraction,
            emission: self.emission,
            texture: self.texture,
            name: self.name,
        }
    }
}
