//! The embedded typeface.

/// A crate can only embed files of its own, and the examples should stand alone.
#[test]
fn the_embedded_typeface_is_that_of_the_examples() {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/fonts");
    let of = |name: &str| std::fs::read(format!("{examples}/{name}")).unwrap();
    assert!(of("dejavu-serif.ppf") == azulejo::typeface::DEJAVU_SERIF);
    assert!(of("latin.ppe") == azulejo::typeface::LATIN);
}
