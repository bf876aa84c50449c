//! The program `azulejo`: `azulejo --help` says what it does.

fn main() -> std::process::ExitCode {
    azulejo_cli::main()
}
