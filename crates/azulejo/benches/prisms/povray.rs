//! The same picture by POV-Ray.

use crate::cpu;
use crate::letters::Page;
use nix::sys::resource::UsageWho;
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// The typeface of the pages, where Debian has it (package fonts-dejavu-core).
const FONT: &str = "/usr/share/fonts/truetype/dejavu/DejaVuSerif.ttf";

/// CPU seconds of POV-Ray with one thread, reading the scene included.
pub fn seconds(page: &Page) -> Option<f64> {
    if !Path::new(FONT).exists() {
        return None;
    }
    let name = format!("azulejo-{}-{}.pov", page.name, std::process::id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, scene(page)).ok()?;
    let before = cpu(UsageWho::RUSAGE_CHILDREN);
    let status = Command::new("povray")
        .args(["+W1280", "+H720", "+WT1", "-A", "-D", "-F"])
        .arg(format!("+I{}", file.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let seconds = cpu(UsageWho::RUSAGE_CHILDREN) - before;
    let _ = std::fs::remove_file(file);
    status.is_ok_and(|s| s.success()).then_some(seconds)
}

/// One `text` for each letter, at its own place.
fn scene(page: &Page) -> String {
    let (camera, lights) = (page.camera(), page.lights());
    let v = |p: glam::DVec3| format!("<{},{},{}>", p.x, p.y, p.z);
    let angle = 2.0
        * ((0.5 * camera.vertical_fov).tan() * 16.0 / 9.0)
            .atan()
            .to_degrees();
    let [corner, a, b] = lights.area;
    let middle = corner + 0.5 * (a + b);
    let mut out = String::from("#version 3.7;\nglobal_settings { assumed_gamma 1 charset utf8 }\n");
    let _ = writeln!(
        out,
        "camera {{ perspective location {} right -x*16/9 up y sky y angle {angle} look_at {} }}",
        v(camera.eye),
        v(camera.target)
    );
    let _ = writeln!(out, "light_source {{ {} rgb 0.5 }}", v(lights.point));
    let _ = writeln!(
        out,
        "light_source {{ {} rgb 0.8 area_light {}, {}, 4, 4 jitter }}",
        v(middle),
        v(a),
        v(b)
    );
    out.push_str("plane { y, 0 pigment { rgb 0.7 } }\nplane { z, -3 pigment { rgb 0.5 } }\n");
    out.push_str("#declare Gold = texture { pigment { rgb <0.75,0.55,0.15> } }\n");
    for (name, pen) in &page.placed {
        let _ = writeln!(
            out,
            "text {{ ttf \"{FONT}\" \"{name}\" {}, 0 scale <{s},{s},{s}> translate <{},{},0> \
             texture {{ Gold }} }}",
            page.depth / page.size,
            pen.x,
            pen.y,
            s = page.size,
        );
    }
    out
}
