//! What names stand for in a file: nodes by `DEF`, prototypes by `PROTO`.

use super::tree::{Prototype, VrmlNode};
use std::collections::HashMap;
use std::rc::Rc;

/// The names of a file, and of the prototypes inside whose bodies a reader is.
///
/// A later definition of a name hides an earlier one. The standard hides what is outside a
/// prototype from its inside; here it is found if nothing inside has the name, as many files
/// expect.
pub(super) struct NameScopes {
    /// The file's own, then those of open prototypes, the innermost last.
    scopes: Vec<NameScope>,
}

#[derive(Default)]
struct NameScope {
    nodes: HashMap<Rc<str>, Rc<VrmlNode>>,
    protos: HashMap<Rc<str>, Rc<Prototype>>,
    /// The same in the order of the file.
    in_order: Vec<Rc<Prototype>>,
}

impl NameScopes {
    /// No names.
    pub fn new() -> NameScopes {
        NameScopes {
            scopes: vec![NameScope::default()],
        }
    }

    /// Goes into the body of a prototype.
    pub fn enter(&mut self) {
        self.scopes.push(NameScope::default());
    }

    /// Comes out of the body of a prototype, whose names are forgotten.
    pub fn leave(&mut self) {
        self.scopes.pop();
    }

    fn innermost(&mut self) -> Option<&mut NameScope> {
        self.scopes.last_mut()
    }

    /// Names a node.
    pub fn define(&mut self, name: Rc<str>, node: Rc<VrmlNode>) {
        if let Some(scope) = self.innermost() {
            scope.nodes.insert(name, node);
        }
    }

    /// Adds a prototype.
    pub fn define_proto(&mut self, proto: Prototype) {
        let proto = Rc::new(proto);
        if let Some(scope) = self.innermost() {
            scope.in_order.push(proto.clone());
            scope.protos.insert(proto.name.clone(), proto);
        }
    }

    /// The node of that name.
    pub fn node(&self, name: &str) -> Option<Rc<VrmlNode>> {
        let mut scopes = self.scopes.iter().rev();
        scopes.find_map(|scope| scope.nodes.get(name)).cloned()
    }

    /// The prototype of that name.
    pub fn proto(&self, name: &str) -> Option<Rc<Prototype>> {
        let mut scopes = self.scopes.iter().rev();
        scopes.find_map(|scope| scope.protos.get(name)).cloned()
    }

    /// The prototypes of the file, in its order.
    pub fn into_protos(mut self) -> Vec<Rc<Prototype>> {
        self.scopes.swap_remove(0).in_order
    }
}
