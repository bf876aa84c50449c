//! Makes the folder of static files: `cargo run --release --manifest-path crates/azulejo-web/tool/Cargo.toml`.
//!
//! Builds the program for WebAssembly, makes its JavaScript, optimizes it where there is npm, and copies the page.

use flate2::{Compression, write::GzEncoder};
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

/// wasm-opt, from npm.
const BINARYEN: &str = "binaryen@123.0.0";

const HELP: &str = "Makes azulejo's page in a folder of static files.

Usage: azulejo-web-tool [--fast] [FOLDER]

FOLDER is dist/web of the workspace unless another is given. --fast leaves out what takes long and makes the page
smaller and faster: the optimizations across crates, and those of binaryen, which needs npm.

Needs: rustup target add wasm32-unknown-unknown";

fn main() -> Result<(), Box<dyn Error>> {
    let mut folder = None;
    let mut is_fast = false;
    for argument in env::args().skip(1) {
        match argument.as_str() {
            "--fast" => is_fast = true,
            "--help" | "-h" => {
                println!("{HELP}");
                return Ok(());
            }
            option if option.starts_with('-') => return Err(format!("{option}?\n\n{HELP}").into()),
            path => folder = Some(PathBuf::from(path)),
        }
    }
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(3);
    let workspace = workspace.ok_or("the tool is not in its workspace")?;
    let folder = folder.unwrap_or_else(|| workspace.join("dist/web"));
    let program = build(workspace, is_fast)?;
    fs::create_dir_all(&folder)?;
    Bindgen::new()
        .input_path(&program)
        .web(true)?
        .typescript(false)
        .generate(&folder)?;
    let wasm = folder.join("azulejo_web_bg.wasm");
    if !is_fast {
        optimize(&wasm);
    }
    for file in fs::read_dir(workspace.join("crates/azulejo-web/page"))? {
        let file = file?;
        fs::copy(file.path(), folder.join(file.file_name()))?;
    }
    report(&folder)
}

/// Builds the program; returns its file.
fn build(workspace: &Path, is_fast: bool) -> Result<PathBuf, Box<dyn Error>> {
    let target = env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let target = target.unwrap_or_else(|| workspace.join("target"));
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(workspace);
    cargo.args([
        "build",
        "--locked",
        "--package",
        "azulejo-web",
        "--profile",
        "web",
    ]);
    cargo
        .args(["--target", TARGET, "--target-dir"])
        .arg(&target);
    // Four numbers at once, as all browsers of today can. Without fused multiplications, so with the same results.
    cargo.env("RUSTFLAGS", "-C target-feature=+simd128");
    if is_fast {
        cargo.args([
            "--config",
            "profile.web.lto=false",
            "--config",
            "profile.web.codegen-units=16",
        ]);
    }
    if !cargo.status()?.success() {
        return Err(format!(
            "the program was not built; is there its target? rustup target add {TARGET}"
        )
        .into());
    }
    Ok(target.join(TARGET).join("web/azulejo_web.wasm"))
}

/// Makes a module smaller and faster, where there is npm.
fn optimize(wasm: &Path) {
    let small = wasm.with_extension("small");
    let mut npm = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    npm.args([
        "exec",
        "--yes",
        "--package",
        BINARYEN,
        "--",
        "wasm-opt",
        "-O3",
    ]);
    npm.args(["--all-features", "--disable-gc", "-o"])
        .arg(&small)
        .arg(wasm);
    let done =
        npm.status().is_ok_and(|status| status.success()) && fs::rename(&small, wasm).is_ok();
    if !done {
        println!("{BINARYEN} of npm did not run: the page is a little larger and slower");
    }
}

/// Says how large the files are.
fn report(folder: &Path) -> Result<(), Box<dyn Error>> {
    let (mut all, mut packed) = (0, 0);
    for file in fs::read_dir(folder)? {
        let bytes = fs::read(file?.path())?;
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&bytes)?;
        all += bytes.len();
        packed += encoder.finish()?.len();
    }
    let mega = |bytes: usize| bytes as f64 / 1e6;
    println!(
        "{}: {:.1} MB, {:.1} MB compressed",
        folder.display(),
        mega(all),
        mega(packed)
    );
    println!(
        "Serve it by any server of static files, such as: python3 -m http.server --directory {}",
        folder.display()
    );
    Ok(())
}
