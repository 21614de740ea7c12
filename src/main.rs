//! The `gradtess` program; see the library for everything it does.

fn main() -> std::process::ExitCode {
    // glibc returns large blocks to the system one by one and faults them in again, until the first large free tells
    // it otherwise. Refinement is a few megabytes made and dropped: without this, page faults are a third of its time.
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
    gradtess::command::main()
}
