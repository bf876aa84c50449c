//! What points see of surfaces, or of groups of them: tables and archives, and radiant temperatures.

use crate::archive::write::{list, triples, write_sky};
use crate::enclosure::{Enclosure, GroupBy, Groups};
use crate::files::text::csv_field;
use crate::thermal::RowCondition;
use crate::thermal::tables::{BoundaryTable, TableError};
use azulejo_factors::form_factors::{
    FactorPoint, PointFactors, PreparedPlan, RowRemainder, SkyFactors,
};
use azulejo_factors::{FactorsError, FormFactors};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use azulejo_scene::Scene;
use azulejo_scene::sky::SkyDivision;
use azulejo_trace::{Cancelled, Progress};
use glam::DVec3;
use std::io::{self, Write};

/// The faces of a small cube, by name.
pub const SIX_DIRECTIONS: [(&str, DVec3); 6] = [
    ("+x", DVec3::X),
    ("-x", DVec3::NEG_X),
    ("+y", DVec3::Y),
    ("-y", DVec3::NEG_Y),
    ("+z", DVec3::Z),
    ("-z", DVec3::NEG_Z),
];

/// Factors from points to the columns of a matrix, or to groups of these.
pub struct SeenFromPoints {
    /// The points.
    pub points: Vec<FactorPoint>,
    /// Their names, in tables.
    pub names: Vec<String>,
    /// What each sees; columns are groups.
    pub seen: Vec<PointFactors>,
    /// The groups of the rows of the matrix.
    pub groups: Groups,
    /// What each sees of patches of the sky, if that is known.
    pub sky: Option<SkyFactors>,
    /// The radiant temperature of each point and its standard error, K, if temperatures are known; NaN where it sees
    /// nothing that has one.
    pub temperatures: Option<Vec<[f64; 2]>>,
    /// The rows that the matrix of the same options has, without factors.
    rows: Enclosure,
}

/// Points with their names: their numbers from 0.
pub fn numbered(points: Vec<FactorPoint>) -> (Vec<FactorPoint>, Vec<String>) {
    let names = (0..points.len()).map(|k| k.to_string()).collect();
    (points, names)
}

/// The faces of a small cube at each point, with their names.
pub fn in_six_directions(points: &[FactorPoint]) -> (Vec<FactorPoint>, Vec<String>) {
    let faces = points.iter().enumerate().flat_map(|(k, point)| {
        SIX_DIRECTIONS.map(|(name, normal)| {
            let normal = Some(normal);
            (FactorPoint { normal, ..*point }, format!("{k}:{name}"))
        })
    });
    faces.unzip()
}

impl SeenFromPoints {
    /// Computes what points see of the patches of a plan, or of groups of them.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn compute(
        prepared: &PreparedPlan,
        (scene, by): (&Scene, Option<GroupBy>),
        (points, names): (Vec<FactorPoint>, Vec<String>),
        progress: &Progress,
    ) -> Result<SeenFromPoints, Cancelled> {
        let rows = rows(prepared, scene);
        let groups = match by {
            Some(by) => rows.groups(by),
            None => Groups {
                of_rows: (0..rows.len() as u32).map(Some).collect(),
                names: rows.rows.names.clone(),
            },
        };
        let columns = (&groups.of_rows[..], groups.names.len());
        let seen = prepared.factors_from_points(&points, columns, progress)?;
        Ok(SeenFromPoints {
            points,
            names,
            seen,
            groups,
            sky: None,
            temperatures: None,
            rows,
        })
    }

    /// Computes [`sky`](SeenFromPoints::sky), for a north in radians.
    ///
    /// # Errors
    /// As [`PreparedPlan::sky_from_points`].
    pub fn add_sky(
        &mut self,
        prepared: &PreparedPlan,
        sky: (SkyDivision, f64),
        progress: &Progress,
    ) -> Result<(), FactorsError> {
        let found = prepared.sky_from_points(sky, &self.points, &self.seen, progress)?;
        self.sky = Some(found);
        Ok(())
    }

    /// Names of a table that no row has.
    pub fn unused<'t>(&self, table: &'t BoundaryTable) -> Vec<&'t str> {
        table.unused(&self.rows)
    }

    /// Computes [`temperatures`](SeenFromPoints::temperatures): that of black surroundings that are the same
    /// everywhere and give each point as much, T⁴ = Σ F T⁴ over what it sees of surfaces, sky and ground. Surfaces are
    /// taken to be black, as for mean radiant temperatures (ISO 7726); what ends on back sides does not count.
    ///
    /// # Errors
    /// Groups without a temperature, or with several; the sky or ground is seen and has none.
    pub fn add_temperatures(&mut self, table: &BoundaryTable) -> Result<(), TableError> {
        let of_groups = self.fourth_powers(table)?;
        let around = table.surroundings.map(|t| t.map(|t| t.powi(4)));
        let temperature = |seen: &PointFactors| {
            let rest = &seen.rest;
            let mut parts: Vec<[f64; 3]> = Vec::new();
            for (k, factor) in &seen.factors {
                parts.push([factor.value, factor.error, of_groups[*k as usize]]);
            }
            let outside = [
                ("sky", rest.sky, rest.sky_error),
                ("ground", rest.ground, rest.ground_error),
            ];
            for ((name, share, error), power) in outside.into_iter().zip(around) {
                match power {
                    Some(power) => parts.push([share, error, power]),
                    None if share > 0.0 => {
                        return Err(TableError::new(format_args!(
                            "points see the {name}, and it has no temperature: add a line \"{name}\", or \"space\" for \
                             all that is around"
                        )));
                    }
                    None => {}
                }
            }
            let all: f64 = parts.iter().map(|[share, ..]| share).sum();
            let mean = parts
                .iter()
                .map(|[share, _, power]| share * power)
                .sum::<f64>()
                / all;
            // Shares add up to a constant: what is too much of one is too little of others, which on average have the mean.
            let squares = parts
                .iter()
                .map(|[_, error, power]| (error * (power - mean)).powi(2));
            let temperature = mean.powf(0.25);
            // At 0 K nothing differs.
            let slope = (4.0 * temperature.powi(3)).max(f64::MIN_POSITIVE);
            let error = squares.sum::<f64>().sqrt() / all / slope;
            Ok(if all > 0.0 {
                [temperature, error]
            } else {
                [f64::NAN; 2]
            })
        };
        self.temperatures = Some(
            self.seen
                .iter()
                .map(temperature)
                .collect::<Result<_, _>>()?,
        );
        Ok(())
    }

    /// T⁴ of each group.
    fn fourth_powers(&self, table: &BoundaryTable) -> Result<Vec<f64>, TableError> {
        let conditions = table.of_rows(&self.rows)?;
        let mut known: Vec<Option<f64>> = vec![None; self.groups.names.len()];
        for (group, condition) in self.groups.of_rows.iter().zip(conditions.rows) {
            let Some(group) = group.map(|group| group as usize) else {
                continue;
            };
            let name = &self.groups.names[group];
            let RowCondition::Temperature(t) = condition else {
                return Err(TableError::new(format_args!(
                    "\"{name}\" has a flux; radiant temperatures need the temperatures of all surfaces (T, or T_C)"
                )));
            };
            if known[group].is_some_and(|other| other != t) {
                return Err(TableError::new(format_args!(
                    "\"{name}\" has several temperatures: group by what has one each (--by face or material)"
                )));
            }
            known[group] = Some(t);
        }
        Ok(known
            .into_iter()
            .map(|t| t.unwrap_or_default().powi(4))
            .collect())
    }

    /// Writes one line for each point and what it sees: names, factor or share, standard error. Sky, ground and back
    /// sides (`hidden`) have lines of their own, and so have patches of the sky (`sky:1` and on) and radiant temperatures,
    /// in K.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "point,to,f,std_error")?;
        for (k, (name, seen)) in self.names.iter().zip(&self.seen).enumerate() {
            for (group, factor) in &seen.factors {
                let to = csv_field(&self.groups.names[*group as usize]);
                writeln!(out, "{name},{to},{},{}", factor.value, factor.error as f32)?;
            }
            let rest = &seen.rest;
            let away = [
                ("sky", rest.sky, rest.sky_error),
                ("ground", rest.ground, rest.ground_error),
                ("hidden", rest.hidden, rest.hidden_error),
            ];
            for (to, share, error) in away.into_iter().filter(|(_, share, _)| *share > 0.0) {
                writeln!(out, "{name},{to},{share},{}", error as f32)?;
            }
            if let Some(sky) = &self.sky {
                let patches = sky.row(k).iter().zip(sky.row_errors(k)).enumerate();
                for (k, (share, error)) in patches.skip(1).filter(|(_, (share, _))| **share > 0.0) {
                    writeln!(out, "{name},sky:{k},{share},{error}")?;
                }
            }
            let temperature = self.temperatures.as_ref().map(|known| known[k]);
            if let Some([t, error]) = temperature.filter(|[t, _]| t.is_finite()) {
                writeln!(out, "{name},radiant_temperature,{t},{}", error as f32)?;
            }
        }
        Ok(())
    }

    /// Writes a sparse matrix that SciPy reads, points × groups, with the standard errors of its entries, the names of
    /// groups, the points, and what reaches no group.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_npz(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut archive = NpzWriter::new(out);
        let mut starts = vec![0];
        for point in &self.seen {
            starts.push(starts[starts.len() - 1] + point.factors.len() as i64);
        }
        let entries: Vec<_> = self.seen.iter().flat_map(|p| &p.factors).collect();
        let shape = [self.seen.len() as i64, self.groups.names.len() as i64];
        archive.add("format", |w| npy::write_bytes(b"csr", w))?;
        archive.add("shape", |w| npy::write(&[2], &shape, w))?;
        archive.add("indptr", |w| npy::write(&[starts.len()], &starts, w))?;
        archive.add("indices", |w| list(&entries, |(k, _)| i64::from(*k), w))?;
        archive.add("data", |w| list(&entries, |(_, f)| f.value, w))?;
        archive.add("std_error", |w| list(&entries, |(_, f)| f.error, w))?;
        let mut add = |name, share: fn(&RowRemainder) -> f64| {
            archive.add(name, |w| list(&self.seen, |p| share(&p.rest), w))
        };
        add("sky", |r| r.sky)?;
        add("sky_error", |r| r.sky_error)?;
        add("ground", |r| r.ground)?;
        add("ground_error", |r| r.ground_error)?;
        add("hidden", |r| r.hidden)?;
        add("hidden_error", |r| r.hidden_error)?;
        add("cut", |r| r.cut)?;
        add("lost", |r| r.lost)?;
        archive.add("names", |w| npy::write_texts(&self.groups.names, w))?;
        archive.add("point_names", |w| npy::write_texts(&self.names, w))?;
        write_points(&self.points, &mut archive)?;
        if let Some(sky) = &self.sky {
            write_sky(sky, self.rows.rows.up, &mut archive)?;
        }
        if let Some(temperatures) = &self.temperatures {
            archive.add("radiant_temperature", |w| list(temperatures, |t| t[0], w))?;
            archive.add("radiant_temperature_error", |w| {
                list(temperatures, |t| t[1], w)
            })?;
        }
        archive.finish()
    }
}

/// Adds positions and normals; of globes these are 0.
pub(crate) fn write_points(points: &[FactorPoint], archive: &mut NpzWriter) -> io::Result<()> {
    let positions = points.iter().map(|p| p.position.to_array());
    archive.add("points", |w| triples(positions, w))?;
    let normals = points.iter().map(|p| p.normal.unwrap_or_default());
    archive.add("normals", |w| triples(normals.map(|n| n.to_array()), w))
}

/// The rows of the matrix of a plan, without factors.
fn rows(prepared: &PreparedPlan, scene: &Scene) -> Enclosure {
    let (plan, count) = (prepared.plan(), prepared.rows());
    let patches = plan.patches();
    let two_sided = count > patches.len();
    let patch = |row: usize| if two_sided { row / 2 } else { row };
    let factors = FormFactors {
        areas: vec![0.0; count],
        faces: (0..count).map(|row| patches.face(patch(row))).collect(),
        materials: (0..count).map(|row| patches.material(patch(row))).collect(),
        is_back: (0..count).map(|row| two_sided && row % 2 == 1).collect(),
        ..FormFactors::default()
    };
    Enclosure::new(prepared, scene, factors)
}
