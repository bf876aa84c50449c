//! Name scopes of a file: nodes by `DEF`, prototypes by `PROTO`.

use super::tree::{Prototype, VrmlNode};
use std::collections::HashMap;
use std::rc::Rc;

/// The names of a file, and of the prototypes whose bodies are being read.
///
/// A later definition of a name hides an earlier one. In the standard, names outside of a prototype
/// are invisible inside it; here they are found if no inner name matches, as many files expect.
pub(super) struct NameScopes {
    /// The file's own scope, then those of open prototypes, the innermost last.
    scopes: Vec<NameScope>,
}

#[derive(Default)]
struct NameScope {
    nodes: HashMap<Rc<str>, Rc<VrmlNode>>,
    protos: HashMap<Rc<str>, Rc<Prototype>>,
    /// The prototypes of the file in their order.
    in_order: Vec<Rc<Prototype>>,
}

impl NameScopes {
    /// Empty scopes.
    pub fn new() -> NameScopes {
        NameScopes {
            scopes: vec![NameScope::default()],
        }
    }

    /// Enters the body of a prototype.
    pub fn enter(&mut self) {
        self.scopes.push(NameScope::default());
    }

    /// Leaves the body of a prototype and forgets its names.
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
