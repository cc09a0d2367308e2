//! Arguments, call, exit code; nothing else.

use std::io::Write as _;

#[global_allocator]
static ALLOCATOR: specforge::allocation::Limited = specforge::allocation::Limited;

fn main() -> ! {
    let exit = specforge::cli::main();
    // Output that could not be written was reported when it was printed.
    let _ = std::io::stdout().flush();
    // SAFETY: it only ends the process. `std::process::exit` would also run the exit functions of libraries.
    // That of the allocator gives the memory back to the system piece by piece: 2 ms of a `check`
    // (docs/experiments/2026-11-21-checker-speed.md).
    unsafe { libc::_exit(exit as i32) }
}
