//! The program `sprung`.

fn main() -> std::process::ExitCode {
    sprung_cli::run(std::env::args_os()).into()
}
