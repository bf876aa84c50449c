//! Tables, and what is wrong with them.

use super::*;
use crate::enclosure::tests::two_squares;
use crate::thermal::bands::SpectralRange;
use crate::thermal::network::RowCondition;

fn materials(text: &str) -> MaterialTable {
    MaterialTable::read(text).unwrap()
}

#[test]
fn a_grey_table_in_three_formats() {
    let enclosure = two_squares();
    let expected = vec![vec![
        Properties {
            emissivity: 0.9,
            mirror: 0.0,
        },
        Properties {
            emissivity: 0.05,
            mirror: 0.9,
        },
    ]];
    for text in [
        "name,eps,rho_s\nfloor,0.9,\nlid,0.05,0.9\n",
        "# a comment\nname\teps\trho_s\n\n\"floor\"\t.9\t\nli?\t5e-2\t.9\n",
        "[floor]\neps = 0.9\n[lid]\neps = 0.05\nrho_s = 0.9\n",
        "name;eps;rho_s\n*;0.05;0.9\nfloor/3;0.9;0\n",
    ] {
        let table = materials(text);
        assert_eq!(table.of_rows(&enclosure).unwrap(), expected, "{text}");
        assert!(table.unused(&enclosure).is_empty());
    }
}

#[test]
fn the_narrowest_name_counts() {
    let enclosure = two_squares();
    let table = materials("name,eps\n*,0.1\ngrey,0.2\nfl*,0.3\nlid/0 (back),0.4\nnobody,0.5\n");
    let records = table.of_rows(&enclosure).unwrap();
    // An exact name of the material comes before a pattern of the object.
    let emissivities: Vec<f64> = records[0].iter().map(|p| p.emissivity).collect();
    assert_eq!(emissivities, [0.2, 0.4]);
    assert_eq!(table.unused(&enclosure), ["fl*", "nobody"]);
}

#[test]
fn bands_are_sorted_and_the_sun_is_last() {
    let table = materials(
        "name,alpha,eps@4-inf,eps@0-4,rho_s,rho_s@0-4,rho_s@solar\n*,0.2,0.8,0.1,0.2,0.5,0\n",
    );
    let ranges: Vec<SpectralRange> = table.bands.iter().map(|b| b.range).collect();
    let expected = [
        SpectralRange::Between(0.0, 4.0),
        SpectralRange::Between(4.0, f64::INFINITY),
        SpectralRange::Solar,
    ];
    assert_eq!(ranges, expected);
    let records = table.of_rows(&two_squares()).unwrap();
    let first: Vec<[f64; 2]> = records
        .iter()
        .map(|b| [b[0].emissivity, b[0].mirror])
        .collect();
    assert_eq!(first, [[0.1, 0.5], [0.8, 0.2], [0.2, 0.0]]);
}

#[test]
fn bands_are_numbers_however_they_are_written() {
    let table = materials("name,eps@0.0-4,eps@ 4.0 - inf,rho_s@0-4.00\n*,0.1,0.8,0.5\n");
    assert_eq!(table.bands.len(), 2);
    let records = table.of_rows(&two_squares()).unwrap();
    let first: Vec<[f64; 2]> = (records.iter())
        .map(|b| [b[0].emissivity, b[0].mirror])
        .collect();
    assert_eq!(first, [[0.1, 0.5], [0.8, 0.0]]);
}

#[test]
fn numbers_of_programs_make_the_same_tables() {
    let number = |name: &str, column: &str, x: f64| (name.to_owned(), vec![(column.to_owned(), x)]);
    let enclosure = two_squares();
    let numbers = [number("*", "eps", 0.3), number("lid", "eps", 0.9)];
    let table = MaterialTable::from_numbers(&numbers).unwrap();
    let same = materials("name,eps\n*,0.3\nlid,0.9\n");
    assert_eq!(table.of_rows(&enclosure), same.of_rows(&enclosure));
    let wrong = MaterialTable::from_numbers(&[number("lid", "eps", f64::NAN)]);
    let message = wrong.unwrap_err().to_string();
    assert!(
        message.contains("materials: eps of \"lid\" is NaN"),
        "{message}"
    );

    // A surface may be called as the surroundings are.
    let numbers = [number("*", "T", 300.0), number("ground", "q", 0.0)];
    let table = BoundaryTable::from_numbers(&numbers).unwrap();
    assert_eq!(table.surroundings, [None, None]);
    assert_eq!(table.unused(&enclosure), ["ground"]);
}

#[test]
fn named_values_are_for_some_rows() {
    let enclosure = two_squares();
    let value = |name: &str, x: f64| (name.to_owned(), x);
    let values = NamedValues::new(&[value("lid", 2.0), value("nobody", 1.0)], "solar").unwrap();
    assert_eq!(values.of_rows(&enclosure), [None, Some(2.0)]);
    assert_eq!(values.unused(&enclosure), ["nobody"]);
    let twice = NamedValues::new(&[value("lid", 2.0), value("lid", 1.0)], "solar");
    assert!(twice.unwrap_err().to_string().contains("is there already"));
    let wrong = NamedValues::new(&[value("lid", f64::INFINITY)], "solar");
    let message = wrong.unwrap_err().to_string();
    assert!(message.contains("solar of \"lid\" is inf"), "{message}");
}

#[test]
fn bad_materials_say_where_and_what() {
    for (text, expected) in [
        ("", "the table is empty"),
        ("eps,rho\n1,2\n", "expected a column `name`"),
        ("name,eps\nfloor\n", "line 2: 1 values, expected 2"),
        (
            "name,eps\nfloor,1.5\n",
            "line 2: eps of \"floor\" is 1.5, expected 0 to 1",
        ),
        (
            "name,eps\nfloor,grey\n",
            "line 2: eps of \"floor\" is \"grey\", expected a number",
        ),
        ("name,eps\nfloor,nan\n", "is NaN, expected a finite number"),
        (
            "name,eps,rho_s\nfloor,0.6,0.5\n",
            "eps + rho_s of \"floor\" is 1.1, expected at most 1",
        ),
        ("name,rho_s\nfloor,0.6\n", "there is no emissivity"),
        ("name,eps\n*,\n", "there is no emissivity"),
        ("name,eps\n*,1\na,\n", "\"a\" has no eps"),
        ("name,eps,shine\n*,1,2\n", "there is no column \"shine\""),
        ("name,eps\na,1\na,1\n", "line 3: \"a\" is there already"),
        ("name,eps,eps@0-4\n*,1,1\n", "expected one or the other"),
        ("name,eps@4-0\n*,1\n", "is not a range of wavelengths"),
        ("name,eps@0-4,eps@5-inf\n*,1,1\n", "between 4 and 5 µm"),
        ("name,eps@0-4\n*,1\n", "bands end at 4 µm"),
        ("[a\neps=1", "TOML"),
    ] {
        let message = MaterialTable::read(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
    let records = materials("name,eps\nlid,1\n").of_rows(&two_squares());
    let message = records.unwrap_err().to_string();
    assert!(
        message.contains("nothing says the emissivity of \"floor\""),
        "{message}"
    );
}

#[test]
fn boundaries_and_surroundings() {
    let table = "name,T,T_C,q,solar\nfloor,,20,,500\n*,,,0,\nspace,3,,,\nground,,10,,\n";
    let table = BoundaryTable::read(table).unwrap();
    assert_eq!(table.surroundings, [Some(3.0), Some(283.15)]);
    let records = table.of_rows(&two_squares()).unwrap();
    let expected = [RowCondition::Temperature(293.15), RowCondition::Flux(0.0)];
    assert_eq!(records.rows, expected);
    assert_eq!(records.solar, [Some(500.0), None]);
    let toml = "[sky]\nT = 250\n[floor]\nadiabatic = true\n[lid]\nq = -5\n";
    let table = BoundaryTable::read(toml).unwrap();
    assert_eq!(table.surroundings, [Some(250.0), None]);
    let records = table.of_rows(&two_squares()).unwrap();
    assert_eq!(
        records.rows,
        [RowCondition::Flux(0.0), RowCondition::Flux(-5.0)]
    );
}

#[test]
fn bad_boundaries_say_where_and_what() {
    for (text, expected) in [
        (
            "name,T\nfloor,-1\n",
            "line 2: T of \"floor\" is -1, expected at least 0",
        ),
        (
            "name,T,T_C\nfloor,300,20\n",
            "line 2: T of \"floor\" is 300, expected no T beside T_C",
        ),
        (
            "name,T_C\nfloor,-300\n",
            "is -300, expected at least -273.15",
        ),
        ("name,T,q\nfloor,300,1\n", "given beside q"),
        ("name,T,q\nfloor,,\n", "expected T in kelvin, or q in W/m²"),
        ("name,T,q\nsky,,1\n", "T of \"sky\" is missing"),
        ("name,T,solar\na,300,-1\n", "0 or more"),
        ("name,T,c\na,300,1\n", "there is no column \"c\""),
    ] {
        let message = BoundaryTable::read(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
}
