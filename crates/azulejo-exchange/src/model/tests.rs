//! Models of tables against closed forms.

use super::*;
use crate::enclosure::unique;
use crate::network::RowCondition;
use crate::network::tests::enclosure_of;
use crate::tables::{BoundaryTable, NamedValues};

/// Two plates that see nothing but each other, one of two rows.
fn plates() -> Arc<Enclosure> {
    let s = [
        vec![0.0, 0.0, 1.0],
        vec![0.0, 0.0, 1.0],
        vec![1.0, 1.0, 0.0],
    ];
    let mut enclosure = enclosure_of(&[1.0, 1.0, 2.0], &s, &[0.0; 3]);
    enclosure.rows.names = unique(["a", "a", "b"].map(str::to_owned).into());
    Arc::new(enclosure)
}

fn table(numbers: &[(&str, &[(&str, f64)])]) -> MaterialTable {
    let record = |(name, fields): &(&str, &[(&str, f64)])| {
        let fields = fields.iter().map(|(c, x)| ((*c).to_owned(), *x));
        ((*name).to_owned(), fields.collect())
    };
    let records: Vec<_> = numbers.iter().map(record).collect();
    MaterialTable::from_numbers(&records).unwrap()
}

fn two_nodes() -> Groups {
    Groups {
        of_rows: vec![Some(0), Some(0), Some(1)],
        names: vec!["a".to_owned(), "b".to_owned()],
    }
}

const PLATES: &[(&str, &[(&str, f64)])] = &[("a *", &[("eps", 0.3)]), ("b", &[("eps", 0.8)])];

#[test]
fn plates_exchange_as_their_formula_says_lumped_or_not() {
    let expected = 2.0 / (1.0 / 0.3 + 1.0 / 0.8 - 1.0);
    for lump in [false, true] {
        let model = ThermalModel::new(vec![plates()], &table(PLATES), two_nodes(), lump).unwrap();
        assert_eq!(model.enclosure().len(), if lump { 2 } else { 3 });
        let networks = model.networks(&Progress::new()).unwrap();
        let (gr, _) = networks[0].1.conductance(0, 1);
        assert!((gr - expected).abs() < 1e-12, "{gr}, expected {expected}");
        let given = Conditions {
            rows: vec![RowCondition::Temperature(400.0); 3],
            solar: vec![None; 3],
        };
        let given = model.conditions(given).unwrap();
        let heat = model.heat(&given, [SPACE; 2], &Progress::new()).unwrap();
        assert!(heat.node_heat.iter().all(|q| q.abs() < 1e-9));
    }
}

#[test]
fn uneven_nodes_and_other_mirrors_are_refused() {
    let model = |numbers: &[(&str, &[(&str, f64)])], lump: bool| {
        let error = ThermalModel::new(vec![plates()], &table(numbers), two_nodes(), lump);
        error.unwrap_err().to_string()
    };
    let uneven = model(&[("a #0", &[("eps", 0.5)]), ("*", &[("eps", 0.25)])], true);
    assert!(uneven.contains("\"a\" have eps from 0.25 to 0.5"), "{uneven}");
    let mirrors = model(&[("*", &[("eps", 0.5), ("rho_s", 0.25)])], false);
    assert!(mirrors.contains("reflectance 0 of \"a #0\", the table has 0.25"));
    let missing = model(&[("b", &[("eps", 0.5)])], false);
    assert!(missing.contains("nothing says the emissivity of \"a #0\""), "{missing}");
    let lumped = ThermalModel::new(vec![plates()], &table(PLATES), two_nodes(), true).unwrap();
    let mut rows = vec![RowCondition::Flux(0.0); 3];
    rows[1] = RowCondition::Flux(1.0);
    let solar = vec![None; 3];
    assert!(lumped.conditions(Conditions { rows, solar }).is_err());
}

#[test]
fn numbers_are_checked_as_tables_are() {
    let fails = |column: &str, x: f64| {
        let record = ("a".to_owned(), vec![(column.to_owned(), x)]);
        MaterialTable::from_numbers(&[record]).unwrap_err().to_string()
    };
    assert_eq!(
        fails("eps", 1.5),
        "materials: eps of \"a\" is 1.5, expected 0 to 1"
    );
    assert!(fails("eps", f64::NAN).contains("a finite number"));
    let both = vec![("T".to_owned(), 300.0), ("q".to_owned(), 0.0)];
    let both = BoundaryTable::from_numbers(&[("a".to_owned(), both)]);
    assert!(both.unwrap_err().to_string().contains("given beside q"));
    let values = [("a *".to_owned(), 2.0), ("c".to_owned(), 3.0)];
    let values = NamedValues::new(&values, "solar").unwrap();
    assert_eq!(values.of_rows(&plates()), [Some(2.0), Some(2.0), None]);
    assert_eq!(values.unused(&plates()), ["c"]);
    assert!(NamedValues::new(&[("a".to_owned(), f64::NAN)], "solar").is_err());
}

#[test]
fn lost_light_can_be_given_to_the_sky() {
    let mut enclosure = Enclosure::clone(&plates());
    enclosure.factors.rest[1].hidden = 0.25;
    assert_eq!(lost(&enclosure), 0.25);
    give_lost_to_sky(&mut enclosure);
    assert_eq!((lost(&enclosure), enclosure.factors.rest[1].sky), (0.0, 0.25));
}

#[test]
fn files_have_their_formats() {
    let model = ThermalModel::new(vec![plates()], &table(PLATES), two_nodes(), false).unwrap();
    let networks = model.networks(&Progress::new()).unwrap();
    let mut result = ThermalResult::new(&model, networks, None, [SPACE; 2]);
    let text = |result: &ThermalResult, format| {
        let mut bytes = Vec::new();
        let list = ConductanceList::default();
        result.write(format, &list, &mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let csv = text(&result, ThermalResultFormat::Csv);
    assert!(csv.starts_with("from,to,gr_m2,std_error\na,b,0.5"), "{csv}");
    assert!(text(&result, ThermalResultFormat::Esatan).contains("$CONDUCTORS"));
    assert!(text(&result, ThermalResultFormat::Archive).contains("script_F"));
    assert_eq!(result.node_areas(), [2.0, 2.0]);
    let given = Conditions {
        rows: vec![RowCondition::Temperature(400.0); 3],
        solar: vec![None; 3],
    };
    result.heat = Some(model.heat(&given, [SPACE; 2], &Progress::new()).unwrap());
    let csv = text(&result, ThermalResultFormat::Csv);
    assert!(csv.starts_with("name,area,T,T_error,Q,Q_error\na,2,400,0,"), "{csv}");
    let mut out = Vec::new();
    let vtu = result.write(ThermalResultFormat::Vtu, &ConductanceList::default(), &mut out);
    assert!(vtu.is_err(), "there are no polygons");
}
