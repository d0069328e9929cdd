//! Writes modelDescription.xml anew: `cargo run -p beam-model-description --example write_description`.

fn main() -> std::io::Result<()> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/modelDescription.xml");
    std::fs::write(file, beam_model_description::xml())?;
    println!("{file}");
    Ok(())
}
