//! The FMU's resource folder: start values and users' effects.

use beam_model_description::{Layout, START_VALUES_FILE, UserCard, Variable, guid_of};
use std::path::{Path, PathBuf};

/// Start values in the order of the layout, and the GUID that goes with them.
#[derive(Debug, Clone)]
pub struct Starts {
    /// The FMU's variables: the fixed ones and those of the users' effects.
    pub layout: &'static Layout,
    /// One value per variable; 0 where a variable has none.
    pub values: Vec<f64>,
    /// GUID that the master must show.
    pub guid: String,
}

impl Starts {
    /// The built-in ones.
    pub fn built_in() -> Self {
        Self::of(Layout::plain(), beam_model_description::guid().to_owned())
    }

    fn of(layout: &'static Layout, guid: String) -> Self {
        let start = |v: &Variable| v.start.unwrap_or(0.0);
        Self {
            layout,
            values: layout.variables().iter().map(start).collect(),
            guid,
        }
    }

    /// Those of the resource folder where it holds any, else the built-in ones.
    ///
    /// # Errors
    /// A message that names the file, the entry and what to do.
    pub fn load(folder: Option<&Path>) -> Result<Self, String> {
        let Some(file) = folder
            .map(|f| f.join(START_VALUES_FILE))
            .filter(|f| f.exists())
        else {
            return Ok(Self::built_in());
        };
        let at = |problem: String| format!("{}: {problem}; pack the FMU anew", file.display());
        let text = std::fs::read_to_string(&file).map_err(|e| at(format!("can't be read: {e}")))?;
        let resources = file.parent().unwrap_or(Path::new(""));
        Self::parse(&text, resources).map_err(at)
    }

    fn parse(text: &str, resources: &Path) -> Result<Self, String> {
        let mut table: toml::Table = text.parse().map_err(|e| format!("not valid TOML: {e}"))?;
        let guid = match table.remove("guid") {
            Some(toml::Value::String(guid)) => guid,
            Some(other) => return Err(format!("guid = {other} is not a string")),
            None => return Err("the entry 'guid' is missing".to_owned()),
        };
        let effects = match table.remove("effect") {
            Some(list) => user_effects(&list, resources)?,
            None => Vec::new(),
        };
        let layout = Layout::with(effects).map_err(|e| e.to_string())?;
        let mut starts = Self::of(layout, guid);
        if let Some(value) = table.remove("start") {
            match value {
                toml::Value::Table(inner) => starts.take("", &inner)?,
                other => return Err(format!("[start] is not a table but {other}")),
            }
        }
        starts.take("", &table)?;
        Ok(starts)
    }

    /// Takes over the entries of a table; dots in names may be written as nested tables.
    fn take(&mut self, prefix: &str, table: &toml::Table) -> Result<(), String> {
        for (key, value) in table {
            let name = if prefix.is_empty() {
                key.clone()
            } else {
                format!("{prefix}.{key}")
            };
            let number = match value {
                toml::Value::Float(number) => *number,
                toml::Value::Integer(number) => *number as f64,
                toml::Value::Table(inner) => {
                    self.take(&name, inner)?;
                    continue;
                }
                other => return Err(format!("'{name}' = {other} is not a number")),
            };
            let index = self.layout.check_start(&name, number);
            self.values[index.map_err(|e| e.to_string())?] = number;
        }
        Ok(())
    }
}

/// The users' effects that `[[effect]]` lists, each from its file, which must be the one that was packed.
fn user_effects(list: &toml::Value, resources: &Path) -> Result<Vec<UserCard>, String> {
    let entry = |value: &toml::Value| {
        let text = |key: &str| value.get(key)?.as_str();
        let (Some(name), Some(digest)) = (text("file"), text("digest")) else {
            return Err("an [[effect]] lacks the texts 'file' and 'digest'".to_owned());
        };
        let in_file = |problem: String| format!("{name}: {problem}");
        let text = std::fs::read_to_string(resources.join(name))
            .map_err(|e| in_file(format!("can't be read: {e}")))?;
        if guid_of(&text) != digest {
            return Err(in_file(
                "was changed since modelDescription.xml was written for it".into(),
            ));
        }
        UserCard::parse(&text).map_err(|e| {
            let line = e.line().map_or(String::new(), |l| format!("line {l}: "));
            in_file(format!("{line}{e}"))
        })
    };
    let list = list.as_array().ok_or("'effect' is not a list of tables")?;
    list.iter().map(entry).collect()
}

/// The folder of a `file:` URI, whichever way masters write it: `file:///p`, `file:/p`, `file:////p`,
/// `file://localhost/p`, percent-encoded or a bare path.
pub fn folder_of_uri(uri: &str) -> Option<PathBuf> {
    let path = match uri.strip_prefix("file:") {
        None if uri.is_empty() || uri.contains("://") => return None,
        None => return Some(PathBuf::from(uri)),
        Some(rest) => match rest.strip_prefix("//") {
            // An authority may stand between the second and the third slash.
            Some(after) => &after[after.find('/')?..],
            None => rest,
        },
    };
    let path = percent_decoded(path);
    if cfg!(windows) {
        return Some(PathBuf::from(path.trim_start_matches('/')));
    }
    Some(PathBuf::from(path))
}

fn percent_decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = bytes
            .get(i + 1..i + 3)
            .and_then(|hex| std::str::from_utf8(hex).ok())
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match (bytes[i], code) {
            (b'%', Some(byte)) => {
                out.push(byte);
                i += 3;
            }
            (byte, _) => {
                out.push(byte);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index_of_name(name: &str) -> Option<usize> {
        Layout::plain().index_of_name(name)
    }

    #[test]
    fn resource_uris_of_real_masters_are_understood() {
        for uri in [
            "file:///tmp/a b/resources",
            "file:///tmp/a%20b/resources",
            "file:/tmp/a%20b/resources",
            "file://localhost/tmp/a%20b/resources",
            "/tmp/a b/resources",
        ] {
            assert_eq!(
                folder_of_uri(uri).as_deref(),
                Some(Path::new("/tmp/a b/resources")),
                "{uri}"
            );
        }
        assert!(folder_of_uri("file:////tmp/x").is_some());
        assert!(folder_of_uri("https://somewhere/x").is_none());
        assert!(folder_of_uri("").is_none());
        assert!(folder_of_uri("file://").is_none());
    }

    #[test]
    fn start_values_are_taken_over_or_refused_with_a_reason() {
        let starts = Starts::parse(
            "guid = \"{x}\"\nfriction.mu_0 = 0.5\n[start]\n\"mode[1].frequency\" = 81",
            Path::new(""),
        )
        .unwrap();
        assert_eq!(starts.guid, "{x}");
        assert_eq!(starts.values[index_of_name("friction.mu_0").unwrap()], 0.5);
        assert_eq!(
            starts.values[index_of_name("mode[1].frequency").unwrap()],
            81.0
        );
        for (text, part) in [
            ("friction.mu_0 = 0.5", "'guid' is missing"),
            ("guid = \"x\"\nfriction.mu = 0.5", "no such variable"),
            ("guid = \"x\"\nfriction.mu_0 = \"a\"", "is not a number"),
            ("guid = \"x\"\ntip_velocity = 1.0", "is a result"),
            ("guid = \"x\"\nfriction.mu_0 = nan", "finite"),
            ("guid = 3", "not a string"),
            ("guid", "not valid TOML"),
            ("guid = \"x\"\neffect = 1", "not a list"),
            ("guid = \"x\"\n[[effect]]\nfile = \"a\"", "lacks"),
            (
                "guid = \"x\"\n[[effect]]\nfile = \"no/such\"\ndigest = \"\"",
                "no/such: can't be read",
            ),
        ] {
            let message = Starts::parse(text, Path::new("")).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
