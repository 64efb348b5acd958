//! The `calibstab` program: `cli` is all of it.

fn main() -> std::process::ExitCode {
    calibstab::cli::main()
}
