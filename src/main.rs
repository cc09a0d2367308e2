//! Arguments, call, exit code; nothing else.

#[global_allocator]
static ALLOCATOR: specforge::allocation::Limited = specforge::allocation::Limited;

fn main() -> std::process::ExitCode {
    std::process::ExitCode::from(specforge::cli::main() as u8)
}
