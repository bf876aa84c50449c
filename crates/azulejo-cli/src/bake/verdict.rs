//! What the tests of an atlas say, in words.

use crate::report::{Report, count, number, percent, short};
use azulejo::bake::check::{AtlasCheck, CheckOptions, Finding};
use azulejo::bake::{Receiver, TriangleId};
use serde_json::{Value, json};

/// Share of the area that may be mirrored or collapsed.
const LEAST_AREA: f64 = 1e-6;

/// Largest spread of densities.
const SPREAD: f64 = 4.0;

/// Distance of charts below which they share texels.
const SHARED: f64 = 1.0;

/// Largest stretch over all area, and anywhere.
const STRETCH: [f64; 2] = [1.05, 4.0];

/// Covered share of pages with few charts, and with many.
const COVERED: [f64; 2] = [0.6, 0.3];
const FEW_CHARTS: usize = 100;

/// How bad a result is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Within the limit.
    Good,
    /// Beyond it; pictures may be worse than they could be.
    Poor,
    /// It will show in pictures.
    Defect,
}

impl Grade {
    /// Poor or good.
    pub fn poor_if(is_poor: bool) -> Grade {
        if is_poor { Grade::Poor } else { Grade::Good }
    }

    fn word(self) -> &'static str {
        match self {
            Grade::Good => "ok",
            Grade::Poor => "poor",
            Grade::Defect => "DEFECT",
        }
    }
}

/// The result of a test.
#[derive(Clone, Debug)]
pub struct TestRow {
    /// Its key in the JSON.
    pub key: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What was found.
    pub found: String,
    /// The number for the JSON.
    pub value: Value,
    /// How often.
    pub count: usize,
    /// What it is held against; empty for nothing.
    pub limit: String,
    /// How bad that is.
    pub grade: Grade,
    /// Where it is worst.
    pub worst: Option<TriangleId>,
}

impl TestRow {
    /// A result that is not counted, and worst nowhere.
    pub fn new(
        key: &'static str,
        name: &'static str,
        found: String,
        value: f64,
        limit: impl Into<String>,
        grade: Grade,
    ) -> TestRow {
        TestRow {
            key,
            name,
            found,
            value: number(value),
            count: 0,
            limit: limit.into(),
            grade,
            worst: None,
        }
    }
}

/// Whether coordinates can be kept for a lightmap; the test that they fail.
pub fn unfit(atlas: &AtlasCheck, options: &CheckOptions) -> Option<TestRow> {
    const NEEDED: [&str; 6] = [
        "outside",
        "overlaps",
        "near_charts",
        "mirrored",
        "collapsed",
        "density_spread",
    ];
    let rows = atlas_rows(atlas, options).into_iter();
    let is_needed = |row: &TestRow| NEEDED.contains(&row.key) && row.grade != Grade::Good;
    let mut failed: Vec<TestRow> = rows.filter(is_needed).collect();
    // What shows comes first.
    failed.sort_by_key(|row| row.grade != Grade::Defect);
    failed.into_iter().next()
}

/// All tests of an atlas.
pub fn atlas_rows(atlas: &AtlasCheck, options: &CheckOptions) -> Vec<TestRow> {
    let row = |key, name, finding: &Finding, detail: String, limit: &str, grade| {
        let text = match finding.count {
            0 => "0".to_owned(),
            n => format!("{}{detail}", count(n)),
        };
        TestRow {
            count: finding.count,
            worst: finding.worst.filter(|_| finding.count > 0),
            ..TestRow::new(key, name, text, finding.amount, limit, grade)
        }
    };
    // Charts that share texels show each other's light, which is a defect; others too close are poor.
    let near = match atlas.near.count {
        0 => Grade::Good,
        _ if atlas.near.amount < SHARED => Grade::Defect,
        _ => Grade::Poor,
    };
    let area_share = |share: f64| format!(", {} of the area", percent(share));
    // These tests count triangles, edges or charts, and name the worst of them.
    let mut rows = vec![
        row(
            "outside",
            "coordinates outside of 0..1",
            &atlas.outside,
            format!(", by {}", short(atlas.outside.amount)),
            "0",
            defect_if(&atlas.outside),
        ),
        row(
            "overlaps",
            "overlapping triangles",
            &atlas.overlaps,
            format!(", up to {}", percent(atlas.overlaps.amount)),
            "0",
            defect_if(&atlas.overlaps),
        ),
        row(
            "near_charts",
            "charts near others",
            &atlas.near,
            format!(", {} texels apart", short(atlas.near.amount)),
            &format!("{} texels", short(options.gap)),
            near,
        ),
        row(
            "mirrored",
            "mirrored triangles",
            &atlas.mirrored,
            area_share(atlas.mirrored_share),
            "0.0001%",
            Grade::poor_if(atlas.mirrored_share > LEAST_AREA),
        ),
        row(
            "collapsed",
            "triangles without texel",
            &atlas.collapsed,
            area_share(atlas.collapsed_share),
            "0.0001%",
            Grade::poor_if(atlas.collapsed_share > LEAST_AREA),
        ),
        row(
            "creases",
            "creases inside of charts",
            &atlas.creases,
            format!(", up to {}°", short(atlas.creases.amount.round())),
            &format!("{}°", short(options.crease)),
            Grade::poor_if(atlas.creases.count > 0),
        ),
        row(
            "thin_charts",
            "charts under half a texel",
            &atlas.thin,
            String::new(),
            "0",
            Grade::poor_if(atlas.thin.count > 0),
        ),
    ];
    // Measures of quality are of the whole atlas, and most of them name no triangle.
    rows.extend(quality_rows(atlas));
    rows
}

fn defect_if(finding: &Finding) -> Grade {
    match finding.count {
        0 => Grade::Good,
        _ => Grade::Defect,
    }
}

fn quality_rows(atlas: &AtlasCheck) -> Vec<TestRow> {
    let spread = atlas.density_spread();
    let least = COVERED[usize::from(atlas.charts >= FEW_CHARTS)];
    let most = &atlas.most_stretch;
    vec![
        TestRow::new(
            "density_spread",
            "spread of density",
            short(spread),
            spread,
            short(SPREAD),
            Grade::poor_if(spread > SPREAD),
        ),
        TestRow::new(
            "stretch",
            "stretch, mean",
            short(atlas.stretch),
            atlas.stretch,
            short(STRETCH[0]),
            Grade::poor_if(atlas.stretch > STRETCH[0]),
        ),
        TestRow {
            worst: most.worst,
            count: most.count,
            ..TestRow::new(
                "most_stretch",
                "stretch, largest",
                short(most.amount),
                most.amount,
                short(STRETCH[1]),
                Grade::poor_if(most.amount > STRETCH[1]),
            )
        },
        TestRow::new(
            "covered",
            "covered share of pages",
            percent(atlas.covered),
            atlas.covered,
            percent(least),
            Grade::poor_if(atlas.covered < least),
        ),
        TestRow::new(
            "below_texel",
            "triangles under a texel",
            format!("{} of the area", percent(atlas.below_texel)),
            atlas.below_texel,
            "",
            Grade::Good,
        ),
    ]
}

/// Where the worst of a test is: `"wall", triangle 17`.
pub fn place(row: &TestRow, receivers: &[Receiver]) -> String {
    let Some(worst) = row.worst else {
        return String::new();
    };
    let name = receivers.get(worst.receiver as usize).map(|r| &r.name);
    let name = name.map_or("", String::as_str);
    format!("\"{name}\", triangle {}", worst.triangle)
}

/// Adds the tests as a table, and as JSON.
pub fn table(rows: &[TestRow], receivers: &[Receiver], report: &mut Report) {
    // Lay out the tests as text, with the heads as the first line.
    let heads = ["test", "found", "limit", "verdict", "worst"].map(str::to_owned);
    let cells = |row: &TestRow| {
        [
            row.name.to_owned(),
            row.found.clone(),
            row.limit.clone(),
            row.grade.word().to_owned(),
            place(row, receivers),
        ]
    };
    let lines: Vec<[String; 5]> = std::iter::once(heads)
        .chain(rows.iter().map(cells))
        .collect();
    // Columns are as wide as their widest cell; the last one ends the line and needs no width.
    let width = |k: usize| {
        lines
            .iter()
            .map(|l| l[k].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths = [0, 1, 2, 3].map(width);
    for [name, result, limit, verdict, worst] in &lines {
        let [a, b, c, d] = widths;
        let line = format!("{name:<a$}  {result:<b$}  {limit:<c$}  {verdict:<d$}  {worst}");
        report.plain(line.trim_end());
    }
    // The JSON has numbers in place of words, and the worst triangle by its object.
    let tests: Vec<Value> = rows
        .iter()
        .map(|row| {
            let object = row.worst.and_then(|w| receivers.get(w.receiver as usize));
            json!({
                "test": row.key,
                "count": row.count,
                "value": row.value,
                "limit": row.limit,
                "verdict": row.grade.word().to_lowercase(),
                "object": object.map(|r| r.name.as_str()),
                "triangle": row.worst.map(|w| w.triangle),
            })
        })
        .collect();
    report.value("tests", tests);
}
