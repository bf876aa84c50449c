//! Rows combined to nodes before the exchange is solved.

use super::{ModelError, SAME, ThermalModel};
use crate::enclosure::Groups;
use crate::thermal::network::{ExchangeError, RowCondition};
use crate::thermal::tables::{Conditions, Properties};
use azulejo_trace::Progress;

/// Makes each node one row of a model, and returns these rows as nodes.
pub fn lump(
    model: &mut ThermalModel,
    groups: &Groups,
    progress: &Progress,
) -> Result<Groups, ModelError> {
    let areas = model.matrices[0].1.factors.areas.clone();
    for (_, rows) in &mut model.bands {
        let lump_property = |property: fn(&Properties) -> f64, what| {
            let values: Vec<f64> = rows.iter().map(property).collect();
            lumped(&values, &areas, groups, what)
        };
        let emissivities = lump_property(|p| p.emissivity, "eps")?;
        let mirrors = lump_property(|p| p.mirror, "rho_s")?;
        let pairs = emissivities.into_iter().zip(mirrors);
        *rows = pairs
            .map(|(emissivity, mirror)| Properties { emissivity, mirror })
            .collect();
    }
    for (_, enclosure) in &mut model.matrices {
        *enclosure = enclosure
            .gathered(groups, progress)
            .map_err(ExchangeError::from)?;
    }
    if let Some(conditions) = &mut model.conditions {
        *conditions = lumped_conditions(conditions, groups)?;
    }
    Ok(Groups {
        of_rows: (0..groups.names.len() as u32).map(Some).collect(),
        names: groups.names.clone(),
    })
}

/// The one value of each node.
fn lumped(
    values: &[f64],
    areas: &[f64],
    groups: &Groups,
    what: &'static str,
) -> Result<Vec<f64>, ModelError> {
    let mut node_values: Vec<Option<f64>> = vec![None; groups.names.len()];
    for ((&value, &area), group) in values.iter().zip(areas).zip(&groups.of_rows) {
        let Some(group) = group.filter(|_| area > 0.0).map(|g| g as usize) else {
            continue;
        };
        let known = *node_values[group].get_or_insert(value);
        if (known - value).abs() > SAME {
            return Err(ModelError::Uneven {
                node: groups.names[group].clone(),
                what,
                between: [known.min(value), known.max(value)],
            });
        }
    }
    let node_values = node_values.into_iter().map(Option::unwrap_or_default);
    Ok(node_values.collect())
}

/// The one condition of each node, and the sunlight on its rows.
fn lumped_conditions(conditions: &Conditions, groups: &Groups) -> Result<Conditions, ModelError> {
    let count = groups.names.len();
    let mut rows: Vec<Option<RowCondition>> = vec![None; count];
    let mut solar: Vec<Option<f64>> = vec![None; count];
    for (i, group) in groups.of_rows.iter().enumerate() {
        let Some(group) = group.map(|g| g as usize) else {
            continue;
        };
        let is_first = rows[group].is_none();
        let known = *rows[group].get_or_insert(conditions.rows[i]);
        let is_even = is_first || solar[group] == conditions.solar[i];
        if known != conditions.rows[i] || !is_even {
            return Err(ModelError::UnevenConditions {
                node: groups.names[group].clone(),
            });
        }
        solar[group] = conditions.solar[i];
    }
    let rows = rows.into_iter();
    Ok(Conditions {
        rows: rows
            .map(|row| row.unwrap_or(RowCondition::Flux(0.0)))
            .collect(),
        solar,
    })
}
