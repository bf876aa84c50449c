//! Radiative conductances between nodes, as thermal networks read them.
//!
//! GR_ij = ε_i A_i B_ij, in m²: from node i to node j flows σ GR_ij (T_i⁴ − T_j⁴).

use crate::files::text::{comment, csv_field, exponential, general};
use crate::thermal::network::STEFAN_BOLTZMANN;
use std::io::{self, Write};
use std::path::Path;

/// Conductances between nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conductances {
    /// The name of each node.
    pub names: Vec<String>,
    /// The area of each node, in m².
    pub areas: Vec<f64>,
    /// The emissivity of each node, if it has one of its own.
    pub eps: Option<Vec<f64>>,
    /// Conductances between different nodes, each pair once.
    pub pairs: Vec<NodePair>,
    /// What surrounds the nodes.
    pub space: Vec<SpaceNode>,
}

/// A conductance between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodePair {
    /// The nodes, the smaller first.
    pub nodes: [u32; 2],
    /// GR, in m².
    pub gr: f64,
    /// Its standard error.
    pub error: f64,
}

/// Surroundings that radiate as a black body: deep space, the sky, the ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpaceNode {
    /// Its name.
    pub name: String,
    /// Its temperature in kelvin; that of deep space if it is not known.
    pub temperature: Option<f64>,
    /// GR of each node with it in m², and its standard error; zeros are left out.
    pub gr: Vec<(f64, f64)>,
}

/// Formats of conductances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConductanceFormat {
    /// One line per pair.
    Csv,
    /// Blocks of an ESATAN model.
    Esatan,
    /// A block of SINDA's conductor data.
    Sinda,
}

impl ConductanceFormat {
    /// The format that a file's extension means: `.csv`, `.esatan`, `.sinda`.
    pub fn from_path(path: &Path) -> Option<ConductanceFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "csv" => Some(ConductanceFormat::Csv),
            "esatan" => Some(ConductanceFormat::Esatan),
            "sinda" => Some(ConductanceFormat::Sinda),
            _ => None,
        }
    }
}

/// What the formats need to know beyond the numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ConductanceOptions {
    /// The model or submodel of the nodes; none if empty.
    pub model: String,
    /// Temperature at which ESATAN's nodes start, in °C.
    pub temperature: f64,
    /// Whether SINDA's values are multiplied by σ, in W/K⁴, for models whose `SIGMA` is 1.
    pub sigma: bool,
    /// The band of the conductances, in a column of its own of CSV, if they are not for all wavelengths.
    pub band: Option<String>,
    /// Whether CSV begins with the names of its columns: not if it continues a list of another band.
    pub with_header: bool,
}

impl Default for ConductanceOptions {
    fn default() -> ConductanceOptions {
        ConductanceOptions {
            model: String::new(),
            temperature: 20.0,
            sigma: false,
            band: None,
            with_header: true,
        }
    }
}

/// Deep space, and 0 °C, in kelvin.
const DEEP_SPACE: f64 = 3.0;
const ZERO_CELSIUS: f64 = 273.15;

/// Digits of a conductance.
const DIGITS: usize = 7;

/// Characters of a node's name in ESATAN, and of each of both names in a comment: lines stay below
/// 80 columns.
const LABEL: usize = 24;
const SHORT: usize = 16;

/// Writes conductances.
///
/// # Errors
/// Those of writing.
pub fn write(
    list: &Conductances,
    format: ConductanceFormat,
    options: &ConductanceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        ConductanceFormat::Csv => write_csv(list, options, out),
        ConductanceFormat::Esatan => write_esatan(list, options, out),
        ConductanceFormat::Sinda => write_sinda(list, options, out),
    }
}

/// Numbers of nodes, and of what surrounds them.
struct NodeNumbers {
    nodes: Vec<u32>,
    space: Vec<u32>,
}

impl NodeNumbers {
    /// The numbers that nodes are named by, if all are; else 1, 2, 3. Surroundings are counted from
    /// 99999 down.
    fn new(list: &Conductances) -> NodeNumbers {
        let numbers: Option<Vec<u32>> = list.names.iter().map(|n| n.parse().ok()).collect();
        let is_good = |numbers: &Vec<u32>| {
            let different: std::collections::HashSet<_> = numbers.iter().collect();
            different.len() == numbers.len() && !numbers.contains(&0)
        };
        let count = list.names.len() as u32;
        let nodes = numbers
            .filter(is_good)
            .unwrap_or_else(|| (1..=count).collect());
        let most = nodes.iter().copied().max().unwrap_or(0);
        let needed = most.saturating_add(list.space.len() as u32);
        let last = [99_999, 999_999, 99_999_999]
            .into_iter()
            .find(|&l| l > needed);
        let last = last.unwrap_or(u32::MAX);
        let space = (0..list.space.len() as u32).map(|k| last - k).collect();
        NodeNumbers { nodes, space }
    }
}

/// Both numbers, value and comment of each conductance.
fn each(
    list: &Conductances,
    mut write: impl FnMut([u32; 2], f64, String) -> io::Result<()>,
) -> io::Result<()> {
    let numbers = NodeNumbers::new(list);
    let names = |a: &str, b: &str| format!("{} - {}", comment(a, SHORT), comment(b, SHORT));
    for pair in &list.pairs {
        let [a, b] = pair.nodes.map(|n| n as usize);
        let words = names(&list.names[a], &list.names[b]);
        write([numbers.nodes[a], numbers.nodes[b]], pair.gr, words)?;
    }
    for (space, number) in list.space.iter().zip(&numbers.space) {
        let seen = space.gr.iter().enumerate().filter(|(_, gr)| gr.0 != 0.0);
        for (i, (gr, _)) in seen {
            let words = names(&list.names[i], &space.name);
            write([numbers.nodes[i], *number], *gr, words)?;
        }
    }
    Ok(())
}

/// One line per pair, surroundings last.
fn write_csv(
    list: &Conductances,
    options: &ConductanceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (title, band) = match &options.band {
        Some(band) => ("band_um,", format!("{},", csv_field(band))),
        None => ("", String::new()),
    };
    if options.with_header {
        writeln!(out, "{title}from,to,gr_m2,std_error")?;
    }
    let names = &list.names;
    for NodePair { nodes, gr, error } in &list.pairs {
        let [a, b] = nodes.map(|n| csv_field(&names[n as usize]));
        writeln!(out, "{band}{a},{b},{gr},{}", general(*error, 3))?;
    }
    for space in &list.space {
        let to = csv_field(&space.name);
        for (name, (gr, error)) in names.iter().zip(&space.gr).filter(|(_, gr)| gr.0 != 0.0) {
            let name = csv_field(name);
            writeln!(out, "{band}{name},{to},{gr},{}", general(*error, 3))?;
        }
    }
    Ok(())
}

/// ESATAN's `$NODES` and `$CONDUCTORS`, with values in m².
fn write_esatan(
    list: &Conductances,
    options: &ConductanceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let numbers = NodeNumbers::new(list);
    // Quotation marks end a label.
    let label = |name: &str| comment(name, LABEL).replace('\'', "_");
    writeln!(out, "$NODES")?;
    for (i, name) in list.names.iter().enumerate() {
        let (number, area) = (numbers.nodes[i], list.areas[i]);
        write!(
            out,
            "D{number} = '{}', T = {}",
            label(name),
            real(options.temperature)
        )?;
        write!(out, ", A = {}", real(area))?;
        let eps = list.eps.as_ref().map(|eps| eps[i]);
        eps.map_or(Ok(()), |eps| write!(out, ", EPS = {}", real(eps)))?;
        writeln!(out, ";")?;
    }
    for (space, number) in list.space.iter().zip(&numbers.space) {
        let celsius = space.temperature.unwrap_or(DEEP_SPACE) - ZERO_CELSIUS;
        writeln!(
            out,
            "B{number} = '{}', T = {};",
            label(&space.name),
            real(celsius)
        )?;
    }
    writeln!(out, "$CONDUCTORS")?;
    let model = match options.model.as_str() {
        "" => String::new(),
        name => format!("{name}:"),
    };
    each(list, |[a, b], gr, words| {
        let gr = exponential(gr, DIGITS);
        writeln!(out, "GR({model}{a}, {model}{b}) = {gr}; # {words}")
    })
}

/// SINDA's conductor data: negative numbers are radiation.
fn write_sinda(
    list: &Conductances,
    options: &ConductanceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let numbers = NodeNumbers::new(list);
    let (factor, unit) = if options.sigma {
        (STEFAN_BOLTZMANN, "W/K4")
    } else {
        (1.0, "m2, times SIGMA")
    };
    writeln!(out, "C Radiative conductances in {unit}")?;
    for (number, name) in numbers.nodes.iter().zip(&list.names) {
        writeln!(out, "C node {number} = {}", comment(name, LABEL))?;
    }
    for (number, space) in numbers.space.iter().zip(&list.space) {
        let name = comment(&space.name, LABEL);
        writeln!(
            out,
            "C node {number} = {name}, which the node data must have as a boundary"
        )?;
    }
    match options.model.as_str() {
        "" => writeln!(out, "HEADER CONDUCTOR DATA")?,
        model => writeln!(out, "HEADER CONDUCTOR DATA, {model}")?,
    }
    let mut number = 0;
    each(list, |[a, b], gr, words| {
        number += 1;
        let gr = exponential(gr * factor, DIGITS);
        writeln!(out, "      -{number}, {a}, {b}, {gr} $ {words}")
    })
}

/// A real number, which has a decimal point.
fn real(x: f64) -> String {
    let text = general(x, DIGITS);
    if text.contains(['.', 'e']) {
        text
    } else {
        text + ".0"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plates() -> Conductances {
        Conductances {
            names: vec!["plate".into(), "lid, 'top'".into()],
            areas: vec![1.0, 0.5],
            eps: Some(vec![0.8, 0.05]),
            pairs: vec![NodePair {
                nodes: [0, 1],
                gr: 0.27906976744186,
                error: 0.001,
            }],
            space: vec![SpaceNode {
                name: "space".into(),
                temperature: None,
                gr: vec![(0.5, 0.002), (0.0, 0.0)],
            }],
        }
    }

    fn check(
        list: &Conductances,
        format: ConductanceFormat,
        options: &ConductanceOptions,
        expected: &str,
    ) {
        let mut out = Vec::new();
        write(list, format, options, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text, expected);
        assert!(text.lines().all(|line| line.len() < 80));
    }

    #[test]
    fn esatan() {
        let options = ConductanceOptions::default();
        check(
            &plates(),
            ConductanceFormat::Esatan,
            &options,
            "$NODES\nD1 = 'plate', T = 20.0, A = 1.0, EPS = 0.8;\n\
             D2 = 'lid, _top_', T = 20.0, A = 0.5, EPS = 0.05;\nB99999 = 'space', T = -270.15;\n\
             $CONDUCTORS\nGR(1, 2) = 2.790698E-01; # plate - lid, 'top'\n\
             GR(1, 99999) = 5.000000E-01; # plate - space\n",
        );
        let mut list = plates();
        list.names = vec!["10".into(), "99999".into()];
        list.eps = None;
        list.space[0].temperature = Some(253.15);
        let options = ConductanceOptions {
            model: "SAT".into(),
            temperature: -3.5,
            ..options
        };
        check(
            &list,
            ConductanceFormat::Esatan,
            &options,
            "$NODES\nD10 = '10', T = -3.5, A = 1.0;\nD99999 = '99999', T = -3.5, A = 0.5;\n\
             B999999 = 'space', T = -20.0;\n$CONDUCTORS\n\
             GR(SAT:10, SAT:99999) = 2.790698E-01; # 10 - 99999\n\
             GR(SAT:10, SAT:999999) = 5.000000E-01; # 10 - space\n",
        );
    }

    #[test]
    fn long_names_fit_lines() {
        let mut list = plates();
        list.names = vec!["x".repeat(99), "y".repeat(99)];
        let mut out = Vec::new();
        let options = ConductanceOptions::default();
        write(&list, ConductanceFormat::Esatan, &options, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.lines().all(|line| line.len() < 80), "{text}");
    }

    #[test]
    fn sinda() {
        let options = ConductanceOptions {
            model: "SAT".into(),
            sigma: true,
            ..ConductanceOptions::default()
        };
        check(
            &plates(),
            ConductanceFormat::Sinda,
            &options,
            "C Radiative conductances in W/K4\nC node 1 = plate\nC node 2 = lid, 'top'\n\
             C node 99999 = space, which the node data must have as a boundary\n\
             HEADER CONDUCTOR DATA, SAT\n      -1, 1, 2, 1.582430E-08 $ plate - lid, 'top'\n      \
             -2, 1, 99999, 2.835187E-08 $ plate - space\n",
        );
    }

    #[test]
    fn csv() {
        check(
            &plates(),
            ConductanceFormat::Csv,
            &ConductanceOptions::default(),
            "from,to,gr_m2,std_error\nplate,\"lid, 'top'\",0.27906976744186,0.001\n\
             plate,space,0.5,0.002\n",
        );
        for (name, expected) in [
            ("a.CSV", Some(ConductanceFormat::Csv)),
            ("a.esatan", Some(ConductanceFormat::Esatan)),
            ("a.sinda", Some(ConductanceFormat::Sinda)),
            ("a", None),
        ] {
            assert_eq!(ConductanceFormat::from_path(Path::new(name)), expected);
        }
    }
}
