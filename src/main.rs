//! Arguments, call, exit code; nothing else.

fn main() -> std::process::ExitCode {
    std::process::ExitCode::from(specforge::cli::main() as u8)
}
