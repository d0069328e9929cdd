//! Link options of the FMU's binary.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        // Thread-locals of the standard library register destructors that live in this library; once
        // a host has unloaded it, the end of a thread would jump into nothing (rust-lang/rust#91979).
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
