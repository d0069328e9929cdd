//! The documents of the repository: one list for every test that reads them. `harness/tests/readme_outputs.rs`
//! compiles this file too.

use std::path::{Path, PathBuf};

/// README.md and the other documents beside it, then every page of docs/ and of docs/adr/.
pub fn pages(root: &Path) -> Vec<PathBuf> {
    let top = ["README", "ARCHITECTURE", "CONTRIBUTING", "CHANGELOG"];
    let mut pages: Vec<PathBuf> = top
        .iter()
        .map(|name| root.join(name).with_extension("md"))
        .collect();
    for folder in ["docs", "docs/adr"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("readable");
        let paths = entries.map(|entry| entry.expect("readable").path());
        let mut found: Vec<PathBuf> = paths
            .filter(|path| path.extension().is_some_and(|e| e == "md"))
            .collect();
        found.sort();
        pages.extend(found);
    }
    pages
}

/// The one TOML example of a page: the text between "```toml" and "```".
pub fn toml_example(page: &str) -> &str {
    const BEGIN: &str = "```toml\n";
    let begin = page.find(BEGIN).expect("an example") + BEGIN.len();
    let end = begin + page[begin..].find("```").expect("its end");
    &page[begin..end]
}
