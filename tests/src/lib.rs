//! What the tests of the whole share: where the built command and the FMU lie, and the FMU driven
//! through its C interface alone.

pub mod exchange;
pub mod pages;
pub mod peers;
pub mod slave;
pub mod tangent;
pub mod variables;

use std::path::{Path, PathBuf};

/// Top folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder into which cargo has built this test (target/debug or target/release).
pub fn build_folder() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it lies");
    let deps = test.parent().expect("in a folder");
    deps.parent()
        .expect("deps lies in the profile's folder")
        .to_owned()
}

/// The FMU's binary: as a dependency of the tests it lies beside them.
pub fn fmu_library() -> PathBuf {
    let name = libloading::library_filename("beam_fmu");
    build_folder().join("deps").join(name)
}
