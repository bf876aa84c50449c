//! Rows of a node combined to one, before the exchange is solved.

use super::{ModelError, SAME, ThermalModel};
use crate::enclosure::Groups;
use crate::network::RowCondition;
use crate::tables::Conditions;
use std::sync::Arc;

impl ThermalModel {
    /// The model whose rows are its nodes.
    pub(super) fn lump(self) -> Result<ThermalModel, ModelError> {
        let groups = self.nodes;
        let areas = &self.enclosures[0].factors.areas;
        let mut bands = self.bands;
        for band in &mut bands {
            band.emissivity = even(&band.emissivity, areas, &groups, "eps")?;
        }
        let mut enclosures = Vec::new();
        for enclosure in &self.enclosures {
            even(&enclosure.mirror_reflectances(), areas, &groups, "rho_s")?;
            enclosures.push(Arc::new(enclosure.grouped(&groups)));
        }
        Ok(ThermalModel {
            enclosures,
            bands,
            nodes: Groups {
                of_rows: (0..groups.names.len() as u32).map(Some).collect(),
                names: groups.names.clone(),
            },
            lumped: Some(groups),
        })
    }

    /// The conditions of its rows, from those of the rows that it was made of.
    ///
    /// # Errors
    /// [`ModelError::UnevenConditions`].
    pub fn conditions(&self, given: Conditions) -> Result<Conditions, ModelError> {
        match &self.lumped {
            Some(groups) => combined(given, groups),
            None => Ok(given),
        }
    }
}

/// The one value of each node.
fn even(
    values: &[f64],
    areas: &[f64],
    groups: &Groups,
    what: &'static str,
) -> Result<Vec<f64>, ModelError> {
    let mut of_nodes: Vec<Option<f64>> = vec![None; groups.names.len()];
    for ((&value, &area), group) in values.iter().zip(areas).zip(&groups.of_rows) {
        let Some(group) = group.filter(|_| area > 0.0) else {
            continue;
        };
        let known = *of_nodes[group as usize].get_or_insert(value);
        if (known - value).abs() > SAME {
            return Err(ModelError::Uneven {
                node: groups.names[group as usize].clone(),
                what,
                values: [known.min(value), known.max(value)],
            });
        }
    }
    let values = of_nodes.into_iter().map(Option::unwrap_or_default);
    Ok(values.collect())
}

/// The one condition of each node.
fn combined(conditions: Conditions, groups: &Groups) -> Result<Conditions, ModelError> {
    let count = groups.names.len();
    let mut rows: Vec<Option<RowCondition>> = vec![None; count];
    let mut solar: Vec<Option<f64>> = vec![None; count];
    for (i, group) in groups.of_rows.iter().enumerate() {
        let Some(group) = group.map(|g| g as usize) else {
            continue;
        };
        let known = *rows[group].get_or_insert(conditions.rows[i]);
        if known != conditions.rows[i] {
            return Err(ModelError::UnevenConditions {
                node: groups.names[group].clone(),
            });
        }
        solar[group] = conditions.solar[i];
    }
    let adiabatic = RowCondition::Flux(0.0);
    Ok(Conditions {
        rows: rows.into_iter().map(|row| row.unwrap_or(adiabatic)).collect(),
        solar,
    })
}
