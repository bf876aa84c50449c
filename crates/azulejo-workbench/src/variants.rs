//! The variants of enumerations, and their names in scripts.

use clap::ValueEnum;

/// All variants, in the order of their definition, which is that of the window.
pub fn all<T: ValueEnum + Copy + 'static>() -> impl DoubleEndedIterator<Item = T> {
    T::value_variants().iter().copied()
}

/// The name of a variant in scripts: small letters, with hyphens between words.
pub fn script_name<T: ValueEnum>(variant: T) -> String {
    let value = variant.to_possible_value();
    value.map_or_else(String::new, |v| v.get_name().to_owned())
}
