//! What `brdf` promises.

use crate::support::{Folder, project};
use azulejo::scene::brdf::{FRESNEL, MODELS, ModelInfo, ParameterInfo, ParameterKind};
use serde_json::{Value, json};
use std::path::Path;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is not a number"))
}

#[test]
fn models_are_listed() {
    let folder = Folder::new();
    let list = folder.json("brdf list");
    let names: Vec<&str> = list["models"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| m["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, MODELS.iter().map(|m| m.name).collect::<Vec<_>>());
    let words = folder.ok("brdf list lewis_phong").out;
    for part in ["lewis\n", "also", "exponent", "required", "CGF 13(2)"] {
        assert!(words.contains(part), "{part} is not in {words}");
    }
    folder.fails("brdf list levis", 2, "nearest name is `lewis`");
    let script = folder.ok("completions bash").out;
    assert!(
        script.contains("oren_nayar"),
        "shells do not offer the models"
    );
}

/// The known values of all models, by the names of that table.
#[test]
fn eval_agrees_with_the_table() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let path = data.join("reference/brdf_values.tsv");
    let table = std::fs::read_to_string(path).unwrap();
    let folder = Folder::new();
    let rows = table
        .lines()
        .filter(|l| l.starts_with('P'))
        .map(|l| l.split('\t').collect());
    let mut count = 0;
    for row in rows.collect::<Vec<Vec<&str>>>() {
        let [id, model, parameters, ti, pi, to, po, expected] = row[..] else {
            panic!("{row:?}");
        };
        let parameters = parameters.replace(';', " ");
        let line = format!("brdf eval {model} {parameters} --i {ti},{pi} --o {to},{po}");
        let found = number(&folder.json(&line)["values"][0]["value"][0]);
        let expected: f64 = expected.parse().unwrap();
        let tolerance = if model == "ggx_ms" { 1e-5 } else { 1e-6 };
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{id} {line}: {found} {expected}"
        );
        count += 1;
    }
    assert_eq!(count, 47);
}

#[test]
fn eval_takes_pairs_of_directions() {
    let folder = Folder::new();
    let line = "brdf eval diffuse kd=0.5,0.25,0.125 --i 30,0 --i 60,10 --o 0";
    let found = folder.json(line);
    let third = 0.125 / std::f64::consts::PI;
    assert_eq!(found["values"].as_array().unwrap().len(), 2);
    assert!((number(&found["values"][1]["value"][2]) - third).abs() < 1e-12);
    let quiet = folder
        .ok("brdf eval fresnel_dielectric eta=1.5 --i 0 --o 0 --quiet")
        .out;
    assert_eq!(quiet, "0.04\n");
    let words = folder.ok("brdf eval lewis n=20 --i 30,180 --o 30,0").out;
    assert!(words.contains("1/sr"), "{words}");
    let both = "brdf eval combination weight=0.5 diffuse kd=0.5 weight=0.5 diffuse kd=0.3";
    let found = folder.json(&format!("{both} --i 1 --o 2"));
    let expected = 0.4 / std::f64::consts::PI;
    assert!((number(&found["values"][0]["value"][0]) - expected).abs() < 1e-12);
}

#[test]
fn misuse_is_explained() {
    let folder = Folder::new();
    let angles = "--i 30 --o 30";
    for (line, said) in [
        ("brdf eval lewiss n=3", "nearest name is `lewis`"),
        ("brdf eval lewis m=3", "no parameter `m`"),
        ("brdf eval lewis", "needs `n`"),
        ("brdf eval lewis n=-3", "between 0 and"),
        ("brdf eval lewis n=3 kd=0.6 ks=0.6", "create energy"),
    ] {
        folder.fails(&format!("{line} {angles}"), 2, said);
    }
    folder.fails("brdf eval diffuse --i 91 --o 0", 2, "expected 0 to 90");
    folder.fails(
        "brdf eval diffuse --i 1 --i 2 --i 3 --o 1 --o 2",
        2,
        "expected the same number",
    );
    folder.fails("brdf eval missing.brdf --i 1 --o 2", 1, "missing.brdf");
    folder.fails("brdf plot lewis n=3 -o a.gif", 2, "expected .svg or .png");
    folder.fails("brdf plot lewis n=3 -o missing/a.png", 1, "cannot write");
    folder.fails(
        "brdf fit lewis n=3 --model lewiss",
        2,
        "nearest name is `lewis`",
    );
    folder.fails(
        "brdf fit lewis n=3 --model combination",
        2,
        "cannot be fitted",
    );
    assert!(folder.names().is_empty());
}

#[test]
fn plots_are_pictures() {
    let folder = Folder::new();
    folder.ok("brdf plot lewis kd=0.3 ks=0.6 n=20 -o a.svg --width 240 --angles 0,45,75 --phi 90");
    let svg = String::from_utf8(folder.read("a.svg")).unwrap();
    for part in [
        "<svg",
        "Lewis (modified Phong)",
        "lewis kd = 0.3",
        "CGF 13(2)",
        "75°",
        "1/sr",
        "Albedo against angle",
        "glossy",
        "data:image/png;base64,",
    ] {
        assert!(svg.contains(part), "{part} is not in the plot");
    }
    folder.ok("brdf plot specular -o b.png --width 240 --compare diffuse --threads 1");
    folder.ok("brdf plot specular -o c.png --width 240 --compare diffuse --threads 2");
    assert!(folder.read("b.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    assert_eq!(folder.read("b.png"), folder.read("c.png"));
}

#[test]
fn fits_are_written() {
    let folder = Folder::new();
    let line =
        "brdf fit lewis kd=0.2 ks=0.5 n=40 --model lewis --starts 4 --most-angle 70 -o a.brdf";
    let found = folder.json(line);
    let value = |k: usize| number(&found["parameters"][k]["value"]);
    for (k, expected) in [0.2, 0.5, 40.0].into_iter().enumerate() {
        assert!((value(k) / expected - 1.0).abs() < 0.01, "{found}");
    }
    assert!(number(&found["relative_error"]) < 1e-3, "{found}");
    assert!(number(&found["lambert_relative_error"]) > 0.1, "{found}");
    // What was fitted can be used like a model.
    let again = folder.json("brdf eval a.brdf --i 30,0 --o 40,170");
    let direct = folder.json("brdf eval lewis kd=0.2 ks=0.5 n=40 --i 30,0 --o 40,170");
    let of = |json: &Value| number(&json["values"][0]["value"][0]);
    assert!((of(&again) / of(&direct) - 1.0).abs() < 0.01);
    // What is given is not looked for.
    let mut command = folder.command("brdf fit lewis n=40 --starts 1 --json --model");
    let output = command.arg("lewis n=20").output().unwrap();
    let other: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        other["parameters"].as_array().map(Vec::len),
        Some(2),
        "{other}"
    );
    assert!(
        other["model"]
            .as_str()
            .is_some_and(|m| m.starts_with("lewis n = 20")),
        "{other}"
    );
}

/// Every model has a page, whose table says what the model's own does. `AZULEJO_ACCEPT=1` writes
/// the tables anew.
#[test]
fn models_have_pages() {
    let folder = project().join("docs/brdf");
    let index = read(&folder.join("README.md"));
    for info in MODELS {
        let path = folder.join(format!("{}.md", info.name));
        let mut page = read(&path);
        let expected = parameters_of(info);
        let old = between(&page, "## Parameters\n\n", "\n## Sampling");
        if old != expected && std::env::var_os("AZULEJO_ACCEPT").is_some() {
            let with = |table: &str| format!("## Parameters\n\n{table}");
            page = page.replacen(&with(&old), &with(&expected), 1);
            std::fs::write(&path, &page).unwrap();
        }
        let old = between(&page, "## Parameters\n\n", "\n## Sampling");
        assert_eq!(
            old,
            expected,
            "{}: AZULEJO_ACCEPT=1 writes it anew",
            path.display()
        );
        let title = format!("# `{}`: {}\n", info.name, info.title);
        assert!(page.starts_with(&title), "{}: {title}", path.display());
        for part in [info.paper, &format!("azulejo brdf plot {}", info.name)] {
            assert!(page.contains(part), "{}: {part}", path.display());
        }
        let picture = project().join(format!("docs/images/brdf/{}.png", info.name));
        let size = std::fs::metadata(&picture).map_or(0, |m| m.len());
        assert!(
            (5_000..80_000).contains(&size),
            "{}: {size} bytes",
            picture.display()
        );
        let yes = |it_is: bool| if it_is { "yes" } else { "no" };
        let row = format!(
            "| [{0}]({0}.md) | {1} | {2} | {3} |",
            info.name,
            info.title,
            yes(info.is_reciprocal),
            yes(info.is_energy_safe)
        );
        assert!(index.contains(&row), "docs/brdf/README.md: {row}");
    }
    let fresnel = between(&index, "## Fresnel terms\n\n", "\n## ");
    let table = table(&FRESNEL.iter().collect::<Vec<_>>());
    assert!(fresnel.contains(&table), "docs/brdf/README.md:\n{table}");
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn between(text: &str, from: &str, to: &str) -> String {
    let start = text.find(from).map(|k| k + from.len());
    let rest = start.map_or("", |k| &text[k..]);
    rest[..rest.find(to).unwrap_or(0)].to_owned()
}

fn parameters_of(info: &ModelInfo) -> String {
    let own: Vec<&ParameterInfo> = info.parameters.iter().collect();
    let mut text = if own.is_empty() {
        String::new()
    } else {
        table(&own)
    };
    if info.has_fresnel {
        text += if own.is_empty() { "" } else { "\n" };
        text += "And one of the [Fresnel terms](README.md#fresnel-terms).\n";
    }
    if !info.aliases.is_empty() {
        text += &format!("\nOther names of the model: {}.\n", quoted(info.aliases));
    }
    text
}

fn quoted(names: &[&str]) -> String {
    names
        .iter()
        .map(|n| format!("`{n}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

fn table(parameters: &[&ParameterInfo]) -> String {
    let mut text =
        "| name | also | value | default | meaning |\n|---|---|---|---|---|\n".to_owned();
    for p in parameters {
        let range = format!("{} to {}", p.least, p.most);
        let value = match p.kind {
            ParameterKind::Number => range,
            ParameterKind::Color => format!("{range}, per channel"),
            ParameterKind::Word => "a word".to_owned(),
        };
        let unit = if p.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", p.unit)
        };
        let default = match p.default {
            Some(default) => default.to_string(),
            None if p.is_needed => "must be given".to_owned(),
            None => String::new(),
        };
        let also = quoted(p.aliases);
        text += &format!(
            "| `{}` | {also} | {value}{unit} | {default} | {} |\n",
            p.name, p.about
        );
    }
    text
}
#[test]
fn checks_have_verdicts() {
    let folder = Folder::new();
    let found = folder.json("brdf check lewis kd=0.3 ks=0.6 n=20 --samples 20000");
    assert_eq!(found["passed"], json!(true), "{found}");
    for key in ["reciprocity", "energy", "sampling", "furnace"] {
        assert_eq!(found[key]["holds"], json!(true), "{key}: {found}");
    }
    assert!(
        (number(&found["angles"][0]["albedo"][0]) - 0.9).abs() < 1e-4,
        "{found}"
    );
    // What nobody promises is said, and is not a failure.
    for (model, key) in [
        ("phong ks=1 n=20", "reciprocity"),
        ("ward_duer ks=1 ax=0.2", "energy"),
    ] {
        let found = folder.json(&format!("brdf check {model} --samples 20000"));
        let verdict = (&found[key]["holds"], &found[key]["promised"]);
        assert_eq!(verdict, (&json!(false), &json!(false)), "{key}: {found}");
        assert_eq!(found["passed"], json!(true), "{found}");
    }
    let words = folder.ok("brdf check specular --samples 2000").out;
    assert!(
        words.contains("energy-safe") && words.contains("holds"),
        "{words}"
    );
}
