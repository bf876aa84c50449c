//! What names stand for in a file: nodes by `DEF`, prototypes by `PROTO`.

use super::tree::{Node, Proto};
use std::collections::HashMap;
use std::rc::Rc;

/// The names of a file, and of the prototypes inside whose bodies a reader is.
///
/// A later definition of a name hides an earlier one. The standard hides what is outside a
/// prototype from its inside; here it is found if nothing inside has the name, as many files
/// expect.
pub(super) struct Names {
    /// The file's own, then those of open prototypes, the innermost last.
    scopes: Vec<Scope>,
}

#[derive(Default)]
struct Scope {
    nodes: HashMap<Rc<str>, Rc<Node>>,
    protos: HashMap<Rc<str>, Rc<Proto>>,
    /// The same in the order of the file.
    in_order: Vec<Rc<Proto>>,
}

impl Names {
    /// No names.
    pub fn new() -> Names {
        Names {
            scopes: vec![Scope::default()],
        }
    }

    /// Goes into the body of a prototype.
    pub fn enter(&mut self) {
        self.scopes.push(Scope::default());
    }

    /// Comes out of the body of a prototype, whose names are forgotten.
    pub fn leave(&mut self) {
        self.scopes.pop();
    }

    fn innermost(&mut self) -> Option<&mut Scope> {
        self.scopes.last_mut()
    }

    /// Names a node.
    pub fn define(&mut self, name: Rc<str>, node: Rc<Node>) {
        if let Some(scope) = self.innermost() {
            scope.nodes.insert(name, node);
        }
    }

    /// Adds a prototype.
    pub fn define_proto(&mut self, proto: Proto) {
        let proto = Rc::new(proto);
        if let Some(scope) = self.innermost() {
            scope.in_order.push(proto.clone());
            scope.protos.insert(proto.name.clone(), proto);
        }
    }

    /// The node of that name.
    pub fn node(&self, name: &str) -> Option<Rc<Node>> {
        let mut scopes = self.scopes.iter().rev();
        scopes.find_map(|scope| scope.nodes.get(name)).cloned()
    }

    /// The prototype of that name.
    pub fn proto(&self, name: &str) -> Option<Rc<Proto>> {
        let mut scopes = self.scopes.iter().rev();
        scopes.find_map(|scope| scope.protos.get(name)).cloned()
    }

    /// The prototypes of the file, in its order.
    pub fn into_protos(mut self) -> Vec<Rc<Proto>> {
        self.scopes.swap_remove(0).in_order
    }
}
