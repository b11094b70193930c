//! Compiles the executor of the simulation, `ssp/executor.c`, into this crate.

use std::path::Path;

fn main() {
    let ssp = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ssp");
    for file in ["executor.c", "executor.h"] {
        println!("cargo:rerun-if-changed={}", ssp.join(file).display());
    }
    cc::Build::new()
        .file(ssp.join("executor.c"))
        .include(ssp.join("../build/runtime/fmi2"))
        .std("c99")
        .opt_level(2)
        .flag("-ffp-contract=off")
        .flags(["-Wall", "-Wextra", "-Wconversion", "-Werror"])
        .compile("flexhex_executor");
    println!("cargo:rustc-link-lib=dl");
}
