//! What has a content as bytes, and the contents of numbers, lists and texts.

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use std::sync::Arc;

/// Receives the bytes of a content, part by part.
pub type ContentSink<'s> = dyn FnMut(&[u8]) + 's;

/// What has a content.
pub trait ContentBytes {
    /// Passes all bytes of the content to `sink`, in parts of any length.
    fn feed(&self, sink: &mut ContentSink<'_>);
}

/// Feeds the fields of structures in their order; does not compile if one is missing. Fields after a semicolon are
/// left out.
macro_rules! content_of_fields {
    ($($type:ident { $($field:ident),+ $(; $($omitted:ident),+)? })+) => {
        $(impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                let $type { $($field,)+ $($($omitted: _,)+)? } = self;
                $($field.feed(sink);)+
            }
        })+
    };
}

/// Feeds the number of a variant, then its fields.
macro_rules! content_of_variants {
    ($($type:ident {
        $($number:literal = $variant:ident $(($item:ident))? $({ $($field:ident),+ })?),+ $(,)?
    })+) => {
        $(impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                match self {
                    $($type::$variant $(($item))? $({ $($field),+ })? => {
                        let number: u8 = $number;
                        number.feed(sink);
                        $($item.feed(sink);)?
                        $($($field.feed(sink);)+)?
                    })+
                }
            }
        })+
    };
}

pub(crate) use {content_of_fields, content_of_variants};

/// Feeds numbers by their bytes.
macro_rules! content_of_numbers {
    ($($type:ident)+) => {
        $(impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                sink(&self.to_le_bytes());
            }
        })+
    };
}

content_of_numbers! { u8 u32 u64 f32 f64 }

/// Feeds other content in place of a value.
macro_rules! content_as {
    ($([$($generics:tt)*] $type:ty: $value:ident => $content:expr;)+) => {
        $(impl<$($generics)*> ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                let $value = self;
                $content.feed(sink);
            }
        })+
    };
}

// Shared content counts like separate content.
content_as! {
    [] bool: x => u8::from(*x);
    [] usize: x => *x as u64;
    [] String: x => x.as_str();
    [] DVec2: x => x.to_array();
    [] DVec3: x => x.to_array();
    [] DQuat: x => x.to_array();
    [] DMat3: x => x.to_cols_array();
    [] DAffine3: x => x.to_cols_array();
    [T: ContentBytes] Vec<T>: x => x.as_slice();
    [T: ContentBytes + ?Sized] Box<T>: x => **x;
    [T: ContentBytes + ?Sized] Arc<T>: x => **x;
}

impl ContentBytes for str {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.len().feed(sink);
        sink(self.as_bytes());
    }
}

impl<T: ContentBytes> ContentBytes for [T] {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.len().feed(sink);
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<T: ContentBytes, const N: usize> ContentBytes for [T; N] {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<T: ContentBytes> ContentBytes for Option<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.is_some().feed(sink);
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<A: ContentBytes, B: ContentBytes> ContentBytes for (A, B) {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.0.feed(sink);
        self.1.feed(sink);
    }
}
