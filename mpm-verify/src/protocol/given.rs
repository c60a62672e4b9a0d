//! What a neutral case gives: the keys of a scene without those of any method, each with its unit in its name.

use mpm_core::scene::Scene;
use serde_json::{Map, Value as Json};
use toml::{Table, Value};

use super::units::{Scale, suffix};
use crate::book::reference;
use crate::error::Error::{self, Found};

/// Keys that belong to a method, or that a case says elsewhere.
const METHOD: &[&str] = &[
    "name",
    "mesh",
    "scheme",
    "time",
    "failure",
    "observe",
    "soil.strain",
    "soil.separation",
    "stages[].coupling",
    "stages[].name",
];

/// Units of keys that the page of scene files tells in words.
const IN_WORDS: &[(&str, &str)] = &[
    ("van_genuchten.alpha", "1/m"),
    ("gardner.alpha", "1/m"),
    (".entry", "m"),
    ("rest.speed", "m/s"),
    ("rest.at_most", "s"),
];

/// The unit of a key by its path; a list of pairs has one for each part.
fn unit(path: &str) -> String {
    let told = IN_WORDS.iter().find(|(end, _)| path.ends_with(end)).map(|(_, unit)| (*unit).to_owned());
    told.or_else(|| reference::unit(path)).unwrap_or_else(|| "-".to_owned())
}

/// Whether a key belongs to a method.
fn is_method(path: &str) -> bool {
    METHOD.iter().any(|own| path == *own || path.strip_prefix(own).is_some_and(|rest| rest.starts_with('.')))
}

/// The table of a scene.
fn table(text: &str) -> Result<Table, Error> {
    text.parse().map_err(|error: toml::de::Error| Found(error.to_string()))
}

/// Everything of a scene that is no matter of the method.
///
/// # Errors
/// A scene that cannot be written.
pub fn given(scene: &Scene) -> Result<Json, Error> {
    Ok(neutral(&Value::Table(table(&scene.text()?)?), ""))
}

/// Joins a key to the path of its table.
fn below(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// A value with the units in the names of its keys.
fn neutral(value: &Value, path: &str) -> Json {
    match value {
        Value::Table(entries) => {
            let mut all = Map::new();
            for (key, value) in entries {
                let path = below(path, key);
                let inner = if is_list_of_tables(value) { format!("{path}[]") } else { path.clone() };
                if !is_method(&path) {
                    all.insert(format!("{key}{}", suffix(&unit(&path))), neutral(value, &inner));
                }
            }
            Json::Object(all)
        }
        Value::Array(list) => Json::Array(list.iter().map(|value| neutral(value, path)).collect()),
        Value::Float(number) if !number.is_finite() => Json::String("infinite".to_owned()),
        other => serde_json::to_value(other).unwrap_or_default(),
    }
}

fn is_list_of_tables(value: &Value) -> bool {
    value.as_array().is_some_and(|list| list.first().is_some_and(Value::is_table))
}

/// The scene of what a case gives, with the method of a scene of ours.
///
/// # Errors
/// A case that no scene can be made of.
pub fn scene(given: &Json, method: &Scene) -> Result<Scene, Error> {
    let Value::Table(mut all) = plain(given, "")? else { return Err(Found("given: expected a table".to_owned())) };
    let own = table(&method.text()?)?;
    take(&mut all, &own, "");
    let text = toml::to_string(&all).map_err(|error| Found(error.to_string()))?;
    Ok(Scene::parse(&text, "case.json")?)
}

/// Adds the keys of a method to a scene that has none.
fn take(all: &mut Table, own: &Table, path: &str) {
    for (key, value) in own {
        let path = below(path, key);
        if is_method(&path) {
            all.insert(key.clone(), value.clone());
        } else if let (Some(Value::Table(inner)), Value::Table(own)) = (all.get_mut(key), value) {
            take(inner, own, &path);
        } else if let (Some(Value::Array(inner)), Value::Array(own)) = (all.get_mut(key), value) {
            for (inner, own) in inner.iter_mut().zip(own) {
                if let (Value::Table(inner), Value::Table(own)) = (inner, own) {
                    take(inner, own, &format!("{path}[]"));
                }
            }
        }
    }
}

/// A value under the names that scenes have for its keys.
fn plain(value: &Json, path: &str) -> Result<Value, Error> {
    Ok(match value {
        Json::Object(entries) => {
            let mut all = Table::new();
            for (key, value) in entries {
                let is_own = |name: &&str| format!("{name}{}", suffix(&unit(&below(path, name)))) == *key;
                // A suffix begins at one of the underscores, or there is none.
                let cut = key.match_indices('_').map(|(at, _)| &key[..at]);
                let name = cut.chain([key.as_str()]).find(is_own).unwrap_or(key);
                let inner = below(path, name);
                let is_list = value.as_array().is_some_and(|list| list.first().is_some_and(Json::is_object));
                let inner = if is_list { format!("{inner}[]") } else { inner };
                all.insert(name.to_owned(), plain(value, &inner)?);
            }
            Value::Table(all)
        }
        Json::Array(list) => Value::Array(list.iter().map(|value| plain(value, path)).collect::<Result<_, _>>()?),
        Json::String(word) if word == "infinite" => Value::Float(f64::INFINITY),
        other => Value::try_from(other).map_err(|error| Found(format!("{path}: {error}")))?,
    })
}

/// A scene of another scale.
///
/// # Errors
/// A number in a unit that is not known, or a scene that is refused.
pub fn scaled(scene: &Scene, scale: Scale) -> Result<Scene, Error> {
    if scale == Scale::ONE {
        return Ok(scene.clone());
    }
    let mut all = Value::Table(table(&scene.text()?)?);
    stretch(&mut all, "", scale)?;
    let text = toml::to_string(&all).map_err(|error| Found(error.to_string()))?;
    Ok(Scene::parse(&text, &scene.name)?)
}

fn stretch(value: &mut Value, path: &str, scale: Scale) -> Result<(), Error> {
    let factor = |unit: &str| scale.factor(unit).ok_or_else(|| Found(format!("{path}: unit {unit}")));
    match value {
        Value::Table(entries) => {
            for (key, value) in entries {
                let path = below(path, key);
                let inner = if is_list_of_tables(value) { format!("{path}[]") } else { path };
                stretch(value, &inner, scale)?;
            }
        }
        Value::Array(list) => {
            let units = unit(path);
            let parts: Vec<&str> = units.split(", ").collect();
            for (number, value) in list.iter_mut().enumerate() {
                match value {
                    // Of pairs [time, factor], or of [height, value]: the first is a length where a key has one unit.
                    Value::Array(pair) if pair.len() == 2 && (parts.len() == 2 || path.starts_with("initial")) => {
                        let units = if parts.len() == 2 { [parts[0], parts[1]] } else { ["m", parts[0]] };
                        for (value, unit) in pair.iter_mut().zip(units) {
                            times(value, factor(unit)?);
                        }
                    }
                    Value::Array(_) | Value::Table(_) => stretch(value, path, scale)?,
                    value => times(value, factor(parts[number.min(parts.len() - 1)])?),
                }
            }
        }
        value => times(value, if value.is_str() || value.is_bool() { 1.0 } else { factor(&unit(path))? }),
    }
    Ok(())
}

/// A number times a factor; whole numbers are counts.
fn times(value: &mut Value, factor: f64) {
    match value {
        Value::Float(number) => *number *= factor,
        Value::Integer(number) if factor != 1.0 => *value = Value::Float(*number as f64 * factor),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::BUILT_IN;

    #[test]
    fn a_scene_comes_back_from_what_is_given_of_it() {
        for (name, text) in BUILT_IN {
            let scene = Scene::parse(text, name).expect(name);
            let back = self::scene(&given(&scene).expect(name), &scene).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(scene.edited(|_| {}).expect(name), back, "{name}");
        }
    }

    #[test]
    fn a_scene_of_another_scale_is_as_far_from_its_limit() {
        let scale = Scale { length: 1.7, time: 0.6, stress: 2.3 };
        for (name, text) in BUILT_IN.iter().filter(|(name, _)| !name.starts_with("levee")) {
            let scene = Scene::parse(text, name).expect(name);
            let other = scaled(&scene, scale).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!((other.height / scene.height / scale.length - 1.0).abs() < 1e-12, "{name}");
            let [limit, scaled] = [&scene, &other].map(|scene| mpm_core::stability::stable_limit(scene));
            assert!((scaled / limit / scale.time - 1.0).abs() < 1e-9 || limit.is_infinite(), "{name}");
        }
    }
}
