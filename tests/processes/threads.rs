//! How many of these tests run at a time. The harness takes that number from the environment alone, before any of them begins.

/// What the loader calls before `main`.
#[used]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn() = two_for_each_processor;

/// Unless somebody has said how many.
extern "C" fn two_for_each_processor() {
    const NUMBER: &str = "RUST_TEST_THREADS";
    if std::env::var_os(NUMBER).is_none()
        && let Ok(processors) = std::thread::available_parallelism()
    {
        // SAFETY: before `main` there is one thread, so nobody reads the environment meanwhile.
        unsafe { std::env::set_var(NUMBER, (2 * processors.get()).to_string()) };
    }
}
