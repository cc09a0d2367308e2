//! specforge with the learner and the engines; `specforge` calls it for the work that needs them.

#[global_allocator]
static ALLOCATOR: specforge::allocation::Limited = specforge::allocation::Limited;

fn main() -> std::process::ExitCode {
    std::process::ExitCode::from(specforge::cli::main() as u8)
}
