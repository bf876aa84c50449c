//! Nodes as text, in the classic encoding of VRML97 or in X3D's XML.

use std::io::{self, BufWriter, Write};

/// A node to be written.
#[derive(Debug)]
pub(super) struct MarkupNode {
    pub kind: &'static str,
    pub def: Option<String>,
    /// The name of the node that stands here again; it has no fields then.
    pub reuse: Option<String>,
    pub fields: Vec<(&'static str, MarkupField)>,
}

/// The value of a field.
#[derive(Debug)]
pub(super) enum MarkupField {
    /// Numbers, or TRUE or FALSE.
    Value(String),
    /// Several of these.
    List(Vec<String>),
    /// Strings.
    Texts(Vec<String>),
    Node(Box<MarkupNode>),
    Nodes(Vec<MarkupNode>),
}

impl MarkupNode {
    pub fn new(kind: &'static str) -> MarkupNode {
        MarkupNode {
            kind,
            def: None,
            reuse: None,
            fields: Vec::new(),
        }
    }

    pub fn value(&mut self, field: &'static str, value: String) {
        self.fields.push((field, MarkupField::Value(value)));
    }

    pub fn list(&mut self, field: &'static str, list: Vec<String>) {
        self.fields.push((field, MarkupField::List(list)));
    }

    pub fn child(&mut self, field: &'static str, node: MarkupNode) {
        self.fields.push((field, MarkupField::Node(Box::new(node))));
    }

    fn classic(&self, depth: usize, out: &mut dyn Write) -> io::Result<()> {
        if let Some(name) = &self.reuse {
            return writeln!(out, "USE {name}");
        }
        if let Some(name) = &self.def {
            write!(out, "DEF {name} ")?;
        }
        writeln!(out, "{} {{", self.kind)?;
        let indent = "  ".repeat(depth + 1);
        for (field, value) in &self.fields {
            write!(out, "{indent}{field} ")?;
            match value {
                MarkupField::Value(value) => writeln!(out, "{value}")?,
                MarkupField::List(list) => {
                    writeln!(out, "[")?;
                    list.iter()
                        .try_for_each(|item| writeln!(out, "{indent}  {item},"))?;
                    writeln!(out, "{indent}]")?;
                }
                MarkupField::Texts(list) => {
                    let quoted: Vec<String> = list.iter().map(|t| quoted(t)).collect();
                    writeln!(out, "[ {} ]", quoted.join(", "))?;
                }
                MarkupField::Node(node) => node.classic(depth + 1, out)?,
                MarkupField::Nodes(nodes) => {
                    writeln!(out, "[")?;
                    for node in nodes {
                        write!(out, "{indent}  ")?;
                        node.classic(depth + 2, out)?;
                    }
                    writeln!(out, "{indent}]")?;
                }
            }
        }
        writeln!(out, "{}}}", "  ".repeat(depth))
    }

    fn xml(&self, depth: usize, out: &mut dyn Write) -> io::Result<()> {
        write!(out, "{}<{}", "  ".repeat(depth), self.kind)?;
        if let Some(name) = &self.reuse {
            return writeln!(out, " USE='{name}'/>");
        }
        if let Some(name) = &self.def {
            write!(out, " DEF='{name}'")?;
        }
        let mut children: Vec<&MarkupNode> = Vec::new();
        for (field, value) in &self.fields {
            match value {
                MarkupField::Value(value) => {
                    write!(out, " {field}='{}'", value.to_lowercase())?;
                }
                MarkupField::List(list) => {
                    write!(out, " {field}='")?;
                    for (k, item) in list.iter().enumerate() {
                        write!(out, "{}{item}", if k == 0 { "" } else { "\n" })?;
                    }
                    write!(out, "'")?;
                }
                MarkupField::Texts(list) => {
                    let quoted: Vec<String> = list.iter().map(|t| escaped(&quoted(t))).collect();
                    write!(out, " {field}='{}'", quoted.join(" "))?;
                }
                MarkupField::Node(node) => children.push(node),
                MarkupField::Nodes(nodes) => children.extend(nodes),
            }
        }
        if children.is_empty() {
            return writeln!(out, "/>");
        }
        writeln!(out, ">")?;
        children.iter().try_for_each(|c| c.xml(depth + 1, out))?;
        writeln!(out, "{}</{}>", "  ".repeat(depth), self.kind)
    }
}

/// A string between quotes, on one line.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Text for an attribute in single quotes.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('\'', "&apos;")
}

/// Writes a file of VRML97.
pub(super) fn write_classic(nodes: &[MarkupNode], out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(out, "#VRML V2.0 utf8\n# azulejo")?;
    nodes.iter().try_for_each(|n| n.classic(0, &mut out))?;
    out.flush()
}

/// Writes a file of X3D 3.3.
pub(super) fn write_xml(nodes: &[MarkupNode], out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    writeln!(
        out,
        "<?xml version='1.0' encoding='UTF-8'?>\n<X3D profile='Interchange' version='3.3'>\n\
         <head><meta name='generator' content='azulejo'/></head>\n<Scene>"
    )?;
    nodes.iter().try_for_each(|n| n.xml(1, &mut out))?;
    writeln!(out, "</Scene>\n</X3D>")?;
    out.flush()
}
