//! What `-h` shows of commands with many options: those that the examples of the documentation use. `--help` shows all.

use clap::Arg;

/// The common options of `solve`, separated by blanks.
pub const SOLVE: &str = "output in-place keep-mesh sides patches patch-size error rays time engine place up unit \
                         recipe sun sky environment studio";

/// The common options of `bake`.
pub const BAKE: &str = "output strip check size texels-per-metre double-sided light lightmap error-map as image \
                        error rays time engine place recipe sun sky environment studio";

/// The common options of `render`.
pub const RENDER: &str = "output size spp gather reference layers denoise exposure camera from at fov error time engine \
                          place recipe sun sky environment studio look";

/// The common options of `probe`.
pub const PROBE: &str = "points radiance hits normals output year patches error rays time engine place recipe sun sky \
                         weather environment studio";

/// The common options of `form-factors`.
pub const FORM_FACTORS: &str = "output format materials patches patch-size rays two-sided periodic memory closure \
                                engine by cluster truncate compress zone place unit recipe";

/// The common options of `exchange`.
pub const EXCHANGE: &str = "materials boundary output by lump truncate patches rays two-sided memory closure engine \
                            place unit recipe";

/// Leaves all options but the common ones to `--help`.
pub fn showing(common: &'static str) -> impl FnMut(Arg) -> Arg {
    move |arg| {
        let is_common = |long: &str| common.split(' ').any(|name| name == long);
        let is_shown = arg.get_long().is_none_or(is_common);
        arg.hide_short_help(!is_shown)
    }
}

/// The end of `-h`.
pub fn ending(examples: &str) -> String {
    format!("{examples}\n\nThese are the common options; --help shows all.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn common_options_exist() {
        let cli = Cli::command();
        let check = |name: &str, common: &str| {
            let command = cli.find_subcommand(name).unwrap();
            let names: Vec<&str> = command.get_arguments().filter_map(Arg::get_long).collect();
            for option in common.split(' ') {
                assert!(names.contains(&option), "{name} --{option}");
            }
        };
        check("solve", SOLVE);
        check("bake", BAKE);
        check("render", RENDER);
        check("probe", PROBE);
        check("form-factors", FORM_FACTORS);
        check("exchange", EXCHANGE);
    }
}
