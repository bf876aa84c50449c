//! Work in shards: parts that together are the bytes of one process, and everything that is not a part.

use crate::support::Folder;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// A quick matrix by rays, in as many blocks as there are shards, and formulas before it.
const QUICK: &str = "form-factors room.obj --patches 200 --rays 64";

/// Computes all shards of a command, by different numbers of threads, as `PREFIX-K`.
fn compute(folder: &Folder, line: &str, prefix: &str, of: u32) {
    for k in 1..=of {
        let threads = 1 + k % 3;
        folder.ok(&format!(
            "{line} --shard {k}/{of} -o {prefix}-{k} --threads {threads}"
        ));
    }
}

/// The names of all parts of a prefix.
fn parts(prefix: &str, of: u32) -> String {
    let names: Vec<String> = (1..=of).map(|k| format!("{prefix}-{k}")).collect();
    names.join(" ")
}

/// Checks that 2 and 7 shards, and 40, give the bytes of one process.
fn check(folder: &Folder, line: &str, output: &str) {
    check_shards(folder, line, output, &[2, 7, 40]);
}

/// Checks that this many shards give the bytes of one process.
fn check_shards(folder: &Folder, line: &str, output: &str, counts: &[u32]) {
    folder.ok(&format!("{line} -o whole.{output}"));
    let whole = folder.read(&format!("whole.{output}"));
    for &of in counts {
        let prefix = format!("part-{of}");
        compute(folder, line, &prefix, of);
        let names = parts(&prefix, of);
        let run = folder.ok(&format!("merge {names} -o merged.{output}"));
        assert!(!run.err.contains("computed now"), "{}", run.err);
        assert!(
            folder.read(&format!("merged.{output}")) == whole,
            "{line}, {of} shards"
        );
        for name in names.split(' ') {
            fs::remove_file(folder.path(name)).unwrap();
        }
    }
}

#[test]
fn form_factors_by_rays() {
    let folder = Folder::with_room();
    check(&folder, QUICK, "npz");
    check(&folder, &format!("{QUICK} --two-sided --by object"), "csv");
}

#[test]
fn form_factors_by_formulas() {
    let folder = Folder::with_room();
    check(
        &folder,
        "form-factors room.obj --patches 300 --engine analytic",
        "mtx",
    );
}

/// Formulas for direct light and flat mirrors, then rays for what they leave.
#[test]
fn form_factors_by_formulas_and_rays() {
    let folder = Folder::with_room();
    let mirror = "newmtl white\nKd 0.2 0.2 0.2\nKs 0.7 0.7 0.7\nNs 1000\nillum 3\n\
                  newmtl lamp\nKd 0 0 0\nKe 10 10 10\n";
    folder.write("room.mtl", mirror);
    let line = "form-factors room.obj --patches 40 --rays 64 --separate --engine analytic";
    check(&folder, line, "npz");
}

#[test]
fn form_factors_by_hemicubes() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj --patches 60 --engine hemicube --resolution 32 --patch-points 4 --gpu off";
    check(&folder, line, "npz");
}

#[test]
fn form_factors_of_view3d() {
    let folder = Folder::new();
    let example = crate::support::project().join("examples/box.vs3");
    fs::copy(example, folder.path("box.vs3")).unwrap();
    check(&folder, "form-factors box.vs3", "txt");
}

/// Blocks that take a while each.
const LONG: &str = "form-factors room.obj --patches 700 --rays 4096 --two-sided";

/// Starts a shard, and waits until this many bytes of its part are there.
fn started(folder: &Folder, line: &str, part: &str, bytes: u64) -> Child {
    let mut child = folder
        .command(line)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let length = || fs::metadata(folder.path(part)).map_or(0, |m| m.len());
    while length() < bytes {
        assert!(
            child.try_wait().unwrap().is_none(),
            "it ended before it was interrupted"
        );
        sleep(Duration::from_millis(1));
    }
    child
}

/// Waits until a part has not grown for a while: its last block is written, and the next in work.
fn settled(folder: &Folder, part: &str) {
    let length = || fs::metadata(folder.path(part)).map_or(0, |m| m.len());
    let (mut last, mut quiet) = (length(), 0);
    while quiet < 20 {
        sleep(Duration::from_millis(5));
        let now = length();
        quiet = if now == last { quiet + 1 } else { 0 };
        last = now;
    }
}

fn signal(child: &Child, signal: Signal) {
    kill(Pid::from_raw(child.id().try_into().unwrap()), signal).unwrap();
}

#[test]
fn interrupted_shards_go_on_to_the_same_bytes() {
    let folder = Folder::with_room();
    folder.ok(&format!("{LONG} -o whole.npz"));
    let whole = folder.read("whole.npz");
    folder.ok(&format!("{LONG} --shard 1/2 -o part-1"));
    let line = format!("{LONG} --shard 2/2 -o part-2");

    // The blocks of formulas are there, and perhaps some of rows.
    let mut child = started(&folder, &line, "part-2", 100_000);
    folder.fails("merge part-1 part-2 -o x.npz", 1, "still being computed");
    folder.fails(&line, 1, "is in use");
    signal(&child, Signal::SIGKILL);
    child.wait().unwrap();
    let killed = folder.read("part-2");
    folder.fails("merge part-1 part-2 -o x.npz", 1, "is not complete");

    // SIGTERM waits for the block in work, and keeps it.
    let child = started(&folder, &line, "part-2", killed.len() as u64 + 1);
    let before = folder.read("part-2");
    signal(&child, Signal::SIGTERM);
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains("finishing the block"), "{said}");
    assert!(said.contains("the same command resumes"), "{said}");
    let after = folder.read("part-2");
    assert!(after.starts_with(&before) && after.len() > before.len() + 1000);

    let run = folder.ok(&line);
    assert!(run.err.contains("resuming from part-2"), "{}", run.err);
    folder.ok("merge part-2 part-1 -o merged.npz");
    assert!(folder.read("merged.npz") == whole);
    assert!(!folder.path("x.npz").exists());

    // A shard that is complete is left as it is.
    let complete = folder.read("part-2");
    let run = folder.ok(&line);
    assert!(run.err.contains("complete already"), "{}", run.err);
    assert!(folder.read("part-2") == complete);
}

#[test]
fn shards_without_rows_are_right() {
    let folder = Folder::with_room();
    let line = "form-factors room.obj --patch-size 0 --rays 64";
    folder.ok(&format!("{line} -o whole.npz"));
    compute(&folder, line, "p", 30);
    let run = folder.ok(&format!("{line} --shard 30/30 -o again-30"));
    assert!(run.err.contains("nothing to do"), "{}", run.err);
    folder.ok(&format!("merge {} -o merged.npz", parts("p", 30)));
    assert!(folder.read("merged.npz") == folder.read("whole.npz"));
}

#[test]
fn numbers_of_shards_are_checked() {
    let folder = Folder::with_room();
    for (shard, expected) in [
        ("0/4", "count from 1"),
        ("5/4", "shard 5 of only 4"),
        ("3/0", "0 shards"),
        ("x/y", "expected K/N"),
        ("3", "expected K/N"),
    ] {
        folder.fails(&format!("{QUICK} -o p --shard {shard}"), 2, expected);
    }
    folder.fails(
        &format!("{QUICK} -o - --shard 1/2"),
        2,
        "not standard output",
    );
    folder.fails("form-factors - -o p --shard 1/2", 2, "standard input");
    folder.fails(
        &format!("{QUICK} -o p --shard 1/2 --no-journal"),
        2,
        "cannot be used with",
    );
    assert_eq!(folder.names(), ["room.mtl", "room.obj"]);
}

#[test]
fn outputs_that_are_something_else_are_left_alone() {
    let folder = Folder::with_room();
    let model = folder.read("room.obj");
    let no_part = "is not a part";
    folder.fails(&format!("{QUICK} --shard 1/2 -o room.obj"), 1, no_part);
    compute(&folder, QUICK, "p", 2);
    let part = folder.read("p-1");
    // Another shard, and other work, into the same file.
    folder.fails(
        &format!("{QUICK} --shard 2/2 -o p-1"),
        1,
        "a file of its own",
    );
    folder.fails(
        &format!("{QUICK} --seed 7 --shard 1/2 -o p-1"),
        1,
        "other options",
    );
    folder.fails("merge p-1 p-2 -o p-1", 2, "is a part");
    folder.fails("merge p-1 p-2 -o room.obj --files .", 2, "computed from");
    folder.fails("merge p-1 p-2 -o x.abc", 2, "unknown matrix format");
    assert!(folder.read("p-1") == part && folder.read("room.obj") == model);
    // What merge writes, it writes as the command does: standard output too.
    let run = folder.ok("merge p-1 p-2 -o -");
    assert_eq!(run.out, folder.ok(&format!("{QUICK} -o -")).out);
}

#[test]
fn parts_of_other_work_are_named() {
    let folder = Folder::with_room();
    compute(&folder, QUICK, "p", 2);
    folder.ok(&format!("{QUICK} --seed 7 --shard 2/2 -o seed-2"));
    folder.fails(
        "merge p-1 seed-2 -o x.npz",
        1,
        "seed-2 does not belong to p-1",
    );
    folder.fails("merge p-1 seed-2 -o x.npz", 1, "--seed 7");
    folder.ok(&format!("{QUICK} --closure=never --shard 2/2 -o open-2"));
    folder.fails("merge p-1 open-2 -o x.npz", 1, "other options");
    folder.ok(&format!("{QUICK} --shard 2/3 -o of-3"));
    folder.fails(
        "merge p-1 of-3 -o x.npz",
        1,
        "is one of 3 shards, and not of 2",
    );
    // Another scene under the same name.
    let model = String::from_utf8(folder.read("room.obj")).unwrap();
    folder.write("room.obj", model.replace("v 4 3 4", "v 4 3.5 4"));
    folder.ok(&format!("{QUICK} --shard 2/2 -o scene-2"));
    folder.fails(
        "merge p-1 scene-2 -o x.npz",
        1,
        "another scene: room.obj differ",
    );
    assert!(!folder.path("x.npz").exists());
}

/// The bytes of a part whose header says something else.
fn with_header(part: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let length = u32::from_le_bytes(*part[16..].first_chunk().unwrap()) as usize;
    let text = String::from_utf8(part[24..24 + length].to_vec()).unwrap();
    assert!(text.contains(from));
    let text = text.replace(from, to);
    let mut bytes = part[..20].to_vec();
    bytes.extend(crc32fast::hash(text.as_bytes()).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(&part[24 + length..]);
    bytes
}

#[test]
fn parts_of_other_versions_are_refused() {
    let folder = Folder::with_room();
    compute(&folder, QUICK, "p", 2);
    let part = folder.read("p-2");
    let version = format!("\"version\":\"{}\"", env!("CARGO_PKG_VERSION"));
    let other = version.replace(char::is_numeric, "9");
    folder.write("p-2", with_header(&part, &version, &other));
    folder.fails("merge p-1 p-2 -o x.npz", 1, "was computed by azulejo 9");
    folder.write("p-1", with_header(&folder.read("p-1"), &version, &other));
    folder.fails("merge p-1 p-2 -o x.npz", 1, "of version 9");
    let mut later = part.clone();
    later[13] = b'2';
    folder.write("p-2", later);
    folder.fails("merge p-2 -o x.npz", 1, "another version");
}

#[test]
fn parts_that_are_missing_twice_cut_or_damaged() {
    let folder = Folder::with_room();
    compute(&folder, QUICK, "p", 12);
    folder.ok(&format!("{QUICK} -o whole.npz"));
    folder.fails(
        "merge p-1 p-2 p-4 p-5 p-6 -o x.npz",
        1,
        "shards 3, 7–12 of 12 are missing",
    );
    let but_last = parts("p", 11);
    folder.fails(
        &format!("merge {but_last} -o x.npz"),
        1,
        "shard 12 of 12 is missing",
    );

    let all = parts("p", 12);
    let whole = folder.read("p-5");
    folder.write("copy", &whole);
    let run = folder.ok(&format!("merge copy {all} -o merged.npz"));
    assert!(
        run.err
            .contains("copy and p-5 are both shard 5 of 12, with the same content"),
        "{}",
        run.err
    );
    assert!(folder.read("merged.npz") == folder.read("whole.npz"));

    let line = format!("merge {all} -o x.npz");
    let header = 24 + u32::from_le_bytes(*whole[16..].first_chunk().unwrap()) as usize;
    // Wherever it is cut, it is not taken for whole.
    for (length, expected) in [
        (0, "cut off in its header"),
        (10, "cut off in its header"),
        (20, "cut off in its header"),
        (header - 1, "cut off in its header"),
        (header, "has 0 blocks"),
        (header + 5, "5 bytes that are not a block"),
        (whole.len() - 29, "is not complete"),
        (whole.len() - 28, "is not complete"),
        (whole.len() - 1, "27 bytes that are not a block"),
    ] {
        folder.write("p-5", &whole[..length]);
        folder.fails(&line, 1, expected);
    }
    // Wherever a byte changes, it is noticed.
    for at in (0..whole.len()).step_by(whole.len() / 60 + 1) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x20;
        folder.write("p-5", damaged);
        let run = folder.run(&line);
        assert_eq!(run.code, Some(1), "{at}: {}", run.err);
        assert!(run.err.contains("p-5"), "{at}: {}", run.err);
    }
    folder.write("p-5", [&whole[..], b"x"].concat());
    folder.fails(&line, 1, "follow its end");
    folder.write("p-5", "my diary");
    folder.fails(&line, 1, "p-5 is not a part");
    folder.fails("merge room.obj -o x.npz", 1, "room.obj is not a part");
    folder.fails("merge . -o x.npz", 1, "is a folder");
    folder.fails("merge nothing -o x.npz", 1, "nothing");
    assert!(!folder.path("x.npz").exists());
}

/// Two parts that say that they are the same shard, and differ.
#[test]
fn overlapping_parts_that_differ_are_refused() {
    let folder = Folder::with_room();
    compute(&folder, QUICK, "p", 2);
    let second = folder.read("p-2");
    let as_first = with_header(&second, "\"number\":2", "\"number\":1");
    folder.write("other", as_first);
    folder.fails(
        "merge p-1 other p-2 -o x.npz",
        1,
        "p-1 and other are both shard 1 of 2",
    );
    folder.fails("merge p-1 other p-2 -o x.npz", 1, "their content differs");
}

#[test]
fn models_that_changed_or_moved() {
    let folder = Folder::with_room();
    folder.ok(&format!("{QUICK} -o whole.npz"));
    compute(&folder, QUICK, "p", 2);
    let (model, materials) = (folder.read("room.obj"), folder.read("room.mtl"));
    let merge = "merge p-1 p-2 -o x.npz";

    folder.write("room.obj", [&model[..], b"# later\n"].concat());
    folder.fails(merge, 1, "room.obj has changed");
    folder.write("room.mtl", [&materials[..], b"# later\n"].concat());
    folder.fails(merge, 1, "room.obj, room.mtl have changed");
    folder.write("room.obj", &model);
    folder.fails(merge, 1, "room.mtl has changed");
    fs::remove_file(folder.path("room.mtl")).unwrap();
    folder.fails(merge, 1, "room.mtl is not there");
    fs::remove_file(folder.path("room.obj")).unwrap();
    folder.fails(merge, 1, "--files FOLDER");
    folder.fails(&format!("{merge} --files nowhere"), 1, "is not there");

    // On another machine the files are elsewhere.
    fs::create_dir(folder.path("copies")).unwrap();
    folder.write("copies/room.obj", &model);
    folder.write("copies/room.mtl", &materials);
    folder.ok(&format!("{merge} --files copies"));
    assert!(folder.read("x.npz") == folder.read("whole.npz"));
    assert!(!folder.path("copies/x.npz").exists());
}

/// From another folder, the files are found in that of the parts' command.
#[test]
fn parts_are_merged_from_another_folder() {
    let folder = Folder::with_room();
    folder.ok(&format!("{QUICK} -o whole.npz"));
    compute(&folder, QUICK, "p", 2);
    let other = Folder::new();
    let names = [1, 2].map(|k| folder.path(&format!("p-{k}")).display().to_string());
    other.ok(&format!("merge {} -o merged.npz", names.join(" ")));
    assert!(other.read("merged.npz") == folder.read("whole.npz"));
}

/// A disk without room: an error, and what is there resumes when there is room again.
#[test]
fn a_full_disk_is_an_error() {
    let folder = Folder::with_room();
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    let line = format!("{QUICK} --shard 1/2 -o part");
    // A file that may not grow beyond 20 KiB, which is more than the header and less than the rows.
    let limited = std::process::Command::new("sh")
        .arg("-c")
        .arg(format!(
            "trap '' XFSZ; ulimit -f 40; exec {} {line}",
            env!("CARGO_BIN_EXE_azulejo")
        ))
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&limited.stderr);
    assert_eq!(limited.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write part"), "{said}");
    folder.fails("merge part -o x.npz", 1, "is not complete");
    folder.ok(&line);
    folder.ok(&format!("{QUICK} --shard 2/2 -o part-2"));
    folder.ok("merge part part-2 -o x.npz");
    folder.ok(&format!("{QUICK} -o whole.npz"));
    assert!(folder.read("x.npz") == folder.read("whole.npz"));
}

/// So many points on the floor of the room, as text.
fn floor(points: usize) -> String {
    let line = |i: usize| {
        let [x, z] = [i % 50, i / 50].map(|k| 0.1 + 0.075 * k as f64);
        format!("{x} 0.001 {z} 0 1 0\n")
    };
    (0..points).map(line).collect()
}

const PROBE: &str = "probe room.obj --points p.txt --patches 50 --rays 64";

#[test]
fn irradiance_at_points() {
    let folder = Folder::with_room();
    // Not a multiple of the points that are gathered together.
    folder.write("p.txt", floor(1003));
    check(&folder, PROBE, "npy");
    check(&folder, &format!("{PROBE} --bounces 2"), "txt");
    folder.ok(&format!("{PROBE} --shard 1/1 -o part"));
    let merged = folder.ok("merge part -o -").out;
    assert_eq!(merged, folder.ok(PROBE).out);
    // Other points under the same name.
    compute(&folder, PROBE, "p", 2);
    folder.write("p.txt", floor(1004));
    folder.fails("merge p-1 p-2 -o x.npy", 1, "p.txt has changed");
    folder.ok(&format!("{PROBE} --shard 2/2 -o other-2"));
    folder.fails(
        "merge p-1 other-2 -o x.npy",
        1,
        "other-2 does not belong to p-1",
    );
    folder.fails(
        &format!("{PROBE} --shard 2/2 -o p-2"),
        1,
        "is of other work",
    );
}

#[test]
fn irradiance_at_vertices() {
    let folder = Folder::with_room();
    let line = "solve room.obj --patches 300 --rays 64";
    check(&folder, line, "grf");
    check(&folder, &format!("{line} --keep-mesh --sides split"), "glb");
}

#[test]
fn light_goes_into_the_text_of_a_copy_by_shards() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.grf");
    let line = "solve room.grf --in-place --patches 100 --rays 64";
    check(&folder, line, "grf");
    folder.fails(&format!("{line} --shard 1/2"), 2, "-o PART is missing");
    compute(&folder, line, "p", 2);
    let model = folder.read("room.grf");
    folder.fails("merge p-1 p-2 -o room.grf", 2, "computed from");
    folder.fails(
        &format!("{line} --shard 1/2 -o room.grf"),
        1,
        "is not a part",
    );
    assert!(folder.read("room.grf") == model);
}

#[test]
fn work_to_an_error_or_a_time_is_not_divided() {
    let folder = Folder::with_room();
    folder.write("p.txt", floor(10));
    for command in [
        "probe room.obj --points p.txt",
        "solve room.obj",
        "bake room.obj",
        "bake room.obj --light ao",
    ] {
        for options in ["", "--error 1%", "--error 1% --rays 64"] {
            let line = format!("{command} {options} --shard 1/2 -o part");
            folder.fails(&line, 2, "give --rays N alone");
        }
        let line = format!("{command} --rays 64 --time 10s --shard 1/2 -o part");
        folder.fails(&line, 2, "depends on the machine");
    }
    folder.write("r.f32", [0u8; 32]);
    let line = "probe room.obj --hits r.f32 --rays 64 --shard 1/2 -o part";
    folder.fails(line, 2, "divides --points");
    let line = "bake room.obj --rays 64 --light direct --shard 1/2 -o part";
    folder.fails(line, 2, "no number of rays");
    assert!(!folder.path("part").exists());
}

/// Parts from machines that solved the light between patches otherwise do not fit.
#[test]
fn parts_of_other_light_between_patches_are_refused() {
    let folder = Folder::with_room();
    folder.write("p.txt", floor(200));
    compute(&folder, PROBE, "p", 2);
    let part = folder.read("p-2");
    let header = 24 + u32::from_le_bytes(*part[16..].first_chunk().unwrap()) as usize;
    // The first record is the digest of that light: eight bytes behind a head of 28.
    let mut other = part.clone();
    other[header + 28] ^= 1;
    let digest = crc32fast::hash(&other[header + 28..header + 36]);
    other[header + 20..header + 24].copy_from_slice(&digest.to_le_bytes());
    let head = crc32fast::hash(&other[header..header + 24]);
    other[header + 24..header + 28].copy_from_slice(&head.to_le_bytes());
    folder.write("p-2", &other);
    folder.fails(
        "merge p-1 p-2 -o x.npy",
        1,
        "p-2 was computed on a machine that",
    );
    assert!(!folder.path("x.npy").exists());
    // Nor is it resumed.
    folder.write("p-2", &other[..header + 36]);
    folder.fails(
        &format!("{PROBE} --shard 2/2 -o p-2"),
        1,
        "was begun on a machine that",
    );
}

/// A shard of points that is killed goes on.
#[test]
fn interrupted_points_go_on_to_the_same_bytes() {
    let folder = Folder::with_room();
    // Two blocks, of so many rays that there is time to interrupt the second.
    folder.write("p.txt", floor(700));
    let line = "probe room.obj --points p.txt --patches 50 --rays 12000";
    folder.ok(&format!("{line} -o whole.npy"));
    let shard = format!("{line} --shard 1/1 -o part");
    let mut child = started(&folder, &shard, "part", 30_000);
    settled(&folder, "part");
    signal(&child, Signal::SIGKILL);
    child.wait().unwrap();
    let run = folder.ok(&shard);
    assert!(
        run.err.contains("resuming from part, blocks done: 1"),
        "{}",
        run.err
    );
    folder.ok("merge part -o merged.npy");
    assert!(folder.read("merged.npy") == folder.read("whole.npy"));
}

const BAKE: &str = "bake room.obj --size 32 --patches 100 --rays 64";

#[test]
fn lightmaps() {
    let folder = Folder::with_room();
    let counts = [1, 2, 7];
    check_shards(&folder, BAKE, "glb", &counts);
    let indirect = "--light indirect --bounces 2 --double-sided split";
    check_shards(&folder, &format!("{BAKE} {indirect}"), "html", &[3]);
    check_shards(&folder, &format!("{BAKE} --density auto"), "glb", &[3]);
    check_shards(&folder, &format!("{BAKE} --light ao"), "glb", &counts);
}

/// A glTF file gets its lightmap from parts, and the pictures are named where they are put together.
#[test]
fn pictures_of_lightmaps_are_for_merge() {
    let folder = Folder::with_room();
    folder.ok("convert room.obj -o room.glb");
    let line = "bake room.glb --size 32 --patches 100 --rays 64 --float";
    folder.ok(&format!(
        "{line} -o lit.gltf --lightmap e.exr --error-map se.exr"
    ));
    compute(&folder, line, "p", 2);
    fs::create_dir(folder.path("merged")).unwrap();
    let merge = "merge p-1 p-2";
    folder.ok(&format!(
        "{merge} -o merged/lit.gltf --lightmap merged/e.exr --error-map merged/se.exr"
    ));
    folder.ok(&format!("{merge} --lightmap alone.exr"));
    assert!(folder.read("alone.exr") == folder.read("e.exr"));
    folder.ok(&format!("{line} --bounces 2 -o page.html"));
    compute(&folder, &format!("{line} --bounces 2"), "b", 3);
    folder.ok(&format!("merge {} -o merged/page.html", parts("b", 3)));
    for name in folder.names() {
        let of_merge = folder.path("merged").join(&name);
        if of_merge.exists() {
            assert!(fs::read(of_merge).unwrap() == folder.read(&name), "{name}");
        }
    }
    let merged = fs::read_dir(folder.path("merged")).unwrap().count();
    assert!(merged > 4, "{merged}");

    let shard = format!("{line} --shard 1/2");
    for map in ["--lightmap x.exr", "--error-map x.exr"] {
        folder.fails(&format!("{shard} -o x {map}"), 2, "to azulejo merge");
    }
    folder.fails(&format!("{shard} -o x --strip"), 2, "cannot be used with");
    folder.fails(merge, 2, "--output");
    folder.fails(&format!("{merge} --lightmap p-1"), 2, "p-1 is a part");
    folder.fails(
        &format!("{merge} --lightmap room.glb"),
        2,
        "room.glb is a file that",
    );
    folder.fails(&format!("{merge} -o x.obj"), 2, ".glb, .gltf or .html");
    assert!(!folder.path("x").exists());

    compute(&folder, QUICK, "f", 2);
    folder.fails(
        "merge f-1 f-2 -o f.npz --lightmap x.exr",
        2,
        "parts of bake",
    );
    folder.fails("merge f-1 f-2 --lightmap x.exr", 2, "parts of bake");
}

#[test]
fn parts_of_other_lightmaps_are_refused() {
    let folder = Folder::with_room();
    compute(&folder, BAKE, "p", 2);
    for (options, said) in [
        ("--padding 3", "other options"),
        ("--rays 128", "other options"),
        ("--light ao", "other options"),
    ] {
        let line = format!("{BAKE} {options} --shard 2/2 -o other-2");
        let line = line.replacen("--rays 64 --rays", "--rays", 1);
        folder.ok(&line);
        folder.fails("merge p-1 other-2 -o x.glb", 1, said);
        fs::remove_file(folder.path("other-2")).unwrap();
    }
    folder.fails("merge p-2 -o x.glb", 1, "shard 1 of 2 is missing");
    let whole = folder.read("p-2");
    folder.write("p-2", &whole[..whole.len() / 2]);
    folder.fails("merge p-1 p-2 -o x.glb", 1, "is not complete");
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    folder.write("p-2", damaged);
    folder.fails("merge p-1 p-2 -o x.glb", 1, "is damaged");
    assert!(!folder.path("x.glb").exists());
}

/// A shard of texels that is killed goes on.
#[test]
fn interrupted_texels_go_on_to_the_same_bytes() {
    let folder = Folder::with_room();
    // Several blocks, of so many rays that there is time to interrupt one.
    let line = "bake room.obj --size 32 --patches 50 --rays 16384";
    folder.ok(&format!("{line} -o whole.glb"));
    let shard = format!("{line} --shard 1/1 -o part");
    let mut child = started(&folder, &shard, "part", 30_000);
    signal(&child, Signal::SIGKILL);
    child.wait().unwrap();
    folder.fails("merge part -o x.glb", 1, "is not complete");
    let run = folder.ok(&shard);
    assert!(
        run.err.contains("resuming from part, blocks done: "),
        "{}",
        run.err
    );
    folder.ok("merge part -o merged.glb");
    assert!(folder.read("merged.glb") == folder.read("whole.glb"));
}

/// There is nothing to go on from in the part of a shard that fails at once.
#[test]
fn a_shard_that_fails_leaves_no_part() {
    let folder = Folder::new();
    folder.write("dark.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    for command in ["solve", "bake"] {
        let line = format!("{command} dark.obj --rays 16 --shard 1/2 -o part");
        folder.fails(&line, 1, "nothing in the scene emits light");
        assert_eq!(folder.names(), ["dark.obj"], "{command}");
    }
}
