//! Named contexts: the colours, materials and vertices that statements define and later ones use.

use std::collections::HashMap;
use std::rc::Rc;

/// All contexts of one type. One of them is current; the first is unnamed.
#[derive(Debug)]
pub(super) struct ContextTable<T> {
    list: Vec<(Rc<[u8]>, T)>,
    by_name: HashMap<Rc<[u8]>, usize>,
    current: usize,
}

/// An error in a statement that selects a context.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum ContextError<'a> {
    /// The arguments have none of the four forms.
    Form,
    /// The name is undefined; a default takes its place.
    Undefined(&'a [u8]),
}

impl<T: Clone + Default> ContextTable<T> {
    /// Only the unnamed context.
    pub fn new() -> ContextTable<T> {
        ContextTable {
            list: vec![(Rc::from(*b""), T::default())],
            by_name: HashMap::new(),
            current: 0,
        }
    }

    /// Name and value of the current context.
    pub fn current(&mut self) -> (&[u8], &mut T) {
        let (name, value) = &mut self.list[self.current];
        (name, value)
    }

    /// The value of a named context.
    pub fn get(&self, name: &[u8]) -> Option<&T> {
        self.by_name.get(name).map(|&i| &self.list[i].1)
    }

    /// All named contexts, in the order of their first definition.
    pub fn named(&mut self) -> impl Iterator<Item = (&[u8], &mut T)> {
        self.list[1..]
            .iter_mut()
            .map(|(name, value)| (&**name, value))
    }

    /// Makes a context current, given the words after the keyword: none, `id`, `id =` or `id =
    /// template`. `undefined` makes the default for an undefined name.
    ///
    /// # Errors
    /// [`ContextError::Form`], with no change; [`ContextError::Undefined`], with the default
    /// current under its new name.
    pub fn choose<'a>(
        &mut self,
        words: &[&'a [u8]],
        undefined: impl FnOnce() -> T,
    ) -> Result<(), ContextError<'a>> {
        match *words {
            [] => {
                self.list[0].1 = T::default();
                self.current = 0;
                Ok(())
            }
            [name] => match self.by_name.get(name) {
                Some(&known) => {
                    self.current = known;
                    Ok(())
                }
                None => {
                    self.define(name, undefined());
                    Err(ContextError::Undefined(name))
                }
            },
            [name, b"="] => {
                self.define(name, T::default());
                Ok(())
            }
            [name, b"=", template] => match self.get(template).cloned() {
                Some(value) => {
                    self.define(name, value);
                    Ok(())
                }
                None => {
                    self.define(name, undefined());
                    Err(ContextError::Undefined(template))
                }
            },
            _ => Err(ContextError::Form),
        }
    }

    fn define(&mut self, name: &[u8], value: T) {
        self.current = match self.by_name.get(name) {
            Some(&known) => {
                self.list[known].1 = value;
                known
            }
            None => {
                let name: Rc<[u8]> = Rc::from(name);
                self.list.push((Rc::clone(&name), value));
                self.by_name.insert(name, self.list.len() - 1);
                self.list.len() - 1
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose<'a>(
        contexts: &mut ContextTable<i32>,
        words: &'a str,
    ) -> Result<(), ContextError<'a>> {
        let words: Vec<&[u8]> = words.split_ascii_whitespace().map(str::as_bytes).collect();
        contexts.choose(&words, || -1)
    }

    #[test]
    fn the_four_forms() {
        let mut c = ContextTable::new();
        *c.current().1 = 5;
        assert_eq!(choose(&mut c, "a ="), Ok(()));
        assert_eq!(c.current(), (&b"a"[..], &mut 0));
        *c.current().1 = 7;
        assert_eq!(choose(&mut c, "b = a"), Ok(()));
        assert_eq!(c.current(), (&b"b"[..], &mut 7));
        *c.current().1 = 8;
        assert_eq!(
            (c.get(b"a"), c.get(b"b"), c.get(b"c")),
            (Some(&7), Some(&8), None)
        );
        assert_eq!(choose(&mut c, "a"), Ok(()));
        assert_eq!(*c.current().1, 7);
        assert_eq!(choose(&mut c, "a = a"), Ok(()));
        assert_eq!(*c.current().1, 7);
        assert_eq!(choose(&mut c, "a ="), Ok(()));
        assert_eq!(*c.current().1, 0);
        assert_eq!(choose(&mut c, ""), Ok(()));
        assert_eq!(c.current(), (&b""[..], &mut 0));
        assert_eq!(c.named().map(|(_, v)| *v).collect::<Vec<_>>(), [0, 8]);
    }

    #[test]
    fn what_is_missing_has_a_stand_in() {
        let mut c = ContextTable::new();
        assert_eq!(choose(&mut c, "a"), Err(ContextError::Undefined(b"a")));
        assert_eq!(*c.current().1, -1);
        assert_eq!(choose(&mut c, "a"), Ok(()));
        assert_eq!(choose(&mut c, "b = c"), Err(ContextError::Undefined(b"c")));
        assert_eq!(c.current(), (&b"b"[..], &mut -1));
        assert_eq!(choose(&mut c, "b is c"), Err(ContextError::Form));
        assert_eq!(choose(&mut c, "b = c d"), Err(ContextError::Form));
        assert_eq!(c.current(), (&b"b"[..], &mut -1));
    }
}
