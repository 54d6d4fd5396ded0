//! Material libraries of OBJ files (MTL).
//!
//! Read here: the library at hand, tobj, ends the program where a colour has fewer than three numbers.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use trisect_mesh::{ReadProblem, Reading, lines, quoted, unquoted, without_comment};

use crate::error::{SceneError, SceneProblem};
use crate::files::{beside, read_text};
use crate::model::{Color, Material, Scene};
use crate::texture::{Texture, UNUSABLE};

/// A material as the file has it.
struct Read {
    name: String,
    diffuse: Option<Color>,
    specular: Color,
    emission: Color,
    shininess: f32,
    index_of_refraction: f32,
    /// `d`.
    opacity: Option<f32>,
    /// `Tr`, and its line.
    transparency: Option<(f32, usize)>,
    /// `Tf`.
    filter: Option<Color>,
    illumination: u8,
    texture: Option<usize>,
}

/// Reads the materials of a library. What it says of a surface that this program does not know is noted;
/// no fault of it makes it unreadable. Textures are added to the scene.
pub(crate) fn load(
    path: &Path,
    scene: &mut Scene,
    reading: &mut Reading,
) -> Result<Vec<Material>, SceneError> {
    let text = read_text(path, reading)?;
    let file = path.display().to_string();
    let mut library = Library {
        path,
        file: &file,
        scene,
        reading,
        materials: Vec::new(),
        names: HashSet::new(),
        textures: HashMap::new(),
    };
    for (line, content) in lines(&text) {
        let content = content.trim();
        let (field, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        library.statement(line, field, rest)?;
    }
    Ok(library.finish())
}

/// The statements of MTL as Alias|Wavefront described it.
const STANDARD: [&str; 19] = [
    "Ka",
    "Kd",
    "Ks",
    "Tf",
    "illum",
    "d",
    "Ns",
    "sharpness",
    "Ni",
    "map_Ka",
    "map_Kd",
    "map_Ks",
    "map_Ns",
    "map_d",
    "map_aat",
    "disp",
    "decal",
    "bump",
    "refl",
];

struct Library<'a> {
    path: &'a Path,
    file: &'a str,
    scene: &'a mut Scene,
    reading: &'a mut Reading,
    materials: Vec<Read>,
    names: HashSet<String>,
    /// Textures of the scene by their file and how often they repeat; none where it cannot be used.
    textures: HashMap<(PathBuf, [u32; 2]), Option<usize>>,
}

impl Library<'_> {
    fn statement(&mut self, line: usize, field: &str, rest: &str) -> Result<(), SceneError> {
        let place = format!("line {line}: {}", quoted(field));
        let keyword = field.to_ascii_lowercase();
        if field.is_empty() || field.starts_with('#') {
            return Ok(());
        }
        if keyword == "newmtl" {
            let name = unquoted(without_comment(rest));
            if !self.names.insert(name.to_owned()) {
                self.note(&place, "a material of a name that is there already replaces it")?;
            }
            self.materials.push(Read::new(name));
            return Ok(());
        }
        if self.materials.is_empty() {
            return self.note(&place, "a statement before the first material is left out");
        }
        // A number ends where a comment begins, with white space between or not.
        let numbers = rest.split('#').next().unwrap_or_default().trim();
        match keyword.as_str() {
            "kd" => {
                let color = self.color(&place, numbers)?;
                self.change(color, |material, color| material.diffuse = Some(color));
            }
            "ks" => {
                let color = self.color(&place, numbers)?;
                self.change(color, |material, color| material.specular = color);
            }
            "ke" => {
                let color = self.color(&place, numbers)?;
                self.change(color, |material, color| material.emission = color);
            }
            "tf" => {
                let color = self.color(&place, numbers)?;
                self.change(color, |material, color| material.filter = Some(color));
            }
            "ns" => {
                let number = self.number(&place, numbers, 0.0)?;
                self.change(number, |material, number| material.shininess = number);
            }
            "ni" => {
                let number = self.number(&place, numbers, 0.001)?;
                self.change(number, |material, number| material.index_of_refraction = number);
            }
            "d" => {
                let factor = numbers.strip_prefix("-halo").unwrap_or(numbers).trim();
                if factor.len() < numbers.len() {
                    let what = "-halo is left out: the surface is equally clear from all sides";
                    self.reading.remark(self.file, &place, what);
                }
                let number = self.number(&place, factor, 0.0)?;
                self.change(number, |material, number| material.opacity = Some(number.min(1.0)));
            }
            "tr" => {
                let number = self.number(&place, numbers, 0.0)?;
                let transparency = number.map(|number| (number.min(1.0), line));
                self.change(transparency, |material, it| material.transparency = Some(it));
            }
            "illum" => {
                let model = numbers.parse().ok().filter(|model: &u8| *model <= 10);
                if model.is_none() {
                    self.note(&place, "a model of illumination other than 0 to 10 is left out")?;
                }
                self.change(model, |material, model| material.illumination = model);
            }
            "map_kd" => self.texture(&place, without_comment(rest))?,
            "map_ks" | "map_ns" | "map_d" | "map_tr" | "map_ke" | "map_bump" | "bump" | "norm"
            | "disp" | "decal" | "refl" => {
                let what = "maps other than map_Kd are left out";
                self.reading.remark(self.file, &place, what);
            }
            _ => {}
        }
        if STANDARD.contains(&field) {
            return Ok(());
        }
        self.reading
            .tolerate(&place, "a statement that MTL does not have")
            .map_err(|p| self.fail(p))
    }

    /// Changes the material that the statements are about.
    fn change<T>(&mut self, value: Option<T>, set: impl FnOnce(&mut Read, T)) {
        if let (Some(material), Some(value)) = (self.materials.last_mut(), value) {
            set(material, value);
        }
    }

    /// One number stands for all three of a colour.
    fn color(&mut self, place: &str, numbers: &str) -> Result<Option<Color>, SceneError> {
        if numbers.starts_with("spectral") || numbers.starts_with("xyz") {
            let what = "a colour as a spectrum or in XYZ is left out";
            self.reading.remark(self.file, place, what);
            return Ok(None);
        }
        let parsed: Option<Vec<f32>> = numbers.split_whitespace().map(from_zero).collect();
        let color = match parsed.as_deref() {
            Some(&[grey]) => Some(Vec3::splat(grey)),
            Some(&[red, green, blue]) => Some(Vec3::new(red, green, blue)),
            _ => None,
        };
        if color.is_none() {
            self.note(place, "a colour that is not one or three numbers from 0 is left out")?;
        }
        Ok(color)
    }

    fn number(&mut self, place: &str, word: &str, least: f32) -> Result<Option<f32>, SceneError> {
        let number = from_zero(word).filter(|number| *number >= least);
        if number.is_none() {
            self.note(place, &format!("what is not a number from {least} is left out"))?;
        }
        Ok(number)
    }

    fn texture(&mut self, place: &str, rest: &str) -> Result<(), SceneError> {
        let Map { file, scale, lost } = Map::read(rest);
        if let Some(lost) = lost {
            let what = format!("the option {lost} of map_Kd is left out");
            self.reading.remark(self.file, place, &what);
        }
        if file.is_empty() {
            return self.note(place, "a map without a file is left out");
        }
        let path = beside(self.path.parent(), file);
        let key = (path, scale.to_array().map(f32::to_bits));
        let texture = if let Some(&known) = self.textures.get(&key) {
            if known.is_none() {
                self.note(place, UNUSABLE)?;
            }
            known
        } else {
            let pixels = Texture::load(&key.0, self.reading);
            let place = format!("{place}: `{}`", quoted(file));
            let pixels = Texture::or_without(pixels, self.file, &place, self.reading);
            let pixels = pixels.map_err(|problem| self.of_picture(problem, &key.0))?;
            let texture = pixels.map(|pixels| {
                // v grows upwards in OBJ.
                let scale = scale * Vec2::new(1.0, -1.0);
                self.scene.textures.push(Texture { scale, pixels });
                self.scene.textures.len() - 1
            });
            self.textures.insert(key, texture);
            texture
        };
        self.change(texture, |material, texture| material.texture = Some(texture));
        Ok(())
    }

    /// What is not standard is the library's fault; all else the picture's.
    fn of_picture(&self, problem: SceneProblem, picture: &Path) -> SceneError {
        match problem {
            SceneProblem::Unread(ReadProblem::NotStandard { .. }) => problem.of_file(self.file),
            _ => problem.of_file(picture.display().to_string()),
        }
    }

    fn note(&mut self, place: &str, what: &str) -> Result<(), SceneError> {
        self.reading.note(self.file, place, what).map_err(|problem| self.fail(problem))
    }

    fn fail(&self, problem: ReadProblem) -> SceneError {
        SceneProblem::Unread(problem).of_file(self.file)
    }

    fn finish(self) -> Vec<Material> {
        for material in &self.materials {
            if let (None, Some((1.0, line))) = (material.opacity, material.transparency)
                && !material.is_glass()
            {
                let what = "Tr 1 without d is taken as opaque, as programs write it that mean d";
                self.reading.remark(self.file, &format!("line {line}"), what);
            }
        }
        self.materials.into_iter().map(Read::finish).collect()
    }
}

/// What `map_Kd` says.
struct Map<'a> {
    file: &'a str,
    /// How often the picture repeats (`-s`).
    scale: Vec2,
    /// The first option that is not followed and changes what is seen.
    lost: Option<&'a str>,
}

impl<'a> Map<'a> {
    fn read(text: &'a str) -> Self {
        let mut map = Self { file: text.trim(), scale: Vec2::ONE, lost: None };
        loop {
            let (option, after) = next_word(map.file);
            let is_number = |word: &str| word.parse::<f32>().is_ok();
            let (least, most) = match option {
                "-s" | "-o" | "-t" => (1, 3),
                "-mm" => (2, 2),
                "-clamp" | "-cc" | "-blendu" | "-blendv" | "-texres" | "-bm" | "-boost"
                | "-imfchan" | "-type" => (1, 1),
                _ => {
                    map.file = unquoted(map.file);
                    return map;
                }
            };
            let mut values = Vec::new();
            map.file = after;
            while values.len() < most {
                let (value, after) = next_word(map.file);
                // A file name follows, which may be a number: but not before the least count, or last.
                if value.is_empty()
                    || values.len() >= least && (!is_number(value) || after.is_empty())
                {
                    break;
                }
                values.push(value);
                map.file = after;
            }
            let numbers: Vec<f32> = values.iter().map_while(|value| value.parse().ok()).collect();
            match (option, numbers.as_slice()) {
                ("-s", [u, rest @ ..]) if u.is_finite() => {
                    let v = rest.first().copied().filter(|v| v.is_finite());
                    map.scale = Vec2::new(*u, v.unwrap_or(1.0));
                }
                ("-o" | "-t", numbers) if numbers.iter().all(|x| *x == 0.0) => {}
                // The last are about how a picture is filtered, and what other maps take of it.
                ("-mm", [0.0, 1.0])
                | (
                    "-blendu" | "-blendv" | "-texres" | "-bm" | "-boost" | "-imfchan" | "-type",
                    _,
                ) => {}
                ("-clamp" | "-cc", _) if values == ["off"] => {}
                _ => map.lost = map.lost.or(Some(option)),
            }
        }
    }
}

/// The first word, and what follows the white space after it.
fn next_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

fn from_zero(word: &str) -> Option<f32> {
    word.parse().ok().filter(|x: &f32| x.is_finite() && *x >= 0.0)
}

impl Read {
    fn new(name: &str) -> Self {
        let Material { specular, emission, shininess, index_of_refraction, .. } =
            Material::default();
        Self {
            name: name.to_owned(),
            diffuse: None,
            specular,
            emission,
            shininess,
            index_of_refraction,
            opacity: None,
            transparency: None,
            filter: None,
            illumination: 2,
            texture: None,
        }
    }

    /// Whether the illumination model is one of those that refract. Many programs write such a one for
    /// every material: it makes glass only of what another statement makes clear.
    fn is_glass(&self) -> bool {
        matches!(self.illumination, 4 | 6 | 7 | 9)
    }

    /// By the illumination model 3, 5 and 8 reflect `Ks`. `d` below 1 or `Tr` above 0 is glass; so is `Tf`
    /// other than white where the model refracts.
    fn finish(self) -> Material {
        let is_mirror = matches!(self.illumination, 3 | 5 | 8);
        let opacity = match (self.opacity, self.transparency) {
            (Some(opacity), _) => opacity,
            (None, Some((1.0, _))) if !self.is_glass() => 1.0,
            (None, Some((transparency, _))) => 1.0 - transparency,
            (None, None) => 1.0,
        };
        let filter = self.filter.filter(|filter| self.is_glass() && *filter != Vec3::ONE);
        let (opaque, transmission) = match filter {
            Some(filter) if opacity == 1.0 => {
                let filter = filter.min(Vec3::ONE);
                (Vec3::ONE - filter, filter)
            }
            _ => (Vec3::splat(opacity), Vec3::splat(1.0 - opacity)),
        };
        // A map is multiplied by `Kd`; alone it is shown as it is.
        let plain = if self.texture.is_some() { Vec3::ONE } else { Material::default().diffuse };
        Material {
            diffuse: self.diffuse.unwrap_or(plain) * opaque,
            specular: if is_mirror { Vec3::ZERO } else { self.specular },
            shininess: self.shininess,
            reflection: if is_mirror { self.specular } else { Vec3::ZERO },
            transmission,
            index_of_refraction: self.index_of_refraction,
            emission: self.emission,
            texture: self.texture,
            name: self.name,
        }
    }
}
